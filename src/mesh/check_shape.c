// SPDX-License-Identifier: MIT
/* Area, volume, shape of faces: [DMC21] section 5.3, equations (8) and (9). Sums run over blocks of
 * fixed size and then over the blocks, so that they are the same for every thread count. */
#include "mesh/check.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/mesh.h"
#include "mesh/predicates.h"

#include <math.h>

enum { BLOCK = 16384 };

typedef struct vec {
    double x, y, z;
} vec;

typedef struct shape_block {
    int64_t degenerate, quads, triangles;
    double area, volume, quad_quality, triangle_quality;
    double worst_quad, worst_triangle;
    double largest_cotangent; /* of the smallest angle */
} shape_block;

typedef struct shape_job {
    qni_check *check;
    shape_block *blocks;
    vec centre; /* volumes are taken from here, so that they are small and exact */
} shape_job;

static vec minus(vec a, vec b) {
    vec d = {a.x - b.x, a.y - b.y, a.z - b.z};
    return d;
}

static vec cross(vec a, vec b) {
    vec c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return c;
}

static double dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static double length(vec a) {
    return sqrt(dot(a, a));
}

static const float *place(const qni_check *check, uint32_t vertex) {
    return check->mesh.positions + 3 * (size_t)vertex;
}

static vec point_of(const shape_job *job, uint32_t vertex) {
    const float *p = place(job->check, vertex);
    vec q = {(double)p[0], (double)p[1], (double)p[2]};
    return q;
}

/* Six times the volume of the tetrahedron over a triangle, its tip at the centre of the mesh. */
static double volume_under(vec centre, vec a, vec b, vec c) {
    return dot(minus(a, centre), cross(minus(b, centre), minus(c, centre)));
}

static void measure_triangle(const shape_job *job, const uint32_t v[3], shape_block *result) {
    vec a = point_of(job, v[0]), b = point_of(job, v[1]), c = point_of(job, v[2]);
    vec ab = minus(b, a), bc = minus(c, b), ca = minus(a, c);
    double twice_area = length(cross(ab, bc));
    double squares = dot(ab, ab) + dot(bc, bc) + dot(ca, ca);
    double quality = squares > 0 ? 2 * sqrt(3.0) * twice_area / squares : 0; /* (8) */
    double largest_dot = -fmin(dot(ab, bc), fmin(dot(bc, ca), dot(ca, ab)));
    double cotangent = twice_area > 0 ? largest_dot / twice_area : HUGE_VAL;
    result->triangles += 1;
    result->area += twice_area / 2;
    result->volume += volume_under(job->centre, a, b, c) / 6;
    result->triangle_quality += quality;
    result->worst_triangle = fmin(result->worst_triangle, quality);
    result->largest_cotangent = fmax(result->largest_cotangent, cotangent);
}

/* Equation (9): the least over the corners of the parallelogram of the corner's edges against the
 * square of their lengths. */
static double quad_quality(const shape_job *job, const uint32_t v[4]) {
    vec edges[4];
    for (int i = 0; i < 4; ++i)
        edges[i] = minus(point_of(job, v[(i + 1) % 4]), point_of(job, v[i]));
    double worst = 1;
    for (int i = 0; i < 4; ++i) {
        vec before = edges[(i + 3) % 4], after = edges[i];
        double squares = dot(before, before) + dot(after, after);
        double area = length(cross(before, after));
        worst = fmin(worst, squares > 0 ? 2 * area / squares : 0);
    }
    return worst;
}

static bool has_no_area(const qni_check *check, const uint32_t v[3]) {
    return qni_collinear(place(check, v[0]), place(check, v[1]), place(check, v[2]));
}

static bool repeats_a_vertex(const uint32_t *v, int corners) {
    for (int i = 0; i < corners; ++i)
        for (int j = 0; j < i; ++j)
            if (v[i] == v[j])
                return true;
    return false;
}

static void measure_face(const shape_job *job, int64_t face, shape_block *result) {
    const qni_check *check = job->check;
    const uint32_t *v;
    const int corners = qni_face_corners(&check->mesh, face, &v);
    if (!qni_face_is_polygon(v, corners) || !qni_face_is_finite(check, v, corners)) {
        result->degenerate += repeats_a_vertex(v, corners);
        return;
    }
    uint32_t triangles[2][3];
    int count = qni_split_face(check, face, triangles);
    bool flat = true; /* without area */
    for (int i = 0; i < count; ++i) {
        measure_triangle(job, triangles[i], result);
        flat = flat && has_no_area(check, triangles[i]);
    }
    result->degenerate += flat || repeats_a_vertex(v, corners);
    if (corners == 4) {
        double quality = quad_quality(job, v);
        result->quads += 1;
        result->quad_quality += quality;
        result->worst_quad = fmin(result->worst_quad, quality);
    }
}

static void measure_faces(void *pointer, int64_t block, int64_t begin, int64_t end) {
    shape_job *job = pointer;
    shape_block result = {
        .worst_quad = HUGE_VAL, .worst_triangle = HUGE_VAL, .largest_cotangent = -HUGE_VAL};
    for (int64_t face = begin; face < end; ++face)
        measure_face(job, face, &result);
    job->blocks[block] = result;
}

static void add_up(const shape_block *blocks, int64_t count, qn_mesh_report *report) {
    shape_block total = {
        .worst_quad = HUGE_VAL, .worst_triangle = HUGE_VAL, .largest_cotangent = -HUGE_VAL};
    for (int64_t b = 0; b < count; ++b) {
        total.degenerate += blocks[b].degenerate;
        total.quads += blocks[b].quads;
        total.triangles += blocks[b].triangles;
        total.area += blocks[b].area;
        total.volume += blocks[b].volume;
        total.quad_quality += blocks[b].quad_quality;
        total.triangle_quality += blocks[b].triangle_quality;
        total.worst_quad = fmin(total.worst_quad, blocks[b].worst_quad);
        total.worst_triangle = fmin(total.worst_triangle, blocks[b].worst_triangle);
        total.largest_cotangent = fmax(total.largest_cotangent, blocks[b].largest_cotangent);
    }
    report->degenerate_faces = total.degenerate;
    report->area = total.area;
    report->volume = total.volume;
    if (total.quads) {
        report->quad_quality_mean = total.quad_quality / (double)total.quads;
        report->quad_quality_min = total.worst_quad;
    }
    if (total.triangles) {
        report->triangle_quality_mean = total.triangle_quality / (double)total.triangles;
        report->triangle_quality_min = total.worst_triangle;
        report->smallest_angle = atan2(1, total.largest_cotangent) * (180 / acos(-1.0));
    }
}

qn_status qni_check_shape(qni_check *check, qni_check_span span) {
    int64_t faces = check->mesh.quad_count + check->mesh.triangle_count;
    int64_t count = qni_block_count(faces, BLOCK);
    const double(*bounds)[3] = (const double(*)[3])check->report->bounds;
    vec centre = {(bounds[0][0] + bounds[1][0]) / 2, (bounds[0][1] + bounds[1][1]) / 2,
                  (bounds[0][2] + bounds[1][2]) / 2};
    shape_job job = {check, qni_alloc(check->context, count, sizeof(shape_block)), centre};
    if (!job.blocks)
        return qni_fail_memory(check->error, "a mesh check");
    qn_status status = qni_check_blocks(check, faces, BLOCK, span, measure_faces, &job);
    if (status == QN_OK)
        add_up(job.blocks, count, check->report);
    qni_free(check->context, job.blocks, count, sizeof(shape_block));
    return status;
}
