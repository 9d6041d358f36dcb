// SPDX-License-Identifier: MIT
/* OBJ: vertices and faces; negative indices, lines continued by a backslash; all else is left out.
 */
#include "core/context.h"
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/text.h"

/* A name, by its hash: two names with one hash would be one owner. */
struct named {
    uint64_t hash; /* 0: free */
    int32_t owner; /* from 1, as they first appear */
};

typedef struct reader {
    const qni_content *content;
    qni_builder *builder;
    qni_text text;
    uint32_t *corners; /* of the face being read */
    int64_t capacity;
    bool strange;        /* a line of no known kind was seen */
    bool materials;      /* some were named: groups count no more */
    struct named *names; /* open addressing, at most half full; of materials and groups */
    int64_t name_count, name_slots;
} reader;

/* Blanks, and a backslash with the line end behind it. */
static void skip_blanks(qni_text *text) {
    for (;;) {
        qni_skip_blanks(text);
        if (text->at + 1 >= text->end || *text->at != '\\' || !qni_is_line_end(text->at[1]))
            return;
        ++text->at;
        qni_next_line(text);
    }
}

static bool at_data_end(const qni_text *text) {
    return qni_at_line_end(text) || *text->at == '#';
}

static qn_status fail_line(const reader *r, qn_error *error, const char *what) {
    return qni_fail_at(r->content, "line", r->text.line, error, "%s", what);
}

static qn_status read_vertex(reader *r, qn_error *error) {
    float position[3];
    for (int a = 0; a < 3; ++a) {
        double value;
        skip_blanks(&r->text);
        if (!qni_take_double(&r->text, &value))
            return fail_line(r, error, "a vertex needs three numbers");
        position[a] = (float)value;
    }
    return qni_builder_add_vertex(r->builder, position, NULL)
               ? QN_OK
               : qni_fail_read_memory(r->content, error);
}

/* "7", "7/1", "7//3", "7/1/3", "-1": the vertex alone counts. */
static qn_status read_corner(reader *r, uint32_t *vertex_out, qn_error *error) {
    int64_t index;
    if (!qni_take_integer(&r->text, &index))
        return fail_line(r, error, "a face needs the numbers of its vertices, such as 'f 1 2 3'");
    while (!qni_at_line_end(&r->text) && *r->text.at != ' ' && *r->text.at != '\t' &&
           *r->text.at != '\\' && *r->text.at != '#')
        ++r->text.at;
    int64_t count = r->builder->positions.count;
    int64_t vertex = index > 0 ? index - 1 : count + index;
    if (index == 0 || vertex < 0 || vertex > (int64_t)UINT32_MAX)
        return qni_fail_at(r->content, "line", r->text.line, error,
                           "a face names vertex %lld, but vertices are counted from 1 (or from -1 "
                           "backwards) and %lld came before",
                           (long long)index, (long long)count);
    *vertex_out = (uint32_t)vertex;
    return QN_OK;
}

static bool grow_corners(reader *r) {
    int64_t capacity = 2 * r->capacity + 16;
    uint32_t *corners =
        qni_realloc(r->content->context, r->corners, r->capacity, capacity, sizeof *corners);
    if (!corners)
        return false;
    r->corners = corners;
    r->capacity = capacity;
    return true;
}

static qn_status read_face(reader *r, qn_error *error) {
    int64_t count = 0, line = r->text.line;
    for (skip_blanks(&r->text); !at_data_end(&r->text); skip_blanks(&r->text)) {
        if (count == r->capacity && !grow_corners(r))
            return qni_fail_read_memory(r->content, error);
        QN_TRY(read_corner(r, r->corners + count++, error));
    }
    return qni_builder_add_face(r->builder, r->corners, count, line)
               ? QN_OK
               : qni_fail_read_memory(r->content, error);
}

static struct named *find_name(struct named *names, int64_t slots, uint64_t hash) {
    uint64_t at = hash & (uint64_t)(slots - 1);
    while (names[at].hash && names[at].hash != hash)
        at = (at + 1) & (uint64_t)(slots - 1);
    return &names[at];
}

static bool grow_names(reader *r) {
    int64_t slots = r->name_slots ? 2 * r->name_slots : 64;
    struct named *names = qni_alloc_zero(r->content->context, slots, sizeof *names);
    if (!names)
        return false;
    for (int64_t n = 0; n < r->name_slots; ++n)
        if (r->names[n].hash)
            *find_name(names, slots, r->names[n].hash) = r->names[n];
    qni_free(r->content->context, r->names, r->name_slots, sizeof *names);
    r->names = names;
    r->name_slots = slots;
    return true;
}

/* "usemtl steel", "g wheel": faces from here on have this owner. Groups count in files without
 * materials only. */
static qn_status read_owner(reader *r, bool material, qn_error *error) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    skip_blanks(&r->text);
    for (const char *at = r->text.at; at < r->text.end && !qni_is_line_end(*at); ++at)
        hash = (hash ^ (unsigned char)*at) * UINT64_C(0x100000001b3);
    hash += hash == 0;
    if (r->materials && !material)
        return QN_OK;
    r->materials = material;
    if (2 * (r->name_count + 1) > r->name_slots && !grow_names(r))
        return qni_fail_read_memory(r->content, error);
    struct named *name = find_name(r->names, r->name_slots, hash);
    if (!name->hash)
        *name = (struct named){hash, (int32_t)(++r->name_count & INT32_MAX)};
    r->builder->owner = name->owner;
    return QN_OK;
}

static bool take_other(qni_text *text) {
    static const char *const words[] = {"vn",  "vt",     "vp",     "l",      "p",      "s",
                                        "o",   "mg",     "mtllib", "usemap", "maplib", "bevel",
                                        "lod", "cstype", "deg",    "curv",   "surf",   "end"};
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (qni_take_word(text, words[i]))
            return true;
    return false;
}

/* Over the rest of a line and of those that continue it. */
static void leave_line(qni_text *text) {
    for (;;) {
        const char *from = text->at;
        while (!qni_at_line_end(text))
            ++text->at;
        bool continued = text->at > from && text->at[-1] == '\\' && text->at < text->end;
        qni_next_line(text);
        if (!continued)
            return;
    }
}

static qn_status read_line(reader *r, qn_error *error) {
    skip_blanks(&r->text);
    if (at_data_end(&r->text))
        return QN_OK;
    if (qni_take_word(&r->text, "v"))
        return read_vertex(r, error);
    if (qni_take_word(&r->text, "f") || qni_take_word(&r->text, "fo"))
        return read_face(r, error);
    if (qni_take_word(&r->text, "usemtl"))
        return read_owner(r, true, error);
    if (qni_take_word(&r->text, "g"))
        return read_owner(r, false, error);
    r->strange = r->strange || !take_other(&r->text);
    return QN_OK;
}

static qn_status read_lines(reader *r, qn_error *error) {
    for (int64_t lines = 0; r->text.at < r->text.end; ++lines) {
        if (lines % QNI_PROGRESS_STEP == 0 && qni_read_stopped(r->content, r->text.at))
            return qni_fail_read_stopped(r->content, error);
        QN_TRY(read_line(r, error));
        leave_line(&r->text);
    }
    if (r->strange && r->builder->positions.count == 0)
        return qni_fail(
            error, QN_ERROR_INPUT,
            "cannot read '%.200s': it has no vertices and other lines than OBJ files have; "
            "give the right format",
            r->content->path);
    return QN_OK;
}

qn_status qni_read_obj(const qni_content *content, qni_builder *builder, qn_error *error) {
    reader r = {.content = content, .builder = builder, .text = qni_text_of(content)};
    qn_status status = read_lines(&r, error);
    qni_free(content->context, r.corners, r.capacity, sizeof *r.corners);
    qni_free(content->context, r.names, r.name_slots, sizeof *r.names);
    return status;
}
