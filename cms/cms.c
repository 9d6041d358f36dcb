// SPDX-License-Identifier: MIT
/* Cubical Marching Squares [CMS05] from solid to mesh: sample, coarsen, faces, cells, mesh. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/flat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 12, MOST_LOOKS = 6 };

/* ---- running chunks
 * ------------------------------------------------------------------------------ */

typedef void chunk_work(qni_stages *stages, int64_t chunk);

static qn_status chunk_failure(const qni_stages *stages, const qni_chunk *chunk) {
    if (chunk->status == QN_ERROR_OUT_OF_MEMORY)
        return qni_fail_memory(stages->error, "a surface");
    if (chunk->status == QN_ERROR_CANCELLED)
        return qni_fail(stages->error, QN_ERROR_CANCELLED, "a callback of the solid asked to stop");
    return qni_fail(stages->error, chunk->status,
                    "the surface did not close in a cell: the solid gave different answers to the "
                    "same question; its "
                    "functions must depend on the point alone");
}

static qn_status run_chunks(qni_stages *stages, chunk_work *work, double from, double to) {
    const int64_t round = 64 * (int64_t)stages->threads;
    for (int64_t first = 0; first < stages->chunk_count; first += round) {
        const double done = from + (to - from) * (double)first / (double)stages->chunk_count;
        if (qni_progress(stages->context, "cms", done))
            return qni_fail(stages->error, QN_ERROR_CANCELLED, "the surface was cancelled");
        const int64_t last =
            stages->chunk_count - first < round ? stages->chunk_count : first + round;
#pragma omp parallel for schedule(dynamic, 1) num_threads(stages->threads)
        for (int64_t chunk = first; chunk < last; ++chunk)
            work(stages, chunk);
        for (int64_t chunk = first; chunk < last; ++chunk)
            if (stages->chunks[chunk].status != QN_OK)
                return chunk_failure(stages, &stages->chunks[chunk]);
    }
    return QN_OK;
}

/* ---- between faces and cells
 * --------------------------------------------------------------------- */

/* The segments of faces solved in this pass, in a chunk, get the final numbers of their features.
 */
static void number_features(const qni_stages *stages, qni_chunk *chunk) {
    for (int64_t s = 0; s < chunk->segment_count; ++s)
        if (chunk->segments[s].pass == stages->pass)
            chunk->segments[s].feature += (uint32_t)chunk->feature_base;
    if (chunk->feature_count)
        memcpy(stages->features + chunk->feature_base, chunk->features,
               sizeof *chunk->features * (size_t)chunk->feature_count);
    qni_free(stages->context, chunk->features, chunk->feature_capacity, sizeof *chunk->features);
    chunk->features = NULL;
    chunk->feature_capacity = 0;
}

/* The features that were solved in this pass go to the end of all. */
static qn_status join_features(qni_stages *stages) {
    int64_t total = stages->feature_count;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        if (stages->chunks[n].solve) {
            stages->chunks[n].feature_base = total;
            total += stages->chunks[n].feature_count;
        }
    qni_face_feature *features = qni_realloc(stages->context, stages->features,
                                             stages->feature_count, total, sizeof *features);
    if (!features)
        return qni_fail_memory(stages->error, "a surface");
    stages->features = features;
    stages->feature_count = total;
#pragma omp parallel for schedule(dynamic, 16) num_threads(stages->threads)
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        if (stages->chunks[n].solve)
            number_features(stages, &stages->chunks[n]);
    return QN_OK;
}

/* Faces, then cells, of the chunks that are marked. */
static qn_status run_pass(qni_stages *stages, qni_veto_list *vetoes, double from, double to) {
    ++stages->pass;
    QN_TRY(run_chunks(stages, qni_chunk_faces, from, from + 0.5 * (to - from)));
    QN_TRY(join_features(stages));
    QN_TRY(run_chunks(stages, qni_chunk_cells, from + 0.5 * (to - from), to));
    return qni_stages_gather_vetoes(stages, vetoes);
}

/* Every face segment was used exactly once forward and once reversed: no crack, no edge of three.
 */
static qn_status audit(qni_stages *stages, int64_t *segments) {
    int64_t wrong = 0;
    QN_TRY(run_chunks(stages, qni_chunk_count_uses, 0.9, 0.95));
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t s = 0; s < stages->chunks[n].segment_count; ++s) {
            const qni_segment *segment = &stages->chunks[n].segments[s];
            wrong += segment->used[0] != 1 || segment->used[1] != 1;
        }
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        *segments += stages->chunks[n].segment_count;
    if (wrong)
        return qni_fail(
            stages->error, QN_ERROR_INTERNAL,
            "%lld of %lld face segments were not used once forward and once reversed: the solid "
            "gave different "
            "answers to the same question; its functions must depend on the point alone",
            (long long)wrong, (long long)*segments);
    return QN_OK;
}

/* ---- reports
 * ------------------------------------------------------------------------------------- */

static void report_faces(const qni_stages *stages, qn_solid_surface_report *report) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        const qni_chunk *chunk = &stages->chunks[n];
        for (int64_t leaf = 0; leaf < chunk->leaf_end - chunk->leaf_first; ++leaf)
            for (int face = 0; face < QNI_FACES; ++face)
                report->ambiguous_faces += chunk->faces[leaf].at[face].count > 1;
        for (int64_t s = 0; s < chunk->segment_count; ++s) {
            const qni_segment *segment = &chunk->segments[s];
            for (int m = 0; m < segment->bends; ++m)
                report->face_features += stages->features[segment->feature + (uint32_t)m].sharp;
            report->dropped_face_features += segment->dropped;
            report->unresolved_cells += segment->touching;
        }
    }
}

static void report_cells(const qni_stages *stages, qn_solid_surface_report *report) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        const qni_cms_tally *tally = &stages->chunks[n].tally;
        report->loops += tally->loops;
        report->smooth_loops += tally->smooth_loops;
        report->crease_loops += tally->crease_loops;
        report->corner_loops += tally->corner_loops;
        report->flat_loops += tally->flat_loops;
        report->escaped_corners += tally->escaped_corners;
        report->reaching_corners += tally->reaching_corners;
        report->united_cells += tally->united_cells;
        report->split_loops += tally->split_loops;
        report->multiple_cells += tally->multiple_cells;
        report->moved_loops += tally->moved_loops;
        report->nested_cells += tally->nested_cells;
        report->tubes += tally->tubes;
        report->nested_tubes += tally->nested_tubes;
        report->lost_tubes += tally->lost_tubes;
        report->unresolved_cells += tally->unresolved_cells;
    }
}

static void report_sources(const qni_stages *stages, qn_solid_surface_report *report) {
    const qni_hermite *hermite = stages->hermite;
    report->finest_cell = hermite->lattice.cell;
    report->blocks = hermite->block_count;
    report->evaluations = hermite->evaluations;
    report->crossings = hermite->crossing_count;
    report->multiple_edges = hermite->multiple_edges;
    report->mended_edges = hermite->mended_edges;
    report->leaves = stages->octree->leaf_count;
    for (int64_t n = 0; n < stages->octree->leaf_count; ++n)
        ++report->leaves_by_level[stages->octree->leaves[n].level & 15];
}

/* ---- the stages
 * ---------------------------------------------------------------------------------- */

/* Cells that came out badly are tried together with those beside them. */
static qn_status unite(qni_stages *stages, qni_veto_list *vetoes, bool may_divide) {
    if (!stages->unite)
        return QN_OK;
    QN_TRY(qni_stages_unite(stages, may_divide ? vetoes : NULL));
    if (stages->unions.count == 0)
        return QN_OK;
    ++stages->pass;
    return run_chunks(stages, qni_chunk_cells, 0.85, 0.9);
}

/* Finest cells whose creases are in doubt, and then those that the creases lead to, are looked at
 * closely. */
static qn_status look_closer(qni_stages *stages, qni_veto_list *vetoes) {
    for (int look = 0; stages->unite && look < MOST_LOOKS && vetoes->added == 0; ++look) {
        int64_t added;
        QN_TRY(qni_stages_look_closer(stages, &added));
        if (added == 0)
            break;
        QN_TRY(run_pass(stages, vetoes, 0.85, 0.85));
    }
    return QN_OK;
}

/* `again` stays set when some leaves must be divided first. */
static qn_status run_round(qni_stages *stages, qni_veto_list *vetoes, bool *again,
                           qn_solid_surface_report *report) {
    QN_TRY(qni_stages_cut(stages));
    QN_TRY(run_pass(stages, vetoes, 0, 0.85));
    qni_octree_destroy(stages->octree_before); /* its leaves have told which ones are new */
    if (vetoes->added == 0)
        QN_TRY(look_closer(stages, vetoes));
    if (!*again || vetoes->added == 0)
        QN_TRY(unite(stages, vetoes, *again));
    *again = *again && vetoes->added > 0;
    if (*again) {
        qni_unions_free(stages);
        qni_stages_divide(stages, vetoes);
        return QN_OK;
    }
    report->divided_leaves = vetoes->count - vetoes->added;
    report->skipped_steps = stages->skipped_steps;
    QN_TRY(audit(stages, &report->segments));
    report_faces(stages, report);
    report_cells(stages, report);
    report_sources(stages, report);
    return QN_OK;
}

/* Octree, faces and cells; again, where it changes something, while leaves must be divided, which
 * ends since finest ones never must. */
static qn_status divide_until_well(qni_stages *stages, qni_coarsening *coarsening, bool uniform,
                                   qn_solid_surface_report *report) {
    qn_context *context = stages->context;
    const qni_hermite *hermite = stages->hermite;
    qni_octree octrees[2] = {{.hermite = hermite}, {.hermite = hermite}};
    qni_remembered remembered = {coarsening, NULL};
    qni_veto_list vetoes = {NULL, 0, 0};
    qn_status status = QN_OK;
    bool again = true;
    for (int round = 0; again && status == QN_OK; ++round) {
        const double start = qni_seconds();
        qni_octree *octree = &octrees[round % 2]; /* the one before tells which leaves are new */
        qni_octree_destroy(octree);
        coarsening->vetoes = vetoes.items;
        coarsening->veto_count = vetoes.count;
        status = qni_octree_create(hermite, uniform ? NULL : qni_ask_remembered, &remembered,
                                   octree, stages->error);
        qni_octree_keep_list(&octrees[(round + 1) % 2]);
        if (status != QN_OK)
            break;
        const double built = qni_seconds();
        report->seconds_octree += built - start;
        stages->octree = octree;
        stages->octree_before = &octrees[(round + 1) % 2];
        remembered.before = octree;
        again = round + 1 < MOST_ROUNDS;
        status = run_round(stages, &vetoes, &again, report);
        report->seconds_cms += qni_seconds() - built;
    }
    report->scratch_bytes = qn_context_memory(context).current_bytes;
    qni_unions_free(stages);
    qni_close_free(stages);
    for (int n = 0; n < 2; ++n)
        qni_octree_destroy(&octrees[n]);
    qni_free(context, vetoes.items, vetoes.count, sizeof *vetoes.items);
    return status;
}

/* Leaves and their shapes, with one scratch patch for each thread. */
static qn_status make_shapes(qni_stages *stages, const qni_hermite *hermite,
                             const qni_cms_settings *settings, bool uniform,
                             qn_solid_surface_report *report, qn_error *error) {
    qn_context *context = hermite->context;
    const int32_t threads = qn_context_threads(context);
    qni_patch *patches = qni_alloc_zero(context, threads, sizeof *patches);
    qni_face_solution *solutions = qni_alloc(context, threads, sizeof *solutions);
    qni_face_store *stores = qni_alloc_zero(context, threads, sizeof *stores);
    qn_status status = patches && solutions && stores ? QN_OK : qni_fail_memory(error, "a surface");
    for (int32_t n = 0; patches && n < threads; ++n)
        qni_patch_start(&patches[n], context, hermite, settings);
    qni_coarsening coarsening = {hermite, settings, patches, stores, NULL, 0};
    const qni_stages start = {.context = context,
                              .hermite = hermite,
                              .settings = *settings,
                              .patches = patches,
                              .solutions = solutions,
                              .threads = threads,
                              .unite = settings->features && !settings->scalar,
                              .error = error};
    *stages = start;
    if (status == QN_OK)
        status = divide_until_well(stages, &coarsening, uniform, report);
    for (int32_t n = 0; patches && n < threads; ++n)
        qni_patch_free(&patches[n]);
    qni_free(context, patches, threads, sizeof *patches);
    qni_free(context, solutions, threads, sizeof *solutions);
    qni_free(context, stores, threads, sizeof *stores);
    return status;
}

/* Octree and all that follows; the crossings are of no use after that, and go on the way. */
static qn_status surface_of_hermite(qni_hermite *hermite, const qni_cms_settings *settings,
                                    bool uniform, qn_mesh **mesh_out,
                                    qn_solid_surface_report *report, qn_error *error) {
    qni_stages stages;
    qn_status status = make_shapes(&stages, hermite, settings, uniform, report, error);
    if (status == QN_OK) {
        const double start = qni_seconds();
        qni_stages_keep_shapes(&stages);
        status = qni_stages_assemble(&stages, hermite, mesh_out);
        report->seconds_cms += qni_seconds() - start;
    }
    qni_stages_free(&stages);
    return status;
}

static double extent_of(const qni_box *box) {
    double extent = 0;
    for (int k = 0; k < 3; ++k)
        extent = fmax(extent, box->high[k] - box->low[k]);
    return extent;
}

/* The box that holds the solid, with a little room so that nothing lies on its sides. */
static qni_box bounds_of(const qn_solid *solid, const qn_solid_surface_options *options,
                         double *extent) {
    qni_box box = solid->box;
    *extent = extent_of(&box);
    for (int k = 0; k < 3; ++k) {
        box.low[k] = options->has_box ? options->low[k] : box.low[k] - 1e-3 * *extent;
        box.high[k] = options->has_box ? options->high[k] : box.high[k] + 1e-3 * *extent;
    }
    *extent = options->has_box ? extent_of(&box) : *extent;
    return box;
}

/* What faces and cells ask: the solid that the lattice's edges were cut to, ending at the bounds.
 * The box of an expression is where to look: it goes on beyond, as the lattice's edges saw. */
static qn_status cut_at_bounds(const qni_hermite *hermite, qn_solid **cut_out, qn_error *error) {
    qn_context *context = hermite->context;
    const qni_box *bounds = &hermite->lattice.bounds;
    qn_solid *box = NULL, *cap = NULL;
    qn_status status = qn_solid_box(context, bounds->low, bounds->high, &box, error);
    if (status == QN_OK)
        status = qn_solid_with_owner(context, box, -1, &cap, error);
    if (status == QN_OK) {
        qn_solid *parts[2] = {qni_solid_boundless(context, hermite->solid), cap};
        status = parts[0] ? qn_solid_intersection(context, 2, parts, cut_out, error)
                          : qni_fail_memory(error, "a surface");
        qn_solid_destroy(parts[0]);
    }
    qn_solid_destroy(cap);
    qn_solid_destroy(box);
    return status;
}

/* Is all of a solid within the bounds, and known to be? */
static bool lies_within(const qn_solid *solid, const qni_box *bounds) {
    bool within = solid->ends_in_box;
    for (int k = 0; k < 3; ++k)
        within =
            within && solid->box.low[k] >= bounds->low[k] && solid->box.high[k] <= bounds->high[k];
    return within;
}

static qn_status surface_of_crossings(qni_hermite *hermite, const qni_cms_settings *settings,
                                      const qn_solid_surface_options *options, qn_mesh **mesh_out,
                                      qn_solid_surface_report *report, qn_error *error) {
    if (hermite->crossing_count >= (int64_t)QNI_REF_FEATURE)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "more than 2^30 crossings: take a smaller depth");
    const qn_solid *whole = hermite->solid;
    qn_solid *cut = NULL;
    /* Volumes close by themselves. */
    if (!options->open && !settings->scalar && !lies_within(whole, &hermite->lattice.bounds))
        QN_TRY(cut_at_bounds(hermite, &cut, error));
    hermite->solid = cut ? cut : whole;
    const qn_status status =
        surface_of_hermite(hermite, settings, options->uniform, mesh_out, report, error);
    hermite->solid = whole;
    qn_solid_destroy(cut);
    return status;
}

/* The depth of cells of a size, and the extent that so many of them have, which is no less. */
static qn_status take_cell(double cell, double *extent, int32_t *depth, qn_error *error) {
    *depth = qn_depth_of_cell(cell, *extent);
    if (*depth > QN_MAX_DEPTH)
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "cells of %g are more than %.0f along the longest side (%g): take larger ones", cell,
            qn_depth_cells(QN_MAX_DEPTH), *extent);
    *extent = cell * qn_depth_cells(*depth);
    return QN_OK;
}

static qn_status lay_lattice(const qni_cms_job *job, const qn_solid_surface_options *options,
                             qni_lattice *lattice, qn_error *error) {
    int32_t base = options->base ? options->base : 8, depth = options->depth ? options->depth : 7;
    if (job->samples)
        return qni_lattice_of_samples(lattice, job->solid, base, options->open, error);
    double extent;
    const qni_box bounds = bounds_of(job->solid, options, &extent);
    if (options->cell > 0)
        QN_TRY(take_cell(options->cell, &extent, &depth, error));
    base = base < 1 << depth ? base : 1 << depth;
    return qni_lattice_init(lattice, &bounds, extent, depth, base, error);
}

static qni_cms_settings settings_of(const qni_cms_job *job, const qni_lattice *lattice,
                                    const qn_solid_surface_options *options) {
    const double pi = 3.14159265358979323846;
    const double crease = cos((options->crease > 0 ? options->crease : 30) * pi / 180);
    const double seam = cos((options->crease > 0 ? options->crease : 30) * pi / 540);
    const qni_cms_settings settings = {
        .crease_cosine = job->creases ? crease : -2,
        .seam_cosine = job->creases ? seam : -2, /* a third of the angle */
        .facing_cosine = job->samples ? 0.5 : crease,
        .tolerance = options->tolerance > 0 ? options->tolerance : lattice->cell / 20,
        .features = !options->no_features,
        .open = options->open,
        .scalar = job->samples,
        .join_ties = job->join_ties,
    };
    return settings;
}

/* Flat is what lies in a plane up to how crossings are rounded and corners found. */
static qn_status merge_flat(qn_context *context, double cell, qn_mesh **mesh,
                            qn_solid_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    double most = 0;
    for (int64_t n = 0; n < 3 * (*mesh)->vertex_count; ++n)
        most = fmax(most, fabs((double)(*mesh)->positions[n]));
    qni_flat_report flat;
    const qn_status status =
        qni_mesh_merge_flat(context, mesh, 1e-5 * cell + ldexp(most, -23), &flat, error);
    report->flat_vertices = flat.dropped_vertices;
    report->kept_regions = flat.kept_regions;
    report->seconds_cms += qni_seconds() - start;
    if (status != QN_OK) {
        qn_mesh_destroy(*mesh);
        *mesh = NULL;
    }
    return status;
}

qn_status qni_cms_surface(qn_context *context, const qni_cms_job *job,
                          const qn_solid_surface_options *options, qn_mesh **mesh_out,
                          qn_solid_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    const int64_t held = qn_context_memory(context).current_bytes;
    qni_lattice lattice;
    qni_hermite hermite;
    QN_TRY(lay_lattice(job, options, &lattice, error));
    QN_TRY(qni_hermite_create(context, job->solid, &lattice, &hermite, error));
    report->seconds_sampling = qni_seconds() - start;
    const qni_cms_settings settings = settings_of(job, &lattice, options);
    qn_status status = surface_of_crossings(&hermite, &settings, options, mesh_out, report, error);
    qni_hermite_destroy(&hermite);
    qni_return_memory(context);
    if (status == QN_OK && settings.features && !options->uniform && !options->keep_flat)
        status = merge_flat(context, lattice.cell, mesh_out, report, error);
    if (status != QN_OK)
        return status;
    report->vertices = (*mesh_out)->vertex_count;
    report->triangles = (*mesh_out)->triangle_count;
    report->crease_edges = (*mesh_out)->crease_edge_count;
    report->output_bytes =
        12 * report->vertices + 16 * report->triangles + 8 * report->crease_edges;
    report->scratch_bytes -= held;
    report->seconds_total = qni_seconds() - start;
    return QN_OK;
}
