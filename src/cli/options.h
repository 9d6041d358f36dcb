// SPDX-License-Identifier: MIT
/* Verbs and options of the tool: two tables, and what a command line said. */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <qn/qn.h>

typedef enum cli_verb {
    VERB_MESH,
    VERB_CSG,
    VERB_REMESH,
    VERB_SDF,
    VERB_INFO,
    VERB_CHECK,
    VERB_COMPARE,
    VERB_CONVERT,
    VERB_VIEW,
    VERB_HELP,
    VERB_COUNT
} cli_verb;

typedef struct cli_verb_row {
    const char *name;
    const char *synopsis;
    const char *summary;
    const char *description; /* NULL when the summary says all */
    const char *examples;    /* lines, each a command */
    int least_operands, most_operands;
} cli_verb_row;

extern const cli_verb_row cli_verbs[VERB_COUNT];

typedef struct cli_option_row {
    int id;
    char letter; /* 0: none */
    const char *name;
    const char *argument; /* NULL: takes none. "on|off" lists all that is allowed. */
    unsigned verbs;       /* bit 1 << verb for each verb that takes it */
    const char *section;  /* NULL: as the row before */
    const char *help;
} cli_option_row;

extern const cli_option_row cli_option_rows[];
extern const int cli_option_count;

typedef enum cli_progress_choice { PROGRESS_AUTO, PROGRESS_BAR, PROGRESS_NONE } cli_progress_choice;
typedef enum cli_inside_choice { INSIDE_ABOVE, INSIDE_BELOW, INSIDE_AUTO } cli_inside_choice;

typedef struct cli_options {
    cli_verb verb;
    const char *input, *output; /* borrowed from argv; NULL when not given */
    const char *second;         /* of compare: the other mesh */
    int64_t samples;
    bool help, version;
    double *isovalues;      /* [isovalue_count]; freed by cli_options_free() */
    int32_t isovalue_count; /* 0: automatic */
    bool triangles;
    bool open, closed_given, keep_doubled, exact_topology;
    cli_inside_choice inside;
    bool cms; /* --mode cms */
    bool creases_given;
    bool simplify, no_reproject;
    int32_t simplify_passes, relax;
    bool ascii, skip_normals, split_normals, curvature;
    char from[16], to[8];
    qn_volume_read_options read;
    bool dry_run, check, json;
    uint32_t fail_on; /* faults of verdict.h */
    bool fail_on_given;
    const char *report;
    int32_t threads;
    qn_device device;
    qn_untangle untangle;
    bool untangle_given;
    cli_progress_choice progress;
    bool quiet;
    int verbose;
    int32_t width, height;
    double azimuth, elevation, zoom;
    bool has_azimuth, has_elevation;
    bool edges, flat;
    qn_solid_surface_options solid; /* of csg */
    bool smooth_primitives;
    qn_mesh_sign sign;                     /* of remesh */
    int64_t cells;                         /* along the longest side; 0: by depth */
    double voxel;                          /* size of a cell; 0: by depth */
    bool dmc;                              /* --mode dmc was given */
    double band_width, band_offset, shell; /* of narrow bands; 0: the defaults */
    bool man, completion;
} cli_options;

/* Reads argv[2..] for a verb. Returns 0, or the exit code after having said what is wrong. */
int cli_options_parse(cli_verb verb, int argc, char **argv, cli_options *options);
void cli_options_free(cli_options *options);

#endif
