// SPDX-License-Identifier: MIT
/* The ground: version, status and error, the context that carries allocator, threads, log and
 * progress. */
#ifndef QN_BASE_H
#define QN_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The only place where the version is written; meson.build reads it from here. */
#define QN_VERSION_MAJOR 0
#define QN_VERSION_MINOR 1
#define QN_VERSION_PATCH 0

#if defined(__GNUC__)
#define QN_API __attribute__((visibility("default")))
#else
#define QN_API
#endif

/* "0.1.0". A static string. */
QN_API const char *qn_version(void);

/* Status: name, exit code of the command line tool, what it means. 0 is success. */
#define QN_STATUS_MAP(X)                                                                           \
    X(OK, 0, "success")                                                                            \
    X(ERROR_INTERNAL, 1, "internal error")                                                         \
    X(ERROR_INVALID_ARGUMENT, 2, "invalid argument")                                               \
    X(ERROR_INPUT, 3, "cannot read the input")                                                     \
    X(ERROR_EMPTY, 4, "empty surface")                                                             \
    X(ERROR_OUT_OF_MEMORY, 5, "out of memory")                                                     \
    X(ERROR_OUTPUT, 5, "cannot write the output")                                                  \
    X(ERROR_QUALITY, 6, "quality check failed")                                                    \
    X(ERROR_UNSUPPORTED, 7, "not built in")                                                        \
    X(ERROR_CANCELLED, 130, "cancelled")

typedef enum qn_status {
#define QN_STATUS_ENUM(name, code, text) QN_##name,
    QN_STATUS_MAP(QN_STATUS_ENUM)
#undef QN_STATUS_ENUM
} qn_status;

/* "invalid argument" and so on. A static string. */
QN_API const char *qn_status_text(qn_status status);
/* The exit code the quoin tool ends with for this status. */
QN_API int qn_status_exit_code(qn_status status);

/* What went wrong, where, and what to do, as one sentence. Owned by the caller; filled on failure
 * only. */
typedef struct qn_error {
    qn_status status;
    char message[512];
} qn_error;

/* Memory. Both functions may be called from any worker thread at once. `alloc` returns NULL on
 * failure; `free` gets the size that was asked for and is never given NULL. */
typedef struct qn_allocator {
    void *user;
    void *(*alloc)(void *user, size_t size, size_t alignment);
    void (*free)(void *user, void *pointer, size_t size);
} qn_allocator;

typedef enum qn_log_level { QN_LOG_WARNING, QN_LOG_INFO, QN_LOG_DEBUG } qn_log_level;

typedef struct qn_context_options {
    size_t struct_size;     /* set by qn_context_options_init() */
    qn_allocator allocator; /* all zero: malloc and free */
    int32_t threads;        /* 0: all cores; 1: the calling thread only */
    /* Both are called on the calling thread only. A non-zero result of `progress` cancels the work,
     * which then ends with QN_ERROR_CANCELLED. `fraction` runs from 0 to 1 within a stage. */
    void (*log)(void *user, qn_log_level level, const char *message);
    int (*progress)(void *user, const char *stage, double fraction);
    void *user; /* handed to log and progress */
} qn_context_options;

static inline void qn_context_options_init(qn_context_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* A context owns no data and no global state; it must outlive all that was made with it.
 * One context serves one calling thread at a time; two contexts in two threads are independent. */
typedef struct qn_context qn_context;

/* options may be NULL. *context_out is NULL on failure. */
QN_API qn_status qn_context_create(const qn_context_options *options, qn_context **context_out,
                                   qn_error *error);
QN_API void qn_context_destroy(qn_context *context);
/* The number of worker threads the context uses, at least 1. */
QN_API int32_t qn_context_threads(const qn_context *context);

/* Bytes the library holds at present through this context, and the most it ever held. */
typedef struct qn_memory_use {
    int64_t current_bytes;
    int64_t peak_bytes;
} qn_memory_use;
QN_API qn_memory_use qn_context_memory(const qn_context *context);
/* Sets the peak to what is held at present, to measure one stage. */
QN_API void qn_context_reset_peak(qn_context *context);

/* Write `size` bytes into a file that appears whole or not at all: it is written under a temporary
 * name in the same folder and renamed, so that a failure leaves nothing behind and keeps what was
 * there. What is there and is not a regular file (/dev/stdout, a FIFO) is written directly.
 * QN_ERROR_OUTPUT  the folder is missing, the disk is full, no right to write */
QN_API qn_status qn_write_file(const char *path, const void *bytes, size_t size, qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
