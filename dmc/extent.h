// SPDX-License-Identifier: MIT
/* What part of a leaf lies in the lattice. */
#ifndef QNI_DMC_EXTENT_H
#define QNI_DMC_EXTENT_H

#include "dmc/leaf_hd.h"
#include "volume/field.h"

static inline qni_leaf_extent qni_leaf_extent_of(const qni_field *field, const int32_t leaf[3]) {
    qni_leaf_extent extent;
    for (int a = 0; a < 3; ++a) {
        int64_t left = field->cells[a] - (int64_t)leaf[a] * QNI_LEAF;
        extent.cells[a] = left < QNI_LEAF ? (int)left : QNI_LEAF;
        extent.at_low[a] = leaf[a] == 0;
    }
    return extent;
}

#endif
