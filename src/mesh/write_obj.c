// SPDX-License-Identifier: MIT
/* OBJ: text with the fewest digits that read back to the same floats. */
#include "mesh/format.h"
#include "mesh/number.h"

#include <stdio.h>

enum { FACE_LENGTH = 4 + 8 * QNI_NUMBER_LENGTH };

static void write_vectors(const char *key, const float *vectors, int64_t count, double start,
                          qni_output *output) {
    size_t key_length = strlen(key);
    for (int64_t i = 0; i < count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 &&
            qni_output_stopped(output, start + 0.3 * (double)i / (double)count))
            return;
        char *from = qni_output_reserve(output, 8 + 3 * QNI_NUMBER_LENGTH);
        char *to = from;
        memcpy(to, key, key_length);
        to += key_length;
        for (int a = 0; a < 3; ++a) {
            *to++ = ' ';
            to = qni_format_float(to, vectors[3 * i + a]);
        }
        *to++ = '\n';
        qni_output_advance(output, (size_t)(to - from));
    }
}

static char *put_corner(char *to, uint32_t vertex, bool with_normal) {
    char *from = to + 1;
    *to++ = ' ';
    to = qni_format_integer(to, (uint64_t)vertex + 1);
    if (!with_normal)
        return to;
    size_t length = (size_t)(to - from);
    *to++ = '/';
    *to++ = '/';
    memcpy(to, from, length);
    return to + length;
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
        char *from = qni_output_reserve(output, FACE_LENGTH);
        char *to = from;
        *to++ = 'f';
        for (int c = 0; c < corners; ++c)
            to = put_corner(to, face[c], view->normals != NULL);
        *to++ = '\n';
        qni_output_advance(output, (size_t)(to - from));
    }
}

void qni_write_obj(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    char *header = qni_output_reserve(output, 64);
    qni_output_advance(output, (size_t)snprintf(header, 64, "# quoin %s\n", qn_version()));
    write_vectors("v", view->positions, view->vertex_count, 0, output);
    if (view->normals)
        write_vectors("vn", view->normals, view->vertex_count, 0.3, output);
    write_faces(view, output);
}
