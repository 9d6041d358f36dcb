// SPDX-License-Identifier: MIT
/* What a mesh of the noisy volume is, as one row of a table that Quoin and its rivals share. */
#ifndef BENCH_TOPOLOGY_H
#define BENCH_TOPOLOGY_H

#include <qn/qn.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Meshes the volume (256^3 u16, index space) at an iso-value into *view; the arrays live until the
 * next call. */
typedef bool topology_surfacer(const uint16_t *samples, const int64_t size[3], double iso,
                               qn_mesh_view *view);

typedef struct topology_engine {
    const char *name;
    topology_surfacer *surface;
    bool dual;     /* vertices lie in cells, not on lattice edges */
    bool repaired; /* has more vertices than the cells have polygons: its faces are those of the
                      mesh before */
} topology_engine;

/* Prints the rows of iso-values 2048 and 2048.5. */
int topology_main(const topology_engine *engine);

#ifdef __cplusplus
}
#endif
#endif
