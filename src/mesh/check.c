// SPDX-License-Identifier: MIT
/* qn_mesh_check(): vertices, topology, shape, self-intersections, in this order. */
#include "mesh/check.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/mesh.h"

#include <string.h>

int64_t qni_block_count(int64_t count, int64_t block_size) {
    return count / block_size + (count % block_size != 0);
}

qn_status qni_check_blocks(qni_check *check, int64_t count, int64_t block_size, qni_check_span span,
                           qni_block_work *work, void *job) {
    const double pause = 0.01; /* seconds between two calls of a caller's progress function */
    const char *stage = check->stage ? check->stage : "check";
    int64_t blocks = qni_block_count(count, block_size);
    bool stop = qni_progress(check->context, stage, span.from);
    double last = qni_seconds();
#pragma omp parallel for schedule(monotonic                                                        \
                                  : dynamic, 1) num_threads(qn_context_threads(check->context))
    for (int64_t block = 0; block < blocks; ++block) {
        if (qni_thread_index() == 0 && qni_seconds() - last > pause) { /* the calling thread */
            double done = span.from + (span.to - span.from) * (double)block / (double)blocks;
            if (qni_progress(check->context, stage, done))
                __atomic_store_n(&stop, true, __ATOMIC_RELAXED);
            last = qni_seconds();
        }
        if (__atomic_load_n(&stop, __ATOMIC_RELAXED))
            continue;
        int64_t begin = block * block_size;
        work(job, block, begin, count - begin < block_size ? count : begin + block_size);
    }
    if (stop)
        return qni_fail(check->error, QN_ERROR_CANCELLED, "cancelled during '%s'", stage);
    return QN_OK;
}

bool qni_face_is_polygon(const uint32_t *v, int corners) {
    if (corners == 3)
        return v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
    int kept = (v[0] != v[1]) + (v[1] != v[2]) + (v[2] != v[3]) + (v[3] != v[0]);
    return kept == 3 || (kept == 4 && v[0] != v[2] && v[1] != v[3]);
}

bool qni_face_is_finite(const qni_check *check, const uint32_t *indices, int corners) {
    unsigned flags = 0;
    for (int i = 0; i < corners; ++i)
        flags |= check->vertex_flags[indices[i]];
    return !(flags & QNI_VERTEX_NONFINITE);
}

int qni_split_face(const qni_check *check, int64_t face, uint32_t triangles[2][3]) {
    const uint32_t *v;
    const int corners = qni_face_corners(&check->mesh, face, &v);
    if (corners == 4)
        qni_cut_quad(v, qni_along_02(&check->diagonals, face), triangles[0]);
    else
        memcpy(triangles[0], v, sizeof triangles[0]);
    return corners - 2;
}

static qn_status run_parts(qni_check *check, bool skip_intersections) {
    const qni_check_span vertices = {0, 0.1}, topology = {0.1, 0.4}, shape = {0.4, 0.5};
    const qni_check_span intersections = {0.5, 1};
    QN_TRY(qni_check_vertices(check, vertices));
    QN_TRY(qni_check_topology(check, topology));
    QN_TRY(qni_check_shape(check, shape));
    if (!skip_intersections)
        QN_TRY(qni_check_intersections(check, intersections));
    return QN_OK;
}

qn_status qn_mesh_check(qn_context *context, const qn_mesh *mesh,
                        const qn_mesh_check_options *options, qn_mesh_report *report_out,
                        qn_error *error) {
    const qn_mesh_report nothing = {0};
    *report_out = nothing;
    QNI_CHECK_OPTIONS(options, "qn_mesh_check_options_init", error);
    qn_mesh_report report = nothing;
    qni_check check = {
        .context = context, .mesh = qn_mesh_get_view(mesh), .report = &report, .error = error};
    report.vertex_count = mesh->vertex_count;
    report.quad_count = mesh->quad_count;
    report.triangle_count = mesh->triangle_count;
    report.self_intersections = -1;
    check.vertex_flags = qni_alloc_zero(context, mesh->vertex_count, 1);
    if (!check.vertex_flags)
        return qni_fail_memory(error, "a mesh check");
    qn_status status = qni_diagonals_choose(context, &check.mesh, &check.diagonals, error);
    if (status == QN_OK)
        status = run_parts(&check, options && options->skip_intersections);
    qni_diagonals_free(&check.diagonals);
    qni_free(context, check.vertex_flags, mesh->vertex_count, 1);
    QN_TRY(status);
    *report_out = report;
    return QN_OK;
}
