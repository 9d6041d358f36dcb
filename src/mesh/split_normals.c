// SPDX-License-Identifier: MIT
/* Normals split at creases: round each vertex the corners of faces between two creases share one
 * normal, and a vertex of their own. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct split_job {
    qn_context *context;
    const qn_mesh *mesh;
    int64_t corners;
    uint32_t *next;         /* of each corner: one that shares its vertex, itself at the end */
    uint32_t *vertex;       /* of each corner: its vertex in the new mesh */
    uint32_t (*creases)[2]; /* low end first, ascending */
} split_job;

static int compare_pairs(const void *a, const void *b) {
    const uint32_t *p = a, *q = b;
    if (p[0] != q[0])
        return p[0] < q[0] ? -1 : 1;
    return p[1] < q[1] ? -1 : p[1] > q[1];
}

static bool is_crease(const split_job *job, uint32_t a, uint32_t b) {
    const uint32_t key[2] = {a < b ? a : b, a < b ? b : a};
    const size_t count = (size_t)job->mesh->crease_edge_count;
    return count && bsearch(key, job->creases, count, sizeof key, compare_pairs);
}

static void sort_creases(split_job *job) {
    for (int64_t n = 0; n < job->mesh->crease_edge_count; ++n) {
        const uint32_t *edge = job->mesh->crease_edges + 2 * n;
        job->creases[n][0] = edge[0] < edge[1] ? edge[0] : edge[1];
        job->creases[n][1] = edge[0] < edge[1] ? edge[1] : edge[0];
    }
    if (job->mesh->crease_edge_count)
        qsort(job->creases, (size_t)job->mesh->crease_edge_count, sizeof *job->creases,
              compare_pairs);
}

static uint32_t root_of(uint32_t *next, uint32_t corner) {
    while (next[corner] != corner)
        corner = next[corner] = next[next[corner]];
    return corner;
}

static void join(split_job *job, uint32_t a, uint32_t b) {
    a = root_of(job->next, a);
    b = root_of(job->next, b);
    job->next[a < b ? b : a] = a < b ? a : b; /* the lowest corner is the root */
}

static uint32_t following(uint32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}

/* Across every edge that is no crease, corners at the same end belong together. */
static void join_corners(split_job *job, const qn_halfedges *halfedges) {
    const uint32_t *triangles = job->mesh->triangles;
    for (uint32_t h = 0; h < (uint32_t)job->corners; ++h)
        job->next[h] = h;
    for (uint32_t h = 0; h < (uint32_t)job->corners; ++h) {
        const uint32_t twin = halfedges->twin[h];
        if (twin == QN_NO_HALFEDGE || twin < h ||
            is_crease(job, triangles[h], triangles[following(h)]))
            continue;
        join(job, h, following(twin));
        join(job, following(h), twin);
    }
}

/* The first group of each vertex keeps its number, the others follow in the order of corners. */
static int64_t number_vertices(split_job *job, uint8_t *taken) {
    int64_t count = job->mesh->vertex_count;
    memset(taken, 0, (size_t)count);
    for (int64_t h = 0; h < job->corners; ++h) {
        const uint32_t old = job->mesh->triangles[h], root = root_of(job->next, (uint32_t)h);
        if (root != (uint32_t)h)
            job->vertex[h] = job->vertex[root];
        else
            job->vertex[h] = taken[old] ? (uint32_t)count++ : old;
        taken[old] = 1;
    }
    return count;
}

static void normalize(float normal[3]) {
    const double x = (double)normal[0], y = (double)normal[1], z = (double)normal[2],
                 length = sqrt(x * x + y * y + z * z);
    normal[0] = length > 0 ? (float)(x / length) : 0;
    normal[1] = length > 0 ? (float)(y / length) : 0;
    normal[2] = length > 0 ? (float)(z / length) : 1;
}

/* Add each face's unit normal, times its angle there, to its three vertices. */
static void add_face(qn_mesh *mesh, const uint32_t *triangle) {
    double side[3][3], normal[3], length = 0;
    for (int n = 0; n < 3; ++n)
        for (int k = 0; k < 3; ++k)
            side[n][k] = (double)mesh->positions[3 * (size_t)triangle[(n + 1) % 3] + (size_t)k] -
                         (double)mesh->positions[3 * (size_t)triangle[n] + (size_t)k];
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        normal[k] = side[0][l] * side[1][m] - side[0][m] * side[1][l];
        length += normal[k] * normal[k];
    }
    length = sqrt(length);
    for (int n = 0; n < 3 && length > 0; ++n) {
        const double *out = side[n], *in = side[(n + 2) % 3];
        const double along = -(out[0] * in[0] + out[1] * in[1] + out[2] * in[2]),
                     angle = atan2(length, along);
        for (int k = 0; k < 3; ++k)
            mesh->normals[3 * (size_t)triangle[n] + (size_t)k] +=
                (float)(angle * normal[k] / length);
    }
}

static void fill(const split_job *job, qn_mesh *out) {
    const qn_mesh *mesh = job->mesh;
    memcpy(out->triangles, job->vertex, sizeof *out->triangles * (size_t)job->corners);
    for (int64_t h = 0; h < job->corners; ++h)
        memcpy(out->positions + 3 * (size_t)job->vertex[h],
               mesh->positions + 3 * (size_t)mesh->triangles[h], 3 * sizeof(float));
    memset(out->normals, 0, 3 * sizeof(float) * (size_t)out->vertex_count);
    for (int64_t t = 0; t < out->triangle_count; ++t)
        add_face(out, out->triangles + 3 * t);
    for (int64_t v = 0; v < out->vertex_count; ++v)
        normalize(out->normals + 3 * v);
    memcpy(out->space, mesh->space, sizeof out->space);
    memcpy(out->unit, mesh->unit, sizeof out->unit);
}

static qn_status make_split(split_job *job, qn_mesh **out, qn_error *error) {
    const qn_mesh *mesh = job->mesh;
    uint8_t *taken = qni_alloc(job->context, mesh->vertex_count, 1);
    if (!taken)
        return qni_fail_memory(error, "split normals");
    const int64_t count = number_vertices(job, taken);
    qni_free(job->context, taken, mesh->vertex_count, 1);
    QN_TRY(qni_mesh_alloc(job->context, count, 0, mesh->triangle_count, true, out, error));
    memcpy((*out)->positions, mesh->positions,
           3 * sizeof(float) * (size_t)mesh->vertex_count); /* vertices without faces too */
    fill(job, *out);
    return QN_OK;
}

static qn_status split_triangles(qn_context *context, qn_mesh *mesh, qn_mesh **out,
                                 qn_error *error) {
    split_job job = {.context = context, .mesh = mesh, .corners = 3 * mesh->triangle_count};
    QN_TRY(qn_mesh_build_halfedges(context, mesh, error));
    job.next = qni_alloc(context, job.corners, sizeof *job.next);
    job.vertex = qni_alloc(context, job.corners, sizeof *job.vertex);
    job.creases = qni_alloc(context, mesh->crease_edge_count, sizeof *job.creases);
    qn_status status = QN_OK;
    if (!job.next || !job.vertex || !job.creases) {
        status = qni_fail_memory(error, "split normals");
    } else {
        const qn_halfedges halfedges = qn_mesh_get_halfedges(mesh);
        sort_creases(&job);
        join_corners(&job, &halfedges);
        status = make_split(&job, out, error);
    }
    qni_free(context, job.next, job.corners, sizeof *job.next);
    qni_free(context, job.vertex, job.corners, sizeof *job.vertex);
    qni_free(context, job.creases, mesh->crease_edge_count, sizeof *job.creases);
    return status;
}

qn_status qn_mesh_split_normals(qn_context *context, const qn_mesh *mesh, qn_mesh **split_out,
                                qn_error *error) {
    *split_out = NULL;
    if (mesh->quad_count)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "normals are split on triangles: take qn_mesh_triangulate() first");
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    qn_mesh *copy;
    QN_TRY(qn_mesh_create(context, &view, &copy, error));
    const qn_status status =
        copy->triangle_count ? split_triangles(context, copy, split_out, error) : QN_OK;
    if (copy->triangle_count || status != QN_OK)
        qn_mesh_destroy(copy);
    else
        *split_out = copy;
    return status;
}
