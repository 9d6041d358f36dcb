// SPDX-License-Identifier: MIT
/* Sets of vertices, and the quads near them as a small mesh (untangle.h). */
#include "core/status.h"
#include "mesh/untangle.h"
#include "mesh/untangle_table.h"

#include <string.h>

enum { BITS_A_NEAR = 256, FACE_BLOCK = 16384 };

qn_status qni_vertex_set_alloc(qn_context *context, int64_t count, qni_vertex_set *set,
                               qn_error *error) {
    set->count = count;
    set->bits = qni_alloc_zero(context, count / 64 + 1, sizeof *set->bits);
    return set->bits ? QN_OK : qni_fail_memory(error, "the search for crossings");
}

void qni_vertex_set_free(qn_context *context, qni_vertex_set *set) {
    qni_free(context, set->bits, set->count / 64 + 1, sizeof *set->bits);
    set->bits = NULL;
}

int64_t qni_vertex_set_count(const qni_vertex_set *set) {
    int64_t count = 0;
    for (int64_t word = 0; word <= set->count / 64; ++word)
        count += __builtin_popcountll(set->bits[word]);
    return count;
}

/* ---- quads near a set of vertices -------------------------------------------------------------
 */

static void block_of(const double to_lattice[3][4], const float *position, int side,
                     int64_t block[3]) {
    double local[3];
    qni_local_place(to_lattice, position, local);
    for (int a = 0; a < 3; ++a)
        block[a] = qni_local_floor(local[a] / side);
}

/* The blocks round every vertex of the set. */
static void enter_blocks(const qn_mesh_view *mesh, const double to_lattice[3][4],
                         const qni_vertex_set *near, int side, qni_bit_table *table) {
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        if (!qni_in_set(near, v))
            continue;
        int64_t middle[3];
        block_of(to_lattice, mesh->positions + 3 * v, side, middle);
        for (int n = 0; n < 27; ++n) {
            const int64_t at[3] = {middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1,
                                   middle[2] + n / 9 - 1};
            qni_table_put(table, qni_mix_place(at));
        }
    }
}

static void take_near(qn_context *context, const qn_mesh_view *mesh, const double to_lattice[3][4],
                      int side, const qni_bit_table *table, qni_vertex_set *set) {
    (void)context;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int64_t word = 0; word <= mesh->vertex_count / 64; ++word) {
        uint64_t bits = 0;
        for (int64_t v = 64 * word; v < 64 * word + 64 && v < mesh->vertex_count; ++v) {
            int64_t block[3];
            block_of(to_lattice, mesh->positions + 3 * v, side, block);
            if (qni_table_has(table, qni_mix_place(block)))
                bits |= UINT64_C(1) << (v % 64);
        }
        set->bits[word] = bits;
    }
}

/* ---- parts ---------------------------------------------------------------------------------- */

typedef struct picker {
    qn_context *context;
    const qn_mesh_view *mesh;
    const qni_vertex_set *quads;    /* these; or NULL */
    const qni_vertex_set *vertices; /* and those at these; NULL: all */
    qni_vertex_set used, picked;    /* vertices; quads */
    uint32_t *before; /* by word of `used`: vertices of the part in the words before */
    int64_t *starts;  /* by block of quads: quads of the part in the blocks before */
    int64_t words, blocks;
} picker;

static bool picks(const picker *p, int64_t q) {
    const uint32_t *quad = p->mesh->quads + 4 * q;
    bool any = !p->vertices || (p->quads && qni_in_set(p->quads, q));
    for (int k = 0; k < 4 && !any; ++k)
        any = qni_in_set(p->vertices, quad[k]);
    return any;
}

/* Blocks are whole words of quads. */
static int64_t end_of_block(const picker *p, int64_t block) {
    const int64_t end = (block + 1) * FACE_BLOCK;
    return end < p->mesh->quad_count ? end : p->mesh->quad_count;
}

/* Counts what is picked, then turns counts into places. */
static void count_picked(picker *p, qni_mesh_part *part) {
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(p->context))
    for (int64_t block = 0; block < p->blocks; ++block) {
        int64_t count = 0;
        for (int64_t q = block * FACE_BLOCK; q < end_of_block(p, block); ++q) {
            const uint32_t *quad = p->mesh->quads + 4 * q;
            if (!picks(p, q))
                continue;
            ++count;
            p->picked.bits[q / 64] |= UINT64_C(1) << (q % 64);
            for (int k = 0; k < 4; ++k)
                __atomic_fetch_or(&p->used.bits[quad[k] / 64], UINT64_C(1) << (quad[k] % 64),
                                  __ATOMIC_RELAXED);
        }
        p->starts[block] = count;
    }
    for (int64_t block = 0; block < p->blocks; ++block) {
        const int64_t count = p->starts[block];
        p->starts[block] = part->quad_count;
        part->quad_count += count;
    }
    for (int64_t word = 0; word < p->words; ++word) {
        p->before[word] = (uint32_t)part->vertex_count;
        part->vertex_count += __builtin_popcountll(p->used.bits[word]);
    }
}

static uint32_t number_of(const picker *p, uint32_t vertex) {
    const uint64_t below = p->used.bits[vertex / 64] & ((UINT64_C(1) << (vertex % 64)) - 1);
    return p->before[vertex / 64] + (uint32_t)__builtin_popcountll(below);
}

static void fill_part(const picker *p, const qni_mesh_part *part) {
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(p->context))
    for (int64_t block = 0; block < p->blocks; ++block) {
        uint32_t *to = part->quads + 4 * p->starts[block];
        for (int64_t word = block * FACE_BLOCK / 64; 64 * word < end_of_block(p, block); ++word)
            for (uint64_t left = p->picked.bits[word]; left; left &= left - 1) {
                const uint32_t *quad = p->mesh->quads + 4 * (64 * word + __builtin_ctzll(left));
                for (int k = 0; k < 4; ++k)
                    *to++ = number_of(p, quad[k]);
            }
    }
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(p->context))
    for (int64_t word = 0; word < p->words; ++word) {
        int64_t to = p->before[word];
        for (uint64_t left = p->used.bits[word]; left; left &= left - 1, ++to) {
            const int64_t vertex = 64 * word + __builtin_ctzll(left);
            part->vertices[to] = (uint32_t)vertex;
            memcpy(part->positions + 3 * to, p->mesh->positions + 3 * vertex, 3 * sizeof(float));
        }
    }
}

static bool alloc_part(qn_context *context, qni_mesh_part *part) {
    part->vertices = qni_alloc(context, part->vertex_count, sizeof *part->vertices);
    part->positions = qni_alloc(context, part->vertex_count, 3 * sizeof *part->positions);
    part->quads = qni_alloc(context, part->quad_count, 4 * sizeof *part->quads);
    return part->vertices && part->positions && part->quads;
}

void qni_mesh_part_free(qn_context *context, qni_mesh_part *part) {
    qni_free(context, part->vertices, part->vertex_count, sizeof *part->vertices);
    qni_free(context, part->positions, part->vertex_count, 3 * sizeof *part->positions);
    qni_free(context, part->quads, part->quad_count, 4 * sizeof *part->quads);
    memset(part, 0, sizeof *part);
}

qn_status qni_mesh_part_of(qn_context *context, const qn_mesh_view *mesh,
                           const qni_vertex_set *quads, const qni_vertex_set *vertices,
                           qni_mesh_part *part, qn_error *error) {
    picker p = {.context = context, .mesh = mesh, .quads = quads, .vertices = vertices};
    memset(part, 0, sizeof *part);
    p.words = mesh->vertex_count / 64 + 1;
    p.blocks = mesh->quad_count / FACE_BLOCK + 1;
    QN_TRY(qni_vertex_set_alloc(context, mesh->vertex_count, &p.used, error));
    p.before = qni_alloc(context, p.words, sizeof *p.before);
    p.starts = qni_alloc(context, p.blocks, sizeof *p.starts);
    bool good = qni_vertex_set_alloc(context, mesh->quad_count, &p.picked, error) == QN_OK &&
                p.before && p.starts;
    if (good) {
        count_picked(&p, part);
        good = alloc_part(context, part);
        if (good)
            fill_part(&p, part);
        else
            qni_mesh_part_free(context, part);
    }
    qni_free(context, p.starts, p.blocks, sizeof *p.starts);
    qni_free(context, p.before, p.words, sizeof *p.before);
    qni_vertex_set_free(context, &p.picked);
    qni_vertex_set_free(context, &p.used);
    return good ? QN_OK : qni_fail_memory(error, "the search for crossings");
}

qn_status qni_mesh_part_all(qn_context *context, const qn_mesh_view *mesh, qni_mesh_part *part,
                            qn_error *error) {
    return qni_mesh_part_of(context, mesh, NULL, NULL, part, error);
}

qn_status qni_vertices_near(qn_context *context, const qn_mesh_view *mesh,
                            const double to_lattice[3][4], const qni_vertex_set *near, int reach,
                            qni_vertex_set *close, qn_error *error) {
    const int64_t most = INT64_C(1) << 27, wanted = qni_vertex_set_count(near) * BITS_A_NEAR;
    qni_bit_table table = {0, NULL};
    if (!qni_table_alloc(context, wanted < most ? wanted : most, &table))
        return qni_fail_memory(error, "the search for crossings");
    const qn_status status = qni_vertex_set_alloc(context, mesh->vertex_count, close, error);
    if (status == QN_OK) {
        enter_blocks(mesh, to_lattice, near, reach, &table);
        take_near(context, mesh, to_lattice, reach, &table, close);
    }
    qni_table_free(context, &table);
    return status;
}

qn_status qni_mesh_part_near(qn_context *context, const qn_mesh_view *mesh,
                             const double to_lattice[3][4], const qni_vertex_set *near, int reach,
                             qni_mesh_part *part, qn_error *error) {
    qni_vertex_set close;
    memset(part, 0, sizeof *part);
    QN_TRY(qni_vertices_near(context, mesh, to_lattice, near, reach, &close, error));
    const qn_status status = qni_mesh_part_of(context, mesh, NULL, &close, part, error);
    qni_vertex_set_free(context, &close);
    return status;
}
