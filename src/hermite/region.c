// SPDX-License-Identifier: MIT
/* Restricting step by step. Each cube is kept until one beside it is asked for; blocks are asked
 * for in an order that goes from one to the next, so the larger ones serve many of them. */
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
    for (int level = 0; level < QNI_REGION_LEVELS; ++level) {
        qn_solid_destroy(region->solids[level]);
        region->solids[level] = NULL;
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

static void forget_from(qni_region *region, int32_t level) {
    for (; level >= BLOCK_LEVEL; --level) {
        qn_solid_destroy(region->solids[level]);
        region->solids[level] = NULL;
    }
}

const qn_solid *qni_region_cube(qni_region *region, const int32_t low[3], int32_t level) {
    const qn_solid *solid = region->whole;
    for (int32_t at = level > region->top ? level : region->top; at >= level; --at) {
        const int32_t place[3] = {low[0] >> at, low[1] >> at, low[2] >> at};
        if (at >= QNI_REGION_LEVELS)
            return NULL;
        if (region->solids[at] && memcmp(place, region->place[at], sizeof place) != 0)
            forget_from(region, at);
        if (!region->solids[at]) {
            const qni_box box = box_of(region, place, at);
            qn_solid *restricted = NULL;
            memcpy(region->place[at], place, sizeof place);
            if (solid->ops->restrict_to(solid, &box, &restricted) != QN_OK)
                return NULL;
            region->solids[at] = restricted;
        }
        solid = region->solids[at];
    }
    return solid;
}
