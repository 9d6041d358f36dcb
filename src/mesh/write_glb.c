// SPDX-License-Identifier: MIT
/* GLB (binary glTF 2.0): one JSON chunk, one BIN chunk with positions, normals and triangle
 * indices. Coordinates stay as they are, though glTF says metres and y up; unit and space go to
 * asset.extras. */
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/number.h"

#include <math.h>
#include <stdio.h>

enum { JSON_LENGTH = 4096, CONTAINER_LENGTH = 12 + 8 + 8 };

typedef struct layout {
    int64_t vertex_bytes; /* of the positions, and of the normals when there are any */
    int64_t index_count, index_bytes;
    int64_t bin_bytes;
} layout;

static layout lay_out(const qn_mesh_view *view) {
    layout plan;
    plan.vertex_bytes = 12 * view->vertex_count;
    plan.index_count = 3 * (2 * view->quad_count + view->triangle_count);
    plan.index_bytes = 4 * plan.index_count;
    plan.bin_bytes = plan.vertex_bytes * (view->normals ? 2 : 1) + plan.index_bytes;
    return plan;
}

qn_status qni_check_glb(const qni_write_job *job, qn_error *error) {
    int64_t total = lay_out(&job->view).bin_bytes + CONTAINER_LENGTH + JSON_LENGTH;
    if (total > (int64_t)UINT32_MAX)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the mesh takes %lld bytes, a GLB file holds at most 4 GiB: write PLY",
                        (long long)total);
    return QN_OK;
}

/* Text of our own making or a name from a file: what JSON cannot hold as it is is left out. */
static int put_name(char *to, const char *name) {
    int length = 0;
    for (int i = 0; name && name[i] && i < 64; ++i)
        if ((unsigned char)name[i] >= ' ' && (unsigned char)name[i] < 127 && name[i] != '"' &&
            name[i] != '\\')
            to[length++] = name[i];
    to[length] = 0;
    return length;
}

static void bounds_of(const qn_mesh_view *view, float low[3], float high[3]) {
    for (int a = 0; a < 3; ++a) {
        low[a] = INFINITY;
        high[a] = -INFINITY;
    }
    for (int64_t i = 0; i < 3 * view->vertex_count; ++i) {
        float value = view->positions[i];
        if (isfinite(value)) {
            low[i % 3] = fminf(low[i % 3], value);
            high[i % 3] = fmaxf(high[i % 3], value);
        }
    }
    for (int a = 0; a < 3; ++a)
        if (low[a] > high[a])
            low[a] = high[a] = 0;
}

/* Digits after the decimal point cannot come from printf(): its point depends on the locale. */
static int put_vector(char *to, const float vector[3]) {
    char *at = to;
    *at++ = '[';
    for (int a = 0; a < 3; ++a) {
        if (a)
            *at++ = ',';
        at = qni_format_float(at, vector[a]);
    }
    *at++ = ']';
    *at = 0;
    return (int)(at - to);
}

static int put_asset(char *to, const qn_mesh_view *view) {
    char space[72], unit[72];
    put_name(space, view->space);
    put_name(unit, view->unit);
    int n = sprintf(to, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"quoin %s\"", qn_version());
    if (*space || *unit)
        n += sprintf(to + n, ",\"extras\":{\"space\":\"%s\",\"unit\":\"%s\"}", space, unit);
    return n + sprintf(to + n, "},\"scene\":0,\"scenes\":[{%s}]",
                       view->vertex_count ? "\"nodes\":[0]" : "\"name\":\"empty\"");
}

static int put_views(char *to, const layout *plan, bool normals) {
    int n = sprintf(to, ",\"buffers\":[{\"byteLength\":%lld}],\"bufferViews\":[",
                    (long long)plan->bin_bytes);
    int64_t offset = 0;
    for (int i = 0; i < (normals ? 2 : 1); ++i, offset += plan->vertex_bytes)
        n += sprintf(to + n,
                     "%s{\"buffer\":0,\"byteOffset\":%lld,\"byteLength\":%lld,\"target\":34962}",
                     i ? "," : "", (long long)offset, (long long)plan->vertex_bytes);
    if (plan->index_count)
        n += sprintf(to + n,
                     ",{\"buffer\":0,\"byteOffset\":%lld,\"byteLength\":%lld,\"target\":34963}",
                     (long long)offset, (long long)plan->index_bytes);
    return n + sprintf(to + n, "]");
}

static int put_accessors(char *to, const qn_mesh_view *view, const layout *plan) {
    float low[3], high[3];
    bounds_of(view, low, high);
    int n = sprintf(to,
                    ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%lld,"
                    "\"type\":\"VEC3\",\"min\":",
                    (long long)view->vertex_count);
    n += put_vector(to + n, low);
    n += sprintf(to + n, ",\"max\":");
    n += put_vector(to + n, high);
    n += sprintf(to + n, "}");
    int next = 1;
    if (view->normals)
        n += sprintf(to + n,
                     ",{\"bufferView\":%d,\"componentType\":5126,\"count\":%lld,\"type\":\"VEC3\"}",
                     next++, (long long)view->vertex_count);
    if (plan->index_count)
        n += sprintf(
            to + n,
            ",{\"bufferView\":%d,\"componentType\":5125,\"count\":%lld,\"type\":\"SCALAR\"}", next,
            (long long)plan->index_count);
    return n + sprintf(to + n, "]");
}

/* A mesh without faces becomes points (mode 0): glTF has no empty arrays. */
static int put_mesh(char *to, const qn_mesh_view *view, const layout *plan) {
    int n = sprintf(to,
                    ",\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{"
                    "\"baseColorFactor\":[0.8,0.78,0.74,1],\"metallicFactor\":0,"
                    "\"roughnessFactor\":0.7},\"doubleSided\":true}],"
                    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0%s}",
                    view->normals ? ",\"NORMAL\":1" : "");
    if (plan->index_count)
        n +=
            sprintf(to + n, ",\"indices\":%d,\"material\":0,\"mode\":4}]}]", view->normals ? 2 : 1);
    else
        n += sprintf(to + n, ",\"mode\":0}]}]");
    return n;
}

static int put_json(char *to, const qn_mesh_view *view, const layout *plan) {
    int n = put_asset(to, view);
    if (view->vertex_count) {
        n += put_views(to + n, plan, view->normals != NULL);
        n += put_accessors(to + n, view, plan);
        n += put_mesh(to + n, view, plan);
    }
    to[n++] = '}';
    while (n % 4)
        to[n++] = ' ';
    return n;
}

static void write_floats(const float *values, int64_t count, double start, qni_output *output) {
    for (int64_t i = 0; i < count; i += 3) {
        if (i % (3 * QNI_PROGRESS_STEP) == 0 &&
            qni_output_stopped(output, start + 0.3 * (double)i / (double)count))
            return;
        qni_put_f32x3(qni_output_reserve(output, 12), values + i);
        qni_output_advance(output, 12);
    }
}

static void write_indices(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    int64_t count = view->quad_count + view->triangle_count;
    for (int64_t i = 0; i < count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 &&
            qni_output_stopped(output, 0.6 + 0.4 * (double)i / (double)count))
            return;
        uint32_t pair[6];
        const uint32_t *indices = pair;
        int corners = 6;
        if (i < view->quad_count) {
            qni_cut_quad(view->quads + 4 * i, qni_along_02(&job->diagonals, i), pair);
        } else {
            indices = view->triangles + 3 * (i - view->quad_count);
            corners = 3;
        }
        char *to = qni_output_reserve(output, sizeof pair);
        for (int c = 0; c < corners; ++c)
            to = qni_put_u32(to, indices[c]);
        qni_output_advance(output, 4 * (size_t)corners);
    }
}

void qni_write_glb(const qni_write_job *job, qni_output *output) {
    const qn_mesh_view *view = &job->view;
    layout plan = lay_out(view);
    char *start = qni_output_reserve(output, CONTAINER_LENGTH + JSON_LENGTH);
    uint32_t json_length = (uint32_t)put_json(start + 20, view, &plan);
    bool with_bin = view->vertex_count > 0;
    int64_t total = 20 + (int64_t)json_length + (with_bin ? 8 + plan.bin_bytes : 0);
    char *to = qni_put_u32(start, 0x46546c67); /* "glTF" */
    to = qni_put_u32(to, 2);
    to = qni_put_u32(to, (uint32_t)total);
    to = qni_put_u32(to, json_length);
    to = qni_put_u32(to, 0x4e4f534a) + json_length; /* "JSON" */
    if (with_bin) {
        to = qni_put_u32(to, (uint32_t)plan.bin_bytes);
        to = qni_put_u32(to, 0x004e4942); /* "BIN" */
    }
    qni_output_advance(output, (size_t)(to - start));
    if (!with_bin)
        return;
    write_floats(view->positions, 3 * view->vertex_count, 0, output);
    if (view->normals)
        write_floats(view->normals, 3 * view->vertex_count, 0.3, output);
    write_indices(job, output);
}
