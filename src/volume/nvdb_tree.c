// SPDX-License-Identifier: MIT
/* NanoVDB trees, by the layout that PNanoVDB.h gives. A file may be hostile: every node is checked
 * to lie inside the grid before it is read, and no more nodes are visited than the grid has room
 * for, so that nodes which point at each other end. */
#include "volume/nvdb.h"
#include "core/context.h"
#include "core/status.h"
#include "qni_config.h"

#if QNI_HAVE_NANOVDB
#include "volume/leaf_order.h"

#include <math.h>
#include <string.h>

#define PNANOVDB_C
#define PNANOVDB_BUF_BOUNDS_CHECK
#include <nanovdb/PNanoVDB.h>

enum { UPPER_COUNT = 32768, LOWER_COUNT = 4096, UPPER_EDGE = 4096, LOWER_EDGE = 128, MAJOR = 32 };

static const struct {
    const char *name;
    int scalar; /* -1: not read */
} types[PNANOVDB_GRID_TYPE_END] = {
    [0] = {"none", -1},
    [PNANOVDB_GRID_TYPE_FLOAT] = {"float", QN_F32},
    [PNANOVDB_GRID_TYPE_DOUBLE] = {"double", QN_F64},
    [PNANOVDB_GRID_TYPE_INT16] = {"int16", QN_I16},
    [PNANOVDB_GRID_TYPE_INT32] = {"int32", QN_I32},
    [PNANOVDB_GRID_TYPE_INT64] = {"int64", QN_F64},
    [PNANOVDB_GRID_TYPE_VEC3F] = {"vec3f", -1},
    [PNANOVDB_GRID_TYPE_VEC3D] = {"vec3d", -1},
    [PNANOVDB_GRID_TYPE_MASK] = {"mask", QN_U8},
    [PNANOVDB_GRID_TYPE_HALF] = {"half", -1},
    [PNANOVDB_GRID_TYPE_UINT32] = {"uint32", QN_U32},
    [PNANOVDB_GRID_TYPE_BOOLEAN] = {"bool", QN_U8},
    [PNANOVDB_GRID_TYPE_RGBA8] = {"rgba8", -1},
    [PNANOVDB_GRID_TYPE_FP4] = {"float4", QN_F32},
    [PNANOVDB_GRID_TYPE_FP8] = {"float8", QN_F32},
    [PNANOVDB_GRID_TYPE_FP16] = {"float16", QN_F32},
    [PNANOVDB_GRID_TYPE_FPN] = {"floatN", QN_F32},
    [PNANOVDB_GRID_TYPE_VEC4F] = {"vec4f", -1},
    [PNANOVDB_GRID_TYPE_VEC4D] = {"vec4d", -1},
    [PNANOVDB_GRID_TYPE_INDEX] = {"index", -1},
};

bool qni_nvdb_type(uint32_t type, const char **name_out, qn_scalar *scalar_out) {
    const bool known = type < PNANOVDB_GRID_TYPE_END;
    *name_out = known ? types[type].name : "unknown";
    *scalar_out = known && types[type].scalar >= 0 ? (qn_scalar)types[type].scalar : QN_U8;
    return known && types[type].scalar >= 0;
}

/* One walk over the tree: to count when `arrays` is NULL, else to fill them. */
typedef struct walk {
    const unsigned char *bytes;
    int64_t size;
    uint32_t type;
    const pnanovdb_grid_type_constants_t *layout;
    double background;
    int64_t uppers, lowers;         /* visited so far */
    int64_t leaf_count, tile_count; /* found so far */
    qni_sparse_arrays *arrays;
    const char *fault; /* what is wrong with the tree */
} walk;

static bool fault(walk *w, const char *what) {
    w->fault = w->fault ? w->fault : what;
    return false;
}

/* Whether a node lies in the grid, and one more of its kind can. */
static bool holds(walk *w, int64_t at, int64_t bytes, int64_t seen) {
    if (at < 0 || at % 8 != 0 || at > w->size || bytes > w->size - at)
        return fault(w, "a node lies outside the grid");
    return seen <= w->size / bytes || fault(w, "nodes are shared");
}

static int64_t child_of(int64_t base, int64_t offset) {
    int64_t at;
    return __builtin_add_overflow(base, offset, &at) ? -1 : at;
}

#define READ(w, type, at, out)                                                                     \
    do {                                                                                           \
        type stored_;                                                                              \
        memcpy(&stored_, (w)->bytes + (at), sizeof stored_);                                       \
        *(out) = stored_;                                                                          \
    } while (0)

/* A value in a node's table; its node was checked. */
static double value_at(walk *w, int64_t at) {
    float f32;
    double f64;
    int16_t i16;
    int32_t i32;
    int64_t i64;
    uint32_t u32;
    uint8_t u8;
    switch (w->type) {
    case PNANOVDB_GRID_TYPE_DOUBLE:
        READ(w, double, at, &f64);
        return f64;
    case PNANOVDB_GRID_TYPE_INT16:
        READ(w, int16_t, at, &i16);
        return i16;
    case PNANOVDB_GRID_TYPE_INT32:
        READ(w, int32_t, at, &i32);
        return i32;
    case PNANOVDB_GRID_TYPE_INT64:
        READ(w, int64_t, at, &i64);
        if (i64 > INT64_C(1) << 53 || i64 < -(INT64_C(1) << 53))
            fault(w, "it holds integers beyond 2^53, which a double cannot");
        return (double)i64;
    case PNANOVDB_GRID_TYPE_UINT32:
        READ(w, uint32_t, at, &u32);
        return u32;
    case PNANOVDB_GRID_TYPE_BOOLEAN:
        READ(w, uint8_t, at, &u8);
        return u8 != 0;
    case PNANOVDB_GRID_TYPE_MASK:
        return 0; /* the active state is all it has */
    default:
        READ(w, float, at, &f32);
        return (double)f32;
    }
}

/* ---- leaves ---------------------------------------------------------------------------------- */

static bool is_quantized(uint32_t type) {
    return type >= PNANOVDB_GRID_TYPE_FP4 && type <= PNANOVDB_GRID_TYPE_FPN;
}

/* Bits of a sample as a power of two: 2, 3, 4, or as the leaf says. */
static unsigned log_bits_of(const walk *w, int64_t at) {
    return w->type == PNANOVDB_GRID_TYPE_FPN ? w->bytes[at + 15] >> 5
                                             : w->type - PNANOVDB_GRID_TYPE_FP4 + 2;
}

static void take_quantized(walk *w, int64_t at, float *out) {
    const pnanovdb_buf_t buffer =
        pnanovdb_make_buf((uint32_t *)(uintptr_t)w->bytes, (uint64_t)w->size / 4);
    const pnanovdb_address_t table = {(uint64_t)at + w->layout->leaf_off_table};
    const unsigned log_bits = log_bits_of(w, at);
    for (int n = 0; n < 512; ++n) {
        pnanovdb_coord_t place = {n >> 6, n >> 3 & 7, n & 7};
        out[qni_leaf_turned(n)] = pnanovdb_leaf_fp_read_float(buffer, table, &place, log_bits);
    }
}

static void take_bits(const unsigned char *bits, uint8_t *out) {
    for (int n = 0; n < 512; ++n)
        out[qni_leaf_turned(n)] = bits[n >> 3] >> (n & 7) & 1;
}

/* NanoVDB.h keeps the bits of a bool leaf right behind the active mask; PNanoVDB.h's table (version
 * 32.4) has them 16 bytes further on. */
enum { BOOL_VALUES = PNANOVDB_LEAF_BASE_SIZE };

static void take_values(walk *w, int64_t at, void *out) {
    const unsigned char *table = w->bytes + at + w->layout->leaf_off_table;
    const size_t size = w->layout->value_stride_bits / 8;
    for (int n = 0; n < 512; ++n)
        if (w->type == PNANOVDB_GRID_TYPE_INT64)
            ((double *)out)[qni_leaf_turned(n)] =
                value_at(w, at + w->layout->leaf_off_table + 8 * n);
        else
            memcpy((char *)out + (size_t)qni_leaf_turned(n) * size, table + (size_t)n * size, size);
}

static bool visit_leaf(walk *w, int64_t at, const int32_t origin[3]) {
    if (!holds(w, at, w->layout->leaf_size, w->leaf_count + 1))
        return false;
    if (is_quantized(w->type)) {
        const unsigned log_bits = log_bits_of(w, at);
        if (log_bits > 4 || !holds(w, at, w->layout->leaf_off_table + (INT64_C(64) << log_bits), 0))
            return fault(w, "a leaf of packed values makes no sense");
    }
    qni_sparse_arrays *arrays = w->arrays;
    const int64_t leaf = w->leaf_count++;
    if (!arrays)
        return true;
    char *values = (char *)arrays->values + (size_t)leaf * arrays->value_bytes;
    uint64_t mask[8];
    memcpy(arrays->origins[leaf], origin, sizeof arrays->origins[leaf]);
    memcpy(mask, w->bytes + at + PNANOVDB_LEAF_OFF_VALUE_MASK, sizeof mask);
    qni_leaf_turn_mask(mask, arrays->masks[leaf]);
    if (is_quantized(w->type))
        take_quantized(w, at, (float *)(void *)values);
    else if (w->type == PNANOVDB_GRID_TYPE_MASK)
        take_bits(w->bytes + at + PNANOVDB_LEAF_OFF_VALUE_MASK, (uint8_t *)values);
    else if (w->type == PNANOVDB_GRID_TYPE_BOOLEAN)
        take_bits(w->bytes + at + BOOL_VALUES, (uint8_t *)values);
    else
        take_values(w, at, values);
    return !w->fault;
}

/* ---- inner nodes ----------------------------------------------------------------------------- */

/* A table of children and tiles: where it is, how many bits of place an axis has. */
typedef struct node {
    int64_t at, value_mask, child_mask, table;
    int axis_bits;
    int32_t edge; /* samples along a child's side */
    const int32_t *origin;
} node;

static bool bit_at(const walk *w, int64_t mask, int n) {
    return w->bytes[mask + n / 8] >> (n % 8) & 1;
}

static void place_in(const node *from, int n, int32_t origin[3]) {
    const int low = (1 << from->axis_bits) - 1;
    for (int a = 0; a < 3; ++a)
        origin[a] = (int32_t)((uint32_t)from->origin[a] +
                              (uint32_t)(from->edge * (n >> (2 - a) * from->axis_bits & low)));
}

static void note_tile(walk *w, const int32_t origin[3], int32_t edge, int32_t length, double value,
                      bool active) {
    if (w->type == PNANOVDB_GRID_TYPE_MASK)
        value = active;
    if (!active && value == w->background)
        return;
    if (w->arrays) {
        qn_sparse_tile *tile = w->arrays->tiles + w->tile_count;
        *tile = (qn_sparse_tile){.size = {edge, edge, length}, .value = value, .active = active};
        memcpy(tile->origin, origin, sizeof tile->origin);
    }
    ++w->tile_count;
}

/* The tiles of a node; neighbours along z that are alike come as one. */
static void visit_tiles(walk *w, const node *from) {
    const int count = 1 << 3 * from->axis_bits, side = 1 << from->axis_bits;
    const size_t stride = w->layout->table_stride;
    for (int n = 0; n < count; ++n) {
        if (bit_at(w, from->child_mask, n))
            continue;
        const unsigned char *entry = w->bytes + from->table + (size_t)n * stride;
        const bool active = bit_at(w, from->value_mask, n);
        const double value = value_at(w, from->table + (int64_t)((size_t)n * stride));
        int end = n + 1;
        while (end % side != 0 && !bit_at(w, from->child_mask, end) &&
               bit_at(w, from->value_mask, end) == active &&
               memcmp(entry, w->bytes + from->table + (size_t)end * stride, stride) == 0)
            ++end;
        int32_t origin[3];
        place_in(from, n, origin);
        note_tile(w, origin, from->edge, from->edge * (end - n), value, active);
        n = end - 1;
    }
}

static int64_t child_at(const walk *w, const node *from, int n) {
    int64_t offset;
    READ(w, int64_t, from->table + (int64_t)n * w->layout->table_stride, &offset);
    return child_of(from->at, offset);
}

static bool visit_lower(walk *w, int64_t at, const int32_t origin[3]) {
    if (!holds(w, at, w->layout->lower_size, ++w->lowers))
        return false;
    const node lower = {at,
                        at + PNANOVDB_LOWER_OFF_VALUE_MASK,
                        at + PNANOVDB_LOWER_OFF_CHILD_MASK,
                        at + w->layout->lower_off_table,
                        4,
                        8,
                        origin};
    visit_tiles(w, &lower);
    for (int n = 0; n < LOWER_COUNT; ++n) {
        int32_t place[3];
        if (!bit_at(w, lower.child_mask, n))
            continue;
        place_in(&lower, n, place);
        if (!visit_leaf(w, child_at(w, &lower, n), place))
            return false;
    }
    return !w->fault;
}

static bool visit_upper(walk *w, int64_t at, const int32_t origin[3]) {
    if (!holds(w, at, w->layout->upper_size, ++w->uppers))
        return false;
    const node upper = {at,
                        at + PNANOVDB_UPPER_OFF_VALUE_MASK,
                        at + PNANOVDB_UPPER_OFF_CHILD_MASK,
                        at + w->layout->upper_off_table,
                        5,
                        LOWER_EDGE,
                        origin};
    visit_tiles(w, &upper);
    for (int n = 0; n < UPPER_COUNT; ++n) {
        int32_t place[3];
        if (!bit_at(w, upper.child_mask, n))
            continue;
        place_in(&upper, n, place);
        if (!visit_lower(w, child_at(w, &upper, n), place))
            return false;
    }
    return !w->fault;
}

/* The origin of a root tile from its key: 21 bits an axis, of which 20 count. */
static void origin_of_key(uint64_t key, int32_t origin[3]) {
    for (int a = 0; a < 3; ++a)
        origin[a] = (int32_t)((uint32_t)(key >> (42 - 21 * a)) << 12);
}

static bool visit_tree(walk *w) {
    int64_t root_offset;
    uint32_t tile_count;
    READ(w, int64_t, PNANOVDB_GRID_SIZE + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, &root_offset);
    const int64_t root = child_of(PNANOVDB_GRID_SIZE, root_offset);
    if (!holds(w, root, w->layout->root_size, 0))
        return false;
    READ(w, uint32_t, root + PNANOVDB_ROOT_OFF_TABLE_SIZE, &tile_count);
    if (!holds(w, root, w->layout->root_size + (int64_t)tile_count * w->layout->root_tile_size, 0))
        return fault(w, "the root has more tiles than the grid has bytes");
    w->background = value_at(w, root + w->layout->root_off_background);
    w->uppers = w->lowers = w->leaf_count = w->tile_count = 0;
    for (uint32_t n = 0; n < tile_count; ++n) {
        const int64_t tile = root + w->layout->root_size + (int64_t)n * w->layout->root_tile_size;
        int64_t child;
        uint64_t key;
        uint32_t state;
        int32_t origin[3];
        READ(w, uint64_t, tile + PNANOVDB_ROOT_TILE_OFF_KEY, &key);
        READ(w, int64_t, tile + PNANOVDB_ROOT_TILE_OFF_CHILD, &child);
        READ(w, uint32_t, tile + PNANOVDB_ROOT_TILE_OFF_STATE, &state);
        origin_of_key(key, origin);
        if (child == 0)
            note_tile(w, origin, UPPER_EDGE, UPPER_EDGE,
                      value_at(w, tile + w->layout->root_tile_off_value), state & 1);
        else if (!visit_upper(w, child_of(root, child), origin))
            return false;
    }
    return !w->fault;
}

/* ---- the grid -------------------------------------------------------------------------------- */

static bool check_header(walk *w) {
    uint64_t magic, size;
    uint32_t version;
    if (w->size < PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE)
        return fault(w, "it is too short");
    READ(w, uint64_t, PNANOVDB_GRID_OFF_MAGIC, &magic);
    READ(w, uint32_t, PNANOVDB_GRID_OFF_VERSION, &version);
    READ(w, uint64_t, PNANOVDB_GRID_OFF_GRID_SIZE, &size);
    READ(w, uint32_t, PNANOVDB_GRID_OFF_GRID_TYPE, &w->type);
    if (magic != PNANOVDB_MAGIC_NUMBER)
        return fault(w, "it does not begin with NanoVDB's mark");
    if (version >> 21 != MAJOR)
        return fault(w, "its version is not 32");
    if (size > (uint64_t)w->size)
        return fault(w, "it says it is longer than it is");
    const char *name;
    qn_scalar scalar;
    if (!qni_nvdb_type(w->type, &name, &scalar))
        return fault(w, "its type is not the one the file named");
    w->layout = pnanovdb_grid_type_constants + w->type;
    return true;
}

static void read_map(const walk *w, double matrix[4][4]) {
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            READ(w, double, PNANOVDB_GRID_OFF_MAP + PNANOVDB_MAP_OFF_MATD + 8 * (3 * r + c),
                 &matrix[r][c]);
        READ(w, double, PNANOVDB_GRID_OFF_MAP + PNANOVDB_MAP_OFF_VECD + 8 * r, &matrix[r][3]);
    }
    matrix[3][3] = 1;
}

static qn_sparse_class class_of(const walk *w) {
    uint32_t grid_class;
    READ(w, uint32_t, PNANOVDB_GRID_OFF_GRID_CLASS, &grid_class);
    return grid_class == PNANOVDB_GRID_CLASS_LEVEL_SET    ? QN_SPARSE_LEVEL_SET
           : grid_class == PNANOVDB_GRID_CLASS_FOG_VOLUME ? QN_SPARSE_FOG
                                                          : QN_SPARSE_UNKNOWN;
}

qn_status qni_nvdb_load(const qni_source *source, const void *bytes, int64_t size, const char *name,
                        const qn_volume_read_options *options, qn_volume **volume_out,
                        qn_error *error) {
    walk w = {.bytes = bytes, .size = size};
    const char *type;
    qn_sparse_grid grid = {.leaf_count = 0};
    if (!check_header(&w) || !visit_tree(&w))
        return qni_source_fail(source, error, "grid '%s' is damaged: %s", name, w.fault);
    qni_nvdb_type(w.type, &type, &grid.scalar);
    QN_TRY(qni_sparse_arrays_create(source->context, grid.scalar, w.leaf_count, w.tile_count,
                                    &w.arrays, error));
    if (!visit_tree(&w)) {
        qni_sparse_arrays_destroy(w.arrays);
        return qni_source_fail(source, error, "grid '%s' is damaged: %s", name, w.fault);
    }
    grid.background = w.background;
    grid.kind = class_of(&w);
    read_map(&w, grid.index_to_world);
    strncpy(grid.name, name, sizeof grid.name - 1);
    return qni_sparse_arrays_load(source, w.arrays, &grid, "nvdb", options, volume_out, error);
}

#endif
