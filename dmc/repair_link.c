// SPDX-License-Identifier: MIT
/* The halfedges of split quads, of their neighbours, and of tunnels. */
#include "dmc/repair_parts.h"
#include "dmc/simplify_hd.h"

#include <string.h>

/* Old side k between its corners, or between the points before them. */
static int parts_of_side(const qni_quad_split *split, int k) {
    return qni_split_doubles(split, k) ? 3 : 1;
}

/* The halfedge of a part of old side k. */
static uint32_t part_halfedge(const qni_dmc *dmc, const qni_quad_split *split, int k, int part) {
    return qni_boundary_halfedge(dmc, split,
                                 qni_split_corner_at(split, k) + qni_split_cuts(split, k) + part);
}

static const qni_quad_split *split_of_quad(const qni_repair *repair, uint32_t quad) {
    int64_t low = 0, high = repair->split_count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (repair->splits[middle].quad < quad)
            low = middle + 1;
        else
            high = middle;
    }
    return low < repair->split_count && repair->splits[low].quad == quad ? repair->splits + low
                                                                         : NULL;
}

static void link_side(const qni_dmc *dmc, const qni_quad_split *split, int k, uint32_t *twins) {
    const int parts = parts_of_side(split, k);
    const uint32_t twin = split->twins[k];
    const qni_quad_split *other =
        twin == QN_NO_HALFEDGE ? NULL : split_of_quad(dmc->repair, twin / 4);
    for (int part = 0; part < parts; ++part) {
        const uint32_t own = part_halfedge(dmc, split, k, part);
        twins[own] = other ? part_halfedge(dmc, other, (int)(twin & 3), parts - 1 - part) : twin;
        if (!other && twin != QN_NO_HALFEDGE)
            twins[twin] = own;
    }
}

static void link_spokes(const qni_dmc *dmc, const qni_quad_split *split, uint32_t *twins) {
    const int fan = split->quads;
    for (int j = 0; j < fan; ++j) {
        const uint32_t out = (uint32_t)(4 * qni_fan_place(dmc, split, (j + 1) % fan));
        const uint32_t back = (uint32_t)(4 * qni_fan_place(dmc, split, j) + 3);
        twins[out] = back;
        twins[back] = out;
    }
}

/* Boundary vertices that are new, corners whose halfedge was the old quad's, and the centre. */
static void link_vertices(const qni_dmc *dmc, int64_t index, qn_mesh *mesh) {
    const qni_quad_split *split = dmc->repair->splits + index;
    for (int at = 0; at < qni_split_boundary_size(split); ++at) {
        const uint32_t h = qni_boundary_halfedge(dmc, split, at), vertex = mesh->quads[h];
        uint32_t *of_vertex = mesh->vertex_halfedges + vertex;
        if ((int64_t)vertex >= dmc->vertex_count &&
            (*of_vertex == QN_NO_HALFEDGE || mesh->twins[h] == QN_NO_HALFEDGE))
            *of_vertex = h;
    }
    for (int k = 0; k < 4; ++k) {
        const uint32_t h = qni_boundary_halfedge(dmc, split, qni_split_corner_at(split, k));
        uint32_t *of_vertex = mesh->vertex_halfedges + mesh->quads[h];
        if (qni_split_cuts(split, k) || *of_vertex == 4 * split->quad + (uint32_t)k)
            *of_vertex = h;
    }
    mesh->vertex_halfedges[qni_centre_vertex(dmc, index)] = 4 * split->quad;
}

/* A quad comes to its corners, or goes. Only vertices apart are counted: others have no such quad,
 * or are fixed. */
static void count_corners(const qni_dmc *dmc, const uint32_t corner[4], int change) {
    for (int k = 0; k < 4; ++k)
        if (dmc->valences[corner[k]] & QNI_VALENCE_APART)
            dmc->valences[corner[k]] = (uint8_t)(dmc->valences[corner[k]] + change);
}

void qni_repair_count_valences(const qni_dmc *dmc, const qn_mesh *mesh) {
    const int64_t made = dmc->repair ? dmc->repair->extra_vertices : 0,
                  splits = dmc->repair ? dmc->repair->split_count : 0;
    const qni_quad_split *split = dmc->repair ? dmc->repair->splits : NULL;
    memset(dmc->valences + dmc->vertex_count, QNI_VALENCE_APART, (size_t)made);
    memset(dmc->valences + dmc->vertex_count + made, QNI_VALENCE_FIXED,
           (size_t)(mesh->vertex_count - dmc->vertex_count - made)); /* the rim's */
    memset(dmc->colours + dmc->quad_count, QNI_COLOUR_APART,
           (size_t)(mesh->quad_count - dmc->quad_count));
    for (int64_t n = 0; n < 4 * splits; ++n) {
        uint8_t *valence = dmc->valences + split[n / 4].corners[n & 3];
        *valence |= *valence == QNI_VALENCE_FIXED ? 0 : QNI_VALENCE_APART;
    }
    for (int64_t n = 0; n < splits; ++n) {
        dmc->colours[split[n].quad] = QNI_COLOUR_APART;
        count_corners(dmc, split[n].corners, -1);
        count_corners(dmc, mesh->quads + 4 * (size_t)split[n].quad, 1);
    }
    for (int64_t q = dmc->quad_count; q < mesh->quad_count; ++q)
        count_corners(dmc, mesh->quads + 4 * q, 1);
}

void qni_repair_link(qni_dmc *dmc, qn_mesh *mesh) {
    qni_repair *repair = dmc->repair;
    for (int64_t v = dmc->vertex_count; v < dmc->vertex_count + repair->extra_vertices; ++v)
        mesh->vertex_halfedges[v] = QN_NO_HALFEDGE;
    for (int64_t n = 0; n < repair->split_count; ++n)
        memcpy(repair->splits[n].twins, mesh->twins + 4 * (size_t)repair->splits[n].quad,
               sizeof repair->splits[n].twins);
    for (int64_t n = 0; n < repair->split_count; ++n) {
        for (int k = 0; k < 4; ++k)
            link_side(dmc, repair->splits + n, k, mesh->twins);
        link_spokes(dmc, repair->splits + n, mesh->twins);
    }
    for (int64_t n = 0; n < repair->tunnel_count; ++n)
        qni_tunnel_link(dmc, n, mesh->twins);
    for (int64_t n = 0; n < repair->split_count; ++n) /* which reads all of their twins */
        link_vertices(dmc, n, mesh);
}
