// SPDX-License-Identifier: MIT
/* Scan conversion in two passes, count and fill; what a line ends up with does not depend on the
 * order of its triangles. */
#include "band/lines.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 4096, LINE_BLOCK = 16384, SHORT_LIST = 16 };

typedef struct line_job {
    const qni_nearest *mesh;
    const qni_lattice *lattice;
    qni_lines *lines;
    int64_t *cursors; /* [lines + 1]; in the first pass the counts, one line later */
    bool fills;
    int64_t open_lines, odd_lines;
} line_job;

/* Where a triangle's side passes the plane z = k. */
typedef struct edge_point {
    double x, y;
    int32_t way; /* +1 upward, -1 downward */
} edge_point;

/* A function of the two ends alone, whichever way the edge is gone. */
static edge_point pass_plane(const double a[3], const double b[3], double k) {
    const bool up = a[2] < b[2];
    const double *low = up ? a : b, *high = up ? b : a;
    const double t = (k - low[2]) / (high[2] - low[2]);
    const edge_point point = {low[0] + t * (high[0] - low[0]), low[1] + t * (high[1] - low[1]),
                              up ? 1 : -1};
    return point;
}

static void put(const line_job *job, int64_t line, int32_t index, int32_t way) {
    if (!job->fills) {
        __atomic_fetch_add(&job->cursors[line + 1], 1, __ATOMIC_RELAXED);
        return;
    }
    const int64_t place = __atomic_fetch_add(&job->cursors[line], 1, __ATOMIC_RELAXED);
    job->lines->steps[place] = (qni_line_step){index, way};
}

/* The lines of the plane z = k between two sides of a triangle. */
static void scan_span(const line_job *job, edge_point from, edge_point to, int32_t k) {
    const qni_lines *lines = job->lines;
    const int64_t row = (k - lines->low[1]) * lines->size[0] - lines->low[0];
    const double slope = (to.x - from.x) / (to.y - from.y);
    const double least = fmin(from.x, to.x), most = fmax(from.x, to.x);
    for (int32_t j = (int32_t)ceil(from.y); (double)j < to.y; ++j) {
        const double x = from.x + ((double)j - from.y) * slope;
        put(job, row + j, (int32_t)ceil(fmin(fmax(x, least), most)), to.way);
    }
}

static void scan_triangle(const line_job *job, const double v[3][3]) {
    const double low = fmin(v[0][2], fmin(v[1][2], v[2][2]));
    const double high = fmax(v[0][2], fmax(v[1][2], v[2][2]));
    for (int32_t k = (int32_t)ceil(low); (double)k < high; ++k) {
        edge_point points[3];
        int count = 0;
        for (int e = 0; e < 3; ++e) {
            const double *a = v[e], *b = v[e == 2 ? 0 : e + 1];
            if ((a[2] <= (double)k) != (b[2] <= (double)k))
                points[count++] = pass_plane(a, b, (double)k);
        }
        if (count == 2 && points[0].y < points[1].y)
            scan_span(job, points[0], points[1], k);
        else if (count == 2 && points[0].y > points[1].y)
            scan_span(job, points[1], points[0], k);
    }
}

static void scan_block(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    const line_job *job = pointer;
    const qni_lattice *lattice = job->lattice;
    for (int64_t t = begin; t < end; ++t) {
        double v[3][3];
        for (int k = 0; k < 3; ++k) {
            const float *p = qni_nearest_corner(job->mesh, (uint32_t)t, k);
            for (int i = 0; i < 3; ++i)
                v[k][i] = ((double)p[i] - lattice->origin[i]) / lattice->voxel;
        }
        scan_triangle(job, (const double(*)[3])v);
    }
}

/* ---- lines in order ----------------------------------------------------------------------------
 */

static void sift_down(qni_line_step *steps, int64_t root, int64_t count) {
    const qni_line_step moved = steps[root];
    for (int64_t child; (child = 2 * root + 1) < count; root = child) {
        child += child + 1 < count && steps[child + 1].index > steps[child].index;
        if (steps[child].index <= moved.index)
            break;
        steps[root] = steps[child];
    }
    steps[root] = moved;
}

static void sort_steps(qni_line_step *steps, int64_t count) {
    for (int64_t n = 1; count <= SHORT_LIST && n < count; ++n) {
        const qni_line_step moved = steps[n];
        int64_t at = n;
        for (; at > 0 && steps[at - 1].index > moved.index; --at)
            steps[at] = steps[at - 1];
        steps[at] = moved;
    }
    if (count <= SHORT_LIST)
        return;
    for (int64_t root = count / 2; root-- > 0;)
        sift_down(steps, root, count);
    for (int64_t last = count - 1; last > 0; --last) {
        const qni_line_step top = steps[0];
        steps[0] = steps[last];
        steps[last] = top;
        sift_down(steps, 0, last);
    }
}

/* Changes become winding numbers, one step an index; places left over go behind all samples. */
static int32_t sum_up(qni_line_step *steps, int64_t count) {
    int32_t winding = 0;
    int64_t kept = 0;
    for (int64_t n = 0; n < count; ++n) {
        winding += steps[n].winding;
        if (n + 1 == count || steps[n + 1].index != steps[n].index)
            steps[kept++] = (qni_line_step){steps[n].index, winding};
    }
    for (; kept < count; ++kept)
        steps[kept] = (qni_line_step){INT32_MAX, winding};
    return winding;
}

static void order_block(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    line_job *job = pointer;
    qni_lines *lines = job->lines;
    int64_t open_lines = 0, odd_lines = 0;
    for (int64_t line = begin; line < end; ++line) {
        qni_line_step *steps = lines->steps + lines->starts[line];
        const int64_t count = lines->starts[line + 1] - lines->starts[line];
        sort_steps(steps, count);
        const int32_t last = sum_up(steps, count);
        open_lines += last != 0;
        odd_lines += last & 1;
    }
    __atomic_fetch_add(&job->open_lines, open_lines, __ATOMIC_RELAXED);
    __atomic_fetch_add(&job->odd_lines, odd_lines, __ATOMIC_RELAXED);
}

/* ---- making them -------------------------------------------------------------------------------
 */

static int64_t line_count(const qni_lines *lines) {
    return lines->size[0] * lines->size[1];
}

static qn_status fill_lines(line_job *job, qni_check *work) {
    qni_lines *lines = job->lines;
    const int64_t triangles = job->mesh->tree.triangle_count, count = line_count(lines);
    const qni_check_span first = {0, 0.4}, second = {0.4, 0.8}, third = {0.8, 1};
    QN_TRY(qni_check_blocks(work, triangles, BLOCK, first, scan_block, job));
    for (int64_t line = 0; line < count; ++line)
        job->cursors[line + 1] += job->cursors[line];
    memcpy(lines->starts, job->cursors, (size_t)(count + 1) * sizeof *lines->starts);
    lines->step_count = lines->starts[count];
    lines->steps = qni_alloc(lines->context, lines->step_count, sizeof *lines->steps);
    if (!lines->steps)
        return qni_fail_memory(work->error, "the lattice lines of a mesh");
    job->fills = true;
    QN_TRY(qni_check_blocks(work, triangles, BLOCK, second, scan_block, job));
    QN_TRY(qni_check_blocks(work, count, LINE_BLOCK, third, order_block, job));
    lines->open_lines = job->open_lines;
    lines->odd_lines = job->odd_lines;
    return QN_OK;
}

static qn_status place_lines(qni_check *work, const qni_nearest *mesh, const qni_lattice *lattice,
                             qni_lines *lines) {
    for (int i = 0; i < 2; ++i) {
        const double low = (mesh->low[i + 1] - lattice->origin[i + 1]) / lattice->voxel;
        const double high = (mesh->high[i + 1] - lattice->origin[i + 1]) / lattice->voxel;
        lines->low[i] = (int32_t)floor(low);
        lines->size[i] = (int64_t)ceil(high) - lines->low[i] + 1;
    }
    if (lines->size[0] > INT32_MAX / lines->size[1])
        return qni_fail(work->error, QN_ERROR_INVALID_ARGUMENT,
                        "%lld x %lld lattice lines are too many: take larger voxels",
                        (long long)lines->size[0], (long long)lines->size[1]);
    return QN_OK;
}

qn_status qni_lines_create(qni_check *work, const qni_nearest *mesh, const qni_lattice *lattice,
                           qni_lines *lines_out) {
    const qni_lines nothing = {.context = work->context};
    *lines_out = nothing;
    QN_TRY(place_lines(work, mesh, lattice, lines_out));
    const int64_t count = line_count(lines_out);
    line_job job = {.mesh = mesh, .lattice = lattice, .lines = lines_out};
    job.cursors = qni_alloc_zero(work->context, count + 1, sizeof *job.cursors);
    lines_out->starts = qni_alloc(work->context, count + 1, sizeof *lines_out->starts);
    qn_status status = job.cursors && lines_out->starts
                           ? fill_lines(&job, work)
                           : qni_fail_memory(work->error, "the lattice lines of a mesh");
    qni_free(work->context, job.cursors, count + 1, sizeof *job.cursors);
    if (status != QN_OK)
        qni_lines_destroy(lines_out);
    return status;
}

void qni_lines_destroy(qni_lines *lines) {
    qni_free(lines->context, lines->steps, lines->step_count, sizeof *lines->steps);
    qni_free(lines->context, lines->starts, line_count(lines) + 1, sizeof *lines->starts);
    lines->steps = NULL;
    lines->starts = NULL;
}

/* ---- asking them -------------------------------------------------------------------------------
 */

/* The steps of the line through p; false when there is none. */
static bool find_line(const qni_lines *lines, const int32_t p[3], const qni_line_step **steps,
                      int64_t *count) {
    const int64_t y = (int64_t)p[1] - lines->low[0], z = (int64_t)p[2] - lines->low[1];
    if (y < 0 || y >= lines->size[0] || z < 0 || z >= lines->size[1])
        return false;
    const int64_t *start = lines->starts + z * lines->size[0] + y;
    *steps = lines->steps + start[0];
    *count = start[1] - start[0];
    return *count > 0;
}

/* How many of the steps come at or before x. */
static int64_t steps_until(const qni_line_step *steps, int64_t count, int32_t x) {
    int64_t low = 0;
    while (low < count) {
        const int64_t middle = low + (count - low) / 2;
        if (steps[middle].index <= x)
            low = middle + 1;
        else
            count = middle;
    }
    return low;
}

int32_t qni_lines_winding(const qni_lines *lines, const int32_t p[3]) {
    const qni_line_step *steps;
    int64_t count;
    if (!find_line(lines, p, &steps, &count))
        return 0;
    const int64_t passed = steps_until(steps, count, p[0]);
    return passed > 0 ? steps[passed - 1].winding : 0;
}

void qni_lines_windings(const qni_lines *lines, const int32_t p[3], int32_t windings[8]) {
    const qni_line_step *steps;
    int64_t count;
    memset(windings, 0, 8 * sizeof *windings);
    if (!find_line(lines, p, &steps, &count))
        return;
    int64_t passed = steps_until(steps, count, p[0]);
    for (int32_t x = 0; x < 8; ++x) {
        while (passed < count && steps[passed].index <= p[0] + x)
            ++passed;
        windings[x] = passed > 0 ? steps[passed - 1].winding : 0;
    }
}
