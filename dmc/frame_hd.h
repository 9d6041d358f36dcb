// SPDX-License-Identifier: MIT
/* How a lattice lies in the world. */
#ifndef QNI_DMC_FRAME_HD_H
#define QNI_DMC_FRAME_HD_H

/* Samples that decide the place and the normal of one vertex: place_hd.h. */
enum { QNI_STENCIL = 32 };

/* Lattice to world for points, and for gradients with the sign that turns them outward. */
typedef struct qni_frame {
    double world[3][4];
    double normal[3][3];
} qni_frame;

#endif
