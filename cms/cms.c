// SPDX-License-Identifier: MIT
/* Cubical Marching Squares [CMS05] from solid to mesh: sample, coarsen, faces, cells, mesh. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 12 };

typedef struct veto_list {
    qni_cell *items;
    int64_t count;
} veto_list;

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

static qn_status join_features(qni_stages *stages) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        stages->chunks[n].feature_base = stages->feature_count;
        stages->feature_count += stages->chunks[n].feature_count;
    }
    stages->features = qni_alloc(stages->context, stages->feature_count, sizeof *stages->features);
    if (!stages->features)
        return qni_fail_memory(stages->error, "a surface");
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        qni_chunk *chunk = &stages->chunks[n];
        if (chunk->feature_count)
            memcpy(stages->features + chunk->feature_base, chunk->features,
                   sizeof *chunk->features * (size_t)chunk->feature_count);
        qni_free(stages->context, chunk->features, chunk->feature_capacity,
                 sizeof *chunk->features);
        chunk->features = NULL;
        chunk->feature_capacity = 0;
    }
    return QN_OK;
}

/* Every face segment was used exactly once forward and once reversed: no crack, no edge of three.
 */
static qn_status audit(const qni_stages *stages, int64_t *segments) {
    int64_t wrong = 0;
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

/* ---- the mesh
 * ------------------------------------------------------------------------------------ */

typedef struct assembly {
    uint32_t *crossing_index; /* final index of each crossing; QNI_NONE when no triangle uses it */
    int64_t crossings, features, apexes, triangles, creases;
} assembly;

static void mark_used(const qni_stages *stages, assembly *parts) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        const qni_chunk *chunk = &stages->chunks[n];
        for (int64_t t = 0; t < chunk->triangle_count; ++t)
            for (int k = 0; k < 3; ++k)
                if (QNI_REF_KIND(chunk->triangles[t][k]) == QNI_REF_CROSSING)
                    parts->crossing_index[QNI_REF_NUMBER(chunk->triangles[t][k])] = 0;
    }
    for (int64_t n = 0; n < stages->hermite->crossing_count; ++n)
        if (parts->crossing_index[n] == 0)
            parts->crossing_index[n] = (uint32_t)parts->crossings++;
}

static void count_parts(qni_stages *stages, assembly *parts) {
    parts->features = stages->feature_count;
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        qni_chunk *chunk = &stages->chunks[n];
        chunk->apex_base = parts->apexes;
        chunk->triangle_base = parts->triangles;
        chunk->crease_base = parts->creases;
        parts->apexes += chunk->apex_count;
        parts->triangles += chunk->triangle_count;
        parts->creases += chunk->crease_count;
    }
}

static uint32_t final_index(const assembly *parts, const qni_chunk *chunk, uint32_t ref) {
    const uint32_t number = QNI_REF_NUMBER(ref);
    if (QNI_REF_KIND(ref) == QNI_REF_CROSSING)
        return parts->crossing_index[number];
    if (QNI_REF_KIND(ref) == QNI_REF_FEATURE)
        return (uint32_t)parts->crossings + number;
    return (uint32_t)(parts->crossings + parts->features + chunk->apex_base) + number;
}

static void fill_chunk(const qni_stages *stages, const assembly *parts, int64_t index,
                       qn_mesh *mesh) {
    const qni_chunk *chunk = &stages->chunks[index];
    for (int64_t t = 0; t < chunk->triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            mesh->triangles[3 * (chunk->triangle_base + t) + k] =
                final_index(parts, chunk, chunk->triangles[t][k]);
    if (chunk->triangle_count)
        memcpy(mesh->triangle_owners + chunk->triangle_base, chunk->owners,
               sizeof *chunk->owners * (size_t)chunk->triangle_count);
    for (int64_t c = 0; c < chunk->crease_count; ++c)
        for (int k = 0; k < 2; ++k)
            mesh->crease_edges[2 * (chunk->crease_base + c) + k] =
                final_index(parts, chunk, chunk->creases[c][k]);
    if (chunk->apex_count)
        memcpy(mesh->positions + 3 * (parts->crossings + parts->features + chunk->apex_base),
               chunk->apexes, sizeof *chunk->apexes * (size_t)chunk->apex_count);
}

static void fill_mesh(const qni_stages *stages, const assembly *parts, qn_mesh *mesh) {
    const qni_hermite *hermite = stages->hermite;
#pragma omp parallel for schedule(static) num_threads(stages->threads)
    for (int64_t n = 0; n < hermite->crossing_count; ++n)
        if (parts->crossing_index[n] != QNI_NONE)
            memcpy(mesh->positions + 3 * (int64_t)parts->crossing_index[n],
                   hermite->crossings[n].place, 3 * sizeof(float));
#pragma omp parallel for schedule(static) num_threads(stages->threads)
    for (int64_t n = 0; n < stages->feature_count; ++n)
        memcpy(mesh->positions + 3 * (parts->crossings + n), stages->features[n].place,
               3 * sizeof(float));
#pragma omp parallel for schedule(dynamic, 16) num_threads(stages->threads)
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        fill_chunk(stages, parts, n, mesh);
}

static qn_status allocate_tags(qn_context *context, const assembly *parts, qn_mesh *mesh,
                               qn_error *error) {
    mesh->triangle_owners = qni_alloc(context, parts->triangles, sizeof *mesh->triangle_owners);
    if (parts->creases)
        mesh->crease_edges = qni_alloc(context, parts->creases, 2 * sizeof *mesh->crease_edges);
    mesh->crease_edge_count = mesh->crease_edges ? parts->creases : 0;
    if (!mesh->triangle_owners || (parts->creases && !mesh->crease_edges))
        return qni_fail_memory(error, "a mesh");
    return QN_OK;
}

static qn_status assemble(qni_stages *stages, qn_mesh **mesh_out) {
    const int64_t crossings = stages->hermite->crossing_count;
    assembly parts = {.crossing_index = qni_alloc(stages->context, crossings, sizeof(uint32_t))};
    if (!parts.crossing_index)
        return qni_fail_memory(stages->error, "a mesh");
    memset(parts.crossing_index, 0xff, sizeof(uint32_t) * (size_t)crossings);
    mark_used(stages, &parts);
    count_parts(stages, &parts);
    qn_mesh *mesh = NULL;
    qn_status status =
        qni_mesh_alloc(stages->context, parts.crossings + parts.features + parts.apexes, 0,
                       parts.triangles, false, &mesh, stages->error);
    if (status == QN_OK)
        status = allocate_tags(stages->context, &parts, mesh, stages->error);
    if (status == QN_OK) {
        fill_mesh(stages, &parts, mesh);
        *mesh_out = mesh;
    } else {
        qn_mesh_destroy(mesh);
    }
    qni_free(stages->context, parts.crossing_index, crossings, sizeof(uint32_t));
    return status;
}

/* ---- reports
 * ------------------------------------------------------------------------------------- */

static void report_tally(const qni_stages *stages, qn_solid_surface_report *report) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        const qni_cms_tally *tally = &stages->chunks[n].tally;
        report->ambiguous_faces += tally->ambiguous_faces;
        report->face_features += tally->face_features;
        report->dropped_face_features += tally->dropped_features;
        report->loops += tally->loops;
        report->smooth_loops += tally->smooth_loops;
        report->crease_loops += tally->crease_loops;
        report->corner_loops += tally->corner_loops;
        report->flat_loops += tally->flat_loops;
        report->escaped_corners += tally->escaped_corners;
        report->multiple_cells += tally->multiple_cells;
        report->moved_loops += tally->moved_loops;
        report->nested_cells += tally->nested_cells;
        report->unresolved_cells += tally->unresolved_cells + tally->unresolved_faces;
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

static void free_stages(qni_stages *stages) {
    for (int64_t n = 0; stages->chunks && n < stages->chunk_count; ++n) {
        qni_chunk *chunk = &stages->chunks[n];
        qni_free(stages->context, chunk->segments, chunk->segment_capacity,
                 sizeof *chunk->segments);
        qni_free(stages->context, chunk->features, chunk->feature_capacity,
                 sizeof *chunk->features);
        qni_free(stages->context, chunk->triangles, chunk->triangle_capacity,
                 sizeof *chunk->triangles);
        qni_free(stages->context, chunk->owners, chunk->owner_capacity, sizeof *chunk->owners);
        qni_free(stages->context, chunk->apexes, chunk->apex_capacity, sizeof *chunk->apexes);
        qni_free(stages->context, chunk->creases, chunk->crease_capacity, sizeof *chunk->creases);
        qni_free(stages->context, chunk->vetoes, chunk->veto_capacity, sizeof *chunk->vetoes);
    }
    qni_free(stages->context, stages->chunks, stages->chunk_count, sizeof *stages->chunks);
    qni_free(stages->context, stages->faces, stages->octree->leaf_count, sizeof *stages->faces);
    qni_free(stages->context, stages->features, stages->feature_count, sizeof *stages->features);
}

/* Vetoes of all chunks, those before included, in order; `added` tells how many are new. */
static qn_status gather_vetoes(const qni_stages *stages, veto_list *list, int64_t *added) {
    *added = 0;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        *added += stages->chunks[n].veto_count;
    if (*added == 0)
        return QN_OK;
    qni_cell *items =
        qni_realloc(stages->context, list->items, list->count, list->count + *added, sizeof *items);
    if (!items)
        return qni_fail_memory(stages->error, "a surface");
    list->items = items;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t m = 0; m < stages->chunks[n].veto_count; ++m)
            items[list->count++] = stages->chunks[n].vetoes[m];
    qsort(items, (size_t)list->count, sizeof *items, qni_compare_vetoes);
    return QN_OK;
}

/* `mesh_out` stays NULL when some leaves must be divided first and `again` is set. */
static qn_status run_stages(qni_stages *stages, veto_list *vetoes, bool *again, qn_mesh **mesh_out,
                            qn_solid_surface_report *report) {
    stages->chunk_count = (stages->octree->leaf_count + QNI_CHUNK - 1) / QNI_CHUNK;
    stages->chunks = qni_alloc_zero(stages->context, stages->chunk_count, sizeof *stages->chunks);
    stages->faces = qni_alloc(stages->context, stages->octree->leaf_count, sizeof *stages->faces);
    if (!stages->chunks || !stages->faces)
        return qni_fail_memory(stages->error, "a surface");
    QN_TRY(run_chunks(stages, qni_chunk_faces, 0, 0.4));
    QN_TRY(join_features(stages));
    QN_TRY(run_chunks(stages, qni_chunk_cells, 0.4, 0.9));
    int64_t added;
    QN_TRY(gather_vetoes(stages, vetoes, &added));
    *again = *again && added > 0;
    if (*again)
        return QN_OK;
    report->divided_leaves = vetoes->count - added;
    QN_TRY(audit(stages, &report->segments));
    QN_TRY(assemble(stages, mesh_out));
    report_tally(stages, report);
    report_sources(stages, report);
    return QN_OK;
}

/* Octree, faces and cells; again while leaves must be divided, which ends since finest ones never
 * must. */
static qn_status divide_until_well(const qni_hermite *hermite, qni_coarsening *coarsening,
                                   bool uniform, qn_mesh **mesh_out,
                                   qn_solid_surface_report *report, qn_error *error) {
    qn_context *context = hermite->context;
    veto_list vetoes = {NULL, 0};
    qn_status status = QN_OK;
    bool again = true;
    for (int round = 0; again && status == QN_OK; ++round) {
        const double start = qni_seconds();
        qni_octree octree;
        coarsening->vetoes = vetoes.items;
        coarsening->veto_count = vetoes.count;
        status = qni_octree_create(hermite, uniform ? NULL : qni_cell_is_explained, coarsening,
                                   &octree, error);
        if (status != QN_OK)
            break;
        const double built = qni_seconds();
        report->seconds_octree += built - start;
        qni_stages stages = {.context = context,
                             .hermite = hermite,
                             .octree = &octree,
                             .settings = *coarsening->settings,
                             .patches = coarsening->patches,
                             .solutions = coarsening->faces,
                             .threads = qn_context_threads(context),
                             .error = error};
        again = round + 1 < MOST_ROUNDS;
        status = run_stages(&stages, &vetoes, &again, mesh_out, report);
        report->scratch_bytes = qn_context_memory(context).current_bytes;
        free_stages(&stages);
        qni_octree_destroy(&octree);
        report->seconds_cms += qni_seconds() - built;
    }
    qni_free(context, vetoes.items, vetoes.count, sizeof *vetoes.items);
    return status;
}

/* Octree and all that follows, with one scratch patch for each thread. */
static qn_status surface_of_hermite(const qni_hermite *hermite, const qni_cms_settings *settings,
                                    bool uniform, qn_mesh **mesh_out,
                                    qn_solid_surface_report *report, qn_error *error) {
    qn_context *context = hermite->context;
    const int32_t threads = qn_context_threads(context);
    qni_patch *patches = qni_alloc_zero(context, threads, sizeof *patches);
    qni_face_solution *solutions = qni_alloc(context, threads, sizeof *solutions);
    qn_status status = patches && solutions ? QN_OK : qni_fail_memory(error, "a surface");
    for (int32_t n = 0; patches && n < threads; ++n)
        qni_patch_start(&patches[n], context, hermite, settings);
    qni_coarsening coarsening = {hermite, settings, patches, solutions, NULL, 0};
    if (status == QN_OK)
        status = divide_until_well(hermite, &coarsening, uniform, mesh_out, report, error);
    for (int32_t n = 0; patches && n < threads; ++n)
        qni_patch_free(&patches[n]);
    qni_free(context, patches, threads, sizeof *patches);
    qni_free(context, solutions, threads, sizeof *solutions);
    return status;
}

/* The box that holds the solid, with a little room so that nothing lies on its sides. */
static qni_box bounds_of(const qn_solid *solid, const qn_solid_surface_options *options) {
    qni_box box = solid->box;
    double extent = 0;
    for (int k = 0; k < 3; ++k)
        extent = fmax(extent, box.high[k] - box.low[k]);
    for (int k = 0; k < 3; ++k) {
        box.low[k] = options->has_box ? options->low[k] : box.low[k] - 1e-3 * extent;
        box.high[k] = options->has_box ? options->high[k] : box.high[k] + 1e-3 * extent;
    }
    return box;
}

qn_status qni_cms_surface(qn_context *context, const qn_solid *solid,
                          const qn_solid_surface_options *options, qn_mesh **mesh_out,
                          qn_solid_surface_report *report, qn_error *error) {
    const double start = qni_seconds(), pi = 3.14159265358979323846;
    const int64_t held = qn_context_memory(context).current_bytes;
    const qni_box bounds = bounds_of(solid, options);
    qni_lattice lattice;
    qni_hermite hermite;
    QN_TRY(qni_lattice_init(&lattice, &bounds, options->depth ? options->depth : 7,
                            options->base ? options->base : 8, error));
    QN_TRY(qni_hermite_create(context, solid, &lattice, &hermite, error));
    report->seconds_sampling = qni_seconds() - start;
    const qni_cms_settings settings = {
        .crease_cosine = cos((options->crease > 0 ? options->crease : 30) * pi / 180),
        .tolerance = options->tolerance > 0 ? options->tolerance : lattice.cell / 20,
        .features = !options->no_features,
        .open = options->open,
    };
    qn_status status;
    if (hermite.crossing_count >= (int64_t)QNI_REF_FEATURE)
        status = qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                          "more than 2^30 crossings: take a smaller depth");
    else
        status = surface_of_hermite(&hermite, &settings, options->uniform, mesh_out, report, error);
    qni_hermite_destroy(&hermite);
    if (status != QN_OK)
        return status;
    report->vertices = (*mesh_out)->vertex_count;
    report->triangles = (*mesh_out)->triangle_count;
    report->crease_edges = (*mesh_out)->crease_edge_count;
    report->output_bytes =
        12 * report->vertices + 16 * report->triangles + 8 * report->crease_edges;
    report->scratch_bytes -= held + report->output_bytes;
    report->seconds_total = qni_seconds() - start;
    return QN_OK;
}
