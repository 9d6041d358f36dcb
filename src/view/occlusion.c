// SPDX-License-Identifier: MIT
/* Ambient obscurance in the picture plane: McGuire, Mara and Luebke, "Scalable ambient obscurance",
 * 2012, section 2.3, with a turn of the samples that repeats every 4 x 4 pixels and a blur of that
 * size. */
#include "view/occlusion.h"
#include "core/parallel.h"

#include <stdlib.h>

enum { SAMPLES = 28, TURNS = 7, TILE = 4, LARGEST_REACH = 160 /* pixels */ };

static const double reach = 0.13; /* of the picture's height, in the world */
static const double strength = 3.07;
static const double bias = 0.012; /* of the reach: what is flat stays open */

typedef struct frame {
    const qni_camera *camera;
    const qni_pixel *pixels;
    int32_t width, height;
    double radius; /* world units */
    double spiral[TILE * TILE][SAMPLES]
                 [2]; /* where to look, for each turn; within the unit circle */
} frame;

/* The turns of one tile's pixels differ as much as they can from their neighbours'. */
static void find_spirals(frame *f) {
    // clang-format off
    static const int turn_of[TILE * TILE] = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
    // clang-format on
    const double round = 2 * 3.14159265358979323846;
    for (int tile = 0; tile < TILE * TILE; ++tile)
        for (int i = 0; i < SAMPLES; ++i) {
            double turn = turn_of[tile] / (double)(TILE * TILE);
            double share = (i + turn + 0.5 / (TILE * TILE)) / SAMPLES;
            f->spiral[tile][i][0] = share * cos(round * (turn + TURNS * share));
            f->spiral[tile][i][1] = share * sin(round * (turn + TURNS * share));
        }
}

static double distance_at(const frame *f, int64_t at) {
    return f->camera->distance / (double)f->pixels[at].inverse;
}

/* Where a pixel's sample lies, in camera coordinates with the eye at the origin. */
static void place_of(const frame *f, int32_t column, int32_t row, double out[3]) {
    double distance = distance_at(f, (int64_t)row * f->width + column);
    double unit = distance / f->camera->focal;
    out[0] = ((column + 0.5) * QNI_SAMPLES - f->camera->half_width) * unit;
    out[1] = ((row + 0.5) * QNI_SAMPLES - f->camera->half_height) * unit;
    out[2] = -distance;
}

static double hidden_by(const frame *f, const double place[3], const float normal[3],
                        int32_t column, int32_t row) {
    double other[3], square = 0, along = 0;
    place_of(f, column, row, other);
    for (int a = 0; a < 3; ++a) {
        double d = (other[a] - place[a]) / f->radius;
        square += d * d;
        along += d * (double)normal[a];
    }
    double near = fmax(0, 1 - square);
    return near * near * near * fmax(0, along - bias) / (square + 0.01);
}

static float open_at(const frame *f, int32_t column, int32_t row) {
    const qni_pixel *pixel = f->pixels + (int64_t)row * f->width + column;
    if (pixel->inverse <= 0)
        return 1;
    double place[3], sum = 0;
    place_of(f, column, row, place);
    double pixels = f->radius * f->camera->focal / (-place[2] * QNI_SAMPLES);
    pixels = fmin(pixels, LARGEST_REACH);
    const double(*spiral)[2] = f->spiral[row % TILE * TILE + column % TILE];
    for (int i = 0; i < SAMPLES; ++i) {
        int32_t c = column + (int32_t)lrint(pixels * spiral[i][0]);
        int32_t r = row + (int32_t)lrint(pixels * spiral[i][1]);
        if (c < 0 || r < 0 || c >= f->width || r >= f->height || (c == column && r == row) ||
            f->pixels[(int64_t)r * f->width + c].inverse <= 0)
            continue;
        sum += hidden_by(f, place, pixel->normal, c, r);
    }
    return (float)fmax(0, 1 - strength * sum / SAMPLES);
}

/* The mean over one tile round a pixel, of those that lie on the same surface. */
static float blur_at(const frame *f, const float *rough, int32_t column, int32_t row) {
    int64_t at = (int64_t)row * f->width + column;
    if (f->pixels[at].inverse <= 0)
        return 1;
    double here = distance_at(f, at), sum = 0, weight = 0;
    for (int32_t r = row - TILE / 2; r <= row + TILE / 2; ++r)
        for (int32_t c = column - TILE / 2; c <= column + TILE / 2; ++c) {
            if (c < 0 || r < 0 || c >= f->width || r >= f->height)
                continue;
            int64_t other = (int64_t)r * f->width + c;
            if (f->pixels[other].inverse <= 0)
                continue;
            double apart = fabs(distance_at(f, other) - here) / f->radius;
            double rim =
                (abs(r - row) == TILE / 2 ? 0.5 : 1) * (abs(c - column) == TILE / 2 ? 0.5 : 1);
            double share = rim * fmax(0, 1 - 4 * apart);
            sum += share * (double)rough[other];
            weight += share;
        }
    return weight > 0 ? (float)(sum / weight) : rough[at];
}

void qni_find_occlusion(const qn_context *context, const qni_camera *camera, int32_t width,
                        int32_t height, const qni_pixel *pixels, float *rough, float *open) {
    (void)context;
    frame f = {.camera = camera, .pixels = pixels, .width = width, .height = height};
    f.radius = reach * camera->extent;
    find_spirals(&f);
#pragma omp parallel for schedule(dynamic, 4) num_threads(qn_context_threads(context))
    for (int32_t row = 0; row < height; ++row)
        for (int32_t column = 0; column < width; ++column)
            rough[(int64_t)row * width + column] = open_at(&f, column, row);
#pragma omp parallel for schedule(dynamic, 4) num_threads(qn_context_threads(context))
    for (int32_t row = 0; row < height; ++row)
        for (int32_t column = 0; column < width; ++column)
            open[(int64_t)row * width + column] = blur_at(&f, rough, column, row);
}
