// SPDX-License-Identifier: MIT
/* Shading: a warm grey front and a blue-red back under a key light, a fill light and a sky. */
#include "view/shade.h"
#include "core/parallel.h"

#include <string.h>

typedef struct colour {
    float r, g, b;
} colour;

/* Linear light. The back of a face shall be told from its front at a glance, in shade as well. */
static const colour front_colour = {0.62f, 0.555f, 0.475f};
static const colour back_colour = {0.25f, 0.11f, 0.17f};
static const colour key_light = {0.98f, 0.94f, 0.87f};
static const colour fill_light = {0.16f, 0.19f, 0.25f};
static const colour sky = {0.31f, 0.34f, 0.39f};
static const colour ground = {0.15f, 0.13f, 0.12f};
/* Unit vectors in camera coordinates: the key light from the upper left, the fill light from the
 * right. */
static const double key_direction[3] = {-0.4767313, 0.5959141, 0.6462334};
static const double fill_direction[3] = {0.8164966, -0.0816497, 0.5715476};
static const double gloss = 0.10, gloss_power = 28;

static void normalise(double v[3]) {
    double length = sqrt(qni_dot(v, v));
    for (int a = 0; a < 3; ++a)
        v[a] = length > 0 && isfinite(length) ? v[a] / length : a == 2;
}

static void to_camera(const qni_camera *camera, const double world[3], double out[3]) {
    out[0] = qni_dot(camera->right, world);
    out[1] = qni_dot(camera->up, world);
    out[2] = qni_dot(camera->toward, world);
}

/* Of a triangle, or of a quad by its diagonals, so that both halves of a quad look alike. */
static void face_normal(const qn_mesh_view *view, const uint32_t corners[4], int count,
                        double normal[3]) {
    const float *p[4];
    for (int c = 0; c < 4; ++c)
        p[c] = view->positions + 3 * (size_t)corners[c];
    double u[3], v[3];
    for (int a = 0; a < 3; ++a) {
        u[a] = (double)p[count == 4 ? 2 : 1][a] - (double)p[0][a];
        v[a] = (double)p[count == 4 ? 3 : 2][a] - (double)p[count == 4 ? 1 : 0][a];
    }
    normalise(u); /* so that tiny and huge meshes do not leave the range of numbers */
    normalise(v);
    for (int a = 0; a < 3; ++a)
        normal[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
}

/* The weights of a piece's corners at a sample, in the world (perspective taken back). */
static void corner_weights(const qni_seen *const s[3], int64_t x, int64_t y, double weights[3]) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        weights[c] = (double)qni_side(s[(c + 1) % 3], s[(c + 2) % 3], x, y) * (double)s[c]->inverse;
        sum += weights[c];
    }
    for (int c = 0; c < 3; ++c)
        weights[c] = sum != 0 ? weights[c] / sum : 1.0 / 3;
}

static double clamp01(double value) {
    return value < 0 ? 0 : value > 1 ? 1 : value;
}

/* How much of a mesh edge a sample shows: lines 1.3 pixels wide, fainter where faces are small. */
static double edge_cover(const qni_seen *const s[4], int count, int64_t x, int64_t y) {
    double pixel = QNI_SUBPIXEL * QNI_SAMPLES, nearest = 1e30, longest = 0;
    for (int c = 0; c < count; ++c) {
        const qni_seen *a = s[c], *b = s[(c + 1) % count];
        double ex = (double)b->x - a->x, ey = (double)b->y - a->y;
        double px = (double)(x - a->x), py = (double)(y - a->y);
        double square = ex * ex + ey * ey;
        double along = square > 0 ? clamp01((px * ex + py * ey) / square) : 0;
        double dx = px - along * ex, dy = py - along * ey;
        nearest = fmin(nearest, sqrt(dx * dx + dy * dy) / pixel);
        longest = fmax(longest, sqrt(square) / pixel);
    }
    double line = clamp01((0.65 - nearest) / 0.25 + 0.5);
    return 0.8 * line * clamp01((longest - 1) / 9);
}

static void add_light(const double normal[3], const double up[3], bool front, double edge,
                      qni_pixel *pixel) {
    colour material = front ? front_colour : back_colour;
    double key = fmax(0, (qni_dot(normal, key_direction) + 0.12) / 1.12); /* a soft terminator */
    double fill = fmax(0, qni_dot(normal, fill_direction));
    double half[3] = {key_direction[0], key_direction[1], key_direction[2] + 1};
    normalise(half);
    double shine = gloss * pow(fmax(0, qni_dot(normal, half)), gloss_power);
    double upward = 0.5 + 0.5 * qni_dot(normal, up);
    double share = 1.0 / (QNI_SAMPLES * QNI_SAMPLES), bare = share * (1 - edge);
    const float *m = &material.r, *k = &key_light.r, *f = &fill_light.r, *s = &sky.r,
                *g = &ground.r;
    for (int i = 0; i < 3; ++i) {
        double direct =
            (double)m[i] * (key * (double)k[i] + fill * (double)f[i]) + shine * (double)k[i];
        double ambient = (double)m[i] * (upward * (double)s[i] + (1 - upward) * (double)g[i]);
        pixel->direct[i] += (float)(bare * direct + share * edge * 0.012);
        pixel->ambient[i] += (float)(bare * ambient);
    }
    pixel->covered += (float)share;
}

static void shade_sample(const qni_scene *scene, int64_t piece, int64_t x, int64_t y, float inverse,
                         qni_pixel *pixel) {
    const qn_mesh_view *view = scene->view;
    uint32_t face[4], piece_corner[3];
    int count = qni_face_corners(view, piece / 2, face);
    qni_piece_corners(view, piece, piece_corner);
    const qni_seen *s[4], *outline[4];
    for (int c = 0; c < 4; ++c) {
        s[c] = scene->seen + piece_corner[c % 3];
        outline[c] = scene->seen + face[c];
    }
    double world[3] = {0, 0, 0}, normal[3];
    if (view->normals && !scene->flat) {
        double weights[3];
        corner_weights(s, x, y, weights);
        for (int c = 0; c < 3; ++c)
            for (int a = 0; a < 3; ++a)
                world[a] +=
                    weights[c] * (double)view->normals[3 * (size_t)piece_corner[c] + (size_t)a];
    } else {
        face_normal(view, face, count, world);
    }
    bool front = qni_side(s[0], s[1], s[2]->x, s[2]->y) > 0;
    normalise(world);
    to_camera(scene->camera, world, normal);
    if (!front)
        for (int a = 0; a < 3; ++a)
            normal[a] = -normal[a];
    const double up[3] = {scene->camera->right[2], scene->camera->up[2], scene->camera->toward[2]};
    add_light(normal, up, front, scene->edges ? edge_cover(outline, count, x, y) : 0, pixel);
    if (inverse > pixel->inverse) {
        pixel->inverse = inverse;
        for (int a = 0; a < 3; ++a)
            pixel->normal[a] = (float)normal[a];
    }
}

static void shade_pixel(const qni_scene *scene, int32_t column, int32_t row, qni_pixel *pixel) {
    const qni_visible *visible = scene->visible;
    memset(pixel, 0, sizeof *pixel);
    for (int32_t i = 0; i < QNI_SAMPLES * QNI_SAMPLES; ++i) {
        int64_t sx = (int64_t)column * QNI_SAMPLES + i % QNI_SAMPLES;
        int64_t sy = (int64_t)row * QNI_SAMPLES + i / QNI_SAMPLES;
        int64_t at = sy * visible->width + sx;
        if (visible->piece[at] != QNI_NO_PIECE)
            shade_sample(scene, visible->piece[at], sx * QNI_SUBPIXEL + QNI_SUBPIXEL / 2,
                         sy * QNI_SUBPIXEL + QNI_SUBPIXEL / 2, visible->inverse[at], pixel);
    }
}

void qni_shade_rows(const qni_scene *scene, int32_t first, int32_t last, qni_pixel *pixels) {
    int32_t width = scene->visible->width / QNI_SAMPLES;
#pragma omp parallel for schedule(dynamic, 4) num_threads(qn_context_threads(scene->context))
    for (int32_t row = first; row < last; ++row)
        for (int32_t column = 0; column < width; ++column)
            shade_pixel(scene, column, row, pixels + (int64_t)row * width + column);
}

static uint8_t to_srgb(double light) {
    light = clamp01(light);
    double value = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
    return (uint8_t)lrint(255 * value);
}

/* Nearly white, a little darker towards the bottom. */
static double background(double height, int channel) {
    static const double low[3] = {0.73, 0.75, 0.78}, high[3] = {0.96, 0.97, 0.98};
    double t = height * height * (3 - 2 * height);
    return low[channel] + t * (high[channel] - low[channel]);
}

void qni_develop(const qn_context *context, int32_t width, int32_t height, const qni_pixel *pixels,
                 const float *open, uint8_t *rgb) {
    (void)context;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int32_t row = 0; row < height; ++row)
        for (int32_t column = 0; column < width; ++column) {
            int64_t at = (int64_t)row * width + column;
            const qni_pixel *pixel = pixels + at;
            uint8_t *out = rgb + 3 * ((int64_t)(height - 1 - row) * width + column);
            double free_sky = (double)open[at];
            for (int i = 0; i < 3; ++i) {
                double light = (double)pixel->ambient[i] * free_sky +
                               (double)pixel->direct[i] * (0.45 + 0.55 * free_sky);
                double behind = background((row + 0.5) / height, i);
                out[i] = to_srgb(light + (1 - (double)pixel->covered) * behind);
            }
        }
}
