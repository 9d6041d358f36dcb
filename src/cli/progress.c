// SPDX-License-Identifier: MIT
/* The progress bar. It waits a third of a second, so that short work shows nothing at all. */
#include "progress.h"
#include "session.h"

#include <stdio.h>
#include <unistd.h>

enum { BAR_WIDTH = 30 };

void progress_open(cli_progress *progress, cli_progress_choice choice, bool quiet) {
    progress->enabled =
        choice == PROGRESS_BAR || (choice == PROGRESS_AUTO && !quiet && isatty(STDERR_FILENO));
    progress->visible = false;
    progress->started = cli_seconds();
    progress->shown = progress->started + 0.2;
}

void progress_show(cli_progress *progress, const char *stage, double fraction) {
    if (!progress->enabled)
        return;
    double now = cli_seconds();
    if (now - progress->shown < 0.1)
        return;
    progress->shown = now;
    progress->visible = true;
    double clamped = fraction < 0 ? 0 : fraction > 1 ? 1 : fraction;
    int filled = (int)(clamped * BAR_WIDTH);
    char bar[BAR_WIDTH + 1];
    for (int i = 0; i < BAR_WIDTH; ++i)
        bar[i] = i < filled ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    fprintf(stderr, "\r\033[K[%s] %3.0f %% %s  %.1f s", bar, 100 * clamped, stage ? stage : "",
            now - progress->started);
    fflush(stderr);
}

void progress_erase(cli_progress *progress) {
    if (progress->visible)
        fputs("\r\033[K", stderr);
    progress->visible = false;
}
