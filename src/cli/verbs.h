// SPDX-License-Identifier: MIT
/* The verbs: each does its whole work and returns the exit code. */
#ifndef CLI_VERBS_H
#define CLI_VERBS_H

#include "session.h"

int verb_mesh(cli_session *session);
int verb_csg(cli_session *session);
int verb_remesh(cli_session *session);
int verb_sdf(cli_session *session);
int verb_info(cli_session *session);
int verb_check(cli_session *session);
int verb_compare(cli_session *session);
int verb_convert(cli_session *session);
int verb_view(cli_session *session);

#endif
