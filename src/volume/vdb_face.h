// SPDX-License-Identifier: MIT
/* What both sides of the socket between the library and quoin-vdb know of OpenVDB files: results,
 * messages, what a grid is and what it holds. */
#ifndef QNI_VOLUME_VDB_FACE_H
#define QNI_VOLUME_VDB_FACE_H

#include <qn/volume.h>

typedef enum qni_vdb_result {
    QNI_VDB_OK,
    QNI_VDB_BAD_FILE,
    QNI_VDB_NO_MEMORY,
    /* the library's side alone: */
    QNI_VDB_STOPPED,  /* the program ended, or broke the rules of vdb_wire.h */
    QNI_VDB_ABSENT,   /* there is no program, or not the right one */
    QNI_VDB_CANCELLED /* progress asked to stop */
} qni_vdb_result;
typedef struct qni_vdb_message {
    char text[200];
} qni_vdb_message;

/* What the file says of a grid without reading its tree. */
typedef struct qni_vdb_grid {
    qn_grid_info info;
    qn_scalar scalar; /* of info.readable grids */
    double index_to_world[4][4];
} qni_vdb_grid;

typedef struct qni_vdb_counts {
    int64_t leaf_count, tile_count;
    double background;
} qni_vdb_counts;

#endif
