// SPDX-License-Identifier: MIT
/* What the stages of one surface share: leaves in chunks; first all faces, then all cells, then the
 * mesh. */
#ifndef QNI_CMS_STAGES_H
#define QNI_CMS_STAGES_H

#include "cms/cms.h"

typedef struct qni_leaf_face {
    uint8_t count : 6; /* segments; none of a face that the leaf does not own */
    bool owned : 1;
    bool closely : 1; /* low steps were looked for */
} qni_leaf_face;

/* A leaf's own faces, and where their segments are in its chunk. */
typedef struct qni_leaf_faces {
    uint32_t first;
    qni_leaf_face at[6];
    uint8_t empty; /* of a finest cell: bits of faces that no leaf with surface lies across */
    uint8_t pass;  /* in which that changed, or the leaf is new */
} qni_leaf_faces;

/* What a leaf's cell made: its part of the chunk's arrays. */
enum { QNI_NOTED_VETO = 1, QNI_NOTED_TROUBLE = 2, QNI_NOTED_DOUBT = 4, QNI_NOT_KEPT = 8 };
enum { QNI_TALLIES = sizeof(qni_cms_tally) / sizeof(int64_t) };

typedef struct qni_leaf_made {
    uint32_t triangles;
    uint16_t apexes, creases; /* QNI_MOST_MADE: too many to be told, and what comes after is lost */
    uint8_t notes;
    uint8_t tally[(QNI_TALLIES + 1) / 2]; /* four bits each */
} qni_leaf_made;
enum { QNI_MOST_MADE = UINT16_MAX, QNI_MOST_TALLY = 15 };
static inline int qni_tally_of(const qni_leaf_made *made, int n) {
    return made->tally[n / 2] >> 4 * (n % 2) & QNI_MOST_TALLY;
}

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

/* A finest cell whose creases may not lie where the solid's are (closer.c). */
typedef struct qni_doubted {
    int32_t low[3];
    qni_doubt doubt;
} qni_doubted;

/* The work on some leaves: those of a run of blocks, QNI_CHUNK of them or a little more, or as many
 * of the larger ones. Offsets come from sums over the chunks before. */
typedef struct qni_chunk {
    int64_t block_first, block_end; /* none: larger leaves */
    int64_t leaf_first, leaf_end;
    const qni_cell *before; /* its leaves as they were when its cells were last made */
    int64_t before_count;
    bool solve, make;      /* to be done in this pass: faces, cells */
    qni_leaf_faces *faces; /* for each leaf */
    int64_t face_capacity;
    qni_leaf_made *made; /* for each leaf */
    int64_t made_capacity;
    qni_segment *segments;
    int64_t segment_count, segment_capacity;
    qni_face_feature *features; /* solved in this pass, until they go to those of all */
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
    qni_doubted *doubts;
    int64_t doubt_count, doubt_capacity;
    qni_cms_tally tally;
    qn_status status;
} qni_chunk;

typedef struct qni_stages {
    qn_context *context;
    const qni_hermite *hermite;
    const qni_octree *octree;
    qni_octree *octree_before; /* of the round before: its list of leaves, for the first pass */
    qni_cms_settings settings;
    qni_chunk *chunks;
    int64_t chunk_count;
    uint32_t *chunk_of_leaf;
    int64_t leaf_count; /* as long as chunk_of_leaf */
    uint8_t pass;       /* from 1: faces, then cells; at most 12 rounds of 1 + 6 looks, and 1 */
    qni_face_feature *features; /* of all faces, as they were solved; some may be of no use now */
    int64_t feature_count;
    int32_t (*close)[3]; /* finest cells whose faces are looked at closely; ascending z, y, x */
    int64_t close_count, close_capacity;
    int64_t skipped_steps; /* cells in doubt that were too many to be looked at */
    bool unite;            /* finest cells that do not come out well may be united with others */
    qni_unions unions;
    bool large_changed; /* leaves above the blocks were divided: their chunks are cut anew */
    qni_patch *patches; /* one for each thread */
    qni_face_solution *solutions;
    int32_t threads;
    qn_error *error;
} qni_stages;

/* Solve the faces that the chunk's leaves own and that are not as they were (leaf_faces.c); make
 * the triangles of its cells whose faces are not as they were (cells.c). */
void qni_chunk_faces(qni_stages *stages, int64_t chunk);
void qni_chunk_cells(qni_stages *stages, int64_t chunk);
/* Count which segments the chunk's cells use. */
void qni_chunk_count_uses(qni_stages *stages, int64_t chunk);
/* The place of a leaf among those before, from a place on; -1: it was none. Leaves that stay keep
 * their order. */
int64_t qni_leaf_before(const qni_stages *stages, const qni_chunk *chunk, const qni_cell *leaf,
                        int64_t *from);

/* What cells made before, walked through from leaf to leaf: skipped, or handed over again (kept.c).
 */
typedef struct qni_kept_walk {
    qni_chunk before; /* the chunk as it was */
    int64_t leaf, triangle, apex, crease, veto, trouble, doubt;
    bool lost; /* a leaf made too much for its numbers to be told */
} qni_kept_walk;
void qni_kept_start(qni_chunk *chunk, qni_kept_walk *walk);
/* False when what the leaf made is not known. */
bool qni_kept_skip_to(qni_kept_walk *walk, int64_t leaf);
bool qni_kept_hand_over(qni_stages *stages, qni_kept_walk *walk, qni_chunk *chunk);
void qni_kept_end(const qni_stages *stages, qni_kept_walk *walk);
/* Forget what a chunk's cells made; only what the mesh has no part of. */
void qni_chunk_free_made(qn_context *context, qni_chunk *chunk);
void qni_chunk_free_notes(qn_context *context, qni_chunk *chunk);
/* Give up room that its cells did not need, where that works. */
void qni_chunk_trim_made(qni_stages *stages, qni_chunk *chunk);

/* The mesh of all that the chunks hold, which goes on the way, as do the crossings (assemble.c). */
qn_status qni_stages_assemble(qni_stages *stages, qni_hermite *hermite, qn_mesh **mesh_out);

/* Hand over what a patch holds (emit.c). False when memory ran out. */
bool qni_chunk_emit(qni_stages *stages, qni_chunk *chunk, qni_patch *patch);
bool qni_stages_grow(qni_stages *stages, void **items, int64_t *capacity, int64_t wanted,
                     size_t size);
void qni_stages_trim(qni_stages *stages, void **items, int64_t *capacity, int64_t count,
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
/* The chunks' memory: of all but what the mesh is made of; all. */
void qni_stages_keep_shapes(qni_stages *stages);
void qni_stages_free(qni_stages *stages);

/* The question for the octree of a later round: what was answered before is not asked again. */
typedef struct qni_remembered {
    qni_coarsening *coarsening;
    const qni_octree *before; /* NULL: none */
} qni_remembered;
bool qni_ask_remembered(void *user, const qni_cell *cell);

/* Mark no chunks; those of a finest cell and of the cells beside it; and all that must then be
 * made.
 */
void qni_stages_mark_none(qni_stages *stages);
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
