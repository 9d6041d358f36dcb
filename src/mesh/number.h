// SPDX-License-Identifier: MIT
/* Numbers as text, whatever the locale: floats that read back to the same bits, fast parsing. */
#ifndef QNI_MESH_NUMBER_H
#define QNI_MESH_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

enum { QNI_NUMBER_LENGTH = 24 }; /* bytes that one formatted number may take */

/* The fewest digits (at most 9) that read back to the same float, as "0.1", "-12", "1e-07", "nan",
 * "inf". Both return the place behind the last byte; no zero is set there. */
char *qni_format_float(char *to, float value);
char *qni_format_integer(char *to, uint64_t value);

/* Parse at [at, end): a number as in C (decimal only), inf, nan, or an integer with sign. Return
 * the place behind it, or NULL when there is none; what follows must be white space, '/' or the
 * end. */
const char *qni_parse_double(const char *at, const char *end, double *value_out);
const char *qni_parse_integer(const char *at, const char *end, int64_t *value_out);

#endif
