// SPDX-License-Identifier: MIT
/* Packs a mesh whose gone vertices and quads are marked, in place and in order: count, scan, move.
 * A vertex that was merged gets the new number of the one it was merged into. */
#include "dmc/simplify.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

/* What is read in order is asked for a page ahead: the processor does not look beyond one itself.
 */
enum { RUN_BITS = 8, RUN = 1 << RUN_BITS, GONE = 255, PAGE = 1024 };

/* For halfedges, how many quads go before quad n: base[n / RUN] + within[n]. So that the tables
 * stay in the cache, the byte takes the mark's place; that of n + 1 is one more when n is gone. */
typedef struct numbering {
    uint32_t *base;  /* [runs] */
    uint8_t *within; /* [count + 1]: what goes before it in its run */
    int64_t runs;
} numbering;

typedef struct packing {
    qn_mesh *mesh;
    int32_t parts;
    const uint8_t *vertex_marks;
    uint8_t *quad_marks;
    uint32_t *renumber;
    numbering quads;       /* where there are halfedges */
    int64_t (*part)[2][2]; /* [parts + 1]: vertices and quads before it, old and new */
} packing;

/* ---- numbers --------------------------------------------------------------------------------- */

static int64_t count_staying(const uint8_t *marks, int64_t from, int64_t end) {
    int64_t gone = 0;
    for (int64_t n = from; n < end;) {
        const int64_t stop = n + 128 < end ? n + 128 : end;
        uint8_t few = 0;
        for (; n < stop; ++n)
            few = (uint8_t)(few + (marks[n] == GONE));
        gone += few;
    }
    return end - from - gone;
}

static void find_parts(const packing *p) {
    const int32_t parts = p->parts;
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n <= parts; ++n) {
        const int64_t count[2] = {p->mesh->vertex_count, p->mesh->quad_count};
        const uint8_t *marks[2] = {p->vertex_marks, p->quad_marks};
        for (int i = 0; i < 2; ++i) {
            const int64_t from = count[i] / parts * n,
                          end = n == parts - 1 ? count[i] : from + count[i] / parts;
            p->part[n][i][0] = n == parts ? count[i] : from;
            p->part[n][i][1] = n == parts ? 0 : count_staying(marks[i], from, end);
        }
    }
    for (int i = 0; i < 2; ++i) {
        int64_t before = 0;
        for (int32_t n = 0; n <= parts; ++n) {
            const int64_t own = p->part[n][i][1];
            p->part[n][i][1] = before;
            before += own;
        }
    }
}

static inline uint32_t gone_before(const numbering *n, uint32_t quad) {
    return n->base[quad >> RUN_BITS] + n->within[quad];
}

static bool number_quads(qn_context *context, packing *p) {
    const int64_t count = p->mesh->quad_count;
    const int32_t threads = p->parts;
    numbering *n = &p->quads;
    uint32_t gone = 0;
    (void)threads;
    n->runs = count / RUN + 1;
    n->within = p->quad_marks;
    n->within[count] = 0;
    n->base = qni_alloc(context, n->runs, sizeof *n->base);
    if (!n->base)
        return false;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t run = 0; run < n->runs; ++run) {
        const int64_t end = (run + 1) * RUN < count + 1 ? (run + 1) * RUN : count + 1;
        uint32_t before = 0;
        for (int64_t at = run * RUN; at < end; ++at) {
            const bool goes = n->within[at] == GONE;
            n->within[at] = (uint8_t)before;
            before += goes;
        }
        n->base[run] = before;
    }
    for (int64_t run = 0; run < n->runs; ++run) {
        const uint32_t in_run = n->base[run];
        n->base[run] = gone;
        gone += in_run;
    }
    return true;
}

/* ---- moving ---------------------------------------------------------------------------------- */

static inline uint32_t side_anew(const numbering *n, uint32_t h) {
    return h == QN_NO_HALFEDGE ? h : h - 4 * gone_before(n, h >> 2);
}

/* The vertices of a run that stay together, from `from` to `to`, which is not beyond it. */
static void move_points(float *points, int64_t from, int64_t end, int64_t to) {
    __builtin_prefetch(points + 3 * from + PAGE);
    if (from != to)
        memmove(points + 3 * to, points + 3 * from, (size_t)(end - from) * 3 * sizeof *points);
}

/* A vertex that went gets the number of the one that was kept, which came before it; unless that is
 * gone too, and then no quad asks. */
static void follow_kept(const packing *p, int64_t v) {
    if (p->vertex_marks[p->renumber[v]] != GONE)
        p->renumber[v] = p->renumber[p->renumber[v]];
}

/* Each thread packs its part to the part's own start, and numbers its vertices. */
static void pack_vertices(const packing *p, int32_t part) {
    qn_mesh *mesh = p->mesh;
    const int64_t first = p->part[part][0][0], end = p->part[part + 1][0][0];
    int64_t number = p->part[part][0][1], to = first;
    for (int64_t v = first; v < end;) {
        const int64_t from = v;
        const uint8_t *gone = memchr(p->vertex_marks + v, GONE, (size_t)(end - v));
        for (const int64_t stop = gone ? gone - p->vertex_marks : end; v < stop; ++v)
            p->renumber[v] = (uint32_t)(number + v - from);
        number += v - from;
        move_points(mesh->positions, from, v, to);
        if (mesh->normals)
            move_points(mesh->normals, from, v, to);
        for (int64_t n = 0; mesh->twins && n < v - from; ++n)
            mesh->vertex_halfedges[to + n] = side_anew(&p->quads, mesh->vertex_halfedges[from + n]);
        to += v - from;
        for (; v < end && p->vertex_marks[v] == GONE; ++v)
            if (p->parts == 1)
                follow_kept(p, v);
    }
}

/* Where the one that was kept can be another thread's, it has its number only now. */
static void follow_all_kept(const packing *p, int32_t part) {
    for (int64_t v = p->part[part][0][0]; v < p->part[part + 1][0][0]; ++v)
        if (p->vertex_marks[v] == GONE)
            follow_kept(p, v);
}

static void pack_quads(const packing *p, int32_t part) {
    uint32_t *quads = p->mesh->quads;
    const uint32_t *renumber = p->renumber;
    const uint8_t *marks = p->quad_marks;
    const int64_t end = p->part[part + 1][1][0];
    int64_t to = p->part[part][1][0];
    for (int64_t q = to; q < end; ++q) {
        const uint32_t *v = quads + 4 * q;
        __builtin_prefetch(v + PAGE);
        const uint32_t moved[4] = {renumber[v[0]], renumber[v[1]], renumber[v[2]], renumber[v[3]]};
        memcpy(quads + 4 * to, moved, sizeof moved);
        to += marks[q] != GONE;
    }
}

/* The same with halfedges. */
static void pack_linked_quads(const packing *p, int32_t part) {
    uint32_t *quads = p->mesh->quads, *twins = p->mesh->twins;
    const uint32_t *renumber = p->renumber;
    const numbering numbers = p->quads;
    const int64_t end = p->part[part + 1][1][0];
    int64_t to = p->part[part][1][0];
    uint32_t before = gone_before(&numbers, (uint32_t)to);
    for (int64_t q = to; q < end; ++q) {
        const uint32_t *v = quads + 4 * q, *h = twins + 4 * q;
        __builtin_prefetch(v + PAGE);
        __builtin_prefetch(h + PAGE);
        const uint32_t next = gone_before(&numbers, (uint32_t)q + 1);
        const bool goes = next != before;
        before = next;
        if (goes)
            continue;
        const uint32_t corner[4] = {renumber[v[0]], renumber[v[1]], renumber[v[2]], renumber[v[3]]};
        const uint32_t twin[4] = {side_anew(&numbers, h[0]), side_anew(&numbers, h[1]),
                                  side_anew(&numbers, h[2]), side_anew(&numbers, h[3])};
        memcpy(quads + 4 * to, corner, sizeof corner);
        memcpy(twins + 4 * to, twin, sizeof twin);
        ++to;
    }
}

static void move_items(void *items, const int64_t part[2], int64_t count, size_t size) {
    if (items && part[0] != part[1])
        memmove((char *)items + (size_t)part[1] * size, (char *)items + (size_t)part[0] * size,
                (size_t)count * size);
}

static void close_up(const packing *p) {
    qn_mesh *mesh = p->mesh;
    for (int32_t n = 1; n < p->parts; ++n) {
        const int64_t *vertices = p->part[n][0], *quads = p->part[n][1];
        const int64_t vertex_count = p->part[n + 1][0][1] - vertices[1],
                      quad_count = p->part[n + 1][1][1] - quads[1];
        move_items(mesh->positions, vertices, vertex_count, 3 * sizeof(float));
        move_items(mesh->normals, vertices, vertex_count, 3 * sizeof(float));
        move_items(mesh->vertex_halfedges, vertices, vertex_count, sizeof(uint32_t));
        move_items(mesh->quads, quads, quad_count, 4 * sizeof(uint32_t));
        move_items(mesh->twins, quads, quad_count, 4 * sizeof(uint32_t));
    }
}

static void pack(const packing *p) {
    const int32_t parts = p->parts;
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n < parts; ++n)
        pack_vertices(p, n);
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n < parts; ++n)
        if (parts > 1)
            follow_all_kept(p, n);
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n < parts; ++n)
        if (p->mesh->twins)
            pack_linked_quads(p, n);
        else
            pack_quads(p, n);
    close_up(p);
}

qn_status qni_compact_mesh(qn_context *context, qn_mesh *mesh, const uint8_t *vertex_marks,
                           uint8_t *quad_marks, uint32_t *renumber, qn_error *error) {
    packing p = {.mesh = mesh,
                 .parts = qn_context_threads(context),
                 .vertex_marks = vertex_marks,
                 .quad_marks = quad_marks,
                 .renumber = renumber};
    p.part = qni_alloc(context, p.parts + 1, sizeof *p.part);
    if (p.part)
        find_parts(&p);
    if (!p.part || (mesh->twins && !number_quads(context, &p))) {
        qni_free(context, p.part, p.parts + 1, sizeof *p.part);
        return qni_fail_memory(error, "the numbers of a packed mesh");
    }
    pack(&p);
    const int64_t vertices = p.part[p.parts][0][1], quads = p.part[p.parts][1][1];
    mesh->vertex_slack += mesh->vertex_count - vertices;
    mesh->quad_slack += mesh->quad_count - quads;
    mesh->vertex_count = vertices;
    mesh->quad_count = quads;
    mesh->halfedge_count = mesh->twins ? 4 * quads : 0;
    qni_free(context, p.part, p.parts + 1, sizeof *p.part);
    qni_free(context, p.quads.base, p.quads.runs, sizeof *p.quads.base);
    return QN_OK;
}
