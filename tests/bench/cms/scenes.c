// SPDX-License-Identifier: MIT
/* Built by the public calls alone, as a user would. */
#include "bench/cms/scenes.h"

#include <math.h>

static void need(qn_status status, const qn_error *error) {
    if (status == QN_OK)
        return;
    fprintf(stderr, "%s\n", error->message);
    exit(1);
}

/* Rows: where the body's axes go; the last column: where its origin goes. The part is used up. */
static qn_solid *moved(qn_context *context, qn_solid *part, const double turn[3][3],
                       const double origin[3]) {
    double matrix[3][4];
    for (int k = 0; k < 3; ++k) {
        for (int m = 0; m < 3; ++m)
            matrix[k][m] = turn[k][m];
        matrix[k][3] = origin[k];
    }
    qn_solid *solid;
    qn_error error;
    need(qn_solid_transform(context, part, (const double(*)[4])matrix, &solid, &error), &error);
    qn_solid_destroy(part);
    return solid;
}

static const double upright[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

static qn_solid *box(qn_context *context, double x, double y, double z) {
    const double low[3] = {-x, -y, -z}, high[3] = {x, y, z};
    qn_solid *solid;
    qn_error error;
    need(qn_solid_box(context, low, high, &solid, &error), &error);
    return solid;
}

static qn_solid *ball(qn_context *context, double x, double y, double z, double radius) {
    const double origin[3] = {x, y, z};
    qn_solid *solid;
    qn_error error;
    need(qn_solid_sphere(context, radius, 0, &solid, &error), &error);
    return moved(context, solid, upright, origin);
}

static qn_solid *cylinder(qn_context *context, double x, double y, double half, double low,
                          double high) {
    const double origin[3] = {x, y, -half};
    qn_solid *solid;
    qn_error error;
    need(qn_solid_cylinder(context, 2 * half, low, high, 0, &solid, &error), &error);
    return moved(context, solid, upright, origin);
}

/* All parts are used up. */
static qn_solid *joined(qn_context *context, bool less, int64_t count, qn_solid **parts) {
    qn_solid *solid;
    qn_error error;
    need(less ? qn_solid_difference(context, count, parts, &solid, &error)
              : qn_solid_union(context, count, parts, &solid, &error),
         &error);
    for (int64_t n = 0; n < count; ++n)
        qn_solid_destroy(parts[n]);
    return solid;
}

qn_solid *scene_figure_8(qn_context *context) {
    qn_solid *both[2] = {box(context, 1, 1, 1), cylinder(context, 0, 0, 1.7, 0.6, 0.6)};
    qn_solid *less[2] = {joined(context, false, 2, both), ball(context, 1, -1, 1, 0.9)};
    return joined(context, true, 2, less);
}

/* Rodrigues' formula. */
static void turn_about(const double axis[3], double angle, double turn[3][3]) {
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    const double c = cos(angle), s = sin(angle);
    for (int k = 0; k < 3; ++k)
        for (int m = 0; m < 3; ++m) {
            const double u = axis[k] / length, v = axis[m] / length;
            const double w = k == m ? 0 : axis[3 - k - m] / length * ((k + 1) % 3 == m ? -1 : 1);
            turn[k][m] = (k == m ? c : 0) + (1 - c) * u * v + s * w;
        }
}

qn_solid *scene_libfive(qn_context *context, bool turned) {
    static const double axis[3] = {1, 2, 3}, origin[3] = {0, 0, 0};
    qn_solid *less[2] = {box(context, 1, 1, 1), ball(context, 1, 1, 1, 1.2)};
    qn_solid *both[2] = {joined(context, true, 2, less),
                         cylinder(context, -0.3, -0.3, 1.5, 0.35, 0.35)};
    qn_solid *solid = joined(context, false, 2, both);
    double turn[3][3];
    if (!turned)
        return solid;
    turn_about(axis, 0.5, turn);
    return moved(context, solid, (const double(*)[3])turn, origin);
}

qn_solid *scene_turned_cube(qn_context *context) {
    static const double axis[3] = {3, 1, 2}, origin[3] = {0.03, -0.07, 0.05};
    double turn[3][3];
    turn_about(axis, 0.6, turn);
    return moved(context, box(context, 1, 1, 1), (const double(*)[3])turn, origin);
}

static qn_solid *random_primitive(qn_context *context, test_random *random) {
    const double a = 0.2 + 0.5 * test_random_unit(random), b = 0.2 + 0.5 * test_random_unit(random);
    const double axis[3] = {test_random_gaussian(random), test_random_gaussian(random),
                            test_random_gaussian(random)};
    double turn[3][3], origin[3];
    for (int k = 0; k < 3; ++k)
        origin[k] = 6 * test_random_unit(random) - 3;
    turn_about(axis, 3 * test_random_unit(random), turn);
    qn_solid *part;
    qn_error error;
    switch (test_random_range(random, 0, 4)) {
    case 0:
        part = ball(context, 0, 0, 0, a);
        break;
    case 1:
        part = cylinder(context, 0, 0, 2 * b, 0.5 * a, 0.5 * a);
        break;
    case 2:
        part = cylinder(context, 0, 0, b, a, 0.2 * a);
        break;
    case 3:
        need(qn_solid_torus(context, a, 0.3 * a, &part, &error), &error);
        break;
    default:
        part = box(context, a, b, 0.3);
    }
    return moved(context, part, (const double(*)[3])turn, origin);
}

qn_solid *scene_primitives(qn_context *context, int count) {
    test_random random = {2005};
    qn_solid **kept = test_alloc((size_t)count + 1, sizeof *kept),
             **less = test_alloc((size_t)count + 1, sizeof *less);
    int64_t kept_count = 0, less_count = 1;
    for (int n = 0; n < count; ++n) {
        qn_solid *part = random_primitive(context, &random);
        if (n % 5 == 4)
            less[less_count++] = part;
        else
            kept[kept_count++] = part;
    }
    less[0] = joined(context, false, kept_count, kept);
    qn_solid *solid = joined(context, true, less_count, less);
    free(kept);
    free(less);
    return solid;
}

qn_solid *scene_file(qn_context *context, const char *name) {
    char relative[256], path[4096];
    snprintf(relative, sizeof relative, "csg/%s", name);
    if (!test_data_path(relative, path, sizeof path))
        return NULL;
    qn_solid *solid = NULL;
    qn_error error;
    if (qn_solid_read(context, path, NULL, &solid, &error) != QN_OK)
        fprintf(stderr, "left out: %s\n", error.message);
    return solid;
}

scene_surface scene_make_surface(qn_context *context, const qn_solid *solid, int depth,
                                 double tolerance_cells, bool uniform) {
    qn_solid_surface_options options;
    scene_surface out;
    qn_error error;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    options.uniform = uniform;
    if (tolerance_cells >
        0) { /* the lattice's cell, a little larger than this, is told only after */
        double low[3], high[3], extent = 0;
        qn_solid_get_box(solid, low, high);
        for (int k = 0; k < 3; ++k)
            extent = fmax(extent, high[k] - low[k]);
        options.tolerance = tolerance_cells * extent / (1 << depth);
    }
    need(qn_solid_surface(context, solid, &options, &out.mesh, &out.report, &error), &error);
    return out;
}

const char *scene_count(int64_t count) {
    static char texts[8][32];
    static int next;
    char digits[32], *out = texts[next++ % 8];
    const int length = snprintf(digits, sizeof digits, "%lld", (long long)count);
    int at = 0;
    for (int n = 0; n < length; ++n) {
        if (n > 0 && (length - n) % 3 == 0)
            out[at++] = ',';
        out[at++] = digits[n];
    }
    out[at] = 0;
    return out;
}
