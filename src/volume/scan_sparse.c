// SPDX-License-Identifier: MIT
/* Scans of sparse fields: the four rows of blocks that a row of lattice leaves touches are walked
 * in step; where all eight blocks round a place hold one value each, only their signs are compared,
 * and stretches without a change are leapt over. */
#include "volume/field_sparse.h"
#include "volume/field_rows.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* The mixed leaves of a row. */
typedef struct mixed_leaf {
    int32_t x;
    uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES];
} mixed_leaf;

struct qni_sparse_scan {
    mixed_leaf *leaves;
    int64_t count, capacity;
};

/* One block of one of the four rows: its signs, and where what it holds ends along x. Of the rows
 * above in y or z only the first layer is filled in. */
typedef struct strip {
    int64_t until;
    bool is_leaf, above;                /* `above` for those that are none */
    uint8_t bits[QNI_BLOCK][QNI_BLOCK]; /* bit x of [z][y] */
} strip;

typedef struct walk {
    const qni_field *field;
    const qni_sparse_run *run[4], *end[4]; /* by 1 for y + 1, 2 for z + 1 */
    strip strips[2][4];                    /* at x and x + 1, in turn */
    bool met_nonfinite;
} walk;

/* Signs of `count` samples, a multiple of 16, 8 to a byte. */
static void pack_samples(walk *w, const char *samples, int64_t count, uint8_t *bits) {
    const qni_field *field = w->field;
    if (field->direct) {
        w->met_nonfinite |= qni_field_pack_samples(field, samples, count, bits);
        return;
    }
    double values[QNI_BLOCK_SAMPLES];
    qni_samples_load(field->grid->scalar, samples, count, values);
    memset(bits, 0, (size_t)(count / 8));
    for (int64_t n = 0; n < count; ++n)
        bits[n / 8] =
            (uint8_t)(bits[n / 8] | (unsigned)(qni_field_settle(field, values[n]) >= 0) << (n % 8));
}

static void pack_leaf(walk *w, int n, const char *samples, strip *to) {
    const size_t layer = 64 * qn_scalar_size(w->field->grid->scalar);
    uint8_t two[2];
    if (n == 0) {
        pack_samples(w, samples, QNI_BLOCK_SAMPLES, &to->bits[0][0]);
    } else if (n == 2) {
        pack_samples(w, samples, 64, &to->bits[0][0]);
    } else {
        for (int z = 0; z < (n == 1 ? QNI_BLOCK : 1); ++z) {
            pack_samples(w, samples + (size_t)z * layer, 16, two);
            to->bits[z][0] = two[0];
        }
    }
}

static void look_up(walk *w, int n, int64_t x, strip *to) {
    const qni_sparse *sparse = w->field->sparse;
    while (w->run[n] < w->end[n] && w->run[n]->end <= x)
        ++w->run[n];
    const qni_sparse_run *run = w->run[n];
    double value = sparse->grid.background;
    to->is_leaf = false;
    if (run == w->end[n]) {
        to->until = INT64_MAX;
    } else if (run->begin > x) {
        to->until = run->begin;
    } else {
        to->until = run->end;
        to->is_leaf = run->leaf >= 0;
        value = run->value;
        if (to->is_leaf) {
            pack_leaf(w, n, qni_sparse_leaf(sparse, run->leaf + (x - run->begin)), to);
            return;
        }
    }
    w->met_nonfinite |= w->field->direct && !isfinite(value);
    to->above = qni_field_settle(w->field, value) >= 0;
    memset(to->bits, to->above ? 0xff : 0, sizeof to->bits);
}

/* All eight blocks hold one value each, and these are on one side. */
static bool is_plain(const strip now[4], const strip next[4]) {
    for (int n = 0; n < 4; ++n)
        if (now[n].is_leaf || next[n].is_leaf || now[n].above != now[0].above ||
            next[n].above != now[0].above)
            return false;
    return true;
}

/* The signs of a lattice leaf; false when they are all alike. */
static bool gather_signs(const strip now[4], const strip next[4],
                         uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES]) {
    unsigned all = 0x1ff, any = 0;
    for (int z = 0; z < QNI_LEAF_SAMPLES; ++z)
        for (int y = 0; y < QNI_LEAF_SAMPLES; ++y) {
            const int n = (y == QNI_BLOCK) + 2 * (z == QNI_BLOCK);
            const unsigned bits = now[n].bits[z & 7][y & 7] | (next[n].bits[z & 7][y & 7] & 1u)
                                                                  << 8;
            signs[z][y] = (uint16_t)bits;
            all &= bits;
            any |= bits;
        }
    return all != 0x1ff && any != 0;
}

static bool reserve(qni_scan *scan) {
    struct qni_sparse_scan *found = scan->sparse;
    if (found->count < found->capacity)
        return true;
    const int64_t capacity = 2 * found->capacity + 64;
    void *grown =
        qni_realloc(scan->context, found->leaves, found->capacity, capacity, sizeof *found->leaves);
    if (!grown)
        return false;
    found->leaves = grown;
    found->capacity = capacity;
    return true;
}

/* The first place whose blocks can differ from what is below all runs; -1 when there are none. */
static int64_t start_walk(const qni_field *field, int64_t row, walk *w) {
    const qni_sparse *sparse = field->sparse;
    const qni_sparse_row *at = sparse->field_rows + row;
    int64_t first = INT64_MAX;
    w->field = field;
    w->met_nonfinite = false;
    for (int n = 0; n < 4; ++n) {
        const int64_t r =
            qni_sparse_find_row(sparse->rows, sparse->row_count, at->y + (n & 1), at->z + (n >> 1));
        w->run[n] = sparse->runs + (r < 0 ? 0 : sparse->row_runs[r]);
        w->end[n] = sparse->runs + (r < 0 ? 0 : sparse->row_runs[r + 1]);
        if (w->run[n] < w->end[n] && w->run[n]->begin < first)
            first = w->run[n]->begin;
    }
    return first == INT64_MAX ? -1 : first - 1;
}

void qni_sparse_scan_row(const qni_field *field, int64_t row, qni_scan *scan) {
    walk w;
    int turn = 0;
    int64_t x = start_walk(field, row, &w);
    scan->rows = 1;
    scan->sparse->count = 0;
    if (x < 0)
        return;
    for (int n = 0; n < 4; ++n)
        look_up(&w, n, x, &w.strips[turn][n]);
    while (x < field->leaves[0]) {
        const strip *now = w.strips[turn];
        strip *next = w.strips[1 - turn];
        int64_t until = INT64_MAX;
        for (int n = 0; n < 4; ++n) {
            look_up(&w, n, x + 1, next + n);
            until = next[n].until < until ? next[n].until : until;
        }
        int64_t to = x + 1;
        if (is_plain(now, next)) {
            if (until == INT64_MAX)
                break;
            to = until - 1;
        } else {
            if (!reserve(scan)) {
                scan->failed = true;
                return;
            }
            mixed_leaf *leaf = scan->sparse->leaves + scan->sparse->count;
            leaf->x = (int32_t)x;
            scan->sparse->count += gather_signs(now, next, leaf->signs);
        }
        x = to;
        turn = 1 - turn;
    }
    scan->met_nonfinite = scan->met_nonfinite || w.met_nonfinite;
}

static int64_t find_leaf(const struct qni_sparse_scan *found, int64_t from) {
    int64_t low = 0, high = found->count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (found->leaves[middle].x < from)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

int64_t qni_sparse_scan_next(const qni_scan *scan, int64_t from) {
    const int64_t at = find_leaf(scan->sparse, from);
    return at < scan->sparse->count ? scan->sparse->leaves[at].x : -1;
}

void qni_sparse_scan_leaf(const qni_scan *scan, int64_t leaf_x,
                          uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES]) {
    const mixed_leaf *leaf = scan->sparse->leaves + find_leaf(scan->sparse, leaf_x);
    memcpy(signs, leaf->signs, sizeof leaf->signs);
}

qn_status qni_sparse_scan_create(qni_scan *scan, qn_error *error) {
    scan->sparse = qni_alloc_zero(scan->context, 1, sizeof *scan->sparse);
    return scan->sparse ? QN_OK : qni_fail_memory(error, "the signs of a row of leaves");
}

void qni_sparse_scan_destroy(qni_scan *scan) {
    if (!scan->sparse)
        return;
    qni_free(scan->context, scan->sparse->leaves, scan->sparse->capacity,
             sizeof *scan->sparse->leaves);
    qni_free(scan->context, scan->sparse, 1, sizeof *scan->sparse);
    scan->sparse = NULL;
}
