// SPDX-License-Identifier: MIT
/* The inner loops, built with AVX2. */
#define KERNEL(name) name##_avx2
#include "dmc/kernel_body.h"
#include "dmc/landing_body.h"
#include "dmc/packing_body.h"
