// SPDX-License-Identifier: MIT
/* One run of a verb: its context, what it says, its exit code, and Ctrl-C. */
#ifndef CLI_SESSION_H
#define CLI_SESSION_H

#include "options.h"
#include "progress.h"

/* Exit codes that are not a qn_status's own. */
enum { CLI_USAGE = 2, CLI_EMPTY = 4, CLI_OUTPUT = 5, CLI_QUALITY = 6, CLI_UNSUPPORTED = 7 };

typedef struct cli_session {
    const cli_options *options;
    qn_context *context;
    cli_progress progress;
    double started; /* seconds */
} cli_session;

/* Both print "quoin: ..." on stderr; cli_usage() returns the exit code 2. */
void cli_say(const char *format, ...) __attribute__((format(printf, 1, 2)));
int cli_usage(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* The same, but nothing with --quiet. */
void cli_tell(cli_session *session, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Returns 0 or an exit code; cli_session_close() may be called in either case. */
int cli_session_open(cli_session *session, const cli_options *options);
void cli_session_close(cli_session *session);

/* Says the error (or that the work was interrupted) and returns the exit code for it; 0 for QN_OK.
 */
int cli_fail(cli_session *session, qn_status status, const qn_error *error);
/* 0, or the exit code after a signal asked to stop: looked at between library calls. */
int cli_interrupted(cli_session *session);

/* Flushes stdout; exit_code, or 5 when what was printed did not get out. */
int cli_finish_stdout(int exit_code);

double cli_seconds(void);             /* a clock that only runs forward */
int64_t cli_process_peak_bytes(void); /* largest resident size of this process */

#endif
