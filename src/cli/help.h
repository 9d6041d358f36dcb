// SPDX-License-Identifier: MIT
/* Help texts, man page and bash completion, all made from the tables of options.h. */
#ifndef CLI_HELP_H
#define CLI_HELP_H

#include "options.h"

#include <stdio.h>

void help_tool(FILE *file);
void help_verb(FILE *file, cli_verb verb);
void help_man(FILE *file);
void help_completion(FILE *file);

#endif
