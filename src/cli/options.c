// SPDX-License-Identifier: MIT
/* The one table of options. Parsing is here; help, man page and completion (help.c) read the same
 * rows. */
#include "options.h"
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

enum {
    OPTION_FIRST = 256,
    OPTION_OUTPUT,
    OPTION_ISO,
    OPTION_MODE,
    OPTION_SIMPLIFY,
    OPTION_SIMPLIFY_PASSES,
    OPTION_NO_REPROJECT,
    OPTION_RELAX,
    OPTION_QUADS,
    OPTION_TRIS,
    OPTION_CLOSED,
    OPTION_MANIFOLD,
    OPTION_TOPOLOGY,
    OPTION_UNTANGLE,
    OPTION_INSIDE,
    OPTION_NO_NORMALS,
    OPTION_FROM,
    OPTION_TRANSFORM,
    OPTION_SPACING,
    OPTION_ORIGIN,
    OPTION_SHAPE,
    OPTION_DTYPE,
    OPTION_HEADER,
    OPTION_GRID,
    OPTION_TO,
    OPTION_ASCII,
    OPTION_DRY_RUN,
    OPTION_CHECK,
    OPTION_FAIL_ON,
    OPTION_REPORT,
    OPTION_JSON,
    OPTION_SIZE,
    OPTION_AZIMUTH,
    OPTION_ELEVATION,
    OPTION_ZOOM,
    OPTION_EDGES,
    OPTION_FLAT,
    OPTION_DEPTH,
    OPTION_DIM,
    OPTION_VOXEL,
    OPTION_SIGN,
    OPTION_BAND,
    OPTION_OFFSET,
    OPTION_SHELL,
    OPTION_BASE,
    OPTION_TOLERANCE,
    OPTION_CREASE,
    OPTION_SPLIT_NORMALS,
    OPTION_CURVATURE,
    OPTION_CREASES,
    OPTION_BOX,
    OPTION_NO_FEATURES,
    OPTION_UNIFORM,
    OPTION_SMOOTH,
    OPTION_SAMPLES,
    OPTION_THREADS,
    OPTION_DEVICE,
    OPTION_PROGRESS,
    OPTION_QUIET,
    OPTION_VERBOSE,
    OPTION_HELP,
    OPTION_VERSION,
    OPTION_MAN,
    OPTION_COMPLETION
};

enum {
    MESH = 1 << VERB_MESH,
    CSG = 1 << VERB_CSG,
    REMESH = 1 << VERB_REMESH,
    SDF = 1 << VERB_SDF,
    INFO = 1 << VERB_INFO,
    CHECK = 1 << VERB_CHECK,
    COMPARE = 1 << VERB_COMPARE,
    CONVERT = 1 << VERB_CONVERT,
    VIEW = 1 << VERB_VIEW,
    HELP = 1 << VERB_HELP,
    WORK = MESH | CSG | REMESH | SDF | INFO | CHECK | COMPARE | CONVERT | VIEW
};

// clang-format off
const cli_verb_row cli_verbs[VERB_COUNT] = {
    {"mesh", "VOLUME -o MESH [options]", "make the iso-surface of a volume as a mesh",
     "Reads NIfTI, NRRD, MetaImage, NumPy and raw volumes, and sparse OpenVDB and NanoVDB ones; writes PLY, OBJ, STL, OFF and GLB in world coordinates, "
     "with shared vertices and faces wound counter-clockwise seen from outside.",
     "quoin mesh ct.nii.gz --iso 300 -o bone.ply\n"
     "quoin mesh ct.nii.gz --iso 300,-500 -o 'tissue_{iso}.stl'\n"
     "quoin mesh dragon.vdb -o dragon.ply\n"
     "quoin mesh v.raw --shape 512,512,300 --dtype i16le --spacing 0.5,0.5,1.2 --iso 150 -o v.glb\n"
     "cat ct.nii.gz | quoin mesh - --from nifti --iso 300 -o - --to ply | other-program", 1, 1},
    {"csg", "MODEL -o MESH [options]", "make the surface of a solid as a mesh, its sharp edges kept, coarse where it is flat",
     "Reads .csg (OpenSCAD) and .vm (expressions, one operation a line). The mesh is closed, 2-manifold and free of self-intersections.",
     "quoin csg bracket.csg -o bracket.stl\n"
     "quoin csg bracket.csg --depth 9 --tol 0.01 --smooth-primitives -o bracket.ply", 1, 1},
    {"remesh", "MODEL -o MESH [options]", "make the surface of a polygon model anew, sharp edges kept, whatever is broken in it",
     "Reads PLY, OBJ, STL, OFF and GLB: triangles, quads and polygons. Parts that overlap become one, holes are closed, faces that are turned "
     "the wrong way are turned. The mesh is closed, 2-manifold and free of self-intersections.",
     "quoin remesh scan.stl -o clean.stl\n"
     "quoin remesh part.obj --voxel 0.2 --crease 20 -o part.ply --check\n"
     "quoin remesh broken.ply --dim 256 --sign winding -o whole.ply --report broken.json", 1, 1},
    {"sdf", "MODEL -o VOLUME [options]", "the signed distances to a polygon model, as a sparse or dense volume",
     "Reads PLY, OBJ, STL, OFF and GLB (and .csg and .vm, whose values are distances only where their function is one); writes .vdb (the narrow band alone), .npy and .nii (its box). Distances are exact to the nearest triangle, negative inside.",
     "quoin sdf part.stl --voxel 0.5 -o part.vdb\nquoin sdf part.stl --dim 200 --offset 1.5 --shell 0.8 -o wall.nii", 1, 1},
    {"info", "VOLUME|MESH [options]", "say what a file holds, and which iso-values are worth a try", NULL,
     "quoin info ct.nii.gz\n"
     "quoin info --json ct.nii.gz", 1, 1},
    {"check", "MESH [options]", "say whether a mesh is closed, manifold, oriented and free of self-intersections",
     "Prints a table and a verdict on stdout. Exits 6 when a fault named by --fail-on is found; by default these are "
     "open, nonmanifold, orientation, intersect and nonfinite.",
     "quoin check bone.ply\n"
     "quoin check bone.ply --fail-on open,orientation", 1, 1},
    {"compare", "MESH MESH [options]", "say how far two meshes are apart, one way and the other",
     "Measures all vertices and points spread evenly over the area, each to the nearest triangle of the other mesh. With --tol it exits 6 when the largest distance is more.",
     "quoin compare model.stl remeshed.ply\nquoin compare model.stl remeshed.ply --tol 0.05 --report apart.json", 2, 2},
    {"convert", "MESH MESH [options]", "copy a mesh, or a volume, into another format",
     "Meshes become PLY, OBJ, STL, OFF or GLB; volumes become .npy or .nii, sparse ones .vdb too.",
     "quoin convert bone.ply bone.stl\n"
     "quoin convert smoke.nvdb smoke.vdb\n"
     "quoin convert bone.ply -o bone.obj --tris", 1, 2},
    {"view", "MESH -o PICTURE.png [options]", "draw a shaded picture of a mesh, without display or GPU", NULL,
     "quoin view bone.ply -o bone.png\n"
     "quoin view bone.ply -o bone.png --size 1200x900 --azimuth 120 --edges", 1, 1},
    {"help", "[VERB]", "show help for the tool or a verb", NULL, "quoin help mesh", 0, 1},
};

const cli_option_row cli_option_rows[] = {
    {OPTION_OUTPUT, 'o', "output", "FILE", MESH | CSG | REMESH | SDF | CONVERT | VIEW, "Output",
     "the file to write; - is stdout (then --to is needed). With several iso-values the name holds {iso}."},
    {OPTION_TO, 0, "to", "FORMAT", MESH | CSG | REMESH | CONVERT, NULL,
     "ply, obj, stl, off or glb, whatever the file is called"},
    {OPTION_ASCII, 0, "ascii", NULL, MESH | CSG | REMESH | CONVERT, NULL, "PLY and STL as text instead of binary"},
    {OPTION_NO_NORMALS, 0, "no-normals", NULL, MESH | CONVERT, NULL, "leave the vertex normals out"},
    {OPTION_JSON, 0, "json", NULL, INFO | CHECK | COMPARE, NULL, "print JSON on stdout instead of a table"},
    {OPTION_REPORT, 0, "report", "FILE", MESH | CSG | REMESH | SDF | CHECK | COMPARE, NULL,
     "write a JSON report (- is stdout): input, options, counts, timings, memory and all of check"},

    {OPTION_ISO, 0, "iso", "V[,V...]|auto", MESH, "Surface",
     "iso-values; auto (the default) takes 0 for a level set, else the one that info suggests; a fog volume wants it stated"},
    {OPTION_INSIDE, 0, "inside", "above|below|auto", MESH, NULL,
     "which side is solid. auto takes below for signed distances (a level set, or a float volume with both signs whose "
     "suggested iso-value is 0), else above."},
    {OPTION_CLOSED, 0, "closed", "on|off", MESH | CSG | REMESH, NULL,
     "on (the default) closes the surface half a voxel outside the outermost samples, or where --box cuts a solid; off leaves it open"},
    {OPTION_MANIFOLD, 0, "manifold", "on|off", MESH, NULL,
     "on (the default) takes edges of four faces apart, so that a closed mesh is a 2-manifold; off leaves them"},
    {OPTION_TOPOLOGY, 0, "topology", "discs|exact", MESH, NULL,
     "discs (the default) makes each polygon of a cell a disc; exact restores the tunnels by which the trilinear interpolant "
     "joins two of them inside a cell, so that a closed mesh has its topology"},
    {OPTION_QUADS, 0, "quads", NULL, MESH, NULL, "quads (the default)"},
    {OPTION_TRIS, 0, "tris", NULL, MESH | CSG | REMESH | CONVERT, NULL, "triangles: each quad split so that its smallest angle is largest"},
    {OPTION_UNTANGLE, 0, "untangle", "on|off|all", MESH | CSG | REMESH, NULL,
     "--mode dmc: on (the default) moves vertices off the surface, by some tenths of a voxel, where faces would cross each other; looked for "
     "where it is likely; all looks everywhere, which takes much longer; off leaves every vertex on the surface"},
    {OPTION_SIMPLIFY, 0, "simplify", NULL, MESH, NULL,
     "remove quads of valences 3-X-3-Y and 3-3-3-3: fewer irregular vertices, the same topology"},
    {OPTION_SIMPLIFY_PASSES, 0, "simplify-passes", "N|paper", MESH, NULL,
     "--simplify, but at most N passes (0, the default: until nothing is left), or the single pass of the published rule"},
    {OPTION_NO_REPROJECT, 0, "no-reproject", NULL, MESH, NULL,
     "leave the vertices made by --simplify between the two they replace instead of putting them back onto the surface"},
    {OPTION_RELAX, 0, "relax", "N", MESH, NULL,
     "N sweeps that slide the vertices along the surface towards squarer quads (0); 3 to 5 do most of it"},
    {OPTION_MODE, 0, "mode", "dmc|cms", MESH | CSG | REMESH, NULL, "the surfacer: dmc, dual marching cubes (the default of mesh): quads on a uniform lattice; or cms, adaptive cubical marching squares (the default of csg and remesh): triangles, few where it is flat"},

    {OPTION_DEPTH, 0, "depth", "D", CSG | REMESH, "Surface of a solid (csg, remesh, mesh --mode cms)", "at most 2^D finest cells along the longest axis, 3 to 12 (7)"},
    {OPTION_DIM, 0, "dim", "N", CSG | REMESH | SDF, NULL, "so many finest cells along the model's longest side, instead of --depth"},
    {OPTION_VOXEL, 0, "voxel", "LENGTH", CSG | REMESH | SDF, NULL, "the size of the finest cells, instead of --depth"},
    {OPTION_SIGN, 0, "sign", "auto|parity|winding", REMESH | SDF, NULL,
     "what says which side is inside. winding: the winding number is not 0, or where the model is open the generalized one is 1/2 or more; "
     "parity: behind an odd number of faces, holes closed by flat fans; auto (the default): winding, and parity where faces are closed "
     "but cannot be made to agree."},
    {OPTION_BAND, 0, "band", "VOXELS", REMESH | SDF, NULL, "half the width of a narrow band of distances (3)"},
    {OPTION_OFFSET, 0, "offset", "LENGTH", REMESH | SDF, NULL, "the surface of all points so far outside the model (round at its edges); negative: inside"},
    {OPTION_SHELL, 0, "shell", "THICKNESS", REMESH | SDF, NULL, "a wall along the surface, half to each side of it"},
    {OPTION_BASE, 0, "base", "N", MESH | CSG | REMESH, NULL, "coarsest cells along the longest axis, a power of two (8)"},
    {OPTION_TOLERANCE, 0, "tol", "LENGTH", MESH | CSG | REMESH | COMPARE, NULL, "how far coarse triangles may be from the fine samples (a twentieth of a finest cell); of compare: the largest distance that is good"},
    {OPTION_CREASE, 0, "crease", "DEGREES", MESH | CSG | REMESH, NULL, "normals that differ by more make a sharp edge (30)"},
    {OPTION_SPLIT_NORMALS, 0, "split-normals", NULL, CSG | REMESH, NULL, "write normals that jump at sharp edges: vertices there are doubled in PLY, OBJ and GLB files"},
    {OPTION_CURVATURE, 0, "curvature", NULL, MESH | CSG | REMESH | CONVERT, NULL, "write mean and Gaussian curvature at vertices: mean_curvature and gaussian_curvature in PLY files"},
    {OPTION_CREASES, 0, "creases", "auto|on|off", MESH, NULL, "volumes in mode cms: have the samples sharp edges? auto says so of distances: level sets, and floats below 0 inside whose slopes are of unit length"},
    {OPTION_BOX, 0, "box", "X,Y,Z,X,Y,Z", CSG, NULL, "low and high corner: the solid is cut there"},
    {OPTION_NO_FEATURES, 0, "no-features", NULL, MESH | CSG | REMESH, NULL, "plain marching cubes: no sharp edges"},
    {OPTION_UNIFORM, 0, "uniform", NULL, MESH | CSG | REMESH, NULL, "finest cells only"},
    {OPTION_SMOOTH, 0, "smooth-primitives", NULL, CSG, NULL, "round spheres and cylinders where OpenSCAD has facets"},

    {OPTION_FROM, 0, "from", "FORMAT", WORK, "Input",
     "nifti, nrrd, metaimage, npy, inr, mitsuba, vdb, nvdb or raw; ply, obj, stl, off, glb or gltf. By default the name and the first bytes tell; the input - (stdin) needs it."},
    {OPTION_TRANSFORM, 0, "transform", "auto|sform|qform|pixdim", MESH | INFO, NULL,
     "which placement of a NIfTI file to use; auto takes the one with the higher code"},
    {OPTION_SPACING, 0, "spacing", "X,Y,Z", MESH | INFO, NULL, "distance between samples, instead of the header's"},
    {OPTION_ORIGIN, 0, "origin", "X,Y,Z", MESH | INFO | SDF, NULL, "place of the first sample, instead of the header's"},
    {OPTION_SHAPE, 0, "shape", "X,Y,Z", MESH | INFO, NULL, "raw files: samples along x (fastest), y and z"},
    {OPTION_DTYPE, 0, "dtype", "TYPE", MESH | INFO, NULL,
     "raw files: u8 i8 u16 i16 u32 i32 f32 f64, with le or be for the byte order (little when left out)"},
    {OPTION_HEADER, 0, "header", "BYTES", MESH | INFO, NULL, "raw files: bytes to skip at the start (after unpacking gzip)"},
    {OPTION_GRID, 0, "grid", "NAME", MESH | INFO | CONVERT, NULL, "OpenVDB and NanoVDB files with several grids: the one to read"},

    {OPTION_CHECK, 0, "check", NULL, MESH | CSG | REMESH, "Checks",
     "check the mesh; exit 6 when it is not oriented, or (unless --closed off) not closed or not manifold"},
    {OPTION_FAIL_ON, 0, "fail-on", "LIST", MESH | CSG | REMESH | CHECK, NULL,
     "the faults that make the exit code 6, out of open, nonmanifold, orientation, intersect, degenerate, duplicate, "
     "nonfinite; or all, or none"},
    {OPTION_DRY_RUN, 0, "dry-run", NULL, MESH | CSG | REMESH, NULL, "count and estimate memory and file size; write no mesh"},

    {OPTION_SAMPLES, 0, "samples", "N", COMPARE, "Distances", "points on each mesh, beside its vertices (100000)"},

    {OPTION_SIZE, 0, "size", "WxH", VIEW, "Picture", "width and height in pixels (800x600)"},
    {OPTION_AZIMUTH, 0, "azimuth", "DEGREES", VIEW, NULL, "where the camera stands, turning from +x towards +y (40)"},
    {OPTION_ELEVATION, 0, "elevation", "DEGREES", VIEW, NULL, "how high it stands above the xy plane (25)"},
    {OPTION_ZOOM, 0, "zoom", "FACTOR", VIEW, NULL, "1 just fits the whole mesh"},
    {OPTION_EDGES, 0, "edges", NULL, VIEW, NULL, "draw the mesh's edges"},
    {OPTION_FLAT, 0, "flat", NULL, VIEW, NULL, "shade by face instead of by vertex normal"},

    {OPTION_THREADS, 't', "threads", "N", WORK, "General", "worker threads; 0 (the default) is all cores. The result is the same for any number."},
    {OPTION_DEVICE, 0, "device", "auto|cpu|cuda", MESH, NULL, "where to work; auto: a large volume on the GPU, where there is one. The result is the same."},
    {OPTION_PROGRESS, 0, "progress", "auto|bar|none", WORK, NULL, "auto shows a bar when stderr is a terminal"},
    {OPTION_QUIET, 'q', "quiet", NULL, WORK, NULL, "say nothing but errors"},
    {OPTION_VERBOSE, 'v', "verbose", NULL, WORK, NULL, "say more; twice: still more"},
    {OPTION_HELP, 'h', "help", NULL, WORK | HELP, NULL, "show this help"},
    {OPTION_VERSION, 0, "version", NULL, WORK | HELP, NULL, "show the version"},
    {OPTION_MAN, 0, "man", NULL, HELP, NULL, "print the man page (roff)"},
    {OPTION_COMPLETION, 0, "completion", NULL, HELP, NULL, "print the completion script for bash"},
};
// clang-format on
const int cli_option_count = (int)(sizeof cli_option_rows / sizeof cli_option_rows[0]);

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
        options->untangle = index == 0   ? QN_UNTANGLE_NEAR
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
        good = set_whole(row, text, (1 << QN_MAX_DEPTH) - 3, "128 (5 to 4093)", &options->cells);
        return good && (options->cells >= 5 || option_wrong(row, text, "128 (5 to 4093)"));
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
    options->untangle = QN_UNTANGLE_NEAR;
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
