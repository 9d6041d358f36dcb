// SPDX-License-Identifier: MIT
/* quoin-make-volume: writes an implicit surface of [DMC21] as a NumPy file of n^3 samples, 32-bit
 * floats.
 *
 *   quoin-make-volume gen2 256 gen2.npy    f = 2y(y^2 - 3x^2)(1 - z^2) + (x^2 + y^2)^2 - (9z^2 -
 * 1)(1 - z^2) at -2 + 4i/(n - 1) on each axis quoin-make-volume iwp 512 iwp.npy      f = cos x cos
 * y + cos y cos z + cos z cos x - cos x cos y cos z at 10.02 pi i/(n - 1) on each axis The surface
 * is f = 0. Fields are evaluated in double. x runs fastest (Fortran order: a[i, j, k]). */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double gen2_place(int i, int n) {
    return -2.0 + 4.0 * i / (n - 1);
}

static double gen2(double x, double y, double z) {
    double r = x * x + y * y, z2 = z * z;
    return 2 * y * (y * y - 3 * x * x) * (1 - z2) + r * r - (9 * z2 - 1) * (1 - z2);
}

/* The cosine is all that iWP needs of a place. */
static double iwp_place(int i, int n) {
    return cos(10.02 * 3.14159265358979323846 * i / (n - 1));
}

static double iwp(double x, double y, double z) {
    return x * y + y * z + z * x - x * y * z;
}

typedef double place_function(int i, int n);
typedef double field_function(double x, double y, double z);

static int write_header(FILE *file, int n) {
    char text[118];
    int length =
        snprintf(text, sizeof text,
                 "{'descr': '<f4', 'fortran_order': True, 'shape': (%d, %d, %d), }", n, n, n);
    memset(text + length, ' ', sizeof text - (size_t)length);
    text[sizeof text - 1] = '\n';
    static const unsigned char magic[10] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, sizeof text, 0};
    return fwrite(magic, 1, 10, file) == 10 && fwrite(text, 1, sizeof text, file) == sizeof text;
}

/* Little-endian, whatever this machine has. */
static void store(float value, unsigned char *bytes) {
    uint32_t bits;
    memcpy(&bits, &value, 4);
    for (int i = 0; i < 4; ++i)
        bytes[i] = (unsigned char)(bits >> (8 * i));
}

static int write_samples(FILE *file, int n, place_function *place, field_function *field) {
    double *places = malloc(sizeof *places * (size_t)n);
    unsigned char *row = malloc(4 * (size_t)n);
    int good = places && row;
    for (int i = 0; good && i < n; ++i)
        places[i] = place(i, n);
    for (int k = 0; good && k < n; ++k)
        for (int j = 0; good && j < n; ++j) {
            for (int i = 0; i < n; ++i)
                store((float)field(places[i], places[j], places[k]), row + 4 * (size_t)i);
            good = fwrite(row, 4, (size_t)n, file) == (size_t)n;
        }
    free(places);
    free(row);
    return good;
}

int main(int argc, char **argv) {
    int n = argc == 4 ? atoi(argv[2]) : 0;
    int is_gen2 = argc == 4 && strcmp(argv[1], "gen2") == 0;
    if (n < 2 || n > 4096 || (!is_gen2 && strcmp(argv[1], "iwp") != 0)) {
        fprintf(stderr, "usage: quoin-make-volume gen2|iwp N FILE.npy   (N from 2 to 4096)\n");
        return 2;
    }
    FILE *file = fopen(argv[3], "wb");
    int good = file && write_header(file, n) &&
               write_samples(file, n, is_gen2 ? gen2_place : iwp_place, is_gen2 ? gen2 : iwp);
    if (file && fclose(file) != 0)
        good = 0;
    if (!good) {
        fprintf(stderr, "quoin-make-volume: cannot write %s\n", argv[3]);
        remove(argv[3]);
    }
    return good ? 0 : 5;
}
