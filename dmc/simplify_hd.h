// SPDX-License-Identifier: MIT
/* Removing quads by the valences of their corners ([DMC21] section 4): which quads may go, which of
 * two that meet goes first, and how the halfedges close up behind them.
 *
 *   3-X-3-Y        o---x---o                  o---x---o       The corners a and b of valence 3
 *              a'--a   q   b--b'   becomes  a'----v----b'     become one of valence 4; X and Y lose
 *                  o---y---o                  o---y---o       one each.
 *
 * X and Y are at least 5, so that no vertex ends below 4: from 4 a new one of valence 3 would arise
 * and the merging would run on along the row of quads, and from 3 one of valence 2, where two quads
 * share two sides.
 *
 *   3-3-3-3    The quad and its four neighbours become one quad; the neighbours' outer corners lose
 *              one each, so they need at least 4, and not all of them 4: then the new quad would be
 *              a 3-3-3-3 again, and a thin rod, whose end it is, would be eaten up ring by ring.
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
    QNI_QUAD_SHRINKS /* 3-3-3-3: the quad and the ring round it become one quad */
};

/* A vertex has one byte: its valence, and marks beside it. */
enum {
    QNI_VALENCE_FIXED = 0, /* stays as it is: at the boundary, where several fans meet, at the end
                              of a doubled edge that is kept */
    QNI_VALENCE_LARGEST = 60, /* larger ones count as fixed */
    QNI_VALENCE_MASK = 63,
    QNI_VALENCE_MERGED = 64, /* vertices were merged into this one */
    QNI_VALENCE_APART = 128, /* not as the grid alone makes them: link conditions must be checked */
    QNI_VALENCE_GONE = 255
};

/* A quad has one byte: its colour, then QNI_QUAD_GONE. Quads of the colours below QNI_COLOURS are
 * those of lattice edges along that axis. */
enum { QNI_COLOURS = 3, QNI_COLOUR_APART = 3, QNI_QUAD_GONE = 255 };

/* ---- halfedges ------------------------------------------------------------------------------- */

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

/* ---- kinds ----------------------------------------------------------------------------------- */

/* What the valences of four corners say, one in each byte and 0 to 127; without branches, since
 * most quads stay and which do not is hard to foresee. */
QN_HD_INLINE int qni_kind_of_valences(uint32_t four) {
    const uint32_t high = UINT32_C(0x80808080), other = four ^ UINT32_C(0x03030303);
    const uint32_t not_3 = (other + UINT32_C(0x7f7f7f7f)) & high;
    const uint32_t large = (four + UINT32_C(0x7b7b7b7b)) & high;
    const uint32_t even = UINT32_C(0x00800080), odd = UINT32_C(0x80008000);
    const int even_3 = (not_3 & even) == 0, odd_3 = (not_3 & odd) == 0;
    const int even_large = (large & even) == even, odd_large = (large & odd) == odd;
    return (even_3 & odd_large) * QNI_QUAD_MERGES_02 + (odd_3 & even_large) * QNI_QUAD_MERGES_13 +
           (even_3 & odd_3) * QNI_QUAD_SHRINKS;
}

QN_HD_INLINE int qni_is_merge(int kind) {
    return kind == QNI_QUAD_MERGES_02 || kind == QNI_QUAD_MERGES_13;
}

/* Whether the four bytes are valences of vertices as the grid makes them, as yet untouched. Then a
 * quad that merges by its valences needs no further look: corners of valence 3 are triangles, each
 * cutting one corner off its cell. Of the quad's lattice edge, in four cells of one layer, a and b
 * cut off an end each, so their third neighbours lie across the faces at those ends: in other
 * layers than the quad's corners, over different cells. So all that qni_may_merge() compares
 * differs. And the three lattice edges of a triangle have three axes, so quads of one colour never
 * share a corner of valence 3. */
QN_HD_INLINE int qni_are_plain(uint32_t four) {
    return (four & UINT32_C(0xc0c0c0c0)) == 0;
}

/* ---- link conditions --------------------------------------------------------------------------
 */

/* The corner that two quads share beside `own`; QNI_UNPAIRED when it is not just one. */
QN_HD_INLINE uint32_t qni_shared_corner(const uint32_t first[4], const uint32_t second[4],
                                        uint32_t own) {
    uint32_t found = QNI_UNPAIRED, count = 0;
    for (int k = 0; k < 4; ++k)
        for (int n = 0; n < 4; ++n)
            if (first[k] == second[n] && first[k] != own) {
                found = first[k];
                ++count;
            }
    return count == 1 ? found : QNI_UNPAIRED;
}

/* Merging a and b across x and y keeps the surface a manifold: all of the new vertex' neighbours
 * differ. (That also keeps away from doubled edges: their ends see one neighbour twice.) */
QN_HD_INLINE int qni_may_merge(uint32_t a, uint32_t b, uint32_t x, uint32_t y, uint32_t beyond_a,
                               uint32_t beyond_b) {
    return a != b && x != y && beyond_a != beyond_b && beyond_a != b && beyond_b != a &&
           beyond_a != x && beyond_a != y && beyond_b != x && beyond_b != y &&
           beyond_a != QNI_UNPAIRED && beyond_b != QNI_UNPAIRED;
}

QN_HD_INLINE int qni_has_corner(const uint32_t corner[4], uint32_t vertex) {
    return corner[0] == vertex || corner[1] == vertex || corner[2] == vertex || corner[3] == vertex;
}

/* Shrinking the ring between inner and outer corners keeps the surface a manifold, unless another
 * quad joins the same outer corners: those are four, and keep a valence of 3 (one of them 4). */
QN_HD_INLINE int qni_may_shrink(const uint32_t inner[4], const uint32_t outer[4],
                                const int valence[4]) {
    int spare = 0;
    for (int k = 0; k < 4; ++k) {
        spare |= valence[k] > 4;
        if (valence[k] < 4 || outer[k] == QNI_UNPAIRED || qni_has_corner(outer, inner[k]))
            return 0;
        for (int n = 0; n < k; ++n)
            if (outer[n] == outer[k])
                return 0;
    }
    return spare;
}

QN_HD_INLINE int qni_joins_all(const uint32_t corner[4], const uint32_t outer[4]) {
    return qni_has_corner(corner, outer[0]) && qni_has_corner(corner, outer[1]) &&
           qni_has_corner(corner, outer[2]) && qni_has_corner(corner, outer[3]);
}

/* ---- who goes first -------------------------------------------------------------------------- */

/* Spreads neighbouring numbers; different numbers stay different (each step can be undone). */
QN_HD_INLINE uint32_t qni_scatter(uint32_t n) {
    n = (n ^ (n >> 16)) * UINT32_C(0x7feb352d);
    n = (n ^ (n >> 15)) * UINT32_C(0x846ca68b);
    return n ^ (n >> 16);
}

/* Lower goes first: by colour, then by scattered number, so that local winners lie dense
 * everywhere. Merges hinder each other when they share a corner of valence 3, rings when they share
 * an outer corner. (Merges that share X or Y only do not: of the quads round X no two neighbours
 * go, so of at least 5 at least 3 stay.) Taking all in their turns, or those that come before all
 * they hinder, again and again, gives the same. */
QN_HD_INLINE uint64_t qni_turn_of(uint8_t colour, uint32_t quad) {
    return (uint64_t)colour << 32 | qni_scatter(quad);
}

/* ---- halfedges close up ---------------------------------------------------------------------- */

QN_HD_INLINE void qni_pair(uint32_t *twin, uint32_t g, uint32_t h) {
    twin[g] = h;
    twin[h] = g;
}

/* X or Y of a merge: when its halfedge was that quad's, it gets `beside`, which starts at it in the
 * quad next to it; that one stays, since it shares a corner of valence 3. So one merge at most
 * writes the halfedge. */
QN_HD_INLINE void qni_leave_vertex(uint32_t *vertex_halfedge, uint32_t vertex, uint32_t quad,
                                   uint32_t beside) {
#ifdef __CUDA_ARCH__
    volatile uint32_t *own = vertex_halfedge + vertex;
    if (*own >> 2 == quad)
        *own = beside;
#else
    uint32_t *own = vertex_halfedge + vertex;
    if (__atomic_load_n(own, __ATOMIC_RELAXED) >> 2 == quad)
        __atomic_store_n(own, beside, __ATOMIC_RELAXED);
#endif
}

/* The quad of side `ha` goes; the side starts at the corner a that is kept, x and y are the corners
 * after and before it. */
QN_HD_INLINE void qni_close_merge(uint32_t *twin, uint32_t *vertex_halfedge, uint32_t ha,
                                  uint32_t a, uint32_t x, uint32_t y) {
    const uint32_t hb = ha ^ 2, hx = qni_next_side(ha), hy = qni_next_side(hb);
    const uint32_t to_a = twin[ha], from_b = twin[hx], to_b = twin[hb], from_a = twin[hy];
    qni_pair(twin, to_a, from_b);
    qni_pair(twin, to_b, from_a);
    vertex_halfedge[a] = from_a;
    qni_leave_vertex(vertex_halfedge, x, ha >> 2, to_a);
    qni_leave_vertex(vertex_halfedge, y, ha >> 2, to_b);
}

/* A quad takes the place of the ring round it. */
QN_HD_INLINE void qni_close_ring(uint32_t *twin, uint32_t *vertex_halfedge, uint32_t quad,
                                 const uint32_t outer[4]) {
    uint32_t beyond[4];
    for (uint32_t k = 0; k < 4; ++k)
        beyond[k] = twin[twin[4 * quad + k] ^ 2];
    for (uint32_t k = 0; k < 4; ++k) {
        qni_pair(twin, 4 * quad + k, beyond[k]);
        vertex_halfedge[outer[k]] = 4 * quad + k;
    }
}

#endif
