// SPDX-License-Identifier: MIT
/* Input files: which kind they are, and reading them with the options of the command line. */
#ifndef CLI_INPUT_H
#define CLI_INPUT_H

#include "session.h"

/* By --from, else by the name's ending, else by the first bytes; a file that tells nothing is a
 * volume. */
bool input_is_mesh(const cli_options *options);
/* By --from or the name's ending alone. */
bool input_is_volume(const cli_options *options);
/* The name's ending without ".gz", in lower case: "nii", "ply". "" when there is none. */
void input_ending(const char *path, char ending[8]);

/* Both return 0 or an exit code after having said what is wrong. */
int input_read_volume(cli_session *session, qn_volume **volume_out);
int input_read_mesh(cli_session *session, qn_mesh **mesh_out);
/* The same for another file than the first one named. */
int input_read_mesh_from(cli_session *session, const char *path, qn_mesh **mesh_out);

#endif
