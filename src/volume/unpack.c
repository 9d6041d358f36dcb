// SPDX-License-Identifier: MIT
/* Unpacking under the byte source: zlib's inflate, with memory of the context, of gzip and zlib
 * streams that may begin anywhere in a file. */
#include "volume/source.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>
#include <zlib.h>

/* zlib frees without a size: it is kept in front of the block. */
enum { ZLIB_PREFIX = 64 };

static void *zlib_alloc(void *opaque, unsigned count, unsigned size) {
    int64_t bytes = (int64_t)count * size + ZLIB_PREFIX;
    char *block = qni_alloc(opaque, bytes, 1);
    if (!block)
        return NULL;
    memcpy(block, &bytes, sizeof bytes);
    return block + ZLIB_PREFIX;
}

static void zlib_free(void *opaque, void *pointer) {
    char *block = (char *)pointer - ZLIB_PREFIX;
    int64_t bytes;
    memcpy(&bytes, block, sizeof bytes);
    qni_free(opaque, block, bytes, 1);
}

qn_status qni_source_inflate(qni_source *source, qn_error *error) {
    if (source->inflate)
        return qni_source_fail(source, error,
                               "its data is packed twice; unpack it once with gunzip");
    z_stream *stream = qni_alloc_zero(source->context, 1, sizeof *stream);
    source->decoded.bytes = qni_alloc(source->context, QNI_SOURCE_WINDOW, 1);
    source->inflate = stream;
    source->inflate_ended = source->inflate_cut = false;
    if (!stream || !source->decoded.bytes)
        return qni_fail_memory(error, "unpacking a file");
    stream->zalloc = zlib_alloc;
    stream->zfree = zlib_free;
    stream->opaque = source->context;
    const int any_header = 32; /* gzip and zlib headers are told apart by inflate */
    if (inflateInit2(stream, MAX_WBITS + any_header) != Z_OK)
        return qni_fail_memory(error, "unpacking a file");
    return QN_OK;
}

/* A gzip file may be several, one after another. */
static qn_status start_next_member(qni_source *source, qn_error *error) {
    QN_TRY(qni_source_need_raw(source, 2, error));
    const qni_window *raw = &source->raw;
    bool another =
        raw->end - raw->at >= 2 && raw->bytes[raw->at] == 0x1f && raw->bytes[raw->at + 1] == 0x8b;
    source->inflate_ended = !another || inflateReset(source->inflate) != Z_OK;
    return QN_OK;
}

static qn_status check_inflate(qni_source *source, int code, bool progress, qn_error *error) {
    if (code == Z_MEM_ERROR)
        return qni_fail_memory(error, "unpacking a file");
    if (code == Z_STREAM_END)
        return start_next_member(source, error);
    if ((code != Z_OK && code != Z_BUF_ERROR) || !progress)
        return qni_source_fail(
            source, error, "the packed (gzip) data is damaged at offset %lld (%s)",
            (long long)source->offset, source->inflate->msg ? source->inflate->msg : "no progress");
    return QN_OK;
}

qn_status qni_source_unpack(qni_source *source, unsigned char *bytes, int64_t wanted,
                            int64_t *found_out, qn_error *error) {
    const int64_t largest = INT64_C(1) << 30;
    z_stream *stream = source->inflate;
    qni_window *raw = &source->raw;
    *found_out = 0;
    while (*found_out == 0 && !source->inflate_ended) {
        QN_TRY(qni_source_need_raw(source, 1, error));
        int64_t stored = raw->end - raw->at;
        if (stored == 0) {
            source->inflate_cut = source->inflate_ended = true;
            break;
        }
        stream->next_in = raw->bytes + raw->at;
        stream->avail_in = (uInt)(stored < largest ? stored : largest);
        stream->next_out = bytes;
        stream->avail_out = (uInt)(wanted < largest ? wanted : largest);
        uInt in_before = stream->avail_in;
        int code = inflate(stream, Z_NO_FLUSH);
        raw->at += in_before - stream->avail_in;
        *found_out = stream->next_out - bytes;
        QN_TRY(check_inflate(source, code, in_before != stream->avail_in || *found_out > 0, error));
    }
    return QN_OK;
}

void qni_source_end_inflate(qni_source *source) {
    if (source->inflate) {
        if (source->inflate->state) /* else inflateInit2 failed */
            inflateEnd(source->inflate);
        qni_free(source->context, source->inflate, 1, sizeof *source->inflate);
    }
    qni_free(source->context, source->decoded.bytes, QNI_SOURCE_WINDOW, 1);
    source->inflate = NULL;
    source->decoded = (qni_window){NULL, 0, 0};
}
