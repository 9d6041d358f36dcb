// SPDX-License-Identifier: MIT
#include "cms/way.h"

#include <string.h>

enum { MOST_TRIES = 40 };

static int sample_count(const qni_way *way) {
    return way->side[0] * way->side[1] * way->side[2];
}

void qni_way_point(const qni_way *way, int sample, double point[3]) {
    for (int k = 0; k < 3; ++k) {
        const int at = sample % way->side[k], steps = way->side[k] - 1;
        sample /= way->side[k];
        point[k] = way->low[k];
        if (steps > 0)
            point[k] += (way->high[k] - way->low[k]) * at / steps;
    }
}

bool qni_way_init(qni_way *way, const qn_solid *solid, const double low[3], const double high[3]) {
    double points[QNI_WAY_SAMPLES][3];
    way->solid = solid;
    for (int k = 0; k < 3; ++k) {
        way->low[k] = low[k];
        way->high[k] = high[k];
        way->side[k] = low[k] < high[k] ? QNI_WAY_SIDE : 1;
    }
    const int count = sample_count(way);
    for (int n = 0; n < count; ++n)
        qni_way_point(way, n, points[n]);
    memset(way->blocked, 0, sizeof way->blocked);
    return qni_solid_inside(solid, count, (const double(*)[3])points, way->inside) == QN_OK;
}

static bool is_on_border(const qni_way *way, int sample) {
    for (int k = 0; k < 3; sample /= way->side[k++])
        if (sample % way->side[k] == 0 || sample % way->side[k] == way->side[k] - 1)
            return true;
    return false;
}

/* Breadth first; the first end that is reached, or -1. */
static int search(qni_way *way, bool inside, const bool *starts, bool border) {
    int16_t queue[QNI_WAY_SAMPLES];
    int head = 0, tail = 0;
    const int count = sample_count(way);
    for (int n = 0; n < count; ++n) {
        way->before[n] = starts[n] ? (int16_t)n : -1;
        if (starts[n])
            queue[tail++] = (int16_t)n;
    }
    while (head < tail) {
        const int here = queue[head++];
        if (way->end[here])
            return here;
        for (int axis = 0, stride = 1; axis < 3; stride *= way->side[axis++])
            for (int up = 0; up < 2; ++up) {
                const int at = here / stride % way->side[axis], low = up ? here : here - stride;
                if (at == (up ? way->side[axis] - 1 : 0))
                    continue;
                const int next = up ? here + stride : low;
                if (way->before[next] >= 0 || way->inside[next] != inside ||
                    way->blocked[axis][low] || (border && !is_on_border(way, next)))
                    continue;
                way->before[next] = (int16_t)here;
                queue[tail++] = (int16_t)next;
            }
    }
    return -1;
}

/* Does any step of the way meet the surface? The first that does is blocked. */
static bool is_clear(qni_way *way, int end) {
    for (int here = end; way->before[here] != here; here = way->before[here]) {
        const int next = way->before[here], low = here < next ? here : next;
        const int step = (here < next ? next : here) - low;
        const int axis = step == 1 && way->side[0] > 1        ? 0
                         : step < way->side[0] * way->side[1] ? 1
                                                              : 2;
        double a[3], b[3];
        qni_crossing found[4];
        int32_t count = 0;
        qni_way_point(way, low, a);
        qni_way_point(way, low + step, b);
        if (way->solid->ops->crossings(way->solid, a, b, 4, found, &count) == QN_OK && count == 0)
            continue;
        way->blocked[axis][low] = true;
        return false;
    }
    return true;
}

int qni_way_find(qni_way *way, bool inside, const bool *starts, bool border) {
    for (int n = 0; n < MOST_TRIES; ++n) {
        const int end = search(way, inside, starts, border);
        if (end < 0 || is_clear(way, end))
            return end;
    }
    return -1;
}
