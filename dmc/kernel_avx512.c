// SPDX-License-Identifier: MIT
/* The inner loops, built with AVX-512. */
#define KERNEL(name) name##_avx512
#include "dmc/kernel_body.h"
#include "dmc/landing_body.h"
#include "dmc/packing_body.h"
