// SPDX-License-Identifier: MIT
/* qn_mesh_check() on small shapes whose every count is known: edges, fans, components, genus. */
#include "unit/check_shapes.h"

static void an_empty_mesh_is_clean(void **state) {
    (void)state;
    qn_mesh_report r = check(new_shape());
    assert_clean(&r);
    assert_int_equal(r.components, 0);
    assert_int_equal(r.euler_characteristic, 0);
    assert_true(r.area == 0 && r.volume == 0 && r.irregular_vertices == 0);
    assert_true(r.bounds[0][0] == 0 && r.bounds[1][2] == 0);
}

static void a_tetrahedron_is_a_sphere(void **state) {
    (void)state;
    shape *s = new_shape();
    add_tetrahedron(s, 100, 200, -300, 2);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.edge_count, 6);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.euler_characteristic, 2);
    assert_int_equal(r.genus_sum, 0);
    assert_near(r.volume, 8.0 / 6);
    assert_near(r.area, 6 + 2 * sqrt(3.0));
    assert_near(r.bounds[0][2], -300);
    assert_near(r.bounds[1][1], 202);
    assert_near(r.smallest_angle, 45);
    /* Three right triangles of legs 2: 4 sqrt(3) 2 / 16; one equilateral: 1. */
    assert_near(r.triangle_quality_min, sqrt(3.0) / 2);
    assert_near(r.triangle_quality_mean, (3 * sqrt(3.0) / 2 + 1) / 4);
    assert_near(r.irregular_vertices, 1);
    assert_true(r.quad_quality_mean == 0);
}

static void a_cube_is_a_sphere_of_quads(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, -1, -1, -1, 2);
    vertex(s, 9, 9, 9);
    qn_mesh_report r = check(s);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.edge_count, 12);
    assert_int_equal(r.euler_characteristic, 2);
    assert_true(r.closed && r.manifold && r.oriented);
    assert_int_equal(r.self_intersections, 0);
    assert_near(r.volume, 8);
    assert_near(r.area, 24);
    assert_near(r.quad_quality_mean, 1);
    assert_near(r.quad_quality_min, 1);
    assert_near(r.triangle_quality_mean, sqrt(3.0) / 2);
    assert_near(r.smallest_angle, 45);
    assert_near(r.irregular_vertices, 1);
    assert_near(r.bounds[1][0], 1);
}

static void an_inward_cube_has_negative_volume(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 50, 0, 0, 1);
    for (int f = 0; f < 6; ++f) {
        uint32_t swapped = s->quads[f][1];
        s->quads[f][1] = s->quads[f][3];
        s->quads[f][3] = swapped;
    }
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_near(r.volume, -1);
}

static void a_torus_has_genus_one_and_is_regular(void **state) {
    (void)state;
    shape *s = new_shape();
    add_torus(s, 24, 12);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.euler_characteristic, 0);
    assert_int_equal(r.genus_sum, 1);
    assert_int_equal(r.largest_genus, 1);
    assert_int_equal(r.edge_count, 2 * 24 * 12);
    assert_true(r.irregular_vertices == 0);
    assert_true(r.volume > 0);
}

static bool plate_with_two_holes(int x, int y, int z) {
    bool hole = y == 1 && (x == 1 || x == 3);
    return x >= 0 && x < 5 && y >= 0 && y < 3 && z == 0 && !hole;
}

static void genus_is_summed_over_components(void **state) {
    (void)state;
    shape *s = new_shape();
    add_voxels(s, 5, plate_with_two_holes);
    for (int i = 0; i < s->vertex_count; ++i)
        s->positions[i][2] += 10;
    add_torus(s, 9, 5);
    add_tetrahedron(s, 30, 0, 0, 1);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.components, 3);
    assert_int_equal(r.euler_characteristic, -2 + 0 + 2);
    assert_int_equal(r.genus_sum, 3);
    assert_int_equal(r.largest_genus, 2);
}

static bool two_cubes_at_an_edge(int x, int y, int z) {
    return z == 0 && ((x == 0 && y == 0) || (x == 1 && y == 1));
}

static void an_edge_of_four_faces_is_not_manifold(void **state) {
    (void)state;
    shape *s = new_shape();
    add_voxels(s, 2, two_cubes_at_an_edge);
    qn_mesh_report r = check(s);
    assert_int_equal(r.vertex_count, 14);
    assert_int_equal(r.nonmanifold_edges, 1);
    assert_int_equal(r.nonmanifold_vertices, 0); /* the fans at its ends hang together by it */
    assert_int_equal(r.boundary_edges, 0);
    assert_int_equal(r.edge_count, 23);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.closed_components, 1);
    assert_true(r.closed && !r.manifold && r.oriented);
    assert_int_equal(r.genus_sum, 0);
    assert_int_equal(r.self_intersections, 0);
}

static bool two_cubes_at_a_corner(int x, int y, int z) {
    return (x == 0 && y == 0 && z == 0) || (x == 1 && y == 1 && z == 1);
}

static void a_shared_tip_is_not_manifold(void **state) {
    (void)state;
    shape *s = new_shape();
    add_voxels(s, 2, two_cubes_at_a_corner);
    qn_mesh_report r = check(s);
    assert_int_equal(r.vertex_count, 15);
    assert_int_equal(r.nonmanifold_edges, 0);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_int_equal(r.euler_characteristic, 3);
    assert_true(r.closed && !r.manifold && r.oriented);
    assert_int_equal(r.self_intersections, 0);
}

static void a_pinched_component_has_no_genus(void **state) {
    (void)state;
    shape *s = new_shape();
    add_torus(s, 24, 12);
    for (int f = 0; f < s->quad_count; ++f)
        for (int k = 0; k < 4; ++k)
            if (s->quads[f][k] == 150)
                s->quads[f][k] = 0;
    qn_mesh_report r = check(s);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.nonmanifold_edges, 0);
    assert_int_equal(r.euler_characteristic, -1);
    assert_true(r.closed && r.oriented && !r.manifold);
    assert_int_equal(r.genus_sum, 0);
}

static void fans_of_many_corners_are_found(void **state) {
    (void)state;
    enum { ROUND = 300 };
    shape *s = new_shape();
    uint32_t tip = vertex(s, 0, 0, 0);
    for (int side = -1; side <= 1; side += 2) {
        uint32_t first = (uint32_t)s->vertex_count;
        for (int i = 0; i < ROUND; ++i) {
            double angle = 2 * acos(-1.0) * i / ROUND;
            vertex(s, cos(angle), sin(angle), side);
        }
        for (uint32_t i = 0; i < ROUND; ++i) {
            uint32_t a = first + i, b = first + (i + 1) % ROUND;
            triangle(s, tip, side > 0 ? a : b, side > 0 ? b : a);
        }
    }
    triangle(s, tip, 2, 1); /* one more face on the first cone, turned: a duplicate */
    qn_mesh_report r = check(s);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_int_equal(r.closed_components, 0);
    assert_int_equal(r.duplicate_faces, 1);
    assert_int_equal(r.nonmanifold_edges, 2);
    assert_int_equal(r.boundary_edges, 2 * ROUND - 1);
    assert_int_equal(r.edge_count, 4 * ROUND);
    assert_int_equal(r.euler_characteristic, 1 + 2 * ROUND - 4 * ROUND + 2 * ROUND + 1);
    assert_int_equal(r.self_intersections, 1);
}

static void a_moebius_band_cannot_be_oriented(void **state) {
    (void)state;
    enum { ROUND = 16 };
    shape *s = new_shape();
    for (int i = 0; i < ROUND; ++i)
        for (int k = -1; k <= 1; k += 2) {
            double u = 2 * acos(-1.0) * i / ROUND;
            vertex(s, (2 + 0.5 * k * cos(u / 2)) * cos(u), (2 + 0.5 * k * cos(u / 2)) * sin(u),
                   0.5 * k * sin(u / 2));
        }
    for (uint32_t i = 0; i < ROUND; ++i) {
        uint32_t a = 2 * i, b = 2 * i + 1, c = 2 * i + 3, d = 2 * i + 2;
        if (i == ROUND - 1) {
            c = 0;
            d = 1;
        }
        quad(s, a, b, c, d);
    }
    qn_mesh_report r = check(s);
    assert_int_equal(r.orientation_conflicts, 1);
    assert_false(r.oriented);
    assert_true(r.manifold);
    assert_int_equal(r.boundary_edges, 2 * ROUND);
    assert_int_equal(r.euler_characteristic, 0);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.self_intersections, 0);
}

static void a_turned_face_makes_conflicts(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    uint32_t swapped = s->quads[2][0];
    s->quads[2][0] = s->quads[2][2];
    s->quads[2][2] = swapped;
    qn_mesh_report r = check(s);
    assert_int_equal(r.orientation_conflicts, 4);
    assert_true(r.closed && r.manifold && !r.oriented);
    assert_int_equal(r.genus_sum, 0);
    assert_int_equal(r.components, 1);
}

static void an_open_box_has_a_boundary(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    s->quad_count -= 1;
    qn_mesh_report r = check(s);
    assert_int_equal(r.boundary_edges, 4);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.closed_components, 0);
    assert_int_equal(r.euler_characteristic, 1);
    assert_true(!r.closed && r.manifold && r.oriented);
    assert_near(r.irregular_vertices, 1); /* the four inner ones, of valence 3 */
}
int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_mesh_is_clean),
        cmocka_unit_test(a_tetrahedron_is_a_sphere),
        cmocka_unit_test(a_cube_is_a_sphere_of_quads),
        cmocka_unit_test(an_inward_cube_has_negative_volume),
        cmocka_unit_test(a_torus_has_genus_one_and_is_regular),
        cmocka_unit_test(genus_is_summed_over_components),
        cmocka_unit_test(an_edge_of_four_faces_is_not_manifold),
        cmocka_unit_test(a_shared_tip_is_not_manifold),
        cmocka_unit_test(a_pinched_component_has_no_genus),
        cmocka_unit_test(fans_of_many_corners_are_found),
        cmocka_unit_test(a_moebius_band_cannot_be_oriented),
        cmocka_unit_test(a_turned_face_makes_conflicts),
        cmocka_unit_test(an_open_box_has_a_boundary),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
