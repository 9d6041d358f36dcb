// SPDX-License-Identifier: MIT
/* What the parts of simplification share: first merges (simplify_first.c), then the rounds on what
 * is left (simplify_rest.c), for which suspects are looked at (simplify_look.c). */
#ifndef QNI_DMC_SIMPLIFY_PARTS_H
#define QNI_DMC_SIMPLIFY_PARTS_H

#include "dmc/around.h"
#include "dmc/dmc.h"
#include "dmc/simplify.h"

/* Numbers of vertices or quads; room is reserved before a thread adds to its own. */
typedef struct qni_numbers {
    uint32_t *items;
    int64_t count, capacity;
} qni_numbers;

bool qni_numbers_reserve(qn_context *context, qni_numbers *numbers, int64_t more);
void qni_numbers_free(qn_context *context, qni_numbers *numbers);

typedef struct qni_simplifier {
    qn_context *context;
    qn_mesh *mesh;
    const qni_simplify_options *options;
    qni_around around;
    const qni_kernels *kernels;
    int32_t threads;
    qni_numbers suspects; /* quads that may have to go, ascending */
    qni_numbers rings;    /* more of them, only by the 3-3-3-3 pattern */
    qni_numbers kept;     /* vertices into which others were merged after the first merges */
    qni_simplify_report report;
    int64_t most_held;
} qni_simplifier;

/* Merge all that can be told from valences alone; suspects and rings are the other quads that may
 * go. */
qn_status qni_simplify_first(qni_simplifier *job, qn_error *error);
/* One round of merges or of rings among the suspects. */
qn_status qni_simplify_round(qni_simplifier *job, bool rings, qn_error *error);
/* [DMC21] section 4.1, steps 2 and 5, in place of the first merges. */
qn_status qni_simplify_as_paper(qni_simplifier *job, qn_error *error);

/* A quad that may go. */
typedef struct qni_candidate {
    uint64_t turn;
    uint32_t quad;
    uint32_t corner[4]; /* a, x, b, y of a merge; the outer corners of a ring */
    uint32_t ring[4];
    uint32_t beyond; /* on the other side of a ring, if guessed; or QNI_UNPAIRED */
    bool guessed;
    uint8_t valence[4]; /* of the outer corners, when it was looked at */
    uint8_t first;      /* which of the quad's corners a is */
} qni_candidate;

typedef struct qni_candidates {
    qni_candidate *items;
    int64_t count, capacity;
    bool failed;
} qni_candidates;

bool qni_candidates_add(qn_context *context, qni_candidates *list, const qni_candidate *item);
void qni_candidates_free(qn_context *context, qni_candidates *list);

/* What the valences say of a quad now; its corners as they are now. */
int qni_kind_now(const qni_around *around, uint32_t quad, uint32_t corner[4]);
/* Ask for what tells the quads round a vertex. */
void qni_expect_vertex(const qni_around *around, uint32_t vertex);
/* Of a stretch of suspects those that may go; those of the other pattern stay suspect, and are put
 * to the stretch's start: so many. */
int64_t qni_simplify_look(const qni_simplifier *job, uint32_t *suspects, int64_t count, bool rings,
                          qni_candidates *found);

/* Corners of a merged quad: a and b, of which a is kept, then X and Y. */
typedef struct qni_merged {
    uint32_t a, b, x, y;
} qni_merged;

/* Up to QNI_LANDINGS of them on the way to their places. */
typedef struct qni_placing {
    qni_merged merged[QNI_LANDINGS];
    int count;
    qni_landings landings;
    qni_approach approach;
} qni_placing;

/* Find where the vertices that were kept belong: in the middle between them and those that went,
 * and between X and Y; ask for what is needed to put them there, back onto the surface. */
void qni_simplify_start_placing(const qni_simplifier *job, qni_placing *placing);
/* Put them there; returns how many the surface was out of reach of. */
int64_t qni_simplify_end_placing(const qni_simplifier *job, qni_placing *placing);

/* Add the quads round vertices whose valence has come down to 3. */
qn_status qni_simplify_suspect_round(qni_simplifier *job, const qni_numbers *vertices,
                                     qn_error *error);
void qni_simplify_note_memory(qni_simplifier *job);

#endif
