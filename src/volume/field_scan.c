// SPDX-License-Identifier: MIT
/* Leaves by their signs: one bit a lattice point, a band of rows of leaves at a time. */
#include "volume/field.h"
#include "volume/field_rows.h"
#include "volume/field_sparse.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { LINES = QNI_LEAF_SAMPLES * QNI_BAND_LINES };

/* Whole 64-bit words, one byte past the last leaf, and room for packing 16 bits at a time. */
static int64_t line_bytes_of(const qni_field *field) {
    return (field->samples[0] / 8 + 2 + 2 + 7) / 8 * 8;
}

qn_status qni_scan_create(qn_context *context, const qni_field *field, qni_scan *scan,
                          qn_error *error) {
    memset(scan, 0, sizeof *scan);
    scan->context = context;
    if (field->sparse)
        return qni_sparse_scan_create(scan, error);
    scan->line_bytes = line_bytes_of(field);
    scan->bits = qni_alloc_zero(context, (LINES + 2 * QNI_BAND_ROWS) * scan->line_bytes, 1);
    scan->values = qni_alloc(context, field->samples[0], sizeof(double));
    if (!scan->bits || !scan->values) {
        qni_scan_destroy(context, field, scan);
        return qni_fail_memory(error, "the signs of a band of leaves");
    }
    scan->all = scan->bits + LINES * scan->line_bytes;
    scan->any = scan->all + QNI_BAND_ROWS * scan->line_bytes;
    return QN_OK;
}

void qni_scan_destroy(qn_context *context, const qni_field *field, qni_scan *scan) {
    qni_sparse_scan_destroy(scan);
    qni_free(context, scan->bits, (LINES + 2 * QNI_BAND_ROWS) * scan->line_bytes, 1);
    qni_free(context, scan->values, field->samples[0], sizeof(double));
    memset(scan, 0, sizeof *scan);
}

int64_t qni_field_row_count(const qni_field *field) {
    if (field->sparse)
        return field->sparse->field_row_count;
    return field->leaves[0] > 0 ? field->leaves[1] * field->leaves[2] : 0;
}

int64_t qni_field_find_row(const qni_field *field, int64_t leaf_y, int64_t leaf_z) {
    if (field->sparse)
        return qni_sparse_find_row(field->sparse->field_rows, field->sparse->field_row_count,
                                   leaf_y, leaf_z);
    const bool beyond =
        leaf_y < 0 || leaf_z < 0 || leaf_y >= field->leaves[1] || leaf_z >= field->leaves[2];
    return beyond ? -1 : leaf_z * field->leaves[1] + leaf_y;
}

void qni_field_row_leaf(const qni_field *field, int64_t row, int32_t leaf_yz[2]) {
    if (field->sparse) {
        leaf_yz[0] = field->sparse->field_rows[row].y;
        leaf_yz[1] = field->sparse->field_rows[row].z;
        return;
    }
    leaf_yz[0] = (int32_t)(row % field->leaves[1]);
    leaf_yz[1] = (int32_t)(row / field->leaves[1]);
}

static int64_t bands_of_layer(const qni_field *field) {
    return (field->leaves[1] + QNI_BAND_ROWS - 1) / QNI_BAND_ROWS;
}

int64_t qni_field_band_count(const qni_field *field) {
    if (field->sparse)
        return field->sparse->field_row_count;
    return field->leaves[0] > 0 ? bands_of_layer(field) * field->leaves[2] : 0;
}

int64_t qni_field_band_row(const qni_field *field, int64_t band) {
    if (field->sparse)
        return band;
    const int64_t layer_bands = bands_of_layer(field);
    return band / layer_bands * field->leaves[1] + band % layer_bands * QNI_BAND_ROWS;
}

static void set_bit(uint8_t *bits, int64_t n, bool on) {
    uint8_t mask = (uint8_t)(1u << (n % 8));
    bits[n / 8] = (uint8_t)(on ? bits[n / 8] | mask : bits[n / 8] & ~mask);
}

/* Move the bits of a row up by one place, to make room for the virtual point in front. */
static void shift_up(uint8_t *bits, int64_t bytes) {
    for (int64_t n = bytes - 1; n > 0; --n)
        bits[n] = (uint8_t)((unsigned)bits[n] << 1 | bits[n - 1] >> 7);
    bits[0] = (uint8_t)((unsigned)bits[0] << 1);
}

static bool is_virtual(const qni_field *field, int axis, int64_t at) {
    return field->border && (at == 0 || at == field->samples[axis] - 1);
}

/* The signs of one lattice row. */
static void pack_lattice_row(const qni_field *field, int64_t y, int64_t z, qni_scan *scan,
                             uint8_t *bits) {
    const int64_t points = field->samples[0];
    if (is_virtual(field, 1, y) || is_virtual(field, 2, z)) {
        memset(bits, field->inside_below ? 0xff : 0, (size_t)scan->line_bytes);
        return;
    }
    if (!field->direct) {
        qni_field_load_lattice_row(field, y, z, scan->values);
        memset(bits, 0, (size_t)scan->line_bytes);
        for (int64_t n = 0; n < points; ++n)
            bits[n / 8] = (uint8_t)(bits[n / 8] | (unsigned)(scan->values[n] >= 0) << (n % 8));
        return;
    }
    if (qni_field_pack_row(field, y - field->border, z - field->border, bits))
        scan->met_nonfinite = true;
    if (field->border) {
        shift_up(bits, scan->line_bytes);
        set_bit(bits, 0, field->inside_below);
        set_bit(bits, points - 1, field->inside_below);
    }
}

/* Beyond the lattice's end the last point is repeated, so that nothing there looks like surface. */
static void repeat_last(const qni_field *field, qni_scan *scan, uint8_t *bits) {
    int64_t points = field->samples[0], end = scan->line_bytes * 8;
    bool last = bits[(points - 1) / 8] >> ((points - 1) % 8) & 1;
    int64_t n = points;
    for (; n < end && n % 8; ++n)
        set_bit(bits, n, last);
    memset(bits + n / 8, last ? 0xff : 0, (size_t)((end - n) / 8));
}

static uint8_t *line_of(const qni_scan *scan, int z, int y) {
    return scan->bits + ((int64_t)z * QNI_BAND_LINES + y) * scan->line_bytes;
}

static void gather_all_and_any(qni_scan *scan, int32_t row) {
    const int64_t words = scan->line_bytes / 8;
    uint64_t *all = (uint64_t *)(void *)(scan->all + row * scan->line_bytes);
    uint64_t *any = (uint64_t *)(void *)(scan->any + row * scan->line_bytes);
    memset(all, 0xff, (size_t)scan->line_bytes);
    memset(any, 0, (size_t)scan->line_bytes);
    for (int z = 0; z < QNI_LEAF_SAMPLES; ++z)
        for (int y = 0; y < QNI_LEAF_SAMPLES; ++y) {
            const uint64_t *bits =
                (const uint64_t *)(const void *)line_of(scan, z, row * QNI_LEAF + y);
            for (int64_t w = 0; w < words; ++w) {
                all[w] &= bits[w];
                any[w] |= bits[w];
            }
        }
}

void qni_field_scan_band(const qni_field *field, int64_t band, qni_scan *scan) {
    if (field->sparse) {
        qni_sparse_scan_row(field, band, scan);
        return;
    }
    int32_t leaf[2];
    qni_field_row_leaf(field, qni_field_band_row(field, band), leaf);
    const int64_t left = field->leaves[1] - leaf[0];
    scan->rows = left < QNI_BAND_ROWS ? (int32_t)left : QNI_BAND_ROWS;
    for (int z = 0; z < QNI_LEAF_SAMPLES; ++z)
        for (int y = 0; y <= scan->rows * QNI_LEAF; ++y) {
            const int64_t at_y = (int64_t)leaf[0] * QNI_LEAF + y,
                          at_z = (int64_t)leaf[1] * QNI_LEAF + z;
            uint8_t *bits = line_of(scan, z, y);
            if (at_z >= field->samples[2]) {
                memcpy(bits, line_of(scan, z - 1, y), (size_t)scan->line_bytes);
            } else if (at_y >= field->samples[1]) {
                memcpy(bits, line_of(scan, z, y - 1), (size_t)scan->line_bytes);
            } else {
                pack_lattice_row(field, at_y, at_z, scan, bits);
                repeat_last(field, scan, bits);
            }
        }
    for (int32_t row = 0; row < scan->rows; ++row)
        gather_all_and_any(scan, row);
}

static unsigned nine_bits(const uint8_t *bits, int64_t leaf_x) {
    return (bits[leaf_x] | (unsigned)bits[leaf_x + 1] << 8) & 0x1ffu;
}

bool qni_scan_is_mixed(const qni_scan *scan, int32_t row, int64_t leaf_x) {
    if (scan->sparse)
        return qni_sparse_scan_next(scan, leaf_x) == leaf_x;
    const int64_t from = row * scan->line_bytes;
    return nine_bits(scan->all + from, leaf_x) != 0x1ffu &&
           nine_bits(scan->any + from, leaf_x) != 0;
}

int64_t qni_scan_next_mixed(const qni_field *field, const qni_scan *scan, int32_t row,
                            int64_t from) {
    if (scan->sparse) {
        const int64_t next = qni_sparse_scan_next(scan, from);
        return next < 0 ? field->leaves[0] : next;
    }
    while (from < field->leaves[0] && !qni_scan_is_mixed(scan, row, from))
        ++from;
    return from;
}

void qni_scan_leaf(const qni_scan *scan, int32_t row, int64_t leaf_x,
                   uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES]) {
    if (scan->sparse) {
        qni_sparse_scan_leaf(scan, leaf_x, signs);
        return;
    }
    for (int z = 0; z < QNI_LEAF_SAMPLES; ++z)
        for (int y = 0; y < QNI_LEAF_SAMPLES; ++y)
            signs[z][y] = (uint16_t)nine_bits(line_of(scan, z, row * QNI_LEAF + y), leaf_x);
}
