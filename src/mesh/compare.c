// SPDX-License-Identifier: MIT
/* How far two meshes are apart: the vertices of one, and points that share out its area evenly
 * along the tree's space-filling curve, each with the nearest triangle of the other. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/nearest.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 2048, DEFAULT_SAMPLES = 100000 };

/* What one block of points found; blocks are added up in order. */
typedef struct sums {
    double max_squared, farthest[3];
    double distance, squared;
    double angle, angle_max;
    int64_t points, beyond;
} sums;

typedef struct compare_job {
    const qni_nearest *from, *to;
    int64_t samples, vertex_count;
    const uint8_t *used; /* [vertex_count]: a triangle has the vertex */
    const double *ends;  /* [triangles]: area of the triangles up to and with each */
    sums *blocks;
} compare_job;

/* ---- the measures of one mesh ------------------------------------------------------------------
 */

static void edges_of(const qni_nearest *mesh, int64_t triangle, double ab[3], double ac[3]) {
    const float *a = qni_nearest_corner(mesh, (uint32_t)triangle, 0);
    const float *b = qni_nearest_corner(mesh, (uint32_t)triangle, 1);
    const float *c = qni_nearest_corner(mesh, (uint32_t)triangle, 2);
    for (int i = 0; i < 3; ++i) {
        ab[i] = (double)b[i] - (double)a[i];
        ac[i] = (double)c[i] - (double)a[i];
    }
}

static void cross(const double u[3], const double v[3], double out[3]) {
    out[0] = u[1] * v[2] - u[2] * v[1];
    out[1] = u[2] * v[0] - u[0] * v[2];
    out[2] = u[0] * v[1] - u[1] * v[0];
}

/* Running areas; returns the signed volume about a point. */
static double measure_triangles(const qni_nearest *mesh, const double about[3], double *ends) {
    double area = 0, volume = 0;
    for (int64_t t = 0; t < mesh->tree.triangle_count; ++t) {
        double ab[3], ac[3], normal[3];
        edges_of(mesh, t, ab, ac);
        cross(ab, ac, normal);
        area += sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]) / 2;
        ends[t] = area;
        const float *a = qni_nearest_corner(mesh, (uint32_t)t, 0);
        for (int i = 0; i < 3; ++i)
            volume += ((double)a[i] - about[i]) * normal[i] / 6;
    }
    return volume;
}

static void mark_used(const qni_nearest *mesh, uint8_t *used) {
    for (int64_t t = 0; t < mesh->tree.triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            used[mesh->tree.triangles[t][k]] = 1;
}

/* ---- points ------------------------------------------------------------------------------------
 */

/* The n-th point of a sequence that fills the unit square evenly (Roberts, "The unreasonable
 * effectiveness of quasirandom sequences", 2018), folded into the triangle u + v <= 1. */
static void spread(int64_t n, double *u, double *v) {
    const double x = 0.5 + (double)n * 0.7548776662466927, y = 0.5 + (double)n * 0.5698402909980532;
    *u = x - floor(x);
    *v = y - floor(y);
    if (*u + *v > 1) {
        *u = 1 - *u;
        *v = 1 - *v;
    }
}

/* The first triangle at whose end the running area exceeds `area`. */
static int64_t triangle_at(const double *ends, int64_t count, double area) {
    int64_t low = 0, high = count - 1;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (ends[middle] > area)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static void measure_point(const compare_job *job, const double p[3], uint32_t *hint, sums *s,
                          double *squared) {
    const qni_near near = qni_nearest_find(job->to, p, INFINITY, *hint);
    *hint = near.triangle;
    *squared = near.squared;
    ++s->points;
    if (s->points > 1 && near.squared <= s->max_squared)
        return;
    s->max_squared = near.squared;
    for (int i = 0; i < 3; ++i)
        s->farthest[i] = p[i];
}

static void measure_vertices(void *pointer, int64_t block, int64_t begin, int64_t end) {
    compare_job *job = pointer;
    sums s = {0};
    uint32_t hint = QNI_NO_TRIANGLE;
    for (int64_t v = begin; v < end; ++v) {
        if (!job->used[v])
            continue;
        const float *q = job->from->positions + 3 * v;
        const double p[3] = {(double)q[0], (double)q[1], (double)q[2]};
        double squared;
        measure_point(job, p, &hint, &s, &squared);
    }
    job->blocks[block] = s;
}

static double angle_between(const double u[3], const double v[3]) {
    double w[3];
    cross(u, v, w);
    const double sine = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    return atan2(sine, u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) * (180 / 3.14159265358979323846);
}

static void add_angle(const compare_job *job, uint32_t mine, uint32_t other, sums *s) {
    double u[3], v[3];
    qni_nearest_normal(job->from, mine, u);
    qni_nearest_normal(job->to, other, v);
    const double angle = angle_between(u, v);
    s->angle += angle;
    s->angle_max = fmax(s->angle_max, angle);
    s->beyond += angle > 30;
}

static void measure_samples(void *pointer, int64_t block, int64_t begin, int64_t end) {
    compare_job *job = pointer;
    const int64_t count = job->from->tree.triangle_count;
    sums s = {0};
    uint32_t hint = QNI_NO_TRIANGLE;
    for (int64_t n = begin; n < end; ++n) {
        const double share = ((double)n + 0.5) / (double)job->samples;
        const int64_t t = triangle_at(job->ends, count, share * job->ends[count - 1]);
        const float *a = qni_nearest_corner(job->from, (uint32_t)t, 0);
        double ab[3], ac[3], p[3], u, v, squared;
        edges_of(job->from, t, ab, ac);
        spread(n, &u, &v);
        for (int i = 0; i < 3; ++i)
            p[i] = (double)a[i] + u * ab[i] + v * ac[i];
        measure_point(job, p, &hint, &s, &squared);
        s.distance += sqrt(squared);
        s.squared += squared;
        add_angle(job, (uint32_t)t, hint, &s);
    }
    job->blocks[block] = s;
}

/* ---- one way -----------------------------------------------------------------------------------
 */

static void add_blocks(const sums *blocks, int64_t count, sums *total) {
    for (int64_t b = 0; b < count; ++b) {
        const sums *s = &blocks[b];
        if (s->points > 0 && (total->points == 0 || s->max_squared > total->max_squared)) {
            total->max_squared = s->max_squared;
            for (int i = 0; i < 3; ++i)
                total->farthest[i] = s->farthest[i];
        }
        total->points += s->points;
        total->beyond += s->beyond;
        total->distance += s->distance;
        total->squared += s->squared;
        total->angle += s->angle;
        total->angle_max = fmax(total->angle_max, s->angle_max);
    }
}

static qn_status run_blocks(compare_job *job, qni_check *check, int64_t count, qni_check_span span,
                            qni_block_work *work, sums *total) {
    const int64_t blocks = qni_block_count(count, BLOCK);
    job->blocks = qni_alloc(check->context, blocks, sizeof *job->blocks);
    if (!job->blocks)
        return qni_fail_memory(check->error, "the distances between two meshes");
    const qn_status status = qni_check_blocks(check, count, BLOCK, span, work, job);
    if (status == QN_OK)
        add_blocks(job->blocks, blocks, total);
    qni_free(check->context, job->blocks, blocks, sizeof *job->blocks);
    return status;
}

static void fill_distance(const sums *total, int64_t samples, qn_mesh_distance *out) {
    const double count = (double)samples;
    out->points = total->points;
    out->max = sqrt(total->max_squared);
    out->mean = total->distance / count;
    out->rms = sqrt(total->squared / count);
    out->normal_mean = total->angle / count;
    out->normal_max = total->angle_max;
    out->normal_beyond_30 = (double)total->beyond / count;
    for (int i = 0; i < 3; ++i)
        out->farthest[i] = total->farthest[i];
}

static qn_status measure_one_way(compare_job *job, qni_check *check, qni_check_span span,
                                 qn_mesh_distance *out) {
    sums total = {0};
    const double middle = (span.from + span.to) / 2;
    const qni_check_span first = {span.from, middle}, second = {middle, span.to};
    QN_TRY(run_blocks(job, check, job->vertex_count, first, measure_vertices, &total));
    QN_TRY(run_blocks(job, check, job->samples, second, measure_samples, &total));
    fill_distance(&total, job->samples, out);
    return QN_OK;
}

/* ---- both ways ---------------------------------------------------------------------------------
 */

/* One mesh's side of the comparison. */
typedef struct side {
    qni_nearest nearest;
    int64_t vertex_count, triangle_count;
    uint8_t *used;
    double *ends;
    double volume;
} side;

static void close_side(qn_context *context, side *s) {
    qni_free(context, s->ends, s->triangle_count, sizeof *s->ends);
    qni_free(context, s->used, s->vertex_count, 1);
    qni_nearest_destroy(&s->nearest);
}

static qn_status open_side(qni_check *check, const qn_mesh *mesh, const char *name, side *s) {
    s->vertex_count = qn_mesh_get_view(mesh).vertex_count;
    QN_TRY(qni_nearest_create(check->context, mesh, check->stage, &s->nearest, check->error));
    s->triangle_count = s->nearest.tree.triangle_count;
    if (s->triangle_count == 0)
        return qni_fail(check->error, QN_ERROR_EMPTY,
                        "the %s mesh has no face with an area: there is nothing to compare", name);
    s->used = qni_alloc_zero(check->context, s->vertex_count, 1);
    s->ends = qni_alloc(check->context, s->triangle_count, sizeof *s->ends);
    if (!s->used || !s->ends)
        return qni_fail_memory(check->error, "the distances between two meshes");
    mark_used(&s->nearest, s->used);
    return QN_OK;
}

static void measure_sides(side *a, side *b, qn_mesh_comparison *out) {
    double middle[3], diagonal = 0;
    for (int i = 0; i < 3; ++i) {
        const double length = a->nearest.high[i] - a->nearest.low[i];
        middle[i] = a->nearest.low[i] + length / 2;
        diagonal += length * length;
    }
    out->diagonal = sqrt(diagonal);
    out->volume_a = measure_triangles(&a->nearest, middle, a->ends);
    out->volume_b = measure_triangles(&b->nearest, middle, b->ends);
    out->area_a = a->ends[a->triangle_count - 1];
    out->area_b = b->ends[b->triangle_count - 1];
}

static void join_both(qn_mesh_comparison *out) {
    const qn_mesh_distance *a = &out->a_to_b, *b = &out->b_to_a;
    const double area = out->area_a + out->area_b;
    out->max = fmax(a->max, b->max);
    out->mean = (a->mean * out->area_a + b->mean * out->area_b) / area;
    out->rms = sqrt((a->rms * a->rms * out->area_a + b->rms * b->rms * out->area_b) / area);
}

static qn_status compare_sides(qni_check *check, const side *a, const side *b, int64_t samples,
                               qn_mesh_comparison *out) {
    const qni_check_span first = {0, 0.5}, second = {0.5, 1};
    compare_job there = {&a->nearest, &b->nearest, samples, a->vertex_count,
                         a->used,     a->ends,     NULL};
    compare_job back = {&b->nearest, &a->nearest, samples, b->vertex_count, b->used, b->ends, NULL};
    QN_TRY(measure_one_way(&there, check, first, &out->a_to_b));
    return measure_one_way(&back, check, second, &out->b_to_a);
}

qn_status qn_mesh_compare(qn_context *context, const qn_mesh *a, const qn_mesh *b,
                          const qn_mesh_compare_options *options,
                          qn_mesh_comparison *comparison_out, qn_error *error) {
    memset(comparison_out, 0, sizeof *comparison_out);
    QNI_CHECK_OPTIONS(options, "qn_mesh_compare_options_init", error);
    const int64_t samples = options && options->samples ? options->samples : DEFAULT_SAMPLES;
    if (samples < 1)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "%lld samples: give a number above 0, or 0 for 100,000",
                        (long long)samples);
    qn_mesh_comparison comparison = *comparison_out;
    side side_a = {.nearest.context = context}, side_b = {.nearest.context = context};
    qni_check check = {.context = context, .error = error, .stage = "compare"};
    qn_status status = open_side(&check, a, "first", &side_a);
    if (status == QN_OK)
        status = open_side(&check, b, "second", &side_b);
    if (status == QN_OK) {
        measure_sides(&side_a, &side_b, &comparison);
        status = compare_sides(&check, &side_a, &side_b, samples, &comparison);
    }
    close_side(context, &side_a);
    close_side(context, &side_b);
    QN_TRY(status);
    join_both(&comparison);
    *comparison_out = comparison;
    return QN_OK;
}
