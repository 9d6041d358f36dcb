// SPDX-License-Identifier: MIT
/* Vertices at which no two quads cross, by a proof. If there is a direction along which all quads
 * round a vertex are seen as convex and turned the same way, each fills an angle of less than half
 * a turn; if all of them fill one turn, none lies over another, however they are cut. The direction
 * is the sum of their areas. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/untangle.h"

#include <math.h>

enum { WORD = 64 };

/* What is known of the fan of quads round a vertex. */
typedef struct fan {
    int16_t direction[3]; /* may wrap: any direction will do that shows what is wanted */
    uint8_t turns;        /* angles that one ray across the direction lies in */
    uint8_t folded;       /* some quad is not seen as convex */
    uint32_t open;        /* 0 when the neighbours after and before the vertex are the same */
} fan;

typedef struct fan_search {
    qn_context *context;
    const qn_mesh_view *mesh;
    float unit; /* a cell's edge, about; world units */
    int32_t threads;
    fan *fans;             /* [vertex_count] */
    qni_vertex_set shared; /* quads at vertices of several threads */
} fan_search;

static inline void add_16(int16_t *to, int16_t more, bool shared) {
    if (shared)
        __atomic_fetch_add(to, more, __ATOMIC_RELAXED);
    else
        *to = (int16_t)(*to + more);
}

/* Twice the quad's area as a vector, to each of its corners. */
static void add_direction(const fan_search *s, const uint32_t *quad, bool shared) {
    const float scale = 128 / (s->unit * s->unit), most = 500, *p[4];
    float first[3], second[3];
    for (int k = 0; k < 4; ++k)
        p[k] = s->mesh->positions + 3 * (size_t)quad[k];
    for (int a = 0; a < 3; ++a) {
        first[a] = p[2][a] - p[0][a];
        second[a] = p[3][a] - p[1][a];
    }
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, d = (a + 2) % 3;
        const float part = scale * (first[b] * second[d] - first[d] * second[b]);
        const int16_t bounded = (int16_t)(part > most ? most : part > -most ? part : -most);
        for (int k = 0; k < 4; ++k)
            add_16(&s->fans[quad[k]].direction[a], bounded, shared);
    }
}

/* So that sums of different numbers differ. */
static inline uint32_t mix(uint32_t n) {
    n *= UINT32_C(0x9e3779b1);
    return (n ^ n >> 15) * UINT32_C(0x85ebca6b);
}

/* One number for each corner of a quad. */
typedef float four __attribute__((vector_size(16)));
typedef int32_t four_signs __attribute__((vector_size(16))); /* -1: true, 0: false */

/* A quad as its corners' vertices see it. */
typedef struct views {
    four on[3], back[3]; /* the ways to the corners after and before */
    four area[3];        /* twice that of each corner, as a vector */
    four direction[3];   /* of the vertices' fans */
    four sure;           /* products of area and direction that are surely positive */
} views;

static inline four size_of(four numbers) {
    return (four)((four_signs)numbers & INT32_MAX);
}

static inline views views_of(const fan_search *s, const uint32_t *quad) {
    views v;
    const float *p = s->mesh->positions;
    const float *p0 = p + 3 * (size_t)quad[0], *p1 = p + 3 * (size_t)quad[1],
                *p2 = p + 3 * (size_t)quad[2], *p3 = p + 3 * (size_t)quad[3];
    const int16_t *d0 = s->fans[quad[0]].direction, *d1 = s->fans[quad[1]].direction,
                  *d2 = s->fans[quad[2]].direction, *d3 = s->fans[quad[3]].direction;
    for (int a = 0; a < 3; ++a) {
        const float first = p1[a] - p0[a], second = p2[a] - p1[a], third = p3[a] - p2[a],
                    fourth = p0[a] - p3[a];
        v.on[a] = (four){first, second, third, fourth};
        v.back[a] = -(four){fourth, first, second, third};
        v.direction[a] = (four){d0[a], d1[a], d2[a], d3[a]};
    }
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, d = (a + 2) % 3;
        v.area[a] = v.on[b] * v.back[d] - v.on[d] * v.back[b];
    }
    const four squares = (v.on[0] * v.on[0] + v.on[1] * v.on[1]) + v.on[2] * v.on[2];
    const float most = (squares[0] + squares[1]) + (squares[2] + squares[3]);
    v.sure = 1e-5f * most * /* far more than rounding can do */
             ((size_of(v.direction[0]) + size_of(v.direction[1])) + size_of(v.direction[2]));
    return v;
}

/* Whether a vertex sees some corner of the quad as not convex. */
static inline four_signs folded_of(const views *v) {
    four_signs folded = {0, 0, 0, 0};
    for (int n = 0; n < 4; ++n)
        folded |= ~((v->area[0][n] * v->direction[0] + v->area[1][n] * v->direction[1]) +
                        v->area[2][n] * v->direction[2] >
                    v->sure);
    return folded;
}

/* Whether a ray from the vertex lies between the ways to the corners after and before it. The ray
 * stands across the direction, x, y, z across both: the sign along it tells what is on which side.
 * No where the direction is too near the one that the ray is made from. */
static inline four_signs turns_of(const views *v) {
    const four *d = v->direction;
    const four x = 0.36f * d[2] - 0.8f * d[1], y = 0.8f * d[0] - 0.48f * d[2],
               z = 0.48f * d[1] - 0.36f * d[0];
    const four ahead = (v->on[0] * x + v->on[1] * y) + v->on[2] * z,
               behind = (v->back[0] * x + v->back[1] * y) + v->back[2] * z;
    const four_signs far =
        (x * x + y * y) + z * z > 1e-4f * ((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]);
    const four nothing = {0, 0, 0, 0};
    return far & (ahead >= nothing) & (behind < nothing);
}

static void look_at_quad(const fan_search *s, const uint32_t *quad, bool shared) {
    const views v = views_of(s, quad);
    const four_signs folded = folded_of(&v), turns = turns_of(&v);
    const uint32_t mixed[4] = {mix(quad[0]), mix(quad[1]), mix(quad[2]), mix(quad[3])};
    for (int k = 0; k < 4; ++k) {
        fan *own = &s->fans[quad[k]];
        const uint32_t open = mixed[(k + 1) & 3] - mixed[(k + 3) & 3];
        if (shared) {
            __atomic_fetch_or(&own->folded, (uint8_t)-folded[k], __ATOMIC_RELAXED);
            __atomic_fetch_add(&own->turns, (uint8_t)-turns[k], __ATOMIC_RELAXED);
            __atomic_fetch_add(&own->open, open, __ATOMIC_RELAXED);
        } else {
            own->folded = (uint8_t)(own->folded | -folded[k]);
            own->turns = (uint8_t)(own->turns - turns[k]);
            own->open += open;
        }
    }
}

/* ---- all quads ------------------------------------------------------------------------------- */

/* The quads of a thread, and the vertices that it has for itself: about those that the quads have,
 * since both lie in the order of the leaves. */
typedef struct share {
    int64_t quad, end_quad, vertex, end_vertex;
} share;

/* The first quad of thread t, and the first vertex. */
static void start_share(const fan_search *s, int64_t t, int64_t *quad, int64_t *vertex) {
    const qn_mesh_view *mesh = s->mesh;
    const bool is_end = t == s->threads;
    *quad = is_end ? mesh->quad_count : mesh->quad_count / WORD * t / s->threads * WORD;
    *vertex = is_end ? mesh->vertex_count : t == 0 ? 0 : mesh->quads[4 * *quad + 2];
}

static share share_of(const fan_search *s, int64_t t) {
    share own;
    start_share(s, t, &own.quad, &own.vertex);
    start_share(s, t + 1, &own.end_quad, &own.end_vertex);
    for (int64_t before = 0; before < t; ++before) { /* a vertex is nobody else's */
        int64_t quad, vertex;
        start_share(s, before, &quad, &vertex);
        own.vertex = vertex > own.vertex ? vertex : own.vertex;
    }
    own.end_vertex = own.vertex > own.end_vertex ? own.vertex : own.end_vertex;
    return own;
}

static inline bool has_all(const share *own, const uint32_t *quad) {
    bool all = true;
    for (int k = 0; k < 4; ++k)
        all = all && quad[k] >= own->vertex && quad[k] < own->end_vertex;
    return all;
}

typedef void look_at(const fan_search *s, const uint32_t *quad, bool shared);

/* First each thread looks at quads whose corners are all its own, then all at the others. */
static void look_at_all(const fan_search *s, look_at *look) {
    const uint32_t *quads = s->mesh->quads;
    const int32_t threads = s->threads;
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int32_t t = 0; t < threads; ++t) {
        const share own = share_of(s, t);
        for (int64_t q = own.quad; q < own.end_quad; ++q)
            if (has_all(&own, quads + 4 * q))
                look(s, quads + 4 * q, false);
            else
                s->shared.bits[q / WORD] |= UINT64_C(1) << (q % WORD);
    }
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t word = 0; word <= s->shared.count / WORD; ++word)
        for (uint64_t left = s->shared.bits[word]; left; left &= left - 1)
            look(s, quads + 4 * (WORD * word + __builtin_ctzll(left)), true);
}

static void note_sound(const fan_search *s, const qni_vertex_set *sound) {
    const int64_t count = s->mesh->vertex_count;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(s->context))
    for (int64_t word = 0; word <= count / WORD; ++word)
        for (int64_t v = WORD * word; v < WORD * word + WORD && v < count; ++v) {
            const fan *own = s->fans + v;
            const bool is_sound = own->turns == 1 && !own->folded && own->open == 0;
            sound->bits[word] |= (uint64_t)is_sound << (v % WORD);
        }
}

qn_status qni_untangle_sound(qn_context *context, const qn_mesh_view *mesh, double unit,
                             const qni_vertex_set *sound, qn_error *error) {
    fan_search s = {.context = context,
                    .mesh = mesh,
                    .unit = (float)unit,
                    .threads = qn_context_threads(context)};
    s.fans = qni_alloc_zero(context, mesh->vertex_count, sizeof *s.fans);
    qn_status status = qni_vertex_set_alloc(context, mesh->quad_count, &s.shared, error);
    if (status == QN_OK && !s.fans)
        status = qni_fail_memory(error, "the search for crossings");
    if (status == QN_OK) {
        look_at_all(&s, add_direction);
        look_at_all(&s, look_at_quad);
        note_sound(&s, sound);
    }
    qni_vertex_set_free(context, &s.shared);
    qni_free(context, s.fans, mesh->vertex_count, sizeof *s.fans);
    return status;
}
