// SPDX-License-Identifier: MIT
/* Packs a mesh whose gone vertices and quads are marked, in place and in order: count, scan, move.
 * A new number is that of the run of 256 plus one byte, which takes the mark's place, so that the
 * tables stay in the cache. */
#include "dmc/simplify.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { RUN_BITS = 8, RUN = 1 << RUN_BITS, GONE = 255 };

/* New numbers: of n it is base[n / RUN] + within[n]; that of n + 1 is the same when n is gone. */
typedef struct numbering {
    uint32_t *base;  /* [runs] */
    uint8_t *within; /* [count + 1]: what stays before it in its run */
    int64_t count, runs, stay;
} numbering;

static uint32_t new_number(const numbering *n, uint32_t old) {
    return n->base[old >> RUN_BITS] + n->within[old];
}

static bool stays(const numbering *n, int64_t old) {
    return new_number(n, (uint32_t)old) != new_number(n, (uint32_t)(old + 1));
}

static bool number_anew(qn_context *context, uint8_t *marks, int64_t count, numbering *n) {
    const int32_t threads = qn_context_threads(context);
    n->count = count;
    n->runs = count / RUN + 1;
    n->within = marks;
    n->stay = 0;
    marks[count] = 0;
    n->base = qni_alloc(context, n->runs, sizeof *n->base);
    if (!n->base)
        return false;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t run = 0; run < n->runs; ++run) {
        const int64_t end = (run + 1) * RUN < count + 1 ? (run + 1) * RUN : count + 1;
        uint32_t before = 0;
        for (int64_t at = run * RUN; at < end; ++at) {
            const bool remains = marks[at] != GONE;
            marks[at] = (uint8_t)before;
            before += remains;
        }
        n->base[run] = before;
    }
    for (int64_t run = 0; run < n->runs; ++run) {
        const uint32_t in_run = n->base[run];
        n->base[run] = (uint32_t)n->stay;
        n->stay += in_run;
    }
    n->stay = new_number(n, (uint32_t)count);
    return true;
}

typedef struct packing {
    qn_mesh *mesh;
    numbering vertices, quads;
} packing;

static uint32_t side_anew(const packing *p, uint32_t h) {
    return h == QN_NO_HALFEDGE ? h : new_number(&p->quads, h >> 2) << 2 | (h & 3);
}

static void move_point(float *points, int64_t from, int64_t to) {
    const float x = points[3 * from], y = points[3 * from + 1], z = points[3 * from + 2];
    points[3 * to] = x;
    points[3 * to + 1] = y;
    points[3 * to + 2] = z;
}

/* Vertices [from, end) to `to` and on, which is not beyond `from`; how many stay. */
static int64_t pack_vertices(const packing *p, int64_t from, int64_t end, int64_t to) {
    qn_mesh *mesh = p->mesh;
    const int64_t first = to;
    for (int64_t v = from; v < end; ++v) {
        if (!stays(&p->vertices, v))
            continue;
        move_point(mesh->positions, v, to);
        if (mesh->normals)
            move_point(mesh->normals, v, to);
        mesh->vertex_halfedges[to++] = side_anew(p, mesh->vertex_halfedges[v]);
    }
    return to - first;
}

static int64_t pack_quads(const packing *p, int64_t from, int64_t end, int64_t to) {
    uint32_t *quads = p->mesh->quads, *twins = p->mesh->twins;
    const int64_t first = to;
    for (int64_t q = from; q < end; ++q) {
        if (!stays(&p->quads, q))
            continue;
        for (int64_t k = 0; k < 4; ++k) {
            quads[4 * to + k] = new_number(&p->vertices, quads[4 * q + k]);
            twins[4 * to + k] = side_anew(p, twins[4 * q + k]);
        }
        ++to;
    }
    return to - first;
}

static void move_items(void *items, int64_t from, int64_t count, int64_t to, size_t size) {
    if (items && from != to)
        memmove((char *)items + (size_t)to * size, (char *)items + (size_t)from * size,
                (size_t)count * size);
}

/* Each thread packs its part to the part's own start; then the parts close up. */
static void pack_parts(const packing *p, int32_t parts) {
    qn_mesh *mesh = p->mesh;
#pragma omp parallel for schedule(static, 1) num_threads(parts)
    for (int32_t part = 0; part < parts; ++part) {
        const int64_t v = mesh->vertex_count * part / parts, q = mesh->quad_count * part / parts;
        pack_vertices(p, v, mesh->vertex_count * (part + 1) / parts, v);
        pack_quads(p, q, mesh->quad_count * (part + 1) / parts, q);
    }
    for (int32_t part = 1; part < parts; ++part) {
        const int64_t v = mesh->vertex_count * part / parts,
                      v_end = mesh->vertex_count * (part + 1) / parts;
        const int64_t q = mesh->quad_count * part / parts,
                      q_end = mesh->quad_count * (part + 1) / parts;
        const int64_t to_v = new_number(&p->vertices, (uint32_t)v),
                      to_q = new_number(&p->quads, (uint32_t)q);
        const int64_t vertices = new_number(&p->vertices, (uint32_t)v_end) - to_v;
        const int64_t quads = new_number(&p->quads, (uint32_t)q_end) - to_q;
        move_items(mesh->positions, v, vertices, to_v, 3 * sizeof(float));
        move_items(mesh->normals, v, vertices, to_v, 3 * sizeof(float));
        move_items(mesh->vertex_halfedges, v, vertices, to_v, sizeof *mesh->vertex_halfedges);
        move_items(mesh->quads, q, quads, to_q, 4 * sizeof(uint32_t));
        move_items(mesh->twins, q, quads, to_q, 4 * sizeof(uint32_t));
    }
}

qn_status qni_compact_mesh(qn_context *context, qn_mesh *mesh, uint8_t *vertex_marks,
                           uint8_t *quad_marks, qn_error *error) {
    packing p = {.mesh = mesh};
    if (!number_anew(context, vertex_marks, mesh->vertex_count, &p.vertices) ||
        !number_anew(context, quad_marks, mesh->quad_count, &p.quads)) {
        qni_free(context, p.vertices.base, p.vertices.runs, sizeof *p.vertices.base);
        return qni_fail_memory(error, "the numbers of a packed mesh");
    }
    pack_parts(&p, qn_context_threads(context));
    mesh->vertex_slack += mesh->vertex_count - p.vertices.stay;
    mesh->quad_slack += mesh->quad_count - p.quads.stay;
    mesh->vertex_count = p.vertices.stay;
    mesh->quad_count = p.quads.stay;
    mesh->halfedge_count = 4 * p.quads.stay;
    qni_free(context, p.vertices.base, p.vertices.runs, sizeof *p.vertices.base);
    qni_free(context, p.quads.base, p.quads.runs, sizeof *p.quads.base);
    return QN_OK;
}
