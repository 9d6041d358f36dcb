// SPDX-License-Identifier: MIT
/* Creases in sampled distances.
 *
 * Differences across a crease mix both of its sides, and interpolation cuts it off. But a sample of
 * a distance that lies wholly on one side knows that side's plane: by differences towards where f
 * is smooth, as in ENO schemes (Shu and Osher 1988), of second order. Where planes of samples
 * nearby differ by more than the crease angle the surface is taken for the border of their
 * intersection (f is their greatest) or union (their least), whichever the samples themselves bear
 * out; where neither, nothing is done. Samples with curved surroundings, such as those whose
 * nearest point is the crease itself, give no plane. */
#include "solid/sampled_sharp.h"

#include <math.h>
#include <string.h>

/* In cells: how much f may bend at a sample whose plane is believed, how far its slope may be from
 * 1, and how far samples may be from what the planes say. */
static const double most_bend = 0.05, most_slope_error = 0.1, most_misfit = 0.06;

/* How far the interpolant is from a plane in the cell: then there is no crease in it. */
bool qni_cell_is_plain(const double c[8], const double step[3]) {
    const double least = 0.02 * fmin(step[0], fmin(step[1], step[2]));
    const double bends[4] = {c[0] - c[1] - c[2] + c[3], c[0] - c[1] - c[4] + c[5],
                             c[0] - c[2] - c[4] + c[6],
                             c[7] - c[6] - c[5] - c[3] + c[4] + c[2] + c[1] - c[0]};
    for (int n = 0; n < 4; ++n)
        if (!(fabs(bends[n]) < least))
            return false;
    return true;
}

typedef struct stencil {
    double f[5]; /* at -2 .. 2 */
} stencil;

static void read_stencil(const qni_sample_reader *reader, const int32_t point[3], int axis,
                         stencil *s) {
    int32_t at[3] = {point[0], point[1], point[2]};
    for (int n = 0; n < 5; ++n) {
        at[axis] = point[axis] + n - 2;
        s->f[n] = reader->at(reader->samples, at);
    }
}

/* The slope a cell by the smoothest of three second differences, which goes to *bend. */
static double smooth_slope(const stencil *s, double *bend) {
    const double *f = s->f + 2;
    const double left = f[0] - 2 * f[-1] + f[-2], right = f[2] - 2 * f[1] + f[0],
                 middle = f[1] - 2 * f[0] + f[-1];
    if (fabs(middle) <= fabs(left) && fabs(middle) <= fabs(right)) {
        *bend = fabs(middle);
        return 0.5 * (f[1] - f[-1]);
    }
    *bend = fmin(fabs(left), fabs(right));
    return fabs(left) < fabs(right) ? f[0] - f[-1] + 0.5 * left : f[1] - f[0] - 0.5 * right;
}

bool qni_tangent_at(const qni_sample_reader *reader, const int32_t point[3], const double step[3],
                    qni_sample_tangent *tangent) {
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        stencil s;
        double bend;
        read_stencil(reader, point, k, &s);
        tangent->slope[k] = smooth_slope(&s, &bend) / step[k];
        if (!(bend < most_bend * step[k]))
            return false;
        tangent->place[k] = reader->plane(reader->samples, k, point[k]);
        square += tangent->slope[k] * tangent->slope[k];
    }
    tangent->value = reader->at(reader->samples, point);
    return fabs(sqrt(square) - 1) < most_slope_error;
}

static double value_of(const qni_sample_tangent *t, const double point[3]) {
    double value = t->value;
    for (int k = 0; k < 3; ++k)
        value += t->slope[k] * (point[k] - t->place[k]);
    return value;
}

bool qni_tangents_agree(const qni_sample_tangent *a, const qni_sample_tangent *b) {
    double turn = 0, apart = 0;
    for (int k = 0; k < 3; ++k) {
        turn = fmax(turn, fabs(a->slope[k] - b->slope[k]));
        apart = fmax(apart, fabs(a->place[k] - b->place[k]));
    }
    return turn < 0.02 && fabs(value_of(a, b->place) - b->value) < 0.01 * apart;
}

double qni_fit_value(const qni_sharp_fit *fit, const double point[3], int *active) {
    double best = value_of(&fit->tangents[0], point);
    *active = 0;
    for (int n = 1; n < fit->count; ++n) {
        const double value = value_of(&fit->tangents[n], point);
        if (fit->concave ? value < best : value > best) {
            best = value;
            *active = n;
        }
    }
    return best;
}

/* Unit normals of two of them differ by more than the angle. */
static bool planes_differ(const qni_sharp_fit *fit, double crease_cosine) {
    for (int m = 0; m < fit->count; ++m)
        for (int n = m + 1; n < fit->count; ++n) {
            const double *a = fit->tangents[m].slope, *b = fit->tangents[n].slope;
            const double along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            const double lengths = sqrt((a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) *
                                        (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]));
            if (along < crease_cosine * lengths)
                return true;
        }
    return false;
}

/* The largest misfit of the samples whose planes are believed; no matter how much above `most`. */
static double misfit(const qni_sharp_fit *fit, double most) {
    double worst = 0;
    for (int n = 0; n < fit->count && worst < most; ++n) {
        int active;
        worst = fmax(worst, fabs(qni_fit_value(fit, fit->tangents[n].place, &active) -
                                 fit->tangents[n].value));
    }
    return worst;
}

/* Leave out the plane that spoils the fit most: one of a curved place that passed for flat. */
static double drop_worst(qni_sharp_fit *fit) {
    double best = HUGE_VAL;
    int worst = 0;
    const int last = --fit->count;
    for (int n = 0; n <= last; ++n) {
        const qni_sample_tangent left_out = fit->tangents[n];
        fit->tangents[n] = fit->tangents[last];
        const double error = misfit(fit, best);
        fit->tangents[n] = left_out;
        if (error < best) {
            best = error;
            worst = n;
        }
    }
    fit->tangents[worst] = fit->tangents[last];
    return best;
}

static void settle(qni_sharp_fit *fit, const double step[3], double crease_cosine) {
    enum { MOST_DROPPED = 3 };
    fit->crease = fit->concave = false;
    if (fit->count < 2 || !planes_differ(fit, crease_cosine))
        return;
    const double most = most_misfit * fmin(step[0], fmin(step[1], step[2]));
    const double hopeless = 8 * most;
    const double convex = misfit(fit, hopeless);
    fit->concave = true;
    double error = misfit(fit, convex);
    fit->concave = error < convex;
    error = fit->concave ? error : convex;
    for (int n = 0; n < MOST_DROPPED && error >= most && error < hopeless && fit->count > 4; ++n)
        error = drop_worst(fit);
    fit->crease = error < most && planes_differ(fit, crease_cosine);
}

static void add(const qni_sample_reader *reader, const int32_t point[3], const double step[3],
                qni_sharp_fit *fit) {
    if (qni_tangent_at(reader, point, step, &fit->tangents[fit->count]))
        ++fit->count;
}

/* The cell's corners, and `beside` the 24 samples across its faces. */
static void fit_corners(const qni_sample_reader *reader, const int32_t cell[3],
                        const double step[3], double crease_cosine, bool beside,
                        qni_sharp_fit *fit) {
    fit->count = 0;
    for (int corner = 0; corner < 8; ++corner) {
        int32_t point[3] = {cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                            cell[2] + (corner >> 2)};
        add(reader, point, step, fit);
        for (int k = 0; beside && k < 3; ++k) {
            const int32_t away = corner >> k & 1 ? 1 : -1;
            point[k] += away;
            add(reader, point, step, fit);
            point[k] -= away;
        }
    }
    settle(fit, step, crease_cosine);
}

void qni_fit_cell(const qni_sample_reader *reader, const int32_t cell[3], const double step[3],
                  double crease_cosine, qni_sharp_fit *fit) {
    fit_corners(reader, cell, step, crease_cosine, true, fit);
    if (!fit->crease && fit->count > 8)
        fit_corners(reader, cell, step, crease_cosine, false, fit);
}

void qni_fit_edge(const qni_sample_reader *reader, const int32_t start[3], int axis,
                  const double step[3], double crease_cosine, qni_sharp_fit *fit) {
    fit->count = 0;
    for (int end = 0; end < 2; ++end)
        for (int n = 0; n < 9; ++n) {
            int32_t point[3] = {start[0], start[1], start[2]};
            point[axis] += end;
            point[axis == 0 ? 1 : 0] += n % 3 - 1;
            point[axis == 2 ? 1 : 2] += n / 3 - 1;
            add(reader, point, step, fit);
        }
    settle(fit, step, crease_cosine);
}
