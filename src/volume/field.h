// SPDX-License-Identifier: MIT
/* A field: what a surfacer sees of a volume at one iso-value. Values are less iso, so the surface
 * is at 0 and a sample is above when its value is >= 0. Surfacers ask for leaves (8^3 cells) by
 * their signs, row by row, and for tiles of values round one leaf; they never learn how the volume
 * stores its samples. A sparse volume answers the same calls from its own leaves, without a band
 * or row for places where it has none.
 *
 * Lattice point (0, 0, 0) is sample (0, 0, 0) of an open field; a closed field has one virtual
 * layer of outside samples on every side, so its sample (0, 0, 0) is lattice point (1, 1, 1).
 * A sparse field is neither: its lattice (sparse.h) begins and ends in background. */
#ifndef QNI_VOLUME_FIELD_H
#define QNI_VOLUME_FIELD_H

#include "volume/volume.h"

enum {
    QNI_LEAF = 8,         /* cells along a leaf's side */
    QNI_LEAF_SAMPLES = 9, /* samples that touch its cells */
    QNI_TILE = 11,        /* samples along a tile's side: one more on each side, for gradients */
    QNI_TILE_SAMPLES = QNI_TILE * QNI_TILE * QNI_TILE
};

typedef struct qni_field {
    const qn_grid *grid;             /* of a sparse field for its type, space and unit only */
    const struct qni_sparse *sparse; /* NULL: dense, and grid->samples are to be had */
    double isovalue;
    bool inside_below; /* inside is value < 0, else value >= 0 */
    int32_t border;    /* 1 closed, 0 open */
    int64_t samples[3];
    int64_t cells[3];
    int64_t leaves[3];
    double world[3][4]; /* lattice point to world */

    /* Stored-value form of `value >= 0` for contiguous samples: (stored >= threshold) != inverted.
     */
    bool direct; /* this form may be used */
    bool inverted;
    int constant; /* -1, or the answer for every stored value */
    union {
        double f64;
        float f32;
        int64_t whole;
    } threshold;

    /* 0 while no sample is known to be non-finite; else the distance given to them. */
    double nonfinite_distance;
    int64_t nan_count, infinite_count;
} qni_field;

/* QN_ERROR_INVALID_ARGUMENT for an iso-value that is not finite. */
qn_status qni_field_init(const qn_volume *volume, double isovalue, bool inside_below, bool open,
                         qni_field *field_out, qn_error *error);

/* Count the non-finite samples and set the distance for them: one pass over the data, needed only
 * after a scan met one, and at once for fields that scans cannot look at in their stored form
 * (`!direct`). */
void qni_field_measure_nonfinite(qn_context *context, qni_field *field);
/* The same from counts made elsewhere; `largest` of |value - iso| over the finite samples. */
void qni_field_set_nonfinite(qni_field *field, int64_t nan_count, int64_t infinite_count,
                             double largest);

/* Value of any lattice point. */
double qni_field_value(const qni_field *field, int64_t x, int64_t y, int64_t z);
/* Values of the eight corners of a cell of the lattice; corner x + 2 y + 4 z. */
void qni_field_load_cell(const qni_field *field, const int64_t cell[3], double corner[8]);
/* The same for several cells here and there, in lanes: all are asked for before any is loaded. */
enum { QNI_CELLS_TOGETHER = 16 };
typedef struct qni_cells {
    int64_t cell[3][QNI_CELLS_TOGETHER];
    const char *from[QNI_CELLS_TOGETHER]; /* where their samples are, unless `other` */
    bool other[QNI_CELLS_TOGETHER];
    int others;
} qni_cells;
void qni_field_expect_cells(const qni_field *field, int count, qni_cells *cells);
void qni_field_load_cells(const qni_field *field, int count, const qni_cells *cells,
                          double corner[8][QNI_CELLS_TOGETHER]);
/* Ask for samples that will be loaded soon: the rows `low` to `high` along y and z from a cell's
 * lowest corner on, 0 to 1 for its corners. */
void qni_field_prefetch_rows(const qni_field *field, const int64_t cell[3], int low, int high);

/* The same, one point beyond the lattice's ends too, extrapolated as in tiles. */
double qni_field_extended_value(const qni_field *field, const int64_t point[3]);

/* Values of `count` lattice points along x; false, and nothing written, unless all of them are
 * samples of a dense volume. */
bool qni_field_load_run(const qni_field *field, const int64_t point[3], int64_t count, double *out);

/* Several short runs along x, from lattice points that lie so far from a cell's lowest corner;
 * false, and nothing written, unless that is quickly done: `low` and `high` bound the points along
 * all axes, all of them must be plain samples of a dense volume. */
typedef struct qni_run {
    int8_t x, y, z, count;
} qni_run;
bool qni_field_load_runs(const qni_field *field, const int64_t cell[3], int low, int high,
                         const qni_run *runs, int count, double *out);

/* ---- leaves by their signs ------------------------------------------------------------------- */

/* Leaves come in rows along x, rows in bands of up to 8 neighbours along y, so that rows of samples
 * are packed once and read in long runs. Bands are the unit of parallel work. */
enum { QNI_BAND_ROWS = 8, QNI_BAND_LINES = QNI_BAND_ROWS * QNI_LEAF + 1 };

/* Room for the signs of one band. */
typedef struct qni_scan {
    int64_t line_bytes; /* bytes of one packed line of lattice points along x */
    uint8_t *bits; /* [9][QNI_BAND_LINES][line_bytes]: bit x of line (z, y): the point is above */
    uint8_t *all, *any; /* [QNI_BAND_ROWS][line_bytes]: and, or over the 81 lines of each row */
    double *values;     /* [samples along x]: for lines without the direct form */
    int32_t rows;       /* rows in the scanned band */
    qn_context *context;
    struct qni_sparse_scan *sparse; /* in place of all these for sparse fields (field_sparse.c) */
    bool failed;                    /* a sparse scan found no memory */
    bool met_nonfinite; /* a direct scan found a sample that is not finite: measure and begin again
                         */
} qni_scan;

qn_status qni_scan_create(qn_context *context, const qni_field *field, qni_scan *scan_out,
                          qn_error *error);
void qni_scan_destroy(qn_context *context, const qni_field *field, qni_scan *scan);

/* Rows are numbered y first, in the order of the output. A sparse field numbers those alone that
 * can hold surface. */
int64_t qni_field_row_count(const qni_field *field);
/* The number of the row at leaf coordinates (y, z); -1 when there is none. */
int64_t qni_field_find_row(const qni_field *field, int64_t leaf_y, int64_t leaf_z);
/* Leaf coordinates (y, z) of a row. */
void qni_field_row_leaf(const qni_field *field, int64_t row, int32_t leaf_yz[2]);

int64_t qni_field_band_count(const qni_field *field);
/* The first row of a band; the band's end is the next one's first row or the next layer. */
int64_t qni_field_band_row(const qni_field *field, int64_t band);
/* Pack the signs of a band. */
void qni_field_scan_band(const qni_field *field, int64_t band, qni_scan *scan);
/* True when leaf x of row `row` of the scanned band (0 the first) has points on both sides. */
bool qni_scan_is_mixed(const qni_scan *scan, int32_t row, int64_t leaf_x);
/* The first such leaf at `from` or later; field->leaves[0] when there is none. */
int64_t qni_scan_next_mixed(const qni_field *field, const qni_scan *scan, int32_t row,
                            int64_t from);
/* The signs of that leaf: bit i of signs[z][y] is lattice point (8 x + i, ...), i from 0 to 8. */
void qni_scan_leaf(const qni_scan *scan, int32_t row, int64_t leaf_x,
                   uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES]);

/* ---- values ---------------------------------------------------------------------------------- */

/* The values round a leaf, tile[z][y][x], from lattice point 8 leaf - 1 on. One point beyond the
 * lattice's ends they are extrapolated linearly, so that central differences turn into one-sided
 * ones there; further out they mean nothing. */
void qni_field_load_tile(const qni_field *field, const int32_t leaf[3],
                         double tile[QNI_TILE][QNI_TILE][QNI_TILE]);
/* Ask for the samples of a tile that will be loaded soon. */
void qni_field_prefetch_tile(const qni_field *field, const int32_t leaf[3]);

#endif
