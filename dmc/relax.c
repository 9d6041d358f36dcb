// SPDX-License-Identifier: MIT
/* Relaxation by sweeps. Each quad is fitted with the nearest square, for which [DMC21] equation (9)
 * is 1; a vertex wishes itself to the mean of its corners of those squares, along the tangent
 * plane. Then all move; where a quad came out worse than the worst round one of its corners was,
 * its corners go back, until nothing is worse. */
#include "dmc/relax.h"
#include "dmc/relax_hd.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

typedef struct job {
    qn_context *context;
    qn_mesh *mesh;
    const qni_slide *surface;
    int32_t threads;
    float *normals; /* [vertices][3]: the mesh's own, or made for the purpose */
    float *wished;  /* [vertices][3]: where vertices would go */
    int32_t *cells; /* [vertices][3] */
    uint8_t *state; /* [vertices] */
    float *worst;   /* [vertices]: least shape round it */
    float
        *across; /* [quads][3]: unit means of the corners' normals, as they were in the beginning */
    float *shape;   /* [quads] */
    uint8_t *worse; /* [quads] */
    qni_relax_report report;
} job;

enum { FIXED = 0, FREE = 1, MOVES = 2, MOVED = 4 };

static uint32_t next_round(const qn_mesh *mesh, uint32_t h) {
    return mesh->twins[(h & ~UINT32_C(3)) | ((h + 3) & 3)];
}

static bool fan_is_closed(const qn_mesh *mesh, int64_t v) {
    const uint32_t start = mesh->vertex_halfedges[v];
    uint32_t h = start;
    do
        h = h == QN_NO_HALFEDGE ? h : next_round(mesh, h);
    while (h != start && h != QN_NO_HALFEDGE);
    return h != QN_NO_HALFEDGE;
}

/* Corners of a quad: where they are, or where those that move will be. */
static void corners_of(const job *j, int64_t quad, bool wished, const float *corner[4]) {
    const uint32_t *v = j->mesh->quads + 4 * quad;
    for (int k = 0; k < 4; ++k) {
        const bool moves = wished && j->state[v[k]] & MOVES;
        corner[k] = (moves ? j->wished : j->mesh->positions) + 3 * (int64_t)v[k];
    }
}

static void set_across(const job *j, int64_t quad) {
    const uint32_t *v = j->mesh->quads + 4 * quad;
    const float *n0 = j->normals + 3 * (int64_t)v[0], *n1 = j->normals + 3 * (int64_t)v[1];
    const float *n2 = j->normals + 3 * (int64_t)v[2], *n3 = j->normals + 3 * (int64_t)v[3];
    float *normal = j->across + 3 * quad;
    for (int a = 0; a < 3; ++a)
        normal[a] = (n0[a] + n1[a]) + (n2[a] + n3[a]);
    const float squares = qni_dot(normal, normal), scale = squares > 0 ? 1 / sqrtf(squares) : 0;
    for (int a = 0; a < 3; ++a)
        normal[a] *= scale;
}

static float shape_of(const job *j, int64_t quad, bool wished) {
    const float *corner[4];
    corners_of(j, quad, wished, corner);
    return qni_quad_shape(corner, j->across + 3 * quad);
}

/* The least shape round a vertex if it alone stood at `place`. */
static float least_round(const job *j, uint32_t start, const float place[3]) {
    float least = 1;
    uint32_t h = start;
    do {
        const float *corner[4];
        corners_of(j, h >> 2, false, corner);
        corner[h & 3] = place;
        const float shape = qni_quad_shape(corner, j->across + 3 * (int64_t)(h >> 2));
        least = shape < least ? shape : least;
        h = next_round(j->mesh, h);
    } while (h != start);
    return least;
}

/* The mean of the vertex' corners of the squares round it, brought into its tangent plane. */
static void wish(const job *j, int64_t v, float place[3]) {
    const uint32_t start = j->mesh->vertex_halfedges[v];
    const float *here = j->mesh->positions + 3 * v, *n = j->normals + 3 * v;
    float sum[3] = {0, 0, 0}, count = 0;
    uint32_t h = start;
    do {
        const float *corner[4];
        float square[3];
        corners_of(j, h >> 2, false, corner);
        qni_square_corner(corner, j->across + 3 * (int64_t)(h >> 2), (int)(h & 3), square);
        for (int a = 0; a < 3; ++a)
            sum[a] += square[a] - here[a];
        count += 1;
        h = next_round(j->mesh, h);
    } while (h != start);
    const float off = qni_dot(sum, n);
    for (int a = 0; a < 3; ++a)
        place[a] = here[a] + (sum[a] - off * n[a]) / count;
}

/* Decide where a vertex goes: the whole way, or half, or a quarter of it. */
static void aim(job *j, int64_t v) {
    const uint32_t start = j->mesh->vertex_halfedges[v];
    const float *here = j->mesh->positions + 3 * v;
    float wanted[3], *place = j->wished + 3 * v;
    wish(j, v, wanted);
    for (float share = 1; share >= 0.25f; share *= 0.5f) {
        for (int a = 0; a < 3; ++a)
            place[a] = here[a] + share * (wanted[a] - here[a]);
        if (j->surface->slide(j->surface->user, j->cells + 3 * v, here, j->normals + 3 * v,
                              place) &&
            least_round(j, start, place) >= j->worst[v]) {
            j->state[v] |= MOVES;
            return;
        }
    }
}

static void measure(job *j) {
    const qn_mesh *mesh = j->mesh;
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t q = 0; q < mesh->quad_count; ++q)
        j->shape[q] = shape_of(j, q, false);
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        float least = -1; /* corners that stay ask for nothing */
        if (j->state[v] & FREE) {
            const uint32_t start = mesh->vertex_halfedges[v];
            uint32_t h = start;
            least = 1;
            do {
                least = j->shape[h >> 2] < least ? j->shape[h >> 2] : least;
                h = next_round(mesh, h);
            } while (h != start);
        }
        j->worst[v] = least;
    }
}

/* One step of taking back; how many vertices it took. */
static int64_t take_back(job *j) {
    const qn_mesh *mesh = j->mesh;
    int64_t taken = 0;
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t q = 0; q < mesh->quad_count; ++q) {
        const uint32_t *v = mesh->quads + 4 * q;
        if (!((j->state[v[0]] | j->state[v[1]] | j->state[v[2]] | j->state[v[3]]) & MOVES)) {
            j->worse[q] = 0;
            continue;
        }
        const float least =
            fmaxf(fmaxf(j->worst[v[0]], j->worst[v[1]]), fmaxf(j->worst[v[2]], j->worst[v[3]]));
        j->worse[q] = (uint8_t) !(shape_of(j, q, true) >= least);
    }
#pragma omp parallel for schedule(static) num_threads(j->threads) reduction(+ : taken)
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        if (!(j->state[v] & MOVES))
            continue;
        const uint32_t start = mesh->vertex_halfedges[v];
        uint32_t h = start;
        bool back = false;
        do {
            back = back || j->worse[h >> 2];
            h = next_round(mesh, h);
        } while (h != start);
        if (back)
            j->state[v] &= (uint8_t)~MOVES;
        taken += back;
    }
    return taken;
}

static qn_status sweep(job *j, double done, qn_error *error) {
    const int64_t vertices = j->mesh->vertex_count;
    if (qni_progress(j->context, "relax", done))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    measure(j);
#pragma omp parallel for schedule(dynamic, 1024) num_threads(j->threads)
    for (int64_t v = 0; v < vertices; ++v)
        if (j->state[v] & FREE)
            aim(j, v);
    for (int64_t taken; (taken = take_back(j)) > 0;)
        j->report.reverted += taken;
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t v = 0; v < vertices; ++v)
        if (j->state[v] & MOVES) {
            memcpy(j->mesh->positions + 3 * v, j->wished + 3 * v, 3 * sizeof(float));
            j->state[v] = FREE | MOVED;
        }
    return QN_OK;
}

static void settle_homes(job *j) {
    const qn_mesh *mesh = j->mesh;
    const qni_slide *surface = j->surface;
#pragma omp parallel for schedule(dynamic, 1024) num_threads(j->threads)
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        const bool used = mesh->vertex_halfedges[v] != QN_NO_HALFEDGE;
        const bool may = surface->home(surface->user, mesh->positions + 3 * v, j->cells + 3 * v);
        j->state[v] = used && may && fan_is_closed(mesh, v) ? FREE : FIXED;
        if (j->normals != mesh->normals) {
            memset(j->normals + 3 * v, 0, 3 * sizeof(float));
            surface->normal(surface->user, j->cells + 3 * v, mesh->positions + 3 * v,
                            j->normals + 3 * v);
        }
    }
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t q = 0; q < mesh->quad_count; ++q)
        set_across(j, q);
}

/* The way is over: count, and bring the normals along. */
static void settle_normals(job *j) {
    int64_t moved = 0;
    qn_mesh *mesh = j->mesh;
#pragma omp parallel for schedule(dynamic, 1024) num_threads(j->threads) reduction(+ : moved)
    for (int64_t v = 0; v < mesh->vertex_count; ++v)
        if (j->state[v] & MOVED) {
            ++moved;
            if (mesh->normals)
                j->surface->normal(j->surface->user, j->cells + 3 * v, mesh->positions + 3 * v,
                                   mesh->normals + 3 * v);
        }
    j->report.moved = moved;
}

static qn_status run(job *j, int32_t sweeps, qn_error *error) {
    settle_homes(j);
    for (int32_t n = 0; n < sweeps; ++n)
        QN_TRY(sweep(j, (double)n / sweeps, error));
    settle_normals(j);
    return QN_OK;
}

qn_status qni_relax(qn_context *context, qn_mesh *mesh, int32_t sweeps, const qni_slide *surface,
                    qni_relax_report *report_out, qn_error *error) {
    const double start = qni_seconds();
    const int64_t vertices = mesh->vertex_count, quads = mesh->quad_count;
    const int64_t held_before = qn_context_memory(context).current_bytes;
    job j = {.context = context,
             .mesh = mesh,
             .surface = surface,
             .threads = qn_context_threads(context)};
    memset(report_out, 0, sizeof *report_out);
    if (quads == 0 || sweeps <= 0)
        return QN_OK;
    if (mesh->triangle_count || !mesh->twins)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "only meshes of quads with halfedges can be relaxed");
    j.normals = mesh->normals ? mesh->normals : qni_alloc(context, vertices, 3 * sizeof(float));
    j.wished = qni_alloc(context, vertices, 3 * sizeof(float));
    j.cells = qni_alloc(context, vertices, 3 * sizeof(int32_t));
    j.state = qni_alloc(context, vertices, 1);
    j.worst = qni_alloc(context, vertices, sizeof(float));
    j.across = qni_alloc(context, quads, 3 * sizeof(float));
    j.shape = qni_alloc(context, quads, sizeof(float));
    j.worse = qni_alloc(context, quads, 1);
    const bool good =
        j.normals && j.wished && j.cells && j.state && j.worst && j.across && j.shape && j.worse;
    qn_status status = good ? run(&j, sweeps, error) : qni_fail_memory(error, "relaxing the mesh");
    j.report.scratch_bytes = qn_context_memory(context).current_bytes - held_before;
    if (j.normals != mesh->normals)
        qni_free(context, j.normals, vertices, 3 * sizeof(float));
    qni_free(context, j.wished, vertices, 3 * sizeof(float));
    qni_free(context, j.cells, vertices, 3 * sizeof(int32_t));
    qni_free(context, j.state, vertices, 1);
    qni_free(context, j.worst, vertices, sizeof(float));
    qni_free(context, j.across, quads, 3 * sizeof(float));
    qni_free(context, j.shape, quads, sizeof(float));
    qni_free(context, j.worse, quads, 1);
    j.report.seconds = qni_seconds() - start;
    *report_out = j.report;
    return status;
}
