// SPDX-License-Identifier: MIT
/* Numbers in and out: strict parsing, shortest text that reads back the same, sizes for people. */
#ifndef CLI_NUMBER_H
#define CLI_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The whole text must be one number; "12abc" and "" are refused. */
bool number_parse_real(const char *text, double *value_out);
bool number_parse_integer(const char *text, int64_t *value_out);
/* Exactly `count` numbers with `separator` between them. */
bool number_parse_reals(const char *text, char separator, int count, double *values_out);
bool number_parse_integers(const char *text, char separator, int count, int64_t *values_out);

enum { NUMBER_TEXT_SIZE = 48 };
/* The shortest decimal that reads back as the same double. */
const char *number_format_real(double value, char text[NUMBER_TEXT_SIZE]);
/* Three to four digits: "12.3 MB". */
const char *number_format_bytes(int64_t bytes, char text[NUMBER_TEXT_SIZE]);
/* With digit groups: "6,498,576". */
const char *number_format_count(int64_t count, char text[NUMBER_TEXT_SIZE]);
/* Two digits or so, in the unit a person would take: "0.25 s", "48 s", "12 min", "3.5 h". */
const char *number_format_duration(double seconds, char text[NUMBER_TEXT_SIZE]);

#endif
