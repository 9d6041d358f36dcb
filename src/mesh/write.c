// SPDX-License-Identifier: MIT
/* Writing a mesh: which format is meant, and the file that appears whole or not at all. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/format.h"

#include <strings.h>

static const char *const format_names[] = {"ply", "obj", "stl", "off", "glb"};

qni_mesh_format qni_mesh_format_named(const char *name, size_t length, bool reading) {
    if (reading && length == 4 && strncasecmp(name, "gltf", 4) == 0)
        return QNI_GLB;
    for (int format = QNI_PLY; format < QNI_NO_FORMAT; ++format)
        if (length == 3 && strncasecmp(name, format_names[format], 3) == 0)
            return (qni_mesh_format)format;
    return QNI_NO_FORMAT;
}

qni_mesh_format qni_mesh_format_of_path(const char *path, bool reading) {
    size_t length = strlen(path);
    if (reading && length > 3 && strcasecmp(path + length - 3, ".gz") == 0)
        length -= 3;
    size_t start = length;
    while (start > 0 && path[start - 1] != '.' && path[start - 1] != '/')
        --start;
    if (start == 0 || path[start - 1] != '.')
        return QNI_NO_FORMAT;
    return qni_mesh_format_named(path + start, length - start, reading);
}

static qn_status choose_format(const char *path, const qn_mesh_write_options *options,
                               qni_mesh_format *format_out, qn_error *error) {
    bool named = options && options->format[0];
    if (named) {
        const char *name = options->format;
        *format_out = qni_mesh_format_named(name, strnlen(name, sizeof options->format), false);
    } else {
        *format_out = qni_mesh_format_of_path(path, false);
    }
    if (*format_out != QNI_NO_FORMAT)
        return QN_OK;
    if (named)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "'%.8s' is no mesh format: take ply, obj, stl, off or glb",
                        options->format);
    return qni_fail(
        error, QN_ERROR_INVALID_ARGUMENT,
        "the name '%.200s' does not say which format is meant: end it in .ply, .obj, .stl, .off "
        "or .glb, or give the format",
        path);
}

static qn_status write_split(qn_context *context, const qn_mesh *mesh, const char *path,
                             const qn_mesh_write_options *options, qn_error *error) {
    qn_mesh_write_options plain = *options;
    plain.split_normals = false;
    qn_mesh *split;
    QN_TRY(qn_mesh_split_normals(context, mesh, &split, error));
    const qn_status status = qn_mesh_write(context, split, path, &plain, error);
    qn_mesh_destroy(split);
    return status;
}

static qn_status write_to(const qni_write_job *job, qni_mesh_format format, const char *path,
                          qn_error *error) {
    static void (*const writers[])(const qni_write_job *, qni_output *) = {
        qni_write_ply, qni_write_obj, qni_write_stl, qni_write_off, qni_write_glb};
    qni_output output;
    QN_TRY(qni_output_open(&output, job->context, path, error));
    writers[format](job, &output);
    return qni_output_commit(&output, error);
}

static qn_status write_job(qni_write_job *job, qni_mesh_format format, const char *path,
                           qn_error *error) {
    if (format == QNI_STL)
        QN_TRY(qni_check_stl(job, error));
    if (format == QNI_GLB)
        QN_TRY(qni_check_glb(job, error));
    if (format != QNI_STL && format != QNI_GLB)
        return write_to(job, format, path, error);
    QN_TRY(qni_diagonals_choose(job->context, &job->view, &job->diagonals, error));
    const qn_status status = write_to(job, format, path, error);
    qni_diagonals_free(&job->diagonals);
    return status;
}

static qn_status write_curvature(const qn_mesh *mesh, qni_write_job *job, qni_mesh_format format,
                                 const char *path, qn_error *error) {
    if (format != QNI_PLY)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "'%.200s': only PLY files hold curvature: end the name in .ply, or leave "
                        "the curvature out",
                        path);
    const int64_t count = job->view.vertex_count;
    float *both = qni_alloc(job->context, 2 * count + 1, sizeof *both);
    if (!both)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "no memory for the curvature of %lld vertices: leave it out",
                        (long long)count);
    job->curvature[0] = both;
    job->curvature[1] = both + count;
    qn_status status =
        qn_mesh_get_curvature(job->context, mesh, job->curvature[0], job->curvature[1], error);
    if (status == QN_OK)
        status = write_job(job, format, path, error);
    qni_free(job->context, both, 2 * count + 1, sizeof *both);
    return status;
}

qn_status qn_mesh_write(qn_context *context, const qn_mesh *mesh, const char *path,
                        const qn_mesh_write_options *options, qn_error *error) {
    QNI_CHECK_OPTIONS(options, "qn_mesh_write_options_init", error);
    qni_mesh_format format;
    QN_TRY(choose_format(path, options, &format, error));
    if (options && options->split_normals && options->curvature)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "normals split at creases and curvature do not go together: choose one");
    if (options && options->split_normals && !options->skip_normals && format != QNI_STL &&
        format != QNI_OFF)
        return write_split(context, mesh, path, options, error);
    qni_write_job job = {
        .context = context, .view = qn_mesh_get_view(mesh), .ascii = options && options->ascii};
    if (options && options->skip_normals)
        job.view.normals = NULL;
    if (options && options->curvature)
        return write_curvature(mesh, &job, format, path, error);
    return write_job(&job, format, path, error);
}
