// SPDX-License-Identifier: MIT
/* The volumes of the benchmark: formulas in three scalar types, a noisy set, real CT. */
#include "bench/bench.h"
#include "lib/analytic.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct source {
    const char *name;    /* of the row in the tables */
    const char *formula; /* NULL: a file */
    int64_t n;
    qn_scalar scalar;
    const char *file;
    int64_t size[3];
    bool big_endian;
    double iso;
} source;

static const source sources[BENCH_VOLUMES] = {
    {.name = "iwp256-f32", .formula = "iwp", .n = 256, .scalar = QN_F32},
    {.name = "iwp256-u16", .formula = "iwp", .n = 256, .scalar = QN_U16},
    {.name = "iwp256-u8", .formula = "iwp", .n = 256, .scalar = QN_U8},
    {.name = "iwp512-f32", .formula = "iwp", .n = 512, .scalar = QN_F32},
    {.name = "iwp512-u16", .formula = "iwp", .n = 512, .scalar = QN_U16},
    {.name = "iwp512-u8", .formula = "iwp", .n = 512, .scalar = QN_U8},
    {.name = "gen2-256-f32", .formula = "gen2", .n = 256, .scalar = QN_F32},
    {.name = "gen2-256-u16", .formula = "gen2", .n = 256, .scalar = QN_U16},
    {.name = "gen2-256-u8", .formula = "gen2", .n = 256, .scalar = QN_U8},
    {.name = "noisy-u16",
     .scalar = QN_U16,
     .file = "volumes/noisy_synthetic_256x256x256_u16le.raw.gz",
     .size = {256, 256, 256},
     .iso = 2048},
    {.name = "cthead-u16be",
     .scalar = QN_U16,
     .file = "volumes/cthead_male_ct_256x256x113_u16be.raw.gz",
     .size = {256, 256, 113},
     .big_endian = true,
     .iso = 1200.5},
    {.name = "cranium-i16",
     .scalar = QN_I16,
     .file = "volumes/cranium_ct_256x256x108_i16le.raw.gz",
     .size = {256, 256, 108},
     .iso = 226.5},
    {.name = "engine-u8",
     .scalar = QN_U8,
     .file = "volumes/engine_ct_256x256x128_u8.raw.gz",
     .size = {256, 256, 128},
     .iso = 80.5},
};

const char *bench_volume_name(int index) {
    return sources[index].name;
}

static bool read_file(const source *from, bench_volume *volume) {
    char path[4096];
    if (!test_data_path(from->file, path, sizeof path))
        return false;
    qn_context *context = test_context(1);
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    memcpy(options.raw_size, from->size, sizeof options.raw_size);
    options.raw_scalar = from->scalar;
    options.raw_big_endian = from->big_endian;
    qn_volume *read = NULL;
    qn_error error;
    bool good = qn_volume_read(context, path, &options, &read, &error) == QN_OK;
    if (good) {
        const qn_grid *grid = qn_volume_grid(read);
        const size_t bytes =
            (size_t)(grid->size[0] * grid->size[1] * grid->size[2]) * qn_scalar_size(grid->scalar);
        void *copy = test_alloc(bytes, 1);
        memcpy(copy, grid->samples, bytes);
        memcpy(volume->size, grid->size, sizeof volume->size);
        volume->samples = copy;
        volume->swapped = grid->swapped;
    } else {
        fprintf(stderr, "skipped: %s\n", error.message);
    }
    qn_volume_destroy(read);
    qn_context_destroy(context);
    return good;
}

bool bench_volume_make(int index, bench_volume *volume) {
    const source *from = &sources[index];
    memset(volume, 0, sizeof *volume);
    snprintf(volume->name, sizeof volume->name, "%s", from->name);
    volume->scalar = from->scalar;
    volume->iso = from->iso;
    if (!from->formula)
        return read_file(from, volume);
    volume->size[0] = volume->size[1] = volume->size[2] = from->n;
    volume->samples =
        test_analytic_samples(test_analytic_find(from->formula), from->n, from->scalar);
    volume->iso = test_analytic_iso(from->scalar);
    return true;
}

void bench_volume_free(bench_volume *volume) {
    free((void *)(uintptr_t)volume->samples);
    volume->samples = NULL;
}
