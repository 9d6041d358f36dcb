// SPDX-License-Identifier: MIT
/* What a command line says, read by the table of options (option_table.c). */
#include "options.h"
#include "option_table.h"
#include "option_values.h"
#include "nearest.h"
#include "number.h"
#include "session.h"
#include "verdict.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Finds the text among "a|b|c" of the row. */
static bool choose(const cli_option_row *row, const char *text, int *index_out) {
    const char *choice = row->argument;
    size_t length = strlen(text);
    for (int index = 0;; ++index) {
        size_t size = strcspn(choice, "|");
        if (size == length && strncmp(choice, text, size) == 0) {
            *index_out = index;
            return true;
        }
        if (!choice[size])
            break;
        choice += size + 1;
    }
    cli_say("--%s %s: choose one of %s", row->name, text, row->argument);
    return false;
}

static bool copy_word(const cli_option_row *row, const char *text, char *word, size_t size) {
    if (strlen(text) >= size || !*text) {
        cli_say("--%s %s: no such format; see 'quoin help'", row->name, text);
        return false;
    }
    memcpy(word, text, strlen(text) + 1);
    return true;
}

static bool set_whole(const cli_option_row *row, const char *text, int64_t most,
                      const char *example, int64_t *value_out) {
    if (number_parse_integer(text, value_out) && *value_out >= 0 && *value_out <= most)
        return true;
    return option_wrong(row, text, example);
}

static bool set_finite(const cli_option_row *row, const char *text, const char *example,
                       double *value_out) {
    if (number_parse_real(text, value_out) && isfinite(*value_out))
        return true;
    return option_wrong(row, text, example);
}

/* Options whose value is taken from a list. Returns an exit code. */
static int apply_choice(cli_options *options, const cli_option_row *row, const char *text) {
    int index;
    if (!choose(row, text, &index))
        return CLI_USAGE;
    switch (row->id) {
    case OPTION_INSIDE:
        options->inside = (cli_inside_choice)index;
        break;
    case OPTION_CLOSED:
        options->open = index == 1;
        options->closed_given = true;
        break;
    case OPTION_TOPOLOGY:
        options->exact_topology = index == 1;
        break;
    case OPTION_UNTANGLE:
        options->untangle = index == 0   ? QN_UNTANGLE_ON
                            : index == 1 ? QN_UNTANGLE_OFF
                                         : QN_UNTANGLE_ALL;
        options->untangle_given = true;
        break;
    case OPTION_CREASES:
        options->solid.creases = index == 0   ? QN_CREASES_AUTO
                                 : index == 1 ? QN_CREASES_ON
                                              : QN_CREASES_OFF;
        options->creases_given = true;
        break;
    case OPTION_MANIFOLD:
        options->keep_doubled = index == 1;
        break;
    case OPTION_TRANSFORM:
        options->read.transform = (qn_transform_choice)index;
        break;
    case OPTION_PROGRESS:
        options->progress = (cli_progress_choice)index;
        break;
    case OPTION_MODE:
        options->cms = index == 1;
        options->dmc = index == 0;
        break;
    case OPTION_SIGN:
        options->sign = (qn_mesh_sign)index;
        break;
    case OPTION_DEVICE:
        options->device = (qn_device)index;
        break;
    }
    return 0;
}

/* Options without an argument. */
static void apply_flag(cli_options *options, const cli_option_row *row) {
    switch (row->id) {
    case OPTION_QUADS:
        options->triangles = false;
        break;
    case OPTION_TRIS:
        options->triangles = true;
        break;
    case OPTION_SIMPLIFY:
        options->simplify = true;
        break;
    case OPTION_NO_REPROJECT:
        options->no_reproject = true;
        break;
    case OPTION_NO_NORMALS:
        options->skip_normals = true;
        break;
    case OPTION_ASCII:
        options->ascii = true;
        break;
    case OPTION_DRY_RUN:
        options->dry_run = true;
        break;
    case OPTION_CHECK:
        options->check = true;
        break;
    case OPTION_JSON:
        options->json = true;
        break;
    case OPTION_EDGES:
        options->edges = true;
        break;
    case OPTION_FLAT:
        options->flat = true;
        break;
    case OPTION_QUIET:
        options->quiet = true;
        break;
    case OPTION_KEEP_FLAT:
        options->solid.keep_flat = true;
        break;
    case OPTION_NO_FEATURES:
        options->solid.no_features = true;
        break;
    case OPTION_CURVATURE:
        options->curvature = true;
        break;
    case OPTION_SPLIT_NORMALS:
        options->split_normals = true;
        break;
    case OPTION_UNIFORM:
        options->solid.uniform = true;
        break;
    case OPTION_SMOOTH:
        options->smooth_primitives = true;
        break;
    case OPTION_VERBOSE:
        options->verbose++;
        break;
    case OPTION_HELP:
        options->help = true;
        break;
    case OPTION_VERSION:
        options->version = true;
        break;
    case OPTION_MAN:
        options->man = true;
        break;
    case OPTION_COMPLETION:
        options->completion = true;
        break;
    }
}

static bool set_box(cli_options *options, const cli_option_row *row, const char *text) {
    double corners[6];
    if (!number_parse_reals(text, ',', 6, corners))
        return option_wrong(row, text, "-1,-1,-1,1,1,1");
    for (int axis = 0; axis < 3; ++axis) {
        options->solid.low[axis] = corners[axis];
        options->solid.high[axis] = corners[3 + axis];
        if (!(isfinite(corners[axis]) && isfinite(corners[3 + axis]) &&
              corners[axis] < corners[3 + axis]))
            return option_wrong(row, text, "-1,-1,-1,1,1,1 (low corner, high corner)");
    }
    return options->solid.has_box = true;
}

static bool set_positive(const cli_option_row *row, const char *text, const char *example,
                         double *value_out) {
    return set_finite(row, text, example, value_out) &&
           (*value_out > 0 || option_wrong(row, text, example));
}

/* Options with an argument of their own form. */
static bool apply_value(cli_options *options, const cli_option_row *row, const char *text) {
    int64_t whole = 0;
    bool good = true;
    switch (row->id) {
    case OPTION_OUTPUT:
        options->output = text;
        break;
    case OPTION_REPORT:
        options->report = text;
        break;
    case OPTION_ISO:
        return option_set_isovalues(options, row, text);
    case OPTION_SPACING:
        return option_set_spacing(options, row, text);
    case OPTION_ORIGIN:
        return option_set_origin(options, row, text);
    case OPTION_SHAPE:
        return option_set_shape(options, row, text);
    case OPTION_DTYPE:
        return option_set_dtype(options, row, text);
    case OPTION_SIZE:
        return option_set_size(options, row, text);
    case OPTION_FROM:
        return copy_word(row, text, options->from, sizeof options->from);
    case OPTION_GRID:
        if (strlen(text) >= sizeof options->read.grid)
            return option_wrong(row, text, "density (at most 63 letters)");
        memcpy(options->read.grid, text, strlen(text) + 1);
        break;
    case OPTION_TO:
        return copy_word(row, text, options->to, sizeof options->to);
    case OPTION_FAIL_ON:
        options->fail_on_given = true;
        return verdict_parse_faults(text, &options->fail_on);
    case OPTION_HEADER:
        return set_whole(row, text, INT64_MAX, "352 (a number of bytes)",
                         &options->read.raw_header);
    case OPTION_THREADS:
        good = set_whole(row, text, 4096, "4 (0 to 4096)", &whole);
        options->threads = (int32_t)whole;
        break;
    case OPTION_SIMPLIFY_PASSES:
        options->simplify = true;
        options->simplify_passes = -1;
        if (strcmp(text, "paper") == 0)
            return true;
        good = set_whole(row, text, 1000000, "2 (0 to 1000000) or --simplify-passes paper", &whole);
        options->simplify_passes = (int32_t)whole;
        break;
    case OPTION_RELAX:
        good = set_whole(row, text, 1000000, "3 (0 to 1000000)", &whole);
        options->relax = (int32_t)whole;
        break;
    case OPTION_AZIMUTH:
        options->has_azimuth = true;
        return set_finite(row, text, "120", &options->azimuth);
    case OPTION_ELEVATION:
        options->has_elevation = true;
        return set_finite(row, text, "25", &options->elevation);
    case OPTION_BOX:
        return set_box(options, row, text);
    case OPTION_TOLERANCE:
        return set_positive(row, text, "0.01 (a length above 0)", &options->solid.tolerance);
    case OPTION_CREASE:
        return set_positive(row, text, "30 (degrees above 0)", &options->solid.crease);
    case OPTION_SAMPLES:
        good = set_whole(row, text, INT64_C(1000000000), "100000 (1 to 1000000000)", &whole);
        options->samples = whole;
        return good && (whole >= 1 || option_wrong(row, text, "100000 (1 to 1000000000)"));
    case OPTION_BAND:
        return set_positive(row, text, "3 (voxels, 2 or more)", &options->band_width) &&
               (options->band_width >= 2 || option_wrong(row, text, "3 (voxels, 2 or more)"));
    case OPTION_OFFSET:
        return set_finite(row, text, "0.5 (a length)", &options->band_offset);
    case OPTION_SHELL:
        return set_positive(row, text, "0.5 (a length above 0)", &options->shell);
    case OPTION_VOXEL:
        return set_positive(row, text, "0.2 (a length above 0)", &options->voxel);
    case OPTION_DIM:
        good = set_whole(row, text, (int64_t)qn_depth_cells(QN_MAX_DEPTH), "128 (5 to 3968)",
                         &options->cells);
        return good && (options->cells >= 5 || option_wrong(row, text, "128 (5 to 3968)"));
    case OPTION_DEPTH:
        good = set_whole(row, text, QN_MAX_DEPTH, "7 (3 to 12)", &whole);
        options->solid.depth = (int32_t)whole;
        return good && (whole >= QN_MIN_DEPTH || option_wrong(row, text, "7 (3 to 12)"));
    case OPTION_BASE:
        good = set_whole(row, text, 4096, "8 (a power of two)", &whole);
        options->solid.base = (int32_t)whole;
        return good && (whole >= 1 || option_wrong(row, text, "8 (a power of two)"));
    case OPTION_ZOOM:
        if (!set_finite(row, text, "1.5", &options->zoom))
            return false;
        return options->zoom > 0 || option_wrong(row, text, "1.5 (more than 0)");
    }
    return good;
}

static bool is_choice(const cli_option_row *row) {
    return row->id == OPTION_INSIDE || row->id == OPTION_CLOSED || row->id == OPTION_MANIFOLD ||
           row->id == OPTION_TOPOLOGY || row->id == OPTION_UNTANGLE ||
           row->id == OPTION_TRANSFORM || row->id == OPTION_PROGRESS || row->id == OPTION_MODE ||
           row->id == OPTION_SIGN || row->id == OPTION_DEVICE || row->id == OPTION_CREASES;
}

static int apply(cli_options *options, const cli_option_row *row, const char *text) {
    if (!(row->verbs & 1u << options->verb)) {
        char verbs[128] = "";
        for (int verb = 0; verb < VERB_COUNT; ++verb)
            if (row->verbs & 1u << verb) {
                strcat(verbs, *verbs ? ", " : "");
                strcat(verbs, cli_verbs[verb].name);
            }
        return cli_usage("--%s is not an option of 'quoin %s' but of: %s", row->name,
                         cli_verbs[options->verb].name, verbs);
    }
    if (!row->argument) {
        apply_flag(options, row);
        return 0;
    }
    if (is_choice(row))
        return apply_choice(options, row, text);
    return apply_value(options, row, text) ? 0 : CLI_USAGE;
}

static const cli_option_row *find_row(int code) {
    for (int i = 0; i < cli_option_count; ++i)
        if (cli_option_rows[i].id == code || (code && cli_option_rows[i].letter == code))
            return &cli_option_rows[i];
    return NULL;
}

static int unknown_option(const cli_options *options, const char *text) {
    const char *names[128];
    int count = 0;
    for (int i = 0; i < cli_option_count && count < 128; ++i)
        if (cli_option_rows[i].verbs & 1u << options->verb)
            names[count++] = cli_option_rows[i].name;
    const char *close = strncmp(text, "--", 2) == 0 ? nearest_word(text + 2, names, count) : NULL;
    if (close)
        return cli_usage("%s is not an option of 'quoin %s'; did you mean --%s?", text,
                         cli_verbs[options->verb].name, close);
    return cli_usage("%s is not an option of 'quoin %s'; see 'quoin help %s'", text,
                     cli_verbs[options->verb].name, cli_verbs[options->verb].name);
}

static int bad_option(const cli_options *options, int code, char **argv) {
    char letter[3] = {'-', (char)optopt, '\0'};
    const cli_option_row *row = find_row(optopt);
    if (code == ':' && row)
        return cli_usage("--%s needs an argument: --%s %s", row->name, row->name, row->argument);
    if (row && optopt >= OPTION_FIRST)
        return cli_usage("--%s takes no argument", row->name);
    return unknown_option(options, optopt && !row ? letter : argv[optind - 1]);
}

static int read_operands(cli_options *options, int argc, char **argv) {
    const cli_verb_row *verb = &cli_verbs[options->verb];
    int count = argc - optind;
    if (options->help || options->version)
        return 0;
    if (count < verb->least_operands)
        return cli_usage("which file? quoin %s %s", verb->name, verb->synopsis);
    if (count > verb->most_operands)
        return cli_usage("%s: one file too many; quoin %s %s", argv[optind + verb->most_operands],
                         verb->name, verb->synopsis);
    options->input = count > 0 ? argv[optind] : NULL;
    if (options->input && strcmp(options->input, "-") == 0) {
        if (!options->from[0])
            return cli_usage("- (stdin): say the format: --from nifti");
        options->input = "/dev/stdin";
    }
    if (options->verb == VERB_COMPARE) {
        options->second = count > 1 ? argv[optind + 1] : NULL;
        return 0;
    }
    if (count > 1 && options->output)
        return cli_usage("%s and -o %s: give one output", argv[optind + 1], options->output);
    if (count > 1)
        options->output = argv[optind + 1];
    return 0;
}

int cli_options_parse(cli_verb verb, int argc, char **argv, cli_options *options) {
    struct option long_options[128] = {{0}};
    char letters[64] = ":", *letter = letters + 1;
    for (int i = 0; i < cli_option_count; ++i) {
        const cli_option_row *row = &cli_option_rows[i];
        long_options[i].name = row->name;
        long_options[i].has_arg = row->argument ? required_argument : no_argument;
        long_options[i].val = row->id;
        if (row->letter) {
            *letter++ = row->letter;
            if (row->argument)
                *letter++ = ':';
        }
    }
    *letter = '\0';
    memset(options, 0, sizeof *options);
    options->verb = verb;
    options->inside = INSIDE_AUTO;
    options->untangle = QN_UNTANGLE_ON;
    qn_volume_read_options_init(&options->read);
    qn_solid_surface_options_init(&options->solid);
    opterr = 0;
    optind = 2;
    int code;
    while ((code = getopt_long(argc, argv, letters, long_options, NULL)) != -1) {
        const cli_option_row *row = code == '?' || code == ':' ? NULL : find_row(code);
        int exit_code = row ? apply(options, row, optarg) : bad_option(options, code, argv);
        if (exit_code)
            return exit_code;
    }
    return read_operands(options, argc, argv);
}

void cli_options_free(cli_options *options) {
    free(options->isovalues);
    options->isovalues = NULL;
}
