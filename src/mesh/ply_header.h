// SPDX-License-Identifier: MIT
/* The header of a PLY file: elements, and the properties of each. */
#ifndef QNI_MESH_PLY_HEADER_H
#define QNI_MESH_PLY_HEADER_H

#include "mesh/content.h"
#include "mesh/text.h"

/* Types: the name of old, the name of today, bytes. */
#define QNI_PLY_TYPES(X)                                                                           \
    X(I8, "char", "int8", 1)                                                                       \
    X(U8, "uchar", "uint8", 1)                                                                     \
    X(I16, "short", "int16", 2)                                                                    \
    X(U16, "ushort", "uint16", 2)                                                                  \
    X(I32, "int", "int32", 4)                                                                      \
    X(U32, "uint", "uint32", 4)                                                                    \
    X(F32, "float", "float32", 4)                                                                  \
    X(F64, "double", "float64", 8)

typedef enum qni_ply_type {
#define QNI_PLY_ENUM(name, old, today, size) QNI_PLY_##name,
    QNI_PLY_TYPES(QNI_PLY_ENUM) QNI_PLY_NO_TYPE
#undef QNI_PLY_ENUM
} qni_ply_type;

/* What a property is to us. The vectors' members are in order. */
typedef enum qni_ply_role {
    QNI_PLY_OTHER,
    QNI_PLY_X,
    QNI_PLY_Y,
    QNI_PLY_Z,
    QNI_PLY_NX,
    QNI_PLY_NY,
    QNI_PLY_NZ,
    QNI_PLY_CORNERS,
    QNI_PLY_OWNER,
    QNI_PLY_ROLES
} qni_ply_role;

typedef struct qni_ply_property {
    qni_ply_type type;       /* of the value, or of a list's items */
    qni_ply_type count_type; /* of a list's length; QNI_PLY_NO_TYPE when it is no list */
    qni_ply_role role;
} qni_ply_property;

enum { QNI_PLY_PROPERTIES = 256, QNI_PLY_ELEMENTS = 32 };

typedef struct qni_ply_element {
    bool is_vertex, is_face;
    int64_t count;
    int first, last;     /* its properties, the last one excluded */
    int64_t least_bytes; /* that one item takes */
    bool has_role[QNI_PLY_ROLES];
} qni_ply_element;

typedef struct qni_ply_header {
    bool ascii, big_endian;
    int element_count, property_count;
    qni_ply_element elements[QNI_PLY_ELEMENTS];
    qni_ply_property properties[QNI_PLY_PROPERTIES];
    char space[32], unit[16]; /* from the comments that Quoin writes */
} qni_ply_header;

int64_t qni_ply_size(qni_ply_type type);
/* Leaves the text at the first byte behind the header. */
qn_status qni_ply_read_header(const qni_content *content, qni_text *text, qni_ply_header *header,
                              qn_error *error);

#endif
