// SPDX-License-Identifier: MIT
/* Status names, exit codes and the filling of errors. */
#include "core/status.h"

#include <stdarg.h>
#include <stdio.h>

#define STRING_(x) #x
#define STRING(x)  STRING_(x)

const char *qn_version(void) {
    return STRING(QN_VERSION_MAJOR) "." STRING(QN_VERSION_MINOR) "." STRING(QN_VERSION_PATCH);
}

const char *qn_status_text(qn_status status) {
    switch (status) {
#define STATUS_TEXT(name, code, text)                                                              \
    case QN_##name:                                                                                \
        return text;
        QN_STATUS_MAP(STATUS_TEXT)
#undef STATUS_TEXT
    }
    return "unknown status";
}

int qn_status_exit_code(qn_status status) {
    switch (status) {
#define STATUS_CODE(name, code, text)                                                              \
    case QN_##name:                                                                                \
        return code;
        QN_STATUS_MAP(STATUS_CODE)
#undef STATUS_CODE
    }
    return 1;
}

qn_status qni_fail(qn_error *error, qn_status status, const char *format, ...) {
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        error->status = status;
        vsnprintf(error->message, sizeof error->message, format, arguments);
        va_end(arguments);
    }
    return status;
}

qn_status qni_fail_memory(qn_error *error, const char *what) {
    return qni_fail(error, QN_ERROR_OUT_OF_MEMORY, "not enough memory for %s", what);
}
