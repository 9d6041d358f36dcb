// SPDX-License-Identifier: MIT
#ifndef TEST_LEVEL_SET_H
#define TEST_LEVEL_SET_H

#include "lib/support.h"

/* A ball as a sparse level set: distances in leaves of 8^3 samples, 16 2/3 samples to the radius.
 */
qn_volume *test_ball_level_set(qn_context *context, const double centre[3], double radius);
/* What lies within its surface; the volume is borrowed. */
qn_solid *test_level_set_solid(qn_context *context, const qn_volume *volume, int32_t owner);

#endif
