// SPDX-License-Identifier: MIT
/* Output files: names and formats are looked at before the long work, so that it is not done in
 * vain. */
#ifndef CLI_OUTPUT_H
#define CLI_OUTPUT_H

#include "session.h"

/* Checks -o and --to of mesh and convert. Returns 0 or an exit code after having said what is
 * wrong. */
int output_check(const cli_options *options);
/* The format that the file will have: --to, else the name's ending. */
const char *output_format(const cli_options *options, char format[8]);
/* The name with {iso} filled in; to be freed. NULL when memory ran out. */
char *output_name(const char *pattern, double isovalue);
/* About the size of the file (exact for the binary formats, to some hundred bytes of header). */
int64_t output_estimate_bytes(const cli_options *options, int64_t vertices, int64_t quads,
                              int64_t triangles);
/* Writes a mesh; "-" is stdout. Returns 0 or an exit code. *bytes_out: size of the file, -1 for
 * none. */
int output_write_mesh(cli_session *session, const qn_mesh *mesh, const char *path,
                      int64_t *bytes_out);
/* True for the formats that hold triangles only. */
/* The name of a format that meshes are written in. */
bool output_is_mesh(const char *format);
bool output_splits_quads(const char *format);

#endif
