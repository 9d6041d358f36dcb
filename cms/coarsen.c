// SPDX-License-Identifier: MIT
/* When a cell may be a leaf: its own surface, one disc, or a few that are flat and apart, explains
 * all fine samples in it.
 *
 * Its own segments make one loop, or a few without an apex; each crossing of a finest edge in the
 * closed cell lies within the tolerance of the cell's triangles, of which one there faces its way,
 * so that a second sheet (one faces back), a wall or a tunnel is never overlooked where the finest
 * lattice sees it; apex and face features lie on the surface. */
#include "cms/cms.h"
#include "cms/vector.h"
#include "core/cube_hd.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- samples ------------------------------------------------------------------------------------
 */

typedef bool sample_visit(void *job, const qni_hermite_crossing *crossing);

/* The block's finest edges along an axis, in one layer of z, whose lower ends lie in a range of x
 * and y. */
static uint64_t range_mask(const int from[3], const int to[3]) {
    if (from[0] > to[0] || from[1] > to[1])
        return 0;
    const uint64_t row = ((UINT64_C(2) << to[0]) - (UINT64_C(1) << from[0])) & 0xff;
    const uint64_t upto = to[1] == 7 ? UINT64_MAX : (UINT64_C(1) << 8 * (to[1] + 1)) - 1;
    return row * UINT64_C(0x0101010101010101) & upto & UINT64_MAX << 8 * from[1];
}

static bool visit_layer(const qni_hermite_block *block, int word, uint64_t mask,
                        sample_visit *visit, void *job) {
    const uint64_t all = block->crossed[word];
    for (uint64_t bits = all & mask; bits; bits &= bits - 1) {
        const int rank = block->rank[word] + qni_count_bits(all & ((bits & -bits) - 1));
        for (int n = block->starts[rank]; n < block->starts[rank + 1]; ++n)
            if (!visit(job, &block->crossings[n]))
                return false;
    }
    return true;
}

static bool visit_block(const qni_hermite_block *block, const qni_cell_box *box,
                        sample_visit *visit, void *job) {
    for (int axis = 0; axis < 3; ++axis) {
        int from[3], to[3];
        for (int k = 0; k < 3; ++k) {
            const int32_t low = box->low[k] - 8 * block->place[k],
                          high = low + box->size[k] - (k == axis);
            from[k] = low < 0 ? 0 : low;
            to[k] = high > 7 ? 7 : high;
        }
        const uint64_t mask = range_mask(from, to);
        for (int z = from[2]; mask && z <= to[2]; ++z)
            if (!visit_layer(block, 8 * axis + z, mask, visit, job))
                return false;
    }
    return true;
}

/* All crossings in a closed box of finest cells; false when the visitor says so. */
static bool visit_box(const qni_hermite *hermite, const qni_cell_box *box, sample_visit *visit,
                      void *job) {
    int32_t first[3], last[3];
    for (int k = 0; k < 3; ++k) {
        first[k] = box->low[k] >> 3;
        last[k] = (box->low[k] + box->size[k]) >> 3;
    }
    for (int32_t z = first[2]; z <= last[2]; ++z)
        for (int32_t y = first[1]; y <= last[1]; ++y)
            for (int32_t x = first[0]; x <= last[0]; ++x) {
                const int64_t index = qni_hermite_find(hermite, x, y, z);
                if (index >= 0 && !visit_block(&hermite->blocks[index], box, visit, job))
                    return false;
            }
    return true;
}

static bool visit_samples(const qni_hermite *hermite, const qni_cell *cell, sample_visit *visit,
                          void *job) {
    const int32_t size = 1 << cell->level;
    const qni_cell_box box = {
        {cell->low[0], cell->low[1], cell->low[2]}, {size, size, size}, false};
    return visit_box(hermite, &box, visit, job);
}

/* ---- geometry
 * ------------------------------------------------------------------------------------ */

typedef struct distance_job {
    const qni_patch *patch;
    double (*normals)[3];
    double tolerance, facing;
    int64_t last; /* the triangle that was near the sample before */
} distance_job;

static void difference(const float *a, const double b[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = (double)a[k] - b[k];
}

static double segment_distance2(const double a[3], const double b[3]) { /* from the origin */
    double way[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const double length2 = qni_dot3(way, way);
    double t = length2 > 0 ? -qni_dot3(a, way) / length2 : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    double p[3] = {a[0] + t * way[0], a[1] + t * way[1], a[2] + t * way[2]};
    return qni_dot3(p, p);
}

/* Squared distance of a point from a triangle of the patch, whose unit normal is given. */
static double triangle_distance2(const qni_patch *patch, const int32_t triangle[3],
                                 const double normal[3], const double point[3]) {
    double v[3][3];
    bool over = true;
    for (int k = 0; k < 3; ++k)
        difference(qni_patch_place(patch, triangle[k]), point, v[k]);
    for (int k = 0; k < 3; ++k) {
        double side[3], turned[3];
        for (int m = 0; m < 3; ++m)
            side[m] = v[(k + 1) % 3][m] - v[k][m];
        qni_cross3(normal, side, turned);
        over = over && qni_dot3(turned, v[k]) <= 0;
    }
    if (over) {
        const double height = qni_dot3(normal, v[0]);
        return height * height;
    }
    double least = segment_distance2(v[0], v[1]);
    for (int k = 1; k < 3; ++k) {
        const double other = segment_distance2(v[k], v[(k + 1) % 3]);
        least = other < least ? other : least;
    }
    return least;
}

static bool holds_sample(const distance_job *job, int64_t t, const double position[3],
                         const double normal[3]) {
    return qni_dot3(job->normals[t], normal) >= job->facing &&
           triangle_distance2(job->patch, job->patch->triangles[t], job->normals[t], position) <=
               job->tolerance * job->tolerance;
}

static bool sample_is_near(void *user, const qni_hermite_crossing *crossing) {
    distance_job *job = user;
    double position[3];
    qni_crossing_position(crossing, position);
    if (job->last < job->patch->triangle_count &&
        holds_sample(job, job->last, position, crossing->normal))
        return true;
    for (int64_t t = 0; t < job->patch->triangle_count; ++t)
        if (t != job->last && holds_sample(job, t, position, crossing->normal)) {
            job->last = t;
            return true;
        }
    return false;
}

void qni_patch_unit_normal(const qni_patch *patch, const int32_t triangle[3], double normal[3]) {
    const float *origin = qni_patch_place(patch, triangle[0]);
    const double from[3] = {(double)origin[0], (double)origin[1], (double)origin[2]};
    double a[3], b[3];
    difference(qni_patch_place(patch, triangle[1]), from, a);
    difference(qni_patch_place(patch, triangle[2]), from, b);
    qni_cross3(a, b, normal);
    const double length = sqrt(qni_dot3(normal, normal));
    for (int k = 0; k < 3; ++k)
        normal[k] = length > 0 ? normal[k] / length : 0;
}

static bool is_on_surface(const qni_patch *patch, const float place[3], double tolerance) {
    const double point[3] = {(double)place[0], (double)place[1], (double)place[2]};
    return qni_is_on_surface(patch->solid, point, tolerance);
}

static bool bends_are_on_surface(const qni_patch *patch, double tolerance) {
    for (int64_t n = 0; n < patch->vertex_count; ++n)
        if (!patch->vertices[n].crossing &&
            !is_on_surface(patch, patch->vertices[n].place, tolerance))
            return false;
    return !patch->loops[0].has_apex || is_on_surface(patch, patch->loops[0].apex, tolerance);
}

enum { MOST_TRIANGLES = 64 };

/* The triangles' normals; false when there are too many. */
static bool measure_normals(const qni_patch *patch, double (*normals)[3]) {
    if (patch->triangle_count > MOST_TRIANGLES)
        return false;
    for (int64_t t = 0; t < patch->triangle_count; ++t)
        qni_patch_unit_normal(patch, patch->triangles[t], normals[t]);
    return true;
}

static bool explains(const qni_patch *patch, double (*normals)[3], const qni_cell_box *box) {
    distance_job job = {patch, normals, patch->settings->tolerance, patch->settings->facing_cosine,
                        0};
    return visit_box(patch->hermite, box, sample_is_near, &job);
}

bool qni_box_is_explained(const qni_patch *patch, const qni_cell_box *box) {
    double normals[MOST_TRIANGLES][3];
    return measure_normals(patch, normals) && explains(patch, normals, box);
}

bool qni_creases_hold(const qni_patch *patch, double least) {
    double normals[MOST_TRIANGLES][3];
    return measure_normals(patch, normals) &&
           qni_folds_hold(patch, (const double(*)[3])normals, least);
}

/* Samples are looked at first: that asks the solid nothing. */
static bool holds(const qni_patch *patch, bool of_leaf) {
    const qni_cell *cell = &patch->cell;
    const int32_t size = 1 << cell->level;
    const qni_cell_box box = {
        {cell->low[0], cell->low[1], cell->low[2]}, {size, size, size}, false};
    double normals[MOST_TRIANGLES][3];
    return measure_normals(patch, normals) && explains(patch, normals, &box) &&
           (of_leaf || bends_are_on_surface(patch, patch->settings->tolerance)) &&
           qni_folds_hold(patch, (const double(*)[3])normals, patch->settings->tolerance);
}

bool qni_cell_is_explained_by(const qni_patch *patch) {
    return holds(patch, true);
}

/* The two sides of an edge of the solid, when that passes by just outside; a corner has three. */
enum { MOST_LOOPS = 3 };

/* The cell's own loops, as if its neighbours were leaves of its size. */
static bool make_loops(qni_patch *patch, qni_face_store *store, const qni_cell *cell) {
    qni_face_feature features[QNI_FACES * QNI_KEPT_FEATURES];
    patch->octree = NULL;
    qni_patch_set_cell(patch, cell);
    for (int face = 0; face < QNI_FACES; ++face) {
        const qni_kept_face *kept = qni_face_store_solve(store, patch, face);
        if (!kept->simple)
            return false;
        const bool out = qni_face_points_out(face);
        const int first = QNI_KEPT_FEATURES * face;
        memcpy(features + first, kept->features, sizeof *features * (size_t)kept->feature_count);
        for (int n = 0; n < kept->count; ++n)
            if (!qni_patch_add_piece(patch, &kept->segments[n], out, (uint32_t)first))
                return false;
    }
    return qni_patch_trace(patch, features) && patch->loop_count > 0 &&
           patch->loop_count <= MOST_LOOPS;
}

/* Discs of several loops must have nothing to do with each other. */
static bool loops_are_well(qni_patch *patch) {
    qni_cms_tally tally;
    memset(&tally, 0, sizeof tally);
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        const qni_loop *loop = &patch->loops[n];
        if (loop->has_apex && (patch->loop_count > 1 || loop->escaped ||
                               (loop->clusters == 2 && loop->sharp_count != 2)))
            return false;
    }
    return patch->loop_count == 1 ||
           (qni_patch_separate(patch, &tally) == QN_OK && tally.tubes == 0 &&
            tally.moved_loops == 0 && tally.unresolved_cells == 0);
}

static bool is_explained(qni_patch *patch, qni_face_store *store, const qni_cell *cell) {
    qni_cms_tally unused;
    memset(&unused, 0, sizeof unused);
    if (!make_loops(patch, store, cell) || qni_patch_place_apexes(patch, &unused) != QN_OK)
        return false;
    if (qni_patch_triangulate(patch, &unused) != QN_OK)
        return false;
    return loops_are_well(patch) && holds(patch, false);
}

static bool straddles(const qni_hermite *hermite, const qni_cell *cell) {
    const qni_lattice *lattice = &hermite->lattice;
    for (int k = 0; k < 3; ++k)
        if (qni_lattice_at(lattice, k, cell->low[k]) < lattice->bounds.low[k] ||
            qni_lattice_at(lattice, k, cell->low[k] + (1 << cell->level)) > lattice->bounds.high[k])
            return true;
    return false;
}

static bool is_unwanted(void *job, const qni_hermite_crossing *crossing) {
    (void)job, (void)crossing;
    return false;
}

int qni_compare_vetoes(const void *a, const void *b) {
    const qni_cell *p = a, *q = b;
    for (int k = 2; k >= 0; --k)
        if (p->low[k] != q->low[k])
            return p->low[k] < q->low[k] ? -1 : 1;
    return p->level - q->level;
}

bool qni_cell_is_explained(void *user, const qni_cell *cell) {
    const qni_coarsening *coarsening = user;
    const qni_hermite *hermite = coarsening->hermite;
    if (coarsening->veto_count && bsearch(cell, coarsening->vetoes, (size_t)coarsening->veto_count,
                                          sizeof *cell, qni_compare_vetoes))
        return false;
    if (coarsening->settings->open && straddles(hermite, cell))
        return false;
    if (!qni_hermite_has_crossed_edge(hermite, cell->low, cell->level))
        return visit_samples(hermite, cell, is_unwanted, NULL);
    const int32_t thread = qni_thread_index();
    return is_explained(&coarsening->patches[thread], &coarsening->stores[thread], cell);
}
