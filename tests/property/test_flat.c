// SPDX-License-Identifier: MIT
/* Flat parts merged: solids of cubes, their faces divided finely and unevenly, turned and rounded
 * to floats, come down to the corners that their cubes tell, and nothing else changes. */
#include "core/context.h"
#include "lib/support.h"
#include "mesh/flat.h"

#include <math.h>
#include <string.h>

enum { SIDE = 4, PARTS = 3, LINES = SIDE * PARTS + 1, POINTS = LINES * LINES * LINES };

/* Which cubes of a grid are solid; nothing beyond. */
typedef struct cubes {
    bool solid[SIDE][SIDE][SIDE];
} cubes;

static bool is_solid(const cubes *c, int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < SIDE && y < SIDE && z < SIDE && c->solid[z][y][x];
}

/* Eight cubes round a corner of the grid. */
static int round_corner(const cubes *c, const int at[3]) {
    int bits = 0;
    for (int n = 0; n < 8; ++n)
        bits |= is_solid(c, at[0] - 1 + (n & 1), at[1] - 1 + (n >> 1 & 1), at[2] - 1 + (n >> 2))
                << n;
    return bits;
}

/* A corner of the solid, unless the cubes are the same on either side of it along some axis. */
static bool is_corner(int bits) {
    return bits != (bits >> 1 & 0x55) * 3 && bits != (bits >> 2 & 0x33) * 5 &&
           bits != (bits >> 4 & 0x0f) * 17;
}

/* Two cubes that have an edge in common alone are not. */
static bool may_be_manifold(const cubes *c) {
    int64_t any = 0;
    for (int n = 0; n < (SIDE + 1) * (SIDE + 1) * (SIDE + 1); ++n) {
        const int at[3] = {n % (SIDE + 1), n / (SIDE + 1) % (SIDE + 1),
                           n / (SIDE + 1) / (SIDE + 1)};
        const int bits = round_corner(c, at);
        any |= bits;
        for (int axis = 0; axis < 3; ++axis)
            for (int side = 0; side < 2; ++side) {
                const int p = 1 << (axis + 1) % 3, q = 1 << (axis + 2) % 3, own = side << axis;
                const int a = bits >> own & 1, b = bits >> (own | p) & 1, d = bits >> (own | q) & 1,
                          e = bits >> (own | p | q) & 1;
                if (a == e && b == d && a != b)
                    return false;
            }
    }
    return any != 0;
}

static void random_cubes(test_random *random, cubes *c) {
    const double share = 0.2 + 0.7 * test_random_unit(random);
    for (int n = 0; n < SIDE * SIDE * SIDE; ++n)
        c->solid[n / SIDE / SIDE][n / SIDE % SIDE][n % SIDE] = test_random_unit(random) < share;
}

static int64_t count_corners(const cubes *c) {
    int64_t count = 0;
    for (int n = 0; n < (SIDE + 1) * (SIDE + 1) * (SIDE + 1); ++n) {
        const int at[3] = {n % (SIDE + 1), n / (SIDE + 1) % (SIDE + 1),
                           n / (SIDE + 1) / (SIDE + 1)};
        count += is_corner(round_corner(c, at));
    }
    return count;
}

/* ---- the mesh -------------------------------------------------------------------------------- */

typedef struct model {
    double turn[3][3], move[3];
    double gap;             /* instead of the second layer of cubes along x, unless 0 */
    double lines[3][LINES]; /* where the cubes and their parts end */
    uint32_t vertex[POINTS];
    float positions[POINTS][3];
    int64_t vertices, triangles, creases;
    uint32_t corners[200000][3];
    int32_t owners[200000];
    uint32_t crease[200000][2];
} model;

static void random_turn(test_random *random, double turn[3][3]) {
    double q[4], square = 0;
    for (int k = 0; k < 4; ++k) {
        q[k] = test_random_gaussian(random);
        square += q[k] * q[k];
    }
    for (int k = 0; k < 4; ++k)
        q[k] /= sqrt(square);
    for (int r = 0; r < 3; ++r) {
        const int s = (r + 1) % 3, t = (r + 2) % 3;
        turn[r][r] = 1 - 2 * (q[s] * q[s] + q[t] * q[t]);
        turn[r][s] = 2 * (q[r] * q[s] - q[t] * q[3]);
        turn[r][t] = 2 * (q[r] * q[t] + q[s] * q[3]);
    }
}

static void start_model(test_random *random, model *m) {
    random_turn(random, m->turn);
    for (int k = 0; k < 3; ++k) {
        m->move[k] = test_random_unit(random) - 0.5;
        for (int n = 0; n < LINES; ++n)
            m->lines[k][n] =
                (double)n / PARTS + (n % PARTS ? 0.2 * (test_random_unit(random) - 0.5) : 0);
    }
    for (int n = 2 * PARTS; m->gap > 0 && n < LINES; ++n)
        m->lines[0][n] += m->gap - 1;
    memset(m->vertex, 0xff, sizeof m->vertex);
    m->vertices = m->triangles = m->creases = 0;
}

static uint32_t vertex_at(model *m, const int at[3]) {
    uint32_t *vertex = &m->vertex[(at[2] * LINES + at[1]) * LINES + at[0]];
    if (*vertex == UINT32_MAX) {
        *vertex = (uint32_t)m->vertices;
        for (int r = 0; r < 3; ++r) {
            double place = m->move[r];
            for (int k = 0; k < 3; ++k)
                place += m->turn[r][k] * m->lines[k][at[k]];
            m->positions[m->vertices][r] = (float)place;
        }
        ++m->vertices;
    }
    return *vertex;
}

/* One part of a cube's face, split along either diagonal. */
static void add_square(test_random *random, model *m, const int low[3], int axis, bool up) {
    const int p = (axis + (up ? 1 : 2)) % 3, q = (axis + (up ? 2 : 1)) % 3;
    uint32_t v[4];
    for (int n = 0; n < 4; ++n) {
        int at[3] = {low[0], low[1], low[2]};
        at[p] += n == 1 || n == 2;
        at[q] += n >= 2;
        v[n] = vertex_at(m, at);
    }
    const int turn = test_random_unit(random) < 0.5;
    for (int n = 0; n < 2; ++n) {
        uint32_t *corner = m->corners[m->triangles];
        corner[0] = v[turn + 2 * n];
        corner[1] = v[(turn + 2 * n + 1) % 4];
        corner[2] = v[(turn + 2 * n + 2) % 4];
        m->owners[m->triangles++] = 2 * axis + up;
    }
}

static void add_face(test_random *random, model *m, const int cube[3], int axis, bool up) {
    const int p = (axis + 1) % 3, q = (axis + 2) % 3;
    for (int n = 0; n < PARTS * PARTS; ++n) {
        int low[3];
        low[axis] = PARTS * (cube[axis] + up);
        low[p] = PARTS * cube[p] + n % PARTS;
        low[q] = PARTS * cube[q] + n / PARTS;
        add_square(random, m, low, axis, up);
    }
}

/* Edges between owners, once each. */
static void add_creases(model *m, const qn_mesh *mesh) {
    for (int64_t h = 0; h < 3 * mesh->triangle_count; ++h) {
        const uint32_t twin = mesh->twins[h];
        if (twin == QN_NO_HALFEDGE || twin < h ||
            mesh->triangle_owners[h / 3] == mesh->triangle_owners[twin / 3])
            continue;
        m->crease[m->creases][0] = mesh->triangles[h];
        m->crease[m->creases++][1] = mesh->triangles[twin];
    }
}

static qn_mesh *mesh_of(qn_context *context, test_random *random, const cubes *c, model *m) {
    start_model(random, m);
    for (int n = 0; n < SIDE * SIDE * SIDE; ++n) {
        const int cube[3] = {n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE};
        for (int face = 0; is_solid(c, cube[0], cube[1], cube[2]) && face < 6; ++face) {
            int beside[3] = {cube[0], cube[1], cube[2]};
            beside[face / 2] += face & 1 ? 1 : -1;
            if (!is_solid(c, beside[0], beside[1], beside[2]))
                add_face(random, m, cube, face / 2, face & 1);
        }
    }
    qn_mesh *mesh;
    assert_int_equal(qni_mesh_alloc(context, m->vertices, 0, m->triangles, false, &mesh, NULL),
                     QN_OK);
    memcpy(mesh->positions, m->positions, (size_t)m->vertices * sizeof *m->positions);
    memcpy(mesh->triangles, m->corners, (size_t)m->triangles * sizeof *m->corners);
    mesh->triangle_owners = qni_alloc(context, m->triangles, sizeof *mesh->triangle_owners);
    memcpy(mesh->triangle_owners, m->owners, (size_t)m->triangles * sizeof *m->owners);
    assert_int_equal(qn_mesh_build_halfedges(context, mesh, NULL), QN_OK);
    add_creases(m, mesh);
    qni_mesh_free_halfedges(mesh);
    mesh->crease_edges = qni_alloc(context, m->creases, 2 * sizeof *mesh->crease_edges);
    memcpy(mesh->crease_edges, m->crease, (size_t)m->creases * sizeof *m->crease);
    mesh->crease_edge_count = m->creases;
    return mesh;
}

static qn_mesh_report check(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    return report;
}

static bool is_clean(const qn_mesh_report *report) {
    return report->closed && report->manifold && report->oriented &&
           report->self_intersections == 0 && report->degenerate_faces == 0;
}

/* Length of all crease edges, and area of each owner. */
static void measure(const qn_mesh *mesh, double *length, double area[6]) {
    const float *p = mesh->positions;
    *length = 0;
    memset(area, 0, 6 * sizeof *area);
    for (int64_t n = 0; n < mesh->crease_edge_count; ++n) {
        double square = 0;
        for (size_t k = 0; k < 3; ++k)
            square += pow((double)p[3 * (size_t)mesh->crease_edges[2 * n] + k] -
                              (double)p[3 * (size_t)mesh->crease_edges[2 * n + 1] + k],
                          2);
        *length += sqrt(square);
    }
    for (int64_t t = 0; t < mesh->triangle_count; ++t) {
        double a[3], b[3], square = 0;
        for (size_t k = 0; k < 3; ++k) {
            const double o = (double)p[3 * (size_t)mesh->triangles[3 * t] + k];
            a[k] = (double)p[3 * (size_t)mesh->triangles[3 * t + 1] + k] - o;
            b[k] = (double)p[3 * (size_t)mesh->triangles[3 * t + 2] + k] - o;
        }
        for (int k = 0; k < 3; ++k)
            square += pow(a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3], 2);
        area[mesh->triangle_owners[t]] += 0.5 * sqrt(square);
    }
}

/* What merging must not change, and what it must come to. */
static void merge_and_check(qn_context *context, const cubes *c, qn_mesh **mesh,
                            const qn_mesh_report *old, int64_t *needless) {
    qni_flat_report report;
    double length[2], area[2][6];
    measure(*mesh, &length[0], area[0]);
    assert_int_equal(qni_mesh_merge_flat(context, mesh, 2e-6, &report, NULL), QN_OK);
    measure(*mesh, &length[1], area[1]);
    const qn_mesh_report now = check(context, *mesh);
    assert_true(is_clean(&now));
    assert_int_equal(now.euler_characteristic, old->euler_characteristic);
    assert_true(fabs(now.volume - old->volume) < 1e-4);
    assert_true(fabs(length[0] - length[1]) < 1e-3);
    for (int n = 0; n < 6; ++n)
        assert_true(fabs(area[0][n] - area[1][n]) < 1e-3);
    assert_int_equal(report.kept_regions, 0);
    assert_int_equal((*mesh)->triangle_count,
                     2 * ((*mesh)->vertex_count - old->euler_characteristic));
    *needless += (*mesh)->vertex_count - count_corners(c);
}

static void cubes_come_down_to_their_corners(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    model *m = test_alloc(1, sizeof *m);
    m->gap = 0;
    int64_t solids = 0, triangles = 0, needless = 0;
    while (solids < test_count(150, 5000)) {
        cubes c;
        random_cubes(&random, &c);
        if (!may_be_manifold(&c))
            continue;
        qn_mesh *mesh = mesh_of(context, &random, &c, m);
        const qn_mesh_report old = check(context, mesh);
        if (is_clean(&old) && mesh->triangle_count > 0) {
            merge_and_check(context, &c, &mesh, &old, &needless);
            triangles += mesh->triangle_count;
            ++solids;
        }
        qn_mesh_destroy(mesh);
    }
    printf("%lld solids of cubes: %lld triangles, %lld vertices that are no corners\n",
           (long long)solids, (long long)triangles, (long long)needless);
    assert_int_equal(needless, 0);
    free(m);
    test_context_end(context);
}

/* Inner points of the two faces of a gap, moved across it together by less than merging would. */
static void bend_faces(test_random *random, const model *m, qn_mesh *mesh) {
    for (int n = 0; n < LINES * LINES; ++n) {
        const int y = n % LINES, z = n / LINES;
        const uint32_t *row = m->vertex + (z * LINES + y) * LINES,
                       pair[2] = {row[PARTS], row[2 * PARTS]};
        const double bend = -1e-6 * test_random_unit(random);
        if (y % PARTS == 0 || z % PARTS == 0)
            continue;
        for (int side = 0; side < 2; ++side)
            for (int r = 0; pair[side] != UINT32_MAX && r < 3; ++r)
                mesh->positions[3 * (size_t)pair[side] + (size_t)r] +=
                    (float)(m->turn[r][0] * bend);
    }
}

/* Two cubes nearer to each other than merging may move their faces, of which one is not merged: it
 * has an owner for each triangle. What would meet stays as it was. */
static void near_faces_do_not_come_to_meet(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    model *m = test_alloc(1, sizeof *m);
    int64_t clean = 0, kept = 0, dropped = 0;
    m->gap = 3e-7;
    for (int64_t n = 0; n < test_count(200, 4000); ++n) {
        cubes c;
        memset(&c, 0, sizeof c);
        c.solid[0][0][0] = c.solid[0][0][2] = true;
        qn_mesh *mesh = mesh_of(context, &random, &c, m);
        bend_faces(&random, m, mesh);
        for (int64_t t = mesh->triangle_count / 2; t < mesh->triangle_count; ++t)
            mesh->triangle_owners[t] = (int32_t)t;
        qn_mesh_report now = check(context, mesh);
        if (is_clean(&now)) {
            qni_flat_report report;
            assert_int_equal(qni_mesh_merge_flat(context, &mesh, 2e-6, &report, NULL), QN_OK);
            now = check(context, mesh);
            assert_true(is_clean(&now));
            assert_int_equal(now.components, 2);
            kept += report.kept_regions;
            dropped += report.dropped_vertices;
            ++clean;
        }
        qn_mesh_destroy(mesh);
    }
    printf("%lld pairs of cubes: %lld vertices dropped, %lld faces kept as they were\n",
           (long long)clean, (long long)dropped, (long long)kept);
    assert_true(clean > 20 && kept > 0 && dropped > 0);
    free(m);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(cubes_come_down_to_their_corners),
                                       cmocka_unit_test(near_faces_do_not_come_to_meet)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
