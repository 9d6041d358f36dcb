// SPDX-License-Identifier: MIT
/* What is wrong with a mesh: the faults of --fail-on, found in a mesh report. */
#ifndef CLI_VERDICT_H
#define CLI_VERDICT_H

#include <qn/qn.h>

typedef enum verdict_fault {
    FAULT_OPEN = 1 << 0,        /* boundary edges */
    FAULT_NONMANIFOLD = 1 << 1, /* edges or vertices */
    FAULT_ORIENTATION = 1 << 2,
    FAULT_INTERSECT = 1 << 3,
    FAULT_DEGENERATE = 1 << 4,
    FAULT_DUPLICATE = 1 << 5, /* duplicate faces */
    FAULT_NONFINITE = 1 << 6,
    FAULT_ALL = (1 << 7) - 1
} verdict_fault;

/* What 'quoin check' fails on when not told. */
enum {
    VERDICT_DEFAULT =
        FAULT_OPEN | FAULT_NONMANIFOLD | FAULT_ORIENTATION | FAULT_INTERSECT | FAULT_NONFINITE
};

/* "open,intersect", "all" or "none"; false after having said what is wrong. */
bool verdict_parse_faults(const char *text, uint32_t *faults_out);
/* The faults that the mesh has. */
uint32_t verdict_faults(const qn_mesh_report *report);
/* How often a fault (one bit) occurs. */
int64_t verdict_count(const qn_mesh_report *report, uint32_t fault);
/* The name of a fault (one bit) as in --fail-on. */
const char *verdict_name(uint32_t fault);

enum { VERDICT_TEXT_SIZE = 256 };
/* "12 boundary edges, 3 self-intersections", of the faults in the mask that the mesh has; "" for
 * none. */
const char *verdict_describe(const qn_mesh_report *report, uint32_t faults,
                             char text[VERDICT_TEXT_SIZE]);

#endif
