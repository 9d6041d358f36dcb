// SPDX-License-Identifier: MIT
/* Triangles of a polygon model as a chain: vertices joined by place, edges and how often they are
 * run along each way, orientation, and caps over the rims. */
#ifndef QNI_SOLID_CHAIN_H
#define QNI_SOLID_CHAIN_H

#include "solid/panel.h"

typedef struct qni_chain_edge {
    uint32_t low, high; /* vertices */
    uint32_t side;      /* 3 triangle + side; it runs from that corner to the next */
    int32_t way;        /* +1 from low to high, -1 back */
} qni_chain_edge;

typedef struct qni_chain {
    qn_context *context;
    int64_t vertex_count, count, capacity;
    float (*places)[3];       /* [vertex_count] */
    uint32_t (*triangles)[3]; /* [count] of different vertices */
    int32_t *owners;          /* [count] */
    qni_chain_edge *edges;    /* [3 count], those of the same two vertices together */
    int64_t joined, dropped;  /* vertices at an earlier one's place; triangles left out */
    int64_t rim_edges;        /* edges that do not cancel */
    int64_t odd_edges;        /* edges of an odd number of triangles */
    int64_t turned;
    double volume; /* signed, with caps from the middle of all */
} qni_chain;

/* From a mesh, quads split; triangles that repeat a place or are not finite are dropped. False: no
 * memory. */
bool qni_chain_from_mesh(qn_context *context, const qn_mesh_view *view, int32_t owner,
                         bool keep_owners, qni_chain *chain);
void qni_chain_free(qni_chain *chain);
/* Sort the edges and count rims. */
bool qni_chain_find_edges(qni_chain *chain);
void qni_chain_drop_edges(qni_chain *chain);
/* Turn triangles so that neighbours across edges of two agree, most of each piece's area staying as
 * it is. */
bool qni_chain_orient(qni_chain *chain);
/* Turn pieces (joined by edges) that are open but nearly closed, and inside out. */
bool qni_chain_turn_pieces(qni_chain *chain);
void qni_chain_turn_all(qni_chain *chain);
/* Close all rims by fans, each round the middle of a loop: `even` for parity (every edge then
 * belongs to an even number), else so that the ways cancel. Loops go to *loops_out. */
bool qni_chain_cap(const qni_chain *chain, bool even, qni_panel_tree *caps, int64_t *loops_out);
qni_panel qni_chain_panel(const qni_chain *chain, int64_t triangle);

#endif
