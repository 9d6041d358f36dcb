// SPDX-License-Identifier: MIT
/* qn_mesh_check() on random soups against plain counting, every face with every other; and the same
 * counts when vertices and faces are shuffled and the axes turned, for every number of threads. */
#include "lib/support.h"
#include "mesh/diagonals.h"
#include "mesh/mesh.h"
#include "mesh/predicates.h"
#include "mesh/triangle_pair.h"

#include <math.h>

enum { MOST_VERTICES = 4000, MOST_FACES = 1400 };

typedef struct soup {
    int vertices, quads, triangles;
    float positions[MOST_VERTICES][3];
    uint32_t quad[MOST_FACES][4], triangle[MOST_FACES][3];
} soup;

/* A face without corners that repeat in a row. */
typedef struct ring {
    int count;
    uint32_t at[4];
} ring;

static test_random dice;
static soup original, changed;
static ring rings[2 * MOST_FACES];

static int roll(int low, int high) {
    return (int)test_random_range(&dice, low, high);
}

static qn_mesh_view view_of(const soup *s) {
    const qn_mesh_view view = {.vertex_count = s->vertices,
                               .quad_count = s->quads,
                               .triangle_count = s->triangles,
                               .positions = s->positions[0],
                               .quads = s->quad[0],
                               .triangles = s->triangle[0]};
    return view;
}

static qn_mesh_report check(const soup *s, int32_t threads) {
    const qn_mesh_view view = view_of(s);
    qn_context *context = test_context(threads);
    qn_mesh *mesh;
    qn_mesh_report report;
    qn_error error = {QN_OK, ""};
    assert_int_equal(qn_mesh_create(context, &view, &mesh, &error), QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, &error), QN_OK);
    qn_mesh_destroy(mesh);
    test_context_end(context);
    return report;
}

/* ---- plain counting
 * ------------------------------------------------------------------------------ */

static ring ring_of(const uint32_t *v, int n) {
    ring r = {0, {0}};
    for (int i = 0; i < n; ++i)
        if (v[i] != v[(i + 1) % n])
            r.at[r.count++] = v[i];
    for (int i = 0; i < r.count; ++i)
        for (int j = 0; j < i; ++j)
            if (r.at[i] == r.at[j])
                r.count = 0;
    if (r.count < 3)
        r.count = 0;
    return r;
}

static int find_rings(const soup *s) {
    int count = 0;
    for (int q = 0; q < s->quads; ++q)
        rings[count++] = ring_of(s->quad[q], 4);
    for (int t = 0; t < s->triangles; ++t)
        rings[count++] = ring_of(s->triangle[t], 3);
    return count;
}

/* +1 when the ring runs from a to b, -1 when from b to a, 0 when it has no such edge. */
static int runs(const ring *r, uint32_t a, uint32_t b) {
    for (int i = 0; i < r->count; ++i) {
        uint32_t from = r->at[i], to = r->at[(i + 1) % r->count];
        if (from == a && to == b)
            return 1;
        if (from == b && to == a)
            return -1;
    }
    return 0;
}

static bool has_vertex(const ring *r, uint32_t v) {
    for (int i = 0; i < r->count; ++i)
        if (r->at[i] == v)
            return true;
    return false;
}

static bool same_set(const ring *a, const ring *b) {
    bool same = a->count == b->count && a->count > 0;
    for (int i = 0; same && i < a->count; ++i)
        same = has_vertex(b, a->at[i]);
    return same;
}

static void count_edges(const soup *s, int faces, qn_mesh_report *r) {
    for (uint32_t a = 0; a < (uint32_t)s->vertices; ++a)
        for (uint32_t b = a + 1; b < (uint32_t)s->vertices; ++b) {
            int uses = 0, sum = 0;
            for (int f = 0; f < faces; ++f) {
                uses += runs(&rings[f], a, b) != 0;
                sum += runs(&rings[f], a, b);
            }
            r->edge_count += uses > 0;
            r->boundary_edges += uses == 1;
            r->nonmanifold_edges += uses > 2;
            r->orientation_conflicts += uses == 2 && sum != 0;
        }
}

static bool share_an_edge(const ring *a, const ring *b, int64_t at_vertex) {
    for (int i = 0; i < a->count; ++i) {
        uint32_t from = a->at[i], to = a->at[(i + 1) % a->count];
        bool wanted = at_vertex < 0 || from == at_vertex || to == at_vertex;
        if (wanted && runs(b, from, to) != 0)
            return true;
    }
    return false;
}

/* Groups of the faces chosen by vertex (all for -1), joined by edges at that vertex (any for -1).
 */
static int count_groups(int faces, int64_t vertex) {
    static int group[2 * MOST_FACES];
    int groups = 0;
    for (int f = 0; f < faces; ++f)
        group[f] =
            rings[f].count && (vertex < 0 || has_vertex(&rings[f], (uint32_t)vertex)) ? f : -1;
    for (bool changes = true; changes;) {
        changes = false;
        for (int f = 0; f < faces; ++f)
            for (int g = 0; g < f; ++g)
                if (group[f] >= 0 && group[g] >= 0 && group[f] != group[g] &&
                    share_an_edge(&rings[f], &rings[g], vertex)) {
                    group[f] = group[g] = group[f] < group[g] ? group[f] : group[g];
                    changes = true;
                }
    }
    for (int f = 0; f < faces; ++f)
        groups += group[f] == f;
    return groups;
}

static void count_vertices(const soup *s, int faces, qn_mesh_report *r) {
    for (int v = 0; v < s->vertices; ++v) {
        int groups = count_groups(faces, v);
        r->unused_vertices += groups == 0;
        r->nonmanifold_vertices += groups > 1;
        for (int w = 0; w < v && groups; ++w)
            if (s->positions[v][0] == s->positions[w][0] &&
                s->positions[v][1] == s->positions[w][1] &&
                s->positions[v][2] == s->positions[w][2] && count_groups(faces, w)) {
                r->duplicate_positions += 1;
                break;
            }
    }
}

static int64_t count_duplicate_faces(int faces) {
    int64_t count = 0;
    for (int f = 0; f < faces; ++f)
        for (int g = 0; g < f; ++g)
            if (same_set(&rings[f], &rings[g])) {
                ++count;
                break;
            }
    return count;
}

static int split_soup(const soup *s, uint32_t out[][3]) {
    int count = 0, kept = 0;
    const qn_mesh_view view = view_of(s);
    qn_context *context = test_context(1);
    qni_diagonals diagonals;
    assert_int_equal(qni_diagonals_choose(context, &view, &diagonals, NULL), QN_OK);
    for (int q = 0; q < s->quads; ++q) {
        const uint32_t *v = s->quad[q];
        if (rings[q].count == 0)
            continue;
        int other = qni_along_02(&diagonals, q) ? 0 : 1;
        for (int k = 0; k < 2; ++k, ++count)
            for (int i = 0; i < 3; ++i)
                out[count][i] = v[(other + 2 * k + i) % 4];
    }
    qni_diagonals_free(&diagonals);
    test_context_end(context);
    for (int t = 0; t < s->triangles; ++t)
        if (rings[s->quads + t].count)
            memcpy(out[count++], s->triangle[t], sizeof out[0]);
    for (int i = 0; i < count; ++i)
        if (!qni_collinear(s->positions[out[i][0]], s->positions[out[i][1]],
                           s->positions[out[i][2]]))
            memmove(out[kept++], out[i], sizeof out[0]);
    return kept;
}

static int64_t count_meeting(const soup *s) {
    static uint32_t triangles[3 * MOST_FACES][3];
    int count = split_soup(s, triangles);
    int64_t met = 0;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < i; ++j)
            met += qni_triangles_meet(s->positions[0], triangles[i], triangles[j]);
    return met;
}

/* ---- soups -------------------------------------------------------------------------------------
 */

static void roll_soup(soup *s, int vertices, int quads, int triangles, int grid) {
    s->vertices = vertices;
    s->quads = quads;
    s->triangles = triangles;
    for (int v = 0; v < vertices; ++v)
        for (int i = 0; i < 3; ++i)
            s->positions[v][i] = grid ? (float)roll(-grid, grid) : (float)test_random_unit(&dice);
    for (int q = 0; q < quads; ++q)
        for (int k = 0; k < 4; ++k)
            s->quad[q][k] = (uint32_t)roll(0, vertices - 1);
    for (int t = 0; t < triangles; ++t)
        for (int k = 0; k < 3; ++k)
            s->triangle[t][k] = (uint32_t)roll(0, vertices - 1);
}

/* Small triangles of their own vertices, spread over a box; some larger. */
static void roll_spread(soup *s, int triangles) {
    roll_soup(s, 3 * triangles, 0, triangles, 0);
    for (int t = 0; t < triangles; ++t) {
        float size = roll(0, 9) ? 0.08f : 0.9f;
        for (int k = 0; k < 3; ++k) {
            s->triangle[t][k] = (uint32_t)(3 * t + k);
            for (int i = 0; k > 0 && i < 3; ++i)
                s->positions[3 * t + k][i] =
                    s->positions[3 * t][i] + size * ((float)test_random_unit(&dice) - 0.5f);
        }
    }
}

static void counts_are_those_of_plain_counting(void **state) {
    (void)state;
    int64_t rounds = test_count(1500, 100000);
    for (int64_t n = 0; n < rounds; ++n) {
        roll_soup(&original, roll(3, 14), roll(0, 8), roll(0, 16), roll(0, 3));
        qn_mesh_report want = {0}, got = check(&original, 1);
        int faces = find_rings(&original), polygons = 0;
        count_edges(&original, faces, &want);
        count_vertices(&original, faces, &want);
        for (int f = 0; f < faces; ++f)
            polygons += rings[f].count > 0;
        assert_int_equal(got.edge_count, want.edge_count);
        assert_int_equal(got.boundary_edges, want.boundary_edges);
        assert_int_equal(got.nonmanifold_edges, want.nonmanifold_edges);
        assert_int_equal(got.orientation_conflicts, want.orientation_conflicts);
        assert_int_equal(got.unused_vertices, want.unused_vertices);
        assert_int_equal(got.nonmanifold_vertices, want.nonmanifold_vertices);
        assert_int_equal(got.duplicate_positions, want.duplicate_positions);
        assert_int_equal(got.duplicate_faces, count_duplicate_faces(faces));
        assert_int_equal(got.components, count_groups(faces, -1));
        assert_int_equal(got.euler_characteristic,
                         original.vertices - want.unused_vertices - want.edge_count + polygons);
        assert_int_equal(got.self_intersections, count_meeting(&original));
    }
}

static void larger_soups_have_the_same_pairs(void **state) {
    (void)state;
    int64_t rounds = test_count(25, 1000), pairs = 0;
    for (int64_t n = 0; n < rounds; ++n) {
        if (n % 3 == 0)
            roll_soup(&original, roll(200, 600), roll(0, 300), roll(100, 500), (int)(n % 2) * 5);
        else
            roll_spread(&original, roll(1, 1200));
        find_rings(&original);
        int64_t met = count_meeting(&original);
        pairs += met;
        assert_int_equal(check(&original, 1).self_intersections, met);
    }
    assert_true(pairs > 1000 * rounds);
}

/* ---- invariance
 * ---------------------------------------------------------------------------------- */

static void shuffle(uint32_t *order, int count) {
    for (int i = 0; i < count; ++i)
        order[i] = (uint32_t)i;
    for (int i = count - 1; i > 0; --i) {
        int j = roll(0, i);
        uint32_t kept = order[i];
        order[i] = order[j];
        order[j] = kept;
    }
}

/* The same soup with vertices and triangles in another order and the axes turned or mirrored. */
static void change_soup(const soup *from, soup *to, int symmetry) {
    static const int axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                   {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    static uint32_t vertex_order[MOST_VERTICES], face_order[MOST_FACES];
    shuffle(vertex_order, from->vertices);
    shuffle(face_order, from->triangles);
    to->vertices = from->vertices;
    to->quads = 0;
    to->triangles = from->triangles;
    for (int v = 0; v < from->vertices; ++v)
        for (int i = 0; i < 3; ++i) {
            float x = from->positions[v][axes[symmetry % 6][i]];
            to->positions[vertex_order[v]][i] = (symmetry / 6) >> i & 1 ? -x : x;
        }
    for (int t = 0; t < from->triangles; ++t) {
        int turn = roll(0, 2);
        for (int k = 0; k < 3; ++k)
            to->triangle[face_order[t]][k] = vertex_order[from->triangle[t][(k + turn) % 3]];
    }
}

static void assert_same_counts(const qn_mesh_report *a, const qn_mesh_report *b, bool mirrored) {
    assert_int_equal(a->edge_count, b->edge_count);
    assert_int_equal(a->boundary_edges, b->boundary_edges);
    assert_int_equal(a->nonmanifold_edges, b->nonmanifold_edges);
    assert_int_equal(a->nonmanifold_vertices, b->nonmanifold_vertices);
    assert_int_equal(a->orientation_conflicts, b->orientation_conflicts);
    assert_int_equal(a->degenerate_faces, b->degenerate_faces);
    assert_int_equal(a->duplicate_faces, b->duplicate_faces);
    assert_int_equal(a->duplicate_positions, b->duplicate_positions);
    assert_int_equal(a->self_intersections, b->self_intersections);
    assert_int_equal(a->components, b->components);
    assert_int_equal(a->closed_components, b->closed_components);
    assert_int_equal(a->euler_characteristic, b->euler_characteristic);
    assert_int_equal(a->genus_sum, b->genus_sum);
    assert_true(a->irregular_vertices == b->irregular_vertices);
    assert_true(fabs(a->area - b->area) <= 1e-9 * a->area);
    double sense = mirrored ? -1 : 1;
    assert_true(fabs(a->volume - sense * b->volume) <= 1e-9 * (1 + fabs(a->volume)) * a->area);
    assert_true(fabs(a->smallest_angle - b->smallest_angle) <= 1e-6);
}

static void order_and_axes_do_not_matter(void **state) {
    (void)state;
    int64_t rounds = test_count(2, 40);
    for (int64_t n = 0; n < rounds; ++n) {
        /* Without ties of quads: their split may choose either diagonal. */
        roll_soup(&original, roll(60, 200), 0, roll(50, 250), n % 2 ? 4 : 0);
        qn_mesh_report report = check(&original, 1);
        for (int symmetry = 0; symmetry < 48; ++symmetry) {
            bool mirrored = (symmetry % 6 >= 3) ^ (__builtin_popcount((unsigned)symmetry / 6) & 1);
            change_soup(&original, &changed, symmetry);
            qn_mesh_report other = check(&changed, 1);
            assert_same_counts(&report, &other, mirrored);
        }
    }
}

static void threads_do_not_matter(void **state) {
    (void)state;
    for (int n = 0; n < 6; ++n) {
        roll_soup(&original, 3000, roll(0, 1) * 900, 1300, n % 2 ? 30 : 0);
        qn_mesh_report one = check(&original, 1);
        for (int32_t threads = 2; threads <= 8; threads += 3) {
            qn_mesh_report many = check(&original, threads);
            assert_memory_equal(&one, &many, sizeof one);
        }
    }
}

int main(void) {
    dice.state = test_seed();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_those_of_plain_counting),
        cmocka_unit_test(larger_soups_have_the_same_pairs),
        cmocka_unit_test(order_and_axes_do_not_matter),
        cmocka_unit_test(threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
