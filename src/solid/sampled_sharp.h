// SPDX-License-Identifier: MIT
/* Creases in sampled distances: planes from the smooth side, and what they make of a cell. */
#ifndef QNI_SOLID_SAMPLED_SHARP_H
#define QNI_SOLID_SAMPLED_SHARP_H

#include "solid/solid.h"

/* How to read samples: f at a point of the frame; points beyond its ends are clamped. */
typedef struct qni_sample_reader {
    const void *samples;
    double (*at)(const void *samples, const int32_t point[3]);
    double (*plane)(const void *samples, int axis, int64_t point);
} qni_sample_reader;

/* Is the interpolant of these corners nearly a plane? Then there is no crease in the cell. */
bool qni_cell_is_plain(const double c[8], const double step[3]);

/* A plane that a sample's neighbourhood on one side fits: f(p) = value + slope . (p - place). */
typedef struct qni_sample_tangent {
    double place[3], value, slope[3];
} qni_sample_tangent;

/* The plane at a sample, by differences on the smoother side of each axis (ENO, second order);
 * false where no side is smooth, or where f is no distance there. */
bool qni_tangent_at(const qni_sample_reader *reader, const int32_t point[3], const double step[3],
                    qni_sample_tangent *tangent);

/* Are they one plane, nearly? Then f is straight between their samples. */
bool qni_tangents_agree(const qni_sample_tangent *a, const qni_sample_tangent *b);

/* What the planes of a few samples say together. */
typedef struct qni_sharp_fit {
    qni_sample_tangent tangents[32];
    int count;
    bool crease; /* they differ by more than the crease angle, and all samples agree with one of: */
    bool concave; /* least of the planes, else greatest */
} qni_sharp_fit;

/* Of a cell: its eight corners and the samples next to them across its faces, or the corners alone.
 * Of a lattice edge along an axis: its two ends and the samples round them, eighteen. */
void qni_fit_cell(const qni_sample_reader *reader, const int32_t cell[3], const double step[3],
                  double crease_cosine, qni_sharp_fit *fit);
void qni_fit_edge(const qni_sample_reader *reader, const int32_t start[3], int axis,
                  const double step[3], double crease_cosine, qni_sharp_fit *fit);
/* The fit's value at a point, and which plane gives it. */
double qni_fit_value(const qni_sharp_fit *fit, const double point[3], int *active);

#endif
