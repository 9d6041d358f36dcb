// SPDX-License-Identifier: MIT
/* What the library and its program quoin-vdb say to each other over a socket: frames, each with a
 * number of items of one kind behind it. Both run on one machine and come from one build: numbers
 * are in the machine's own order, and the mark at the front tells another order or version. */
#ifndef QNI_VOLUME_VDB_WIRE_H
#define QNI_VOLUME_VDB_WIRE_H

#include <stdint.h>

enum {
    QNI_VDB_MARK = 0x51564401, /* its last byte counts versions */
    QNI_VDB_SOCKET = 0,        /* descriptors of the program: what it talks over ... */
    QNI_VDB_FILE = 3,          /* ... and the file that is read or written */
    QNI_VDB_BATCH = 64         /* leaves in a frame at most */
};

typedef enum qni_vdb_kind {
    QNI_VDB_ASK_OPEN,     /* answer, then a count of grids in `count` */
    QNI_VDB_ASK_DESCRIBE, /* of grid `count`; an answer, one qni_vdb_wire_grid when it is good */
    QNI_VDB_ASK_LOAD,     /* of grid `count`; an answer, one qni_vdb_counts when it is good */
    QNI_VDB_ASK_TAKE,     /* leaves and tiles as frames, then an answer */
    QNI_VDB_ASK_WRITE,    /* one qni_vdb_wire_head follows, then tiles and leaves; no answer yet */
    QNI_VDB_ASK_FINISH,   /* write what came; an answer */
    QNI_VDB_LEAVES,       /* `count` origins, their masks, their values */
    QNI_VDB_TILES,        /* `count` of qni_vdb_wire_tile */
    QNI_VDB_ANSWER        /* `count`: of grids; a qni_vdb_wire_answer follows */
} qni_vdb_kind;

typedef struct qni_vdb_frame {
    uint32_t mark, kind;
    int64_t count;
} qni_vdb_frame;

typedef struct qni_vdb_wire_answer {
    int32_t result; /* qni_vdb_result */
    char text[204];
} qni_vdb_wire_answer;

typedef struct qni_vdb_wire_grid {
    char name[64], type[32];
    int32_t kind, half, frustum, readable, scalar, unused;
    double index_to_world[4][4];
} qni_vdb_wire_grid;

typedef struct qni_vdb_wire_tile {
    int32_t origin[3], size[3];
    double value;
    int64_t active;
} qni_vdb_wire_tile;

typedef struct qni_vdb_wire_head { /* of a grid to be written; leaves are of f32 */
    char name[64];
    int32_t kind, has_masks;
    double background;
    double index_to_world[4][4];
} qni_vdb_wire_head;

/* Seconds of processor time that reading a file may take, and bytes of memory. A good file takes a
 * few milliseconds a megabyte. The largest node, 32^3 tiles of doubles, needs 8 KB in a file and
 * 264 KB in memory, so 64 times the size is ample. */
static inline int64_t qni_vdb_seconds_allowed(int64_t file_bytes) {
    return 10 + file_bytes / 5000000;
}
static inline int64_t qni_vdb_bytes_allowed(int64_t file_bytes) {
    return (INT64_C(1) << 30) +
           64 * (file_bytes < INT64_C(1) << 50 ? file_bytes : INT64_C(1) << 50);
}

#endif
