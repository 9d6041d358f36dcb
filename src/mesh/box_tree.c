// SPDX-License-Identifier: MIT
/* Building the tree: Morton numbers of the triangles' box centres, a stable radix sort, boxes
 * upwards. Memory while it is built: 32 bytes a triangle; after that 12 for the triangle and 28 for
 * boxes. */
#include "mesh/box_tree.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/predicates.h"

#include <math.h>
#include <string.h>

enum { FACE_BLOCK = 16384, ROW_BLOCK = 4096, AXIS_BITS = 16, DIGIT_BITS = 12, DIGITS = 4 };
static const uint64_t left_out = UINT64_MAX;

typedef struct numbered {
    uint64_t number;   /* on the curve, or left_out */
    uint64_t triangle; /* 2 q + 0 or 1 for quads, then one a triangle */
} numbered;

typedef struct tree_job {
    qni_check *check;
    qni_box_tree *tree;
    numbered *order;
    int level;
    double origin[3], scale;
} tree_job;

/* Two zero bits before each bit. */
static uint64_t spread_bits(uint64_t x) {
    x = (x | x << 32) & 0x001f00000000ffffu;
    x = (x | x << 16) & 0x001f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

static const float *place(const tree_job *job, uint32_t vertex) {
    return job->check->mesh.positions + 3 * (size_t)vertex;
}

/* Of numbers that are none the second. */
static inline float least(float a, float b) {
    return a < b ? a : b;
}

static inline float most(float a, float b) {
    return a > b ? a : b;
}

static uint64_t curve_number(const tree_job *job, const uint32_t v[3]) {
    const float *a = place(job, v[0]), *b = place(job, v[1]), *c = place(job, v[2]);
    if (qni_collinear(a, b, c))
        return left_out;
    uint64_t number = 0;
    for (int i = 0; i < 3; ++i) {
        const float low = least(a[i], least(b[i], c[i])), high = most(a[i], most(b[i], c[i]));
        double cell = (((double)low + (double)high) / 2 - job->origin[i]) * job->scale;
        number |= spread_bits((uint64_t)cell) << i;
    }
    return number;
}

static int64_t first_triangle(const qn_mesh_view *mesh, int64_t face) {
    return face < mesh->quad_count ? 2 * face : face + mesh->quad_count;
}

static void number_faces(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    tree_job *job = pointer;
    const qn_mesh_view *mesh = &job->check->mesh;
    for (int64_t face = begin; face < end; ++face) {
        const uint32_t *indices;
        uint32_t triangles[2][3];
        int corners = qni_face_corners(mesh, face, &indices);
        bool counts = qni_face_is_polygon(indices, corners) &&
                      qni_face_is_finite(job->check, indices, corners);
        int64_t first = first_triangle(mesh, face);
        qni_split_face(job->check, face, triangles);
        for (int i = 0; i < corners - 2; ++i) {
            numbered *n = &job->order[first + i];
            n->number = counts ? curve_number(job, triangles[i]) : left_out;
            n->triangle = (uint64_t)(first + i);
        }
    }
}

/* Stable, so that equal numbers keep the mesh's order. */
static void sort_by_digit(const numbered *from, numbered *to, int64_t count, int shift) {
    const uint64_t mask = (1u << DIGIT_BITS) - 1;
    int64_t starts[1 << DIGIT_BITS] = {0};
    for (int64_t i = 0; i < count; ++i)
        ++starts[(from[i].number >> shift) & mask];
    int64_t total = 0;
    for (int64_t digit = 0; digit <= (int64_t)mask; ++digit) {
        int64_t here = starts[digit];
        starts[digit] = total;
        total += here;
    }
    for (int64_t i = 0; i < count; ++i)
        to[starts[(from[i].number >> shift) & mask]++] = from[i];
}

static qn_status sort_along_curve(tree_job *job, int64_t count, qni_check_span span) {
    qni_check *check = job->check;
    numbered *other = qni_alloc(check->context, count, sizeof *other);
    if (!other)
        return qni_fail_memory(check->error, "a tree of boxes over triangles");
    qn_status status = QN_OK;
    for (int digit = 0; digit < DIGITS && status == QN_OK; ++digit) {
        double done = span.from + (span.to - span.from) * digit / DIGITS;
        const char *stage = check->stage ? check->stage : "check";
        if (qni_progress(check->context, stage, done))
            status = qni_fail(check->error, QN_ERROR_CANCELLED, "cancelled during '%s'", stage);
        sort_by_digit(job->order, other, count, digit * DIGIT_BITS);
        numbered *sorted = other;
        other = job->order;
        job->order = sorted;
    }
    qni_free(check->context, other, count, sizeof *other);
    return status;
}

static void fetch_triangles(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    tree_job *job = pointer;
    const qn_mesh_view *mesh = &job->check->mesh;
    int64_t of_quads = 2 * mesh->quad_count;
    for (int64_t i = begin; i < end; ++i) {
        int64_t triangle = (int64_t)job->order[i].triangle;
        int64_t face = triangle < of_quads ? triangle / 2 : triangle - mesh->quad_count;
        uint32_t triangles[2][3];
        qni_split_face(job->check, face, triangles);
        memcpy(job->tree->triangles[i], triangles[triangle < of_quads ? triangle % 2 : 0],
               sizeof triangles[0]);
    }
}

/* ---- boxes -------------------------------------------------------------------------------------
 */

static void empty_box(qni_box_row *row, int slot) {
    for (int i = 0; i < 3; ++i) {
        row->low[i][slot] = INFINITY;
        row->high[i][slot] = -INFINITY;
    }
}

static void box_triangle(const tree_job *job, qni_box_row *row, int slot, const uint32_t v[3]) {
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) {
            const float x = place(job, v[k])[i];
            row->low[i][slot] = least(x, row->low[i][slot]);
            row->high[i][slot] = most(x, row->high[i][slot]);
        }
}

static void box_row(qni_box_row *row, int slot, const qni_box_row *below) {
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < QNI_BOX_WIDTH; ++k) {
            row->low[i][slot] = least(row->low[i][slot], below->low[i][k]);
            row->high[i][slot] = most(row->high[i][slot], below->high[i][k]);
        }
}

static void fill_rows(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    tree_job *job = pointer;
    const qni_box_tree *tree = job->tree;
    int level = job->level;
    int64_t below = level == 0 ? tree->triangle_count : tree->row_count[level - 1];
    for (int64_t r = begin; r < end; ++r)
        for (int slot = 0; slot < QNI_BOX_WIDTH; ++slot) {
            int64_t child = QNI_BOX_WIDTH * r + slot;
            empty_box(&tree->rows[level][r], slot);
            if (child >= below)
                continue;
            if (level == 0)
                box_triangle(job, &tree->rows[level][r], slot, tree->triangles[child]);
            else
                box_row(&tree->rows[level][r], slot, &tree->rows[level - 1][child]);
        }
}

static qn_status build_levels(tree_job *job, qni_check_span span) {
    qni_box_tree *tree = job->tree;
    int64_t count = tree->triangle_count;
    while (count > 1 || tree->levels == 0) {
        count = qni_block_count(count, QNI_BOX_WIDTH);
        job->level = tree->levels++;
        tree->row_count[job->level] = count;
        tree->rows[job->level] = qni_alloc(job->check->context, count, sizeof(qni_box_row));
        if (!tree->rows[job->level])
            return qni_fail_memory(job->check->error, "a tree of boxes over triangles");
        QN_TRY(qni_check_blocks(job->check, count, ROW_BLOCK, span, fill_rows, job));
        span.from = span.to;
    }
    return QN_OK;
}

static int64_t count_kept(const numbered *order, int64_t count) {
    int64_t kept = 0;
    for (int64_t i = 0; i < count; ++i)
        kept += order[i].number != left_out;
    return kept;
}

static qn_status order_triangles(tree_job *job, int64_t all, qni_check_span span) {
    qni_check *check = job->check;
    qni_box_tree *tree = job->tree;
    double part = (span.to - span.from) / 3;
    const qni_check_span numbers = {span.from, span.from + part};
    const qni_check_span sorts = {numbers.to, numbers.to + part}, fetches = {sorts.to, span.to};
    int64_t faces = check->mesh.quad_count + check->mesh.triangle_count;
    QN_TRY(qni_check_blocks(check, faces, FACE_BLOCK, numbers, number_faces, job));
    QN_TRY(sort_along_curve(job, all, sorts));
    tree->triangle_count = count_kept(job->order, all);
    tree->triangles = qni_alloc(check->context, tree->triangle_count, sizeof *tree->triangles);
    if (!tree->triangles) {
        tree->triangle_count = 0;
        return qni_fail_memory(check->error, "a tree of boxes over triangles");
    }
    return qni_check_blocks(check, tree->triangle_count, FACE_BLOCK, fetches, fetch_triangles, job);
}

static void place_grid(tree_job *job) {
    const double(*bounds)[3] = (const double(*)[3])job->check->report->bounds;
    double side = 0;
    for (int i = 0; i < 3; ++i) {
        job->origin[i] = bounds[0][i];
        side = fmax(side, bounds[1][i] - bounds[0][i]);
    }
    job->scale = side > 0 ? ((1 << AXIS_BITS) - 1) / side : 0;
}

qn_status qni_box_tree_create(qni_check *check, qni_check_span span, qni_box_tree *tree) {
    const qni_box_tree nothing = {0};
    *tree = nothing;
    int64_t all = 2 * check->mesh.quad_count + check->mesh.triangle_count;
    tree_job job = {.check = check, .tree = tree};
    place_grid(&job);
    job.order = qni_alloc(check->context, all, sizeof *job.order);
    if (!job.order)
        return qni_fail_memory(check->error, "a tree of boxes over triangles");
    double middle = span.from + 0.9 * (span.to - span.from);
    const qni_check_span ordering = {span.from, middle}, boxing = {middle, span.to};
    qn_status status = order_triangles(&job, all, ordering);
    qni_free(check->context, job.order, all, sizeof *job.order);
    if (status == QN_OK)
        status = build_levels(&job, boxing);
    if (status != QN_OK)
        qni_box_tree_destroy(check, tree);
    return status;
}

void qni_box_tree_destroy(qni_check *check, qni_box_tree *tree) {
    qni_free(check->context, tree->triangles, tree->triangle_count, sizeof *tree->triangles);
    for (int level = 0; level < tree->levels; ++level)
        qni_free(check->context, tree->rows[level], tree->row_count[level], sizeof(qni_box_row));
}
