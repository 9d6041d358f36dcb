// SPDX-License-Identifier: MIT
/* Splitting the quads at doubled edges: where the new vertices lie, which quads they make. All of
 * it is arithmetic on the cells at hand; every point and every quad is written by itself. */
#include "dmc/repair_parts.h"
#include "dmc/repair_hd.h"
#include "dmc/stencil.h"
#include "core/context.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

/* ---- vertices -------------------------------------------------------------------------------- */

void qni_repair_place_from(const qni_repair_job *job, const int64_t cell[3],
                           const double stencil[QNI_STENCIL], const double local[3],
                           int64_t vertex) {
    const double at[3] = {(double)cell[0], (double)cell[1], (double)cell[2]};
    float position[3], normal[3];
    qni_place_point(stencil, at, local, job->frame, position, normal);
    qni_store_vertex(job->mesh, vertex, position, normal, stencil, local, job->frame);
}

void qni_repair_place(const qni_repair_job *job, const int64_t cell[3], const double local[3],
                      int64_t vertex) {
    double stencil[QNI_STENCIL];
    qni_load_stencil(&job->dmc->field, cell, stencil);
    qni_repair_place_from(job, cell, stencil, local, vertex);
}

void qni_repair_load_corners(const qni_field *field, const int64_t cell[3], double d[8]) {
    qni_field_load_cell(field, cell, d);
}

/* What is to be split lies scattered in the volume and the mesh: it is asked for some items ahead,
 * its samples first, then its quad. */
enum { AHEAD_FAR = 12, AHEAD_NEAR = 4 };

static void expect_face(const qni_repair_job *job, int64_t index) {
    if (index >= job->dmc->repair->face_count)
        return;
    const qni_doubled_face *face = job->dmc->repair->faces + index;
    const int64_t cell[3] = {face->cell[0], face->cell[1], face->cell[2]};
    qni_field_prefetch_rows(&job->dmc->field, cell, -1, 2);
}

static void expect_quad(const qni_repair_job *job, int64_t index) {
    if (index >= job->dmc->repair->split_count)
        return;
    const qni_quad_split *split = job->dmc->repair->splits + index;
    const int64_t cell[3] = {split->point[0], split->point[1], split->point[2]};
    __builtin_prefetch(job->mesh->quads + 4 * (size_t)split->quad);
    qni_field_prefetch_rows(&job->dmc->field, cell, 0, 1);
}

static void expect_split(const qni_repair_job *job, int64_t index) {
    if (index >= job->dmc->repair->split_count)
        return;
    const qni_quad_split *split = job->dmc->repair->splits + index;
    const int64_t cell[3] = {split->point[0], split->point[1], split->point[2]};
    qni_field_prefetch_rows(&job->dmc->field, cell, -1, 2);
    for (int k = 0; k < 4; ++k)
        __builtin_prefetch(job->mesh->positions + 3 * (size_t)split->corners[k]);
}

/* The four points of a doubled face: two for each segment, first the one above the face. Returns
 * how many stay on it. */
static int place_face_points(const qni_repair_job *job, int64_t index) {
    const qni_doubled_face *face = job->dmc->repair->faces + index;
    const int axis = face->axis;
    double d[2][8], stencil[2][QNI_STENCIL];
    int64_t cell[2][3];
    int left = 0;
    for (int side = 0; side < 2; ++side) {
        for (int a = 0; a < 3; ++a)
            cell[side][a] = face->cell[a] - (side && a == axis);
        qni_load_stencil(&job->dmc->field, cell[side], stencil[side]);
        qni_stencil_corners(stencil[side], d[side]);
    }
    for (int segment = 0; segment < 2; ++segment) {
        double uw[2], length;
        qni_segment_middle(axis, face->first_cut, segment, d[0], uw, &length);
        for (int side = 0; side < 2; ++side) {
            double local[3];
            left +=
                !qni_point_in_cell(d[side], axis, side, uw, length * QNI_REPAIR_NEARNESS, local);
            qni_repair_place_from(job, cell[side], stencil[side], local,
                                  job->dmc->vertex_count + 4 * index + 2 * segment + side);
        }
    }
    return left;
}

/* ---- quads ----------------------------------------------------------------------------------- */

/* The boundary of a quad with the points on its sides, from its first corner on (repair_parts.h).
 */
static int boundary_of(const qni_dmc *dmc, const qni_quad_split *split,
                       uint32_t boundary[QNI_LARGEST_BOUNDARY]) {
    int count = 0;
    for (int k = 0; k < 4; ++k) {
        const int ring_side = qni_split_ring_side(split, k);
        if (qni_split_cuts(split, k)) {
            boundary[count++] = qni_cut_corner_vertex(dmc, split, k);
            boundary[count++] = qni_cut_side_vertex(dmc, split, k, true);
        } else {
            boundary[count++] = split->corners[k];
        }
        if (qni_split_doubles(split, k)) {
            /* Sides 0 and 1 of a ring climb, 2 and 3 come down. */
            const bool climbs = (ring_side < 2) == (split->forward != 0);
            const uint32_t above = (uint32_t)(dmc->vertex_count + split->points[ring_side]);
            boundary[count++] = climbs ? above + 1 : above;
            boundary[count++] = climbs ? above : above + 1;
        }
        if (qni_split_cuts(split, k + 1))
            boundary[count++] = qni_cut_side_vertex(dmc, split, k + 1, false);
    }
    return count;
}

/* Remember a quad as emitted: splits overwrite it, and tunnels need to know its corners. */
static void note_quad(const qni_repair_job *job, qni_quad_split *split) {
    const int32_t *at = split->point;
    split->forward = (qni_field_value(&job->dmc->field, at[0], at[1], at[2]) >= 0) != job->reverse;
    memcpy(split->corners, job->mesh->quads + 4 * (size_t)split->quad, sizeof split->corners);
}

/* The centre is where the lattice edge meets the surface: a point of all four cells and of the
 * right branch in each. */
static void split_quad(const qni_repair_job *job, int64_t index) {
    const qni_dmc *dmc = job->dmc;
    qni_quad_split *split = dmc->repair->splits + index;
    const int64_t cell[3] = {split->point[0], split->point[1], split->point[2]};
    const uint32_t centre = qni_centre_vertex(dmc, index);
    double local[3] = {0, 0, 0}, d[8], stencil[QNI_STENCIL];
    qni_load_stencil(&dmc->field, cell, stencil);
    qni_stencil_corners(stencil, d);
    local[split->axis] = d[0] / (d[0] - d[1 << split->axis]);
    qni_repair_place_from(job, cell, stencil, local, centre);
    uint32_t boundary[QNI_LARGEST_BOUNDARY];
    const int count = boundary_of(dmc, split, boundary);
    split->turn = (uint8_t)qni_better_turn(job->mesh->positions, boundary, count, centre);
    for (int j = 0; j < count / 2; ++j)
        qni_fan_quad(boundary, count, centre, split->turn, j,
                     job->mesh->quads + 4 * qni_fan_place(dmc, split, j));
}

void qni_repair_apply(qni_dmc *dmc, const qni_frame *frame, bool reverse, qn_mesh *mesh) {
    const qni_repair_job job = {dmc, frame, mesh, reverse};
    const qni_repair *repair = dmc->repair;
    const int32_t threads = qn_context_threads(dmc->context);
    int64_t left = 0;
    (void)threads;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t n = 0; n < repair->split_count; ++n) {
        expect_quad(&job, n + AHEAD_FAR);
        note_quad(&job, repair->splits + n);
    }
#pragma omp parallel for schedule(static) reduction(+ : left) num_threads(threads)
    for (int64_t n = 0; n < repair->face_count; ++n) {
        expect_face(&job, n + AHEAD_NEAR);
        left += place_face_points(&job, n);
    }
#pragma omp parallel for schedule(static) reduction(+ : left) num_threads(threads)
    for (int64_t n = 0; n < 2 * repair->tunnel_count; ++n)
        left += qni_tunnel_place_end(&job, n);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t n = 0; n < repair->split_count; ++n) {
        expect_split(&job, n + AHEAD_NEAR);
        split_quad(&job, n);
    }
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t n = 0; n < repair->tunnel_count; ++n)
        qni_tunnel_close(&job, n);
    dmc->repair->fallback_points = left;
}
