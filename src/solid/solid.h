// SPDX-License-Identifier: MIT
/* A solid from inside: what octree and surfacers ask of it. f < 0 is inside. */
#ifndef QNI_SOLID_SOLID_H
#define QNI_SOLID_SOLID_H

#include <qn/solid.h>

typedef struct qni_box {
    double low[3], high[3];
} qni_box;

/* One place where a segment meets the surface. */
typedef struct qni_crossing {
    double at;        /* 0 to 1 along the segment from a to b */
    double normal[3]; /* unit length, out of the solid: the gradient of the branch that is active
                         there */
    int32_t owner;
    bool enters; /* going from a to b one comes into the solid here */
} qni_crossing;

/* All that a block of lattice cells can ask: signs at its points and crossings of its edges. */
enum { QNI_SCAN_CELLS = 8, QNI_SCAN_POINTS = 9 * 9 * 9, QNI_SCAN_EDGES = 3 * 512 };

typedef struct qni_block_scan {
    bool inside[QNI_SCAN_POINTS];          /* 81 z + 9 y + x */
    uint64_t crossed[QNI_SCAN_EDGES / 64]; /* edges with crossings, by their lower ends: 512 axis +
                                              64 z + 8 y + x */
    int32_t starts[QNI_SCAN_EDGES + 1];    /* of each edge's crossings, as `crossings` gives them */
    qni_crossing *crossings;
    int64_t count, capacity; /* to be freed */
} qni_block_scan;

/* Each kind of solid gives these; all are thread-safe, and all results are pure functions of the
 * arguments. */
typedef struct qni_solid_ops {
    void (*destroy)(qn_solid *solid);
    /* Values at points; QN_ERROR_CANCELLED when a callback stops. */
    qn_status (*values)(const qn_solid *solid, int64_t count, const double (*points)[3],
                        double *values);
    /* Gradients and owners of the active branch; outputs may be NULL. */
    qn_status (*gradients)(const qn_solid *solid, int64_t count, const double (*points)[3],
                           double (*gradients)[3], int32_t *owners);
    /* An enclosure of f over the box; -infinity .. infinity where nothing is known. */
    qn_status (*bounds)(const qn_solid *solid, const qni_box *box, double range[2]);
    /* All crossings of the segment a - b in ascending order, at most `capacity` of them; their
     * number goes to *count_out. Alternating `enters`; parity agrees with the signs at the ends (a
     * value of 0 is outside). The caller names the ends in one canonical order, so that everybody
     * gets the same bits. */
    qn_status (*crossings)(const qn_solid *solid, const double a[3], const double b[3],
                           int32_t capacity, qni_crossing *crossings, int32_t *count_out);
    /* A solid that agrees with this one inside the box and is cheaper there; may be the solid
     * itself with one more reference. */
    qn_status (*restrict_to)(const qn_solid *solid, const qni_box *box, qn_solid **solid_out);
    /* Bounds of the derivative of f along b - a on the segment a - b; true when they are known. May
     * be NULL. Bounds on one side of 0 say that f rises or falls all the way, so that the ends tell
     * all. */
    bool (*slope)(const qn_solid *solid, const double a[3], const double b[3], double range[2]);
    /* Which points have values below 0, where that costs less than the values. May be NULL. */
    qn_status (*inside)(const qn_solid *solid, int64_t count, const double (*points)[3],
                        bool *inside);
    /* Bounds of the derivatives of f by x, y and z in the box, so that f at the ends of an edge
     * says what can be between them; true when they are known and f is continuous there. May be
     * NULL. */
    bool (*slopes)(const qn_solid *solid, const qni_box *box, double ranges[3][2]);
    /* f and its gradient at one point, and the owner there, where that costs less than one after
     * the other. May be NULL. */
    qn_status (*first_order)(const qn_solid *solid, const double p[3], double *value,
                             double gradient[3], int32_t *owner);
    /* |f| at a point, or anything above `most` where it is more: of solids whose gradients have
     * length 1, and where that costs less than the sign does; false where it is not known. May be
     * NULL. */
    bool (*distance)(const qn_solid *solid, const double p[3], double most, double *distance_out);
    /* Whether f may change sign in the box, where that is known for less than bounds cost; false
     * when it is not. May be NULL. */
    bool (*changes)(const qn_solid *solid, const qni_box *box, bool *may_out);
    /* What points and edges between nine planes of each axis would answer one by one, where that is
     * known for less; *known_out is false where it is not. At most `most` crossings an edge. May be
     * NULL. */
    qn_status (*scan)(const qn_solid *solid, const double planes[3][9], int32_t most,
                      qni_block_scan *scan, bool *known_out);
} qni_solid_ops;

struct qn_solid {
    const qni_solid_ops *ops;
    qn_context *context;
    int64_t references; /* changed with atomic operations */
    qni_box box;    /* holds the solid; infinite for half-spaces and the like, low = high when it is
                       empty */
    int32_t depth;  /* levels of the tree below and with this one */
    int32_t weight; /* what a value costs, about: primitives below and with this one */
    bool narrows;   /* much smaller in a small box: restricted as fast as its bounds are found */
    int32_t owner;  /* of leaves: what gradients and crossings say */
    bool ends_in_box; /* nothing of it lies beyond the box, which else may be where to look only */
    bool direct;      /* it is restricted to a small box at once as well as step by step */
    bool listed; /* restricted, it is a list: one for 4^3 cells costs less than one for each cell */
};

/* The crossings of any solid whose values and bounds are all that is known: the segment is cut into
 * up to 32 pieces where the bounds leave the surface possible, and each change of sign is followed
 * to 1e-14 of the segment. Where bounds are not known, one crossing at most is found, from the
 * signs at the ends. */
qn_status qni_find_crossings(const qn_solid *solid, const double a[3], const double b[3],
                             int32_t capacity, qni_crossing *crossings, int32_t *count_out);

/* The one crossing of a segment along which f is known to rise or fall, from its values at the
 * ends, whose signs differ: what qni_find_crossings() gives there. */
qn_status qni_find_single(const qn_solid *solid, const double a[3], const double b[3],
                          const double values[2], qni_crossing *crossing);

/* Which points have values below 0, the cheapest way there is. */
qn_status qni_solid_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                           bool *inside);

/* f and its gradient at a point, and the owner there, the cheapest way there is. */
qn_status qni_solid_first_order(const qn_solid *solid, const double p[3], double *value,
                                double gradient[3], int32_t *owner);

qn_solid *qni_solid_retain(const qn_solid *solid);

/* The same solid with an infinite box: for one whose box says where to look, not where it ends.
 * NULL when memory runs out. */
qn_solid *qni_solid_boundless(qn_context *context, const qn_solid *part);

#endif
