// SPDX-License-Identifier: MIT
/* STL: triangles with their own corners and a facet normal, binary or text. */
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/number.h"

#include <math.h>
#include <stdio.h>

enum { HEADER_LENGTH = 80, FACET_LENGTH = 50, TEXT_LENGTH = 160 + 12 * QNI_NUMBER_LENGTH };

static int64_t triangle_total(const qn_mesh_view *view) {
    return 2 * view->quad_count + view->triangle_count;
}

qn_status qni_check_stl(const qni_write_job *job, qn_error *error) {
    int64_t count = triangle_total(&job->view);
    if (!job->ascii && count > (int64_t)UINT32_MAX)
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "the mesh has %lld triangles, an STL file holds at most 2^32 - 1: write PLY",
            (long long)count);
    return QN_OK;
}

/* The unit normal of a facet, 0 0 0 when it has no area: readers then take the winding. */
static void facet_normal(const float *a, const float *b, const float *c, float normal[3]) {
    double u[3], v[3], n[3], length = 0;
    for (int i = 0; i < 3; ++i) {
        u[i] = (double)b[i] - (double)a[i];
        v[i] = (double)c[i] - (double)a[i];
    }
    for (int i = 0; i < 3; ++i) {
        n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
        length += n[i] * n[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; ++i)
        normal[i] = length > 0 && isfinite(length) ? (float)(n[i] / length) : 0;
}

static char *put_binary(char *to, const float normal[3], const float *const corners[3]) {
    to = qni_put_f32x3(to, normal);
    for (int c = 0; c < 3; ++c)
        to = qni_put_f32x3(to, corners[c]);
    *to++ = 0;
    *to++ = 0;
    return to;
}

static char *put_text(char *to, const char *text) {
    size_t length = strlen(text);
    memcpy(to, text, length);
    return to + length;
}

static char *put_ascii(char *to, const float normal[3], const float *const corners[3]) {
    to = put_text(to, "facet normal");
    for (int v = -1; v < 3; ++v) {
        if (v >= 0)
            to = put_text(to, "vertex");
        const float *vector = v < 0 ? normal : corners[v];
        for (int a = 0; a < 3; ++a) {
            *to++ = ' ';
            to = qni_format_float(to, vector[a]);
        }
        to = put_text(to, v < 0 ? "\nouter loop\n" : "\n");
    }
    return put_text(to, "endloop\nendfacet\n");
}

static void write_facet(const qni_write_job *job, const uint32_t triangle[3], qni_output *output) {
    const float *corners[3];
    for (int c = 0; c < 3; ++c)
        corners[c] = job->view.positions + 3 * (size_t)triangle[c];
    float normal[3];
    facet_normal(corners[0], corners[1], corners[2], normal);
    char *from = qni_output_reserve(output, job->ascii ? TEXT_LENGTH : FACET_LENGTH);
    char *to = job->ascii ? put_ascii(from, normal, corners) : put_binary(from, normal, corners);
    qni_output_advance(output, (size_t)(to - from));
}

static void write_facets(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    int64_t count = view->quad_count + view->triangle_count;
    for (int64_t i = 0; i < count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 && qni_output_stopped(output, (double)i / (double)count))
            return;
        if (i < view->quad_count) {
            uint32_t pair[6];
            qni_cut_quad(view->quads + 4 * i, qni_along_02(&job->diagonals, i), pair);
            write_facet(job, pair, output);
            write_facet(job, pair + 3, output);
        } else {
            write_facet(job, view->triangles + 3 * (i - view->quad_count), output);
        }
    }
}

void qni_write_stl(const qni_write_job *job, qni_output *output) {
    /* A binary file must not begin with "solid", which is what text files begin with. */
    char header[HEADER_LENGTH + 4] = {0};
    if (job->ascii) {
        qni_output_write(output, "solid quoin\n", 12);
        write_facets(job, output);
        qni_output_write(output, "endsolid quoin\n", 15);
        return;
    }
    snprintf(header, HEADER_LENGTH, "quoin %s binary STL", qn_version());
    qni_put_u32(header + HEADER_LENGTH, (uint32_t)triangle_total(&job->view));
    qni_output_write(output, header, sizeof header);
    write_facets(job, output);
}
