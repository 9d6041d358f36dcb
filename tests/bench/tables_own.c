// SPDX-License-Identifier: MIT
/* The tables of [DMC21] without rivals: tables [part of a data set's name]. */
#include "bench/tables.h"

int main(int argc, char **argv) {
    return tables_main(NULL, 0, argc, argv);
}
