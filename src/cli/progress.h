// SPDX-License-Identifier: MIT
/* The progress bar: on stderr, ten times a second at most, gone when the work is done. */
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include "options.h"

typedef struct cli_progress {
    bool enabled, visible;
    double started, shown; /* seconds */
} cli_progress;

void progress_open(cli_progress *progress, cli_progress_choice choice, bool quiet);
void progress_show(cli_progress *progress, const char *stage, double fraction);
void progress_erase(cli_progress *progress);

#endif
