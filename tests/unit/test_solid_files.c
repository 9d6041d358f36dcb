// SPDX-License-Identifier: MIT
/* The .csg files of the data folder: each solid keeps all claims and has the volume of OpenSCAD's
 * own mesh of it. */
#include <math.h>
#include <zlib.h>

#include "lib/solid_claims.h"

/* A model, whether the mesh of it is packed, and how near its volume comes by 1,000 rays along an
 * axis; with fewer ten times that. Rays miss much of the thin plates of example021. */
typedef struct model {
    const char *name;
    bool packed;
    double share;
} model;

static const model models[] = {
    {"CSG", true, 0.0005},
    {"candleStand", true, 0.0005},
    {"cube-tests", false, 0.0005},
    {"cylinder-tests", false, 0.0005},
    {"difference-tests", false, 0.0005},
    {"example001", true, 0.0005},
    {"example003", false, 0.0005},
    {"example005", true, 0.0005},
    {"example014", false, 0.0005},
    {"example017", true, 0.0005},
    {"example018", true, 0.0005},
    {"example021", true, 0.003},
    {"horn-torus", true, 0.0005},
    {"hull3-tests", false, 0.0005},
    {"intersection-tests", false, 0.0005},
    {"issue1105", false, 0.0005},
    {"issue1105b", false, 0.0005},
    {"issue1215", false, 0.0005},
    {"issue13", false, 0.0005},
    {"issue945", false, 0.0005},
    {"rotate_extrude-angle", true, 0.0005},
    {"sphere-tests", true, 0.0005},
    {"transform-tests", false, 0.0005},
    {"union-tests", false, 0.0005},
};

/* The volume that the triangles of a text STL enclose. */
static bool stl_volume(const char *name, bool packed, double *volume_out) {
    char path[4096], relative[256], line[256];
    snprintf(relative, sizeof relative, "csg/%s.expected.stl%s", name, packed ? ".gz" : "");
    if (!test_data_path(relative, path, sizeof path))
        return false;
    gzFile file = gzopen(path, "rb");
    assert_non_null(file);
    double corner[3][3], six = 0;
    int n = 0;
    while (gzgets(file, line, sizeof line))
        if (sscanf(line, " vertex %lf %lf %lf", &corner[n][0], &corner[n][1], &corner[n][2]) == 3 &&
            ++n == 3) {
            const double *a = corner[0], *b = corner[1], *c = corner[2];
            six += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                   a[2] * (b[0] * c[1] - b[1] * c[0]);
            n = 0;
        }
    gzclose(file);
    *volume_out = six / 6;
    return true;
}

/* What lies inside along rays through the box, one in each square of a lattice, as they are
 * crossed. */
static double ray_volume(const qn_solid *solid, int axis, int side, test_random *random) {
    double low[3], high[3], sum = 0;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    qn_solid_get_box(solid, low, high);
    for (int64_t n = 0; n < (int64_t)side * side; ++n) {
        double a[3], b[3], inside_from = -1;
        a[u] = b[u] =
            low[u] + (high[u] - low[u]) * ((double)(n % side) + test_random_unit(random)) / side;
        a[v] = b[v] =
            low[v] + (high[v] - low[v]) * ((double)(n / side) + test_random_unit(random)) / side;
        a[axis] = low[axis] - 1;
        b[axis] = high[axis] + 1;
        qni_crossing crossings[64];
        int32_t count;
        assert_int_equal(solid->ops->crossings(solid, a, b, 64, crossings, &count), QN_OK);
        assert_int_equal(count % 2, 0);
        for (int32_t i = 0; i < count; ++i) {
            if (!crossings[i].enters)
                sum += (crossings[i].at - inside_from) * (b[axis] - a[axis]);
            inside_from = crossings[i].at;
        }
    }
    return sum * (high[u] - low[u]) * (high[v] - low[v]) / side / side;
}

static qn_solid *read_model(qn_context *context, const model *m, bool smooth) {
    char path[4096], relative[256];
    snprintf(relative, sizeof relative, "csg/%s.csg", m->name);
    if (!test_data_path(relative, path, sizeof path))
        return NULL;
    qn_solid_read_options options;
    qn_solid_read_options_init(&options);
    options.smooth_primitives = smooth;
    qn_solid *solid;
    qn_error error;
    qn_status status = qn_solid_read(context, path, &options, &solid, &error);
    if (status == QN_ERROR_UNSUPPORTED && strstr(error.message, "Qhull")) {
        printf("skipped: %s\n", error.message);
    } else if (status != QN_OK && smooth) { /* hulls of round parts */
        assert_int_equal(status, QN_ERROR_UNSUPPORTED);
    } else if (status != QN_OK) {
        fail_msg("%s", error.message);
    }
    return solid;
}

static void volumes_are_those_of_openscad(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        double expected;
        qn_solid *solid = read_model(context, &models[i], false);
        if (!solid || !stl_volume(models[i].name, models[i].packed, &expected))
            continue;
        for (int axis = 0; axis < 3; ++axis) {
            double found = ray_volume(solid, axis, (int)test_count(160, 1000), &random);
            if (fabs(found - expected) >
                models[i].share * (test_is_long() ? 1 : 10) * fabs(expected))
                fail_msg("%s: volume %g along axis %d, OpenSCAD's mesh has %g", models[i].name,
                         found, axis, expected);
        }
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

static void files_keep_all_claims(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (size_t i = 0; i < 2 * sizeof models / sizeof *models; ++i) {
        bool smooth = i % 2;
        qn_solid *solid = read_model(context, &models[i / 2], smooth);
        if (!solid)
            continue;
        test_claims claims = {.rounds = (int)test_count(60, 3000), .all = !smooth};
        qn_solid_get_box(solid, claims.low, claims.high);
        for (int k = 0; k < 3; ++k) {
            double margin = 0.05 * (claims.high[k] - claims.low[k]);
            claims.low[k] -= margin;
            claims.high[k] += margin;
        }
        test_solid_claims(models[i / 2].name, solid, &claims, &random);
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volumes_are_those_of_openscad),
        cmocka_unit_test(files_keep_all_claims),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
