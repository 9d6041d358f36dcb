// SPDX-License-Identifier: MIT
/* Turning triangles: neighbours are made to agree, pieces that are inside out are turned. */
#include "solid/chain.h"

#include <string.h>

static const uint32_t nobody = UINT32_MAX;

typedef struct walk {
    qni_chain *chain;
    uint32_t *link; /* [3 count]: the side on the other side of an edge of two, or nobody */
    uint32_t *queue;
    uint8_t *seen, *flip; /* [count] */
} walk;

static int32_t way_of(const qni_chain *chain, uint32_t side) {
    uint32_t from = chain->triangles[side / 3][side % 3],
             to = chain->triangles[side / 3][(side + 1) % 3];
    return from < to ? 1 : -1;
}

static void link_sides(walk *way) {
    const qni_chain *chain = way->chain;
    for (int64_t n = 0; n < 3 * chain->count; ++n)
        way->link[n] = nobody;
    for (int64_t n = 0, end; n < 3 * chain->count; n = end) {
        for (end = n; end < 3 * chain->count && chain->edges[end].low == chain->edges[n].low &&
                      chain->edges[end].high == chain->edges[n].high;)
            ++end;
        if (end - n != 2)
            continue;
        way->link[chain->edges[n].side] = chain->edges[n + 1].side;
        way->link[chain->edges[n + 1].side] = chain->edges[n].side;
    }
}

static void free_walk(walk *way) {
    qn_context *context = way->chain->context;
    int64_t count = way->chain->count;
    qni_free(context, way->link, 3 * count, sizeof *way->link);
    qni_free(context, way->queue, count, sizeof *way->queue);
    qni_free(context, way->seen, count, 1);
    qni_free(context, way->flip, count, 1);
}

static bool start_walk(qni_chain *chain, walk *way) {
    *way = (walk){.chain = chain};
    way->link = qni_alloc(chain->context, 3 * chain->count, sizeof *way->link);
    way->queue = qni_alloc(chain->context, chain->count, sizeof *way->queue);
    way->seen = qni_alloc_zero(chain->context, chain->count, 1);
    way->flip = qni_alloc_zero(chain->context, chain->count, 1);
    if (way->link && way->queue && way->seen && way->flip) {
        link_sides(way);
        return true;
    }
    free_walk(way);
    return false;
}

/* The piece of a triangle, in the queue; flips are what agreement with the first one asks for. */
static int64_t collect_piece(walk *way, uint32_t start) {
    int64_t count = 0;
    way->queue[count++] = start;
    way->seen[start] = 1;
    for (int64_t n = 0; n < count; ++n) {
        uint32_t here = way->queue[n];
        for (uint32_t side = 3 * here; side < 3 * here + 3; ++side) {
            uint32_t other = way->link[side];
            if (other == nobody || way->seen[other / 3])
                continue;
            bool clash = way_of(way->chain, side) == way_of(way->chain, other);
            way->flip[other / 3] = way->flip[here] ^ clash;
            way->seen[other / 3] = 1;
            way->queue[count++] = other / 3;
        }
    }
    return count;
}

static void turn(qni_chain *chain, int64_t triangle) {
    uint32_t swap = chain->triangles[triangle][1];
    chain->triangles[triangle][1] = chain->triangles[triangle][2];
    chain->triangles[triangle][2] = swap;
}

static void area_vector(const qni_chain *chain, int64_t triangle, double out[3]) {
    double u[3], v[3];
    const float *a = chain->places[chain->triangles[triangle][0]],
                *b = chain->places[chain->triangles[triangle][1]],
                *c = chain->places[chain->triangles[triangle][2]];
    for (int k = 0; k < 3; ++k) {
        u[k] = (double)b[k] - (double)a[k];
        v[k] = (double)c[k] - (double)a[k];
    }
    for (int k = 0; k < 3; ++k)
        out[k] = 0.5 * (u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
}

static double length_of(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

bool qni_chain_orient(qni_chain *chain) {
    walk way;
    if (!start_walk(chain, &way))
        return false;
    for (int64_t n = 0; n < chain->count; ++n) {
        if (way.seen[n])
            continue;
        int64_t count = collect_piece(&way, (uint32_t)n);
        double kept = 0, vector[3];
        for (int64_t i = 0; i < count; ++i) {
            area_vector(chain, way.queue[i], vector);
            kept += way.flip[way.queue[i]] ? -length_of(vector) : length_of(vector);
        }
        for (int64_t i = 0; i < count; ++i)
            if (way.flip[way.queue[i]] == (kept >= 0)) {
                turn(chain, way.queue[i]);
                ++chain->turned;
            }
    }
    free_walk(&way);
    return qni_chain_find_edges(chain);
}

/* Volume of the cones from `middle`. */
static double cone(const qni_chain *chain, int64_t triangle, const double middle[3]) {
    double vector[3], sum = 0;
    area_vector(chain, triangle, vector);
    for (int k = 0; k < 3; ++k)
        sum += vector[k] * ((double)chain->places[chain->triangles[triangle][0]][k] - middle[k]);
    return sum / 3;
}

/* An open piece's rim is capped from its middle; a sheet, whose cap is as large as itself, has no
 * inside. */
static bool is_inside_out(const walk *way, int64_t count) {
    const qni_chain *chain = way->chain;
    double middle[3] = {0, 0, 0}, whole[3] = {0, 0, 0}, vector[3], area = 0, volume = 0;
    int64_t rim = 0;
    for (int64_t i = 0; i < count; ++i) {
        uint32_t triangle = way->queue[i];
        for (uint32_t side = 0; side < 3; ++side) {
            if (way->link[3 * triangle + side] != nobody)
                continue;
            ++rim;
            for (int k = 0; k < 3; ++k)
                middle[k] += (double)chain->places[chain->triangles[triangle][side]][k];
        }
        area_vector(chain, triangle, vector);
        area += length_of(vector);
        for (int k = 0; k < 3; ++k)
            whole[k] += vector[k];
    }
    if (rim == 0 || length_of(whole) > 0.25 * area)
        return false;
    for (int k = 0; k < 3; ++k)
        middle[k] /= (double)rim;
    for (int64_t i = 0; i < count; ++i)
        volume += cone(chain, way->queue[i], middle);
    return volume < 0;
}

bool qni_chain_turn_pieces(qni_chain *chain) {
    walk way;
    if (!start_walk(chain, &way))
        return false;
    for (int64_t n = 0; n < chain->count; ++n) {
        if (way.seen[n])
            continue;
        int64_t count = collect_piece(&way, (uint32_t)n);
        bool wrong = is_inside_out(&way, count);
        for (int64_t i = 0; wrong && i < count; ++i)
            turn(chain, way.queue[i]);
        chain->turned += wrong ? count : 0;
    }
    free_walk(&way);
    const double origin[3] = {0, 0, 0};
    double middle[3] = {0, 0, 0};
    for (int64_t n = 0; n < chain->count; ++n)
        for (int k = 0; k < 3; ++k)
            middle[k] += (double)chain->places[chain->triangles[n][0]][k] / (double)chain->count;
    chain->volume = 0;
    for (int64_t n = 0; n < chain->count; ++n)
        chain->volume += cone(chain, n, chain->rim_edges ? middle : origin);
    return qni_chain_find_edges(chain);
}

void qni_chain_turn_all(qni_chain *chain) {
    for (int64_t n = 0; n < chain->count; ++n)
        turn(chain, n);
    for (int64_t n = 0; n < 3 * chain->count; ++n)
        chain->edges[n].way = -chain->edges[n].way;
    chain->turned = chain->count - chain->turned;
    chain->volume = -chain->volume;
}
