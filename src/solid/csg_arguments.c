// SPDX-License-Identifier: MIT
/* Arguments of .csg calls, checked, and messages that say where a call is. */
#include <stdarg.h>
#include <stdio.h>

#include "solid/csg_build.h"
#include "solid/facets.h"

qn_status qni_csg_fail(const qni_csg_builder *build, const qni_csg_call *call, qn_status status,
                       const char *format, ...) {
    char what[320];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return qni_fail(build->error, status, "'%s', line %lld, column %lld, %s: %s", build->text->name,
                    (long long)call->line, (long long)call->column,
                    qni_word_of(call->name.at, call->name.length).text, what);
}

qn_status qni_csg_give(const qni_csg_builder *build, qn_solid *solid, qn_solid **solid_out) {
    *solid_out = solid;
    return solid ? QN_OK : qni_fail_memory(build->error, "a solid");
}

static bool usable(const qni_csg_value *value) {
    return value->kind == QNI_CSG_NUMBER && isfinite(value->number);
}

qn_status qni_csg_number(qni_csg_builder *build, const qni_csg_call *call, const char *name,
                         double otherwise, double *value_out) {
    const qni_csg_value *value = qni_csg_find(call, name);
    *value_out = value ? value->number : otherwise;
    if (!value && otherwise != otherwise)
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "%s is missing", name);
    if (value && !usable(value))
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "%s must be a finite number", name);
    return QN_OK;
}

qn_status qni_csg_flag(qni_csg_builder *build, const qni_csg_call *call, const char *name,
                       bool *value_out) {
    const qni_csg_value *value = qni_csg_find(call, name);
    *value_out = value && value->number != 0;
    if (value && value->kind != QNI_CSG_BOOL)
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "%s must be true or false", name);
    return QN_OK;
}

qn_status qni_csg_numbers(qni_csg_builder *build, const qni_csg_call *call, const char *name,
                          int count, double *values_out) {
    const qni_csg_value *value = qni_csg_find(call, name);
    if (value && usable(value)) {
        for (int k = 0; k < count; ++k)
            values_out[k] = value->number;
        return QN_OK;
    }
    if (!value || value->kind != QNI_CSG_VECTOR || value->count != count)
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "%s must be a vector of %d numbers", name,
                            count);
    const qni_csg_value *item = value->items;
    for (int k = 0; k < count; ++k, item = item->next) {
        if (!usable(item))
            return qni_csg_fail(build, call, QN_ERROR_INPUT,
                                "%s must be a vector of %d finite numbers", name, count);
        values_out[k] = item->number;
    }
    return QN_OK;
}

/* Fragments as OpenSCAD counts them: $fn, else what $fa and $fs allow, at least 5. */
qn_status qni_csg_fragments(qni_csg_builder *build, const qni_csg_call *call, double radius,
                            int32_t *count_out) {
    double number, angle, size;
    QN_TRY(qni_csg_number(build, call, "$fn", 0, &number));
    QN_TRY(qni_csg_number(build, call, "$fa", 12, &angle));
    QN_TRY(qni_csg_number(build, call, "$fs", 2, &size));
    const double finest_grid = 0x1p-20;
    double count = 3;
    if (radius < finest_grid)
        count = 3;
    else if (number > 0)
        count = number >= 3 ? floor(number) : 3;
    else
        count = ceil(fmax(
            fmin(360 / fmax(angle, 0.01), radius * 2 * 3.14159265358979323846 / fmax(size, 0.01)),
            5));
    int32_t most = qni_csg_is(call, "sphere") ? QNI_SPHERE_FRAGMENTS : QNI_CIRCLE_FRAGMENTS;
    if (count > most)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "%g facets round a circle; up to %d are supported", count, most);
    *count_out = (int32_t)count;
    return QN_OK;
}

/* One positional argument, or m: four rows (or three) of four numbers. */
qn_status qni_csg_matrix(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                         double matrix[3][4]) {
    const qni_csg_value *value = qni_csg_find(call, "m");
    if (!value && call->arguments)
        value = &call->arguments->value;
    bool good = value && value->kind == QNI_CSG_VECTOR && (value->count == 4 || value->count == 3);
    const qni_csg_value *row = good ? value->items : NULL;
    for (int i = 0; good && i < value->count; ++i, row = row->next) {
        good = row->kind == QNI_CSG_VECTOR && row->count == 4;
        const qni_csg_value *item = good ? row->items : NULL;
        for (int j = 0; good && j < 4; ++j, item = item->next) {
            good = usable(item) && (i < 3 || item->number == (j == 3));
            if (good && i < 3)
                matrix[i][j] = item->number;
        }
    }
    if (!good)
        return qni_csg_fail(
            build, call, QN_ERROR_INPUT,
            "expected a matrix of four rows of four finite numbers, the last row 0, 0, 0, 1");
    for (int k = 0; dimension == 2 && k < 4; ++k)
        matrix[2][k] = k == 2;
    for (int k = 0; dimension == 2 && k < 2; ++k)
        matrix[k][2] = 0;
    return QN_OK;
}
