// SPDX-License-Identifier: MIT
/* Output files: early checks, names with {iso}, sizes, and stdout. */
#include "output.h"
#include "input.h"
#include "number.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static const char ISO_MARK[] = "{iso}";

bool output_is_mesh(const char *name) {
    static const char *const names[] = {"ply", "obj", "stl", "off", "glb"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcasecmp(name, names[i]) == 0)
            return true;
    return false;
}

bool output_splits_quads(const char *format) {
    return strcasecmp(format, "stl") == 0 || strcasecmp(format, "glb") == 0;
}

const char *output_format(const cli_options *options, char format[8]) {
    if (options->to[0])
        memcpy(format, options->to, sizeof options->to);
    else
        input_ending(options->output, format);
    return format;
}

/* The folder must be there before the work begins. */
static int check_folder(const char *path) {
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    struct stat info;
    int exit_code = 0;
    if (folder && (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))) {
        cli_say("%s: there is no folder %s: make it first", path, folder);
        exit_code = CLI_OUTPUT;
    }
    free(folder);
    return exit_code;
}

int output_check(const cli_options *options) {
    const char *verb = cli_verbs[options->verb].name;
    if (!options->output) {
        if (options->dry_run)
            return 0;
        return cli_usage("where to? name the output: quoin %s %s -o mesh.ply", verb,
                         options->input);
    }
    bool to_stdout = strcmp(options->output, "-") == 0;
    if (to_stdout && !options->to[0])
        return cli_usage("-o -: say the format: --to ply");
    if (to_stdout && options->report && strcmp(options->report, "-") == 0)
        return cli_usage("-o - and --report - both want stdout: name a file for one of them");
    size_t length = strlen(options->output);
    if (length > 3 && strcasecmp(options->output + length - 3, ".gz") == 0)
        return cli_usage("%s: meshes are not written as gzip: leave .gz out", options->output);
    char format[8];
    if (!output_is_mesh(output_format(options, format)))
        return cli_usage("%s: cannot tell the format: end the name in .ply, .obj, .stl, .off or "
                         ".glb, or add --to",
                         options->to[0] ? options->to : options->output);
    if (options->curvature && strcasecmp(format, "ply") != 0)
        return cli_usage("--curvature: only PLY files hold it: end the name in .ply");
    if (options->curvature && options->split_normals)
        return cli_usage("--curvature and --split-normals do not go together: choose one");
    if (options->isovalue_count > 1 && !strstr(options->output, ISO_MARK))
        return cli_usage("%d iso-values go into as many files: put {iso} into the name, for "
                         "example -o 'mesh_{iso}.ply'",
                         (int)options->isovalue_count);
    return to_stdout ? 0 : check_folder(options->output);
}

char *output_name(const char *pattern, double isovalue) {
    char number[NUMBER_TEXT_SIZE];
    const char *mark = strstr(pattern, ISO_MARK);
    if (!mark)
        return strdup(pattern);
    number_format_real(isovalue, number);
    size_t size = strlen(pattern) + strlen(number) + 1;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s%s%s", (int)(mark - pattern), pattern, number,
                 mark + strlen(ISO_MARK));
    return name;
}

int64_t output_estimate_bytes(const cli_options *options, int64_t vertices, int64_t quads,
                              int64_t triangles) {
    char format[8] = "ply";
    if (options->output)
        output_format(options, format);
    int64_t split = triangles + 2 * quads;
    int64_t normals = options->skip_normals ? 0 : vertices;
    if (strcasecmp(format, "stl") == 0)
        return options->ascii ? 260 * split : 84 + 50 * split;
    if (strcasecmp(format, "glb") == 0)
        return 1000 + 12 * (vertices + normals) + 12 * split;
    if (strcasecmp(format, "obj") == 0)
        return 32 * vertices + 32 * normals + (normals ? 68 : 34) * quads +
               (normals ? 52 : 26) * triangles;
    if (strcasecmp(format, "off") == 0)
        return 32 * vertices + 34 * quads + 26 * triangles;
    if (options->ascii)
        return 400 + 30 * (vertices + normals) + (options->curvature ? 20 * vertices : 0) +
               34 * quads + 26 * triangles;
    return 400 + 12 * (vertices + normals) + (options->curvature ? 8 * vertices : 0) + 17 * quads +
           13 * triangles;
}

/* Copies a file to stdout. */
static int copy_to_stdout(FILE *file) {
    char buffer[1 << 16];
    size_t got;
    while ((got = fread(buffer, 1, sizeof buffer, file)) > 0)
        if (fwrite(buffer, 1, got, stdout) != got)
            break;
    return cli_finish_stdout(0);
}

/* A file behind stdout ("> file", ">> file") belongs to the shell: it must not be replaced by
 * renaming, as the library does with files. So the bytes go by way of a temporary file. */
static int write_through_temporary(cli_session *session, const qn_mesh *mesh,
                                   const qn_mesh_write_options *write) {
    const char *folder = getenv("TMPDIR");
    char path[4096];
    snprintf(path, sizeof path, "%s/quoin-XXXXXX", folder && *folder ? folder : "/tmp");
    int descriptor = mkstemp(path);
    if (descriptor < 0) {
        cli_say("%s: cannot make a temporary file: %s; set TMPDIR to a folder with room", path,
                strerror(errno));
        return CLI_OUTPUT;
    }
    close(descriptor);
    qn_error error;
    int exit_code =
        cli_fail(session, qn_mesh_write(session->context, mesh, path, write, &error), &error);
    FILE *file = exit_code ? NULL : fopen(path, "rb");
    if (file) {
        exit_code = copy_to_stdout(file);
        fclose(file);
    }
    unlink(path);
    return exit_code;
}

int output_write_mesh(cli_session *session, const qn_mesh *mesh, const char *path,
                      int64_t *bytes_out) {
    const cli_options *options = session->options;
    qn_mesh_write_options write;
    qn_mesh_write_options_init(&write);
    memcpy(write.format, options->to, sizeof write.format);
    write.ascii = options->ascii;
    write.skip_normals = options->skip_normals;
    write.split_normals = options->split_normals;
    write.curvature = options->curvature;
    *bytes_out = -1;
    struct stat info;
    bool to_stdout = strcmp(path, "-") == 0;
    if (to_stdout && fstat(STDOUT_FILENO, &info) == 0 && S_ISREG(info.st_mode))
        return write_through_temporary(session, mesh, &write);
    qn_error error;
    qn_status status =
        qn_mesh_write(session->context, mesh, to_stdout ? "/dev/stdout" : path, &write, &error);
    if (status == QN_OK && !to_stdout && stat(path, &info) == 0 && S_ISREG(info.st_mode))
        *bytes_out = (int64_t)info.st_size;
    return cli_fail(session, status, &error);
}
