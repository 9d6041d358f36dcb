// SPDX-License-Identifier: MIT
/* glTF 2.0, as one binary file (.glb) or as JSON with its data in base64 or beside it (.gltf): the
 * triangles of all meshes of the scene, moved by their nodes, joined where their coordinates are
 * equal; the owner is the material's number from 1. Coordinates stay as they are. Every offset and
 * count is checked against the buffer before it is used. */
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/gltf_buffers.h"
#include "mesh/weld.h"

#include <jansson.h>
#include <math.h>

enum {
    JSON_CHUNK = 0x4e4f534a,
    BIN_CHUNK = 0x004e4942,
    DEEPEST = 64,
    SIGNED_BYTE = 5120,
    BYTE = 5121,
    SIGNED_SHORT = 5122,
    SHORT = 5123,
    INTEGER = 5125,
    FLOAT = 5126,
    TRIANGLES = 4,
    STRIP = 5,
    FAN = 6
};

typedef struct reader {
    const qni_content *content;
    qni_builder *builder;
    qni_weld weld;
    const json_t *root;
    qni_gltf_buffers buffers;
    int64_t corners; /* taken so far */
    int64_t face;
    qn_error *error;
} reader;

/* Items of an accessor in their buffer. */
typedef struct span {
    const char *at;
    int64_t count, stride;
    int64_t type;
    bool normalized; /* whole numbers that stand for -1 to 1, or 0 to 1 */
} span;

static qn_status damaged(const reader *r, const char *what) {
    return qni_fail(r->error, QN_ERROR_INPUT, "cannot read '%.200s': %s", r->content->path, what);
}

/* Instances of instances must not fill the memory: counts what is taken against the bytes read. */
static bool has_room(reader *r, int64_t corners) {
    r->corners += corners;
    return r->corners <= 1000000 + 16 * (r->content->size + r->buffers.loaded);
}

/* A whole number of 0 and more; `otherwise` when it is missing, -1 when it is none. */
static int64_t whole(const json_t *object, const char *key, int64_t otherwise) {
    const json_t *value = json_object_get(object, key);
    if (!value)
        return otherwise;
    return json_is_integer(value) && json_integer_value(value) >= 0 ? json_integer_value(value)
                                                                    : -1;
}

static const json_t *item(const reader *r, const char *list, int64_t index) {
    const json_t *items = json_object_get(r->root, list);
    return index < 0 || index >= (int64_t)json_array_size(items)
               ? NULL
               : json_array_get(items, (size_t)index);
}

static int64_t size_of(int64_t type) {
    return type == BYTE || type == SIGNED_BYTE     ? 1
           : type == SHORT || type == SIGNED_SHORT ? 2
           : type == INTEGER || type == FLOAT      ? 4
                                                   : 0;
}

static qn_status find_span(reader *r, int64_t index, int width, span *out) {
    const json_t *accessor = item(r, "accessors", index);
    const json_t *view =
        accessor ? item(r, "bufferViews", whole(accessor, "bufferView", -1)) : NULL;
    if (accessor && json_object_get(accessor, "sparse"))
        return damaged(r, "sparse accessors are not supported");
    if (!view)
        return damaged(r, "an accessor has no data");
    const qni_gltf_buffer *buffer;
    QN_TRY(qni_gltf_buffers_get(&r->buffers, whole(view, "buffer", -1), &buffer, r->error));
    out->type = whole(accessor, "componentType", -1);
    out->count = whole(accessor, "count", -1);
    out->normalized = json_is_true(json_object_get(accessor, "normalized"));
    int64_t size = size_of(out->type) * width, start = whole(view, "byteOffset", 0),
            length = whole(view, "byteLength", -1), first = whole(accessor, "byteOffset", 0);
    out->stride = whole(view, "byteStride", size);
    if (size == 0 || out->count < 0 || start < 0 || length < 0 || first < 0 || out->stride < size ||
        out->stride > 255 + size)
        return damaged(r, "an accessor is not of the right form");
    if (start > buffer->size || length > buffer->size - start || first > length ||
        (out->count > 0 &&
         (length - first < size || (length - first - size) / out->stride < out->count - 1)))
        return damaged(r, "an accessor reaches beyond the end of its data; the file is damaged");
    out->at = buffer->bytes + start + first;
    return QN_OK;
}

static int64_t index_at(const span *s, int64_t n) {
    const unsigned char *at = (const unsigned char *)s->at + n * s->stride;
    if (s->type == BYTE)
        return at[0];
    return s->type == SHORT ? at[0] | at[1] << 8 : (int64_t)qni_get_u32((const char *)at);
}

/* A coordinate: a float, or a whole number of a quantized mesh (KHR_mesh_quantization). */
static float coordinate_at(const span *s, const char *at) {
    const unsigned char *byte = (const unsigned char *)at;
    if (s->type == FLOAT)
        return qni_get_f32(at);
    const bool is_signed = s->type == SIGNED_BYTE || s->type == SIGNED_SHORT;
    int32_t value = s->type == BYTE || s->type == SIGNED_BYTE ? byte[0] : byte[0] | byte[1] << 8;
    const int32_t top = s->type == BYTE || s->type == SIGNED_BYTE ? 255 : 65535;
    if (is_signed && value > top / 2)
        value -= top + 1;
    if (!s->normalized)
        return (float)value;
    const int32_t unit = is_signed ? top / 2 : top;
    return (float)(value < -unit ? -unit : value) / (float)unit;
}

static qn_status take_corner(reader *r, const span *places, const double matrix[3][4], int64_t n,
                             uint32_t *vertex_out) {
    if (n >= places->count)
        return damaged(r, "a triangle names a vertex that is not there; the file is damaged");
    float p[3], q[3];
    for (int k = 0; k < 3; ++k)
        p[k] = coordinate_at(places, places->at + n * places->stride + k * size_of(places->type));
    for (int k = 0; k < 3; ++k)
        q[k] = (float)(matrix[k][0] * (double)p[0] + matrix[k][1] * (double)p[1] +
                       matrix[k][2] * (double)p[2] + matrix[k][3]);
    return qni_weld_vertex(&r->weld, q, vertex_out) ? QN_OK
                                                    : qni_fail_read_memory(r->content, r->error);
}

static bool mirrors(const double m[3][4]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
           0;
}

/* Triangle n of a list, strip or fan, as places among the indices. */
static void corners_of(int64_t mode, int64_t n, int64_t at[3]) {
    at[0] = mode == TRIANGLES ? 3 * n : mode == STRIP ? n : 0;
    at[1] = mode == TRIANGLES ? 3 * n + 1 : mode == STRIP ? n + 1 + n % 2 : n + 1;
    at[2] = mode == TRIANGLES ? 3 * n + 2 : mode == STRIP ? n + 2 - n % 2 : n + 2;
}

static qn_status read_triangles(reader *r, const span *places, const span *indices, int64_t mode,
                                const double matrix[3][4]) {
    int64_t count = indices ? indices->count : places->count;
    int64_t triangles = mode == TRIANGLES ? count / 3 : count > 2 ? count - 2 : 0;
    bool turned = mirrors(matrix);
    if (!has_room(r, 3 * triangles))
        return damaged(r, "its instances come to more triangles than its size allows");
    for (int64_t n = 0; n < triangles; ++n) {
        int64_t at[3];
        uint32_t corners[3];
        corners_of(mode, n, at);
        for (int i = 0; i < 3; ++i)
            QN_TRY(take_corner(r, places, matrix, indices ? index_at(indices, at[i]) : at[i],
                               &corners[turned ? 2 - i : i]));
        if (!qni_builder_add_face(r->builder, corners, 3, ++r->face))
            return qni_fail_read_memory(r->content, r->error);
        if (r->face % QNI_PROGRESS_STEP == 0 && qni_read_stopped(r->content, places->at))
            return qni_fail_read_stopped(r->content, r->error);
    }
    return QN_OK;
}

static qn_status read_primitive(reader *r, const json_t *primitive, const double matrix[3][4]) {
    int64_t mode = whole(primitive, "mode", TRIANGLES), indices = whole(primitive, "indices", -2);
    if (mode >= 0 && mode < TRIANGLES) /* points and lines */
        return QN_OK;
    if (mode < 0 || mode > FAN || indices == -1)
        return damaged(r, "a primitive is not of the right form");
    const json_t *attributes = json_object_get(primitive, "attributes");
    span places, numbers;
    QN_TRY(find_span(r, whole(attributes, "POSITION", -1), 3, &places));
    if (places.type == INTEGER)
        return damaged(r, "positions are floats, bytes or 16-bit numbers; the file is damaged");
    if (indices >= 0) {
        QN_TRY(find_span(r, indices, 1, &numbers));
        if (numbers.type != BYTE && numbers.type != SHORT && numbers.type != INTEGER)
            return damaged(r, "indices are whole numbers without a sign; the file is damaged");
    }
    int64_t material = whole(primitive, "material", -1);
    r->builder->owner = material >= 0 && material < INT32_MAX ? (int32_t)material + 1 : 0;
    return read_triangles(r, &places, indices >= 0 ? &numbers : NULL, mode, matrix);
}

static bool take_reals(const json_t *list, int count, double *out) {
    if (!json_is_array(list) || (int)json_array_size(list) != count)
        return false;
    for (int n = 0; n < count; ++n)
        out[n] = json_number_value(json_array_get(list, (size_t)n));
    return true;
}

static void local_matrix(const json_t *node, double m[3][4]) {
    double all[16], q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1}, t[3] = {0, 0, 0};
    if (take_reals(json_object_get(node, "matrix"), 16, all)) { /* by columns */
        for (int n = 0; n < 12; ++n)
            m[n / 4][n % 4] = all[4 * (n % 4) + n / 4];
        return;
    }
    take_reals(json_object_get(node, "rotation"), 4, q);
    take_reals(json_object_get(node, "scale"), 3, s);
    take_reals(json_object_get(node, "translation"), 3, t);
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                               {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                               {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            m[i][k] = turn[i][k] * s[k];
        m[i][3] = t[i];
    }
}

static qn_status read_mesh(reader *r, int64_t index, const double matrix[3][4]) {
    const json_t *mesh = item(r, "meshes", index);
    const json_t *primitives = mesh ? json_object_get(mesh, "primitives") : NULL;
    if (!mesh)
        return damaged(r, "a node names a mesh that is not there; the file is damaged");
    for (size_t n = 0; n < json_array_size(primitives); ++n) {
        if (!has_room(r, 1))
            return damaged(r, "its instances come to more than its size allows");
        QN_TRY(read_primitive(r, json_array_get(primitives, n), matrix));
    }
    return QN_OK;
}

static qn_status read_node(reader *r, int64_t index, const double above[3][4], int depth) {
    const json_t *node = item(r, "nodes", index);
    if (!node)
        return damaged(r, "the scene names a node that is not there; the file is damaged");
    if (depth > DEEPEST)
        return damaged(r, "its nodes are nested too deeply, or in a circle");
    if (!has_room(r, 1))
        return damaged(r, "its instances come to more than its size allows");
    double own[3][4], matrix[3][4];
    local_matrix(node, own);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 4; ++k)
            matrix[i][k] = above[i][0] * own[0][k] + above[i][1] * own[1][k] +
                           above[i][2] * own[2][k] + (k == 3 ? above[i][3] : 0);
    if (json_object_get(node, "mesh"))
        QN_TRY(read_mesh(r, whole(node, "mesh", -1), (const double(*)[4])matrix));
    const json_t *children = json_object_get(node, "children");
    for (size_t n = 0; n < json_array_size(children); ++n) {
        const json_t *child = json_array_get(children, n);
        QN_TRY(read_node(r, json_is_integer(child) ? json_integer_value(child) : -1,
                         (const double(*)[4])matrix, depth + 1));
    }
    return QN_OK;
}

/* The default scene, or the first; without scenes all meshes as they are. */
static qn_status read_scene(reader *r) {
    static const double same[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const json_t *scene = item(r, "scenes", whole(r->root, "scene", 0));
    if (!scene) {
        for (size_t n = 0; n < json_array_size(json_object_get(r->root, "meshes")); ++n)
            QN_TRY(read_mesh(r, (int64_t)n, same));
        return QN_OK;
    }
    const json_t *nodes = json_object_get(scene, "nodes");
    for (size_t n = 0; n < json_array_size(nodes); ++n) {
        const json_t *node = json_array_get(nodes, n);
        QN_TRY(read_node(r, json_is_integer(node) ? json_integer_value(node) : -1, same, 0));
    }
    return QN_OK;
}

/* What our own writer notes beside the mesh. */
static void take_names(reader *r) {
    const json_t *extras = json_object_get(json_object_get(r->root, "asset"), "extras");
    const char *space = json_string_value(json_object_get(extras, "space")),
               *unit = json_string_value(json_object_get(extras, "unit"));
    if (space && strlen(space) < sizeof r->builder->space)
        memcpy(r->builder->space, space, strlen(space) + 1);
    if (unit && strlen(unit) < sizeof r->builder->unit)
        memcpy(r->builder->unit, unit, strlen(unit) + 1);
}

/* What the file cannot be understood without. Materials, textures and lights do not matter here. */
static qn_status check_extensions(const reader *r) {
    static const char *const harmless[] = {"KHR_mesh_quantization", "KHR_materials_",
                                           "KHR_texture_",          "EXT_texture_",
                                           "KHR_lights_",           "KHR_xmp"};
    const json_t *names = json_object_get(r->root, "extensionsRequired");
    for (size_t n = 0; n < json_array_size(names); ++n) {
        const char *name = json_string_value(json_array_get(names, n));
        bool known = !name;
        for (size_t i = 0; i < sizeof harmless / sizeof *harmless && !known; ++i)
            known = strncmp(name, harmless[i], strlen(harmless[i])) == 0;
        if (!known)
            return qni_fail(r->error, QN_ERROR_INPUT,
                            "cannot read '%.120s': it needs the glTF extension '%.40s', which is "
                            "not supported; export it without (uncompressed)",
                            r->content->path, name);
    }
    return QN_OK;
}

static qn_status find_chunks(reader *r, const char **json_out, int64_t *json_size_out) {
    const qni_content *content = r->content;
    if (content->size < 20 || qni_get_u32(content->bytes + 4) != 2)
        return damaged(r, "it is no GLB file of version 2");
    *json_out = NULL;
    for (int64_t at = 12; content->size - at >= 8;) {
        int64_t length = qni_get_u32(content->bytes + at);
        uint32_t kind = qni_get_u32(content->bytes + at + 4);
        at += 8;
        if (length > content->size - at)
            return damaged(r, "it is cut short");
        if (kind == JSON_CHUNK && !*json_out) {
            *json_out = content->bytes + at;
            *json_size_out = length;
        } else if (kind == BIN_CHUNK && !r->buffers.chunk) {
            r->buffers.chunk = content->bytes + at;
            r->buffers.chunk_size = length;
        }
        at += length;
    }
    return *json_out ? QN_OK : damaged(r, "it has no JSON chunk");
}

/* The JSON: a chunk of a binary file, or the whole of a text. */
static qn_status find_json(reader *r, const char **json_out, int64_t *json_size_out) {
    const qni_content *content = r->content;
    if (content->size >= 4 && memcmp(content->bytes, "glTF", 4) == 0)
        return find_chunks(r, json_out, json_size_out);
    const char *at = content->bytes, *end = at + content->size;
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n'))
        ++at;
    if (at == end || *at != '{')
        return damaged(r, "it is neither a GLB file of version 2 nor a glTF text");
    *json_out = at;
    *json_size_out = end - at;
    return QN_OK;
}

static qn_status read_asset(reader *r) {
    take_names(r);
    QN_TRY(check_extensions(r));
    QN_TRY(qni_gltf_buffers_start(&r->buffers, r->error));
    const qn_status status = read_scene(r);
    qni_gltf_buffers_free(&r->buffers);
    return status;
}

qn_status qni_read_gltf(const qni_content *content, qni_builder *builder, qn_error *error) {
    reader r = {.content = content, .builder = builder, .error = error};
    r.weld.builder = builder;
    const char *text = NULL;
    int64_t size = 0;
    QN_TRY(find_json(&r, &text, &size));
    json_error_t at;
    json_t *root = json_loadb(text, (size_t)size, 0, &at);
    if (!json_is_object(root)) {
        json_decref(root);
        return damaged(&r, "its JSON is damaged");
    }
    r.root = root;
    r.buffers.asset = content;
    r.buffers.list = json_object_get(root, "buffers");
    qn_status status = read_asset(&r);
    qni_weld_free(&r.weld);
    json_decref(root);
    return status;
}
