// SPDX-License-Identifier: MIT
/* What exact distances tell of the sides of a leaf's samples: a sample's ball holds no surface, so
 * neighbours of which one lies in the other's ball are on one side. */
#ifndef QNI_BAND_LEAF_H
#define QNI_BAND_LEAF_H

#include "band/band.h"

/* Regions of samples that are on one side for sure: of each sample its region, of each region its
 * first sample. Returns their number. */
int qni_leaf_regions(const double distances[QNI_BAND_SAMPLES], double voxel,
                     int16_t regions[QNI_BAND_SAMPLES], int16_t first[QNI_BAND_SAMPLES]);
/* Pairs of such neighbours that are said to be on two sides. */
int64_t qni_leaf_tears(const double distances[QNI_BAND_SAMPLES], double voxel,
                       const bool inside[QNI_BAND_SAMPLES]);

#endif
