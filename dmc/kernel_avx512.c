// SPDX-License-Identifier: MIT
/* The inner loops, built with AVX-512. */
#define KERNEL_NAME qni_point_kernel_avx512
#include "dmc/kernel_body.h"
