// SPDX-License-Identifier: MIT
/* quoin info of OpenVDB and NanoVDB files: the list of their grids, and what is sparse of one. */
#ifndef CLI_INFO_GRIDS_H
#define CLI_INFO_GRIDS_H

#include "session.h"

#include <jansson.h>

/* A file with several grids, or with none that can be read, and no --grid: print all of them. Sets
 * *done_out when that is all there is to say. Returns an exit code. */
int info_list_grids(cli_session *session, bool *done_out);

/* Leaves, tiles, background and class of a sparse volume; nothing, or NULL, for a dense one. */
void info_print_sparse(cli_session *session, const qn_volume *volume);
json_t *info_sparse_json(cli_session *session, const qn_volume *volume);

#endif
