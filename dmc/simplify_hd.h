// SPDX-License-Identifier: MIT
/* Removing quads by the valences of their corners ([DMC21] section 4): which quads may go, which of
 * two that meet goes first, and how the halfedges close up behind them.
 *
 *   3-X-3-Y        o---x---o                  o---x---o       The corners a and b of valence 3
 * become one of valence 4; X and a'--a   q   b--b'   becomes  a'----v----b'     Y lose one each. X
 * and Y are at least 5, so that no vertex ends o---y---o                  o---y---o       below 4:
 * from 4 a new one of valence 3 would arise and the merging would run on along the row of quads,
 * and from 3 one of valence 2, where two quads share two sides. 3-3-3-3    The quad and its four
 * neighbours become one quad; the neighbours' outer corners lose one each, so they need at least 4,
 * and not all of them 4: then the new quad would be a 3-3-3-3 again, and a thin rod, whose end it
 *              is, would be eaten up ring by ring.
 *
 * Which of them are done is decided for all first, and only then they are done, all at once: no two
 * of them share a vertex or a quad that both write. */
#ifndef QNI_DMC_SIMPLIFY_HD_H
#define QNI_DMC_SIMPLIFY_HD_H

#include "core/hd.h"

#include <stdint.h>

#define QNI_UNPAIRED UINT32_C(0xffffffff) /* as QN_NO_HALFEDGE */

enum qni_quad_kind {
    QNI_QUAD_STAYS,
    QNI_QUAD_MERGES_02, /* 3-X-3-Y: corners 0 and 2 have valence 3 */
    QNI_QUAD_MERGES_13,
    QNI_QUAD_SHRINKS, /* 3-3-3-3: the quad and the ring round it become one quad */
    QNI_KIND_MASK = 3,
    QNI_TAKEN = 16,    /* marks beside the kind: it will be done, */
    QNI_LEFT = 32,     /* it will not, for now, */
    QNI_PENDING = 128, /* the quad is to be looked at (the kind is not known) */
    QNI_QUAD_GONE = 255
};

enum { QNI_VALENCE_FIXED = 0, QNI_VALENCE_GONE = 255 };

/* Quads with their halfedges and marks; valence is QNI_VALENCE_FIXED at the boundary and where fans
 * meet. */
typedef struct qni_links {
    uint32_t *origin; /* [4 quads] */
    uint32_t *twin;
    uint32_t *vertex_halfedge;
    uint8_t *valence;
    uint8_t *kind;
    const uint8_t *colour; /* NULL: none */
} qni_links;

QN_HD_INLINE uint32_t qni_next_side(uint32_t h) {
    return (h & ~UINT32_C(3)) | ((h + 1) & 3);
}

QN_HD_INLINE uint32_t qni_previous_side(uint32_t h) {
    return (h & ~UINT32_C(3)) | ((h + 3) & 3);
}

/* The next halfedge that starts at the same vertex; QNI_UNPAIRED at the end of an open fan. */
QN_HD_INLINE uint32_t qni_next_round(const uint32_t *twin, uint32_t h) {
    return twin[qni_previous_side(h)];
}

/* The quads round a vertex, from its halfedge on; *closed tells whether they close. */
QN_HD_INLINE uint32_t qni_fan_size(const uint32_t *twin, uint32_t start, int *closed) {
    uint32_t count = 1, h = qni_next_round(twin, start);
    while (h != start && h != QNI_UNPAIRED) {
        h = qni_next_round(twin, h);
        ++count;
    }
    *closed = h == start;
    return count;
}

/* What the valences alone say; without branches, since most quads stay and which do not is hard to
 * foresee. */
QN_HD_INLINE int qni_kind_of_valences(int v0, int v1, int v2, int v3) {
    const int even_3 = (v0 == 3) & (v2 == 3), odd_3 = (v1 == 3) & (v3 == 3);
    const int even_large = (v0 >= 5) & (v2 >= 5), odd_large = (v1 >= 5) & (v3 >= 5);
    return (even_3 & odd_large) * QNI_QUAD_MERGES_02 + (odd_3 & even_large) * QNI_QUAD_MERGES_13 +
           (even_3 & odd_3) * QNI_QUAD_SHRINKS;
}

/* Of a vertex of valence 3, the neighbour that is no corner of the quad of its halfedge h. */
QN_HD_INLINE uint32_t qni_third_neighbour(const qni_links *links, uint32_t h) {
    return links->origin[links->twin[h] ^ 2];
}

/* Merging the corners of h and of the side opposite keeps the surface a manifold: all of the new
 * vertex' neighbours differ. (That also keeps away from doubled edges: their ends see one neighbour
 * twice.) */
QN_HD_INLINE int qni_may_merge(const qni_links *links, uint32_t h) {
    const uint32_t *origin = links->origin;
    const uint32_t opposite = h ^ 2, first = h & ~UINT32_C(3);
    const uint32_t a = origin[h], b = origin[opposite];
    const uint32_t x = origin[first | ((h + 1) & 3)], y = origin[first | ((h + 3) & 3)];
    const uint32_t beyond_a = qni_third_neighbour(links, h),
                   beyond_b = qni_third_neighbour(links, opposite);
    return a != b && x != y && beyond_a != beyond_b && beyond_a != b && beyond_b != a &&
           beyond_a != x && beyond_a != y && beyond_b != x && beyond_b != y;
}

/* The side of the ring that lies opposite side h of the quad in its middle, seen from the ring. */
QN_HD_INLINE uint32_t qni_outer_side(const qni_links *links, uint32_t h) {
    return links->twin[h] ^ 2;
}

QN_HD_INLINE int qni_has_corner(const uint32_t corner[4], uint32_t vertex) {
    return corner[0] == vertex || corner[1] == vertex || corner[2] == vertex || corner[3] == vertex;
}

/* Shrinking the ring round a quad keeps the surface a manifold: the outer corners are four, keep a
 * valence of 3 (one of them at least 4), and no quad outside joins the same four. */
QN_HD_INLINE int qni_may_shrink(const qni_links *links, uint32_t quad) {
    uint32_t outer[4];
    int spare = 0;
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t side = qni_outer_side(links, 4 * quad + k);
        outer[k] = links->origin[side];
        spare |= links->valence[outer[k]] > 4;
        if (links->valence[outer[k]] < 4 || links->origin[qni_next_side(side)] == outer[k])
            return 0;
        for (uint32_t n = 0; n < k; ++n)
            if (outer[n] == outer[k])
                return 0;
    }
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t inner = links->origin[4 * quad + k];
        const uint32_t beyond = links->twin[qni_outer_side(links, 4 * quad + k)] >> 2;
        const uint32_t *corner = links->origin + 4 * beyond;
        if (qni_has_corner(outer, inner) || beyond == quad ||
            (qni_has_corner(corner, outer[0]) && qni_has_corner(corner, outer[1]) &&
             qni_has_corner(corner, outer[2]) && qni_has_corner(corner, outer[3])))
            return 0;
    }
    return spare;
}

/* Of eight kinds in a word, the bytes that are neither QNI_QUAD_STAYS nor QNI_QUAD_GONE. */
QN_HD_INLINE uint64_t qni_live_kinds(uint64_t word) {
    const uint64_t gone = word >> 6 & UINT64_C(0x0101010101010101); /* no other kind has bit 6 */
    return word & ~(gone * 255);
}

/* What may happen to a quad as things stand. */
QN_HD_INLINE int qni_kind_of_quad(const qni_links *links, uint32_t quad) {
    const uint32_t *v = links->origin + 4 * quad;
    const uint8_t *valence = links->valence;
    const int kind =
        qni_kind_of_valences(valence[v[0]], valence[v[1]], valence[v[2]], valence[v[3]]);
    if (kind == QNI_QUAD_STAYS)
        return kind;
    if (kind == QNI_QUAD_SHRINKS)
        return qni_may_shrink(links, quad) ? kind : QNI_QUAD_STAYS;
    return qni_may_merge(links, 4 * quad + (uint32_t)(kind - QNI_QUAD_MERGES_02)) ? kind
                                                                                  : QNI_QUAD_STAYS;
}

/* ---- who goes first -------------------------------------------------------------------------- */

/* Spreads neighbouring numbers; different numbers stay different (each step can be undone). */
QN_HD_INLINE uint32_t qni_scatter(uint32_t n) {
    n = (n ^ (n >> 16)) * UINT32_C(0x7feb352d);
    n = (n ^ (n >> 15)) * UINT32_C(0x846ca68b);
    return n ^ (n >> 16);
}

/* Lower goes first: by colour, then by scattered number, so that local winners lie dense
 * everywhere. */
QN_HD_INLINE uint64_t qni_turn_of(const qni_links *links, uint32_t quad) {
    const uint64_t colour = links->colour ? links->colour[quad] : 0;
    return colour << 32 | qni_scatter(quad);
}

QN_HD_INLINE int qni_is_merge(int kind) {
    return kind == QNI_QUAD_MERGES_02 || kind == QNI_QUAD_MERGES_13;
}

/* Of the operations that must not be done together with this one: is one taken (then this one is
 * left), is one that goes before it still open (then this one stays open), or neither (then it is
 * taken)? Asked over and over, in any order and by any number of threads at once, this ends with
 * the same answers: those of taking all in their turns, one by one. */
typedef struct qni_rivals {
    uint64_t turn;
    int decision; /* the kind's marks: 0 open, QNI_TAKEN, QNI_LEFT */
} qni_rivals;

QN_HD_INLINE int qni_kind_now(const qni_links *links, uint32_t quad) {
#ifdef __CUDA_ARCH__
    return *(const volatile uint8_t *)(links->kind + quad);
#else
    return __atomic_load_n(links->kind + quad, __ATOMIC_RELAXED);
#endif
}

QN_HD_INLINE void qni_meet_rival(const qni_links *links, uint32_t quad, int kind,
                                 qni_rivals *rivals) {
    if (kind & QNI_LEFT)
        return;
    if (kind & QNI_TAKEN)
        rivals->decision = QNI_LEFT;
    else if (rivals->decision == QNI_TAKEN && qni_turn_of(links, quad) < rivals->turn)
        rivals->decision = 0;
}

/* Merges that share a corner of valence 3 lie side by side. (Those that share X or Y only do not
 * hinder each other: of the quads round X no two neighbours go, so of at least 5 at least 3 stay.)
 */
QN_HD_INLINE int qni_decide_merge(const qni_links *links, uint32_t quad) {
    qni_rivals rivals;
    rivals.turn = qni_turn_of(links, quad);
    rivals.decision = QNI_TAKEN;
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t other = links->twin[4 * quad + k] >> 2;
        const int kind = qni_kind_now(links, other);
        if (qni_is_merge(kind & QNI_KIND_MASK))
            qni_meet_rival(links, other, kind, &rivals);
    }
    return rivals.decision;
}

/* Rings that share an outer corner: from each quad round such a corner the middle of another ring
 * would lie across one of the two sides that the corner is not part of. */
QN_HD_INLINE int qni_decide_shrink(const qni_links *links, uint32_t quad) {
    qni_rivals rivals;
    rivals.turn = qni_turn_of(links, quad);
    rivals.decision = QNI_TAKEN;
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t start = qni_outer_side(links, 4 * quad + k);
        uint32_t h = start;
        do {
            for (uint32_t n = 1; n < 3; ++n) {
                const uint32_t across = links->twin[(h & ~UINT32_C(3)) | ((h + n) & 3)];
                if (across == QNI_UNPAIRED || across >> 2 == quad)
                    continue;
                const int kind = qni_kind_now(links, across >> 2);
                if ((kind & QNI_KIND_MASK) == QNI_QUAD_SHRINKS)
                    qni_meet_rival(links, across >> 2, kind, &rivals);
            }
            h = qni_next_round(links->twin, h);
        } while (h != start);
    }
    return rivals.decision;
}

/* ---- carrying out ---------------------------------------------------------------------------- */

QN_HD_INLINE void qni_pair(uint32_t *twin, uint32_t g, uint32_t h) {
    twin[g] = h;
    twin[h] = g;
}

/* One quad less round a vertex; several may say so at once. */
QN_HD_INLINE void qni_drop_valence(qni_links *links, uint32_t vertex) {
#ifdef __CUDA_ARCH__
    const size_t address = (size_t)(links->valence + vertex);
    atomicSub((unsigned *)(address & ~(size_t)3), 1u << (8 * (address & 3)));
#else
    __atomic_fetch_sub(links->valence + vertex, (uint8_t)1, __ATOMIC_RELAXED);
#endif
}

/* X or Y of a merge: one quad less, and when its halfedge was that quad's, it gets `beside`, which
 * starts at it in the quad next to it; that one stays, since it shares a corner of valence 3. So
 * one merge at most writes the halfedge. */
QN_HD_INLINE void qni_leave_vertex(qni_links *links, uint32_t quad, uint32_t beside) {
    const uint32_t vertex = links->origin[beside];
#ifdef __CUDA_ARCH__
    volatile uint32_t *own = links->vertex_halfedge + vertex;
    if (*own >> 2 == quad)
        *own = beside;
#else
    uint32_t *own = links->vertex_halfedge + vertex;
    if (__atomic_load_n(own, __ATOMIC_RELAXED) >> 2 == quad)
        __atomic_store_n(own, beside, __ATOMIC_RELAXED);
#endif
    qni_drop_valence(links, vertex);
}

/* Merge a quad's corners of valence 3 into the lower one of them, which is returned; *gone_out is
 * the other. Several merges may meet at X or Y. */
QN_HD_INLINE uint32_t qni_merge(qni_links *links, uint32_t quad, uint32_t *gone_out) {
    const uint32_t first =
        4 * quad + (uint32_t)((links->kind[quad] & QNI_KIND_MASK) - QNI_QUAD_MERGES_02);
    const uint32_t ha = links->origin[first] < links->origin[first ^ 2] ? first : first ^ 2,
                   hb = ha ^ 2;
    const uint32_t hx = qni_next_side(ha), hy = qni_next_side(hb);
    const uint32_t a = links->origin[ha], b = links->origin[hb];
    const uint32_t to_a = links->twin[ha], from_b = links->twin[hx], to_b = links->twin[hb],
                   from_a = links->twin[hy];
    links->origin[from_b] = a;
    links->origin[qni_next_side(to_b)] = a;
    qni_pair(links->twin, to_a, from_b);
    qni_pair(links->twin, to_b, from_a);
    links->valence[a] = 4;
    links->valence[b] = QNI_VALENCE_GONE;
    links->vertex_halfedge[a] = from_a;
    qni_leave_vertex(links, quad, to_a);
    qni_leave_vertex(links, quad, to_b);
    *gone_out = b;
    return a;
}

/* Let a quad take the place of the ring round it. */
QN_HD_INLINE void qni_shrink(qni_links *links, uint32_t quad) {
    uint32_t outer[4], beyond[4];
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t side = qni_outer_side(links, 4 * quad + k);
        outer[k] = links->origin[side];
        beyond[k] = links->twin[side];
        links->kind[side >> 2] = QNI_QUAD_GONE;
        links->valence[links->origin[4 * quad + k]] = QNI_VALENCE_GONE;
    }
    for (uint32_t k = 0; k < 4; ++k) {
        links->origin[4 * quad + k] = outer[k];
        qni_pair(links->twin, 4 * quad + k, beyond[k]);
        --links->valence[outer[k]];
        links->vertex_halfedge[outer[k]] = 4 * quad + k;
    }
}

#endif
