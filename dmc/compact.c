// SPDX-License-Identifier: MIT
/* Packs a mesh whose gone vertices and quads are marked, in place and in order: count, scan, move.
 * A vertex that was merged gets the new number of the one it was merged into. */
#include "dmc/dmc.h"
#include "dmc/simplify.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

/* What is read in order is asked for a page ahead: the processor does not look beyond one itself.
 */
enum { GONE = 255, PAGE = 1024 };

typedef struct packing {
    const qni_kernels *kernels;
    qn_mesh *mesh;
    int32_t parts;
    const uint8_t *vertex_marks, *quad_marks;
    uint32_t *renumber;
    uint32_t *sides_before; /* that go, before each quad that stays; where there are halfedges */
    int64_t (*part)[2][2];  /* [parts + 1]: vertices and quads before it, old and new */
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

static void number_sides(const packing *p, int32_t part) {
    const int64_t first = p->part[part][1][0], end = p->part[part + 1][1][0];
    uint32_t *restrict number = p->sides_before;
    p->kernels->number(p->quad_marks, first, end, (uint32_t)p->part[part][1][1], false, number);
    for (int64_t q = first; q < end; ++q)
        number[q] = 4 * ((uint32_t)q - number[q]);
}

/* ---- moving ---------------------------------------------------------------------------------- */

static inline uint32_t side_anew(const packing *p, uint32_t h) {
    return h == QN_NO_HALFEDGE ? h : h - p->sides_before[h >> 2];
}

/* Without branches on the marks, since which go is hard to foresee. */
static void move_halfedges(const packing *p, int64_t v, int64_t end) {
    uint32_t *halfedges = p->mesh->vertex_halfedges;
    for (int64_t to = v; v < end; ++v) {
        halfedges[to] = side_anew(p, halfedges[v]);
        to += p->vertex_marks[v] != GONE;
    }
}

/* Each thread packs its part to the part's own start, and numbers its vertices. */
static void pack_vertices(const packing *p, int32_t part) {
    const qn_mesh *mesh = p->mesh;
    const int64_t first = p->part[part][0][0], end = p->part[part + 1][0][0];
    const uint8_t *gone = memchr(p->vertex_marks + first, GONE, (size_t)(end - first));
    const int64_t stop = gone ? gone - p->vertex_marks : end;
    p->kernels->number(p->vertex_marks, first, end, (uint32_t)p->part[part][0][1], p->parts == 1,
                       p->renumber);
    p->kernels->squeeze(mesh->positions, p->vertex_marks, stop, end);
    if (mesh->normals)
        p->kernels->squeeze(mesh->normals, p->vertex_marks, stop, end);
    if (mesh->twins)
        move_halfedges(p, first, end);
}

/* Where the one that was kept can be another thread's, it has its number only now. */
static void follow_all_kept(const packing *p, int32_t part) {
    for (int64_t v = p->part[part][0][0]; v < p->part[part + 1][0][0]; ++v)
        if (p->vertex_marks[v] == GONE && p->vertex_marks[p->renumber[v]] != GONE)
            p->renumber[v] = p->renumber[p->renumber[v]];
}

static inline void pack_sides(const packing *p, int32_t part, bool linked) {
    uint32_t *quads = p->mesh->quads, *twins = p->mesh->twins;
    const uint32_t *renumber = p->renumber;
    const uint8_t *marks = p->quad_marks;
    const int64_t end = p->part[part + 1][1][0];
    int64_t to = p->part[part][1][0];
    for (int64_t q = to; q < end; ++q) {
        const uint32_t *v = quads + 4 * q, *h = linked ? twins + 4 * q : NULL;
        __builtin_prefetch(v + PAGE);
        const uint32_t moved[4] = {renumber[v[0]], renumber[v[1]], renumber[v[2]], renumber[v[3]]};
        memcpy(quads + 4 * to, moved, sizeof moved);
        if (linked) {
            __builtin_prefetch(h + PAGE);
            const uint32_t twin[4] = {side_anew(p, h[0]), side_anew(p, h[1]), side_anew(p, h[2]),
                                      side_anew(p, h[3])};
            memcpy(twins + 4 * to, twin, sizeof twin);
        }
        to += marks[q] != GONE;
    }
}

static void pack_quads(const packing *p, int32_t part) {
    if (p->mesh->twins)
        pack_sides(p, part, true);
    else
        pack_sides(p, part, false);
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
        if (p->sides_before)
            number_sides(p, n);
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n < parts; ++n)
        pack_vertices(p, n);
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n < parts; ++n)
        if (parts > 1)
            follow_all_kept(p, n);
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t n = 0; n < parts; ++n)
        pack_quads(p, n);
    close_up(p);
}

qn_status qni_compact_mesh(qn_context *context, qn_mesh *mesh, const uint8_t *vertex_marks,
                           const uint8_t *quad_marks, uint32_t *renumber, qn_error *error) {
    packing p = {.kernels = qni_choose_kernels(),
                 .mesh = mesh,
                 .parts = qn_context_threads(context),
                 .vertex_marks = vertex_marks,
                 .quad_marks = quad_marks,
                 .renumber = renumber};
    const int64_t numbered = mesh->twins ? mesh->quad_count : 0;
    p.part = qni_alloc(context, p.parts + 1, sizeof *p.part);
    p.sides_before = numbered > 0 ? qni_alloc(context, numbered, sizeof *p.sides_before) : NULL;
    const bool good = p.part && (p.sides_before || numbered == 0);
    if (good) {
        find_parts(&p);
        pack(&p);
        const int64_t vertices = p.part[p.parts][0][1], quads = p.part[p.parts][1][1];
        mesh->vertex_slack += mesh->vertex_count - vertices;
        mesh->quad_slack += mesh->quad_count - quads;
        mesh->vertex_count = vertices;
        mesh->quad_count = quads;
        mesh->halfedge_count = mesh->twins ? 4 * quads : 0;
    }
    qni_free(context, p.part, p.parts + 1, sizeof *p.part);
    qni_free(context, p.sides_before, numbered, sizeof *p.sides_before);
    return good ? QN_OK : qni_fail_memory(error, "the numbers of a packed mesh");
}
