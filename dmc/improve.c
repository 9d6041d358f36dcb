// SPDX-License-Identifier: MIT
/* After the mesh stands: simplification and relaxation, tied to the field it came from. */
#include "dmc/around.h"
#include "dmc/dmc.h"
#include "dmc/project.h"
#include "dmc/relax.h"
#include "dmc/simplify.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

/* The arrays as they are held, the room that simplification left in them included. */
static int64_t bytes_of(const qn_mesh *mesh) {
    const int64_t a_vertex = 12 + (mesh->normals ? 12 : 0) + (mesh->twins ? 4 : 0);
    const int64_t a_quad = 16 + (mesh->twins ? 16 : 0);
    return (mesh->vertex_count + mesh->vertex_slack) * a_vertex +
           (mesh->quad_count + mesh->quad_slack) * a_quad;
}

/* What a stage held, and what is still held for it from before. */
static void note_scratch(const qni_dmc *dmc, const qn_mesh *mesh, int64_t bytes,
                         qn_surface_report *report) {
    const int64_t beside =
        bytes + qn_context_memory(dmc->context).current_bytes - dmc->held_before - bytes_of(mesh);
    report->scratch_bytes = beside > report->scratch_bytes ? beside : report->scratch_bytes;
}

static qn_status simplify(qni_dmc *dmc, qn_mesh *mesh, const qni_projector *projector,
                          const qn_surface_options *options, qn_surface_report *report,
                          qn_error *error) {
    const double start = qni_seconds();
    qni_leaf_index index = {0};
    if (!mesh->twins)
        QN_TRY(qni_leaf_index_build(dmc, mesh, &index, error));
    const qni_simplify_options how = {
        .valences = dmc->valences,
        .colours = dmc->colours,
        .index = mesh->twins ? NULL : &index,
        .passes = options->simplify_passes > 0 ? options->simplify_passes : 0,
        .paper = options->simplify_passes < 0,
        .projector = options->no_reproject ? NULL : projector,
    };
    qni_simplify_report done;
    const qn_status status = qni_simplify(dmc->context, mesh, &how, &done, error);
    report->merged_quads = done.merged_quads;
    report->shrunk_quads = done.shrunk_quads;
    report->unprojected_points = done.unprojected;
    report->simplify_passes = done.passes;
    note_scratch(dmc, mesh, done.scratch_bytes, report);
    qni_leaf_index_free(dmc, &index);
    report->seconds_simplify = qni_seconds() - start;
    return status;
}

static qn_status relax(qni_dmc *dmc, qn_mesh *mesh, const qni_projector *projector,
                       const qn_surface_options *options, qn_surface_report *report,
                       qn_error *error) {
    const qni_slide slide = {projector, qni_project_home, qni_project_in_cell, qni_project_normal};
    qni_relax_report done;
    const qn_status status = qni_relax(dmc->context, mesh, options->relax, &slide, &done, error);
    report->relaxed_vertices = done.moved;
    note_scratch(dmc, mesh, done.scratch_bytes, report);
    report->seconds_relax = done.seconds;
    return status;
}

qn_status qni_dmc_improve(qni_dmc *dmc, qn_mesh *mesh, const qn_surface_options *options,
                          qn_surface_report *report, qn_error *error) {
    if (mesh->quad_count == 0 || !(options->simplify || options->relax > 0))
        return QN_OK;
    qni_projector projector;
    qni_projector_init(&dmc->field, &projector);
    if (!mesh->twins && (options->relax > 0 || !dmc->valences))
        QN_TRY(qn_mesh_build_halfedges(dmc->context, mesh, error));
    if (mesh->twins)
        qni_dmc_free_rows(dmc); /* halfedges tell all that is asked of them */
    if (options->simplify)
        QN_TRY(simplify(dmc, mesh, &projector, options, report, error));
    if (options->relax > 0)
        QN_TRY(relax(dmc, mesh, &projector, options, report, error));
    if (!options->halfedges && mesh->twins)
        qni_mesh_free_halfedges(mesh);
    report->vertices = mesh->vertex_count;
    report->quads = mesh->quad_count;
    report->output_bytes = bytes_of(mesh);
    return QN_OK;
}
