// SPDX-License-Identifier: MIT
/* Errors are values with a sentence. */
#ifndef QNI_CORE_STATUS_H
#define QNI_CORE_STATUS_H

#include <qn/base.h>

/* Fill `error` (which may be NULL) and return `status`. */
qn_status qni_fail(qn_error *error, qn_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The one sentence for memory that was not to be had. */
qn_status qni_fail_memory(qn_error *error, const char *what);

/* Leave the function when a call fails; for functions that hold nothing to clean up. */
#define QN_TRY(call)                                                                               \
    do {                                                                                           \
        qn_status qn_try_status_ = (call);                                                         \
        if (qn_try_status_ != QN_OK)                                                               \
            return qn_try_status_;                                                                 \
    } while (0)

/* Options given by a caller carry their size; an unset one is a forgotten init call. */
#define QNI_CHECK_OPTIONS(options, init_name, error)                                               \
    do {                                                                                           \
        if ((options) && (options)->struct_size != sizeof *(options))                              \
            return qni_fail((error), QN_ERROR_INVALID_ARGUMENT,                                    \
                            "options were not set up: call " init_name "() first");                \
    } while (0)

#endif
