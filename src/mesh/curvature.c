// SPDX-License-Identifier: MIT
/* Curvature at vertices from how the normals turn: round each vertex the slopes that the
 * neighbours' normals tell are fitted with those of a cubic height field (Goldfeather and
 * Interrante 2004, normals only). Positions are left out of the fit: vertices of an iso-surface
 * stand on the interpolant's small facets, whose second differences say nothing, however fine the
 * grid. */
#include "mesh/mesh.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { UNKNOWNS = 7, SECOND_ORDER = 3 };

/* The faces round each vertex: faces[start[v] .. start[v + 1]). */
typedef struct round_vertices {
    int64_t *start;
    uint32_t *faces;
    int64_t corners;
} round_vertices;

typedef struct job {
    const qn_mesh *mesh;
    const float *normals;
    round_vertices round;
} job;

static int corners_of(const qn_mesh *mesh, int64_t face, const uint32_t **corner) {
    const bool is_quad = face < mesh->quad_count;
    *corner = is_quad ? mesh->quads + 4 * face : mesh->triangles + 3 * (face - mesh->quad_count);
    return is_quad ? 4 : 3;
}

static bool gather_faces(qn_context *context, const qn_mesh *mesh, round_vertices *round) {
    const int64_t vertices = mesh->vertex_count, faces = mesh->quad_count + mesh->triangle_count;
    round->corners = 4 * mesh->quad_count + 3 * mesh->triangle_count;
    round->start = qni_alloc_zero(context, vertices + 2, sizeof *round->start);
    round->faces = qni_alloc(context, round->corners, sizeof *round->faces);
    if (!round->start || !round->faces)
        return false;
    const uint32_t *corner;
    for (int64_t f = 0; f < faces; ++f)
        for (int n = corners_of(mesh, f, &corner); n-- > 0;)
            ++round->start[corner[n] + 2];
    for (int64_t v = 0; v < vertices; ++v)
        round->start[v + 2] += round->start[v + 1];
    /* start[v + 1] runs from the vertex' first place to its last, and so becomes the next one's
     * first. */
    for (int64_t f = 0; f < faces; ++f)
        for (int n = corners_of(mesh, f, &corner); n-- > 0;)
            round->faces[round->start[corner[n] + 1]++] = (uint32_t)f;
    return true;
}

/* Twice the face's area, as a vector along its normal. */
static void face_normal(const qn_mesh *mesh, int64_t face, double out[3]) {
    const uint32_t *corner;
    const int count = corners_of(mesh, face, &corner);
    const float *p0 = mesh->positions + 3 * (int64_t)corner[0],
                *p1 = mesh->positions + 3 * (int64_t)corner[1];
    const float *p2 = mesh->positions + 3 * (int64_t)corner[2],
                *p3 = mesh->positions + 3 * (int64_t)corner[count - 1];
    double u[3], v[3];
    for (int a = 0; a < 3; ++a) {
        u[a] = (double)p2[a] - (double)p0[a];
        v[a] = (double)p3[a] - (double)(count == 4 ? p1[a] : p0[a]);
        if (count == 3)
            u[a] = (double)p1[a] - (double)p0[a];
    }
    for (int a = 0; a < 3; ++a)
        out[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
}

/* For meshes without normals: the mean of the faces', weighted by area. */
static void mean_normal(const job *j, int64_t v, float normal[3]) {
    double sum[3] = {0, 0, 0};
    for (int64_t n = j->round.start[v]; n < j->round.start[v + 1]; ++n) {
        double one[3];
        face_normal(j->mesh, j->round.faces[n], one);
        for (int a = 0; a < 3; ++a)
            sum[a] += one[a];
    }
    const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (int a = 0; a < 3; ++a)
        normal[a] = length > 0 ? (float)(sum[a] / length) : 0;
}

/* ---- the fit --------------------------------------------------------------------------------- */

typedef struct frame {
    double origin[3], axis[3][3]; /* two tangents, the normal */
    double scale;                 /* mean distance of the neighbours */
} frame;

static void set_frame(const job *j, int64_t v, frame *f) {
    const float *p = j->mesh->positions + 3 * v, *n = j->normals + 3 * v;
    double *t = f->axis[0], *b = f->axis[1], *z = f->axis[2];
    for (int a = 0; a < 3; ++a) {
        f->origin[a] = (double)p[a];
        z[a] = (double)n[a];
    }
    const int least = fabs(z[0]) <= fabs(z[1]) && fabs(z[0]) <= fabs(z[2]) ? 0
                      : fabs(z[1]) <= fabs(z[2])                           ? 1
                                                                           : 2;
    double squares = 0;
    for (int a = 0; a < 3; ++a) {
        t[a] = (a == least ? 1 : 0) - z[least] * z[a];
        squares += t[a] * t[a];
    }
    for (int a = 0; a < 3; ++a)
        t[a] /= sqrt(squares);
    for (int a = 0; a < 3; ++a)
        b[a] = z[(a + 1) % 3] * t[(a + 2) % 3] - z[(a + 2) % 3] * t[(a + 1) % 3];
}

static double dot(const double u[3], const double v[3]) {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

typedef struct equations {
    double matrix[UNKNOWNS][UNKNOWNS], right[UNKNOWNS];
    int neighbours;
} equations;

static void add_row(equations *e, const double row[UNKNOWNS], double value) {
    for (int r = 0; r < UNKNOWNS; ++r) {
        for (int c = 0; c < UNKNOWNS; ++c)
            e->matrix[r][c] += row[r] * row[c];
        e->right[r] += row[r] * value;
    }
}

/* Height h = (A x^2 + 2 B x y + C y^2) / 2 + D x^3 + E x^2 y + F x y^2 + G y^3: its slopes at a
 * neighbour. */
static void add_neighbour(const job *j, const frame *f, uint32_t neighbour, equations *e) {
    double way[3], normal[3];
    for (int a = 0; a < 3; ++a) {
        way[a] = ((double)j->mesh->positions[3 * (int64_t)neighbour + a] - f->origin[a]) / f->scale;
        normal[a] = (double)j->normals[3 * (int64_t)neighbour + a];
    }
    const double x = dot(way, f->axis[0]), y = dot(way, f->axis[1]), up = dot(normal, f->axis[2]);
    if (!(up > 0.1)) /* turned away too far for a height field */
        return;
    const double along_x[UNKNOWNS] = {x, y, 0, 3 * x * x, 2 * x * y, y * y, 0};
    const double along_y[UNKNOWNS] = {0, x, y, 0, x * x, 2 * x * y, 3 * y * y};
    add_row(e, along_x, -dot(normal, f->axis[0]) / up);
    add_row(e, along_y, -dot(normal, f->axis[1]) / up);
    ++e->neighbours;
}

/* Solve the first `size` of the equations by Cholesky's method; false when they do not tell all
 * unknowns. */
static bool solve(const equations *e, int size, double out[UNKNOWNS]) {
    double l[UNKNOWNS][UNKNOWNS], y[UNKNOWNS];
    for (int r = 0; r < size; ++r)
        for (int c = 0; c <= r; ++c) {
            double sum = e->matrix[r][c];
            for (int k = 0; k < c; ++k)
                sum -= l[r][k] * l[c][k];
            if (r == c && !(sum > 1e-6 * e->matrix[r][r]))
                return false;
            l[r][c] = r == c ? sqrt(sum) : sum / l[c][c];
        }
    for (int r = 0; r < size; ++r) {
        y[r] = e->right[r];
        for (int k = 0; k < r; ++k)
            y[r] -= l[r][k] * y[k];
        y[r] /= l[r][r];
    }
    for (int r = size - 1; r >= 0; --r) {
        out[r] = y[r];
        for (int k = r + 1; k < size; ++k)
            out[r] -= l[k][r] * out[k];
        out[r] /= l[r][r];
    }
    return true;
}

/* Mean distance of the other corners of the faces round a vertex; 0 without any. */
static double mean_distance(const job *j, int64_t v, const frame *f) {
    double sum = 0;
    int64_t count = 0;
    const uint32_t *corner;
    for (int64_t n = j->round.start[v]; n < j->round.start[v + 1]; ++n)
        for (int k = corners_of(j->mesh, j->round.faces[n], &corner); k-- > 0;) {
            const float *p = j->mesh->positions + 3 * (int64_t)corner[k];
            const double way[3] = {(double)p[0] - f->origin[0], (double)p[1] - f->origin[1],
                                   (double)p[2] - f->origin[2]};
            sum += sqrt(dot(way, way));
            count += corner[k] != (uint32_t)v;
        }
    return count ? sum / (double)count : 0;
}

static void fit(const job *j, int64_t v, double *mean, double *gaussian) {
    frame f;
    equations e = {.neighbours = 0};
    double h[UNKNOWNS] = {0, 0, 0, 0, 0, 0, 0};
    const uint32_t *corner;
    *mean = *gaussian = 0;
    set_frame(j, v, &f);
    f.scale = mean_distance(j, v, &f);
    if (!(f.scale > 0) || !(dot(f.axis[2], f.axis[2]) > 0.5))
        return;
    for (int64_t n = j->round.start[v]; n < j->round.start[v + 1]; ++n)
        for (int k = corners_of(j->mesh, j->round.faces[n], &corner); k-- > 0;)
            if (corner[k] != (uint32_t)v)
                add_neighbour(j, &f, corner[k], &e);
    if (!(e.neighbours > 3 && solve(&e, UNKNOWNS, h)) && !solve(&e, SECOND_ORDER, h))
        return;
    *mean = -0.5 * (h[0] + h[2]) / f.scale;
    *gaussian = (h[0] * h[2] - h[1] * h[1]) / (f.scale * f.scale);
}

static qn_status run(qn_context *context, job *j, float *made, float *mean_out, float *gaussian_out,
                     qn_error *error) {
    const int64_t vertices = j->mesh->vertex_count;
    const int32_t threads = qn_context_threads(context);
    if (!gather_faces(context, j->mesh, &j->round))
        return qni_fail_memory(error, "the faces round each vertex");
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t v = 0; v < (made ? vertices : 0); ++v)
        mean_normal(j, v, made + 3 * v);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t v = 0; v < vertices; ++v) {
        double mean, gaussian;
        fit(j, v, &mean, &gaussian);
        if (mean_out)
            mean_out[v] = (float)mean;
        if (gaussian_out)
            gaussian_out[v] = (float)gaussian;
    }
    return QN_OK;
}

qn_status qn_mesh_get_curvature(qn_context *context, const qn_mesh *mesh, float *mean_out,
                                float *gaussian_out, qn_error *error) {
    const int64_t vertices = mesh->vertex_count;
    float *made = mesh->normals ? NULL : qni_alloc(context, vertices, 3 * sizeof *made);
    job j = {.mesh = mesh, .normals = mesh->normals ? mesh->normals : made};
    qn_status status = mesh->normals || made ? run(context, &j, made, mean_out, gaussian_out, error)
                                             : qni_fail_memory(error, "the normals of the mesh");
    qni_free(context, made, vertices, 3 * sizeof *made);
    qni_free(context, j.round.start, vertices + 2, sizeof *j.round.start);
    qni_free(context, j.round.faces, j.round.corners, sizeof *j.round.faces);
    return status;
}
