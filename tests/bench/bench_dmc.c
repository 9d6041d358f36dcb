// SPDX-License-Identifier: MIT
/* Quoin's Dual Marching Cubes under the benchmark's frame. */
#include "bench/bench.h"
#include "lib/support.h"

typedef struct state {
    qn_context *context;
    qn_volume *volume;
    qn_surface_options options;
    double iso;
    qn_mesh *mesh;
} state;

static bool keep_doubled; /* of --manifold off, told before any case runs */

static void *prepare(const bench_volume *volume, int threads, bool normals) {
    state *s = test_alloc(1, sizeof *s);
    memset(s, 0, sizeof *s);
    s->context = test_context(threads);
    s->iso = volume->iso;
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.samples = volume->samples;
    grid.scalar = volume->scalar;
    grid.swapped = volume->swapped;
    memcpy(grid.size, volume->size, sizeof grid.size);
    qn_error error;
    if (qn_volume_create(s->context, &grid, NULL, NULL, &s->volume, &error) != QN_OK) {
        fprintf(stderr, "%s\n", error.message);
        return NULL;
    }
    qn_surface_options_init(&s->options);
    s->options.isovalues = &s->iso;
    s->options.isovalue_count = 1;
    s->options.open = true;
    s->options.skip_normals = !normals;
    s->options.keep_doubled = keep_doubled;
    return s;
}

static bool extract(void *user, bench_outcome *outcome) {
    state *s = user;
    qn_surface_report report;
    qn_error error;
    if (qn_surface(s->context, s->volume, &s->options, &s->mesh, &report, &error) != QN_OK) {
        fprintf(stderr, "%s\n", error.message);
        return false;
    }
    outcome->vertices = report.vertices;
    outcome->faces = report.quads;
    outcome->output_bytes = report.output_bytes;
    outcome->scratch_bytes = report.scratch_bytes;
    outcome->classify_wall = report.seconds_classify;
    outcome->emit_wall = report.seconds_emit;
    return true;
}

static void clear(void *user) {
    state *s = user;
    qn_mesh_destroy(s->mesh);
    s->mesh = NULL;
}

int main(int argc, char **argv) {
    keep_doubled = argc > 2 && strcmp(argv[1], "--manifold") == 0 && strcmp(argv[2], "off") == 0;
    if (keep_doubled) {
        argv[2] = argv[0];
        argv += 2;
        argc -= 2;
    }
    const bench_engine engine = {
        keep_doubled ? "quoin --manifold off" : "quoin", true, true, true, prepare, extract, clear};
    return bench_main(&engine, argc, argv);
}
