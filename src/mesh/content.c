// SPDX-License-Identifier: MIT
/* A file's content in memory. zlib's gz functions read plain and packed files alike. */
#include "mesh/content.h"
#include "core/context.h"
#include "core/status.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

enum { STEP = 1 << 24, SMALLEST = 1 << 16 };

static qn_status fail_system(const char *path, int failure, qn_error *error) {
    char reason[128];
    if (strerror_r(failure, reason, sizeof reason) != 0)
        snprintf(reason, sizeof reason, "error %d", failure);
    return qni_fail(error, QN_ERROR_INPUT, "cannot read '%.200s': %s; %s", path, reason,
                    failure == ENOENT   ? "check the name"
                    : failure == EACCES ? "get the right to read it"
                                        : "check the disk");
}

static qn_status fail_unpacking(const char *path, gzFile file, qn_error *error) {
    int code, failure = errno;
    const char *text = gzerror(file, &code);
    if (code == Z_MEM_ERROR)
        return qni_fail_memory(error, "unpacking gzip");
    if (code == Z_ERRNO)
        return fail_system(path, failure, error);
    return qni_fail(
        error, QN_ERROR_INPUT,
        "cannot read '%.200s': its gzip stream is damaged or cut short (%s); fetch it again", path,
        code == Z_BUF_ERROR ? "it ends too early" : text);
}

void qni_content_free(qni_content *content) {
    qni_free(content->context, content->bytes, content->capacity, 1);
    content->bytes = NULL;
    content->size = content->capacity = 0;
}

static bool grow(qni_content *content) {
    int64_t capacity = content->capacity < SMALLEST ? SMALLEST : 2 * content->capacity;
    char *bytes = qni_realloc(content->context, content->bytes, content->capacity, capacity, 1);
    if (!bytes)
        return false;
    content->bytes = bytes;
    content->capacity = capacity;
    return true;
}

static qn_status read_all(gzFile file, int64_t file_size, qni_content *content, qn_error *error) {
    for (;;) {
        if (content->size == content->capacity && !grow(content))
            return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                            "not enough memory for the content of '%.200s'", content->path);
        if (file_size > 0 && qni_progress(content->context, "read",
                                          0.5 * (double)gzoffset(file) / (double)file_size))
            return qni_fail(error, QN_ERROR_CANCELLED, "cancelled while reading '%.200s'",
                            content->path);
        int64_t room = content->capacity - content->size;
        int taken =
            gzread(file, content->bytes + content->size, (unsigned)(room < STEP ? room : STEP));
        if (taken < 0)
            return fail_unpacking(content->path, file, error);
        content->size += taken;
        if (taken == 0)
            return QN_OK;
    }
}

/* The first guess at the room needed, one byte more than a plain file has, to see its end. */
static int64_t first_capacity(int descriptor, int64_t file_size) {
    unsigned char magic[2] = {0, 0};
    bool packed = pread(descriptor, magic, 2, 0) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
    return packed ? 4 * file_size + SMALLEST : file_size + 1;
}

qn_status qni_content_load(qn_context *context, const char *path, qni_content *content,
                           qn_error *error) {
    *content = (qni_content){.context = context, .path = path};
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor < 0)
        return fail_system(path, errno, error);
    struct stat info;
    if (fstat(descriptor, &info) != 0 || S_ISDIR(info.st_mode)) {
        close(descriptor);
        return qni_fail(error, QN_ERROR_INPUT,
                        "cannot read '%.200s': it is a folder; give the name of a file in it",
                        path);
    }
    int64_t file_size = S_ISREG(info.st_mode) ? (int64_t)info.st_size : 0;
    int64_t capacity = first_capacity(descriptor, file_size);
    content->bytes = qni_alloc(context, capacity, 1);
    content->capacity = content->bytes ? capacity : 0;
    gzFile file = content->bytes ? gzdopen(descriptor, "rb") : NULL;
    if (!file) {
        close(descriptor);
        qni_content_free(content);
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "not enough memory for the content of '%.200s'", path);
    }
    gzbuffer(file, 1 << 17);
    qn_status status = read_all(file, file_size, content, error);
    int closed = gzclose_r(file);
    if (status == QN_OK && closed == Z_BUF_ERROR)
        status =
            qni_fail(error, QN_ERROR_INPUT,
                     "cannot read '%.200s': its gzip stream is cut short; fetch it again", path);
    if (status != QN_OK)
        qni_content_free(content);
    return status;
}
