// SPDX-License-Identifier: MIT
/* PLY: binary little-endian, or text. Nothing in the file changes from run to run. */
#include "mesh/format.h"
#include "mesh/number.h"

#include <stdio.h>

/* Names come from volume files: what would break a line of the header is left out. */
static int put_comment(char *to, const char *key, const char *text) {
    if (!text || !*text)
        return 0;
    int length = sprintf(to, "comment %s ", key);
    for (int i = 0; text[i] && i < 64; ++i)
        if ((unsigned char)text[i] >= ' ')
            to[length++] = text[i];
    to[length++] = '\n';
    return length;
}

static void write_header(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    char *at = qni_output_reserve(output, 1024);
    int length = snprintf(at, 1024, "ply\nformat %s 1.0\ncomment quoin %s\n",
                          job->ascii ? "ascii" : "binary_little_endian", qn_version());
    length += put_comment(at + length, "space", view->space);
    length += put_comment(at + length, "unit", view->unit);
    length += snprintf(
        at + length, 1024 - (size_t)length,
        "element vertex %lld\nproperty float x\nproperty float y\nproperty float z\n%s%s"
        "element face %lld\nproperty list uchar uint vertex_indices\nend_header\n",
        (long long)view->vertex_count,
        view->normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
        job->curvature[0] ? "property float mean_curvature\nproperty float gaussian_curvature\n"
                          : "",
        (long long)(view->quad_count + view->triangle_count));
    qni_output_advance(output, (size_t)length);
}

static char *put_vector(char *to, const float *vector, bool ascii) {
    if (!ascii)
        return qni_put_f32x3(to, vector);
    for (int a = 0; a < 3; ++a) {
        to = qni_format_float(to, vector[a]);
        *to++ = ' ';
    }
    return to;
}

static char *put_curvature(char *to, const qni_write_job *job, int64_t vertex) {
    for (int k = 0; k < 2; ++k) {
        const float value = job->curvature[k][vertex];
        to = job->ascii ? qni_format_float(to, value) : qni_put_f32(to, value);
        if (job->ascii)
            *to++ = ' ';
    }
    return to;
}

static void write_vertices(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    for (int64_t i = 0; i < view->vertex_count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 &&
            qni_output_stopped(output, 0.5 * (double)i / (double)view->vertex_count))
            return;
        char *start = qni_output_reserve(output, 8 * QNI_NUMBER_LENGTH);
        char *to = put_vector(start, view->positions + 3 * i, job->ascii);
        if (view->normals)
            to = put_vector(to, view->normals + 3 * i, job->ascii);
        if (job->curvature[0])
            to = put_curvature(to, job, i);
        if (job->ascii)
            to[-1] = '\n';
        qni_output_advance(output, (size_t)(to - start));
    }
}

static char *put_face(char *to, const uint32_t *corners, int count, bool ascii) {
    *to++ = (char)(ascii ? '0' + count : count);
    for (int c = 0; c < count; ++c) {
        if (ascii)
            *to++ = ' ';
        to = ascii ? qni_format_integer(to, corners[c]) : qni_put_u32(to, corners[c]);
    }
    if (ascii)
        *to++ = '\n';
    return to;
}

static void write_faces(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    int64_t count = view->quad_count + view->triangle_count;
    for (int64_t i = 0; i < count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 &&
            qni_output_stopped(output, 0.5 + 0.5 * (double)i / (double)count))
            return;
        char *start = qni_output_reserve(output, 5 * QNI_NUMBER_LENGTH);
        char *to =
            i < view->quad_count
                ? put_face(start, view->quads + 4 * i, 4, job->ascii)
                : put_face(start, view->triangles + 3 * (i - view->quad_count), 3, job->ascii);
        qni_output_advance(output, (size_t)(to - start));
    }
}

void qni_write_ply(const qni_write_job *job, qni_output *output) {
    write_header(job, output);
    write_vertices(job, output);
    write_faces(job, output);
}
