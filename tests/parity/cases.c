// SPDX-License-Identifier: MIT
/* Random volumes of every sample type, and comparing a mesh from a device with the CPU's. */
#include "parity/cases.h"

#include <math.h>

/* ---- volumes of every type ------------------------------------------------------------------- */

const qn_scalar test_scalars[] = {QN_F32, QN_U8, QN_U16, QN_I16, QN_F64, QN_I8, QN_U32, QN_I32};

static double range_of(qn_scalar scalar, bool high) {
    switch (scalar) {
    case QN_U8:
        return high ? UINT8_MAX : 0;
    case QN_I8:
        return high ? INT8_MAX : INT8_MIN;
    case QN_U16:
        return high ? UINT16_MAX : 0;
    case QN_I16:
        return high ? INT16_MAX : INT16_MIN;
    case QN_U32:
        return high ? UINT32_MAX : 0;
    default:
        return high ? INT32_MAX : INT32_MIN;
    }
}

/* The field's samples in another type: integers on a scale of their own, clamped. */
test_sampled test_sample(const test_field *field, qn_scalar scalar, test_random *random) {
    test_sampled s = {.iso = field->iso};
    const int64_t count = field->size[0] * field->size[1] * field->size[2];
    const bool whole = scalar != QN_F32 && scalar != QN_F64;
    const double middle = whole ? floor((range_of(scalar, false) + range_of(scalar, true)) / 2) : 0;
    const double scale = whole ? (double)test_random_range(random, 1, 40) : 1;
    s.samples = test_alloc((size_t)count, qn_scalar_size(scalar));
    for (int64_t n = 0; n < count; ++n) {
        double value = field->values[n];
        if (whole) {
            value = round((value - field->iso) * scale + middle);
            value = isnan(value) ? middle : value;
            value = fmin(fmax(value, range_of(scalar, false)), range_of(scalar, true));
        }
        switch (scalar) {
#define STORE(name, type, text)                                                                    \
    case QN_##name:                                                                                \
        ((type *)s.samples)[n] = (type)value;                                                      \
        break;
            QN_SCALAR_MAP(STORE)
#undef STORE
        case QN_SCALAR_COUNT:
            break;
        }
    }
    if (whole)
        s.iso = middle + (test_random_range(random, 0, 1) ? 0.5 : 0.0);
    for (int64_t n = 0; !whole && n < count && random->state % 5 == 0; n += 1 + n / 2) {
        const double odd[3] = {NAN, INFINITY, -INFINITY};
        const double value = odd[test_random_range(random, 0, 2)];
        if (scalar == QN_F32)
            ((float *)s.samples)[n] = (float)value;
        else
            ((double *)s.samples)[n] = value;
    }
    if (random->state % 3 == 0) { /* twice the value, or its negative */
        s.grid.slope = random->state % 2 ? 2 : -1;
        s.grid.intercept = 0.125;
        s.iso = s.grid.slope * s.iso + s.grid.intercept;
    }
    s.grid.samples = s.samples;
    s.grid.scalar = scalar;
    memcpy(s.grid.size, field->size, sizeof s.grid.size);
    memcpy(s.grid.index_to_world, field->matrix, sizeof s.grid.index_to_world);
    return s;
}

/* ---- both ways ------------------------------------------------------------------------------- */

void test_expect_equal(const char *name, const char *what, const void *found, const void *expected,
                       int64_t count, size_t size) {
    for (int64_t n = 0; n < count; ++n)
        if (memcmp((const char *)found + n * (int64_t)size,
                   (const char *)expected + n * (int64_t)size, size) != 0) {
            const uint32_t *f = (const void *)((const char *)found + n * (int64_t)size);
            const uint32_t *e = (const void *)((const char *)expected + n * (int64_t)size);
            fail_msg("%s: %s %lld of %lld is other than on the CPU: %08x %08x, not %08x %08x", name,
                     what, (long long)n, (long long)count, f[0], f[size > 4], e[0], e[size > 4]);
        }
}

void test_expect_number(const char *name, const char *what, int64_t found, int64_t expected) {
    if (found != expected)
        fail_msg("%s: %s %lld, on the CPU %lld", name, what, (long long)found, (long long)expected);
}

void test_expect_report(const char *name, const qn_surface_report *found,
                        const qn_surface_report *expected) {
#define EXPECT(field) test_expect_number(name, #field, found->field, expected->field)
    EXPECT(cells);
    EXPECT(active_leaves);
    EXPECT(active_cells);
    EXPECT(ambiguous_faces);
    EXPECT(multiple_cells);
    EXPECT(tied_faces);
    EXPECT(vertices);
    EXPECT(quads);
    EXPECT(doubled_edges);
    EXPECT(repaired_edges);
    EXPECT(slice_points);
    EXPECT(degenerate_points);
    EXPECT(fallback_points);
    EXPECT(zero_gradients);
    EXPECT(nan_samples);
    EXPECT(infinite_samples);
    EXPECT(merged_quads);
    EXPECT(shrunk_quads);
    EXPECT(unprojected_points);
    EXPECT(simplify_passes);
    if (expected->merged_quads + expected->shrunk_quads == 0) /* else the CPU's has slack */
        EXPECT(output_bytes);
    assert_true(found->output_bytes <= expected->output_bytes);
#undef EXPECT
}

qn_mesh *test_cpu_surface(qn_context *context, const qn_volume *volume,
                          const qn_surface_options *options, qn_surface_report *report) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface(context, volume, options, &mesh, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

/* All that a mesh holds, halfedges too. */
uint64_t test_hash_all(const qn_mesh *mesh) {
    const qn_halfedges halves = qn_mesh_get_halfedges(mesh);
    uint64_t hash = test_hash_mesh(mesh);
    if (halves.count == 0)
        return hash;
    hash = test_hash(hash, halves.twin, (size_t)halves.count * 4);
    return test_hash(hash, halves.vertex_halfedge, (size_t)qn_mesh_get_view(mesh).vertex_count * 4);
}

void test_expect_mesh(const char *name, const qn_mesh *found, const qn_mesh *expected) {
    const qn_mesh_view f = qn_mesh_get_view(found), e = qn_mesh_get_view(expected);
    const qn_halfedges fh = qn_mesh_get_halfedges(found), eh = qn_mesh_get_halfedges(expected);
    test_expect_number(name, "vertices", f.vertex_count, e.vertex_count);
    test_expect_number(name, "quads", f.quad_count, e.quad_count);
    test_expect_number(name, "halfedges", fh.count, eh.count);
    test_expect_equal(name, "position", f.positions, e.positions, e.vertex_count, 12);
    test_expect_equal(name, "quad", f.quads, e.quads, e.quad_count, 16);
    test_expect_equal(name, "twin", fh.twin, eh.twin, eh.count, 4);
    if (e.normals)
        test_expect_equal(name, "normal", f.normals, e.normals, e.vertex_count, 12);
    if (eh.count > 0)
        test_expect_equal(name, "halfedge of vertex", fh.vertex_halfedge, eh.vertex_halfedge,
                          e.vertex_count, 4);
}
