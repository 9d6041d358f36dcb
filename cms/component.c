// SPDX-License-Identifier: MIT
/* One cell's loops: directed pieces of the face segments chained until they close [CMS05 3.4,
 * design of 4.3]. */
#include "cms/cms.h"
#include "core/context.h"

#include <stdlib.h>
#include <string.h>

void qni_patch_start(qni_patch *patch, qn_context *context, const qni_hermite *hermite,
                     const qni_cms_settings *settings) {
    memset(patch, 0, sizeof *patch);
    patch->context = context;
    patch->hermite = hermite;
    patch->settings = settings;
    qni_nearby_start(&patch->nearby, hermite);
    patch->solid = &patch->nearby.base;
}

void qni_patch_free(qni_patch *patch) {
    qni_nearby_end(&patch->nearby);
    qni_free(patch->context, patch->pieces, patch->piece_capacity, sizeof *patch->pieces);
    qni_free(patch->context, patch->vertices, patch->vertex_capacity, sizeof *patch->vertices);
    qni_free(patch->context, patch->loops, patch->loop_capacity, sizeof *patch->loops);
    qni_free(patch->context, patch->triangles, patch->triangle_capacity, sizeof *patch->triangles);
    qni_free(patch->context, patch->scratch, patch->scratch_capacity, sizeof *patch->scratch);
    qni_free(patch->context, patch->inner, patch->inner_capacity, sizeof *patch->inner);
}

bool qni_patch_grow(qni_patch *patch, void **items, int64_t *capacity, int64_t wanted,
                    size_t size) {
    if (wanted <= *capacity)
        return true;
    int64_t more = *capacity ? 2 * *capacity : 64;
    more = more < wanted ? wanted : more;
    void *fresh = qni_realloc(patch->context, *items, *capacity, more, size);
    if (!fresh) {
        patch->failed = true;
        return false;
    }
    *items = fresh;
    *capacity = more;
    return true;
}

static void start_box(qni_patch *patch, const qni_cell *cell, const int32_t size[3]) {
    patch->cell = *cell;
    for (int k = 0; k < 3; ++k) {
        patch->low[k] = (float)qni_lattice_at(&patch->hermite->lattice, k, cell->low[k]);
        patch->high[k] = (float)qni_lattice_at(&patch->hermite->lattice, k, cell->low[k] + size[k]);
    }
    for (int k = 0; k < 3; ++k) {
        const double room = patch->hermite->lattice.clearance;
        patch->clear_low[k] = (float)((double)patch->low[k] + room);
        patch->clear_high[k] = (float)((double)patch->high[k] - room);
    }
    patch->size = patch->hermite->lattice.cell * (1 << cell->level);
    patch->piece_count = patch->vertex_count = patch->loop_count = patch->triangle_count =
        patch->inner_count = 0;
    patch->dropped = 0;
    patch->youngest = 0;
    patch->beside_finer = false;
    patch->most_bad = INT64_MAX;
    patch->split = patch->flat_only = false;
}

void qni_patch_set_cell(qni_patch *patch, const qni_cell *cell) {
    const int32_t width = 1 << cell->level, size[3] = {width, width, width};
    start_box(patch, cell, size);
    qni_nearby_set_cell(&patch->nearby, cell, false);
    patch->united = false;
    patch->may_split = cell->level == 0;
}

void qni_patch_set_union(qni_patch *patch, const qni_cell_box *box) {
    const qni_cell lowest = {{box->low[0], box->low[1], box->low[2]}, 0};
    const qni_cell about = {{box->low[0], box->low[1], box->low[2]}, 1}; /* as large as any union */
    start_box(patch, &lowest, box->size);
    qni_nearby_set_cell(&patch->nearby, &about, true);
    patch->united = true;
    patch->size_cells = box->size[0] * box->size[1] * box->size[2];
    patch->may_split = box->split;
}

bool qni_patch_add_piece(qni_patch *patch, const qni_segment *segment, bool out, uint32_t base) {
    if (!qni_patch_grow(patch, (void **)&patch->pieces, &patch->piece_capacity,
                        patch->piece_count + 1, sizeof *patch->pieces))
        return false;
    const qni_directed piece = {out ? segment->from : segment->to,
                                out ? segment->to : segment->from, segment->feature + base,
                                segment->bends, !out};
    patch->pieces[patch->piece_count++] = piece;
    patch->youngest = segment->pass > patch->youngest ? segment->pass : patch->youngest;
    patch->dropped += segment->dropped;
    return true;
}

static int compare_pieces(const void *a, const void *b) {
    const uint32_t p = ((const qni_directed *)a)->from, q = ((const qni_directed *)b)->from;
    return p < q ? -1 : p > q;
}

/* A cell has a handful of pieces; a large one beside fine neighbours can have thousands. */
static void sort_pieces(qni_patch *patch) {
    if (patch->piece_count > 24) {
        qsort(patch->pieces, (size_t)patch->piece_count, sizeof *patch->pieces, compare_pieces);
        return;
    }
    for (int64_t n = 1; n < patch->piece_count; ++n) {
        const qni_directed piece = patch->pieces[n];
        int64_t m = n;
        for (; m > 0 && patch->pieces[m - 1].from > piece.from; --m)
            patch->pieces[m] = patch->pieces[m - 1];
        patch->pieces[m] = piece;
    }
}

static int64_t find_piece(const qni_patch *patch, uint32_t from) {
    int64_t low = 0, high = patch->piece_count;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (patch->pieces[middle].from < from)
            low = middle + 1;
        else
            high = middle;
    }
    return low < patch->piece_count && patch->pieces[low].from == from ? low : -1;
}

static bool add_vertex(qni_patch *patch, uint32_t ref, const qni_hermite_crossing *crossing,
                       const qni_face_feature *feature) {
    const float *place = crossing ? crossing->place : feature->place;
    if (!qni_patch_grow(patch, (void **)&patch->vertices, &patch->vertex_capacity,
                        patch->vertex_count + 1, sizeof *patch->vertices))
        return false;
    qni_loop_vertex *vertex = &patch->vertices[patch->vertex_count++];
    vertex->same = (int32_t)patch->vertex_count - 1;
    vertex->ref = ref;
    vertex->crossing = crossing;
    vertex->sharp = feature && feature->sharp;
    vertex->has_plane = crossing || feature->has_plane;
    vertex->owner = crossing ? crossing->owner : feature->owner;
    memcpy(vertex->normal, crossing ? crossing->normal : feature->normal, sizeof vertex->normal);
    vertex->walls = 0;
    for (int k = 0; k < 3; ++k) {
        vertex->place[k] = place[k];
        vertex->at[k] = feature && feature->has_plane ? feature->at[k] : (double)place[k];
        vertex->walls |= (uint8_t)((place[k] == patch->low[k]) << 2 * k |
                                   (place[k] == patch->high[k]) << (2 * k + 1));
    }
    if (crossing)
        vertex->at[crossing->axis] = crossing->at;
    return true;
}

static bool trace_one(qni_patch *patch, int64_t start, const qni_face_feature *features) {
    if (!qni_patch_grow(patch, (void **)&patch->loops, &patch->loop_capacity, patch->loop_count + 1,
                        sizeof *patch->loops))
        return false;
    qni_loop *loop = &patch->loops[patch->loop_count++];
    memset(loop, 0, sizeof *loop);
    loop->first = (int32_t)patch->vertex_count;
    const uint32_t first = patch->pieces[start].from;
    int64_t at = start;
    for (int64_t steps = 0; steps <= patch->piece_count; ++steps) {
        qni_directed *piece = &patch->pieces[at];
        const qni_hermite_crossing *crossing = &patch->hermite->crossings[piece->from];
        if (piece->to == QNI_NONE) /* taken: two pieces end here */
            return false;
        if (!add_vertex(patch, QNI_REF_CROSSING | piece->from, crossing, NULL))
            return false;
        for (uint32_t n = 0; n < piece->bends; ++n) {
            const uint32_t number = piece->feature + (piece->reversed ? piece->bends - 1 - n : n);
            if (!add_vertex(patch, QNI_REF_FEATURE | number, NULL, &features[number]))
                return false;
            loop->sharp_count += features[number].sharp;
        }
        const uint32_t next = piece->to;
        piece->to = QNI_NONE;
        if (next == first) {
            loop->count = (int32_t)patch->vertex_count - loop->first;
            return true;
        }
        at = find_piece(patch, next);
        if (at < 0)
            return false;
    }
    return false;
}

bool qni_patch_trace(qni_patch *patch, const qni_face_feature *features) {
    sort_pieces(patch);
    for (int64_t n = 1; n < patch->piece_count; ++n)
        if (patch->pieces[n].from == patch->pieces[n - 1].from)
            return false;
    for (int64_t n = 0; n < patch->piece_count; ++n)
        if (patch->pieces[n].to != QNI_NONE && !trace_one(patch, n, features))
            return false;
    patch->traced_loops = patch->loop_count;
    return true;
}
