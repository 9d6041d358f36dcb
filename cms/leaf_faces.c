// SPDX-License-Identifier: MIT
/* The faces of one chunk's leaves.
 *
 * A face between two leaves belongs to the finer one; between equal ones to that below it. In a
 * later pass only the faces that are new are solved, and those to be looked at closely: the others
 * keep their segments, and these the numbers of their features, so that only the cells beside what
 * changed are made anew. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

/* Whose level is that across? */
static bool owns_face(const qni_cell *cell, int face, int across) {
    return across < 0 || across == cell->level ? face & 1 : across > cell->level;
}

int64_t qni_leaf_before(const qni_stages *stages, const qni_chunk *chunk, const qni_cell *leaf,
                        int64_t *from) {
    while (*from < chunk->before_count &&
           qni_octree_find_leaf(stages->octree, &chunk->before[*from]) < 0)
        ++*from; /* it was divided */
    if (*from == chunk->before_count || memcmp(&chunk->before[*from], leaf, sizeof *leaf) != 0)
        return -1;
    return (*from)++;
}

/* The chunk's faces as they were. */
typedef struct faces_before {
    qni_leaf_faces *faces;
    qni_segment *segments;
    int64_t face_capacity, segment_capacity;
} faces_before;

static bool add_segments(qni_stages *stages, qni_chunk *chunk, const qni_segment *segments,
                         int count) {
    if (count == 0)
        return true;
    if (!qni_stages_grow(stages, (void **)&chunk->segments, &chunk->segment_capacity,
                         chunk->segment_count + count, sizeof *chunk->segments))
        return false;
    memcpy(chunk->segments + chunk->segment_count, segments, sizeof *segments * (size_t)count);
    chunk->segment_count += count;
    return true;
}

static bool add_solution(qni_stages *stages, qni_chunk *chunk, qni_face_solution *solution) {
    if (!qni_stages_grow(stages, (void **)&chunk->features, &chunk->feature_capacity,
                         chunk->feature_count + solution->feature_count, sizeof *chunk->features))
        return false;
    for (int n = 0; n < solution->count; ++n) {
        solution->segments[n].feature += (uint32_t)chunk->feature_count;
        solution->segments[n].touching = n == 0 && solution->unresolved;
        solution->segments[n].pass = stages->pass;
    }
    for (int n = 0; n < solution->feature_count; ++n)
        chunk->features[chunk->feature_count++] = solution->features[n];
    return add_segments(stages, chunk, solution->segments, solution->count);
}

/* The faces of a leaf but for their segments; corners may reach into empty cells. */
static qni_leaf_faces describe(const qni_stages *stages, const qni_cell *cell) {
    qni_leaf_faces faces = {.pass = stages->pass};
    for (int face = 0; face < QNI_FACES; ++face) {
        const qni_cell across = qni_cell_across(cell, face);
        const int level = cell->level ? qni_octree_level_across(stages->octree, cell, face)
                                      : qni_octree_level(stages->octree, across.low);
        faces.at[face].owned = owns_face(cell, face, level);
        faces.at[face].closely = cell->level == 0 && (qni_is_close(stages, cell->low) ||
                                                      qni_is_close(stages, across.low));
        if (cell->level == 0 && stages->unite &&
            qni_octree_is_empty_of(stages->octree, across.low, level))
            faces.empty |= (uint8_t)(1 << face);
    }
    return faces;
}

static qn_status solve(qni_stages *stages, qni_chunk *chunk, const qni_cell *cell, int face,
                       qni_leaf_face *own) {
    const int thread = qni_thread_index();
    qni_patch *patch = &stages->patches[thread];
    qni_face_solution *solution = &stages->solutions[thread];
    const qni_face place = qni_face_of_cell(cell, face);
    qni_solve_face(stages->hermite, patch->solid, &stages->settings, &place, own->closely,
                   solution);
    if (solution->broken)
        return QN_ERROR_INTERNAL;
    own->count = (unsigned)solution->count & 63U;
    return add_solution(stages, chunk, solution) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static qn_status faces_of_leaf(qni_stages *stages, qni_chunk *chunk, int64_t leaf,
                               const qni_leaf_faces *before, const qni_segment *segments) {
    const qni_cell *cell = &stages->octree->leaves[leaf];
    qni_leaf_faces *faces = &chunk->faces[leaf - chunk->leaf_first];
    *faces = describe(stages, cell);
    faces->first = (uint32_t)chunk->segment_count;
    if (before && before->empty == faces->empty)
        faces->pass = before->pass;
    qni_patch_set_cell(&stages->patches[qni_thread_index()], cell);
    for (int face = 0; face < QNI_FACES; ++face) {
        qni_leaf_face *own = &faces->at[face];
        const qni_leaf_face was = before ? before->at[face] : (qni_leaf_face){.owned = false};
        if (own->owned && was.owned && was.closely == own->closely) {
            own->count = was.count;
            if (!add_segments(stages, chunk, segments, was.count))
                return QN_ERROR_OUT_OF_MEMORY;
        } else if (own->owned) {
            QN_TRY(solve(stages, chunk, cell, face, own));
        }
        if (before)
            segments += was.count;
    }
    return QN_OK;
}

static qn_status solve_leaves(qni_stages *stages, qni_chunk *chunk, const faces_before *before) {
    int64_t from = 0;
    if (!qni_stages_grow(stages, (void **)&chunk->faces, &chunk->face_capacity,
                         chunk->leaf_end - chunk->leaf_first, sizeof *chunk->faces))
        return QN_ERROR_OUT_OF_MEMORY;
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end; ++leaf) {
        const int64_t was = qni_leaf_before(stages, chunk, &stages->octree->leaves[leaf], &from);
        const qni_leaf_faces *faces = was < 0 ? NULL : &before->faces[was];
        QN_TRY(faces_of_leaf(stages, chunk, leaf, faces,
                             faces ? before->segments + faces->first : NULL));
    }
    return QN_OK;
}

void qni_chunk_faces(qni_stages *stages, int64_t index) {
    qni_chunk *chunk = &stages->chunks[index];
    if (!chunk->solve)
        return;
    const faces_before before = {chunk->faces, chunk->segments, chunk->face_capacity,
                                 chunk->segment_capacity};
    chunk->faces = NULL;
    chunk->segments = NULL;
    chunk->face_capacity = chunk->segment_capacity = chunk->segment_count = 0;
    chunk->feature_count = 0;
    chunk->status = solve_leaves(stages, chunk, &before);
    qni_stages_trim(stages, (void **)&chunk->segments, &chunk->segment_capacity,
                    chunk->segment_count, sizeof *chunk->segments);
    qni_stages_trim(stages, (void **)&chunk->faces, &chunk->face_capacity,
                    chunk->leaf_end - chunk->leaf_first, sizeof *chunk->faces);
    qni_free(stages->context, before.faces, before.face_capacity, sizeof *before.faces);
    qni_free(stages->context, before.segments, before.segment_capacity, sizeof *before.segments);
}
