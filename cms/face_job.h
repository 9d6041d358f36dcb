// SPDX-License-Identifier: MIT
/* What the files that solve one face share: its crossings, the lines of its trace, its bends. */
#ifndef QNI_CMS_FACE_JOB_H
#define QNI_CMS_FACE_JOB_H

#include "cms/cms.h"

/* The tangent of the surface's trace on the face, as a line in the face's axes. */
typedef struct qni_face_line {
    double at[2], normal[2]; /* a point of the surface; unit length in the face */
    double space_normal[3];
    int32_t owner;
} qni_face_line;

/* A crossing on the face's boundary. */
typedef struct qni_face_point {
    qni_face_line line;
    const qni_hermite_crossing *crossing;
    uint32_t number;
    int8_t side;
    bool enters; /* walking counter-clockwise */
} qni_face_point;

typedef struct qni_trace_memo qni_trace_memo;

typedef struct qni_face_job {
    const qni_hermite *hermite;
    const qn_solid *solid;
    const qni_cms_settings *settings;
    const qni_face *face;
    bool closely;                   /* steps are looked for, however low */
    int p, q;                       /* the face's axes */
    double low[2], high[2], height; /* height: the face's plane */
    double size;
    float low_float[2], high_float[2];
    qni_face_point points[QNI_FACE_POINTS];
    int count;
    int partner[QNI_FACE_POINTS];
    qni_trace_memo *memo;
} qni_face_job;

/* Lines one after the other, and where each meets the next. */
typedef struct qni_trace {
    qni_face_line lines[QNI_MOST_BENDS + 1];
    double bends[QNI_MOST_BENDS][2];
    int count;     /* of bends */
    bool verified; /* the solid's values say that every bend is on the surface */
} qni_trace;

/* What was found on the face so far (trace_memo.c). */
enum { QNI_MEMO_PAIRS = 16, QNI_MEMO_BENDS = 16 };

typedef struct qni_memo_pair {
    const qni_face_point *enter, *leave;
    qni_trace trace;
    bool found;
} qni_memo_pair;

typedef struct qni_memo_bend {
    qni_face_line first, second; /* asked for */
    qni_face_line between;       /* and answered */
    double bend[2];
    int kind;
} qni_memo_bend;

struct qni_trace_memo {
    int pair_count, bend_count; /* that ever were; the oldest give way */
    qni_memo_pair pairs[QNI_MEMO_PAIRS];
    qni_memo_bend bends[QNI_MEMO_BENDS];
};

void qni_trace_memo_start(qni_trace_memo *memo);
const qni_memo_bend *qni_memo_find_bend(const qni_trace_memo *memo, const qni_face_line *first,
                                        const qni_face_line *second);
qni_memo_bend *qni_memo_add_bend(qni_trace_memo *memo);

static inline double qni_dot2(const double a[2], const double b[2]) {
    return a[0] * b[0] + a[1] * b[1];
}

/* Does the way from -> to have the solid on its right, as the normal there says? */
static inline bool qni_runs_rightly(const double from[2], const double to[2],
                                    const double normal[2]) {
    return normal[1] * (to[0] - from[0]) - normal[0] * (to[1] - from[1]) > 0;
}

/* Do the normals of two crossings differ by more than the crease angle? */
bool qni_pair_is_sharp(const qni_face_job *job, const qni_face_point *a, const qni_face_point *b);
/* Of a bend, however smooth, each end lies on the same side of the other's tangent plane; of a step
 * it does not, which two creases make that no end knows of. How high that step is, in shares of its
 * length; 0 when it is none. */
double qni_line_step(const qni_face_job *job, const qni_face_line *a, const qni_face_line *b);
double qni_pair_step(const qni_face_job *job, const qni_face_point *a, const qni_face_point *b);
/* The trace between two crossings whose normals differ (trace.c; qni_face_trace() remembers it).
 * False when it is not found. No bends when the surface only curves. */
bool qni_trace_pair(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace);
/* The same by following the tangents of its ends only; and from part to part of the face, cut at
 * least so often (trace_parts.c). */
bool qni_trace_within(const qni_face_job *job, const qni_face_point *enter,
                      const qni_face_point *leave, qni_trace *trace);
bool qni_trace_by_parts(const qni_face_job *job, const qni_face_point *enter,
                        const qni_face_point *leave, int least_cuts, qni_trace *trace);
/* The same between two of like normals, where a step lies between them, however low: the face is
 * cut where the step is until it is high in its part. */
bool qni_trace_step(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace);
/* A point of the face in space; the tangent of the trace where the surface has a normal: false when
 * it lies in the face. */
void qni_face_to_space(const qni_face_job *job, const double at[2], double point[3]);
bool qni_face_set_line(const qni_face_job *job, const double at[3], const double normal[3],
                       qni_face_line *line);
bool qni_face_trace(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace);

/* Is there surface next to the middle of the chord between two crossings, alike to both? */
bool qni_pair_is_plain(const qni_face_job *job, const qni_face_point *enter,
                       const qni_face_point *leave);

/* Pair the crossings (pairing.c): neighbours, the first one with the next or the one before; or all
 * of them at the least cost. */
void qni_pair_neighbors(qni_face_job *job, int shift);
void qni_pair_by_cost(qni_face_job *job);
double qni_pairing_cost(const qni_face_job *job);
/* Of four crossings, does the inside hang together across the face, or the outside? False when
 * neither is found (face_way.c). */
bool qni_face_joins(const qni_face_job *job, bool *outside);
/* The rule on the values at the corners: are the outside corners joined? */
bool qni_outside_is_joined(const qni_face_job *job);

/* Do any two segments, or pieces of one, touch where they should not? Exact (touch.c). */
bool qni_segments_touch(const qni_face_job *job, const qni_face_solution *solution);

#endif
