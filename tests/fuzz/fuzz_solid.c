// SPDX-License-Identifier: MIT
/* What the targets of the solid readers share. */
#include "fuzz/fuzz_solid.h"

#include <qn/qn.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "solid/solid.h"

static void demand(bool holds, const char *what) {
    if (holds)
        return;
    fprintf(stderr, "fuzz: %s\n", what);
    abort();
}

/* Crossings whose number agrees with the signs at the ends, values within their bounds. */
static void ask(const qn_solid *solid) {
    static const double ends[2][3] = {{-1.5, 0.125, 0.25}, {2.5, 0.375, 0.75}};
    double values[2], range[2], gradients[2][3];
    qni_box box = {{-1.5, 0.125, 0.25}, {2.5, 0.375, 0.75}};
    qni_crossing crossings[8];
    int32_t count, owners[2];
    qn_solid *restricted;
    demand(solid->ops->values(solid, 2, ends, values) == QN_OK, "no values");
    demand(solid->ops->gradients(solid, 2, ends, gradients, owners) == QN_OK, "no gradients");
    demand(solid->ops->bounds(solid, &box, range) == QN_OK, "no bounds");
    demand(values[0] >= range[0] && values[0] <= range[1] && values[1] >= range[0] &&
               values[1] <= range[1],
           "a value out of its bounds");
    demand(solid->ops->crossings(solid, ends[0], ends[1], 8, crossings, &count) == QN_OK,
           "no crossings");
    demand(count >= 0 && count <= 8, "too many crossings");
    demand((count % 2 != 0) == ((values[0] < 0) != (values[1] < 0)),
           "crossings that disagree with the ends");
    demand(solid->ops->restrict_to(solid, &box, &restricted) == QN_OK, "not restricted");
    qn_solid_destroy(restricted);
}

int fuzz_solid_read(const char *name, const uint8_t *bytes, size_t size) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = 1;
    qn_context *context;
    demand(qn_context_create(&options, &context, NULL) == QN_OK, "no context");
    for (int smooth = 0; smooth < 2; ++smooth) {
        qn_solid_read_options how;
        qn_solid_read_options_init(&how);
        how.smooth_primitives = smooth;
        qn_solid *solid;
        qn_error error = {0};
        qn_status status = qn_solid_read_text(context, name, (const char *)bytes, (int64_t)size,
                                              &how, &solid, &error);
        demand((status == QN_OK) == (solid != NULL),
               "a status that does not say whether there is a solid");
        demand(status == QN_OK || error.message[0], "a failure without a sentence");
        if (solid)
            ask(solid);
        qn_solid_destroy(solid);
    }
    demand(qn_context_memory(context).current_bytes == 0, "memory is left");
    qn_context_destroy(context);
    return 0;
}
