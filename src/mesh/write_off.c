// SPDX-License-Identifier: MIT
/* OFF: text, "NOFF" with normals. */
#include "mesh/format.h"
#include "mesh/number.h"

#include <stdio.h>

static char *put_vector(char *to, const float *vector) {
    for (int a = 0; a < 3; ++a) {
        to = qni_format_float(to, vector[a]);
        *to++ = ' ';
    }
    return to;
}

static void write_vertices(const qn_mesh_view *view, qni_output *output) {
    for (int64_t i = 0; i < view->vertex_count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 &&
            qni_output_stopped(output, 0.6 * (double)i / (double)view->vertex_count))
            return;
        char *from = qni_output_reserve(output, 6 * QNI_NUMBER_LENGTH);
        char *to = put_vector(from, view->positions + 3 * i);
        if (view->normals)
            to = put_vector(to, view->normals + 3 * i);
        to[-1] = '\n';
        qni_output_advance(output, (size_t)(to - from));
    }
}

static void write_faces(const qn_mesh_view *view, qni_output *output) {
    int64_t count = view->quad_count + view->triangle_count;
    for (int64_t i = 0; i < count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 &&
            qni_output_stopped(output, 0.6 + 0.4 * (double)i / (double)count))
            return;
        int corners = i < view->quad_count ? 4 : 3;
        const uint32_t *face =
            corners == 4 ? view->quads + 4 * i : view->triangles + 3 * (i - view->quad_count);
        char *from = qni_output_reserve(output, 5 * QNI_NUMBER_LENGTH);
        char *to = from;
        *to++ = (char)('0' + corners);
        for (int c = 0; c < corners; ++c) {
            *to++ = ' ';
            to = qni_format_integer(to, face[c]);
        }
        *to++ = '\n';
        qni_output_advance(output, (size_t)(to - from));
    }
}

void qni_write_off(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    char *header = qni_output_reserve(output, 128);
    int length = snprintf(
        header, 128, "%s\n# quoin %s\n%lld %lld 0\n", view->normals ? "NOFF" : "OFF", qn_version(),
        (long long)view->vertex_count, (long long)(view->quad_count + view->triangle_count));
    qni_output_advance(output, (size_t)length);
    write_vertices(view, output);
    write_faces(view, output);
}
