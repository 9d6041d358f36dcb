// SPDX-License-Identifier: MIT
/* The solid as it is near one cell: restricted to the block round the cell, and from there to the
 * cell itself, but not before somebody asks. Most cells ask little or nothing. */
#include "cms/cms.h"

#include <string.h>

/* So many questions pay for what restricting costs. */
enum { QUESTIONS_WORTH_IT = 3 };

/* The solid restricted to a cell and `margin` of its width around; NULL when there is none to be
 * had. */
static qn_solid *restrict_to_cell(const qni_hermite *hermite, const qn_solid *solid,
                                  const qni_cell *cell, double margin) {
    const double size = hermite->lattice.cell * (1 << cell->level);
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        box.low[k] = qni_lattice_at(&hermite->lattice, k, cell->low[k]) - margin * size;
        box.high[k] = box.low[k] + (1 + 2 * margin) * size;
    }
    qn_solid *restricted = NULL;
    return solid->ops->restrict_to(solid, &box, &restricted) == QN_OK ? restricted : NULL;
}

/* The block, or larger cell, round a cell. */
static qni_cell around_of(const qni_cell *cell) {
    qni_cell around = *cell;
    around.level = cell->level > 3 ? cell->level : 3;
    for (int k = 0; k < 3; ++k)
        around.low[k] = around.low[k] >> around.level << around.level;
    return around;
}

/* What to ask. The block's solid is kept for the next cell of it. */
static const qn_solid *part_of(const qn_solid *solid) {
    qni_nearby *nearby = (qni_nearby *)(uintptr_t)solid; /* one thread's own */
    if (nearby->near)
        return nearby->near;
    const qni_hermite *hermite = nearby->hermite;
    const qni_cell around = around_of(&nearby->cell);
    if (!nearby->block || memcmp(&around, &nearby->block_cell, sizeof around) != 0) {
        qn_solid_destroy(nearby->block);
        nearby->block_cell = around;
        nearby->block = restrict_to_cell(hermite, hermite->solid, &around, 0.5);
    }
    const qn_solid *block = nearby->block ? nearby->block : hermite->solid;
    if (nearby->cell.level < 3 && ++nearby->questions == QUESTIONS_WORTH_IT)
        nearby->near = restrict_to_cell(hermite, block, &nearby->cell, 1);
    return nearby->near ? nearby->near : block;
}

static qn_status nearby_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                               double *values) {
    const qn_solid *part = part_of(solid);
    return part->ops->values(part, count, points, values);
}

static qn_status nearby_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double (*gradients)[3], int32_t *owners) {
    const qn_solid *part = part_of(solid);
    return part->ops->gradients(part, count, points, gradients, owners);
}

static qn_status nearby_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const qn_solid *part = part_of(solid);
    return part->ops->bounds(part, box, range);
}

static qn_status nearby_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                  int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const qn_solid *part = part_of(solid);
    return part->ops->crossings(part, a, b, capacity, crossings, count_out);
}

static qn_status nearby_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const qn_solid *part = part_of(solid);
    return part->ops->restrict_to(part, box, solid_out);
}

/* Lives in a patch, and is never destroyed by reference. */
static const qni_solid_ops nearby_ops = {
    .values = nearby_values,
    .gradients = nearby_gradients,
    .bounds = nearby_bounds,
    .crossings = nearby_crossings,
    .restrict_to = nearby_restrict,
};

void qni_nearby_start(qni_nearby *nearby, const qni_hermite *hermite) {
    memset(nearby, 0, sizeof *nearby);
    nearby->base = *hermite->solid;
    nearby->base.ops = &nearby_ops;
    nearby->hermite = hermite;
}

void qni_nearby_set_cell(qni_nearby *nearby, const qni_cell *cell) {
    qn_solid_destroy(nearby->near);
    nearby->near = NULL;
    nearby->cell = *cell;
    nearby->questions = 0;
}

void qni_nearby_end(qni_nearby *nearby) {
    qn_solid_destroy(nearby->near);
    qn_solid_destroy(nearby->block);
    nearby->near = nearby->block = NULL;
}
