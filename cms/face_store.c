// SPDX-License-Identifier: MIT
/* Faces that a question about leaves has solved, kept while the cells of one block are asked: two
 * cells share a face, and what it looks like is the same from both sides. */
#include "cms/cms.h"

#include <string.h>

static void keep(const qni_face_solution *solution, qni_kept_face *kept) {
    kept->known = true;
    kept->simple = solution->count <= QNI_KEPT_SEGMENTS &&
                   solution->feature_count <= QNI_KEPT_FEATURES && !solution->broken &&
                   !solution->dropped && !solution->unresolved;
    kept->count = kept->simple ? (int8_t)solution->count : 0;
    kept->feature_count = kept->simple ? (int8_t)solution->feature_count : 0;
    memcpy(kept->segments, solution->segments, sizeof *kept->segments * (size_t)kept->count);
    memcpy(kept->features, solution->features,
           sizeof *kept->features * (size_t)kept->feature_count);
}

/* Where a face of a cell of level 1 or 2 is kept: 240 and 36 of them touch a block. */
static int place_of(const qni_face *face, const int32_t block[3]) {
    const int p = face->axis == 0 ? 1 : 0, q = face->axis == 2 ? 1 : 2, level = face->level;
    int at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = (face->low[k] - 8 * block[k]) >> level;
    const int side = 8 >> level;
    return (level == 1 ? 0 : 240) +
           ((face->axis * (side + 1) + at[face->axis]) * side + at[p]) * side + at[q];
}

static void start_block(qni_face_store *store, const int32_t block[3]) {
    if (store->used && memcmp(store->block, block, sizeof store->block) == 0)
        return;
    memcpy(store->block, block, sizeof store->block);
    store->used = true;
    for (int n = 0; n < QNI_KEPT_FACES; ++n)
        store->faces[n].known = false;
}

const qni_kept_face *qni_face_store_solve(qni_face_store *store, const qni_patch *patch, int face) {
    const qni_face place = qni_face_of_cell(&patch->cell, face);
    qni_kept_face *kept = &store->other;
    kept->known = false;
    if (place.level == 1 || place.level == 2) {
        const int32_t block[3] = {patch->cell.low[0] >> 3, patch->cell.low[1] >> 3,
                                  patch->cell.low[2] >> 3};
        start_block(store, block);
        kept = &store->faces[place_of(&place, block)];
    }
    if (!kept->known) {
        qni_solve_face(patch->hermite, patch->solid, patch->settings, &place, false,
                       &store->solution);
        keep(&store->solution, kept);
    }
    return kept;
}
