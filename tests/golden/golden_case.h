// SPDX-License-Identifier: MIT
/* One line of golden.csv: what is meshed, and what came out when it was last agreed on. */
#ifndef TEST_GOLDEN_CASE_H
#define TEST_GOLDEN_CASE_H

#include "lib/support.h"

typedef struct golden_case {
    char name[40], scalar[8], inside[8], border[8], faces[12];
    int64_t n;
    char vertices[24], face_count[24], hash[24]; /* as text; "-": not fixed */
} golden_case;

/* False for a line that is none. */
bool golden_parse(const char *line, golden_case *parsed);
void golden_print(FILE *file, const golden_case *one);
/* Meshes the case. Fails the test when it names nothing known. */
qn_mesh *golden_mesh(qn_context *context, const golden_case *one);

#endif
