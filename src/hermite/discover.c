// SPDX-License-Identifier: MIT
/* Where the surface can be: from root cells down to blocks, pruned by the solid's bounds; each root
 * on its own thread.
 *
 * Where the solid has no bounds, cells are kept down to 1/16 of the lattice and below that when
 * samples in them differ in sign; what that misses beside what it finds is found by following
 * crossings (hermite.c). */
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "hermite/hermite.h"
#include "solid/sampled.h"

#include <math.h>

enum { BLIND_CELLS = 16, ROUND = 64 };

typedef struct place_list {
    int32_t (*items)[3];
    int64_t count, capacity;
} place_list;

static bool push_place(qn_context *context, place_list *list, const int32_t place[3]) {
    if (list->count == list->capacity) {
        const int64_t capacity = list->capacity ? 2 * list->capacity : 64;
        int32_t(*items)[3] =
            qni_realloc(context, list->items, list->capacity, capacity, sizeof *items);
        if (!items)
            return false;
        list->items = items;
        list->capacity = capacity;
    }
    for (int k = 0; k < 3; ++k)
        list->items[list->count][k] = place[k] / QNI_BLOCK;
    ++list->count;
    return true;
}

/* The cell's closed box; none when the bounds lie beyond it. */
static bool box_of(const qni_lattice *lattice, const int32_t low[3], int32_t size, qni_box *box) {
    bool meets = true;
    for (int k = 0; k < 3; ++k) {
        box->low[k] = qni_lattice_at(lattice, k, low[k]);
        box->high[k] = qni_lattice_at(lattice, k, low[k] + size);
        meets = meets && box->low[k] <= lattice->bounds.high[k] &&
                box->high[k] >= lattice->bounds.low[k];
    }
    return meets;
}

static bool crosses_bounds(const qni_lattice *lattice, const qni_box *box) {
    for (int k = 0; k < 3; ++k)
        if (box->low[k] <= lattice->bounds.low[k] || box->high[k] >= lattice->bounds.high[k])
            return true;
    return false;
}

/* Do 5^3 samples of the box differ in sign? */
static qn_status samples_differ(const qn_solid *solid, const qni_box *box, bool *differ) {
    double points[125][3], values[125];
    for (int n = 0; n < 125; ++n) {
        const int at[3] = {n % 5, n / 5 % 5, n / 25};
        for (int k = 0; k < 3; ++k)
            points[n][k] = box->low[k] + (box->high[k] - box->low[k]) * at[k] / 4;
    }
    QN_TRY(solid->ops->values(solid, 125, (const double(*)[3])points, values));
    int inside = 0;
    for (int n = 0; n < 125; ++n)
        inside += values[n] < 0;
    *differ = inside != 0 && inside != 125;
    return QN_OK;
}

static qn_status may_hold_surface(const qni_hermite *hermite, const qn_solid *solid,
                                  const qni_box *box, int32_t size, bool *may) {
    const qni_lattice *lattice = &hermite->lattice;
    double range[2];
    bool changes;
    if (solid->ops->changes && solid->ops->changes(solid, box, &changes) &&
        (changes || !crosses_bounds(lattice, box))) {
        *may = changes;
        return QN_OK;
    }
    QN_TRY(solid->ops->bounds(solid, box, range));
    *may = false;
    if (range[0] > 0)
        return QN_OK;
    *may = true;
    if (crosses_bounds(lattice, box)) /* caps may stand there */
        return QN_OK;
    *may = !(range[1] < 0);
    const int32_t most =
        lattice->cells[0] > lattice->cells[1] ? lattice->cells[0] : lattice->cells[1];
    const int32_t longest = most > lattice->cells[2] ? most : lattice->cells[2];
    if (*may && isinf(range[0]) && isinf(range[1]) && size < QNI_BLOCK * BLIND_CELLS &&
        size * BLIND_CELLS <= longest)
        QN_TRY(samples_differ(solid, box, may));
    return QN_OK;
}

static qn_status descend(qni_hermite *hermite, const qn_solid *solid, const int32_t low[3],
                         int32_t size, place_list *list) {
    qni_box box;
    bool may;
    if (!box_of(&hermite->lattice, low, size, &box))
        return QN_OK;
    QN_TRY(may_hold_surface(hermite, solid, &box, size, &may));
    if (!may)
        return QN_OK;
    if (size == QNI_BLOCK)
        return push_place(hermite->context, list, low) ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
    qn_solid *inner = solid->direct ? qni_solid_retain(solid) : NULL;
    if (!inner)
        QN_TRY(solid->ops->restrict_to(solid, &box, &inner));
    qn_status status = QN_OK;
    for (int child = 0; child < 8 && status == QN_OK; ++child) {
        int32_t corner[3];
        for (int k = 0; k < 3; ++k)
            corner[k] = low[k] + (child >> k & 1 ? size / 2 : 0);
        status = descend(hermite, inner, corner, size / 2, list);
    }
    qn_solid_destroy(inner);
    return status;
}

static qn_status enter_lists(qni_hermite *hermite, place_list *lists, int64_t count, int worst,
                             qn_error *error) {
    bool room = true;
    for (int64_t i = 0; i < count; ++i) {
        for (int64_t n = 0; n < lists[i].count && worst == QN_OK && room; ++n)
            room = qni_hermite_enter(hermite, lists[i].items[n]);
        qni_free(hermite->context, lists[i].items, lists[i].capacity, sizeof *lists[i].items);
    }
    if (worst == QN_ERROR_OUT_OF_MEMORY || !room)
        return qni_fail_memory(error, "Hermite data");
    if (worst != QN_OK)
        return qni_fail(error, (qn_status)worst, "a callback of the solid asked to stop");
    return QN_OK;
}

/* Blocks are the volume's leaves, which are known. */
static qn_status enter_leaves(qni_hermite *hermite, qn_error *error) {
    int64_t count;
    const int32_t(*leaves)[3] = qni_sampled_mixed_leaves(hermite->solid, &count);
    for (int64_t n = 0; n < count; ++n) {
        int32_t place[3];
        for (int k = 0; k < 3; ++k)
            place[k] = leaves[n][k] + hermite->lattice.shift[k] / QNI_BLOCK;
        if (!qni_hermite_enter(hermite, place))
            return qni_fail_memory(error, "Hermite data");
    }
    return QN_OK;
}

qn_status qni_discover(qni_hermite *hermite, qn_error *error) {
    const qni_lattice *lattice = &hermite->lattice;
    if (lattice->samples)
        return enter_leaves(hermite, error);
    const int32_t size = lattice->top > 3 ? 1 << lattice->top : QNI_BLOCK;
    const int64_t nx = lattice->cells[0] / size, ny = lattice->cells[1] / size,
                  nz = lattice->cells[2] / size;
    const int32_t threads = qn_context_threads(hermite->context);
    for (int64_t first = 0; first < nx * ny * nz; first += ROUND) {
        place_list lists[ROUND] = {{NULL, 0, 0}};
        const int64_t count = nx * ny * nz - first < ROUND ? nx * ny * nz - first : ROUND;
        int worst = QN_OK;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) reduction(max : worst)
        for (int64_t i = 0; i < count; ++i) {
            const int64_t n = first + i;
            const int32_t low[3] = {(int32_t)(n % nx) * size, (int32_t)(n / nx % ny) * size,
                                    (int32_t)(n / nx / ny) * size};
            const int status = (int)descend(hermite, hermite->solid, low, size, &lists[i]);
            worst = status > worst ? status : worst;
        }
        QN_TRY(enter_lists(hermite, lists, count, worst, error));
        if (qni_progress(hermite->context, "sampling", 0))
            return qni_fail(error, QN_ERROR_CANCELLED, "sampling was cancelled");
    }
    return QN_OK;
}
