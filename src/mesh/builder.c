// SPDX-License-Identifier: MIT
/* Building a mesh whose size shows only while it is read. */
#include "mesh/builder.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/mesh.h"
#include "mesh/polygon.h"

#include <string.h>

enum { VECTOR = 3 * sizeof(float), QUAD = 4 * sizeof(uint32_t), TRIANGLE = 3 * sizeof(uint32_t) };

static void array_free(qn_context *context, qni_array *array, size_t size) {
    qni_free(context, array->items, array->capacity, size);
    *array = (qni_array){0};
}

static bool array_resize(qn_context *context, qni_array *array, int64_t capacity, size_t size) {
    if (capacity == array->capacity)
        return true;
    void *items = qni_realloc(context, array->items, array->capacity, capacity, size);
    if (!items)
        return false;
    array->items = items;
    array->capacity = capacity;
    return true;
}

/* Room for `more` items behind the last; NULL when there is no memory. */
static void *array_extend(qn_context *context, qni_array *array, int64_t more, size_t size) {
    if (more > array->capacity - array->count) {
        int64_t capacity = array->capacity + array->capacity / 2 + 64;
        if (capacity - array->count < more)
            capacity = array->count + more;
        if (!array_resize(context, array, capacity, size))
            return NULL;
    }
    void *room = (char *)array->items + (size_t)array->count * size;
    array->count += more;
    return room;
}

void qni_builder_start(qni_builder *builder, qn_context *context) {
    *builder = (qni_builder){.context = context};
}

void qni_builder_free(qni_builder *builder) {
    qn_context *context = builder->context;
    array_free(context, &builder->positions, VECTOR);
    array_free(context, &builder->normals, VECTOR);
    array_free(context, &builder->quads, QUAD);
    array_free(context, &builder->triangles, TRIANGLE);
    array_free(context, &builder->polygons, sizeof(uint32_t));
    array_free(context, &builder->triangle_owners, sizeof(int32_t));
    array_free(context, &builder->quad_owners, sizeof(int32_t));
    array_free(context, &builder->polygon_owners, sizeof(int32_t));
}

bool qni_builder_reserve(qni_builder *builder, int64_t vertices, bool with_normals) {
    return array_resize(builder->context, &builder->positions, vertices, VECTOR) &&
           (!with_normals || array_resize(builder->context, &builder->normals, vertices, VECTOR));
}

bool qni_builder_add_vertex(qni_builder *builder, const float position[3], const float *normal) {
    float *room = array_extend(builder->context, &builder->positions, 1, VECTOR);
    if (!room)
        return false;
    memcpy(room, position, VECTOR);
    if (!normal)
        return true;
    room = array_extend(builder->context, &builder->normals, 1, VECTOR);
    if (room)
        memcpy(room, normal, VECTOR);
    return room != NULL;
}

static void note_indices(qni_builder *builder, const uint32_t *corners, int64_t count,
                         int64_t where) {
    for (int64_t i = 0; i < count; ++i)
        if (corners[i] > builder->largest_index || builder->largest_where == 0) {
            builder->largest_index = corners[i];
            builder->largest_where = where;
        }
}

/* Owners up to face number `count`: 0 for those not noted yet. */
static bool fill_owners(qn_context *context, qni_array *owners, int64_t count) {
    int64_t more = count - owners->count;
    if (more <= 0)
        return true;
    int32_t *room = array_extend(context, owners, more, sizeof *room);
    if (room)
        memset(room, 0, (size_t)more * sizeof *room);
    return room != NULL;
}

/* Nothing is kept until the first owner that is not 0. */
static bool note_owner(qni_builder *builder, qni_array *owners, int64_t count) {
    if (builder->owner == 0)
        return true;
    if (!fill_owners(builder->context, owners, count))
        return false;
    ((int32_t *)owners->items)[count - 1] = builder->owner;
    return true;
}

bool qni_builder_add_face(qni_builder *builder, const uint32_t *corners, int64_t count,
                          int64_t where) {
    if (count < 3) {
        ++builder->skipped_faces;
        return true;
    }
    note_indices(builder, corners, count, where);
    uint32_t *room;
    if (count == 3) {
        room = array_extend(builder->context, &builder->triangles, 1, TRIANGLE);
    } else if (count == 4) {
        room = array_extend(builder->context, &builder->quads, 1, QUAD);
    } else {
        room = count > (int64_t)UINT32_MAX
                   ? NULL
                   : array_extend(builder->context, &builder->polygons, count + 1, sizeof *room);
        if (room)
            *room++ = (uint32_t)count;
    }
    if (!room)
        return false;
    memcpy(room, corners, (size_t)count * sizeof *room);
    if (count == 3)
        return note_owner(builder, &builder->triangle_owners, builder->triangles.count);
    if (count == 4)
        return note_owner(builder, &builder->quad_owners, builder->quads.count);
    return note_owner(builder, &builder->polygon_owners, ++builder->polygon_count);
}

/* Splitting waits until all vertices are known: a file may name them before it lists them. */
static bool split_polygons(qni_builder *builder) {
    const uint32_t *items = builder->polygons.items;
    int64_t largest = 0, triangles = 0;
    for (int64_t i = 0; i < builder->polygons.count; i += items[i] + INT64_C(1)) {
        largest = items[i] > largest ? items[i] : largest;
        triangles += items[i] - INT64_C(2);
    }
    if (largest == 0)
        return true;
    int64_t scratch_bytes = qni_polygon_scratch_bytes(largest);
    void *scratch = qni_alloc(builder->context, scratch_bytes, 1);
    int64_t from = builder->triangles.count, face = 0;
    bool owned = builder->polygon_owners.count > 0;
    bool good =
        !owned ||
        (fill_owners(builder->context, &builder->triangle_owners, from) &&
         fill_owners(builder->context, &builder->polygon_owners, builder->polygon_count) &&
         array_extend(builder->context, &builder->triangle_owners, triangles, sizeof(int32_t)));
    uint32_t *to = scratch && good
                       ? array_extend(builder->context, &builder->triangles, triangles, TRIANGLE)
                       : NULL;
    for (int64_t i = 0; to && i < builder->polygons.count; i += items[i] + INT64_C(1)) {
        qni_polygon_split(builder->positions.items, items + i + 1, items[i], scratch, to);
        to += 3 * (items[i] - INT64_C(2));
        int32_t *owners = builder->triangle_owners.items;
        for (int64_t n = 2; owned && n < (int64_t)items[i]; ++n)
            owners[from++] = ((const int32_t *)builder->polygon_owners.items)[face];
        ++face;
    }
    qni_free(builder->context, scratch, scratch_bytes, 1);
    return to != NULL;
}

/* Give an array to the mesh, at its exact size; empty ones become NULL. */
static bool hand_over(qn_context *context, qni_array *array, size_t size, void *items_out) {
    void *items = NULL;
    if (array->count == 0) {
        array_free(context, array, size);
    } else {
        if (!array_resize(context, array, array->count, size))
            return false;
        items = array->items;
        *array = (qni_array){0};
    }
    memcpy(items_out, &items, sizeof items);
    return true;
}

static qn_status check_indices(const qni_builder *builder, const char *path, const char *place,
                               qn_error *error) {
    if (builder->positions.count > (int64_t)UINT32_MAX)
        return qni_fail(
            error, QN_ERROR_INPUT,
            "cannot read '%.200s': it has more than 2^32 - 1 vertices; read it in parts", path);
    if (builder->largest_where && (int64_t)builder->largest_index >= builder->positions.count)
        return qni_fail(
            error, QN_ERROR_INPUT,
            "cannot read '%.200s': %s %lld names vertex %lld (from 0), but there are %lld "
            "vertices; the file is damaged",
            path, place, (long long)builder->largest_where, (long long)builder->largest_index,
            (long long)builder->positions.count);
    return QN_OK;
}

/* One for each face, or none at all. */
static bool settle_owners(qni_builder *builder) {
    qn_context *context = builder->context;
    array_free(context, &builder->polygon_owners, sizeof(int32_t));
    if (builder->triangle_owners.count == 0 && builder->quad_owners.count == 0)
        return true;
    return fill_owners(context, &builder->triangle_owners, builder->triangles.count) &&
           fill_owners(context, &builder->quad_owners, builder->quads.count);
}

static qn_status make_mesh(qni_builder *builder, const char *path, qn_mesh **mesh_out,
                           qn_error *error) {
    qn_context *context = builder->context;
    int64_t vertices = builder->positions.count;
    if (builder->normals.count != vertices)
        array_free(context, &builder->normals, VECTOR);
    if (!split_polygons(builder))
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "not enough memory for the polygons of '%.200s'", path);
    array_free(context, &builder->polygons, sizeof(uint32_t));
    if (!settle_owners(builder))
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "not enough memory for the owners of '%.200s'", path);
    int64_t quads = builder->quads.count, triangles = builder->triangles.count;
    QN_TRY(qni_mesh_alloc(context, 0, 0, 0, false, mesh_out, error));
    qn_mesh *mesh = *mesh_out;
    bool good = hand_over(context, &builder->positions, VECTOR, &mesh->positions);
    mesh->vertex_count = good ? vertices : 0;
    good = good && hand_over(context, &builder->normals, VECTOR, &mesh->normals);
    good = good && hand_over(context, &builder->quads, QUAD, &mesh->quads);
    mesh->quad_count = mesh->quads ? quads : 0;
    good = good && hand_over(context, &builder->triangles, TRIANGLE, &mesh->triangles);
    mesh->triangle_count = mesh->triangles ? triangles : 0;
    good = good &&
           hand_over(context, &builder->triangle_owners, sizeof(int32_t), &mesh->triangle_owners);
    good = good && hand_over(context, &builder->quad_owners, sizeof(int32_t), &mesh->quad_owners);
    mesh->quad_owner_count = mesh->quad_owners ? quads : 0;
    if (!good) {
        qn_mesh_destroy(mesh);
        *mesh_out = NULL;
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY, "not enough memory for the mesh of '%.200s'",
                        path);
    }
    memcpy(mesh->space, builder->space, sizeof mesh->space);
    memcpy(mesh->unit, builder->unit, sizeof mesh->unit);
    return QN_OK;
}

qn_status qni_builder_finish(qni_builder *builder, const char *path, const char *place,
                             qn_mesh **mesh_out, qn_error *error) {
    *mesh_out = NULL;
    if (builder->skipped_faces)
        qni_log(builder->context, QN_LOG_WARNING,
                "'%.200s': left out %lld faces of fewer than 3 corners", path,
                (long long)builder->skipped_faces);
    qn_status status = check_indices(builder, path, place, error);
    if (status == QN_OK)
        status = make_mesh(builder, path, mesh_out, error);
    qni_builder_free(builder);
    return status;
}
