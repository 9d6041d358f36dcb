// SPDX-License-Identifier: MIT
/* Starts quoin-vdb with posix_spawn(), and moves bytes over its socket without ever blocking for
 * longer than a tenth of a second: so progress is asked, and a program that hangs is seen. */
#define _GNU_SOURCE /* dladdr, secure_getenv, MSG_NOSIGNAL, SOCK_CLOEXEC */
#include "volume/vdb_process.h"
#include "qni_config.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { TICK = 100 /* milliseconds */ };

qni_vdb_result qni_vdb_process_fail(qni_vdb_process *process, qni_vdb_result result,
                                    const char *format, ...) {
    va_list values;
    va_start(values, format);
    vsnprintf(process->message->text, sizeof process->message->text, format, values);
    va_end(values);
    return process->result = result;
}

/* ---- where it is ----------------------------------------------------------------------------- */

/* The folder this code was loaded from, "/usr/lib/" or the build folder; false when unknown. */
static bool find_own_folder(char folder[PATH_MAX]) {
    static const char here = 0;
    Dl_info own;
    if (!dladdr(&here, &own) || !own.dli_fname)
        return false;
    const char *end = strrchr(own.dli_fname, '/');
    const size_t length = end ? (size_t)(end - own.dli_fname) + 1 : 0;
    if (length == 0 || length >= PATH_MAX)
        return false;
    memcpy(folder, own.dli_fname, length);
    folder[length] = 0;
    return true;
}

static bool try_place(char path[PATH_MAX], const char *folder, const char *name) {
    return name[0] && snprintf(path, PATH_MAX, "%s%s", folder, name) < PATH_MAX &&
           access(path, X_OK) == 0;
}

/* Named by the environment; beside an installed library, wherever its prefix was moved to; beside a
 * library in its build folder; where it was to be installed. */
static bool find_program(char path[PATH_MAX]) {
    char folder[PATH_MAX];
    const char *named = secure_getenv("QUOIN_VDB_PROGRAM");
    if (named && named[0])
        return try_place(path, "", named);
    return (find_own_folder(folder) && (try_place(path, folder, QNI_VDB_PROGRAM_FROM_LIBRARY) ||
                                        try_place(path, folder, "src/volume/quoin-vdb"))) ||
           try_place(path, "", QNI_VDB_PROGRAM_INSTALLED);
}

static qni_vdb_result fail_absent(qni_vdb_process *process) {
    const char *named = secure_getenv("QUOIN_VDB_PROGRAM");
    if (named && named[0])
        return qni_vdb_process_fail(process, QNI_VDB_ABSENT,
                                    "QUOIN_VDB_PROGRAM names '%.100s', which cannot be run", named);
    return qni_vdb_process_fail(process, QNI_VDB_ABSENT,
                                "the program quoin-vdb is missing; install it again, or name it in "
                                "QUOIN_VDB_PROGRAM");
}

/* ---- start ----------------------------------------------------------------------------------- */

/* A descriptor clear of those the program is given, and of ours that may be closed; -1 on failure.
 */
static int move_up(int descriptor) {
    const int moved = descriptor < 0 ? -1 : fcntl(descriptor, F_DUPFD_CLOEXEC, 10);
    if (descriptor >= 0)
        close(descriptor);
    return moved;
}

static int spawn(const char *path, int socket, int file, pid_t *child) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none, all;
    char *const arguments[] = {(char *)"quoin-vdb", NULL};
    sigemptyset(&none);
    sigfillset(&all);
    sigdelset(&all, SIGKILL);
    sigdelset(&all, SIGSTOP);
    if (posix_spawn_file_actions_init(&actions) != 0)
        return ENOMEM;
    if (posix_spawnattr_init(&attributes) != 0) {
        posix_spawn_file_actions_destroy(&actions);
        return ENOMEM;
    }
    int failure = posix_spawn_file_actions_adddup2(&actions, socket, QNI_VDB_SOCKET);
    failure |= posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    failure |= posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    failure |= posix_spawn_file_actions_adddup2(&actions, file, QNI_VDB_FILE);
    failure |= posix_spawnattr_setsigmask(&attributes, &none);
    failure |= posix_spawnattr_setsigdefault(&attributes, &all);
    failure |=
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    if (!failure)
        failure = posix_spawn(child, path, &actions, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    return failure;
}

static qni_vdb_result start_on(qni_vdb_process *process, int file) {
    char path[PATH_MAX];
    int ends[2];
    pid_t child;
    if (!find_program(path))
        return fail_absent(process);
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return qni_vdb_process_fail(process, QNI_VDB_NO_MEMORY, "%s", "no socket is left");
    const int theirs = move_up(ends[1]);
    process->socket = move_up(ends[0]);
    const int failure =
        theirs < 0 || process->socket < 0 ? EMFILE : spawn(path, theirs, file, &child);
    if (theirs >= 0)
        close(theirs);
    if (failure == EMFILE || failure == ENOMEM || failure == EAGAIN)
        return qni_vdb_process_fail(process, QNI_VDB_NO_MEMORY,
                                    "quoin-vdb cannot be started: too many files or processes");
    if (failure)
        return fail_absent(process);
    process->child = child;
    return QNI_VDB_OK;
}

qni_vdb_result qni_vdb_process_start(qni_vdb_process *process, qn_context *context,
                                     const char *path, bool reading, qni_vdb_message *message) {
    struct stat status;
    *process = (qni_vdb_process){
        .context = context, .stage = reading ? "read" : "write", .socket = -1, .message = message};
    message->text[0] = 0;
    const int file =
        move_up(open(path, (reading ? O_RDONLY : O_RDWR) | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (file < 0 || fstat(file, &status) != 0)
        qni_vdb_process_fail(process, QNI_VDB_BAD_FILE, "it cannot be opened again");
    else if (!S_ISREG(status.st_mode))
        qni_vdb_process_fail(process, QNI_VDB_BAD_FILE, "it is no regular file");
    else {
        process->file_bytes = (int64_t)status.st_size;
        process->seconds_allowed =
            reading ? 60 + 5 * qni_vdb_seconds_allowed(process->file_bytes) : 0;
        start_on(process, file);
    }
    if (file >= 0)
        close(file);
    return process->result;
}

/* ---- end ------------------------------------------------------------------------------------- */

/* Wait for the program, which has ended or is about to; false when its status is lost. */
static bool reap(qni_vdb_process *process, int *status) {
    pid_t found;
    do
        found = waitpid((pid_t)process->child, status, 0);
    while (found < 0 && errno == EINTR);
    process->child = 0;
    return found > 0;
}

/* It closed its end: say why. */
static void tell_end(qni_vdb_process *process) {
    int status = 0;
    const bool known = reap(process, &status);
    const int number = known && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (number == SIGXCPU)
        qni_vdb_process_fail(process, QNI_VDB_STOPPED, "it took more than %lld s of processor time",
                             (long long)qni_vdb_seconds_allowed(process->file_bytes));
    else if (number)
        qni_vdb_process_fail(process, QNI_VDB_STOPPED, "%s, signal %d",
                             number == SIGABRT   ? "an assertion of OpenVDB"
                             : number == SIGKILL ? "killed, perhaps for memory"
                                                 : "a fault in OpenVDB",
                             number);
    else
        qni_vdb_process_fail(process, QNI_VDB_STOPPED, "it ended with code %d",
                             known && WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

void qni_vdb_process_end(qni_vdb_process *process) {
    int status;
    if (process->child > 0) { /* nothing of it is wanted any more: no need to let it clean up */
        kill((pid_t)process->child, SIGKILL);
        reap(process, &status);
    }
    if (process->socket >= 0)
        close(process->socket);
    process->socket = -1;
}

/* ---- bytes ----------------------------------------------------------------------------------- */

/* Until the socket is ready for `events`, or the result is no longer good. */
static void wait_for(qni_vdb_process *process, short events) {
    struct pollfd ready = {.fd = process->socket, .events = events};
    for (int64_t ticks = 0; process->result == QNI_VDB_OK;) {
        const int found = poll(&ready, 1, TICK);
        if (found > 0)
            return;
        if (qni_progress(process->context, process->stage, process->fraction))
            qni_vdb_process_fail(process, QNI_VDB_CANCELLED, "cancelled");
        else if (found == 0 && process->seconds_allowed > 0 &&
                 ++ticks > process->seconds_allowed * (1000 / TICK))
            qni_vdb_process_fail(process, QNI_VDB_STOPPED, "it was silent for %lld s",
                                 (long long)process->seconds_allowed);
        else if (found < 0 && errno != EINTR)
            qni_vdb_process_fail(process, QNI_VDB_STOPPED, "its socket failed");
    }
}

qni_vdb_result qni_vdb_process_send(qni_vdb_process *process, const void *bytes, size_t size) {
    while (size > 0 && process->result == QNI_VDB_OK) {
        const ssize_t gone = send(process->socket, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (gone > 0) {
            bytes = (const char *)bytes + gone;
            size -= (size_t)gone;
        } else if (gone < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            wait_for(process, POLLOUT);
        else if (gone == 0 || errno != EINTR)
            tell_end(process);
    }
    return process->result;
}

qni_vdb_result qni_vdb_process_receive(qni_vdb_process *process, void *bytes, size_t size) {
    while (size > 0 && process->result == QNI_VDB_OK) {
        const ssize_t got = recv(process->socket, bytes, size, MSG_DONTWAIT);
        if (got > 0) {
            bytes = (char *)bytes + got;
            size -= (size_t)got;
        } else if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            wait_for(process, POLLIN);
        else if (got == 0 || errno != EINTR)
            tell_end(process);
    }
    return process->result;
}
