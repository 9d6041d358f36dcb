// SPDX-License-Identifier: MIT
/* After the mesh stands: simplification and relaxation, tied to the field it came from. */
#include "dmc/dmc.h"
#include "dmc/project.h"
#include "dmc/relax.h"
#include "dmc/simplify.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

/* A quad's four vertices lie in the cells round its lattice edge: along the edge's axis their cells
 * agree, and the edge starts at the highest. (A vertex that rounding put over a border costs at
 * most a worse colour, and colours only say who goes first.) */
static uint8_t colour_of(const void *user, const qn_mesh *mesh, int64_t quad) {
    const qni_projector *projector = user;
    int64_t low[3] = {INT64_MAX, INT64_MAX, INT64_MAX}, high[3] = {0, 0, 0};
    for (int k = 0; k < 4; ++k) {
        const float *p = mesh->positions + 3 * (int64_t)mesh->quads[4 * quad + k];
        for (int a = 0; a < 3; ++a) {
            const double *row = projector->lattice[a];
            const double at =
                (row[0] * (double)p[0] + row[1] * (double)p[1]) + (row[2] * (double)p[2] + row[3]);
            const int64_t cell = (int64_t)at; /* not negative, but for rounding */
            low[a] = cell < low[a] ? cell : low[a];
            high[a] = cell > high[a] ? cell : high[a];
        }
    }
    const int axis = low[0] == high[0] ? 0 : low[1] == high[1] ? 1 : 2;
    return (uint8_t)(2 * axis + ((high[0] + high[1] + high[2]) & 1));
}

/* What a stage held, and what emission left for it. */
static void note_scratch(const qni_dmc *dmc, int64_t bytes, qn_surface_report *report) {
    const int64_t beside = bytes + dmc->valence_room + dmc->colour_room;
    report->scratch_bytes = beside > report->scratch_bytes ? beside : report->scratch_bytes;
}

/* The arrays as they are held, the room that simplification left in them included. */
static int64_t bytes_of(const qn_mesh *mesh) {
    const int64_t a_vertex = 12 + (mesh->normals ? 12 : 0) + (mesh->twins ? 4 : 0);
    const int64_t a_quad = 16 + (mesh->twins ? 16 : 0);
    return (mesh->vertex_count + mesh->vertex_slack) * a_vertex +
           (mesh->quad_count + mesh->quad_slack) * a_quad;
}

static qn_status simplify(qni_dmc *dmc, qn_mesh *mesh, const uint8_t *colours,
                          const qni_projector *projector, const qn_surface_options *options,
                          qn_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    const qni_simplify_options how = {
        .colours = colours,
        .colour = colour_of,
        .colour_user = projector,
        .valences = dmc->valences,
        .passes = options->simplify_passes > 0 ? options->simplify_passes : 0,
        .paper = options->simplify_passes < 0,
        .project = options->no_reproject ? NULL : qni_project_near,
        .project_user = projector,
    };
    qni_simplify_report done;
    const qn_status status = qni_simplify(dmc->context, mesh, &how, &done, error);
    report->merged_quads = done.merged_quads;
    report->shrunk_quads = done.shrunk_quads;
    report->unprojected_points = done.unprojected;
    report->simplify_passes = done.passes;
    note_scratch(dmc, done.scratch_bytes, report);
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
    note_scratch(dmc, done.scratch_bytes, report);
    report->seconds_relax = done.seconds;
    return status;
}

qn_status qni_dmc_improve(qni_dmc *dmc, qn_mesh *mesh, const uint8_t *colours,
                          const qn_surface_options *options, qn_surface_report *report,
                          qn_error *error) {
    if (mesh->quad_count == 0 || !(options->simplify || options->relax > 0))
        return QN_OK;
    qni_projector projector;
    qni_projector_init(&dmc->field, &projector);
    if (!mesh->twins)
        QN_TRY(qn_mesh_build_halfedges(dmc->context, mesh, error));
    if (options->simplify)
        QN_TRY(simplify(dmc, mesh, colours, &projector, options, report, error));
    if (options->relax > 0)
        QN_TRY(relax(dmc, mesh, &projector, options, report, error));
    if (!options->halfedges)
        qni_mesh_free_halfedges(mesh);
    report->vertices = mesh->vertex_count;
    report->quads = mesh->quad_count;
    report->output_bytes = bytes_of(mesh);
    return QN_OK;
}
