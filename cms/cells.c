// SPDX-License-Identifier: MIT
/* The cells of one chunk's leaves. In a later pass only cells whose faces have changed are made
 * anew. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/cube_hd.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* The segments on one leaf face, whoever owns it, as seen from the cell; without a patch their uses
 * are counted. */
static bool take_segments(qni_stages *stages, qni_patch *patch, int64_t leaf, int owner_face,
                          bool out) {
    qni_chunk *chunk = &stages->chunks[stages->chunk_of_leaf[leaf]];
    const qni_leaf_faces *faces = &chunk->faces[leaf - chunk->leaf_first];
    int64_t first = faces->first;
    for (int face = 0; face < owner_face; ++face)
        first += faces->at[face].count;
    for (int n = 0; n < faces->at[owner_face].count; ++n) {
        qni_segment *segment = &chunk->segments[first + n];
        if (!patch)
            ++segment->used[out ? 0 : 1];
        else if (!qni_patch_add_piece(patch, segment, out, 0))
            return false;
    }
    return true;
}

/* The face of a cell, or of a part of it that lies against finer leaves. */
static bool gather_face(qni_stages *stages, qni_patch *patch, const qni_cell *cell, int face,
                        bool out) {
    if (cell->level > 0 && qni_octree_divided_across(stages->octree, cell, face)) {
        if (patch)
            patch->beside_finer = true;
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
    const qni_chunk *chunk = &stages->chunks[stages->chunk_of_leaf[leaf]];
    const qni_leaf_faces *faces = &chunk->faces[leaf - chunk->leaf_first];
    for (int face = 0; face < QNI_FACES; ++face) {
        const qni_cell across = qni_cell_across(cell, face);
        if (box && holds(box, across.low))
            continue;
        const bool out = qni_face_points_out(face);
        if (faces->at[face].owned ? !take_segments(stages, patch, leaf, face, out)
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
 * conditions as before. Without any it has the triangles by which it became a leaf. */
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
           before->unresolved_cells == after->unresolved_cells &&
           (!patch->beside_finer || qni_cell_is_explained_by(patch));
}

/* What gets a union its try (unite.c). */
static bool note_trouble(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch,
                         const qni_cms_tally *before) {
    const qni_cms_tally *after = &chunk->tally;
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
static qni_doubt doubt_of(const qni_patch *patch) {
    const double tolerance = patch->settings->tolerance;
    qni_doubt doubt = QNI_NO_DOUBT;
    bool escaped = false, ends = false;
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        const qni_loop *loop = &patch->loops[n];
        const qni_doubt turns = qni_step_turns_back(patch, loop);
        doubt = turns > doubt ? turns : doubt;
        escaped = escaped || loop->escaped;
        ends = ends || (loop->escaped && (loop->sharp_count == 1 || loop->of_facets));
    }
    if (doubt == QNI_NO_DOUBT)
        return ends ? QNI_FAINT_DOUBT : QNI_NO_DOUBT;
    if (escaped || !qni_creases_hold(patch, tolerance))
        return doubt;
    return qni_creases_hold(patch, 0.2 * tolerance) ? QNI_NO_DOUBT : QNI_SLIGHT_DOUBT;
}

static bool note_doubt(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch) {
    const qni_doubt doubt = doubt_of(patch);
    if (doubt == QNI_NO_DOUBT)
        return true;
    if (!qni_stages_grow(stages, (void **)&chunk->doubts, &chunk->doubt_capacity,
                         chunk->doubt_count + 1, sizeof *chunk->doubts))
        return false;
    qni_doubted *cell = &chunk->doubts[chunk->doubt_count++];
    memcpy(cell->low, patch->cell.low, sizeof cell->low);
    cell->doubt = doubt;
    return true;
}

static qn_status gather(qni_stages *stages, qni_patch *patch, int64_t leaf,
                        const qni_cell_box *box) {
    patch->octree = stages->octree;
    patch->unions = &stages->unions;
    if (box)
        qni_patch_set_union(patch, box);
    else
        qni_patch_set_cell(patch, &stages->octree->leaves[leaf]);
    if (box ? !gather_union(stages, patch, box) : !gather_cell(stages, patch, leaf, NULL))
        return QN_ERROR_OUT_OF_MEMORY;
    return QN_OK;
}

qn_status qni_trace_patch(qni_stages *stages, qni_patch *patch, int64_t leaf,
                          const qni_cell_box *box, bool *closed) {
    QN_TRY(gather(stages, patch, leaf, box));
    *closed = qni_patch_trace(patch, stages->features);
    return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}

qn_status qni_fill_patch(qni_patch *patch, qni_cms_tally *tally) {
    QN_TRY(qni_patch_place_apexes(patch, tally));
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
    ++chunk->tally.united_cells;
    if (!closed)
        return QN_ERROR_INTERNAL;
    QN_TRY(qni_fill_patch(patch, &chunk->tally));
    return qni_chunk_emit(stages, chunk, patch) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static bool note_veto(qni_stages *stages, qni_chunk *chunk, const qni_patch *patch) {
    if (!qni_stages_grow(stages, (void **)&chunk->vetoes, &chunk->veto_capacity,
                         chunk->veto_count + 1, sizeof *chunk->vetoes))
        return false;
    chunk->vetoes[chunk->veto_count++] = patch->cell;
    return true;
}

/* Of a patch whose pieces are gathered. */
static qn_status make_cell(qni_stages *stages, qni_chunk *chunk, qni_patch *patch) {
    const qni_cms_tally before = chunk->tally;
    const bool closed = qni_patch_trace(patch, stages->features);
    if (patch->failed)
        return QN_ERROR_OUT_OF_MEMORY;
    if (!closed) {
        ++chunk->tally.open_loops;
        return QN_ERROR_INTERNAL;
    }
    QN_TRY(qni_fill_patch(patch, &chunk->tally));
    if (!came_out_well(patch, &before, &chunk->tally) && !note_veto(stages, chunk, patch))
        return QN_ERROR_OUT_OF_MEMORY;
    if (patch->cell.level == 0 && stages->unite &&
        (!note_trouble(stages, chunk, patch, &before) || !note_doubt(stages, chunk, patch)))
        return QN_ERROR_OUT_OF_MEMORY;
    return qni_chunk_emit(stages, chunk, patch) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

/* Make it, or hand over what it made before, when `walk` is there. */
static qn_status cell_of_leaf(qni_stages *stages, qni_chunk *chunk, int64_t leaf, qni_patch *patch,
                              qni_kept_walk *walk) {
    const qni_cell *cell = &stages->octree->leaves[leaf];
    if (stages->settings.open && lies_across_bounds(&stages->hermite->lattice, cell))
        return QN_OK;
    const int64_t number = cell->level ? -1 : qni_find_union(&stages->unions, cell->low);
    if (number >= 0) {
        const qni_cell_box *box = &stages->unions.items[number];
        return makes_union(stages, box, leaf) ? make_united(stages, chunk, box, patch) : QN_OK;
    }
    QN_TRY(gather(stages, patch, leaf, NULL));
    if (walk && patch->youngest != stages->pass &&
        chunk->faces[leaf - chunk->leaf_first].pass != stages->pass)
        return qni_kept_hand_over(stages, walk, chunk) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
    return make_cell(stages, chunk, patch);
}

static uint16_t told(int64_t count) {
    return count < QNI_MOST_MADE ? (uint16_t)count : QNI_MOST_MADE;
}

/* What the chunk has that it had not before. */
static qni_leaf_made made_since(const qni_chunk *chunk, const qni_chunk *before) {
    const int64_t *now = (const int64_t *)&chunk->tally, *then = (const int64_t *)&before->tally;
    qni_leaf_made made = {
        .triangles = (uint32_t)(chunk->triangle_count - before->triangle_count),
        .apexes = told(chunk->apex_count - before->apex_count),
        .creases = told(chunk->crease_count - before->crease_count),
        .notes = (uint8_t)((chunk->veto_count > before->veto_count ? QNI_NOTED_VETO : 0) |
                           (chunk->trouble_count > before->trouble_count ? QNI_NOTED_TROUBLE : 0) |
                           (chunk->doubt_count > before->doubt_count ? QNI_NOTED_DOUBT : 0)),
    };
    for (int n = 0; n < QNI_TALLIES; ++n) {
        const int64_t more = now[n] - then[n];
        if (more > QNI_MOST_TALLY)
            made.notes |= QNI_NOT_KEPT;
        made.tally[n / 2] |= (uint8_t)((more & QNI_MOST_TALLY) << 4 * (n % 2));
    }
    return made;
}

static qn_status make_leaves(qni_stages *stages, qni_chunk *chunk, qni_kept_walk *walk) {
    qni_patch *patch = &stages->patches[qni_thread_index()];
    int64_t from = 0;
    if (!qni_stages_grow(stages, (void **)&chunk->made, &chunk->made_capacity,
                         chunk->leaf_end - chunk->leaf_first, sizeof *chunk->made))
        return QN_ERROR_OUT_OF_MEMORY;
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end; ++leaf) {
        const qni_chunk so_far = *chunk;
        const int64_t was = qni_leaf_before(stages, chunk, &stages->octree->leaves[leaf], &from);
        const bool may_keep = was >= 0 && qni_kept_skip_to(walk, was) &&
                              !(walk->before.made[was].notes & QNI_NOT_KEPT);
        QN_TRY(cell_of_leaf(stages, chunk, leaf, patch, may_keep ? walk : NULL));
        chunk->made[leaf - chunk->leaf_first] = made_since(chunk, &so_far);
    }
    return QN_OK;
}

void qni_chunk_cells(qni_stages *stages, int64_t index) {
    qni_chunk *chunk = &stages->chunks[index];
    if (chunk->make) {
        qni_kept_walk walk;
        qni_kept_start(chunk, &walk);
        chunk->status = make_leaves(stages, chunk, &walk);
        qni_kept_end(stages, &walk);
        qni_chunk_trim_made(stages, chunk);
    }
    chunk->before = stages->octree->leaves + chunk->leaf_first;
    chunk->before_count = chunk->leaf_end - chunk->leaf_first;
}

void qni_chunk_count_uses(qni_stages *stages, int64_t index) {
    const qni_chunk *chunk = &stages->chunks[index];
    for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end; ++leaf)
        gather_cell(stages, NULL, leaf, NULL);
}
