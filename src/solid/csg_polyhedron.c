// SPDX-License-Identifier: MIT
/* OpenSCAD's polyhedron(points, faces). */
#include <stdio.h>

#include "solid/csg_build.h"
#include "solid/polyhedron.h"

/* The lists, as the maker of polyhedra wants them. */
typedef struct lists {
    double (*points)[3];
    int64_t *sizes, *indices;
    int64_t point_count, face_count, index_count;
} lists;

static void lists_free(qni_csg_builder *build, lists *all) {
    qni_free(build->context, all->points, all->point_count, sizeof *all->points);
    qni_free(build->context, all->sizes, all->face_count, sizeof *all->sizes);
    qni_free(build->context, all->indices, all->index_count, sizeof *all->indices);
}

static bool is_list(const qni_csg_value *value) {
    return value && value->kind == QNI_CSG_VECTOR;
}

static qn_status read_points(qni_csg_builder *build, const qni_csg_call *call, lists *all) {
    const qni_csg_value *list = qni_csg_find(call, "points");
    if (!is_list(list))
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "points must be a list of points");
    all->point_count = list->count;
    all->points = qni_alloc(build->context, list->count, sizeof *all->points);
    if (!all->points)
        return qni_fail_memory(build->error, "a polyhedron");
    int64_t n = 0;
    for (const qni_csg_value *point = list->items; point; point = point->next, ++n) {
        const qni_csg_value *item = is_list(point) && point->count == 3 ? point->items : NULL;
        for (int k = 0; k < 3; ++k, item = item->next) {
            if (!item || item->kind != QNI_CSG_NUMBER || !isfinite(item->number))
                return qni_csg_fail(build, call, QN_ERROR_INPUT,
                                    "point %lld is not three finite numbers", (long long)n);
            all->points[n][k] = item->number;
        }
    }
    return QN_OK;
}

static qn_status read_face(qni_csg_builder *build, const qni_csg_call *call,
                           const qni_csg_value *face, int64_t n, lists *all, int64_t *used) {
    all->sizes[n] = face->count;
    for (const qni_csg_value *item = face->items; item; item = item->next) {
        if (item->kind != QNI_CSG_NUMBER ||
            !(item->number >= 0 && item->number < (double)all->point_count))
            return qni_csg_fail(build, call, QN_ERROR_INPUT,
                                "face %lld names a point that is not one of the %lld", (long long)n,
                                (long long)all->point_count);
        all->indices[(*used)++] = (int64_t)item->number;
    }
    return QN_OK;
}

static qn_status read_faces(qni_csg_builder *build, const qni_csg_call *call, lists *all) {
    const qni_csg_value *list = qni_csg_find(call, "faces");
    if (!is_list(list))
        return qni_csg_fail(build, call, QN_ERROR_INPUT,
                            "faces must be a list of lists of point numbers");
    for (const qni_csg_value *face = list->items; face; face = face->next) {
        if (!is_list(face))
            return qni_csg_fail(build, call, QN_ERROR_INPUT,
                                "faces must be a list of lists of point numbers");
        all->index_count += face->count;
    }
    all->face_count = list->count;
    all->sizes = qni_alloc(build->context, all->face_count, sizeof *all->sizes);
    all->indices = qni_alloc(build->context, all->index_count, sizeof *all->indices);
    if (!all->sizes || !all->indices)
        return qni_fail_memory(build->error, "a polyhedron");
    int64_t n = 0, used = 0;
    for (const qni_csg_value *face = list->items; face; face = face->next, ++n)
        QN_TRY(read_face(build, call, face, n, all, &used));
    return QN_OK;
}

qn_status qni_csg_polyhedron(qni_csg_builder *build, const qni_csg_call *call,
                             qn_solid **solid_out) {
    lists all = {0};
    char where[200];
    snprintf(where, sizeof where, "'%.100s', line %lld, column %lld", build->text->name,
             (long long)call->line, (long long)call->column);
    qn_status status = read_points(build, call, &all);
    if (status == QN_OK)
        status = read_faces(build, call, &all);
    if (status == QN_OK)
        status = qni_polyhedron_from_faces(
            build->context, where, all.point_count, (const double(*)[3])all.points, all.face_count,
            all.sizes, all.indices, build->owner, solid_out, build->error);
    lists_free(build, &all);
    return status;
}

qn_status qni_csg_polyhedron_corners(qni_csg_builder *build, const qni_csg_call *call,
                                     qni_points *points) {
    lists all = {0};
    qn_status status = read_points(build, call, &all);
    for (int64_t n = 0; status == QN_OK && n < all.point_count; ++n)
        if (!qni_points_add(build->context, points, all.points[n]))
            status = qni_fail_memory(build->error, "a hull");
    lists_free(build, &all);
    return status;
}
