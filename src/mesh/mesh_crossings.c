// SPDX-License-Identifier: MIT
/* Crossings among the triangles of any mesh, for those who are not checking it. */
#include "mesh/box_tree.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

static void note_places(const qn_mesh_view *mesh, uint8_t *flags, qn_mesh_report *report) {
    for (int a = 0; a < 3; ++a) {
        report->bounds[0][a] = INFINITY;
        report->bounds[1][a] = -INFINITY;
    }
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        const float *p = mesh->positions + 3 * v;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) {
            flags[v] = QNI_VERTEX_NONFINITE;
            continue;
        }
        for (int a = 0; a < 3; ++a) {
            report->bounds[0][a] = fmin(report->bounds[0][a], (double)p[a]);
            report->bounds[1][a] = fmax(report->bounds[1][a], (double)p[a]);
        }
    }
}

qn_status qni_mesh_crossings(qn_context *context, const qn_mesh_view *mesh, const char *stage,
                             const uint8_t *wanted, uint8_t *marks, int64_t *count_out,
                             qn_error *error) {
    qn_mesh_report report;
    memset(&report, 0, sizeof report);
    memset(marks, 0, (size_t)mesh->vertex_count);
    qni_check check = {
        .context = context, .mesh = *mesh, .report = &report, .error = error, .stage = stage};
    check.vertex_flags = qni_alloc_zero(context, mesh->vertex_count, 1);
    if (!check.vertex_flags)
        return qni_fail_memory(error, "the search for crossings");
    note_places(mesh, check.vertex_flags, &report);
    qn_status status = qni_diagonals_choose(context, &check.mesh, &check.diagonals, error);
    const qni_check_span building = {0, 0.2}, pairing = {0.2, 1};
    qni_box_tree tree;
    if (status == QN_OK)
        status = qni_box_tree_create(&check, building, &tree);
    if (status == QN_OK) {
        status = qni_count_crossings(&check, &tree, pairing, wanted, marks, count_out);
        qni_box_tree_destroy(&check, &tree);
    }
    qni_diagonals_free(&check.diagonals);
    qni_free(context, check.vertex_flags, mesh->vertex_count, 1);
    return status;
}
