// SPDX-License-Identifier: MIT
/* Volumes for check_gpu.c: random ones, dense and sparse, and those of the benchmark. They need no
 * test library. On failure to get memory the program ends. */
#ifndef CHECK_VOLUMES_H
#define CHECK_VOLUMES_H

#include <qn/volume.h>

void check_seed(uint64_t seed);
/* A number from 0 to end - 1. */
int64_t check_below(int64_t end);

typedef struct check_volume {
    qn_grid grid;
    void *samples;
    double iso;
    const char *kind;
} check_volume;
check_volume check_random_volume(void);

/* Two thirds of 4^3 leaves with the volume's samples, a tile, and a background. The caller
 * points the grid to origins and tile, where the struct has come to lie. */
typedef struct check_sparse {
    qn_sparse_grid grid;
    int32_t (*origins)[3];
    char *values;
    qn_sparse_tile tile;
} check_sparse;
check_sparse check_make_sparse(const check_volume *volume);

typedef struct check_bench_volume {
    const char *name;
    int kind; /* 0 iwp, 1 gen2, 2 scan */
    int64_t size[3];
    qn_scalar scalar;
    double paper[3]; /* ms: mesh, halfedges, simplification; on an RTX 2080 Ti */
} check_bench_volume;
double check_bench_iso(const check_bench_volume *volume);
void *check_bench_samples(const check_bench_volume *volume, const int64_t size[3]);

#endif
