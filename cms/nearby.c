// SPDX-License-Identifier: MIT
/* The solid as it is near one cell: restricted to the block round the cell, and from there to the
 * cell itself, but not before somebody asks. Most cells ask little or nothing. */
#include "cms/cms.h"

#include <string.h>

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

static qni_cell cell_around(const qni_cell *cell, int32_t level) {
    qni_cell around = *cell;
    around.level = cell->level > level ? cell->level : level;
    for (int k = 0; k < 3; ++k)
        around.low[k] = around.low[k] >> around.level << around.level;
    return around;
}

static void forget_parts(qni_nearby *nearby) {
    for (int n = 0; n < QNI_NEARBY_PARTS; ++n) {
        qn_solid_destroy(nearby->parts[n]);
        nearby->parts[n] = NULL;
    }
}

/* Does the part of the block last asked hold a union, too? It reaches half a block beyond the
 * block, and boxes round one cell are tried in turn that lie in several. */
static bool serves(const qni_nearby *nearby) {
    const qni_cell *block = &nearby->block_cell;
    bool within = nearby->united && nearby->hermite->solid->listed && block->level == 3;
    for (int k = 0; k < 3; ++k) {
        const int32_t at = nearby->cell.low[k] - block->low[k];
        within = within && at >= -2 && at <= 9;
    }
    return within;
}

static qni_cell block_of(const qni_nearby *nearby) {
    return serves(nearby) ? nearby->block_cell : cell_around(&nearby->cell, 3);
}

/* Of the block, or larger cell, round the cell: it serves all cells in it. */
static const qn_solid *block_part(qni_nearby *nearby) {
    const qni_cell around = block_of(nearby);
    if (memcmp(&around, &nearby->block_cell, sizeof around) != 0) {
        forget_parts(nearby);
        nearby->block_cell = around;
    }
    const qn_solid *part = qni_region_cube(&nearby->region, around.low, around.level);
    return part ? part : nearby->hermite->solid;
}

/* Unions of cells stand for cells that are not aligned. */
static bool is_kept(const qni_nearby *nearby, const qni_cell *cell) {
    const int32_t low = (1 << cell->level) - 1;
    const qni_cell around = cell_around(cell, 3);
    return cell->level > 0 && !((cell->low[0] | cell->low[1] | cell->low[2]) & low) &&
           memcmp(&around, &nearby->block_cell, sizeof around) == 0;
}

/* Where the part of a cell of level 1 or 2 in the block is kept. */
static int place_of(const qni_cell *cell) {
    const int x = (cell->low[0] & 7) >> cell->level, y = (cell->low[1] & 7) >> cell->level,
              z = (cell->low[2] & 7) >> cell->level;
    return cell->level == 1 ? 16 * z + 4 * y + x : 64 + 4 * z + 2 * y + x;
}

/* Of a cell within the block, restricted step by step: each has few parts left to look at, and
 * serves the cells in it. */
static const qn_solid *cell_part(qni_nearby *nearby, const qni_cell *cell) {
    if (cell->level >= 3)
        return block_part(nearby);
    if (cell->level < 2 && nearby->hermite->solid->listed) {
        const qni_cell around = cell_around(cell, 2);
        return is_kept(nearby, &around) ? cell_part(nearby, &around) : block_part(nearby);
    }
    qn_solid **kept = is_kept(nearby, cell) ? &nearby->parts[place_of(cell)] : &nearby->near;
    if (!*kept) {
        const qni_cell around = cell_around(cell, cell->level + 1);
        const qn_solid *larger = cell_part(nearby, &around);
        *kept = restrict_to_cell(nearby->hermite, larger, cell, cell->level > 0 ? 0.5 : 1);
        if (!*kept)
            return larger;
    }
    return *kept;
}

/* What to ask. */
static const qn_solid *part_of(const qn_solid *solid) {
    qni_nearby *nearby = (qni_nearby *)(uintptr_t)solid; /* one thread's own */
    if (!nearby->asked) {
        if (nearby->cell.level < 3)
            block_part(nearby); /* forgets the parts of another block */
        nearby->asked = cell_part(nearby, &nearby->cell);
    }
    return nearby->asked;
}

static qn_status nearby_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                               double *values) {
    const qn_solid *part = part_of(solid);
    return part->ops->values(part, count, points, values);
}

static qn_status nearby_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                               bool *inside) {
    return qni_solid_inside(part_of(solid), count, points, inside);
}

static qn_status nearby_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double (*gradients)[3], int32_t *owners) {
    const qn_solid *part = part_of(solid);
    return part->ops->gradients(part, count, points, gradients, owners);
}

static qn_status nearby_first_order(const qn_solid *solid, const double p[3], double *value,
                                    double gradient[3], int32_t *owner) {
    return qni_solid_first_order(part_of(solid), p, value, gradient, owner);
}

static bool nearby_distance(const qn_solid *solid, const double p[3], double most,
                            double *distance_out) {
    const qn_solid *part = part_of(solid);
    return part->ops->distance && part->ops->distance(part, p, most, distance_out);
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
    .inside = nearby_inside,
    .first_order = nearby_first_order,
    .distance = nearby_distance,
};

void qni_nearby_start(qni_nearby *nearby, const qni_hermite *hermite) {
    memset(nearby, 0, sizeof *nearby);
    nearby->base = *hermite->solid;
    nearby->base.ops = &nearby_ops;
    nearby->hermite = hermite;
    qni_region_start(&nearby->region, hermite->solid, &hermite->lattice, true);
}

void qni_nearby_set_cell(qni_nearby *nearby, const qni_cell *cell, bool united) {
    qn_solid_destroy(nearby->near);
    nearby->near = NULL;
    nearby->cell = *cell;
    nearby->united = united;
    nearby->asked = NULL;
}

void qni_nearby_end(qni_nearby *nearby) {
    forget_parts(nearby);
    qni_region_end(&nearby->region);
    qn_solid_destroy(nearby->near);
    nearby->near = NULL;
}
