// SPDX-License-Identifier: MIT
/* Restricting step by step. Blocks are asked for row by row, and layer by layer: each cube is kept
 * until one is asked for that lies 16 cubes of its size on, or in another layer, so that the larger
 * ones serve all blocks in them. */
#include "hermite/region.h"

#include <string.h>

enum { BLOCK_LEVEL = 3 };

void qni_region_start(qni_region *region, const qn_solid *whole, const qni_lattice *lattice,
                      bool wide) {
    memset(region, 0, sizeof *region);
    region->whole = whole;
    region->lattice = lattice;
    region->wide = wide;
    region->top = BLOCK_LEVEL;
    for (int k = 0; k < 3 && !whole->direct; ++k)
        while (region->top + 1 < QNI_REGION_LEVELS && lattice->cells[k] > 1 << region->top)
            ++region->top;
}

void qni_region_end(qni_region *region) {
    for (int level = 0; level < QNI_REGION_LEVELS; ++level)
        for (int n = 0; n < QNI_REGION_PLACES; ++n) {
            qn_solid_destroy(region->parts[level][n].solid);
            region->parts[level][n].solid = NULL;
        }
}

static qni_box box_of(const qni_region *region, const int32_t place[3], int32_t level) {
    const int32_t margin = region->wide ? 1 << (level - 1) : 0;
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        box.low[k] = qni_lattice_at(region->lattice, k, (place[k] << level) - margin);
        box.high[k] = qni_lattice_at(region->lattice, k, ((place[k] + 1) << level) + margin);
    }
    return box;
}

/* What is restricted at once needs no larger cubes, and may be large itself: only the last is kept.
 */
static qni_region_part *part_at(qni_region *region, const int32_t place[3], int32_t level) {
    if (region->whole->direct)
        return &region->parts[level][0];
    const uint32_t x = (uint32_t)place[0] % QNI_REGION_SIDE,
                   y = (uint32_t)place[1] % QNI_REGION_SIDE;
    return &region->parts[level][QNI_REGION_SIDE * y + x];
}

/* A cube of a solid that agrees with the whole in it; NULL when that failed. */
static const qn_solid *cube_of(qni_region *region, const qn_solid *solid, const int32_t place[3],
                               int32_t level) {
    qni_region_part *part = part_at(region, place, level);
    if (part->solid && memcmp(place, part->place, sizeof part->place) == 0)
        return part->solid;
    const qni_box box = box_of(region, place, level);
    qn_solid_destroy(part->solid);
    part->solid = NULL;
    memcpy(part->place, place, sizeof part->place);
    if (solid->ops->restrict_to(solid, &box, &part->solid) != QN_OK)
        part->solid = NULL;
    return part->solid;
}

const qn_solid *qni_region_cube(qni_region *region, const int32_t low[3], int32_t level) {
    const qn_solid *solid = region->whole;
    for (int32_t at = level > region->top ? level : region->top; solid && at >= level; --at) {
        const int32_t place[3] = {low[0] >> at, low[1] >> at, low[2] >> at};
        solid = at < QNI_REGION_LEVELS ? cube_of(region, solid, place, at) : NULL;
    }
    return solid;
}
