// SPDX-License-Identifier: MIT
/* The modules of .csg files that have children: groups, booleans, matrices, projections; and the
 * reader itself. */
#include <string.h>

#include "solid/csg_build.h"
#include "solid/read.h"

static bool is_any(const qni_csg_call *call, const char *const *names) {
    for (; *names; ++names)
        if (qni_csg_is(call, *names))
            return true;
    return false;
}

/* The root of a file has no name. */
static bool is_group(const qni_csg_call *call) {
    static const char *const names[] = {"group", "union", "color", "render", NULL};
    return call->name.length == 0 || is_any(call, names);
}

int qni_csg_dimension(const qni_csg_call *call) {
    static const char *const solids[] = {"cube",       "sphere",         "cylinder",
                                         "polyhedron", "linear_extrude", "rotate_extrude",
                                         "surface",    "import",         NULL};
    static const char *const flats[] = {"square", "circle", "polygon", "text", "projection", NULL};
    if (is_any(call, solids))
        return 3;
    if (is_any(call, flats))
        return 2;
    for (const qni_csg_call *child = call->children; child; child = child->next) {
        int dimension = qni_csg_dimension(child);
        if (dimension)
            return dimension;
    }
    return 0;
}

/* The children of this dimension, built; `parts` has room for all children. In place of others
 * stands an empty solid, as OpenSCAD has it: nothing to add or to take away, but an intersection
 * with nothing is nothing. */
static qn_status build_children(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                                qn_solid **parts, int64_t *count_out) {
    for (const qni_csg_call *child = call->children; child; child = child->next) {
        int own = qni_csg_dimension(child);
        if (own && own != dimension) {
            qni_log(build->context, QN_LOG_WARNING,
                    "'%s', line %lld: a %s shape among %s ones is left out", build->text->name,
                    (long long)child->line, own == 2 ? "flat" : "solid",
                    own == 2 ? "solid" : "flat");
            QN_TRY(qni_csg_give(build, qni_empty_create(build->context), &parts[*count_out]));
        } else {
            QN_TRY(qni_csg_build(build, child, &parts[*count_out]));
        }
        ++*count_out;
    }
    return QN_OK;
}

typedef enum join { UNION, INTERSECTION, DIFFERENCE } join;

static qn_solid *join_parts(qni_csg_builder *build, join how, qn_solid **parts, int64_t count,
                            bool *minus) {
    int64_t used = 0;
    for (int64_t n = 0; n < count; ++n) {
        bool empty = qni_box_is_nothing(&parts[n]->box);
        if (empty && (how == INTERSECTION || (how == DIFFERENCE && n == 0)))
            return qni_empty_create(build->context);
        if (empty)
            continue;
        qn_solid *swap = parts[used]; /* empty ones go behind: all are given back later */
        parts[used] = parts[n];
        parts[n] = swap;
        minus[used] = how == DIFFERENCE && used > 0;
        ++used;
    }
    return qni_combine_create(build->context, how != UNION, used, parts, minus);
}

static qn_status joined(qni_csg_builder *build, const qni_csg_call *call, int dimension, join how,
                        qn_solid **solid_out) {
    int64_t room = call->child_count, count = 0;
    qn_solid **parts = qni_alloc_zero(build->context, room, sizeof *parts);
    bool *minus = qni_alloc_zero(build->context, room, sizeof *minus);
    qn_status status = parts && minus ? build_children(build, call, dimension, parts, &count)
                                      : qni_fail_memory(build->error, "a solid");
    if (status == QN_OK)
        status = qni_csg_give(build, join_parts(build, how, parts, count, minus), solid_out);
    for (int64_t n = 0; parts && n < room; ++n)
        qn_solid_destroy(parts[n]);
    qni_free(build->context, parts, room, sizeof *parts);
    qni_free(build->context, minus, room, sizeof *minus);
    return status;
}

qn_status qni_csg_children(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                           qn_solid **solid_out) {
    return joined(build, call, dimension, UNION, solid_out);
}

static qn_status multmatrix(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                            qn_solid **solid_out) {
    double matrix[3][4], inverse[3][4];
    qn_solid *part;
    QN_TRY(qni_csg_matrix(build, call, dimension, matrix));
    QN_TRY(qni_csg_children(build, call, dimension, &part));
    if (qni_box_is_nothing(&part->box)) {
        *solid_out = part;
        return QN_OK;
    }
    qn_status status;
    if (qni_invert((const double(*)[4])matrix, inverse)) {
        status =
            qni_csg_give(build,
                         qni_transform_create(build->context, part, (const double(*)[4])inverse,
                                              (const double(*)[4])matrix, NULL),
                         solid_out);
    } else {
        qni_log(build->context, QN_LOG_WARNING,
                "'%s', line %lld: a matrix that flattens its shape leaves nothing",
                build->text->name, (long long)call->line);
        status = qni_csg_give(build, qni_empty_create(build->context), solid_out);
    }
    qn_solid_destroy(part);
    return status;
}

/* The cut by the plane z = 0: the solid seen from points that are first moved there. Without a cut:
 * the shadow. */
static qn_status projection(qni_csg_builder *build, const qni_csg_call *call,
                            qn_solid **solid_out) {
    static const double flatten[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}};
    bool cut;
    QN_TRY(qni_csg_flag(build, call, "cut", &cut));
    qn_solid *part;
    QN_TRY(qni_csg_children(build, call, 3, &part));
    if (qni_box_is_nothing(&part->box)) {
        *solid_out = part;
        return QN_OK;
    }
    if (!cut) {
        const qn_status status =
            qni_csg_give(build, qni_shadow_create(build->context, part), solid_out);
        qn_solid_destroy(part);
        return status;
    }
    qni_box box = part->box;
    box.low[2] = -QNI_INFINITY;
    box.high[2] = QNI_INFINITY;
    qn_status status = qni_csg_give(
        build, qni_transform_create(build->context, part, flatten, NULL, &box), solid_out);
    qn_solid_destroy(part);
    return status;
}

/* What is known but not supported, and what is not known. */
static qn_status refuse(qni_csg_builder *build, const qni_csg_call *call) {
    return qni_csg_fail(
        build, call, QN_ERROR_UNSUPPORTED,
        "this module is not supported; supported are cube, sphere, cylinder, polyhedron, square, "
        "circle, polygon, group, union, difference, intersection, multmatrix, color, render, hull, "
        "import, minkowski of convex parts, linear_extrude, rotate_extrude, projection");
}

qn_status qni_csg_build(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out) {
    bool known;
    *solid_out = NULL;
    QN_TRY(qni_csg_primitive(build, call, &known, solid_out));
    if (known)
        return QN_OK;
    int dimension = qni_csg_dimension(call);
    if (is_group(call))
        return joined(build, call, dimension, UNION, solid_out);
    if (qni_csg_is(call, "difference"))
        return joined(build, call, dimension, DIFFERENCE, solid_out);
    if (qni_csg_is(call, "intersection"))
        return joined(build, call, dimension, INTERSECTION, solid_out);
    if (qni_csg_is(call, "multmatrix"))
        return multmatrix(build, call, dimension, solid_out);
    if (qni_csg_is(call, "linear_extrude"))
        return qni_csg_linear_extrude(build, call, solid_out);
    if (qni_csg_is(call, "rotate_extrude"))
        return qni_csg_rotate_extrude(build, call, solid_out);
    if (qni_csg_is(call, "projection"))
        return projection(build, call, solid_out);
    if (qni_csg_is(call, "hull"))
        return qni_csg_hull(build, call, solid_out);
    if (qni_csg_is(call, "minkowski"))
        return qni_csg_minkowski(build, call, solid_out);
    if (qni_csg_is(call, "import"))
        return qni_csg_import(build, call, solid_out);
    return refuse(build, call);
}

qn_status qni_read_csg(qn_context *context, const qni_text *text, bool smooth, qn_solid **solid_out,
                       qn_error *error) {
    qni_csg_memory memory = {context, NULL};
    qni_csg_call *root;
    *solid_out = NULL;
    qn_status status = qni_csg_parse(text, &memory, &root, error);
    qni_csg_builder build = {context, text, error, smooth, 0};
    if (status == QN_OK && qni_csg_dimension(root) == 2)
        status =
            qni_fail(error, QN_ERROR_INPUT,
                     "'%s' describes a flat shape: give it a height by linear_extrude", text->name);
    if (status == QN_OK)
        status = qni_csg_build(&build, root, solid_out);
    qni_csg_memory_free(&memory);
    return status;
}
