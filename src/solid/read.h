// SPDX-License-Identifier: MIT
/* Readers of solids: each takes the whole text. */
#ifndef QNI_SOLID_READ_H
#define QNI_SOLID_READ_H

#include "solid/text.h"

/* One operation a line: NAME OPERATION OPERANDS; the last one is the solid's function. */
qn_status qni_read_vm(qn_context *context, const qni_text *text, const qni_box *region,
                      qn_solid **solid_out, qn_error *error);
/* OpenSCAD's flattened CSG trees. */
qn_status qni_read_csg(qn_context *context, const qni_text *text, bool smooth, qn_solid **solid_out,
                       qn_error *error);

#endif
