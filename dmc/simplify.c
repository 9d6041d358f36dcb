// SPDX-License-Identifier: MIT
/* Simplification: the first merges over the whole mesh, then rounds on what is left, until there is
 * nothing to remove. No step's result depends on the number of threads. [DMC21] section 4. */
#include "dmc/simplify.h"
#include "dmc/simplify_parts.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

bool qni_numbers_reserve(qn_context *context, qni_numbers *numbers, int64_t more) {
    const int64_t wanted = numbers->count + more;
    if (wanted <= numbers->capacity)
        return true;
    const int64_t capacity = wanted < 2 * numbers->capacity ? 2 * numbers->capacity : wanted;
    void *grown =
        qni_realloc(context, numbers->items, numbers->capacity, capacity, sizeof *numbers->items);
    if (!grown)
        return false;
    numbers->items = grown;
    numbers->capacity = capacity;
    return true;
}

void qni_numbers_free(qn_context *context, qni_numbers *numbers) {
    qni_free(context, numbers->items, numbers->capacity, sizeof *numbers->items);
    memset(numbers, 0, sizeof *numbers);
}

void qni_simplify_note_memory(qni_simplifier *job) {
    const int64_t held = qn_context_memory(job->context).current_bytes;
    job->most_held = held > job->most_held ? held : job->most_held;
}

/* ---- valences by halfedges ------------------------------------------------------------------- */

/* Vertices where several fans meet stay as they are: mark what each vertex' own fan holds; other
 * sides show the rest. */
static qn_status fix_shared_vertices(const qni_simplifier *job, qn_error *error) {
    const qn_mesh *mesh = job->mesh;
    const int64_t sides = 4 * mesh->quad_count;
    uint8_t *held = qni_alloc_zero(job->context, sides, 1);
    if (!held)
        return qni_fail_memory(error, "the marks of halfedges");
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        const uint32_t start = mesh->vertex_halfedges[v];
        if (start == QN_NO_HALFEDGE)
            continue;
        uint32_t h = start;
        do {
            held[h] = 1;
            h = qni_next_round(mesh->twins, h);
        } while (h != start && h != QN_NO_HALFEDGE);
    }
    for (int64_t h = 0; h < sides; ++h)
        if (!held[h])
            job->around.valence[mesh->quads[h]] = QNI_VALENCE_FIXED;
    qni_free(job->context, held, sides, 1);
    return QN_OK;
}

/* Nothing is known of the mesh: all vertices need their link conditions checked, no quad has a
 * colour. */
static qn_status measure_valences(const qni_simplifier *job, qn_error *error) {
    const qn_mesh *mesh = job->mesh;
    const int32_t threads = job->threads;
    int64_t sides = 0;
    (void)threads;
#pragma omp parallel for schedule(static) num_threads(threads) reduction(+ : sides)
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        const uint32_t start = mesh->vertex_halfedges[v];
        int closed = 0;
        const uint32_t size =
            start == QN_NO_HALFEDGE ? 0 : qni_fan_size(mesh->twins, start, &closed);
        const bool good = closed && size <= QNI_VALENCE_LARGEST;
        job->around.valence[v] = (uint8_t)(good ? size | QNI_VALENCE_APART : QNI_VALENCE_FIXED);
        sides += size;
    }
    memset(job->around.colour, QNI_COLOUR_APART, (size_t)mesh->quad_count);
    return sides == 4 * mesh->quad_count ? QN_OK : fix_shared_vertices(job, error);
}

/* ---- all of it ------------------------------------------------------------------------------- */

static qn_status run_passes(qni_simplifier *job, qn_error *error) {
    int64_t before = 0;
    QN_TRY(qni_simplify_first(job, error));
    do {
        before = job->report.passes ? job->report.merged_quads + job->report.shrunk_quads : 0;
        QN_TRY(qni_simplify_round(job, false, error));
        QN_TRY(qni_simplify_round(job, true, error));
        ++job->report.passes;
    } while (job->report.merged_quads + job->report.shrunk_quads > before &&
             job->report.passes != job->options->passes);
    return QN_OK;
}

/* Vertices that were merged name the one that is left of them. */
static void name_kept_vertices(const qni_simplifier *job) {
    const qni_around *around = &job->around;
    for (int64_t n = 0; n < job->kept.count; ++n) {
        const uint32_t kept = job->kept.items[n];
        if (around->valence[kept] == QNI_VALENCE_GONE)
            continue;
        for (uint32_t v = around->circle[kept]; v != kept;) {
            const uint32_t next = around->circle[v];
            around->circle[v] = kept;
            v = next;
        }
        around->circle[kept] = kept;
    }
}

static qn_status run(qni_simplifier *job, qn_error *error) {
    if (!job->options->valences)
        QN_TRY(measure_valences(job, error));
    QN_TRY(qni_around_init(&job->around, error));
    if (job->options->paper) {
        QN_TRY(qni_simplify_as_paper(job, error));
        job->report.passes = 1;
    } else {
        QN_TRY(run_passes(job, error));
    }
    name_kept_vertices(job);
    qni_simplify_note_memory(job);
    return qni_compact_mesh(job->context, job->mesh, job->around.valence, job->around.colour,
                            job->around.circle, error);
}

qn_status qni_simplify(qn_context *context, qn_mesh *mesh, const qni_simplify_options *options,
                       qni_simplify_report *report_out, qn_error *error) {
    const double start = qni_seconds();
    const int64_t vertices = mesh->vertex_count, quads = mesh->quad_count;
    const int64_t held_before = qn_context_memory(context).current_bytes;
    memset(report_out, 0, sizeof *report_out);
    if (quads == 0)
        return QN_OK;
    if (mesh->triangle_count || (!mesh->twins && !(options->valences && options->index)))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "only meshes of quads with halfedges can be simplified");
    const bool own = !options->valences;
    qni_simplifier job = {.context = context,
                          .mesh = mesh,
                          .options = options,
                          .kernels = qni_choose_kernels(),
                          .threads = qn_context_threads(context)};
    job.around = (qni_around){.context = context, .mesh = mesh, .index = options->index};
    job.around.valence = own ? qni_alloc(context, vertices + 1, 1) : options->valences;
    job.around.colour = own ? qni_alloc(context, quads + 1, 1) : options->colours;
    job.around.circle = qni_alloc(context, vertices, sizeof *job.around.circle);
    const bool good = job.around.valence && job.around.colour && job.around.circle;
    const qn_status status =
        good ? run(&job, error) : qni_fail_memory(error, "the marks of vertices and quads");
    job.report.scratch_bytes = job.most_held - held_before;
    qni_free(context, job.around.circle, vertices, sizeof *job.around.circle);
    if (own) {
        qni_free(context, job.around.valence, vertices + 1, 1);
        qni_free(context, job.around.colour, quads + 1, 1);
    }
    qni_around_free(&job.around);
    qni_numbers_free(context, &job.suspects);
    qni_numbers_free(context, &job.rings);
    qni_numbers_free(context, &job.kept);
    job.report.seconds = qni_seconds() - start;
    *report_out = job.report;
    return status;
}
