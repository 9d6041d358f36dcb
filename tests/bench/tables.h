// SPDX-License-Identifier: MIT
/* The tables of [DMC21] again: methods that make a mesh of a volume, open at the border and in
 * index space, and the table program that measures them all alike. */
#ifndef BENCH_TABLES_H
#define BENCH_TABLES_H

#include "bench/bench.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tables_method {
    const char *name;
    /* The mesh, to be freed with qn_mesh_destroy(), or NULL where the method cannot. */
    qn_mesh *(*surface)(qn_context *context, const bench_volume *volume);
} tables_method;

/* Plain marching cubes: a vertex on every crossed lattice edge, the polygons of each cell as fans
 * of triangles; ambiguous faces by the asymptotic decider, no tunnels. */
qn_mesh *tables_marching_cubes(qn_context *context, const bench_volume *volume);
/* Dual contouring on the uniform lattice: one vertex a cell with surface, where the quadratic error
 * of the planes through its crossings is least; one quad round each crossed inner edge. */
qn_mesh *tables_dual_contouring(qn_context *context, const bench_volume *volume);

/* Prints the tables with columns for Quoin, the two above and the rivals given. */
int tables_main(const tables_method *rivals, int rival_count, int argc, char **argv);

#ifdef __cplusplus
}
#endif
#endif
