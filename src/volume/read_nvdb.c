// SPDX-License-Identifier: MIT
/* NanoVDB files: segments of a header, the grids' descriptions and their bytes, plain or packed by
 * zip or blosc. Grids by nvdb_tree.c. */
#include "volume/nvdb.h"
#include "core/context.h"
#include "core/status.h"
#include "qni_config.h"

#if QNI_HAVE_NANOVDB

#include <string.h>
#include <zlib.h>
#if QNI_HAVE_BLOSC
#include <blosc.h>
#endif

enum {
    SEGMENT_HEADER = 16,
    DESCRIPTION = 176,
    LONGEST_NAME = 4096,
    MOST_GRIDS = 4096,
    /* Packed bytes that claim to be more than this many times as long are not believed. */
    LARGEST_RATIO = 1100
};
enum { CODEC_NONE, CODEC_ZIP, CODEC_BLOSC };
static const uint64_t magic_number = UINT64_C(0x304244566f6e614e); /* "NanoVDB0" */
static const int64_t blosc_piece = INT64_C(1) << 30; /* packed bytes come in pieces of so many */

/* What a file says of one grid. */
typedef struct grid_entry {
    qn_grid_info info;
    int64_t grid_size, file_size;
    uint32_t codec;
} grid_entry;

typedef struct grid_list {
    grid_entry *entries;
    int64_t capacity;
    int32_t count;
} grid_list;

static uint64_t number_at(const unsigned char *bytes, int size) {
    uint64_t value = 0;
    for (int b = size - 1; b >= 0; --b)
        value = value << 8 | bytes[b];
    return value;
}

/* ---- descriptions ---------------------------------------------------------------------------- */

static qn_status read_name(qni_source *source, uint64_t size, char name[64], qn_error *error) {
    char all[LONGEST_NAME + 1] = "";
    if (size > LONGEST_NAME)
        return qni_source_fail(source, error, "a grid's name of %llu bytes makes no sense",
                               (unsigned long long)size);
    QN_TRY(qni_source_read(source, all, (int64_t)size, error));
    all[63] = 0;
    for (char *at = all; *at; ++at)
        *at = (unsigned char)*at < 32 ? '?' : *at;
    memcpy(name, all, 64);
    return QN_OK;
}

static qn_status read_description(qni_source *source, grid_entry *entry, qn_error *error) {
    unsigned char bytes[DESCRIPTION];
    memset(entry, 0, sizeof *entry);
    QN_TRY(qni_source_read(source, bytes, DESCRIPTION, error));
    const uint64_t grid_size = number_at(bytes, 8), file_size = number_at(bytes + 8, 8);
    const uint32_t grid_class = (uint32_t)number_at(bytes + 36, 4);
    const char *type;
    qn_scalar scalar;
    entry->codec = (uint32_t)number_at(bytes + 168, 2);
    entry->info.readable = qni_nvdb_type((uint32_t)number_at(bytes + 32, 4), &type, &scalar);
    entry->info.kind = grid_class == 1   ? QN_SPARSE_LEVEL_SET
                       : grid_class == 2 ? QN_SPARSE_FOG
                                         : QN_SPARSE_UNKNOWN;
    strncpy(entry->info.type, type, sizeof entry->info.type - 1);
    QN_TRY(read_name(source, number_at(bytes + 136, 4), entry->info.name, error));
    if (grid_size > INT64_MAX || file_size > INT64_MAX)
        return qni_source_fail(source, error, "grid '%s' is of a size that makes no sense",
                               entry->info.name);
    entry->grid_size = (int64_t)grid_size;
    entry->file_size = (int64_t)file_size;
    return QN_OK;
}

static qn_status append(qni_source *source, grid_list *list, qn_error *error) {
    if (list->count == MOST_GRIDS)
        return qni_source_fail(source, error, "more than %d grids", MOST_GRIDS);
    if (list->count == list->capacity) {
        void *grown = qni_realloc(source->context, list->entries, list->capacity,
                                  2 * list->capacity + 4, sizeof *list->entries);
        if (!grown)
            return qni_fail_memory(error, "the list of grids");
        list->entries = grown;
        list->capacity = 2 * list->capacity + 4;
    }
    QN_TRY(read_description(source, list->entries + list->count, error));
    ++list->count;
    return QN_OK;
}

/* Read a segment's descriptions; *more_out is false at the end of the file. */
static qn_status read_segment(qni_source *source, grid_list *list, bool *more_out,
                              qn_error *error) {
    unsigned char bytes[SEGMENT_HEADER];
    const unsigned char *seen;
    int64_t found;
    *more_out = false;
    QN_TRY(qni_source_peek(source, 1, &seen, &found, error));
    if (found == 0)
        return QN_OK;
    QN_TRY(qni_source_read(source, bytes, SEGMENT_HEADER, error));
    if (number_at(bytes, 8) != magic_number)
        return qni_source_fail(source, error, "a segment does not begin with NanoVDB's mark");
    const int count = (int)number_at(bytes + 12, 2);
    for (int n = 0; n < count; ++n)
        QN_TRY(append(source, list, error));
    *more_out = true;
    return QN_OK;
}

/* Walk over the file; stops in front of grid `wanted`, unless that is -1. */
static qn_status walk_file(qni_source *source, int32_t wanted, grid_list *list, qn_error *error) {
    bool more = true;
    for (int32_t next = 0; more;) {
        QN_TRY(read_segment(source, list, &more, error));
        for (; next < list->count; ++next) {
            if (next == wanted)
                return QN_OK;
            QN_TRY(qni_source_skip(source, list->entries[next].file_size, error));
        }
    }
    return QN_OK;
}

/* ---- bytes of a grid ------------------------------------------------------------------------- */

/* Read a packed piece, its length before it, into memory of *length_out bytes. */
static qn_status read_packed(qni_source *source, int64_t unpacked, unsigned char **packed_out,
                             int64_t *length_out, qn_error *error) {
    unsigned char bytes[8];
    QN_TRY(qni_source_read(source, bytes, 8, error));
    const uint64_t length = number_at(bytes, 8);
    if (length > (uint64_t)qni_source_bound(source) || length > (uint64_t)INT32_MAX * 2 ||
        unpacked / LARGEST_RATIO > (int64_t)length)
        return qni_source_fail(source, error, "%llu packed bytes for %lld of a grid make no sense",
                               (unsigned long long)length, (long long)unpacked);
    *length_out = (int64_t)length;
    *packed_out = qni_alloc(source->context, *length_out, 1);
    if (!*packed_out)
        return qni_fail_memory(error, "packed bytes of a grid");
    const qn_status status = qni_source_read(source, *packed_out, *length_out, error);
    if (status != QN_OK)
        qni_free(source->context, *packed_out, *length_out, 1);
    return status;
}

static bool unpack_zip(const unsigned char *packed, int64_t length, unsigned char *to,
                       int64_t size) {
    uLongf got = (uLongf)size;
    return uncompress(to, &got, packed, (uLong)length) == Z_OK && (int64_t)got == size;
}

static bool unpack_blosc(const unsigned char *packed, int64_t length, unsigned char *to,
                         int64_t size) {
#if QNI_HAVE_BLOSC
    size_t unpacked = 0;
    if (blosc_cbuffer_validate(packed, (size_t)length, &unpacked) < 0 || unpacked != (size_t)size)
        return false;
    return blosc_decompress_ctx(packed, to, (size_t)size, 1) == size;
#else
    (void)packed;
    (void)length;
    (void)to;
    (void)size;
    return false;
#endif
}

static qn_status read_pieces(qni_source *source, const grid_entry *entry, unsigned char *to,
                             qn_error *error) {
    const bool blosc = entry->codec == CODEC_BLOSC;
    for (int64_t done = 0; done < entry->grid_size;) {
        const int64_t left = entry->grid_size - done;
        const int64_t size = blosc && left > blosc_piece ? blosc_piece : left;
        unsigned char *packed = NULL;
        int64_t length = 0;
        QN_TRY(read_packed(source, size, &packed, &length, error));
        const bool good = blosc ? unpack_blosc(packed, length, to + done, size)
                                : unpack_zip(packed, length, to + done, size);
        qni_free(source->context, packed, length, 1);
        if (!good)
            return qni_source_fail(source, error, "the %s data of grid '%s' are damaged",
                                   blosc ? "blosc" : "zip", entry->info.name);
        done += size;
    }
    return QN_OK;
}

static qn_status check_entry(qni_source *source, const grid_entry *entry, qn_error *error) {
    if (entry->codec > CODEC_BLOSC)
        return qni_source_fail(source, error, "grid '%s' is packed by an unknown codec, %u",
                               entry->info.name, (unsigned)entry->codec);
    if (entry->codec == CODEC_BLOSC && !QNI_HAVE_BLOSC)
        return qni_source_fail_as(source, QN_ERROR_UNSUPPORTED, error,
                                  "grid '%s' is packed by blosc, which this build lacks: install "
                                  "libblosc-dev and build again",
                                  entry->info.name);
    const int64_t bound = qni_source_bound(source);
    if (entry->codec == CODEC_NONE ? entry->grid_size > bound
                                   : entry->grid_size / LARGEST_RATIO > bound)
        return qni_source_fail(source, error,
                               "grid '%s' is said to be %lld bytes long, but only %lld are left",
                               entry->info.name, (long long)entry->grid_size, (long long)bound);
    return QN_OK;
}

static qn_status load_entry(qni_source *source, const grid_entry *entry,
                            const qn_volume_read_options *options, qn_volume **volume_out,
                            qn_error *error) {
    QN_TRY(check_entry(source, entry, error));
    unsigned char *bytes = qni_alloc(source->context, entry->grid_size, 1);
    if (!bytes)
        return qni_fail_memory(error, "a NanoVDB grid");
    qn_status status = entry->codec == CODEC_NONE
                           ? qni_source_read(source, bytes, entry->grid_size, error)
                           : read_pieces(source, entry, bytes, error);
    if (status == QN_OK)
        status = qni_nvdb_load(source, bytes, entry->grid_size, entry->info.name, options,
                               volume_out, error);
    qni_free(source->context, bytes, entry->grid_size, 1);
    return status;
}

/* ---- files ----------------------------------------------------------------------------------- */

/* Sources run from front to back only: go on from the beginning with another one. */
static qn_status open_again(const qni_source *source, qni_source *again, qn_error *error) {
    return source->in_memory
               ? qni_source_open_memory(source->context, source->path, source->raw.bytes,
                                        source->raw.end, again, error)
               : qni_source_open(source->context, source->path, again, error);
}

static void free_list(const qni_source *source, grid_list *list) {
    qni_free(source->context, list->entries, list->capacity, sizeof *list->entries);
}

static qn_status choose(qni_source *source, const grid_list *list, const char *wanted,
                        int32_t *chosen, qn_error *error) {
    qn_grid_info *infos = qni_alloc(source->context, list->count, sizeof *infos);
    if (!infos)
        return qni_fail_memory(error, "the list of grids");
    for (int32_t n = 0; n < list->count; ++n)
        infos[n] = list->entries[n].info;
    const qn_status status = qni_choose_grid(source, infos, list->count, wanted, chosen, error);
    qni_free(source->context, infos, list->count, sizeof *infos);
    return status;
}

static qn_status load_chosen(const qni_source *source, int32_t chosen,
                             const qn_volume_read_options *options, qn_volume **volume_out,
                             qn_error *error) {
    grid_list list = {NULL, 0, 0};
    qni_source again;
    QN_TRY(open_again(source, &again, error));
    qn_status status = walk_file(&again, chosen, &list, error);
    if (status == QN_OK && chosen >= list.count)
        status = qni_source_fail(source, error, "changed while it was read");
    if (status == QN_OK)
        status = load_entry(&again, list.entries + chosen, options, volume_out, error);
    free_list(&again, &list);
    qni_source_close(&again);
    return status;
}

qn_status qni_read_nvdb(qni_source *source, const qn_volume_read_options *options,
                        qn_volume **volume_out, qn_error *error) {
    grid_list list = {NULL, 0, 0};
    int32_t chosen = 0;
    qn_status status = walk_file(source, -1, &list, error);
    if (status == QN_OK)
        status = choose(source, &list, options->grid, &chosen, error);
    free_list(source, &list);
    return status == QN_OK ? load_chosen(source, chosen, options, volume_out, error) : status;
}

qn_status qni_list_nvdb(qni_source *source, qn_grid_info *infos_out, int32_t capacity,
                        int32_t *count_out, qn_error *error) {
    grid_list list = {NULL, 0, 0};
    const qn_status status = walk_file(source, -1, &list, error);
    for (int32_t n = 0; status == QN_OK && n < list.count && n < capacity; ++n)
        infos_out[n] = list.entries[n].info;
    *count_out = status == QN_OK ? list.count : 0;
    free_list(source, &list);
    return status;
}

#else

static qn_status fail_absent(const qni_source *source, qn_error *error) {
    return qni_source_fail_as(source, QN_ERROR_UNSUPPORTED, error,
                              "this build does not read NanoVDB files: install libnanovdb-dev and "
                              "build with -Dnanovdb=enabled");
}

qn_status qni_read_nvdb(qni_source *source, const qn_volume_read_options *options,
                        qn_volume **volume_out, qn_error *error) {
    (void)options;
    (void)volume_out;
    return fail_absent(source, error);
}

qn_status qni_list_nvdb(qni_source *source, qn_grid_info *infos_out, int32_t capacity,
                        int32_t *count_out, qn_error *error) {
    (void)infos_out;
    (void)capacity;
    *count_out = 0;
    return fail_absent(source, error);
}

#endif
