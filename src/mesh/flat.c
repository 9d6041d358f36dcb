// SPDX-License-Identifier: MIT
/* Flat parts with fewer triangles (flat.h): regions are found, their vertices dropped, edges
 * flipped; then what is new is held against the whole mesh. Where it meets anything, which takes
 * surfaces nearer to each other than rounding can tell, its regions are left alone, and all is done
 * again without them. */
#include "mesh/flat_parts.h"
#include "mesh/box_tree.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { MOST_ATTEMPTS = 8 };

typedef struct barred_regions {
    uint8_t *marks; /* [count]; NULL while none is */
    int64_t count, number;
} barred_regions;

/* ---- the triangles at hand ------------------------------------------------------------------- */

static bool allocate(qni_flat *flat) {
    qn_context *context = flat->context;
    const int64_t sides = 3 * flat->triangles;
    flat->corners = qni_alloc(context, sides, sizeof *flat->corners);
    flat->twins = qni_alloc(context, sides, sizeof *flat->twins);
    flat->creased = qni_alloc(context, sides, 1);
    flat->starts = qni_alloc(context, flat->vertices, sizeof *flat->starts);
    flat->regions = qni_alloc(context, flat->triangles, sizeof *flat->regions);
    flat->changed = qni_alloc_zero(context, flat->triangles, 1);
    return flat->corners && flat->twins && flat->creased && flat->starts && flat->regions &&
           flat->changed;
}

/* Who neighbours whom. */
static void release_links(qni_flat *flat) {
    qn_context *context = flat->context;
    const int64_t sides = 3 * flat->triangles;
    qni_free(context, flat->twins, sides, sizeof *flat->twins);
    qni_free(context, flat->creased, sides, 1);
    qni_free(context, flat->starts, flat->vertices, sizeof *flat->starts);
    flat->twins = flat->starts = NULL;
    flat->creased = NULL;
}

static void release(qni_flat *flat) {
    qn_context *context = flat->context;
    release_links(flat);
    qni_free(context, flat->corners, 3 * flat->triangles, sizeof *flat->corners);
    qni_free(context, flat->regions, flat->triangles, sizeof *flat->regions);
    qni_free(context, flat->changed, flat->triangles, 1);
    qni_free(context, flat->planes, flat->plane_room, sizeof *flat->planes);
}

static qn_status start(qni_flat *flat, const barred_regions *barred, qn_error *error) {
    if (!allocate(flat))
        return qni_fail_memory(error, "the flat parts");
    if (flat->triangles)
        memcpy(flat->corners, flat->mesh->triangles,
               3 * (size_t)flat->triangles * sizeof(uint32_t));
    if (!qni_flat_link(flat))
        return qni_fail_memory(error, "the flat parts");
    qni_flat_mark_creases(flat);
    QN_TRY(qni_flat_find_regions(flat, error));
    for (int64_t n = 0; barred->marks && n < flat->plane_count; ++n)
        flat->planes[n].barred = barred->marks[n];
    return QN_OK;
}

/* ---- the mesh that is left ------------------------------------------------------------------- */

static int64_t count_creases(const qni_flat *flat) {
    int64_t count = 0;
    for (uint32_t h = 0; h < 3 * flat->triangles; ++h)
        count += flat->corners[h - h % 3] != QN_NO_HALFEDGE && flat->creased[h] &&
                 (flat->twins[h] == QN_NO_HALFEDGE || h < flat->twins[h]);
    return count;
}

static void fill(const qni_flat *flat, const uint32_t *numbers, qn_mesh *out) {
    int64_t triangle = 0, crease = 0;
    for (int64_t v = 0; v < flat->vertices; ++v)
        if (flat->starts[v] != QN_NO_HALFEDGE)
            memcpy(out->positions + 3 * (size_t)numbers[v], qni_flat_place(flat, (uint32_t)v),
                   3 * sizeof(float));
    for (uint32_t t = 0; t < flat->triangles; ++t) {
        if (flat->corners[3 * (size_t)t] == QN_NO_HALFEDGE)
            continue;
        out->triangle_owners[triangle] = flat->regions[t] == QNI_NO_REGION
                                             ? flat->mesh->triangle_owners[t]
                                             : flat->planes[flat->regions[t]].owner;
        for (uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
            out->triangles[3 * triangle + h % 3] = numbers[flat->corners[h]];
            if (!flat->creased[h] || (flat->twins[h] != QN_NO_HALFEDGE && flat->twins[h] < h))
                continue;
            out->crease_edges[2 * crease] = numbers[flat->corners[h]];
            out->crease_edges[2 * crease++ + 1] = numbers[flat->corners[qni_flat_next(h)]];
        }
        ++triangle;
    }
}

static qn_status pack(const qni_flat *flat, const uint32_t *numbers, int64_t vertices,
                      qn_mesh **out, qn_error *error) {
    int64_t triangles = 0;
    const int64_t creases = count_creases(flat);
    for (int64_t t = 0; t < flat->triangles; ++t)
        triangles += flat->corners[3 * t] != QN_NO_HALFEDGE;
    QN_TRY(qni_mesh_alloc(flat->context, vertices, 0, triangles, false, out, error));
    qn_mesh *mesh = *out;
    mesh->triangle_owners = qni_alloc(flat->context, triangles, sizeof *mesh->triangle_owners);
    if (creases)
        mesh->crease_edges = qni_alloc(flat->context, creases, 2 * sizeof *mesh->crease_edges);
    mesh->crease_edge_count = mesh->crease_edges ? creases : 0;
    if (!mesh->triangle_owners || (creases && !mesh->crease_edges)) {
        qn_mesh_destroy(mesh);
        *out = NULL;
        return qni_fail_memory(error, "a mesh");
    }
    fill(flat, numbers, mesh);
    memcpy(mesh->space, flat->mesh->space, sizeof mesh->space);
    memcpy(mesh->unit, flat->mesh->unit, sizeof mesh->unit);
    return QN_OK;
}

/* ---- held against the whole ------------------------------------------------------------------ */

/* Regions of what is new and has all corners marked, as triangles that meet have. */
static bool bar(const qni_flat *flat, const uint32_t *numbers, const uint8_t *marks,
                barred_regions *barred) {
    if (!barred->marks) {
        barred->count = flat->plane_count;
        barred->marks = qni_alloc_zero(flat->context, barred->count, 1);
    }
    if (!barred->marks)
        return false;
    int64_t more = 0;
    for (int all = 0; all < 2 && more == 0; ++all)
        for (uint32_t t = 0; t < flat->triangles; ++t) {
            const uint32_t *c = flat->corners + 3 * (size_t)t;
            if (c[0] == QN_NO_HALFEDGE || !flat->changed[t] || barred->marks[flat->regions[t]] ||
                !(all || (marks[numbers[c[0]]] && marks[numbers[c[1]]] && marks[numbers[c[2]]])))
                continue;
            barred->marks[flat->regions[t]] = 1;
            ++more;
        }
    barred->number += more;
    return true;
}

static qn_status find_meetings(const qni_flat *flat, const uint32_t *numbers, const qn_mesh *mesh,
                               uint8_t *marks, int64_t *count, qn_error *error) {
    uint8_t *wanted = qni_alloc_zero(flat->context, mesh->vertex_count, 1);
    uint32_t *near = NULL;
    int64_t near_count = 0;
    qn_status status = wanted && qni_flat_near_changed(flat, numbers, &near, &near_count)
                           ? QN_OK
                           : qni_fail_memory(error, "the flat parts");
    for (uint32_t h = 0; status == QN_OK && h < 3 * flat->triangles; ++h)
        if (flat->changed[h / 3] && flat->corners[h - h % 3] != QN_NO_HALFEDGE)
            wanted[numbers[flat->corners[h]]] = QNI_WANTED_WITH_ALL;
    if (status == QN_OK) {
        qn_mesh_view view = qn_mesh_get_view(mesh);
        view.triangles = near;
        view.triangle_count = near_count;
        status = qni_mesh_crossings(flat->context, &view, "merge", wanted, marks, count, error);
    }
    qni_free(flat->context, near, near_count, 3 * sizeof *near);
    qni_free(flat->context, wanted, mesh->vertex_count, 1);
    return status;
}

/* *out stays NULL when regions were barred. */
static qn_status finish(qni_flat *flat, uint32_t *numbers, barred_regions *barred, qn_mesh **out,
                        qn_error *error) {
    int64_t vertices = 0, meetings = 0;
    for (int64_t v = 0; v < flat->vertices; ++v)
        numbers[v] = flat->starts[v] == QN_NO_HALFEDGE ? 0 : (uint32_t)vertices++;
    QN_TRY(pack(flat, numbers, vertices, out, error));
    release_links(flat);
    uint8_t *marks = qni_alloc(flat->context, vertices, 1);
    qn_status status = marks ? find_meetings(flat, numbers, *out, marks, &meetings, error)
                             : qni_fail_memory(error, "the flat parts");
    if (status == QN_OK && meetings > 0 && !bar(flat, numbers, marks, barred))
        status = qni_fail_memory(error, "the flat parts");
    qni_free(flat->context, marks, vertices, 1);
    if (status != QN_OK || meetings > 0) {
        qn_mesh_destroy(*out);
        *out = NULL;
    }
    return status;
}

/* *out stays NULL where nothing is to be dropped, too; then *dropped is 0. */
static qn_status attempt(qn_context *context, const qn_mesh *mesh, double near,
                         barred_regions *barred, qn_mesh **out, int64_t *dropped, qn_error *error) {
    qni_flat flat = {.context = context,
                     .mesh = mesh,
                     .near = near,
                     .vertices = mesh->vertex_count,
                     .triangles = mesh->triangle_count};
    uint32_t *numbers = NULL;
    qn_status status = start(&flat, barred, error);
    if (status == QN_OK) {
        qni_flat_drop(&flat);
        *dropped = flat.dropped;
        status = flat.dropped ? qni_flat_flip(&flat, error) : QN_OK;
    }
    if (status == QN_OK && flat.dropped) {
        numbers = qni_alloc(context, flat.vertices, sizeof *numbers);
        status = numbers ? finish(&flat, numbers, barred, out, error)
                         : qni_fail_memory(error, "the flat parts");
    }
    qni_free(context, numbers, flat.vertices, sizeof *numbers);
    release(&flat);
    return status;
}

qn_status qni_mesh_merge_flat(qn_context *context, qn_mesh **mesh, double near,
                              qni_flat_report *report_out, qn_error *error) {
    barred_regions barred = {0};
    qn_mesh *out = NULL;
    int64_t dropped = 1;
    qn_status status = QN_OK;
    for (int n = 0; n < MOST_ATTEMPTS && status == QN_OK && !out && dropped; ++n)
        status = attempt(context, *mesh, near, &barred, &out, &dropped, error);
    report_out->kept_regions = barred.number;
    report_out->dropped_vertices = out ? dropped : 0;
    qni_free(context, barred.marks, barred.count, 1);
    if (!out)
        return status;
    qn_mesh_destroy(*mesh);
    *mesh = out;
    return QN_OK;
}
