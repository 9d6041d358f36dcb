// SPDX-License-Identifier: MIT
/* The inner loops, built with AVX2. */
#define KERNEL_NAME qni_point_kernel_avx2
#include "dmc/kernel_body.h"
