// SPDX-License-Identifier: MIT
/* What the stages of one surface share: leaves in chunks; first all faces, then all cells, then the
 * mesh. */
#ifndef QNI_CMS_STAGES_H
#define QNI_CMS_STAGES_H

#include "cms/cms.h"

/* Where a leaf's own face segments are, in its chunk. */
typedef struct qni_leaf_faces {
    uint32_t first;
    uint8_t count[6];
} qni_leaf_faces;

/* A finest cell that did not come out well, or whose corner reaches into the empty cell beside it,
 * or that holds a tube.
 */
typedef struct qni_trouble {
    int32_t cell[3];
    int32_t bad; /* loops and segments */
    bool reaches, knows_corner, tube;
    bool several; /* creases that do not meet in one corner */
    float corner[3];
} qni_trouble;

/* The work on some leaves: those of a run of blocks, QNI_CHUNK of them or a little more, or as many
 * of the larger ones. Offsets come from sums over the chunks before. */
typedef struct qni_chunk {
    int64_t block_first, block_end; /* none: larger leaves */
    int64_t leaf_first, leaf_end;
    bool solve, make;      /* to be done in this round: faces, cells */
    qni_leaf_faces *faces; /* for each leaf */
    int64_t face_capacity;
    qni_segment *segments;
    int64_t segment_count, segment_capacity;
    qni_face_feature *features;
    int64_t feature_count, feature_capacity, feature_base;
    uint32_t (*triangles)[3];
    int32_t *owners; /* as long as triangles */
    int64_t triangle_count, triangle_capacity, owner_capacity, triangle_base;
    float (*apexes)[3];
    int64_t apex_count, apex_capacity, apex_base;
    uint32_t (*creases)[2];
    int64_t crease_count, crease_capacity, crease_base;
    qni_cell *vetoes; /* coarse leaves that must be divided */
    int64_t veto_count, veto_capacity;
    qni_trouble *troubles;
    int64_t trouble_count, trouble_capacity;
    int32_t (*doubts)[3]; /* finest cells whose creases do not lie where the solid's are */
    int64_t doubt_count, doubt_capacity;
    qni_cms_tally face_tally, cell_tally;
    qn_status status;
} qni_chunk;

typedef struct qni_stages {
    qn_context *context;
    const qni_hermite *hermite;
    const qni_octree *octree;
    qni_cms_settings settings;
    qni_chunk *chunks;
    int64_t chunk_count;
    uint32_t *chunk_of_leaf;
    int64_t leaf_count; /* as long as chunk_of_leaf */
    qni_face_feature
        *features; /* of all chunks, as they were solved; some may be of no use any more
                    */
    int64_t feature_count;
    int32_t (*close)[3]; /* finest cells whose faces are looked at closely; ascending z, y, x */
    int64_t close_count, close_capacity;
    int64_t skipped_steps; /* cells in doubt that were too many to be looked at */
    bool unite;            /* finest cells that do not come out well may be united with others */
    qni_unions unions;
    bool large_changed; /* leaves above the blocks were divided: their chunks are cut anew */
    bool renumbered;    /* chunks were solved anew: features do not lie in the chunks' order */
    qni_patch *patches; /* one for each thread */
    qni_face_solution *solutions;
    int32_t threads;
    qn_error *error;
} qni_stages;

/* Solve the faces that the chunk's leaves own; make the triangles of its cells (cells.c). */
void qni_chunk_faces(qni_stages *stages, int64_t chunk);
void qni_chunk_cells(qni_stages *stages, int64_t chunk);
/* Count anew which segments the chunk's cells use, after some chunks were made anew. */
void qni_chunk_recount(qni_stages *stages, int64_t chunk);

/* Hand over what a patch holds (emit.c). False when memory ran out. */
bool qni_chunk_emit(qni_stages *stages, qni_chunk *chunk, qni_patch *patch);
bool qni_stages_grow(qni_stages *stages, void **items, int64_t *capacity, int64_t wanted,
                     size_t size);
/* The loops of a leaf, or of a union of finest cells; then their apexes and triangles. A union's
 * loops may meet. */
qn_status qni_trace_patch(qni_stages *stages, qni_patch *patch, int64_t leaf,
                          const qni_cell_box *box, bool *closed);
qn_status qni_fill_patch(qni_patch *patch, qni_cms_tally *tally);
/* The n-th finest cell of a box, x fastest; false when there are no more. */
static inline bool qni_box_member(const qni_cell_box *box, int32_t n, qni_cell *cell) {
    const int32_t at[3] = {n % box->size[0], n / box->size[0] % box->size[1],
                           n / (box->size[0] * box->size[1])};
    for (int k = 0; k < 3; ++k)
        cell->low[k] = box->low[k] + at[k];
    cell->level = 0;
    return at[2] < box->size[2];
}

/* ---- rounds (rounds.c) --------------------------------------------------------------------------
 */

/* Leaves that must be divided, ascending but for the new ones: they did not come out well beside
 * finer ones. */
typedef struct qni_veto_list {
    qni_cell *items;
    int64_t count, added; /* in the last round */
} qni_veto_list;

/* Cut the leaves into chunks: the blocks as they were cut before, if they were. */
qn_status qni_stages_cut(qni_stages *stages);
/* Add what the chunks of this round say must be divided. */
qn_status qni_stages_gather_vetoes(qni_stages *stages, qni_veto_list *list);
/* Put the list in order, and mark the chunks that its new cells change, for another round. */
void qni_stages_divide(qni_stages *stages, qni_veto_list *list);
/* The chunk of the block that holds a finest cell; NULL where there is none. */
qni_chunk *qni_stages_chunk_at(const qni_stages *stages, const int32_t cell[3]);
/* Add cells to the list, as of this round. */
qn_status qni_stages_add_vetoes(qni_stages *stages, qni_veto_list *list, const qni_cell *cells,
                                int64_t count);
/* The chunks' memory. */
void qni_stages_free(qni_stages *stages);

/* The question for the octree of a later round: what was answered before is not asked again. */
typedef struct qni_remembered {
    qni_coarsening *coarsening;
    const qni_octree *before; /* NULL: none */
} qni_remembered;
bool qni_ask_remembered(void *user, const qni_cell *cell);

/* Mark the chunks that have, or make, faces of a finest cell. */
void qni_stages_mark_cell(qni_stages *stages, const int32_t low[3]);
void qni_stages_mark_made(qni_stages *stages);

/* ---- a closer look (closer.c)
 * ------------------------------------------------------------------------ */

/* Is a finest cell one of those whose faces are looked at closely? */
bool qni_is_close(const qni_stages *stages, const int32_t low[3]);
/* Add the cells whose creases are in doubt, and mark the chunks that this changes; how many are
 * new. */
qn_status qni_stages_look_closer(qni_stages *stages, int64_t *added);
void qni_close_free(qni_stages *stages);

/* ---- unions (unite.c) ---------------------------------------------------------------------------
 */

/* Unite finest cells that did not come out well with cells beside them where that helps, and mark
 * the chunks that this changes; or, with vetoes, add coarse leaves in the way to them, if there are
 * any, and unite nothing. */
qn_status qni_stages_unite(qni_stages *stages, qni_veto_list *vetoes);
void qni_unions_free(qni_stages *stages);

#endif
