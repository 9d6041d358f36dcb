// SPDX-License-Identifier: MIT
/* A .csg file as a tree of calls, before anything is made of it. */
#ifndef QNI_SOLID_CSG_TREE_H
#define QNI_SOLID_CSG_TREE_H

#include "solid/text.h"

typedef struct qni_csg_span {
    const char *at;
    int64_t length;
} qni_csg_span;

typedef enum qni_csg_kind {
    QNI_CSG_UNDEF,
    QNI_CSG_NUMBER,
    QNI_CSG_BOOL,
    QNI_CSG_STRING,
    QNI_CSG_VECTOR
} qni_csg_kind;

typedef struct qni_csg_value {
    qni_csg_kind kind;
    double number;     /* also 0 or 1 of a bool */
    qni_csg_span text; /* of a string, escapes as they are */
    struct qni_csg_value *items, *next;
    int64_t count;
} qni_csg_value;

typedef struct qni_csg_argument {
    qni_csg_span name; /* empty for a positional one */
    qni_csg_value value;
    struct qni_csg_argument *next;
} qni_csg_argument;

/* NAME(ARGUMENTS) { CHILDREN }. Children with the modifiers % and *, which do not count, are left
 * out. */
typedef struct qni_csg_call {
    qni_csg_span name;
    int64_t line, column;
    qni_csg_argument *arguments;
    struct qni_csg_call *children, *next;
    int64_t child_count;
} qni_csg_call;

/* Memory of a tree, all of it freed at once. */
typedef struct qni_csg_memory {
    qn_context *context;
    struct qni_csg_chunk *chunks;
} qni_csg_memory;
void qni_csg_memory_free(qni_csg_memory *memory);

/* The whole file as one call without a name whose children are the file's. */
qn_status qni_csg_parse(const qni_text *text, qni_csg_memory *memory, qni_csg_call **root_out,
                        qn_error *error);

bool qni_csg_is(const qni_csg_call *call, const char *name);
/* The argument of this name; NULL when there is none, or it is undef. */
const qni_csg_value *qni_csg_find(const qni_csg_call *call, const char *name);

#endif
