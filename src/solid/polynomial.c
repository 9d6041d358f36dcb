// SPDX-License-Identifier: MIT
/* Roots by way of the derivative's roots: between two of them a polynomial rises or falls, and
 * halving cannot fail. */
#include "solid/polynomial.h"

#include <math.h>

static double at(int degree, const double *c, double t) {
    double value = c[degree];
    for (int i = degree - 1; i >= 0; --i)
        value = value * t + c[i];
    return value;
}

/* Newton's steps kept within the bracket. */
static double root_between(int degree, const double *c, const double *slope, double low,
                           double high) {
    bool rises = at(degree, c, low) < at(degree, c, high);
    double t = 0.5 * (low + high);
    for (int i = 0; i < 200; ++i) {
        double value = at(degree, c, t);
        if (value == 0)
            return t;
        if ((value < 0) == rises)
            low = t;
        else
            high = t;
        double next = t - value / at(degree - 1, slope, t);
        if (!(next > low && next < high))
            next = 0.5 * (low + high);
        if (fabs(next - t) <= QNI_EPSILON * fabs(t) || next == low || next == high)
            return next;
        t = next;
    }
    return t;
}

int qni_polynomial_roots(int degree, const double c[5], double low, double high, double roots[4]) {
    if (degree == 0)
        return 0;
    double slope[5], turns[6];
    for (int i = 0; i < degree; ++i)
        slope[i] = (i + 1) * c[i + 1];
    int turn_count = 1 + qni_polynomial_roots(degree - 1, slope, low, high, turns + 1), count = 0;
    turns[0] = low;
    turns[turn_count++] = high;
    for (int i = 0; i + 1 < turn_count; ++i)
        if ((at(degree, c, turns[i]) < 0) != (at(degree, c, turns[i + 1]) < 0))
            roots[count++] = root_between(degree, c, slope, turns[i], turns[i + 1]);
    return count;
}

static double clamped(double t) {
    return t < 0 ? 0 : t > 1 ? 1 : t;
}

/* What can mend a wrong parity: dropping the crossing nearest to an end within, or taking the one
 * just beyond it. */
static void mend(const double *places, int count, int *first, int *last) {
    bool some = *first < *last;
    double cost[4] = {some ? places[*first] : QNI_INFINITY,
                      some ? 1 - places[*last - 1] : QNI_INFINITY,
                      *first > 0 ? -places[*first - 1] : QNI_INFINITY,
                      *last < count ? places[*last] - 1 : QNI_INFINITY};
    int best = 0;
    for (int i = 1; i < 4; ++i)
        best = cost[i] < cost[best] ? i : best;
    *first += best == 0 ? 1 : best == 2 ? -1 : 0;
    *last += best == 1 ? -1 : best == 3 ? 1 : 0;
}

int qni_match_ends(double *places, int count, bool inside_at_0, bool inside_at_1) {
    int first = 0, last = count;
    bool differ = inside_at_0 != inside_at_1;
    if (count == 0) {
        places[0] = 0;
        return differ;
    }
    while (first < last && places[first] < 0)
        ++first;
    while (last > first && places[last - 1] > 1)
        --last;
    if (((last - first) % 2 != 0) != differ)
        mend(places, count, &first, &last);
    for (int i = first; i < last; ++i)
        places[i - first] = clamped(places[i]);
    return last - first;
}
