// SPDX-License-Identifier: MIT
/* A mesh or a solid as a narrow band, as the options of sdf, remesh and csg say. */
#ifndef CLI_BAND_INPUT_H
#define CLI_BAND_INPUT_H

#include "report.h"
#include "session.h"

typedef struct band_input {
    qn_volume *volume;
    qn_band_report band;
    json_t *report; /* of the band; to be dropped */
    double seconds_read, seconds_band;
} band_input;

/* True when the options ask for more than the model's own surface. */
bool band_is_asked_for(const cli_options *options);
/* Reads the input, a mesh or (by its ending, .csg or .vm) a solid, and makes its band. Returns 0 or
 * an exit code after having said what is wrong. */
int band_read(cli_session *session, band_input *input);
/* The same for a solid at hand. */
int band_of_solid(cli_session *session, const qn_solid *solid, band_input *input);
void band_free(band_input *input);

#endif
