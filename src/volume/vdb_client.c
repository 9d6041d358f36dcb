// SPDX-License-Identifier: MIT
/* Requests to quoin-vdb and its answers. A damaged file can have turned the program's memory into
 * anything, so counts are held against the file's size, and texts, flags and types are checked. */
#include "volume/vdb_client.h"

#include <stdio.h>
#include <string.h>

/* Bytes that a leaf needs in a file at least: its active mask. A node of tiles needs a bit and more
 * for each of them. */
enum { LEAF_BYTES = 64, TILES_A_BYTE = 8 };

static qni_vdb_result ask(qni_vdb_process *process, qni_vdb_kind kind, int64_t count) {
    const qni_vdb_frame frame = {QNI_VDB_MARK, kind, count};
    return qni_vdb_process_send(process, &frame, sizeof frame);
}

static qni_vdb_result fail_nonsense(qni_vdb_process *process) {
    return qni_vdb_process_fail(process, QNI_VDB_STOPPED, "it said what makes no sense");
}

static qni_vdb_result get_frame(qni_vdb_process *process, qni_vdb_frame *frame) {
    if (qni_vdb_process_receive(process, frame, sizeof *frame) != QNI_VDB_OK)
        return process->result;
    if (frame->mark != QNI_VDB_MARK)
        return qni_vdb_process_fail(process, QNI_VDB_ABSENT,
                                    "the program quoin-vdb is of another version than this one; "
                                    "install both again");
    return QNI_VDB_OK;
}

/* One line of printable text, whatever came. */
static void settle_text(char *text, size_t room) {
    text[room - 1] = 0;
    for (char *at = text; *at; ++at)
        if ((unsigned char)*at < 32)
            *at = ' ';
}

/* The rest of an answer whose frame was read. */
static qni_vdb_result get_answer(qni_vdb_process *process, const qni_vdb_frame *frame) {
    qni_vdb_wire_answer answer;
    if (frame->kind != QNI_VDB_ANSWER)
        return fail_nonsense(process);
    if (qni_vdb_process_receive(process, &answer, sizeof answer) != QNI_VDB_OK)
        return process->result;
    settle_text(answer.text, sizeof process->message->text);
    if (answer.result == QNI_VDB_OK)
        return QNI_VDB_OK;
    if (answer.result == QNI_VDB_NO_MEMORY && process->seconds_allowed > 0)
        return qni_vdb_process_fail(process, QNI_VDB_STOPPED,
                                    "it would take more than %lld MB of memory",
                                    (long long)(qni_vdb_bytes_allowed(process->file_bytes) >> 20));
    return qni_vdb_process_fail(
        process, answer.result == QNI_VDB_NO_MEMORY ? QNI_VDB_NO_MEMORY : QNI_VDB_BAD_FILE, "%s",
        answer.text);
}

/* Ask for something and read the answer; `count_out` may be NULL. */
static qni_vdb_result converse(qni_vdb_process *process, qni_vdb_kind kind, int64_t count,
                               int64_t *count_out) {
    qni_vdb_frame frame;
    if (ask(process, kind, count) != QNI_VDB_OK || get_frame(process, &frame) != QNI_VDB_OK)
        return process->result;
    if (count_out)
        *count_out = frame.count;
    return get_answer(process, &frame);
}

/* ---- reading --------------------------------------------------------------------------------- */

qni_vdb_result qni_vdb_client_open(qni_vdb_process *process, qn_context *context, const char *path,
                                   int32_t *grid_count_out, qni_vdb_message *message) {
    int64_t count = 0;
    *grid_count_out = 0;
    if (qni_vdb_process_start(process, context, path, true, message) != QNI_VDB_OK ||
        converse(process, QNI_VDB_ASK_OPEN, 0, &count) != QNI_VDB_OK)
        return process->result;
    if (count < 0 || count > process->file_bytes || count > INT32_MAX)
        return fail_nonsense(process);
    *grid_count_out = (int32_t)count;
    return QNI_VDB_OK;
}

qni_vdb_result qni_vdb_client_describe(qni_vdb_process *process, int32_t grid,
                                       qni_vdb_grid *grid_out) {
    qni_vdb_wire_grid wire;
    memset(grid_out, 0, sizeof *grid_out);
    if (converse(process, QNI_VDB_ASK_DESCRIBE, grid, NULL) != QNI_VDB_OK ||
        qni_vdb_process_receive(process, &wire, sizeof wire) != QNI_VDB_OK)
        return process->result;
    if (wire.kind < QN_SPARSE_UNKNOWN || wire.kind > QN_SPARSE_FOG || wire.scalar < 0 ||
        wire.scalar >= QN_SCALAR_COUNT)
        return fail_nonsense(process);
    settle_text(wire.name, sizeof wire.name);
    settle_text(wire.type, sizeof wire.type);
    memcpy(grid_out->info.name, wire.name, sizeof wire.name);
    memcpy(grid_out->info.type, wire.type, sizeof wire.type);
    grid_out->info.kind = (qn_sparse_class)wire.kind;
    grid_out->info.half = wire.half != 0;
    grid_out->info.frustum = wire.frustum != 0;
    grid_out->info.readable = wire.readable != 0;
    grid_out->scalar = (qn_scalar)wire.scalar;
    memcpy(grid_out->index_to_world, wire.index_to_world, sizeof wire.index_to_world);
    return QNI_VDB_OK;
}

qni_vdb_result qni_vdb_client_load(qni_vdb_process *process, int32_t grid,
                                   qni_vdb_counts *counts_out) {
    memset(counts_out, 0, sizeof *counts_out);
    if (converse(process, QNI_VDB_ASK_LOAD, grid, NULL) != QNI_VDB_OK ||
        qni_vdb_process_receive(process, counts_out, sizeof *counts_out) != QNI_VDB_OK)
        return process->result;
    if (counts_out->leaf_count < 0 || counts_out->tile_count < 0 ||
        counts_out->leaf_count > process->file_bytes / LEAF_BYTES ||
        counts_out->tile_count / TILES_A_BYTE > process->file_bytes)
        return fail_nonsense(process);
    return QNI_VDB_OK;
}

static void receive_leaves(qni_vdb_process *process, qni_sparse_arrays *arrays, int64_t first,
                           int64_t count) {
    const size_t number = (size_t)count;
    qni_vdb_process_receive(process, arrays->origins + first, number * sizeof *arrays->origins);
    qni_vdb_process_receive(process, arrays->masks + first, number * sizeof *arrays->masks);
    qni_vdb_process_receive(process, (char *)arrays->values + (size_t)first * arrays->value_bytes,
                            number * arrays->value_bytes);
}

static void receive_tiles(qni_vdb_process *process, qn_sparse_tile *tiles, int64_t count) {
    for (int64_t n = 0; n < count; ++n) {
        qni_vdb_wire_tile wire;
        if (qni_vdb_process_receive(process, &wire, sizeof wire) != QNI_VDB_OK)
            return;
        memset(tiles + n, 0, sizeof *tiles);
        memcpy(tiles[n].origin, wire.origin, sizeof wire.origin);
        memcpy(tiles[n].size, wire.size, sizeof wire.size);
        tiles[n].value = wire.value;
        tiles[n].active = wire.active != 0;
    }
}

qni_vdb_result qni_vdb_client_take(qni_vdb_process *process, qni_sparse_arrays *arrays) {
    int64_t leaves = 0, tiles = 0;
    ask(process, QNI_VDB_ASK_TAKE, 0);
    while (process->result == QNI_VDB_OK) {
        qni_vdb_frame frame;
        const int64_t count = get_frame(process, &frame) == QNI_VDB_OK ? frame.count : 0;
        if (process->result != QNI_VDB_OK)
            break;
        if (frame.kind == QNI_VDB_LEAVES && count >= 0 && count <= arrays->leaf_count - leaves) {
            receive_leaves(process, arrays, leaves, count);
            leaves += count;
        } else if (frame.kind == QNI_VDB_TILES && count >= 0 &&
                   count <= arrays->tile_count - tiles) {
            receive_tiles(process, arrays->tiles + tiles, count);
            tiles += count;
        } else if (get_answer(process, &frame) == QNI_VDB_OK)
            return leaves == arrays->leaf_count && tiles == arrays->tile_count
                       ? QNI_VDB_OK
                       : fail_nonsense(process);
        process->fraction = arrays->leaf_count ? (double)leaves / (double)arrays->leaf_count : 0;
    }
    return process->result;
}

/* ---- writing --------------------------------------------------------------------------------- */

static void send_head(qni_vdb_process *process, const qn_sparse_grid *grid) {
    qni_vdb_wire_head head = {.kind = (int32_t)grid->kind,
                              .has_masks = grid->masks != NULL,
                              .background = grid->background};
    memcpy(head.name, grid->name, sizeof head.name);
    memcpy(head.index_to_world, grid->index_to_world, sizeof head.index_to_world);
    ask(process, QNI_VDB_ASK_WRITE, 1);
    qni_vdb_process_send(process, &head, sizeof head);
}

static void send_tiles(qni_vdb_process *process, const qn_sparse_tile *tiles, int64_t count) {
    ask(process, QNI_VDB_TILES, count);
    for (int64_t n = 0; n < count && process->result == QNI_VDB_OK; ++n) {
        qni_vdb_wire_tile wire = {.value = tiles[n].value, .active = tiles[n].active};
        memcpy(wire.origin, tiles[n].origin, sizeof wire.origin);
        memcpy(wire.size, tiles[n].size, sizeof wire.size);
        qni_vdb_process_send(process, &wire, sizeof wire);
    }
}

static void send_leaves(qni_vdb_process *process, const qn_sparse_grid *grid) {
    const size_t leaf = 512 * sizeof(float);
    for (int64_t n = 0; n < grid->leaf_count && process->result == QNI_VDB_OK; n += QNI_VDB_BATCH) {
        const int64_t left = grid->leaf_count - n;
        const size_t count = (size_t)(left < QNI_VDB_BATCH ? left : QNI_VDB_BATCH);
        ask(process, QNI_VDB_LEAVES, (int64_t)count);
        qni_vdb_process_send(process, grid->origins + n, count * sizeof *grid->origins);
        if (grid->masks)
            qni_vdb_process_send(process, grid->masks + n, count * sizeof *grid->masks);
        qni_vdb_process_send(process, (const char *)grid->values + (size_t)n * leaf, count * leaf);
        process->fraction = (double)n / (double)grid->leaf_count;
    }
}

qni_vdb_result qni_vdb_client_write(qn_context *context, const char *path,
                                    const qn_sparse_grid *grid, const qn_sparse_tile *fill,
                                    int64_t fill_count, qni_vdb_message *message) {
    qni_vdb_process process;
    if (qni_vdb_process_start(&process, context, path, false, message) == QNI_VDB_OK) {
        send_head(&process, grid);
        send_tiles(&process, fill, fill_count);
        send_tiles(&process, grid->tiles, grid->tile_count);
        send_leaves(&process, grid);
        converse(&process, QNI_VDB_ASK_FINISH, 0, NULL);
    }
    qni_vdb_process_end(&process);
    return process.result;
}
