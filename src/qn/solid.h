// SPDX-License-Identifier: MIT
/* Solids: sets { p : f(p) < 0 } given by a function, a program or a CSG tree. */
#ifndef QN_SOLID_H
#define QN_SOLID_H

#include <qn/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A solid is immutable and counted by references; any number of threads may evaluate it at once. */
typedef struct qn_solid qn_solid;

/* A solid of the caller's own. All functions may be called from several threads at once; each returns 0, or
 * anything else to stop the work with QN_ERROR_CANCELLED. Points are in world units. */
typedef struct qn_solid_callback {
    size_t struct_size;
    void *user;
    /* values[n] = f(points[n]): negative inside. Must be continuous near the surface. */
    int (*values)(void *user, int64_t count, const double (*points)[3], double *values);
    /* Gradients of f (any length; they point out of the solid) and the owner (material) of the surface there; each output
     * may be NULL. The function may be NULL: central differences, owner 0. */
    int (*gradients)(void *user, int64_t count, const double (*points)[3], double (*gradients)[3],
                     int32_t *owners);
    /* range[0] <= f <= range[1] over the box. May be NULL: then `lipschitz` bounds it, and where that is 0 too, nothing is
     * known and the solid is sampled to a minimum depth. */
    int (*bounds)(void *user, const double low[3], const double high[3], double range[2]);
    double lipschitz;         /* |f(p) - f(q)| <= lipschitz |p - q|; 0: not known */
    double low[3], high[3];   /* a box that holds the solid */
} qn_solid_callback;

static inline void qn_solid_callback_init(qn_solid_callback *callback) {
    qn_solid_callback zero;
    char *byte = (char *)&zero;
    for (size_t i = 0; i < sizeof zero; ++i)
        byte[i] = 0;
    *callback = zero;
    callback->struct_size = sizeof *callback;
}

QN_API qn_status qn_solid_from_callback(qn_context *context, const qn_solid_callback *callback,
                                        qn_solid **solid_out, qn_error *error);
QN_API void qn_solid_destroy(qn_solid *solid);

#ifdef __cplusplus
}
#endif
#endif
