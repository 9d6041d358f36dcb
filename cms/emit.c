// SPDX-License-Identifier: MIT
/* What a cell hands over: its triangles with their owners, its inner vertices, its crease edges. */
#include "cms/stages.h"
#include "cms/vector.h"
#include "core/context.h"

#include <math.h>
#include <string.h>

bool qni_stages_grow(qni_stages *stages, void **items, int64_t *capacity, int64_t wanted,
                     size_t size) {
    if (wanted <= *capacity)
        return true;
    int64_t more = *capacity ? *capacity + *capacity / 2 : 64;
    more = more < wanted ? wanted : more;
    void *fresh = qni_realloc(stages->context, *items, *capacity, more, size);
    if (!fresh)
        return false;
    *items = fresh;
    *capacity = more;
    return true;
}

void qni_stages_trim(qni_stages *stages, void **items, int64_t *capacity, int64_t count,
                     size_t size) {
    if (*capacity == count || !*items)
        return;
    void *fresh = qni_realloc(stages->context, *items, *capacity, count, size);
    if (!fresh)
        return; /* it stays as it is */
    *items = fresh;
    *capacity = count;
}

static uint32_t ref_of(const qni_patch *patch, int32_t vertex, const uint32_t *apex_refs,
                       int64_t inner_first) {
    if (vertex < 0)
        return apex_refs[-1 - vertex];
    if (vertex >= QNI_INNER)
        return QNI_REF_APEX | (uint32_t)(inner_first + (vertex - QNI_INNER));
    return patch->vertices[vertex].ref;
}

/* How far a triangle is from the tangent plane of a vertex. */
static double height_over(const qni_patch *patch, const int32_t triangle[4],
                          const qni_loop_vertex *plane) {
    double most = 0;
    for (int n = 0; n < 3; ++n) {
        const float *place = qni_patch_place(patch, triangle[n]);
        double height = 0;
        for (int k = 0; k < 3; ++k)
            height += plane->normal[k] * ((double)place[k] - plane->at[k]);
        most = fmax(most, fabs(height));
    }
    return most;
}

/* Of the vertices from one on that know a plane, the one in whose plane a triangle lies best; NULL
 * when none does. */
static const qni_loop_vertex *nearest_plane(const qni_patch *patch, const int32_t triangle[4],
                                            const qni_loop_vertex *from, int64_t count,
                                            double *least) {
    const qni_loop_vertex *best = NULL;
    for (int64_t n = 0; n < count; ++n) {
        const double height = from[n].has_plane ? height_over(patch, triangle, &from[n]) : HUGE_VAL;
        if (height < *least) {
            *least = height;
            best = &from[n];
        }
    }
    return best;
}

/* The owner of the loop's piece between two vertices: that of the crossing at its end, features lie
 * between. Between two features no crossing speaks for the sheet: the nearest plane does, of the
 * features themselves if they know one. */
static int32_t owner_of(const qni_patch *patch, const int32_t triangle[4]) {
    if (triangle[3] >= 0)
        return patch->vertices[triangle[3]].owner;
    const qni_loop_vertex *speaker = NULL;
    double least = HUGE_VAL;
    for (int k = 0; k < 3; ++k) {
        if (triangle[k] < 0 || triangle[k] >= QNI_INNER)
            continue;
        const qni_loop_vertex *vertex = &patch->vertices[triangle[k]];
        if (vertex->crossing)
            return vertex->crossing->owner;
        const qni_loop_vertex *own = nearest_plane(patch, triangle, vertex, 1, &least);
        speaker = own ? own : speaker;
    }
    if (!speaker)
        speaker = nearest_plane(patch, triangle, patch->vertices, patch->vertex_count, &least);
    return speaker ? speaker->owner : -1;
}

static bool emit_crease(qni_stages *stages, qni_chunk *chunk, uint32_t a, uint32_t b) {
    if (!qni_stages_grow(stages, (void **)&chunk->creases, &chunk->crease_capacity,
                         chunk->crease_count + 1, sizeof *chunk->creases))
        return false;
    chunk->creases[chunk->crease_count][0] = a;
    chunk->creases[chunk->crease_count++][1] = b;
    return true;
}

/* Do two triangles turn by more than the crease angle? */
static bool are_folded(const qni_patch *patch, const int32_t a[4], const int32_t b[4]) {
    double m[3], n[3];
    qni_patch_unit_normal(patch, a, m);
    qni_patch_unit_normal(patch, b, n);
    return qni_dot3(m, n) < patch->settings->crease_cosine;
}

/* Is the spoke to a sharp feature tagged? A crease is; where two parts of the solid meet at a small
 * angle, if the sheets on both sides of the feature turn enough, or the fan's triangles do. From an
 * apex that had to be put where no corner is, only if the solid's crease is there, too. */
static bool is_tagged(const qni_patch *patch, const qni_loop *loop, int32_t n) {
    const qni_loop_vertex *v = patch->vertices + loop->first,
                          *before = qni_plane_beside(v, loop->count, n, -1),
                          *after = v[n].has_plane ? &v[n] : qni_plane_beside(v, loop->count, n, 1);
    const int32_t(*fan)[4] = (const int32_t(*)[4])patch->triangles + loop->triangle_first,
          *last = fan[(n + loop->count - 1) % loop->count], *next = fan[n];
    const bool is_fan = loop->triangle_count == loop->count;
    if (loop->escaped)
        return is_fan && qni_is_true_fold(patch, last, next);
    return !before || !after || before->owner == after->owner ||
           qni_dot3(before->normal, after->normal) < patch->settings->crease_cosine ||
           (is_fan && are_folded(patch, last, next));
}

/* From a fan's apex to each sharp feature on the walls. */
static bool emit_spokes(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                        const qni_loop *loop, uint32_t apex, int64_t inner_first) {
    for (int32_t m = 0; m < loop->count; ++m) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + m];
        if (vertex->sharp && is_tagged(patch, loop, m) &&
            !emit_crease(stages, chunk, ref_of(patch, vertex->same, NULL, inner_first), apex))
            return false;
    }
    return true;
}

/* Of two parts of a loop, inner points lie on creases. */
static bool is_sharp(const qni_patch *patch, int32_t vertex) {
    return vertex >= QNI_INNER || patch->vertices[vertex].sharp;
}

/* By the planes that the triangles lie in; those of fans, and of two parts of the solid, by
 * themselves. */
static bool is_folded(const qni_patch *patch, const int32_t a[4], const int32_t b[4]) {
    if (a[3] < 0 || b[3] < 0)
        return are_folded(patch, a, b);
    const qni_loop_vertex *m = &patch->vertices[a[3]], *n = &patch->vertices[b[3]];
    return qni_dot3(m->normal, n->normal) < patch->settings->crease_cosine ||
           (m->owner != n->owner && are_folded(patch, a, b));
}

/* Is the edge between two triangles a crease? It joins two sharp features, and their tangent planes
 * differ enough. */
static bool emit_fold(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                      const int32_t a[4], const int32_t b[4], int64_t inner_first) {
    int32_t shared[2] = {0, 0};
    int count = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (a[i] == b[j] && a[i] >= 0 && count < 2)
                shared[count++] = a[i];
    return count < 2 || !is_sharp(patch, shared[0]) || !is_sharp(patch, shared[1]) ||
           !is_folded(patch, a, b) ||
           emit_crease(stages, chunk, ref_of(patch, shared[0], NULL, inner_first),
                       ref_of(patch, shared[1], NULL, inner_first));
}

static bool emit_folds(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch, int64_t first,
                       int64_t end, int64_t inner_first) {
    for (int64_t s = first; s < end; ++s)
        for (int64_t t = s + 1; t < end; ++t)
            if (!emit_fold(stages, chunk, patch, patch->triangles[s], patch->triangles[t],
                           inner_first))
                return false;
    return true;
}

/* Of a loop that was cut, a crease may run along the cut, between its parts. */
static bool emit_creases(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                         const uint32_t *apex_refs, int64_t inner_first) {
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        const qni_loop *loop = &patch->loops[n];
        if (loop->has_apex && !emit_spokes(stages, chunk, patch, loop, apex_refs[n], inner_first))
            return false;
        if (!loop->has_apex && !patch->split &&
            !emit_folds(stages, chunk, patch, loop->triangle_first,
                        loop->triangle_first + loop->triangle_count, inner_first))
            return false;
    }
    return !patch->split || emit_folds(stages, chunk, patch, 0, patch->triangle_count, inner_first);
}

/* Hand the patch over: apexes of loops that have one first, then inner points. */
bool qni_chunk_emit(qni_stages *stages, qni_chunk *chunk, qni_patch *patch) {
    const int64_t most = patch->loop_count + patch->inner_count;
    if (!qni_stages_grow(stages, (void **)&chunk->apexes, &chunk->apex_capacity,
                         chunk->apex_count + most, sizeof *chunk->apexes) ||
        !qni_stages_grow(stages, (void **)&chunk->triangles, &chunk->triangle_capacity,
                         chunk->triangle_count + patch->triangle_count, sizeof *chunk->triangles) ||
        !qni_stages_grow(stages, (void **)&chunk->owners, &chunk->owner_capacity,
                         chunk->triangle_count + patch->triangle_count, sizeof *chunk->owners) ||
        !qni_patch_grow(patch, (void **)&patch->scratch, &patch->scratch_capacity,
                        patch->loop_count, sizeof *patch->scratch))
        return false;
    uint32_t *apex_refs = (uint32_t *)patch->scratch;
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        apex_refs[n] = QNI_REF_APEX | (uint32_t)chunk->apex_count;
        if (patch->loops[n].has_apex)
            memcpy(chunk->apexes[chunk->apex_count++], patch->loops[n].apex, sizeof *chunk->apexes);
    }
    const int64_t inner_first = chunk->apex_count;
    for (int64_t n = 0; n < patch->inner_count; ++n)
        memcpy(chunk->apexes[chunk->apex_count++], patch->inner[n], sizeof *chunk->apexes);
    for (int64_t t = 0; t < patch->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k)
            chunk->triangles[chunk->triangle_count][k] =
                ref_of(patch, patch->triangles[t][k], apex_refs, inner_first);
        chunk->owners[chunk->triangle_count++] = owner_of(patch, patch->triangles[t]);
    }
    return emit_creases(stages, chunk, patch, apex_refs, inner_first);
}
