// SPDX-License-Identifier: MIT
/* Values of options that are lists. All return false after having said what is wrong. */
#ifndef CLI_OPTION_VALUES_H
#define CLI_OPTION_VALUES_H

#include "options.h"

/* Says that the text is not of the right form, with an example; false. */
bool option_wrong(const cli_option_row *row, const char *text, const char *form);

bool option_set_isovalues(cli_options *options, const cli_option_row *row, const char *text);
bool option_set_spacing(cli_options *options, const cli_option_row *row, const char *text);
bool option_set_origin(cli_options *options, const cli_option_row *row, const char *text);
bool option_set_shape(cli_options *options, const cli_option_row *row, const char *text);
bool option_set_dtype(cli_options *options, const cli_option_row *row, const char *text);
bool option_set_size(cli_options *options, const cli_option_row *row, const char *text);

#endif
