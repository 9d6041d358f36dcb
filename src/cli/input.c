// SPDX-License-Identifier: MIT
/* Input files. The library finds the exact format; here only volumes and meshes are told apart. */
#include "input.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static bool is_mesh_format(const char *name) {
    static const char *const names[] = {"ply", "obj", "stl", "off", "glb", "gltf"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcasecmp(name, names[i]) == 0)
            return true;
    return false;
}

static bool is_volume_ending(const char *name) {
    static const char *const names[] = {"nii", "hdr", "img", "nrrd", "nhdr", "mha", "mhd", "npy",
                                        "inr", "vol", "raw", "bin",  "dat",  "vdb", "nvdb"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcasecmp(name, names[i]) == 0)
            return true;
    return false;
}

void input_ending(const char *path, char ending[8]) {
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    size_t length = strlen(name);
    if (length > 3 && strcasecmp(name + length - 3, ".gz") == 0)
        length -= 3;
    size_t dot = length;
    while (dot > 0 && name[dot - 1] != '.')
        --dot;
    ending[0] = '\0';
    if (dot == 0 || length - dot >= 8)
        return;
    for (size_t i = dot; i < length; ++i)
        ending[i - dot] = (char)tolower((unsigned char)name[i]);
    ending[length - dot] = '\0';
}

static bool starts_like_a_mesh(const char *path) {
    char head[8] = "";
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode))
        return false; /* a pipe's first bytes can be read only once */
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    size_t got = fread(head, 1, sizeof head - 1, file);
    fclose(file);
    head[got] = '\0';
    head[strcspn(head, "\r\n")] = '\0';
    const char *off = strstr(head, "OFF"); /* OFF, COFF, STNOFF ... */
    return strcmp(head, "ply") == 0 || strncmp(head, "solid ", 6) == 0 ||
           (off && off == head + strspn(head, "STCN4n"));
}

bool input_is_mesh(const cli_options *options) {
    if (options->from[0])
        return is_mesh_format(options->from);
    char ending[8];
    input_ending(options->input, ending);
    if (is_mesh_format(ending))
        return true;
    return !is_volume_ending(ending) && options->read.raw_size[0] == 0 &&
           starts_like_a_mesh(options->input);
}

bool input_is_volume(const cli_options *options) {
    char ending[8];
    input_ending(options->input, ending);
    return options->from[0] ? !is_mesh_format(options->from) : is_volume_ending(ending);
}

int input_read_volume(cli_session *session, qn_volume **volume_out) {
    const cli_options *options = session->options;
    qn_volume_read_options read = options->read;
    memcpy(read.format, options->from, sizeof read.format);
    qn_error error;
    return cli_fail(session,
                    qn_volume_read(session->context, options->input, &read, volume_out, &error),
                    &error);
}

static int read_mesh(cli_session *session, const char *path, bool is_mesh, qn_mesh **mesh_out) {
    const cli_options *options = session->options;
    if (!is_mesh && !options->from[0]) {
        cli_say("%s: that is not a mesh file; make a mesh of a volume first: quoin mesh %s -o "
                "mesh.ply",
                path, path);
        return CLI_USAGE;
    }
    qn_error error;
    return cli_fail(session, qn_mesh_read(session->context, path, options->from, mesh_out, &error),
                    &error);
}

int input_read_mesh(cli_session *session, qn_mesh **mesh_out) {
    return read_mesh(session, session->options->input, input_is_mesh(session->options), mesh_out);
}

int input_read_mesh_from(cli_session *session, const char *path, qn_mesh **mesh_out) {
    cli_options options = *session->options;
    options.input = path;
    return read_mesh(session, path, input_is_mesh(&options), mesh_out);
}
