// SPDX-License-Identifier: MIT
/* The benchmark's frame: volumes, floors, timing and tables are the same for Quoin and for each
 * rival; a program adds one engine and calls bench_main(). */
#ifndef BENCH_H
#define BENCH_H

#include <qn/qn.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Packed samples in memory; `iso` is on the scale of the stored numbers. */
typedef struct bench_volume {
    char name[40];
    qn_scalar scalar;
    bool swapped; /* stored in the other byte order */
    int64_t size[3];
    const void *samples;
    double iso;
} bench_volume;

static inline int64_t bench_sample_count(const bench_volume *volume) {
    return volume->size[0] * volume->size[1] * volume->size[2];
}

/* What one extraction gave; -1 where an engine cannot tell. */
typedef struct bench_outcome {
    int64_t vertices, faces;
    int64_t output_bytes;            /* the mesh's arrays */
    int64_t scratch_bytes;           /* most memory counted beside them */
    double classify_wall, emit_wall; /* seconds of the two passes */
} bench_outcome;

typedef struct bench_engine {
    const char *name;
    bool can_leave_normals, can_make_normals, can_read_swapped;
    /* Outside of the time: whatever form of the volume the engine starts from. NULL when it cannot.
     */
    void *(*prepare)(const bench_volume *volume, int threads, bool normals);
    /* The time: from that form to a mesh in memory. */
    bool (*extract)(void *state, bench_outcome *outcome);
    /* Give the mesh back. */
    void (*clear)(void *state);
} bench_engine;

int bench_main(const bench_engine *engine, int argc, char **argv);

/* ---- volumes (volumes.c) -----------------------------------------------------------------------
 */

enum { BENCH_VOLUMES = 13 };
/* Make or read volume `index`; false, with a line on stderr, when its file is not there. */
bool bench_volume_make(int index, bench_volume *volume);
const char *bench_volume_name(int index);
void bench_volume_free(bench_volume *volume);

/* ---- floors (floor.c) --------------------------------------------------------------------------
 */

/* One streaming pass: every sample compared with the iso-value, one bit each written to `bits`
 * ([samples / 8 + 64]), by the widest vectors there are, on so many threads. */
void bench_read_pass(const bench_volume *volume, int threads, uint8_t *bits);
/* Which vectors those are: "AVX-512BW", "AVX2", "plain C". */
const char *bench_read_pass_name(void);
/* Get `bytes` of fresh memory from the system, in huge pages where it has them, write it, give it
 * back. */
void bench_output_pass(int64_t bytes, int threads);

#ifdef __cplusplus
}
#endif
#endif
