// SPDX-License-Identifier: MIT
/* Samples near a box, copied from the field once, so that restricted solids need not ask the
 * volume; samples and cells by way of them. */
#include "solid/sampled_parts.h"

enum { MOST_BLOCK = 28 }; /* points along a side: of a block of 8^3 cells and what is near it */

int64_t qni_block_samples(const sample_block *block) {
    return (int64_t)block->size[0] * block->size[1] * block->size[2];
}

const double *qni_block_find(const sampled_solid *s, const int32_t point[3]) {
    const sample_block *block = &s->block;
    if (!block->values)
        return NULL;
    int64_t at = 0;
    for (int k = 2; k >= 0; --k) {
        const int32_t offset = point[k] - block->low[k];
        if (offset < 0 || offset >= block->size[k])
            return NULL;
        at = at * block->size[k] + offset;
    }
    return block->values + at;
}

double qni_sample(const sampled_solid *s, const int32_t point[3]) {
    const double *value = qni_block_find(s, point);
    if (value)
        return *value;
    const qni_field *field = &s->whole->field;
    return qni_sampled_sign(field->inside_below,
                            qni_field_value(field, point[0], point[1], point[2]));
}

void qni_sampled_load(const sampled_solid *s, const int32_t cell[3], double corner[8]) {
    const int32_t last[3] = {cell[0] + 1, cell[1] + 1, cell[2] + 1};
    const double *first = qni_block_find(s, cell);
    if (first && qni_block_find(s, last)) {
        const int64_t row = s->block.size[0], slice = row * s->block.size[1];
        for (int c = 0; c < 8; ++c)
            corner[c] = first[(c & 1) + (c >> 1 & 1) * row + (c >> 2) * slice];
        return;
    }
    const qni_field *field = &s->whole->field;
    const int64_t at[3] = {cell[0], cell[1], cell[2]};
    qni_field_load_cell(field, at, corner);
    for (int c = 0; c < 8; ++c)
        corner[c] = qni_sampled_sign(field->inside_below, corner[c]);
}

/* The samples of one leaf's tile that lie in the block. A leaf gives its own 8^3 points; the border
 * leaves, and the only leaf of a small block, all that their tiles hold of it. */
static void copy_tile(const qni_field *field, const int32_t leaf[3], bool alone,
                      sample_block *block) {
    double tile[QNI_TILE][QNI_TILE][QNI_TILE];
    int32_t low[3], high[3], base[3];
    qni_field_load_tile(field, leaf, tile);
    for (int k = 0; k < 3; ++k) {
        const int32_t first = leaf[k] * QNI_LEAF, end = block->low[k] + block->size[k] - 1;
        base[k] = first - 1;
        low[k] = qni_clamped(alone ? first - 1 : first, block->low[k], end);
        high[k] = qni_clamped(alone || leaf[k] + 1 == field->leaves[k] ? first + 9 : first + 7,
                              block->low[k], end);
    }
    for (int32_t z = low[2]; z <= high[2]; ++z)
        for (int32_t y = low[1]; y <= high[1]; ++y)
            for (int32_t x = low[0]; x <= high[0]; ++x)
                block->values[((int64_t)(z - block->low[2]) * block->size[1] + y - block->low[1]) *
                                  block->size[0] +
                              x - block->low[0]] =
                    qni_sampled_sign(field->inside_below,
                                     tile[z - base[2]][y - base[1]][x - base[0]]);
}

void qni_block_fill(const qni_field *field, sample_block *block) {
    int32_t first[3], last[3], leaf[3];
    bool alone = true;
    for (int k = 0; k < 3; ++k) {
        const int32_t end = block->low[k] + block->size[k] - 1;
        first[k] = qni_clamped((block->low[k] + 1) / QNI_LEAF, 0, field->leaves[k] - 1);
        alone = alone && end <= first[k] * QNI_LEAF + 9;
    }
    if (alone) {
        copy_tile(field, first, true, block);
        return;
    }
    for (int k = 0; k < 3; ++k) {
        first[k] = qni_clamped(block->low[k] / QNI_LEAF, 0, field->leaves[k] - 1);
        last[k] =
            qni_clamped((block->low[k] + block->size[k] - 1) / QNI_LEAF, 0, field->leaves[k] - 1);
    }
    for (leaf[2] = first[2]; leaf[2] <= last[2]; ++leaf[2])
        for (leaf[1] = first[1]; leaf[1] <= last[1]; ++leaf[1])
            for (leaf[0] = first[0]; leaf[0] <= last[0]; ++leaf[0])
                copy_tile(field, leaf, false, block);
}

/* The points that the box's cells, and the slopes at their corners, need; false when they are too
 * many. */
bool qni_block_lay(const sampled_solid *s, const qni_box *box, sample_block *block) {
    for (int k = 0; k < 3; ++k) {
        qni_cell_place first, last;
        const qni_sample_frame *frame = &s->whole->frame;
        qni_locate_axis(frame, k, box->low[k], &first);
        qni_locate_axis(frame, k, box->high[k], &last);
        const int32_t end = last.cell[k] + (last.along[k] > 0) + 1;
        const int32_t more = s->whole->creases ? 2 : 0; /* for stencils on either side */
        const int32_t low = qni_clamped(first.cell[k] - 1 - more, 0, frame->count[k] - 1),
                      high = qni_clamped(end + more, 0, frame->count[k] - 1);
        block->low[k] = low;
        block->size[k] = high - low + 1;
        if (block->size[k] > MOST_BLOCK)
            return false;
    }
    return true;
}

/* What a block holds is there at once, fits that are known with it: a smaller one is no cheaper. */
bool qni_block_holds(const sampled_solid *s, const sample_block *block) {
    int32_t last[3];
    for (int k = 0; k < 3; ++k)
        last[k] = block->low[k] + block->size[k] - 1;
    return qni_block_find(s, block->low) && qni_block_find(s, last);
}
