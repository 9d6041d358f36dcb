// SPDX-License-Identifier: MIT
/* Prints the hash of each mesh of golden.csv but the largest: what the byte test compares between
 * compilers. Arguments: golden.csv [threads]. */
#include "golden/golden_case.h"

int main(int argc, char **argv) {
    char line[256];
    golden_case one;
    FILE *file = argc > 1 ? fopen(argv[1], "r") : NULL;
    if (!file || !fgets(line, sizeof line, file))
        return 2;
    qn_context *context = test_context(argc > 2 ? atoi(argv[2]) : 0);
    while (fgets(line, sizeof line, file)) {
        if (!golden_parse(line, &one))
            return 2;
        if (one.n > 256)
            continue;
        qn_mesh *mesh = golden_mesh(context, &one);
        printf("%s %s %lld %s %s %s %016llx\n", one.name, one.scalar, (long long)one.n, one.inside,
               one.border, one.faces, (unsigned long long)test_hash_mesh(mesh));
        qn_mesh_destroy(mesh);
    }
    qn_context_destroy(context);
    return fclose(file);
}
