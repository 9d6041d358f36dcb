// SPDX-License-Identifier: MIT
/* Caps: the rims of a chain are walked as loops, and each loop is closed by a fan round its middle.
 * The rims' own ways cancel at each vertex (the boundary of a boundary is nothing), so every walk
 * closes. */
#include "solid/chain.h"

#include <stdlib.h>
#include <string.h>

typedef struct rim {
    uint32_t from, to;
    int64_t number; /* the two ways of an undirected one have the same */
} rim;

typedef struct cap_job {
    const qni_chain *chain;
    qni_panel_tree *caps;
    rim *rims; /* by `from` */
    int64_t rim_count, rim_capacity;
    uint8_t *used;
    int64_t *place; /* [vertex_count]: place in the path + 1 */
    uint32_t *path;
    int64_t length, loops;
    bool even;
} cap_job;

static int compare_rims(const void *a, const void *b) {
    const rim *p = a, *q = b;
    if (p->from != q->from)
        return p->from < q->from ? -1 : 1;
    return p->number < q->number ? -1 : p->number > q->number;
}

static void list_rims(cap_job *job) {
    const qni_chain *chain = job->chain;
    int64_t numbers = 0;
    for (int64_t n = 0, end; n < 3 * chain->count; n = end) {
        const qni_chain_edge *edge = &chain->edges[n];
        int64_t net = 0;
        for (end = n; end < 3 * chain->count && chain->edges[end].low == edge->low &&
                      chain->edges[end].high == edge->high;
             ++end)
            net += chain->edges[end].way;
        if (job->even && (end - n) % 2) {
            job->rims[job->rim_count++] = (rim){edge->low, edge->high, numbers};
            job->rims[job->rim_count++] = (rim){edge->high, edge->low, numbers++};
        }
        for (int64_t i = 0; !job->even && i < (net < 0 ? -net : net); ++i)
            job->rims[job->rim_count++] = net > 0 ? (rim){edge->low, edge->high, numbers++}
                                                  : (rim){edge->high, edge->low, numbers++};
    }
    if (job->rim_count)
        qsort(job->rims, (size_t)job->rim_count, sizeof *job->rims, compare_rims);
}

static int64_t first_rim(const cap_job *job, uint32_t from) {
    int64_t low = 0, high = job->rim_count;
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (job->rims[middle].from < from)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static const rim *next_rim(cap_job *job, uint32_t from) {
    for (int64_t n = first_rim(job, from); n < job->rim_count && job->rims[n].from == from; ++n)
        if (!job->used[job->rims[n].number]) {
            job->used[job->rims[n].number] = 1;
            return &job->rims[n];
        }
    return NULL;
}

/* Off the middle by an odd thousandth: then no spoke of a symmetrical hole lies on lattice lines.
 * Caps that are surface stay where they are. */
static void middle_of(const cap_job *job, const uint32_t *loop, int64_t count, float out[3]) {
    static const double odd[3] = {0.5317, 0.3671, -0.7633};
    double middle[3] = {0, 0, 0}, reach = 0;
    for (int64_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k)
            middle[k] += (double)job->chain->places[loop[i]][k] / (double)count;
    for (int k = 0; k < 3; ++k)
        reach = fmax(reach, fabs((double)job->chain->places[loop[0]][k] - middle[k]));
    for (int k = 0; k < 3; ++k)
        out[k] = (float)(middle[k] + (job->even ? 0 : 1e-3 * reach * odd[k]));
}

static bool close_loop(cap_job *job, const uint32_t *loop, int64_t count) {
    const qni_chain *chain = job->chain;
    if (count < 3)
        return true;
    float middle[3];
    middle_of(job, loop, count, middle);
    ++job->loops;
    for (int64_t i = 0; i < count; ++i) {
        qni_panel panel = {.owner = chain->owners[0], .number = job->caps->count};
        memcpy(panel.at[0], chain->places[loop[(i + 1) % count]], sizeof panel.at[0]);
        memcpy(panel.at[1], chain->places[loop[i]], sizeof panel.at[1]);
        memcpy(panel.at[2], middle, sizeof panel.at[2]);
        if (!qni_panel_tree_add(chain->context, job->caps, &panel))
            return false;
    }
    return true;
}

static void push(cap_job *job, uint32_t vertex) {
    job->path[job->length++] = vertex;
    job->place[vertex] = job->length;
}

static bool walk_from(cap_job *job, uint32_t start) {
    push(job, start);
    while (job->length) {
        const rim *next = next_rim(job, job->path[job->length - 1]);
        if (!next) {
            job->place[job->path[--job->length]] = 0;
            continue;
        }
        if (!job->place[next->to]) {
            push(job, next->to);
            continue;
        }
        int64_t from = job->place[next->to] - 1;
        if (!close_loop(job, job->path + from, job->length - from))
            return false;
        while (job->length > from + 1)
            job->place[job->path[--job->length]] = 0;
    }
    return true;
}

bool qni_chain_cap(const qni_chain *chain, bool even, qni_panel_tree *caps, int64_t *loops_out) {
    qn_context *context = chain->context;
    cap_job job = {.chain = chain, .caps = caps, .even = even};
    job.rim_capacity = even ? 2 * chain->odd_edges : chain->rim_edges;
    *loops_out = 0;
    if (job.rim_capacity == 0)
        return true;
    job.rims = qni_alloc(context, job.rim_capacity, sizeof *job.rims);
    job.used = qni_alloc_zero(context, job.rim_capacity, 1);
    job.place = qni_alloc_zero(context, chain->vertex_count, sizeof *job.place);
    job.path = qni_alloc(context, chain->vertex_count, sizeof *job.path);
    bool good = job.rims && job.used && job.place && job.path;
    if (good)
        list_rims(&job);
    for (int64_t n = 0; good && n < job.rim_count; ++n)
        if (!job.used[job.rims[n].number])
            good = walk_from(&job, job.rims[n].from);
    *loops_out = job.loops;
    qni_free(context, job.rims, job.rim_capacity, sizeof *job.rims);
    qni_free(context, job.used, job.rim_capacity, 1);
    qni_free(context, job.place, chain->vertex_count, sizeof *job.place);
    qni_free(context, job.path, chain->vertex_count, sizeof *job.path);
    return good;
}
