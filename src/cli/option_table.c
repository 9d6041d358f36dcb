// SPDX-License-Identifier: MIT
/* The verbs and options of the tool as two tables: parsing, help, man page and completion come from
 * them. */
#include "option_table.h"
#include "options.h"

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
     "--mode dmc: on (the default) moves vertices off the surface, by some tenths of a voxel, where faces would cross each other; all such places "
     "are found; all does the same by looking everywhere, which takes much longer; off leaves every vertex on the surface"},
    {OPTION_SIMPLIFY, 0, "simplify", NULL, MESH, NULL,
     "remove quads of valences 3-X-3-Y and 3-3-3-3: fewer irregular vertices, the same topology"},
    {OPTION_SIMPLIFY_PASSES, 0, "simplify-passes", "N|paper", MESH, NULL,
     "--simplify, but at most N passes (0, the default: until nothing is left), or the single pass of the published rule"},
    {OPTION_NO_REPROJECT, 0, "no-reproject", NULL, MESH, NULL,
     "leave the vertices made by --simplify between the two they replace instead of putting them back onto the surface"},
    {OPTION_RELAX, 0, "relax", "N", MESH, NULL,
     "N sweeps that slide the vertices along the surface towards squarer quads (0); 3 to 5 do most of it"},
    {OPTION_MODE, 0, "mode", "dmc|cms", MESH | CSG | REMESH, NULL, "the surfacer: dmc, dual marching cubes (the default of mesh): quads on a uniform lattice; or cms, adaptive cubical marching squares (the default of csg and remesh): triangles, few where it is flat"},

    {OPTION_DEPTH, 0, "depth", "D", CSG | REMESH, "Surface of a solid (csg, remesh, mesh --mode cms)", "2^D finest cells along the longest axis, 1/32 of them room, 3 to 12 (7)"},
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
    {OPTION_KEEP_FLAT, 0, "keep-flat", NULL, MESH | CSG | REMESH, NULL, "leave flat parts divided as the octree is, for triangles of even shape: else they have as few as their outlines need"},
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
