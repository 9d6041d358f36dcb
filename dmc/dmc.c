// SPDX-License-Identifier: MIT
/* Dual Marching Cubes for one iso-value: count, allocate exactly, emit ([DMC21] section 3; order:
 * docs/architecture.md). */
#include "dmc/dmc.h"
#include "dmc/repair.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

void qni_dmc_note_memory(qni_dmc *dmc, int64_t mesh_bytes) {
    const int64_t beside =
        qn_context_memory(dmc->context).current_bytes - dmc->held_before - mesh_bytes;
    dmc->scratch_bytes = beside > dmc->scratch_bytes ? beside : dmc->scratch_bytes;
}

static int64_t total_vertices(const qni_dmc *dmc) {
    return dmc->vertex_count + (dmc->repair ? dmc->repair->extra_vertices : 0) + dmc->rim_count;
}

static int64_t total_quads(const qni_dmc *dmc) {
    return dmc->quad_count + (dmc->repair ? dmc->repair->extra_quads : 0);
}

int64_t qni_dmc_mesh_bytes(const qni_dmc *dmc, bool with_normals) {
    const int64_t a_vertex = 12 + (with_normals ? 12 : 0) + (dmc->with_halfedges ? 4 : 0);
    const int64_t a_quad = 16 + (dmc->with_halfedges ? 16 : 0);
    return total_vertices(dmc) * a_vertex + total_quads(dmc) * a_quad;
}

/* Sparse lattices can have more cells than can be counted. */
static int64_t cell_count(const qni_field *field) {
    int64_t count;
    if (__builtin_mul_overflow(field->cells[0], field->cells[1], &count) ||
        __builtin_mul_overflow(count, field->cells[2], &count))
        return INT64_MAX;
    return count;
}

static void fill_report(const qni_dmc *dmc, bool with_normals, qn_surface_report *report) {
    const qni_dmc_tally *tally = &dmc->tally;
    report->isovalue = dmc->field.isovalue;
    report->cells = cell_count(&dmc->field);
    report->active_leaves = dmc->leaf_count;
    report->active_cells = tally->active_cells;
    report->ambiguous_faces = tally->ambiguous_faces;
    report->multiple_cells = tally->multiple_cells;
    report->tied_faces = tally->tied_faces;
    report->vertices = total_vertices(dmc);
    report->quads = total_quads(dmc);
    report->doubled_edges = dmc->doubled_count;
    report->repaired_edges = dmc->repair ? dmc->repair->face_count : 0;
    report->tunnels = tally->tunnels;
    report->restored_tunnels = dmc->tunnel_count;
    report->slice_points = tally->slice_points;
    report->degenerate_points = tally->degenerate_points;
    report->split_rim_vertices = dmc->rim_count;
    report->fallback_points = tally->fallback_points + dmc->rim_points_left +
                              (dmc->repair ? dmc->repair->fallback_points : 0);
    report->zero_gradients = tally->zero_gradients;
    report->nan_samples = dmc->field.nan_count;
    report->infinite_samples = dmc->field.infinite_count;
    report->scratch_bytes = dmc->scratch_bytes;
    report->output_bytes = qni_dmc_mesh_bytes(dmc, with_normals);
}

static qn_status make_mesh(qni_dmc *dmc, const qn_grid *grid, bool with_normals, qn_mesh **mesh_out,
                           qn_error *error) {
    qn_mesh *mesh;
    QN_TRY(qni_mesh_alloc(dmc->context, total_vertices(dmc), total_quads(dmc), 0, with_normals,
                          &mesh, error));
    memcpy(mesh->space, grid->space, sizeof mesh->space);
    memcpy(mesh->unit, grid->unit, sizeof mesh->unit);
    qn_status status =
        dmc->with_halfedges ? qni_mesh_alloc_halfedges(dmc->context, mesh, error) : QN_OK;
    if (status == QN_OK && dmc->with_valences) {
        dmc->valence_room = total_vertices(dmc) + 1;
        dmc->valences = qni_alloc(dmc->context, dmc->valence_room, 1);
        dmc->colour_room = total_quads(dmc) + 1;
        dmc->colours = qni_alloc(dmc->context, dmc->colour_room, 1);
        if (!dmc->valences || !dmc->colours)
            status = qni_fail_memory(error, "the valences");
    }
    if (status == QN_OK)
        status = qni_dmc_emit(dmc, mesh, error);
    if (status != QN_OK) {
        qn_mesh_destroy(mesh);
        return status;
    }
    *mesh_out = mesh;
    return QN_OK;
}

/* Fields whose scan cannot meet their non-finite samples: no direct form, or no cell at all. */
static bool needs_measuring(const qni_field *field) {
    const bool real = field->grid->scalar == QN_F32 || field->grid->scalar == QN_F64;
    return (!field->direct || qni_field_row_count(field) == 0) && real;
}

qn_status qni_dmc_surface(qn_context *context, const qn_volume *volume, double isovalue,
                          const qn_surface_options *options, qn_mesh **mesh_out,
                          qn_surface_report *report, qn_error *error) {
    qni_dmc dmc = {.context = context, .held_before = qn_context_memory(context).current_bytes};
    const bool with_normals = !options->skip_normals;
    const double start = qni_seconds();
    dmc.with_halfedges = (options->halfedges && !options->triangles) || options->relax > 0;
    dmc.with_repair = !options->keep_doubled;
    dmc.with_valences = options->simplify;
    dmc.with_tunnels = options->topology == QN_TOPOLOGY_EXACT;
    *mesh_out = NULL;
    memset(report, 0, sizeof *report);
    QN_TRY(qni_field_init(volume, isovalue, options->inside == QN_INSIDE_BELOW, options->open,
                          &dmc.field, error));
    if (needs_measuring(&dmc.field))
        qni_field_measure_nonfinite(context, &dmc.field);
    qn_status status = qni_dmc_count(&dmc, error);
    if (status == QN_OK && ((dmc.with_repair && dmc.doubled_count > 0) || dmc.tunnel_count > 0))
        status = qni_repair_plan(&dmc, error);
    const double counted = qni_seconds();
    if (status == QN_OK && !options->count_only)
        status = make_mesh(&dmc, qn_volume_grid(volume), with_normals, mesh_out, error);
    if (status == QN_OK)
        fill_report(&dmc, with_normals, report);
    report->seconds_classify = counted - start;
    report->seconds_emit = qni_seconds() - counted;
    if (status == QN_OK && *mesh_out)
        status = qni_dmc_improve(&dmc, *mesh_out, options, report, error);
    qni_repair_free(&dmc);
    qni_dmc_free_rows(&dmc);
    qni_free(context, dmc.valences, dmc.valence_room, 1);
    qni_free(context, dmc.colours, dmc.colour_room, 1);
    if (status != QN_OK) {
        qn_mesh_destroy(*mesh_out);
        *mesh_out = NULL;
    }
    report->seconds_total = qni_seconds() - start;
    return status;
}
