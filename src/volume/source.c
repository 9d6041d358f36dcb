// SPDX-License-Identifier: MIT
/* The byte source: opening files and memory, windows of bytes, bounded reads.
 * Unpacking is a layer of its own (unpack.c). */
#include "volume/source.h"
#include "core/context.h"
#include "core/status.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    WINDOW = QNI_SOURCE_WINDOW,
    LARGEST_LINE = 1 << 20,
    /* deflate packs at most 258 bytes into two bits */
    LARGEST_RATIO = 1032,
    /* bytes zlib may still hold back inside */
    INFLATE_SLACK = 65536
};

qn_status qni_source_fail_as(const qni_source *source, qn_status status, qn_error *error,
                             const char *format, ...) {
    if (!error)
        return status;
    char text[sizeof error->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    /* The end of a long path says more than its beginning; the sentence must fit as well. */
    const size_t longest_path = 160;
    size_t length = strlen(source->path);
    bool cut = length > longest_path;
    qni_fail(error, status, "%s%s: %s", cut ? "..." : "",
             source->path + (cut ? length - longest_path : 0), text);
    for (char *c = error->message; *c; ++c) /* texts of a hostile header do not steer a terminal */
        if ((unsigned char)*c < 32 || *c == 127)
            *c = '?';
    return status;
}

qn_status qni_source_fail_truncated(const qni_source *source, int64_t wanted, int64_t offset,
                                    int64_t found, qn_error *error) {
    return qni_source_fail(source, error,
                           "truncated: wanted %lld bytes at offset %lld%s, found %lld",
                           (long long)wanted, (long long)offset,
                           source->inflate ? " of the unpacked data" : "", (long long)found);
}

/* ---- stored bytes ---- */

static qn_status fetch(qni_source *source, unsigned char *bytes, int64_t wanted, int64_t *found_out,
                       qn_error *error) {
    *found_out = 0;
    if (source->in_memory)
        return QN_OK;
    const int64_t largest = INT64_C(1) << 30;
    ssize_t got;
    do
        got = read(source->descriptor, bytes, (size_t)(wanted < largest ? wanted : largest));
    while (got < 0 && errno == EINTR);
    if (got < 0)
        return qni_source_fail(source, error, "cannot be read: %s", strerror(errno));
    source->file_offset += got;
    *found_out = got;
    return QN_OK;
}

qn_status qni_source_need_raw(qni_source *source, int64_t wanted, qn_error *error) {
    qni_window *raw = &source->raw;
    if (source->in_memory || raw->end - raw->at >= wanted)
        return QN_OK;
    memmove(raw->bytes, raw->bytes + raw->at, (size_t)(raw->end - raw->at));
    raw->end -= raw->at;
    raw->at = 0;
    while (raw->end < wanted) {
        int64_t got;
        QN_TRY(fetch(source, raw->bytes + raw->end, WINDOW - raw->end, &got, error));
        if (got == 0)
            break;
        raw->end += got;
    }
    return QN_OK;
}

/* ---- the window readers see ---- */

static qni_window *top_window(qni_source *source) {
    return source->inflate ? &source->decoded : &source->raw;
}

/* Bytes from below the top window. */
static qn_status produce(qni_source *source, unsigned char *bytes, int64_t wanted,
                         int64_t *found_out, qn_error *error) {
    return source->inflate ? qni_source_unpack(source, bytes, wanted, found_out, error)
                           : fetch(source, bytes, wanted, found_out, error);
}

static qn_status need_top(qni_source *source, int64_t wanted, qn_error *error) {
    if (!source->inflate)
        return qni_source_need_raw(source, wanted, error);
    qni_window *top = &source->decoded;
    if (top->end - top->at >= wanted)
        return QN_OK;
    memmove(top->bytes, top->bytes + top->at, (size_t)(top->end - top->at));
    top->end -= top->at;
    top->at = 0;
    while (top->end < wanted) {
        int64_t got;
        QN_TRY(qni_source_unpack(source, top->bytes + top->end, WINDOW - top->end, &got, error));
        if (got == 0)
            break;
        top->end += got;
    }
    return QN_OK;
}

/* ---- reading ---- */

qn_status qni_source_peek(qni_source *source, int64_t wanted, const unsigned char **bytes_out,
                          int64_t *found_out, qn_error *error) {
    *bytes_out = NULL;
    *found_out = 0;
    QN_TRY(need_top(source, wanted, error));
    const qni_window *top = top_window(source);
    *bytes_out = top->bytes + top->at;
    *found_out = top->end - top->at < wanted ? top->end - top->at : wanted;
    return QN_OK;
}

qn_status qni_source_read_some(qni_source *source, void *bytes, int64_t wanted, int64_t *found_out,
                               qn_error *error) {
    unsigned char *to = bytes;
    qni_window *top = top_window(source);
    *found_out = 0;
    while (*found_out < wanted) {
        int64_t missing = wanted - *found_out;
        int64_t ready = top->end - top->at;
        int64_t got = ready < missing ? ready : missing;
        if (ready > 0) {
            memcpy(to + *found_out, top->bytes + top->at, (size_t)got);
            top->at += got;
        } else if (missing >= WINDOW) {
            QN_TRY(produce(source, to + *found_out, missing, &got, error));
            if (got == 0)
                break;
        } else {
            QN_TRY(need_top(source, 1, error));
            if (top->end == top->at)
                break;
            continue;
        }
        *found_out += got;
        source->offset += got;
    }
    return QN_OK;
}

qn_status qni_source_read(qni_source *source, void *bytes, int64_t wanted, qn_error *error) {
    int64_t found, offset = source->offset;
    QN_TRY(qni_source_read_some(source, bytes, wanted, &found, error));
    if (found < wanted)
        return qni_source_fail_truncated(source, wanted, offset, found, error);
    return QN_OK;
}

qn_status qni_source_skip(qni_source *source, int64_t bytes, qn_error *error) {
    int64_t offset = source->offset;
    if (bytes < 0 || bytes > qni_source_bound(source))
        return qni_source_fail_truncated(source, bytes, offset, qni_source_bound(source), error);
    qni_window *top = top_window(source);
    while (source->offset - offset < bytes) {
        QN_TRY(need_top(source, 1, error));
        int64_t left = bytes - (source->offset - offset);
        int64_t ready = top->end - top->at;
        if (ready == 0)
            return qni_source_fail_truncated(source, bytes, offset, source->offset - offset, error);
        int64_t taken = ready < left ? ready : left;
        top->at += taken;
        source->offset += taken;
    }
    return QN_OK;
}

qn_status qni_source_line(qni_source *source, char *line, size_t room, bool *ended_out,
                          qn_error *error) {
    qni_window *top = top_window(source);
    size_t length = 0;
    int64_t taken = 0;
    for (char c = 0; c != '\n'; ++taken) {
        if (top->at == top->end)
            QN_TRY(need_top(source, 1, error));
        if (top->at == top->end)
            break;
        if (taken >= LARGEST_LINE)
            return qni_source_fail(source, error, "a line of more than %d bytes in the header",
                                   (int)LARGEST_LINE);
        c = (char)top->bytes[top->at++];
        ++source->offset;
        if (c != '\n' && length + 1 < room)
            line[length++] = c;
    }
    if (length > 0 && line[length - 1] == '\r')
        --length;
    line[length] = 0;
    *ended_out = taken == 0;
    return QN_OK;
}

int64_t qni_source_bound(const qni_source *source) {
    int64_t stored = source->raw.end - source->raw.at;
    if (source->file_size < 0)
        return INT64_MAX;
    if (source->file_size > source->file_offset)
        stored += source->file_size - source->file_offset;
    if (!source->inflate)
        return stored;
    int64_t ready = source->decoded.end - source->decoded.at;
    if (stored > INT64_MAX / (2 * LARGEST_RATIO))
        return INT64_MAX;
    return ready + stored * LARGEST_RATIO + (source->inflate_ended ? 0 : INFLATE_SLACK);
}

qn_status qni_source_check_end(qni_source *source, bool *more_out, qn_error *error) {
    *more_out = false;
    QN_TRY(need_top(source, 1, error));
    const qni_window *top = top_window(source);
    *more_out = top->end > top->at;
    if (!*more_out && source->inflate && source->inflate_cut)
        return qni_source_fail(
            source, error, "truncated: the packed data stops before its end mark, after %lld bytes",
            (long long)source->offset);
    return QN_OK;
}

/* ---- opening ---- */

static qn_status keep_path(qni_source *source, const char *folder, size_t folder_length,
                           const char *name, qn_error *error) {
    source->path_bytes = (int64_t)(folder_length + strlen(name) + 1);
    source->path = qni_alloc(source->context, source->path_bytes, 1);
    if (!source->path)
        return qni_fail_memory(error, "a file name");
    memcpy(source->path, folder, folder_length);
    memcpy(source->path + folder_length, name, strlen(name) + 1);
    return QN_OK;
}

static qn_status open_descriptor(qni_source *source, bool must_be_regular, qn_error *error) {
    source->raw.bytes = qni_alloc(source->context, WINDOW, 1);
    if (!source->raw.bytes)
        return qni_fail_memory(error, "reading a file");
    /* A header may name a pipe that nobody writes to: do not wait for it. */
    source->descriptor =
        open(source->path, O_RDONLY | O_CLOEXEC | (must_be_regular ? O_NONBLOCK : 0));
    struct stat about;
    if (source->descriptor < 0 || fstat(source->descriptor, &about) != 0)
        return qni_source_fail(source, error, "cannot be opened: %s", strerror(errno));
    if (S_ISDIR(about.st_mode))
        return qni_source_fail(source, error, "is a folder, not a volume file");
    if (must_be_regular && !S_ISREG(about.st_mode))
        return qni_source_fail(source, error,
                               "is no regular file, as a volume's data file must be");
    source->file_size = S_ISREG(about.st_mode) ? (int64_t)about.st_size : -1;
    return QN_OK;
}

static qn_status unpack_if_gzip(qni_source *source, qn_error *error) {
    const unsigned char *bytes;
    int64_t found;
    QN_TRY(qni_source_peek(source, 4, &bytes, &found, error));
    /* Magic, the only method there is, and no reserved flag: raw samples hardly ever start so. */
    if (found == 4 && bytes[0] == 0x1f && bytes[1] == 0x8b && bytes[2] == 8 && bytes[3] < 0x20)
        return qni_source_inflate(source, error);
    return QN_OK;
}

static qn_status open_path(qn_context *context, const char *folder, size_t folder_length,
                           const char *name, bool must_be_regular, qni_source *source,
                           qn_error *error) {
    memset(source, 0, sizeof *source);
    source->context = context;
    source->descriptor = -1;
    qn_status status = keep_path(source, folder, folder_length, name, error);
    if (status == QN_OK)
        status = open_descriptor(source, must_be_regular, error);
    if (status == QN_OK)
        status = unpack_if_gzip(source, error);
    if (status != QN_OK)
        qni_source_close(source);
    return status;
}

qn_status qni_source_open(qn_context *context, const char *path, qni_source *source,
                          qn_error *error) {
    return open_path(context, "", 0, path, false, source, error);
}

qn_status qni_source_open_memory(qn_context *context, const char *name, const void *bytes,
                                 int64_t size, qni_source *source, qn_error *error) {
    memset(source, 0, sizeof *source);
    source->context = context;
    source->descriptor = -1;
    source->in_memory = true;
    source->file_size = source->file_offset = size;
    source->raw.bytes = (unsigned char *)(uintptr_t)bytes; /* only read, never freed */
    source->raw.end = size;
    qn_status status = keep_path(source, "", 0, name, error);
    if (status == QN_OK)
        status = unpack_if_gzip(source, error);
    if (status != QN_OK)
        qni_source_close(source);
    return status;
}

qn_status qni_source_open_beside(const qni_source *header, const char *name, qni_source *source,
                                 qn_error *error) {
    if (header->in_memory)
        return qni_source_open_memory(header->context, name, header->raw.bytes, header->raw.end,
                                      source, error);
    const char *slash = strrchr(header->path, '/');
    size_t folder_length = slash && name[0] != '/' ? (size_t)(slash - header->path) + 1 : 0;
    return open_path(header->context, header->path, folder_length, name, true, source, error);
}

void qni_source_close(qni_source *source) {
    qn_context *context = source->context;
    qni_source_end_inflate(source);
    if (source->descriptor >= 0)
        close(source->descriptor);
    if (!source->in_memory)
        qni_free(context, source->raw.bytes, WINDOW, 1);
    qni_free(context, source->path, source->path_bytes, 1);
    memset(source, 0, sizeof *source);
    source->descriptor = -1;
}
