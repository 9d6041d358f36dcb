// SPDX-License-Identifier: MIT
/* What a mesh of the noisy volume is: cracks, manifoldness, and whether its ambiguous faces are as
 * exact arithmetic says the bilinear interpolant runs there. */
#include "bench/topology.h"
#include "bench/bench.h"
#include "lib/mesh_measure.h"
#include "lib/reference_match.h"

#include <math.h>

enum { NOISY = 9, SEEN_RIGHT = 1, SEEN_OTHER = 2 };

static test_field field_of(const bench_volume *volume, double iso) {
    const uint16_t *samples = volume->samples;
    test_field field = test_field_make(volume->size[0], volume->size[1], volume->size[2]);
    for (int64_t n = 0; n < bench_sample_count(volume); ++n)
        field.values[n] = samples[n];
    field.iso = iso;
    field.open = true;
    test_field_prepare(&field);
    return field;
}

/* ---- ambiguous faces
 * ----------------------------------------------------------------------------- */

/* One number for each lattice face, and for its three axes. */
static int64_t face_number(const test_field *field, const test_face *face) {
    const int64_t *n = field->size, *s = face->sample;
    return s[0] + n[0] * (s[1] + n[1] * (s[2] + n[2] * face->axis));
}

/* Ambiguous, and the two products of the decider differ by more than a millionth: no matter of
 * rounding. */
static test_face_state clear_state(const test_field *field, const test_face *face) {
    const test_face_state state = test_face_decide(field, *face, NULL);
    if (state == TEST_FACE_PLAIN)
        return state;
    const int u = face->axis == 0, v = face->axis == 2 ? 1 : 2;
    double d[4];
    for (int c = 0; c < 4; ++c) {
        int64_t s[3] = {face->sample[0], face->sample[1], face->sample[2]};
        s[u] += c & 1;
        s[v] += c >> 1;
        d[c] = test_field_distance(field, s[0], s[1], s[2]);
    }
    const double one = fabs(d[0] * d[3]), other = fabs(d[1] * d[2]);
    return fabs(one - other) > 1e-6 * (one + other) ? state : TEST_FACE_PLAIN;
}

/* The lattice edge a vertex lies on; false when it lies on a sample or on none. */
static bool edge_of_vertex(const float position[3], test_edge *edge) {
    int broken = 0;
    for (int a = 0; a < 3; ++a) {
        const double below = floor((double)position[a]);
        edge->sample[a] = (int64_t)below;
        if ((double)position[a] > below) {
            edge->axis = a;
            ++broken;
        }
    }
    return broken == 1;
}

/* The lattice face that holds both edges, when they are two of its neighbouring sides; the corner
 * between them. */
static bool common_face(const test_edge *a, const test_edge *b, test_face *face,
                        int64_t corner[3]) {
    if (a->axis == b->axis)
        return false;
    face->axis = 3 - a->axis - b->axis;
    if (a->sample[face->axis] != b->sample[face->axis])
        return false;
    corner[face->axis] = face->sample[face->axis] = a->sample[face->axis];
    face->sample[a->axis] = a->sample[a->axis];
    face->sample[b->axis] = b->sample[b->axis];
    corner[a->axis] = b->sample[a->axis];
    corner[b->axis] = a->sample[b->axis];
    const int64_t along_a = corner[a->axis] - a->sample[a->axis],
                  along_b = corner[b->axis] - b->sample[b->axis];
    return (along_a == 0 || along_a == 1) && (along_b == 0 || along_b == 1);
}

/* A segment of a face cuts one corner off: in a face whose corners above are joined that corner
 * must be below. */
static void see_mesh_edge(const test_field *field, const float *positions, uint32_t a, uint32_t b,
                          uint8_t *seen) {
    test_edge from, to;
    test_face face;
    int64_t corner[3];
    if (!edge_of_vertex(positions + 3 * (int64_t)a, &from) ||
        !edge_of_vertex(positions + 3 * (int64_t)b, &to) || !common_face(&from, &to, &face, corner))
        return;
    const test_face_state state = clear_state(field, &face);
    if (state == TEST_FACE_PLAIN)
        return;
    const bool above = test_field_above(field, corner[0], corner[1], corner[2]);
    uint8_t *flags = seen + face_number(field, &face);
    *flags = (uint8_t)(*flags | (above == (state == TEST_FACE_NEGATIVE) ? SEEN_RIGHT : SEEN_OTHER));
}

typedef struct face_tally {
    int64_t faces, right, other, both;
} face_tally;

/* Of a mesh whose vertices lie on lattice edges. */
static face_tally tally_faces(const test_field *field, const qn_mesh_view *view) {
    face_tally tally = {0, 0, 0, 0};
    const int64_t *size = field->size;
    uint8_t *seen = test_alloc((size_t)(3 * size[0] * size[1] * size[2]), 1);
    memset(seen, 0, (size_t)(3 * size[0] * size[1] * size[2]));
    for (int64_t t = 0; t < view->triangle_count; ++t)
        for (int n = 0; n < 3; ++n)
            see_mesh_edge(field, view->positions, view->triangles[3 * t + n],
                          view->triangles[3 * t + (n + 1) % 3], seen);
    test_face face;
    for (face.axis = 0; face.axis < 3; ++face.axis)
        for (face.sample[2] = 0; face.sample[2] < size[2] - (face.axis != 2); ++face.sample[2])
            for (face.sample[1] = 0; face.sample[1] < size[1] - (face.axis != 1); ++face.sample[1])
                for (face.sample[0] = 0; face.sample[0] < size[0] - (face.axis != 0);
                     ++face.sample[0]) {
                    if (clear_state(field, &face) == TEST_FACE_PLAIN)
                        continue;
                    const uint8_t flags = seen[face_number(field, &face)];
                    ++tally.faces;
                    tally.right += flags == SEEN_RIGHT;
                    tally.other += flags == SEEN_OTHER;
                    tally.both += flags == (SEEN_RIGHT | SEEN_OTHER);
                }
    free(seen);
    return tally;
}

/* Of a dual mesh: either its connectivity is, quad by quad, that of the reference, whose faces are
 * decided exactly, or the comparison ends the program with a sentence. */
static face_tally match_faces(const test_field *field, const qn_mesh *mesh,
                              const qn_mesh_view *view) {
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    face_tally tally = tally_faces(field, view);
    tally.right = tally.faces;
    test_match_free(&match);
    test_reference_free(&reference);
    return tally;
}

/* ---- rows
 * ---------------------------------------------------------------------------------------- */

static bool print_row(const topology_engine *engine, const bench_volume *volume, double iso) {
    qn_context *context = test_context(0);
    qn_mesh_view view;
    qn_mesh *mesh = NULL;
    qn_mesh_report report;
    qn_error error;
    if (!engine->surface(volume->samples, volume->size, iso, &view) ||
        qn_mesh_create(context, &view, &mesh, &error) != QN_OK ||
        qn_mesh_check(context, mesh, NULL, &report, &error) != QN_OK)
        return false;
    /* The outermost cells' vertices of a dual mesh stand back from the box. */
    const double margin = engine->dual ? 1 : 1e-4;
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        low[a] = margin;
        high[a] = (double)(volume->size[a] - 1) - margin;
    }
    const int64_t inside = test_mesh_cracks(mesh, low, high);
    test_field field = field_of(volume, iso);
    printf(
        "| %s | %g | %lld | %lld | %lld | %lld | %lld | %lld | %lld | %lld | %lld | %lld | %lld | ",
        engine->name, iso, (long long)report.vertex_count,
        (long long)(report.quad_count + report.triangle_count), (long long)inside,
        (long long)(report.boundary_edges - inside), (long long)report.nonmanifold_edges,
        (long long)report.nonmanifold_vertices, (long long)report.components,
        (long long)report.euler_characteristic, (long long)report.degenerate_faces,
        (long long)report.duplicate_positions, (long long)report.self_intersections);
    if (engine->repaired) {
        printf("as before repair |\n");
    } else {
        const face_tally faces =
            engine->dual ? match_faces(&field, mesh, &view) : tally_faces(&field, &view);
        printf("%lld / %lld / %lld of %lld |\n", (long long)faces.right, (long long)faces.other,
               (long long)faces.both, (long long)faces.faces);
    }
    test_field_free(&field);
    qn_mesh_destroy(mesh);
    qn_context_destroy(context);
    return true;
}

int topology_main(const topology_engine *engine) {
    bench_volume volume;
    if (!bench_volume_make(NOISY, &volume))
        return 0;
    printf("| engine | iso | V | F | boundary edges inside | on the box | non-manifold edges | "
           "vertices | components | "
           "Euler | degenerate F | duplicate V | self-intersections | clear ambiguous faces: right "
           "/ other / both |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    const bool good = print_row(engine, &volume, 2048) && print_row(engine, &volume, 2048.5);
    bench_volume_free(&volume);
    return good ? 0 : 1;
}
