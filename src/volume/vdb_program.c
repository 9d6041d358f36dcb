// SPDX-License-Identifier: MIT
/* quoin-vdb: reads and writes OpenVDB files for the library, in a process of its own, where
 * OpenVDB's assertions, loops and appetite for memory on damaged files end nobody else. Not for
 * people: it talks frames (vdb_wire.h) over a socket that the library gives it. */
#include "volume/vdb_shim.h"
#include "volume/vdb_wire.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>
#ifdef __linux__
#define FILE_PATH "/proc/self/fd/3"
#else
#define FILE_PATH "/dev/fd/3"
#endif

/* ---- the socket: when the other side is gone, so is the work --------------------------------- */

static void get(void *bytes, size_t size) {
    while (size > 0) {
        const ssize_t got = read(QNI_VDB_SOCKET, bytes, size);
        if (got == 0 || (got < 0 && errno != EINTR))
            _exit(0);
        bytes = (char *)bytes + (got > 0 ? got : 0);
        size -= (size_t)(got > 0 ? got : 0);
    }
}

static void put(const void *bytes, size_t size) {
    while (size > 0) {
        const ssize_t gone = write(QNI_VDB_SOCKET, bytes, size);
        if (gone < 0 && errno != EINTR)
            _exit(0);
        bytes = (const char *)bytes + (gone > 0 ? gone : 0);
        size -= (size_t)(gone > 0 ? gone : 0);
    }
}

static void put_frame(qni_vdb_kind kind, int64_t count) {
    const qni_vdb_frame frame = {QNI_VDB_MARK, kind, count};
    put(&frame, sizeof frame);
}

static void put_answer(qni_vdb_result result, const qni_vdb_message *message, int64_t count) {
    qni_vdb_wire_answer answer = {.result = (int32_t)result};
    memcpy(answer.text, message->text, sizeof message->text);
    put_frame(QNI_VDB_ANSWER, count);
    put(&answer, sizeof answer);
}

/* ---- limits ---------------------------------------------------------------------------------- */

static void limit(int resource, int64_t most) {
    struct rlimit now;
    if (getrlimit(resource, &now) != 0)
        return;
    const rlim_t wanted = (rlim_t)most;
    now.rlim_cur = now.rlim_cur == RLIM_INFINITY || now.rlim_cur > wanted ? wanted : now.rlim_cur;
    setrlimit(resource, &now);
}

#ifdef __SANITIZE_ADDRESS__
/* The sanitizer reserves terabytes of addresses, so a limit on addresses would end it at once: what
 * is resident is looked at instead, a hundred times a second. */
static int64_t most_resident;

static void end_beyond_limit(int unused) {
    char text[96] = "";
    const int kept = errno, descriptor = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    (void)unused;
    if (descriptor >= 0) {
        if (read(descriptor, text, sizeof text - 1) > 0 && strchr(text, ' ') &&
            strtoll(strchr(text, ' '), NULL, 10) * (int64_t)sysconf(_SC_PAGESIZE) > most_resident)
            _exit(1);
        close(descriptor);
    }
    errno = kept;
}

static void limit_memory(int64_t most) {
    const struct itimerval often = {{0, 10000}, {0, 10000}};
    struct sigaction action = {.sa_flags = SA_RESTART};
    action.sa_handler = end_beyond_limit;
    most_resident = most;
    sigaction(SIGALRM, &action, NULL);
    setitimer(ITIMER_REAL, &often, NULL);
}
#else
static void limit_memory(int64_t most) {
    limit(RLIMIT_AS, most);
}
#endif

static void limit_reading(void) {
    struct stat status;
    const int64_t size = fstat(QNI_VDB_FILE, &status) == 0 ? (int64_t)status.st_size : 0;
    const int64_t machine = (int64_t)sysconf(_SC_PHYS_PAGES) * (int64_t)sysconf(_SC_PAGESIZE);
    const int64_t bytes = qni_vdb_bytes_allowed(size);
    limit(RLIMIT_CPU, qni_vdb_seconds_allowed(size));
    limit_memory(machine > 0 && machine < bytes ? machine : bytes);
}

static void set_up(void) {
    limit(RLIMIT_CORE, 1);   /* no core file, and unlike 0 no pipe to a program that keeps them */
    signal(SIGINT, SIG_IGN); /* the terminal sends it to both: the library decides */
}

/* ---- reading --------------------------------------------------------------------------------- */

typedef struct batch { /* pieces of a tree on their way */
    int64_t leaf_count, tile_count;
    size_t value_bytes;
    int32_t origins[QNI_VDB_BATCH][3];
    uint64_t masks[QNI_VDB_BATCH][8];
    double values[QNI_VDB_BATCH][512]; /* of value_bytes each, close together */
    qni_vdb_wire_tile tiles[QNI_VDB_BATCH];
} batch;

static void put_leaves(batch *to) {
    const size_t count = (size_t)to->leaf_count;
    if (count == 0)
        return;
    put_frame(QNI_VDB_LEAVES, to->leaf_count);
    put(to->origins, count * sizeof to->origins[0]);
    put(to->masks, count * sizeof to->masks[0]);
    put(to->values, count * 512 * to->value_bytes);
    to->leaf_count = 0;
}

static void put_tiles(batch *to) {
    if (to->tile_count == 0)
        return;
    put_frame(QNI_VDB_TILES, to->tile_count);
    put(to->tiles, (size_t)to->tile_count * sizeof to->tiles[0]);
    to->tile_count = 0;
}

static bool take_leaf(void *user, const int32_t origin[3], const uint64_t mask[8],
                      const void *values, size_t value_bytes) {
    batch *to = user;
    const size_t at = (size_t)to->leaf_count++;
    to->value_bytes = value_bytes;
    memcpy(to->origins[at], origin, sizeof to->origins[0]);
    memcpy(to->masks[at], mask, sizeof to->masks[0]);
    memcpy((char *)to->values + at * 512 * value_bytes, values, 512 * value_bytes);
    if (to->leaf_count == QNI_VDB_BATCH)
        put_leaves(to);
    return true;
}

static bool take_tile(void *user, const qn_sparse_tile *tile) {
    batch *to = user;
    qni_vdb_wire_tile *out = to->tiles + to->tile_count++;
    *out = (qni_vdb_wire_tile){.value = tile->value, .active = tile->active};
    memcpy(out->origin, tile->origin, sizeof out->origin);
    memcpy(out->size, tile->size, sizeof out->size);
    if (to->tile_count == QNI_VDB_BATCH)
        put_tiles(to);
    return true;
}

static void answer_take(qni_vdb *file) {
    static batch pieces;
    qni_vdb_message message;
    const qni_vdb_sink sink = {take_leaf, take_tile, &pieces};
    const qni_vdb_result result = qni_vdb_take(file, &sink, &message);
    put_leaves(&pieces);
    put_tiles(&pieces);
    put_answer(result, &message, 0);
}

static void answer_describe(qni_vdb *file, int32_t n) {
    qni_vdb_grid grid;
    qni_vdb_message message;
    const qni_vdb_result result = qni_vdb_describe(file, n, &grid, &message);
    put_answer(result, &message, 0);
    if (result != QNI_VDB_OK)
        return;
    qni_vdb_wire_grid wire = {.kind = grid.info.kind,
                              .half = grid.info.half,
                              .frustum = grid.info.frustum,
                              .readable = grid.info.readable,
                              .scalar = grid.scalar};
    memcpy(wire.name, grid.info.name, sizeof wire.name);
    memcpy(wire.type, grid.info.type, sizeof wire.type);
    memcpy(wire.index_to_world, grid.index_to_world, sizeof wire.index_to_world);
    put(&wire, sizeof wire);
}

static void answer_load(qni_vdb *file, int32_t n) {
    qni_vdb_counts counts;
    qni_vdb_message message;
    const qni_vdb_result result = qni_vdb_load(file, n, &counts, &message);
    put_answer(result, &message, 0);
    if (result == QNI_VDB_OK)
        put(&counts, sizeof counts);
}

/* ---- writing: what fails is kept, and told at the end -----------------------------------------
 */

typedef struct writing {
    qni_vdb *file;
    qni_vdb_result result;
    qni_vdb_message message;
    bool has_masks;
} writing;

static void begin(writing *to) {
    qni_vdb_wire_head head;
    get(&head, sizeof head);
    qn_sparse_grid grid = {.kind = (qn_sparse_class)head.kind, .background = head.background};
    memcpy(grid.name, head.name, sizeof grid.name);
    memcpy(grid.index_to_world, head.index_to_world, sizeof grid.index_to_world);
    to->has_masks = head.has_masks != 0;
    to->result = qni_vdb_begin(&grid, &to->file, &to->message);
}

static void get_tiles(writing *to, int64_t count) {
    for (int64_t n = 0; n < count; ++n) {
        qni_vdb_wire_tile wire;
        get(&wire, sizeof wire);
        qn_sparse_tile tile = {.value = wire.value, .active = wire.active != 0};
        memcpy(tile.origin, wire.origin, sizeof tile.origin);
        memcpy(tile.size, wire.size, sizeof tile.size);
        if (to->result == QNI_VDB_OK)
            to->result = qni_vdb_put_tile(to->file, &tile, &to->message);
    }
}

static void get_leaves(writing *to, int64_t count) {
    static int32_t origins[QNI_VDB_BATCH][3];
    static uint64_t masks[QNI_VDB_BATCH][8];
    static float values[QNI_VDB_BATCH][512];
    get(origins, (size_t)count * sizeof origins[0]);
    if (to->has_masks)
        get(masks, (size_t)count * sizeof masks[0]);
    get(values, (size_t)count * sizeof values[0]);
    for (int64_t n = 0; n < count && to->result == QNI_VDB_OK; ++n)
        to->result = qni_vdb_put_leaf(to->file, origins[n], to->has_masks ? masks[n] : NULL,
                                      values[n], &to->message);
}

/* ---- requests -------------------------------------------------------------------------------- */

static void answer_open(qni_vdb **file) {
    qni_vdb_message message;
    limit_reading();
    const qni_vdb_result result = qni_vdb_open(FILE_PATH, file, &message);
    put_answer(result, &message, result == QNI_VDB_OK ? qni_vdb_grid_count(*file) : 0);
}

/* False for a request that makes no sense here. */
static bool answer(const qni_vdb_frame *frame, qni_vdb **file, writing *to) {
    const bool is_grid =
        *file && frame->count >= 0 && !to->file && frame->count < qni_vdb_grid_count(*file);
    if (frame->mark != QNI_VDB_MARK)
        return false;
    if (frame->kind == QNI_VDB_ASK_OPEN && !*file)
        answer_open(file);
    else if (frame->kind == QNI_VDB_ASK_DESCRIBE && is_grid)
        answer_describe(*file, (int32_t)frame->count);
    else if (frame->kind == QNI_VDB_ASK_LOAD && is_grid)
        answer_load(*file, (int32_t)frame->count);
    else if (frame->kind == QNI_VDB_ASK_TAKE && *file)
        answer_take(*file);
    else if (frame->kind == QNI_VDB_ASK_WRITE && !*file)
        begin(to);
    else if (frame->kind == QNI_VDB_TILES)
        get_tiles(to, frame->count);
    else if (frame->kind == QNI_VDB_LEAVES && frame->count >= 0 && frame->count <= QNI_VDB_BATCH)
        get_leaves(to, frame->count);
    else if (frame->kind == QNI_VDB_ASK_FINISH) {
        if (to->result == QNI_VDB_OK)
            to->result = qni_vdb_finish(to->file, FILE_PATH, &to->message);
        put_answer(to->result, &to->message, 0);
    } else
        return false;
    return true;
}

int main(void) {
    qni_vdb *file = NULL;
    writing to = {NULL, QNI_VDB_BAD_FILE, {"nothing was begun"}, false};
    struct stat status;
    qni_vdb_frame frame;
    if (fstat(QNI_VDB_SOCKET, &status) != 0 || !S_ISSOCK(status.st_mode)) {
        fprintf(stderr,
                "quoin-vdb: reads OpenVDB files for quoin; it is not to be started by hand\n");
        return 2;
    }
    set_up();
    do
        get(&frame, sizeof frame);
    while (answer(&frame, &file, &to));
    return 1;
}
