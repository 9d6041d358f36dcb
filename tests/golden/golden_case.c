// SPDX-License-Identifier: MIT
/* Golden cases: the fields they name, and their lines. */
#include "golden/golden_case.h"
#include "lib/analytic.h"
#include "lib/random_volume.h"

bool golden_parse(const char *line, golden_case *parsed) {
    long long n = 0;
    int count = sscanf(line, "%39[^,],%7[^,],%lld,%7[^,],%7[^,],%11[^,],%23[^,],%23[^,],%23[^,\n]",
                       parsed->name, parsed->scalar, &n, parsed->inside, parsed->border,
                       parsed->faces, parsed->vertices, parsed->face_count, parsed->hash);
    parsed->n = n;
    return count == 9;
}

void golden_print(FILE *file, const golden_case *one) {
    fprintf(file, "%s,%s,%lld,%s,%s,%s,%s,%s,%s\n", one->name, one->scalar, (long long)one->n,
            one->inside, one->border, one->faces, one->vertices, one->face_count, one->hash);
}

static qn_scalar scalar_of(const char *name) {
    for (int s = 0; s < QN_SCALAR_COUNT; ++s)
        if (strcmp(qn_scalar_name((qn_scalar)s), name) == 0)
            return (qn_scalar)s;
    fail_msg("golden.csv: no scalar type %s", name);
    return QN_U8;
}

static void *random_samples(const char *name, int64_t n, double *iso) {
    for (int kind = 0; kind < TEST_KIND_COUNT; ++kind)
        if (strcmp(name + strlen("random-"), test_kind_name((test_kind)kind)) == 0) {
            test_random random = {(uint64_t)(1000 + kind)};
            test_field field = test_field_make(n, n, n);
            test_random_fill(&field, &random, (test_kind)kind);
            *iso = field.iso;
            return field.values; /* the caller's now */
        }
    return NULL;
}

static void *samples_of(const golden_case *one, qn_scalar scalar, double *iso) {
    const test_analytic *analytic = test_analytic_find(one->name);
    *iso = test_analytic_iso(scalar);
    if (analytic)
        return test_analytic_samples(analytic, one->n, scalar);
    if (strncmp(one->name, "random-", 7) == 0 && scalar == QN_F64)
        return random_samples(one->name, one->n, iso);
    return NULL;
}

qn_mesh *golden_mesh(qn_context *context, const golden_case *one) {
    double iso;
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.scalar = scalar_of(one->scalar);
    grid.samples = samples_of(one, grid.scalar, &iso);
    if (!grid.samples)
        fail_msg("golden.csv: no field %s of %s", one->name, one->scalar);
    grid.size[0] = grid.size[1] = grid.size[2] = one->n;
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = &iso;
    options.isovalue_count = 1;
    options.inside = strcmp(one->inside, "below") == 0 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
    options.open = strcmp(one->border, "open") == 0;
    options.triangles = strcmp(one->faces, "triangles") == 0;
    qn_volume *volume;
    qn_mesh *mesh;
    qn_error error;
    if (qn_volume_create(context, &grid, NULL, NULL, &volume, &error) != QN_OK ||
        qn_surface(context, volume, &options, &mesh, NULL, &error) != QN_OK)
        fail_msg("%s: %s", one->name, error.message);
    qn_volume_destroy(volume);
    free((void *)grid.samples);
    return mesh;
}
