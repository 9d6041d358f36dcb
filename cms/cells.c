// SPDX-License-Identifier: MIT
/* One chunk of leaves: the faces they own, then their cells.
 *
 * A face between two leaves belongs to the finer one; between equal ones to that below it. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/cube_hd.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* ---- faces
 * --------------------------------------------------------------------------------------- */

static bool owns_face(const qni_octree *octree, const qni_cell *cell, int face) {
    if (qni_octree_divided_across(octree, cell, face))
        return false;
    return (face & 1) || qni_octree_coarser_across(octree, cell, face);
}

static bool keep_solution(qni_stages *stages, qni_chunk *chunk, const qni_face_solution *solution) {
    if (!qni_stages_grow(stages, (void **)&chunk->segments, &chunk->segment_capacity,
                         chunk->segment_count + solution->count, sizeof *chunk->segments) ||
        !qni_stages_grow(stages, (void **)&chunk->features, &chunk->feature_capacity,
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
        const qni_cell across = qni_cell_across(cell, face);
        const bool closely = cell->level == 0 &&
                             (qni_is_close(stages, cell->low) || qni_is_close(stages, across.low));
        qni_solve_face(stages->hermite, patch->solid, &stages->settings, &place, closely, solution);
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
    if (!qni_stages_grow(stages, (void **)&chunk->faces, &chunk->face_capacity, leaves,
                         sizeof *chunk->faces))
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
        if (!patch || !patch->trial)
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

static bool holds(const qni_cell_box *box, const int32_t low[3]) {
    for (int k = 0; k < 3; ++k)
        if (low[k] < box->low[k] || low[k] >= box->low[k] + box->size[k])
            return false;
    return true;
}

/* The pieces of a leaf; of one in a union, without those on walls to its other members. */
static bool gather_cell(qni_stages *stages, qni_patch *patch, int64_t leaf,
                        const qni_cell_box *box) {
    const qni_cell *cell = &stages->octree->leaves[leaf];
    for (int face = 0; face < QNI_FACES; ++face) {
        const qni_cell across = qni_cell_across(cell, face);
        if (box && holds(box, across.low))
            continue;
        const bool out = qni_face_points_out(face);
        if (owns_face(stages->octree, cell, face) ? !take_segments(stages, patch, leaf, face, out)
                                                  : !gather_face(stages, patch, cell, face, out))
            return false;
    }
    return true;
}

static bool gather_union(qni_stages *stages, qni_patch *patch, const qni_cell_box *box) {
    qni_cell cell = {{0, 0, 0}, 0};
    for (int32_t n = 0; qni_box_member(box, n, &cell); ++n) {
        const int64_t leaf = qni_octree_find_leaf(stages->octree, &cell);
        if (leaf >= 0 && !gather_cell(stages, patch, leaf, box))
            return false;
    }
    return true;
}

static bool lies_across_bounds(const qni_lattice *lattice, const qni_cell *cell) {
    for (int k = 0; k < 3; ++k)
        if (qni_lattice_at(lattice, k, cell->low[k]) < lattice->bounds.low[k] ||
            qni_lattice_at(lattice, k, cell->low[k] + (1 << cell->level)) > lattice->bounds.high[k])
            return true;
    return false;
}

/* Do two creases leave a corner almost the same way? It is one crease, which left the leaf through
 * a wall to finer neighbours and came back. */
static bool has_twin_spokes(const qni_patch *patch, const qni_loop *loop) {
    enum { MOST_SPOKES = 16 };
    static const double alike = 0.985; /* 10 degrees */
    double spokes[MOST_SPOKES][3];
    int count = 0;
    for (int32_t n = 0; n < loop->count && count < MOST_SPOKES; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        double length = 0;
        if (!vertex->sharp)
            continue;
        for (int k = 0; k < 3; ++k) {
            spokes[count][k] = (double)vertex->place[k] - (double)loop->apex[k];
            length += spokes[count][k] * spokes[count][k];
        }
        for (int k = 0; k < 3; ++k)
            spokes[count][k] /= sqrt(length);
        for (int m = 0; m < count; ++m)
            if (spokes[m][0] * spokes[count][0] + spokes[m][1] * spokes[count][1] +
                    spokes[m][2] * spokes[count][2] >
                alike)
                return true;
        ++count;
    }
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
        if (loop->has_apex && loop->sharp_count > 3 && has_twin_spokes(patch, loop))
            return false;
    }
    return before->moved_loops == after->moved_loops &&
           before->unresolved_cells == after->unresolved_cells && qni_cell_is_explained_by(patch);
}

/* What gets a union its try (unite.c). */
static bool note_trouble(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                         const qni_cms_tally *before) {
    const qni_cms_tally *after = &chunk->cell_tally;
    qni_trouble trouble = {
        .cell = {patch->cell.low[0], patch->cell.low[1], patch->cell.low[2]},
        .bad = patch->dropped + (int32_t)(after->moved_loops - before->moved_loops),
        .tube =
            before->tubes != after->tubes || before->unresolved_cells != after->unresolved_cells,
    };
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        const qni_loop *loop = &patch->loops[n];
        trouble.bad += loop->escaped;
        trouble.several = trouble.several || (loop->escaped && loop->sharp_count > 3);
        trouble.reaches = trouble.reaches || loop->beyond;
        if (loop->beyond || (loop->knows_corner && !trouble.knows_corner)) {
            memcpy(trouble.corner, loop->beyond ? loop->apex : loop->corner, sizeof trouble.corner);
            trouble.knows_corner = true;
        }
    }
    if (!trouble.bad && !trouble.reaches && !trouble.tube)
        return true;
    if (!qni_stages_grow(stages, (void **)&chunk->troubles, &chunk->trouble_capacity,
                         chunk->trouble_count + 1, sizeof *chunk->troubles))
        return false;
    chunk->troubles[chunk->trouble_count++] = trouble;
    return true;
}

/* Does a step seem to end in a finest cell, and do its creases not lie where the solid's are? */
static bool note_doubt(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch) {
    bool escaped = false, turns = false;
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        escaped = escaped || patch->loops[n].escaped;
        turns = turns || qni_step_turns_back(patch, &patch->loops[n]);
    }
    if (!turns || (!escaped && qni_creases_hold(patch)))
        return true;
    if (!qni_stages_grow(stages, (void **)&chunk->doubts, &chunk->doubt_capacity,
                         chunk->doubt_count + 1, sizeof *chunk->doubts))
        return false;
    memcpy(chunk->doubts[chunk->doubt_count++], patch->cell.low, sizeof *chunk->doubts);
    return true;
}

qn_status qni_trace_patch(qni_stages *stages, qni_patch *patch, int64_t leaf,
                          const qni_cell_box *box, bool *closed) {
    patch->octree = stages->octree;
    patch->unions = &stages->unions;
    if (box)
        qni_patch_set_union(patch, box);
    else
        qni_patch_set_cell(patch, &stages->octree->leaves[leaf]);
    if (box ? !gather_union(stages, patch, box) : !gather_cell(stages, patch, leaf, NULL))
        return QN_ERROR_OUT_OF_MEMORY;
    *closed = qni_patch_trace(patch, stages->features);
    return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}

qn_status qni_fill_patch(qni_patch *patch, qni_cms_tally *tally) {
    QN_TRY(qni_patch_place_apexes(patch, true, tally));
    QN_TRY(qni_patch_triangulate(patch, tally));
    return patch->united ? QN_OK : qni_patch_separate(patch, tally);
}

/* The lowest leaf of a union makes all of it. */
static bool makes_union(const qni_stages *stages, const qni_cell_box *box, int64_t leaf) {
    qni_cell cell = {{0, 0, 0}, 0};
    for (int32_t n = 0; qni_box_member(box, n, &cell); ++n) {
        const int64_t member = qni_octree_find_leaf(stages->octree, &cell);
        if (member >= 0)
            return member == leaf;
    }
    return false;
}

static qn_status make_united(qni_stages *stages, qni_chunk *chunk, const qni_cell_box *box,
                             qni_patch *patch) {
    bool closed;
    QN_TRY(qni_trace_patch(stages, patch, -1, box, &closed));
    ++chunk->cell_tally.united_cells;
    if (!closed)
        return QN_ERROR_INTERNAL;
    QN_TRY(qni_fill_patch(patch, &chunk->cell_tally));
    return qni_chunk_emit(stages, chunk, patch) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static qn_status cell_of_leaf(qni_stages *stages, qni_chunk *chunk, int64_t leaf,
                              qni_patch *patch) {
    const qni_cell *cell = &stages->octree->leaves[leaf];
    if (stages->settings.open && lies_across_bounds(&stages->hermite->lattice, cell)) {
        gather_cell(stages, NULL, leaf, NULL);
        return QN_OK;
    }
    const int64_t number = cell->level ? -1 : qni_find_union(&stages->unions, cell->low);
    if (number >= 0) {
        const qni_cell_box *box = &stages->unions.items[number];
        return makes_union(stages, box, leaf) ? make_united(stages, chunk, box, patch) : QN_OK;
    }
    const qni_cms_tally before = chunk->cell_tally;
    bool closed;
    QN_TRY(qni_trace_patch(stages, patch, leaf, NULL, &closed));
    if (!closed) {
        ++chunk->cell_tally.open_loops;
        return QN_ERROR_INTERNAL;
    }
    QN_TRY(qni_fill_patch(patch, &chunk->cell_tally));
    if (!came_out_well(patch, &before, &chunk->cell_tally)) {
        if (!qni_stages_grow(stages, (void **)&chunk->vetoes, &chunk->veto_capacity,
                             chunk->veto_count + 1, sizeof *chunk->vetoes))
            return QN_ERROR_OUT_OF_MEMORY;
        chunk->vetoes[chunk->veto_count++] = patch->cell;
    }
    if (cell->level == 0 && stages->unite &&
        (!note_trouble(stages, chunk, patch, &before) || !note_doubt(stages, chunk, patch)))
        return QN_ERROR_OUT_OF_MEMORY;
    return qni_chunk_emit(stages, chunk, patch) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

void qni_chunk_cells(qni_stages *stages, int64_t index) {
    qni_chunk *chunk = &stages->chunks[index];
    const qni_cms_tally none = {0};
    if (!chunk->make)
        return;
    chunk->triangle_count = chunk->apex_count = chunk->crease_count = chunk->veto_count =
        chunk->trouble_count = chunk->doubt_count = 0;
    chunk->cell_tally = none;
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end && chunk->status == QN_OK; ++leaf)
        chunk->status = cell_of_leaf(stages, chunk, leaf, &stages->patches[qni_thread_index()]);
}

void qni_chunk_recount(qni_stages *stages, int64_t index) {
    const qni_chunk *chunk = &stages->chunks[index];
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end; ++leaf)
        gather_cell(stages, NULL, leaf, NULL);
}
