// SPDX-License-Identifier: MIT
/* Small shapes for the tests of qn_mesh_check(), and checks that do not depend on threads. */
#ifndef TEST_CHECK_SHAPES_H
#define TEST_CHECK_SHAPES_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <qn/qn.h>
#include "core/context.h"

enum { MOST = 4096 };

/* A mesh under construction. */
typedef struct shape {
    int64_t vertex_count, quad_count, triangle_count;
    float positions[MOST][3];
    uint32_t quads[MOST][4], triangles[MOST][3];
} shape;

static inline uint32_t vertex(shape *s, double x, double y, double z) {
    s->positions[s->vertex_count][0] = (float)x;
    s->positions[s->vertex_count][1] = (float)y;
    s->positions[s->vertex_count][2] = (float)z;
    return (uint32_t)s->vertex_count++;
}

static inline void quad(shape *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const uint32_t q[4] = {a, b, c, d};
    memcpy(s->quads[s->quad_count++], q, sizeof q);
}

static inline void triangle(shape *s, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t t[3] = {a, b, c};
    memcpy(s->triangles[s->triangle_count++], t, sizeof t);
}

static inline shape *new_shape(void) {
    return calloc(1, sizeof(shape));
}

/* Corner numbers of a cube: bit 0 is x, bit 1 is y, bit 2 is z. */
static const uint32_t cube_quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

static inline void add_cube_faces(shape *s, const uint32_t corner[8]) {
    for (int f = 0; f < 6; ++f) {
        const uint32_t *q = cube_quads[f];
        quad(s, corner[q[0]], corner[q[1]], corner[q[2]], corner[q[3]]);
    }
}

static inline void add_cube(shape *s, double x, double y, double z, double side) {
    uint32_t corner[8];
    for (int i = 0; i < 8; ++i)
        corner[i] = vertex(s, x + side * (i & 1), y + side * ((i >> 1) & 1), z + side * (i >> 2));
    add_cube_faces(s, corner);
}

/* A tetrahedron of the corner at (x, y, z) and the three axes; its volume is side^3 / 6. */
static inline void add_tetrahedron(shape *s, double x, double y, double z, double side) {
    uint32_t o = vertex(s, x, y, z), a = vertex(s, x + side, y, z);
    uint32_t b = vertex(s, x, y + side, z), c = vertex(s, x, y, z + side);
    triangle(s, o, b, a);
    triangle(s, o, a, c);
    triangle(s, o, c, b);
    triangle(s, a, b, c);
}

/* Surface of the unit cubes (x, y, z) for which full() is true, vertices joined on the lattice. */
static inline void add_voxels(shape *s, int n, bool (*full)(int x, int y, int z)) {
    static uint32_t names[16][16][16];
    memset(names, 0xff, sizeof names);
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x)
                for (int f = 0; f < 6 && full(x, y, z); ++f) {
                    int step = f % 2 ? 1 : -1, axis = f / 2;
                    if (full(x + (axis == 0 ? step : 0), y + (axis == 1 ? step : 0),
                             z + (axis == 2 ? step : 0)))
                        continue;
                    uint32_t q[4];
                    for (int k = 0; k < 4; ++k) {
                        uint32_t c = cube_quads[f][k];
                        uint32_t *name = &names[z + (c >> 2)][y + ((c >> 1) & 1)][x + (c & 1)];
                        if (*name == UINT32_MAX)
                            *name = vertex(s, x + (int)(c & 1), y + (int)((c >> 1) & 1),
                                           z + (int)(c >> 2));
                        q[k] = *name;
                    }
                    quad(s, q[0], q[1], q[2], q[3]);
                }
}

static inline qn_mesh_report check_with_threads(const shape *s, int32_t threads) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = threads;
    qn_context *context;
    qn_mesh *mesh;
    qn_mesh_report report;
    qn_error error = {QN_OK, ""};
    const qn_mesh_view view = {s->vertex_count,
                               s->quad_count,
                               s->triangle_count,
                               s->positions[0],
                               NULL,
                               s->quads[0],
                               s->triangles[0],
                               "",
                               "",
                               NULL,
                               0,
                               NULL,
                               NULL};
    assert_int_equal(qn_context_create(&options, &context, &error), QN_OK);
    assert_int_equal(qn_mesh_create(context, &view, &mesh, &error), QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, &error), QN_OK);
    qn_mesh_destroy(mesh);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_destroy(context);
    return report;
}

/* Check a shape and free it. The report must not depend on the number of threads. */
static inline qn_mesh_report check(shape *s) {
    qn_mesh_report one = check_with_threads(s, 1), three = check_with_threads(s, 3);
    assert_memory_equal(&one, &three, sizeof one);
    free(s);
    return one;
}

static inline void assert_near(double a, double b) {
    assert_true(fabs(a - b) <= 1e-6 * fmax(1, fabs(b)));
}

static inline void assert_clean(const qn_mesh_report *r) {
    assert_true(r->closed && r->manifold && r->oriented);
    assert_int_equal(r->boundary_edges, 0);
    assert_int_equal(r->nonmanifold_edges, 0);
    assert_int_equal(r->nonmanifold_vertices, 0);
    assert_int_equal(r->orientation_conflicts, 0);
    assert_int_equal(r->degenerate_faces, 0);
    assert_int_equal(r->duplicate_faces, 0);
    assert_int_equal(r->duplicate_positions, 0);
    assert_int_equal(r->nonfinite_vertices, 0);
    assert_int_equal(r->unused_vertices, 0);
    assert_int_equal(r->self_intersections, 0);
    assert_int_equal(r->components, r->closed_components);
}

static inline void add_torus(shape *s, int around, int tube) {
    uint32_t first = (uint32_t)s->vertex_count;
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < tube; ++j) {
            double u = 2 * acos(-1.0) * i / around, v = 2 * acos(-1.0) * j / tube;
            vertex(s, (3 + cos(v)) * cos(u), (3 + cos(v)) * sin(u), sin(v));
        }
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < tube; ++j) {
            int k = (i + 1) % around, l = (j + 1) % tube;
            quad(s, first + i * tube + j, first + k * tube + j, first + k * tube + l,
                 first + i * tube + l);
        }
}

#endif
