// SPDX-License-Identifier: MIT
/* One run of a verb. A first Ctrl-C asks the library to stop through progress, a second one kills.
 */
#include "session.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

static volatile sig_atomic_t signal_caught;

static void catch_signal(int number) {
    signal_caught = number;
}

static void watch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = catch_signal;
    action.sa_flags = SA_RESETHAND | SA_RESTART;
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (int i = 0; i < 3; ++i) {
        struct sigaction before;
        /* What the caller had ignored (nohup, a shell's background job) stays ignored. */
        if (sigaction(numbers[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
            sigaction(numbers[i], &action, NULL);
    }
    signal(SIGPIPE, SIG_IGN); /* a closed pipe is a write error with a sentence: exit 5 */
}

static void say(const char *format, va_list arguments) {
    fputs("quoin: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
}

void cli_say(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(format, arguments);
    va_end(arguments);
}

int cli_usage(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(format, arguments);
    va_end(arguments);
    return CLI_USAGE;
}

void cli_tell(cli_session *session, const char *format, ...) {
    if (session->options->quiet)
        return;
    progress_erase(&session->progress);
    va_list arguments;
    va_start(arguments, format);
    say(format, arguments);
    va_end(arguments);
}

static void on_log(void *user, qn_log_level level, const char *message) {
    cli_session *session = user;
    int verbose = session->options->verbose;
    bool wanted = level == QN_LOG_WARNING ? !session->options->quiet : verbose >= (int)level;
    if (!wanted)
        return;
    progress_erase(&session->progress);
    cli_say("%s", message);
}

static int on_progress(void *user, const char *stage, double fraction) {
    cli_session *session = user;
    progress_show(&session->progress, stage, fraction);
    return signal_caught != 0;
}

int cli_session_open(cli_session *session, const cli_options *options) {
    memset(session, 0, sizeof *session);
    session->options = options;
    session->started = cli_seconds();
    progress_open(&session->progress, options->progress, options->quiet);
    watch_signals();
    qn_context_options context_options;
    qn_context_options_init(&context_options);
    context_options.threads = options->threads;
    context_options.log = on_log;
    context_options.progress = on_progress;
    context_options.user = session;
    qn_error error;
    return cli_fail(session, qn_context_create(&context_options, &session->context, &error),
                    &error);
}

void cli_session_close(cli_session *session) {
    progress_erase(&session->progress);
    qn_context_destroy(session->context);
    session->context = NULL;
}

int cli_interrupted(cli_session *session) {
    if (!signal_caught)
        return 0;
    progress_erase(&session->progress);
    cli_say("interrupted; no unfinished file is left");
    return 128 + (int)signal_caught;
}

int cli_fail(cli_session *session, qn_status status, const qn_error *error) {
    if (signal_caught)
        return cli_interrupted(session);
    if (status == QN_OK)
        return 0;
    progress_erase(&session->progress);
    cli_say("%s", error->message);
    return qn_status_exit_code(status);
}

int cli_finish_stdout(int exit_code) {
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout))
        return exit_code;
    cli_say("stdout: cannot write: %s", errno ? strerror(errno) : "write error");
    return CLI_OUTPUT;
}

double cli_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int64_t cli_process_peak_bytes(void) {
    struct rusage use;
    if (getrusage(RUSAGE_SELF, &use) != 0)
        return 0;
#ifdef __APPLE__
    return (int64_t)use.ru_maxrss;
#else
    return (int64_t)use.ru_maxrss * 1024;
#endif
}
