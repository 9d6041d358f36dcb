// SPDX-License-Identifier: MIT
/* One byte source over a plain file, a gzip file or bytes in memory, read from front to back. All
 * readers of volumes read through it: reads are bounded, a short one is a sentence with offset and
 * both sizes. */
#ifndef QNI_VOLUME_SOURCE_H
#define QNI_VOLUME_SOURCE_H

#include <qn/base.h>

enum { QNI_SOURCE_WINDOW = 65536 };

/* Bytes fetched or unpacked but not yet handed out: bytes[at] to bytes[end - 1]. */
typedef struct qni_window {
    unsigned char *bytes;
    int64_t at, end;
} qni_window;

struct z_stream_s;

typedef struct qni_source {
    qn_context *context;
    char *path; /* own copy, for messages and for files beside it */
    int64_t path_bytes;
    int descriptor;      /* -1 while closed or in memory */
    bool in_memory;      /* `raw` shows all bytes and does not own them */
    int64_t file_size;   /* of the file as stored; -1 when it cannot be known (a pipe) */
    int64_t file_offset; /* stored bytes fetched into `raw` or handed out */
    int64_t offset;      /* bytes handed out, after unpacking */
    qni_window raw;
    qni_window decoded;         /* used while unpacking only */
    struct z_stream_s *inflate; /* NULL: not unpacking */
    bool inflate_ended;
    bool inflate_cut; /* the packed data stopped before its end mark */
} qni_source;

/* Open a file; one that starts like gzip is unpacked on the way. On failure nothing is held. */
qn_status qni_source_open(qn_context *context, const char *path, qni_source *source,
                          qn_error *error);
/* The same over borrowed bytes. `name` stands for the path. */
qn_status qni_source_open_memory(qn_context *context, const char *name, const void *bytes,
                                 int64_t size, qni_source *source, qn_error *error);
/* Open the file `name` in the folder of `header`, as detached headers mean it. Bytes in memory have
 * no folder: there they stand for every file they name. */
qn_status qni_source_open_beside(const qni_source *header, const char *name, qni_source *source,
                                 qn_error *error);
void qni_source_close(qni_source *source);

/* Show the next `wanted` bytes (at most 4096) without taking them; fewer at the end. */
qn_status qni_source_peek(qni_source *source, int64_t wanted, const unsigned char **bytes_out,
                          int64_t *found_out, qn_error *error);
/* Take up to `wanted` bytes; fewer only at the end. */
qn_status qni_source_read_some(qni_source *source, void *bytes, int64_t wanted, int64_t *found_out,
                               qn_error *error);
/* Take exactly `wanted` bytes, or fail with QN_ERROR_INPUT. */
qn_status qni_source_read(qni_source *source, void *bytes, int64_t wanted, qn_error *error);
qn_status qni_source_skip(qni_source *source, int64_t bytes, qn_error *error);
/* Take one line without its end mark. A line longer than the room is cut. *ended_out is true when
 * there was no further line. */
qn_status qni_source_line(qni_source *source, char *line, size_t room, bool *ended_out,
                          qn_error *error);
/* From here on the bytes are a gzip or zlib stream. */
qn_status qni_source_inflate(qni_source *source, qn_error *error);

/* The most bytes that can still come: exact for plain files, an upper bound for packed ones. */
int64_t qni_source_bound(const qni_source *source);
/* Fail when packed data whose bytes were all taken is damaged or lacks its end mark. *more_out says
 * whether bytes are left. */
qn_status qni_source_check_end(qni_source *source, bool *more_out, qn_error *error);

/* Fail with the sentence "PATH: ...". */
qn_status qni_source_fail_as(const qni_source *source, qn_status status, qn_error *error,
                             const char *format, ...) __attribute__((format(printf, 4, 5)));
/* The same for what is the file's fault. */
#define qni_source_fail(source, error, ...)                                                        \
    qni_source_fail_as((source), QN_ERROR_INPUT, (error), __VA_ARGS__)
/* The one sentence of a file that stops too early. */
qn_status qni_source_fail_truncated(const qni_source *source, int64_t wanted, int64_t offset,
                                    int64_t found, qn_error *error);

/* ---- between source.c and unpack.c ---- */

/* Bring at least `wanted` stored bytes into `raw`, where there are as many. */
qn_status qni_source_need_raw(qni_source *source, int64_t wanted, qn_error *error);
/* Unpack up to `wanted` bytes; none only at the end. */
qn_status qni_source_unpack(qni_source *source, unsigned char *bytes, int64_t wanted,
                            int64_t *found_out, qn_error *error);
void qni_source_end_inflate(qni_source *source);

#endif
