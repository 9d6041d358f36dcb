// SPDX-License-Identifier: MIT
/* One chunk of leaves: the faces they own, then their cells.
 *
 * A face between two leaves belongs to the finer one; between equal ones to that below it. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/cube_hd.h"
#include "core/parallel.h"

#include <string.h>

static bool grow(qni_stages *stages, void **items, int64_t *capacity, int64_t wanted, size_t size) {
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

/* ---- faces
 * --------------------------------------------------------------------------------------- */

static bool owns_face(const qni_octree *octree, const qni_cell *cell, int face) {
    if (qni_octree_divided_across(octree, cell, face))
        return false;
    return (face & 1) || qni_octree_coarser_across(octree, cell, face);
}

static bool keep_solution(qni_stages *stages, qni_chunk *chunk, const qni_face_solution *solution) {
    if (!grow(stages, (void **)&chunk->segments, &chunk->segment_capacity,
              chunk->segment_count + solution->count, sizeof *chunk->segments) ||
        !grow(stages, (void **)&chunk->features, &chunk->feature_capacity,
              chunk->feature_count + solution->feature_count, sizeof *chunk->features))
        return false;
    for (int n = 0; n < solution->count; ++n) {
        qni_segment segment = solution->segments[n];
        segment.feature += (uint32_t)chunk->feature_count;
        chunk->segments[chunk->segment_count++] = segment;
    }
    for (int n = 0; n < solution->feature_count; ++n) {
        chunk->features[chunk->feature_count++] = solution->features[n];
        chunk->face_tally.face_features += solution->features[n].sharp;
    }
    chunk->face_tally.ambiguous_faces += solution->ambiguous;
    chunk->face_tally.dropped_features += solution->dropped;
    chunk->face_tally.unresolved_faces += solution->unresolved;
    return true;
}

static qn_status faces_of_leaf(qni_stages *stages, qni_chunk *chunk, int64_t leaf, qni_patch *patch,
                               qni_face_solution *solution) {
    const qni_cell *cell = &stages->octree->leaves[leaf];
    qni_leaf_faces *faces = &chunk->faces[leaf - chunk->leaf_first];
    faces->first = (uint32_t)chunk->segment_count;
    qni_patch_set_cell(patch, cell);
    for (int face = 0; face < QNI_FACES; ++face) {
        faces->count[face] = 0;
        if (!owns_face(stages->octree, cell, face))
            continue;
        const qni_face place = qni_face_of_cell(cell, face);
        qni_solve_face(stages->hermite, patch->solid, &stages->settings, &place, solution);
        if (solution->broken)
            return QN_ERROR_INTERNAL;
        faces->count[face] = (uint8_t)solution->count;
        if (!keep_solution(stages, chunk, solution))
            return QN_ERROR_OUT_OF_MEMORY;
    }
    return QN_OK;
}

void qni_chunk_faces(qni_stages *stages, int64_t index) {
    qni_chunk *chunk = &stages->chunks[index];
    const qni_cms_tally none = {0};
    const int64_t leaves = chunk->leaf_end - chunk->leaf_first;
    if (!chunk->solve)
        return;
    chunk->segment_count = chunk->feature_count = 0;
    chunk->face_tally = none;
    if (!grow(stages, (void **)&chunk->faces, &chunk->face_capacity, leaves, sizeof *chunk->faces))
        chunk->status = QN_ERROR_OUT_OF_MEMORY;
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end && chunk->status == QN_OK; ++leaf)
        chunk->status = faces_of_leaf(stages, chunk, leaf, &stages->patches[qni_thread_index()],
                                      &stages->solutions[qni_thread_index()]);
}

/* ---- cells
 * --------------------------------------------------------------------------------------- */

/* The segments on one leaf face, whoever owns it, as seen from the cell; without a patch they are
 * only counted. */
static bool take_segments(qni_stages *stages, qni_patch *patch, int64_t leaf, int owner_face,
                          bool out) {
    qni_chunk *chunk = &stages->chunks[stages->chunk_of_leaf[leaf]];
    const qni_leaf_faces *faces = &chunk->faces[leaf - chunk->leaf_first];
    int64_t first = faces->first;
    for (int face = 0; face < owner_face; ++face)
        first += faces->count[face];
    for (int n = 0; n < faces->count[owner_face]; ++n) {
        qni_segment *segment = &chunk->segments[first + n];
        ++segment->used[out ? 0 : 1];
        if (patch && !qni_patch_add_piece(patch, segment, out, (uint32_t)chunk->feature_base))
            return false;
    }
    return true;
}

/* The face of a cell, or of a part of it that lies against finer leaves. */
static bool gather_face(qni_stages *stages, qni_patch *patch, const qni_cell *cell, int face,
                        bool out) {
    if (qni_octree_divided_across(stages->octree, cell, face)) {
        const int axis = face >> 1, p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
        const int32_t half = 1 << (cell->level - 1);
        for (int n = 0; n < 4; ++n) {
            qni_cell part = *cell;
            part.level = cell->level - 1;
            part.low[axis] += face & 1 ? half : 0;
            part.low[p] += n & 1 ? half : 0;
            part.low[q] += n & 2 ? half : 0;
            if (!gather_face(stages, patch, &part, face, out))
                return false;
        }
        return true;
    }
    const qni_cell across = qni_cell_across(cell, face);
    const int64_t leaf = qni_octree_find_leaf(stages->octree, &across);
    return leaf < 0 || take_segments(stages, patch, leaf, face ^ 1, out);
}

static bool gather_cell(qni_stages *stages, qni_patch *patch, int64_t leaf) {
    const qni_cell *cell = &stages->octree->leaves[leaf];
    for (int face = 0; face < QNI_FACES; ++face) {
        const bool out = qni_face_points_out(face);
        if (owns_face(stages->octree, cell, face) ? !take_segments(stages, patch, leaf, face, out)
                                                  : !gather_face(stages, patch, cell, face, out))
            return false;
    }
    return true;
}

static uint32_t ref_of(const qni_patch *patch, int32_t vertex, const uint32_t *apex_refs,
                       int64_t inner_first) {
    if (vertex < 0)
        return apex_refs[-1 - vertex];
    if (vertex >= QNI_INNER)
        return QNI_REF_APEX | (uint32_t)(inner_first + (vertex - QNI_INNER));
    return patch->vertices[vertex].ref;
}

/* The owner of the loop's piece between two vertices: that of the crossing at its end, features lie
 * between. */
static int32_t owner_of(const qni_patch *patch, const int32_t triangle[4]) {
    if (triangle[3] >= 0)
        return patch->vertices[triangle[3]].owner;
    for (int k = 0; k < 3; ++k)
        if (triangle[k] >= 0 && triangle[k] < QNI_INNER && patch->vertices[triangle[k]].crossing)
            return patch->vertices[triangle[k]].crossing->owner;
    return -1;
}

static bool emit_crease(qni_stages *stages, qni_chunk *chunk, uint32_t a, uint32_t b) {
    if (!grow(stages, (void **)&chunk->creases, &chunk->crease_capacity, chunk->crease_count + 1,
              sizeof *chunk->creases))
        return false;
    chunk->creases[chunk->crease_count][0] = a;
    chunk->creases[chunk->crease_count++][1] = b;
    return true;
}

/* From a fan's apex to each sharp feature on the walls; not from one that had to be put where no
 * corner is. */
static bool emit_spokes(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                        const qni_loop *loop, uint32_t apex) {
    for (int32_t m = 0; m < loop->count; ++m) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + m];
        if (vertex->sharp && !emit_crease(stages, chunk, vertex->ref, apex))
            return false;
    }
    return true;
}

static bool is_folded(const qni_patch *patch, const int32_t a[4], const int32_t b[4]) {
    const double *m = patch->vertices[a[3]].normal, *n = patch->vertices[b[3]].normal;
    return m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < patch->settings->crease_cosine;
}

/* Is the edge between two triangles a crease? It joins two sharp features, and their tangent planes
 * differ enough. */
static bool emit_fold(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                      const int32_t a[4], const int32_t b[4]) {
    int32_t shared[2] = {0, 0};
    int count = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (a[i] == b[j] && count < 2)
                shared[count++] = a[i];
    return count < 2 || !patch->vertices[shared[0]].sharp || !patch->vertices[shared[1]].sharp ||
           !is_folded(patch, a, b) ||
           emit_crease(stages, chunk, patch->vertices[shared[0]].ref,
                       patch->vertices[shared[1]].ref);
}

static bool emit_creases(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                         const uint32_t *apex_refs) {
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        const qni_loop *loop = &patch->loops[n];
        if (loop->has_apex && !loop->escaped &&
            !emit_spokes(stages, chunk, patch, loop, apex_refs[n]))
            return false;
        for (int32_t s = 0; s < loop->triangle_count && !loop->has_apex; ++s)
            for (int32_t t = s + 1; t < loop->triangle_count; ++t) {
                const int32_t *a = patch->triangles[loop->triangle_first + s],
                              *b = patch->triangles[loop->triangle_first + t];
                if (a[3] >= 0 && b[3] >= 0 && !emit_fold(stages, chunk, patch, a, b))
                    return false;
            }
    }
    return true;
}

/* Hand the patch over: apexes of loops that have one first, then inner points. */
static bool emit(qni_stages *stages, qni_chunk *chunk, qni_patch *patch) {
    const int64_t most = patch->loop_count + patch->inner_count;
    if (!grow(stages, (void **)&chunk->apexes, &chunk->apex_capacity, chunk->apex_count + most,
              sizeof *chunk->apexes) ||
        !grow(stages, (void **)&chunk->triangles, &chunk->triangle_capacity,
              chunk->triangle_count + patch->triangle_count, sizeof *chunk->triangles) ||
        !grow(stages, (void **)&chunk->owners, &chunk->owner_capacity,
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
    return emit_creases(stages, chunk, patch, apex_refs);
}

static bool lies_across_bounds(const qni_lattice *lattice, const qni_cell *cell) {
    for (int k = 0; k < 3; ++k)
        if (qni_lattice_at(lattice, k, cell->low[k]) < lattice->bounds.low[k] ||
            qni_lattice_at(lattice, k, cell->low[k] + (1 << cell->level)) > lattice->bounds.high[k])
            return true;
    return false;
}

/* A coarse leaf is asked again with the segments that its finer neighbours gave it: the same
 * conditions as before. */
static bool came_out_well(const qni_patch *patch, const qni_cms_tally *before,
                          const qni_cms_tally *after) {
    if (patch->cell.level == 0 || !patch->settings->features)
        return true;
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        const qni_loop *loop = &patch->loops[n];
        if (loop->has_apex && (loop->escaped || (loop->clusters == 2 && loop->sharp_count != 2)))
            return false;
    }
    return before->moved_loops == after->moved_loops &&
           before->unresolved_cells == after->unresolved_cells;
}

static qn_status cell_of_leaf(qni_stages *stages, qni_chunk *chunk, int64_t leaf,
                              qni_patch *patch) {
    patch->octree = stages->octree;
    qni_patch_set_cell(patch, &stages->octree->leaves[leaf]);
    if (!gather_cell(stages, patch, leaf))
        return QN_ERROR_OUT_OF_MEMORY;
    if (stages->settings.open && lies_across_bounds(&stages->hermite->lattice, &patch->cell))
        return QN_OK;
    if (!qni_patch_trace(patch, stages->features)) {
        ++chunk->cell_tally.open_loops;
        return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_ERROR_INTERNAL;
    }
    const qni_cms_tally before = chunk->cell_tally;
    qn_status status = qni_patch_place_apexes(patch, true, &chunk->cell_tally);
    if (status == QN_OK)
        status = qni_patch_triangulate(patch, &chunk->cell_tally);
    if (status == QN_OK)
        status = qni_patch_separate(patch, &chunk->cell_tally);
    if (status != QN_OK)
        return status;
    if (!came_out_well(patch, &before, &chunk->cell_tally)) {
        if (!grow(stages, (void **)&chunk->vetoes, &chunk->veto_capacity, chunk->veto_count + 1,
                  sizeof *chunk->vetoes))
            return QN_ERROR_OUT_OF_MEMORY;
        chunk->vetoes[chunk->veto_count++] = patch->cell;
    }
    return emit(stages, chunk, patch) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

void qni_chunk_cells(qni_stages *stages, int64_t index) {
    qni_chunk *chunk = &stages->chunks[index];
    const qni_cms_tally none = {0};
    if (!chunk->make)
        return;
    chunk->triangle_count = chunk->apex_count = chunk->crease_count = chunk->veto_count = 0;
    chunk->cell_tally = none;
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end && chunk->status == QN_OK; ++leaf)
        chunk->status = cell_of_leaf(stages, chunk, leaf, &stages->patches[qni_thread_index()]);
}

void qni_chunk_recount(qni_stages *stages, int64_t index) {
    const qni_chunk *chunk = &stages->chunks[index];
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end; ++leaf)
        gather_cell(stages, NULL, leaf);
}
