// SPDX-License-Identifier: MIT
/* Files that appear whole or not at all: every failing call is seen, reported once and cleaned up
 * after. */
#include "core/file.h"
#include "core/context.h"
#include "core/status.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const char *cure_of(int failure) {
    switch (failure) {
    case ENOSPC:
    case EDQUOT:
        return "make room on the disk or name another place";
    case EFBIG:
        return "the limit for a file's size is reached: raise it or name another place";
    case EACCES:
    case EPERM:
        return "get the right to write there or name another place";
    case EROFS:
        return "the place is read-only: name another one";
    case ENOENT:
    case ENOTDIR:
        return "make the folder first";
    case EISDIR:
        return "that is a folder: give the name of a file in it";
    case ENAMETOOLONG:
        return "give a shorter name";
    default:
        return "check the disk or name another place";
    }
}

static qn_status fail_output(const char *path, int failure, qn_error *error) {
    char reason[128];
    if (strerror_r(failure, reason, sizeof reason) != 0) /* strerror() is not safe in threads */
        snprintf(reason, sizeof reason, "error %d", failure);
    return qni_fail(error, QN_ERROR_OUTPUT, "cannot write '%.200s': %s; %s", path, reason,
                    cure_of(failure));
}

/* The place that the bytes shall end up: links are followed, so that they stay links. */
static int find_target(qni_output *output) {
    struct stat info;
    if (strlen(output->path) >= sizeof output->target)
        return ENAMETOOLONG;
    if (!*output->path)
        return ENOENT;
    if (stat(output->path, &info) != 0) {
        strcpy(output->target, output->path);
        return errno == ENOENT ? 0 : errno;
    }
    if (S_ISDIR(info.st_mode))
        return EISDIR;
    if (!S_ISREG(info.st_mode)) {
        output->direct = true;
        return 0;
    }
    /* A file that may not be written is not replaced behind its owner's back. */
    if (access(output->path, W_OK) != 0)
        return errno;
    return realpath(output->path, output->target) ? 0 : errno;
}

static unsigned long noise(const void *salt) {
    struct timespec now = {0};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return ((unsigned long)now.tv_nsec * 2654435761u) ^ (unsigned long)now.tv_sec ^
           ((unsigned long)(uintptr_t)salt >> 4);
}

/* ".NAME.PID-noise.tmp" beside the target, so that the rename stays within one file system. */
static int open_temporary(qni_output *output) {
    const char *slash = strrchr(output->target, '/');
    int folder = slash ? (int)(slash - output->target) + 1 : 0;
    const char *name = output->target + folder;
    for (int attempt = 0; attempt < 100; ++attempt) {
        int length = snprintf(output->temporary, sizeof output->temporary,
                              "%.*s.%.180s.%ld-%06lx.tmp", folder, output->target, name,
                              (long)getpid(), (noise(output) + (unsigned long)attempt) & 0xffffff);
        if (length < 0 || (size_t)length >= sizeof output->temporary)
            return ENAMETOOLONG;
        output->descriptor =
            open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOCTTY, 0666);
        if (output->descriptor >= 0)
            return 0;
        if (errno != EEXIST)
            break;
    }
    output->temporary[0] = 0;
    return errno;
}

/* A file that is replaced keeps its rights; that they cannot be kept is no reason to fail. */
static void keep_mode(const qni_output *output) {
    struct stat info;
    if (stat(output->target, &info) == 0 && fchmod(output->descriptor, info.st_mode & 0777) != 0)
        return;
}

qn_status qni_output_open(qni_output *output, qn_context *context, const char *path,
                          qn_error *error) {
    *output = (qni_output){.context = context, .path = path, .descriptor = -1};
    int failure = find_target(output);
    if (failure)
        return fail_output(path, failure, error);
    if (context && !(output->buffer = qni_alloc(context, QNI_OUTPUT_BUFFER, 1)))
        return qni_fail_memory(error, "the buffer of an output file");
    if (output->direct) {
        output->descriptor = open(path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
        failure = output->descriptor < 0 ? errno : 0;
    } else {
        failure = open_temporary(output);
        if (!failure)
            keep_mode(output);
    }
    if (!failure)
        return QN_OK;
    qni_output_abandon(output);
    return fail_output(path, failure, error);
}

static void write_through(qni_output *output, const char *bytes, size_t size) {
    while (size && !output->failure) {
        /* Linux takes at most 2^31 - 4096 bytes a call. */
        ssize_t written = write(output->descriptor, bytes, size < (1 << 30) ? size : (1 << 30));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) {
            output->failure = written < 0 ? errno : EIO;
            return;
        }
        bytes += written;
        size -= (size_t)written;
    }
}

static void flush(qni_output *output) {
    write_through(output, output->buffer, output->used);
    output->used = 0;
}

void qni_output_write(qni_output *output, const void *bytes, size_t size) {
    output->bytes += (int64_t)size;
    if (!output->buffer || size >= QNI_OUTPUT_BUFFER) {
        flush(output);
        write_through(output, bytes, size);
        return;
    }
    if (size > QNI_OUTPUT_BUFFER - output->used)
        flush(output);
    if (size)
        memcpy(output->buffer + output->used, bytes, size);
    output->used += size;
}

char *qni_output_reserve(qni_output *output, size_t size) {
    if (size > QNI_OUTPUT_BUFFER - output->used)
        flush(output);
    return output->buffer + output->used;
}

void qni_output_advance(qni_output *output, size_t size) {
    output->used += size;
    output->bytes += (int64_t)size;
}

bool qni_output_stopped(qni_output *output, double fraction) {
    if (output->context && !output->cancelled && !output->failure)
        output->cancelled = qni_progress(output->context, "write", fraction);
    return output->cancelled || output->failure;
}

static void release(qni_output *output) {
    if (output->descriptor >= 0)
        close(output->descriptor);
    output->descriptor = -1;
    if (output->temporary[0])
        unlink(output->temporary);
    output->temporary[0] = 0;
    if (output->buffer)
        qni_free(output->context, output->buffer, QNI_OUTPUT_BUFFER, 1);
    output->buffer = NULL;
}

void qni_output_abandon(qni_output *output) {
    release(output);
}

/* Disks report late: some failures show only when the file is synced or closed. */
static void finish_descriptor(qni_output *output) {
    if (fsync(output->descriptor) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS &&
        !output->failure)
        output->failure = errno;
    if (close(output->descriptor) != 0 && errno != EINTR && !output->failure)
        output->failure = errno;
    output->descriptor = -1;
}

qn_status qni_output_commit(qni_output *output, qn_error *error) {
    if (!output->cancelled && output->buffer)
        flush(output);
    finish_descriptor(output);
    if (!output->failure && !output->cancelled && !output->direct) {
        if (rename(output->temporary, output->target) == 0)
            output->temporary[0] = 0;
        else
            output->failure = errno;
    }
    release(output);
    if (output->failure)
        return fail_output(output->path, output->failure, error);
    if (output->cancelled)
        return qni_fail(error, QN_ERROR_CANCELLED,
                        "cancelled while writing '%.200s'; nothing was left", output->path);
    return QN_OK;
}

qn_status qn_write_file(const char *path, const void *bytes, size_t size, qn_error *error) {
    qni_output output;
    QN_TRY(qni_output_open(&output, NULL, path, error));
    qni_output_write(&output, bytes, size);
    return qni_output_commit(&output, error);
}
