// SPDX-License-Identifier: MIT
/* The buffers of a glTF asset (glTF 2.0 specification, sections 3.6 and 4.4). A URI may only lead
 * to the asset's own folder or below it: a model from elsewhere does not choose what else is read.
 */
#include "mesh/gltf_buffers.h"
#include "core/context.h"
#include "core/status.h"

#include <limits.h>
#include <string.h>
#include <sys/stat.h>

static qn_status damaged(const qni_gltf_buffers *b, int64_t n, const char *what, qn_error *error) {
    return qni_fail(error, QN_ERROR_INPUT, "cannot read '%.200s': buffer %lld %s", b->asset->path,
                    (long long)n, what);
}

qn_status qni_gltf_buffers_start(qni_gltf_buffers *buffers, qn_error *error) {
    const int64_t count = (int64_t)json_array_size(buffers->list);
    buffers->items = qni_alloc(buffers->asset->context, count + 1, sizeof *buffers->items);
    if (!buffers->items)
        return qni_fail_memory(error, "the buffers of a glTF file");
    buffers->count = count;
    memset(buffers->items, 0, (size_t)(count + 1) * sizeof *buffers->items);
    return QN_OK;
}

void qni_gltf_buffers_free(qni_gltf_buffers *buffers) {
    for (int64_t n = 0; n < buffers->count; ++n)
        if (buffers->items[n].held.bytes)
            qni_content_free(&buffers->items[n].held);
    if (buffers->items)
        qni_free(buffers->asset->context, buffers->items, buffers->count + 1,
                 sizeof *buffers->items);
    buffers->items = NULL;
}

/* 0 to 63; -1 for what is no digit. */
static int digit(char c) {
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* Four digits are three bytes; "=" at the end fills up. The count of bytes, -1 where it is not
 * base64. */
static int64_t decode(const char *text, char *bytes) {
    int64_t count = 0;
    uint32_t bits = 0;
    int held = 0;
    for (; *text && *text != '='; ++text) {
        const int value = digit(*text);
        if (value < 0)
            return -1;
        bits = (bits << 6 | (uint32_t)value) & 0xffffff;
        held += 6;
        if (held >= 8) {
            held -= 8;
            bytes[count++] = (char)(bits >> held & 255);
        }
    }
    return text[strspn(text, "=")] ? -1 : count;
}

static qn_status take_base64(qni_gltf_buffers *b, int64_t n, const char *uri, qn_error *error) {
    static const char mark[] = ";base64,";
    const char *text = strstr(uri, mark);
    qni_content *held = &b->items[n].held;
    if (!text)
        return damaged(b, n, "is a data URI that is not base64, which is not supported", error);
    text += sizeof mark - 1;
    const int64_t room = (int64_t)strlen(text) / 4 * 3 + 3;
    *held = (qni_content){.context = b->asset->context, .path = b->asset->path};
    held->bytes = qni_alloc(held->context, room, 1);
    if (!held->bytes)
        return qni_fail_memory(error, "the data of a glTF file");
    held->capacity = room;
    held->size = decode(text, held->bytes);
    return held->size < 0 ? damaged(b, n, "is not base64; the file is damaged", error) : QN_OK;
}

static int hex(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* The name with %20 and the like replaced; false where it does not fit or hides a 0. */
static bool take_name(const char *uri, char *name, size_t room) {
    size_t length = 0;
    for (; *uri; ++uri) {
        char c = *uri;
        if (c == '%' && hex(uri[1]) >= 0 && hex(uri[2]) >= 0) {
            c = (char)(hex(uri[1]) << 4 | hex(uri[2]));
            uri += 2;
        }
        if (!c || length + 1 >= room)
            return false;
        name[length++] = c;
    }
    name[length] = '\0';
    return length > 0;
}

/* Within the folder of the asset: not absolute, no scheme, no step upwards. */
static bool stays_below(const char *name) {
    if (name[0] == '/' || name[strcspn(name, ":/")] == ':')
        return false;
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || !part[2]))
            return false;
    }
    return true;
}

static qn_status take_file(qni_gltf_buffers *b, int64_t n, const char *uri, qn_error *error) {
    const char *slash = strrchr(b->asset->path, '/');
    const size_t folder = slash ? (size_t)(slash - b->asset->path) + 1 : 0;
    char path[PATH_MAX];
    struct stat info;
    if (folder >= sizeof path || !take_name(uri, path + folder, sizeof path - folder))
        return damaged(b, n, "has a file name that is too long or empty", error);
    if (!stays_below(path + folder))
        return damaged(b, n,
                       "names a file outside the folder of this one; put it beside it, and its "
                       "name into 'uri'",
                       error);
    memcpy(path, b->asset->path, folder);
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return damaged(b, n, "names something that is no file", error);
    qn_status status = qni_content_load(b->asset->context, path, &b->items[n].held, error);
    b->items[n].held.path = b->asset->path;
    b->loaded += status == QN_OK ? b->items[n].held.size : 0;
    return status;
}

static qn_status load(qni_gltf_buffers *b, int64_t n, qn_error *error) {
    const json_t *buffer = json_array_get(b->list, (size_t)n);
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    qni_gltf_buffer *item = b->items + n;
    if (!uri && n == 0 && b->chunk) {
        item->bytes = b->chunk;
        item->size = b->chunk_size;
        return QN_OK;
    }
    if (!uri)
        return damaged(b, n, "has no data: it needs a 'uri'; the file is damaged", error);
    QN_TRY(strncmp(uri, "data:", 5) == 0 ? take_base64(b, n, uri, error)
                                         : take_file(b, n, uri, error));
    const int64_t length = json_integer_value(json_object_get(buffer, "byteLength"));
    if (length > item->held.size)
        return damaged(b, n, "is shorter than the file says; fetch it again", error);
    item->bytes = item->held.bytes;
    item->size = item->held.size;
    return QN_OK;
}

qn_status qni_gltf_buffers_get(qni_gltf_buffers *buffers, int64_t n, const qni_gltf_buffer **out,
                               qn_error *error) {
    if (n < 0 || n >= buffers->count)
        return qni_fail(error, QN_ERROR_INPUT,
                        "cannot read '%.200s': it names a buffer that is not there; the file is "
                        "damaged",
                        buffers->asset->path);
    if (!buffers->items[n].bytes)
        QN_TRY(load(buffers, n, error));
    *out = buffers->items + n;
    return QN_OK;
}
