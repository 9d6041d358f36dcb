// SPDX-License-Identifier: MIT
/* The mesh formats: their names, the functions that write and read them, bytes in file order. */
#ifndef QNI_MESH_FORMAT_H
#define QNI_MESH_FORMAT_H

#include "core/file.h"
#include "mesh/builder.h"
#include "mesh/content.h"
#include "mesh/diagonals.h"
#include "mesh/mesh.h"

#include <string.h>

typedef enum qni_mesh_format {
    QNI_PLY,
    QNI_OBJ,
    QNI_STL,
    QNI_OFF,
    QNI_GLB, /* and, to be read, glTF as text */
    QNI_NO_FORMAT
} qni_mesh_format;

/* The format of a name such as "ply", in any case; QNI_NO_FORMAT when there is none. "gltf" is one
 * only for reading. */
qni_mesh_format qni_mesh_format_named(const char *name, size_t length, bool reading);
/* The format a file's name ends in; ".gz" after it is looked through when `reading`. */
qni_mesh_format qni_mesh_format_of_path(const char *path, bool reading);

/* What the writers are handed; `normals` is NULL when they are absent or not wanted. */
typedef struct qni_write_job {
    qn_context *context;
    qn_mesh_view view;
    bool ascii;
    float *curvature[2];     /* of each vertex, mean and Gaussian; NULL when not wanted */
    qni_diagonals diagonals; /* for formats without quads */
} qni_write_job;

/* Each writes into an open output and leaves failures there; the caller commits. The ones that can
 * refuse a mesh for its size do so before anything is opened, in qni_check_NAME(). */
void qni_write_ply(const qni_write_job *job, qni_output *output);
void qni_write_obj(const qni_write_job *job, qni_output *output);
void qni_write_stl(const qni_write_job *job, qni_output *output);
void qni_write_off(const qni_write_job *job, qni_output *output);
void qni_write_glb(const qni_write_job *job, qni_output *output);
qn_status qni_check_stl(const qni_write_job *job, qn_error *error);
qn_status qni_check_glb(const qni_write_job *job, qn_error *error);

/* Each reads unpacked content into a builder. */
qn_status qni_read_ply(const qni_content *content, qni_builder *builder, qn_error *error);
qn_status qni_read_obj(const qni_content *content, qni_builder *builder, qn_error *error);
qn_status qni_read_stl(const qni_content *content, qni_builder *builder, qn_error *error);
qn_status qni_read_off(const qni_content *content, qni_builder *builder, qn_error *error);
qn_status qni_read_gltf(const qni_content *content, qni_builder *builder, qn_error *error);
/* Whether content is binary STL: its length is what its triangle count asks for. */
bool qni_is_binary_stl(const qni_content *content);

/* QN_ERROR_INPUT: "cannot read 'x.obj': line 12: ..."; `place` is "line" or "byte". */
qn_status qni_fail_at(const qni_content *content, const char *place, int64_t number,
                      qn_error *error, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
qn_status qni_fail_read_memory(const qni_content *content, qn_error *error);
/* True when the caller asked to stop; `at` is how far reading came. */
bool qni_read_stopped(const qni_content *content, const char *at);
qn_status qni_fail_read_stopped(const qni_content *content, qn_error *error);

/* Faces or vertices between two looks at progress. */
enum { QNI_PROGRESS_STEP = 1 << 16 };

static inline char *qni_put_u32(char *to, uint32_t value) {
    to[0] = (char)value;
    to[1] = (char)(value >> 8);
    to[2] = (char)(value >> 16);
    to[3] = (char)(value >> 24);
    return to + 4;
}

static inline char *qni_put_f32(char *to, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return qni_put_u32(to, bits);
}

static inline char *qni_put_f32x3(char *to, const float *values) {
    return qni_put_f32(qni_put_f32(qni_put_f32(to, values[0]), values[1]), values[2]);
}

static inline uint32_t qni_get_u32(const char *from) {
    const unsigned char *byte = (const unsigned char *)from;
    return byte[0] | (uint32_t)byte[1] << 8 | (uint32_t)byte[2] << 16 | (uint32_t)byte[3] << 24;
}

static inline float qni_get_f32(const char *from) {
    uint32_t bits = qni_get_u32(from);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
