// SPDX-License-Identifier: MIT
/* Cubical Marching Squares: face segments, loops, features, triangles, over the leaves of an
 * octree. */
#ifndef QNI_CMS_CMS_H
#define QNI_CMS_CMS_H

#include <qn/surface.h>
#include "core/cube_hd.h"
#include "octree/octree.h"

#define QNI_NONE UINT32_MAX

enum {
    QNI_FACE_POINTS = 4 * QNI_EDGE_CAPACITY,
    QNI_FACE_SEGMENTS = QNI_FACE_POINTS / 2,
    QNI_MOST_BENDS = 6, /* of one segment */
    QNI_CHUNK = 128
};

/* What vertices are called until all are counted: two bits say which kind, the others which one. */
enum { QNI_REF_SHIFT = 30 };
#define QNI_REF_CROSSING    UINT32_C(0)
#define QNI_REF_FEATURE     (UINT32_C(1) << QNI_REF_SHIFT)
#define QNI_REF_APEX        (UINT32_C(2) << QNI_REF_SHIFT)
#define QNI_REF_NUMBER(ref) ((ref) & (QNI_REF_FEATURE - 1))
#define QNI_REF_KIND(ref)   ((ref) & (UINT32_C(3) << QNI_REF_SHIFT))

typedef struct qni_cms_settings {
    double crease_cosine; /* below -1: no creases */
    double seam_cosine;   /* the same where two parts of the solid meet: no less */
    double facing_cosine; /* a triangle explains samples whose normals differ by no more */
    double tolerance;     /* world units */
    bool features, open;
    bool scalar;    /* the surface of a trilinear f: ambiguities are settled by its values alone */
    bool join_ties; /* where a face's saddle lies on the surface its inside corners are joined */
} qni_cms_settings;

/* Where parts of the solid meet there is a crease, known by their owners, though the angle be
 * small; it is followed as all are, and tagged only where the angle is one of creases. Do two
 * tangents lie on both sides of one? */
static inline bool qni_is_crease(const qni_cms_settings *settings, double likeness, int32_t owner,
                                 int32_t other) {
    return likeness < (owner == other ? settings->crease_cosine : settings->seam_cosine);
}

/* What to make the surface of. */
typedef struct qni_cms_job {
    const qn_solid *solid;
    bool samples;   /* it is made of samples: their lattice, in their frame */
    bool join_ties; /* see above */
    bool creases;   /* the solid has sharp edges */
} qni_cms_job;

/* Counters; sums over cells. */
typedef struct qni_cms_tally {
    int64_t loops, smooth_loops, crease_loops, corner_loops, flat_loops, escaped_corners;
    int64_t reaching_corners, united_cells, split_loops;
    int64_t multiple_cells, moved_loops, nested_cells, unresolved_cells, open_loops;
    int64_t tubes, nested_tubes, lost_tubes;
} qni_cms_tally;

/* A point inside a face where a segment bends: a sharp feature, or a bend that keeps it off an
 * edge. Where a segment has several features, planes lie between its ends' own: they know them. */
typedef struct qni_face_feature {
    double at[3], normal[3]; /* unit length; of the plane between, where has_plane */
    float place[3];
    int32_t owner;
    bool sharp, has_plane;
} qni_face_feature;

/* A piece of surface trace on a leaf face, from where the boundary, walked counter-clockwise about
 * the face's own normal, comes into the solid to where it leaves it. */
typedef struct qni_segment {
    uint32_t from, to; /* numbers of crossings */
    uint32_t feature;  /* the first one's number: in the solution, then in the whole */
    uint8_t bends : 6; /* how many features follow each other */
    bool dropped : 1;  /* its features were not found, or could not be kept */
    bool touching : 1; /* the first of a face whose segments touch */
    uint8_t pass;      /* in which it was solved */
    uint8_t used[2];   /* forward, reversed: the audit */
} qni_segment;

/* A lattice face: its lowest corner, its axis, 2^level finest cells wide. Its own normal runs along
 * +x, -y, +z: its two other axes, the lower one first, turn counter-clockwise about it. */
typedef struct qni_face {
    int32_t low[3];
    int32_t level, axis;
} qni_face;

typedef struct qni_face_solution {
    int32_t count, feature_count;
    bool ambiguous;
    bool broken;     /* crossings do not alternate: the solid gave different answers to the same
                        question */
    int32_t dropped; /* features that escaped or crossed */
    bool unresolved; /* segments touch */
    qni_segment segments[QNI_FACE_SEGMENTS];
    qni_face_feature features[QNI_MOST_BENDS * QNI_FACE_SEGMENTS];
} qni_face_solution;

/* Solve one face; a pure function of the face (face.c). `solid` agrees with the whole one near the
 * face. `closely`: look for low steps, too. */
void qni_solve_face(const qni_hermite *hermite, const qn_solid *solid,
                    const qni_cms_settings *settings, const qni_face *face, bool closely,
                    qni_face_solution *solution);
qni_face qni_face_of_cell(const qni_cell *cell, int face);
/* Is the face's own normal the one that points out of the cell? */
static inline bool qni_face_points_out(int face) {
    return (face >> 1 == 1) == ((face & 1) == 0);
}

/* ---- loops --------------------------------------------------------------------------------------
 */

typedef struct qni_loop_vertex {
    float place[3];
    uint32_t ref;
    const qni_hermite_crossing *crossing; /* NULL: a feature */
    double at[3], normal[3];              /* its tangent plane, where it has one */
    int32_t owner;
    bool has_plane;
    uint8_t walls; /* faces of the cell it lies on */
    bool sharp;    /* a sharp feature */
    int32_t same;  /* the vertex of the patch, or the inner point, that it is a copy of */
} qni_loop_vertex;

typedef struct qni_loop {
    int32_t first, count; /* in the patch's vertices */
    int32_t triangle_first, triangle_count;
    float apex[3];
    bool has_apex;
    int32_t clusters, sharp_count;
    bool escaped;   /* a corner that is not in the cell */
    bool beyond;    /* its apex is in the empty cell across a wall */
    bool unsettled; /* its apex is the mean of the loop */
    bool knows_corner;
    bool of_facets;  /* all its tangent planes meet in that corner */
    float corner[3]; /* of a corner that is not in the cell: where it is, if that is known */
} qni_loop;

typedef struct qni_directed {
    uint32_t from, to, feature;
    uint8_t bends;
    bool reversed;
} qni_directed;

/* The solid near a cell, restricted when it is asked (nearby.c); of one thread. */
enum { QNI_NEARBY_PARTS = 64 + 8 };

typedef struct qni_nearby {
    qn_solid base;
    const qni_hermite *hermite;
    qni_region region; /* down to blocks */
    qni_cell cell, block_cell;
    qn_solid *parts[QNI_NEARBY_PARTS]; /* of the block's cells of levels 1 and 2; NULL: none yet */
    qn_solid *near;                    /* to the cell itself, of level 0 */
    const qn_solid *asked;             /* one of them; NULL: nobody asked yet */
    bool united;                       /* the cell stands for a union */
} qni_nearby;

void qni_nearby_start(qni_nearby *nearby, const qni_hermite *hermite);
void qni_nearby_set_cell(qni_nearby *nearby, const qni_cell *cell, bool united);
void qni_nearby_end(qni_nearby *nearby);

/* ---- unions of cells ----------------------------------------------------------------------------
 */

/* A box of finest cells that are made as one. */
typedef struct qni_cell_box {
    int32_t low[3], size[3];
    bool split; /* its loop may be cut in parts */
} qni_cell_box;

typedef struct qni_union_member {
    int32_t low[3]; /* a finest cell */
    int32_t number; /* its union */
} qni_union_member;

typedef struct qni_unions {
    qni_cell_box *items;
    int64_t count, capacity;
    qni_union_member *members; /* ascending z, y, x; number -1: a corner reaches into it */
    int64_t member_count, member_capacity;
} qni_unions;

/* The union that holds a finest cell, or -1 (unite.c). */
int64_t qni_find_union(const qni_unions *unions, const int32_t low[3]);

/* Everything about one cell, or one union of cells; a thread keeps one and uses it again and again.
 */
typedef struct qni_patch {
    qn_context *context;
    const qni_hermite *hermite;
    const qni_cms_settings *settings;
    const qn_solid *solid;    /* agrees with the whole one in the cell and half its width around */
    qni_nearby nearby;        /* which is that solid */
    const qni_octree *octree; /* NULL while there is none yet */
    const qni_unions *unions; /* NULL: none */
    qni_cell cell;            /* the lowest one of a union */
    bool united, may_split;
    bool split; /* the first loop is cut in parts: all others */
    int64_t traced_loops;
    int32_t cuts_left;  /* to be tried */
    int32_t most_depth; /* of parts that are cut again */
    bool of_owners;     /* what is cut belongs to several parts of the solid */
    double cut_within;  /* what is cut must lie this near to the surface */
    bool flat_only;     /* sheets that curve are not followed */
    uint8_t youngest;   /* the last pass in which one of its segments was solved */
    int32_t size_cells; /* of a union: how many */
    int32_t dropped;    /* segments without their features */
    bool beside_finer;  /* some segments are finer leaves' */
    int64_t most_bad;   /* a trial: with more flaws than that its triangles do not matter */
    float low[3], high[3];
    float clear_low[3], clear_high[3]; /* inner points keep within */
    double size;
    bool failed; /* memory */
    qni_directed *pieces;
    int64_t piece_count, piece_capacity;
    qni_loop_vertex *vertices;
    int64_t vertex_count, vertex_capacity;
    qni_loop *loops;
    int64_t loop_count, loop_capacity;
    int32_t (*triangles)[4]; /* of patch vertices; -1 - loop: that loop's apex; from 1 << 24: inner
                              * points. Fourth: the vertex whose tangent plane it lies in, -1 when
                              * that is not known */
    int64_t triangle_count, triangle_capacity;
    double *scratch;
    int64_t scratch_capacity;
    float (*inner)[3];
    int64_t inner_count, inner_capacity;
} qni_patch;

enum { QNI_INNER = 1 << 24 };

/* Is a point strictly within the cell? */
static inline bool qni_patch_holds(const qni_patch *patch, const double point[3]) {
    for (int k = 0; k < 3; ++k)
        if (!(point[k] > (double)patch->low[k] && point[k] < (double)patch->high[k]))
            return false;
    return true;
}

void qni_patch_start(qni_patch *patch, qn_context *context, const qni_hermite *hermite,
                     const qni_cms_settings *settings);
void qni_patch_free(qni_patch *patch);
/* Grow an array of a patch; false and patch->failed when memory ran out. */
bool qni_patch_grow(qni_patch *patch, void **items, int64_t *capacity, int64_t wanted, size_t size);
void qni_patch_set_cell(qni_patch *patch, const qni_cell *cell);
void qni_patch_set_union(qni_patch *patch, const qni_cell_box *box);
/* `out`: the way the segment runs as it is, else reversed; `base` is added to its features'
 * numbers. */
bool qni_patch_add_piece(qni_patch *patch, const qni_segment *segment, bool out, uint32_t base);
/* Chain the pieces to loops (component.c); false when one does not close. Features are looked up in
 * `features`. */
bool qni_patch_trace(qni_patch *patch, const qni_face_feature *features);
/* Place the apex of each loop (feature.c). That of a smooth one is moved onto the surface only
 * where it gets triangles: most need none. */
void qni_patch_place_apex(qni_patch *patch, qni_loop *loop);
qn_status qni_patch_settle_apex(const qni_patch *patch, qni_loop *loop);
qn_status qni_patch_place_apexes(qni_patch *patch, qni_cms_tally *tally);
/* Where the sheets between a loop's sharp features meet, next to the middle of the features; with
 * two features, in the plane across (sheets.c). False when that is not found on the surface. */
bool qni_patch_meet_sheets(const qni_patch *patch, const qni_loop *loop, const double middle[3],
                           double point[3]);
/* The same point, or another one of the crease between the loop's two features that is inside the
 * cell, by going from sheet to sheet. */
bool qni_patch_cross_sheets(const qni_patch *patch, const qni_loop *loop, const double middle[3],
                            double point[3]);
/* Where three facets or more meet, in the cell or just beyond a wall, so that straight creases lead
 * to the loop's sharp features: facets that its crossings know, or those `beside` its features. And
 * a point of the crease between two tangents, inside the cell (kink.c). */
typedef enum qni_kink { QNI_NO_KINK, QNI_KINK_INSIDE, QNI_KINK_BEYOND } qni_kink;
qni_kink qni_patch_find_kink(const qni_patch *patch, const qni_loop *loop, bool beside,
                             double point[3]);
bool qni_patch_halve_to_crease(const qni_patch *patch, const double at[2][3],
                               const double normal[2][3], double point[3]);
/* Where the sheets of two vertices meet, next to a point, in the plane across their crease. */
bool qni_patch_meet_two(const qni_patch *patch, const qni_loop_vertex *a, const qni_loop_vertex *b,
                        const double middle[3], double point[3]);
/* Cut the one loop of a finest cell, or union, in parts that come out well (split.c); false when
 * that is not found. */
bool qni_patch_split(qni_patch *patch);
/* Triangles of all loops (triangulate.c); in a cell of several loops they are kept apart
 * (separate.c). */
void qni_patch_fan(qni_patch *patch, qni_loop *loop);
bool qni_patch_flat(qni_patch *patch, qni_loop *loop, bool force);
qn_status qni_patch_triangulate(qni_patch *patch, qni_cms_tally *tally);
/* Nested boxes (nest.c): in theory always apart; `attempt` varies their sizes. `tube`: two loops to
 * be joined, or NULL. False when it cannot be built. */
bool qni_patch_nest(qni_patch *patch, const int *tube, int attempt);
/* A loop without triangles: another one of the same tube has them all. */
static inline void qni_patch_drop_loop(qni_patch *patch, int loop) {
    patch->loops[loop].has_apex = false;
    patch->loops[loop].triangle_count = 0;
    patch->loops[loop].triangle_first = (int32_t)patch->triangle_count;
}
/* Do any two triangles of the patch meet beyond the vertices they share? And of different loops
 * only? (separate.c) */
bool qni_patch_meets_itself(const qni_patch *patch);
bool qni_patch_loops_meet(const qni_patch *patch);
/* Loops without their features: own vertices only, or fans from their means. */
void qni_patch_rebuild_simply(qni_patch *patch, qni_loop *loop, bool fan);
/* Two loops of a cell that are one tube (tube.c): whether there are, and their triangles. False
 * from the second when no way without a crossing was found. */
bool qni_patch_find_solid_tube(const qni_patch *patch, int tube[2], double middle[3]);
bool qni_patch_find_tube(qni_patch *patch, int tube[2], double middle[3]);
bool qni_patch_make_tube(qni_patch *patch, const int tube[2], const double middle[3],
                         qni_cms_tally *tally);
qn_status qni_patch_separate(qni_patch *patch, qni_cms_tally *tally);
/* Segments without their features, and corners that are not in the cell. */
int64_t qni_patch_flaws(const qni_patch *patch);
const float *qni_patch_place(const qni_patch *patch, int32_t vertex);
/* The edge of the cell that a crossing lies on, by its two walls. */
static inline int qni_edge_of_walls(uint8_t walls) {
    int axis = 0, corner = 0;
    for (int k = 0; k < 3; ++k) {
        const int bits = walls >> 2 * k & 3;
        if (!bits)
            axis = k;
        corner |= (bits == 2) << k;
    }
    return qni_edge_at(axis, corner);
}
/* A float strictly between the walls, as near to the value as can be. */
static inline float qni_between(double value, float low, float high) {
    const float rounded = (float)value;
    if (rounded > low && rounded < high)
        return rounded;
    const float least = __builtin_nextafterf(low, high), most = __builtin_nextafterf(high, low);
    return rounded < least ? least : rounded > most ? most : rounded;
}

/* A tangent plane of the surface, and whose it is. */
typedef struct qni_tangent {
    double at[3], normal[3]; /* unit length */
    int32_t owner;
} qni_tangent;

/* The surface within `reach` of a point along a unit direction; its normal must be that given,
 * nearly (near.c). */
bool qni_surface_near(const qn_solid *solid, const double point[3], const double direction[3],
                      const double normal[3], double reach, qni_tangent *out);
/* The same from a tangent to a target near its plane, on the same sheet: across a crease is false.
 */
bool qni_surface_along(const qn_solid *solid, const qni_cms_settings *settings,
                       const qni_tangent *from, const double target[3], const double direction[3],
                       double reach, qni_tangent *out);

/* Is a point within a distance of the surface, to first order (near.c)? */
bool qni_is_on_surface(const qn_solid *solid, const double point[3], double tolerance);
/* Is a point on the surface, and are the ways to it from points whose tangent planes meet in it,
 * where they come near it? Then what meets there is flat, and the point need not be looked for any
 * closer (near.c). */
bool qni_flat_pieces_meet(const qn_solid *solid, const double point[3], int32_t count,
                          const double (*from)[3], double tolerance);

/* ---- the whole ----------------------------------------------------------------------------------
 */

/* Faces of cells that may be leaves, while one block's cells are asked (face_store.c). */
enum { QNI_KEPT_FACES = 240 + 36, QNI_KEPT_SEGMENTS = 3, QNI_KEPT_FEATURES = 6 };

typedef struct qni_kept_face {
    bool known;
    bool simple; /* else a leaf cannot have it, and nothing more is kept of it */
    int8_t count, feature_count;
    qni_segment segments[QNI_KEPT_SEGMENTS];
    qni_face_feature features[QNI_KEPT_FEATURES];
} qni_kept_face;

typedef struct qni_face_store {
    bool used;
    int32_t block[3];
    qni_face_solution solution;
    qni_kept_face other, faces[QNI_KEPT_FACES]; /* other: of larger cells, not kept */
} qni_face_store;

/* A face of the patch's cell, good until the next question. */
const qni_kept_face *qni_face_store_solve(qni_face_store *store, const qni_patch *patch, int face);

/* The coarsening question (coarsen.c). */
typedef struct qni_coarsening {
    const qni_hermite *hermite;
    const qni_cms_settings *settings;
    qni_patch *patches;     /* one for each thread */
    qni_face_store *stores; /* likewise */
    const qni_cell *vetoes; /* ascending: cells that did not come out well beside finer ones */
    int64_t veto_count;
} qni_coarsening;
int qni_compare_vetoes(const void *a, const void *b);
bool qni_cell_is_explained(void *user, const qni_cell *cell);
/* Whether each crossing of a finest edge in the closed cell, or box of finest cells, lies near a
 * triangle of the patch that faces its way; in a cell, also whether the creases between its
 * triangles lie where the solid's are (folds.c). */
bool qni_cell_is_explained_by(const qni_patch *patch);
/* How sure it is that creases end in a cell where the solid's do not (closer.c): a crease ends, or
 * its corner lies beyond a wall; a step does, seen low or obliquely; a step does. */
typedef enum qni_doubt {
    QNI_NO_DOUBT,
    QNI_FAINT_DOUBT,
    QNI_SLIGHT_DOUBT,
    QNI_CLEAR_DOUBT
} qni_doubt;
/* Do two creases come into the cell side by side, as the walls of a step, and no way on? */
qni_doubt qni_step_turns_back(const qni_patch *patch, const qni_loop *loop);
/* `least`: nearer to a crease than that, in world units, the solid is not asked; short creases
 * are only looked at as far as that allows. */
bool qni_creases_hold(const qni_patch *patch, double least);
bool qni_folds_hold(const qni_patch *patch, const double (*normals)[3], double least);
/* Is the edge between two triangles a crease that turns enough to be tagged, and does it lie where
 * the solid's is? */
bool qni_is_true_fold(const qni_patch *patch, const int32_t a[4], const int32_t b[4]);
/* The same of one loop's triangles. */
bool qni_loop_folds_hold(const qni_patch *patch, const qni_loop *loop);
/* The nearest of a loop's vertices that knows a plane, from one on, forwards or (step -1) back. */
const qni_loop_vertex *qni_plane_beside(const qni_loop_vertex *v, int32_t count, int32_t from,
                                        int32_t step);
/* Of unit length; 0 when it has none. */
void qni_patch_unit_normal(const qni_patch *patch, const int32_t triangle[3], double normal[3]);
bool qni_box_is_explained(const qni_patch *patch, const qni_cell_box *box);

/* Singular value decomposition (svd.c): the least-squares point of planes about a centre, keeping
 * `rank` directions. */
bool qni_solve_planes(double *rows, double *heights, int32_t count, int32_t rank,
                      double solution[3]);

qn_status qni_cms_surface(qn_context *context, const qni_cms_job *job,
                          const qn_solid_surface_options *options, qn_mesh **mesh_out,
                          qn_solid_surface_report *report, qn_error *error);

#endif
