// SPDX-License-Identifier: MIT
/* A face less a convex body: what is outside of its first plane; of the rest what is outside of the
 * second; and so on. So every piece is a convex polygon. */
#include "bench/cms/tetrahedra.h"

#include <math.h>

enum { CORNERS = 24, PIECES = 512 };

typedef struct piece {
    double at[CORNERS][3];
    int count;
} piece;

typedef struct pieces {
    piece items[PIECES];
    int count;
} pieces;

static double height(const double plane[4], const double p[3]) {
    return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] - plane[3];
}

/* The plane through the face opposite to a corner; the corner lies inside. */
static void plane_of(const double corners[4][3], int opposite, double plane[4]) {
    const double *a = corners[(opposite + 1) % 4], *b = corners[(opposite + 2) % 4],
                 *c = corners[(opposite + 3) % 4];
    double u[3], v[3], length = 0;
    for (int k = 0; k < 3; ++k) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
    }
    for (int k = 0; k < 3; ++k) {
        plane[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        length += plane[k] * plane[k];
    }
    length = sqrt(length);
    plane[3] = 0;
    for (int k = 0; k < 3; ++k) {
        plane[k] /= length;
        plane[3] += plane[k] * a[k];
    }
    if (height(plane, corners[opposite]) > 0)
        for (int k = 0; k < 4; ++k)
            plane[k] = -plane[k];
}

tetrahedra tetrahedra_random(test_random *random) {
    tetrahedra three;
    for (int n = 0; n < TETRAHEDRA; ++n) {
        double least;
        do {
            for (int c = 0; c < 4; ++c)
                for (int k = 0; k < 3; ++k)
                    three.corners[n][c][k] = 2 * test_random_unit(random) - 1;
            least = INFINITY;
            for (int c = 0; c < 4; ++c) {
                plane_of((const double(*)[3])three.corners[n], c, three.planes[n][c]);
                least = fmin(least, -height(three.planes[n][c], three.corners[n][c]));
            }
        } while (!(least > 0.1));
    }
    return three;
}

qn_solid *tetrahedra_solid(qn_context *context, const tetrahedra *three) {
    static const int64_t sizes[4] = {3, 3, 3, 3};
    static const int64_t faces[12] = {0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3};
    qn_solid *parts[TETRAHEDRA], *solid;
    for (int n = 0; n < TETRAHEDRA; ++n)
        assert_int_equal(qn_solid_polyhedron(context, 4, (const double(*)[3])three->corners[n], 4,
                                             sizes, faces, &parts[n], NULL),
                         QN_OK);
    assert_int_equal(qn_solid_union(context, TETRAHEDRA, parts, &solid, NULL), QN_OK);
    for (int n = 0; n < TETRAHEDRA; ++n)
        qn_solid_destroy(parts[n]);
    return solid;
}

static void put(piece *out, const double p[3]) {
    assert_true(out->count < CORNERS);
    memcpy(out->at[out->count++], p, sizeof out->at[0]);
}

/* Both sides of a plane. */
static void split(const piece *whole, const double plane[4], piece *inside, piece *outside) {
    inside->count = outside->count = 0;
    for (int n = 0; n < whole->count; ++n) {
        const double *a = whole->at[n], *b = whole->at[(n + 1) % whole->count];
        const double high = height(plane, a), next = height(plane, b);
        put(high < 0 ? inside : outside, a);
        if ((high < 0) == (next < 0))
            continue;
        double cut[3];
        for (int k = 0; k < 3; ++k)
            cut[k] = a[k] + high / (high - next) * (b[k] - a[k]);
        put(inside, cut);
        put(outside, cut);
    }
}

static void keep(pieces *list, const piece *one) {
    if (one->count < 3)
        return;
    assert_true(list->count < PIECES);
    list->items[list->count++] = *one;
}

static void subtract(const pieces *from, const double planes[4][4], pieces *rest) {
    rest->count = 0;
    for (int n = 0; n < from->count; ++n) {
        piece inside = from->items[n], outside, next;
        for (int k = 0; k < 4 && inside.count >= 3; ++k) {
            split(&inside, planes[k], &next, &outside);
            keep(rest, &outside);
            inside = next;
        }
    }
}

typedef struct soup {
    float positions[3 * TETRAHEDRA * 4 * PIECES][3];
    uint32_t triangles[TETRAHEDRA * 4 * PIECES][3];
    int64_t count;
} soup;

static void add_pieces(soup *all, const pieces *list) {
    for (int n = 0; n < list->count; ++n)
        for (int m = 1; m + 1 < list->items[n].count; ++m) {
            const int corners[3] = {0, m, m + 1};
            assert_true(all->count < TETRAHEDRA * 4 * PIECES);
            for (int c = 0; c < 3; ++c) {
                for (int k = 0; k < 3; ++k)
                    all->positions[3 * all->count + c][k] = (float)list->items[n].at[corners[c]][k];
                all->triangles[all->count][c] = (uint32_t)(3 * all->count + c);
            }
            ++all->count;
        }
}

test_distance_tree *tetrahedra_surface(qn_context *context, const tetrahedra *three) {
    pieces *list = test_alloc(2, sizeof *list), *rest = list + 1;
    soup *all = test_alloc(1, sizeof *all);
    all->count = 0;
    for (int n = 0; n < TETRAHEDRA; ++n)
        for (int face = 0; face < 4; ++face) {
            list->count = 1;
            list->items[0].count = 0;
            for (int c = 1; c < 4; ++c)
                put(&list->items[0], three->corners[n][(face + c) % 4]);
            for (int other = 0; other < TETRAHEDRA; ++other)
                if (other != n) {
                    subtract(list, (const double(*)[4])three->planes[other], rest);
                    *list = *rest;
                }
            add_pieces(all, list);
        }
    const qn_mesh_view view = {.vertex_count = 3 * all->count,
                               .triangle_count = all->count,
                               .positions = all->positions[0],
                               .triangles = all->triangles[0],
                               .space = "",
                               .unit = ""};
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    test_distance_tree *tree = test_distance_tree_create(mesh);
    qn_mesh_destroy(mesh);
    free(all);
    free(list);
    return tree;
}
