// SPDX-License-Identifier: MIT
/* Taking crossings out of a mesh (untangle.h), in rounds: the corners of crossing triangles go half
 * the way to the mean of the faces round them; where that is not enough, their neighbours too.
 *
 * Why it works: a surface net, every vertex at the mean of its cell's crossings, has almost no
 * crossings; a vertex on the interpolant can lie far out in its cell, where quads turn over it. The
 * mean of the faces' middles is near that of the crossings, and asks for no samples. Where a whole
 * layer of samples has the iso-value two sheets lie on each other, and no mean parts them: so later
 * rounds also push vertices along their normals, to the side on which such samples are not. */
#include "mesh/untangle.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/box_tree.h"

#include <math.h>
#include <string.h>

enum { SEARCH_REACH = 2, MEND_REACH = 3, FIRST_PUSH = 5, MOST_ROUNDS = 32, PATIENCE = 12 };

static qn_mesh_view view_of(const qni_mesh_part *part) {
    qn_mesh_view view;
    memset(&view, 0, sizeof view);
    view.vertex_count = part->vertex_count;
    view.quad_count = part->quad_count;
    view.positions = part->positions;
    view.quads = part->quads;
    return view;
}

/* The crossing pairs of a part that have a wanted corner (NULL: any); `marks` become those of their
 * triangles' corners. */
static qn_status find_crossings(qn_context *context, const qni_mesh_part *part,
                                const uint8_t *wanted, uint8_t *marks, int64_t *count_out,
                                qn_error *error) {
    const qn_mesh_view view = view_of(part);
    return qni_mesh_crossings(context, &view, "untangle", wanted, marks, count_out, error);
}

/* ---- moving ---------------------------------------------------------------------------------- */

typedef struct mender {
    qn_context *context;
    qni_mesh_part part;
    int64_t *starts;  /* [vertex_count + 1]: where the quads of each vertex begin */
    uint32_t *quads;  /* [4 quad_count]: the quads round the vertices, ascending */
    uint8_t *moving;  /* [vertex_count]: 0, or QNI_WANTED: to be moved */
    uint8_t *scratch; /* [vertex_count] */
    float *next;      /* [vertex_count][3]: the places after the move */
    double push;      /* world units along the normals, beside the move */
} mender;

static void fill_fans(mender *m) {
    const qni_mesh_part *part = &m->part;
    for (int64_t n = 0; n < 4 * part->quad_count; ++n)
        ++m->starts[part->quads[n]];
    int64_t total = 0;
    for (int64_t v = 0; v <= part->vertex_count; ++v) {
        total += m->starts[v]; /* now the end, which falls to the start as the fan fills */
        m->starts[v] = total;
    }
    for (int64_t n = 4 * part->quad_count - 1; n >= 0; --n)
        m->quads[--m->starts[part->quads[n]]] = (uint32_t)(n / 4);
}

static bool alloc_mender(mender *m) {
    const int64_t vertices = m->part.vertex_count, quads = m->part.quad_count;
    m->starts = qni_alloc_zero(m->context, vertices + 1, sizeof *m->starts);
    m->quads = qni_alloc(m->context, quads, 4 * sizeof *m->quads);
    m->moving = qni_alloc(m->context, vertices, 1);
    m->scratch = qni_alloc(m->context, vertices, 1);
    m->next = qni_alloc(m->context, vertices, 3 * sizeof *m->next);
    return m->starts && m->quads && m->moving && m->scratch && m->next;
}

static void free_mender(mender *m) {
    const int64_t vertices = m->part.vertex_count, quads = m->part.quad_count;
    qni_free(m->context, m->next, vertices, 3 * sizeof *m->next);
    qni_free(m->context, m->scratch, vertices, 1);
    qni_free(m->context, m->moving, vertices, 1);
    qni_free(m->context, m->quads, quads, 4 * sizeof *m->quads);
    qni_free(m->context, m->starts, vertices + 1, sizeof *m->starts);
    qni_mesh_part_free(m->context, &m->part);
}

/* The corners of all quads at moving vertices move too. */
static void widen(mender *m) {
    const qni_mesh_part *part = &m->part;
    uint8_t *wider = m->scratch;
    memcpy(wider, m->moving, (size_t)part->vertex_count);
    for (int64_t q = 0; q < part->quad_count; ++q) {
        const uint32_t *quad = part->quads + 4 * q;
        if (m->moving[quad[0]] | m->moving[quad[1]] | m->moving[quad[2]] | m->moving[quad[3]])
            for (int k = 0; k < 4; ++k)
                wider[quad[k]] = QNI_WANTED;
    }
    m->scratch = m->moving;
    m->moving = wider;
}

/* The mean normal of the quads round a vertex, by their areas; length 1, or 0 where they cancel. */
static void normal_at(const mender *m, int64_t v, double normal[3]) {
    const qni_mesh_part *part = &m->part;
    double squares = 0;
    normal[0] = normal[1] = normal[2] = 0;
    for (int64_t n = m->starts[v]; n < m->starts[v + 1]; ++n) {
        const uint32_t *quad = part->quads + 4 * (size_t)m->quads[n];
        double across[2][3];
        for (int a = 0; a < 3; ++a)
            for (int d = 0; d < 2; ++d)
                across[d][a] = (double)part->positions[3 * (size_t)quad[d + 2] + a] -
                               (double)part->positions[3 * (size_t)quad[d] + a];
        for (int a = 0; a < 3; ++a)
            normal[a] += across[0][(a + 1) % 3] * across[1][(a + 2) % 3] -
                         across[0][(a + 2) % 3] * across[1][(a + 1) % 3];
    }
    for (int a = 0; a < 3; ++a)
        squares += normal[a] * normal[a];
    for (int a = 0; a < 3 && squares > 0; ++a)
        normal[a] /= sqrt(squares);
}

/* Half the way to the mean of the middles of the quads round it, and the push. */
static void step(const mender *m, int64_t v, float to[3]) {
    const qni_mesh_part *part = &m->part;
    double sum[3] = {0, 0, 0};
    for (int64_t n = m->starts[v]; n < m->starts[v + 1]; ++n)
        for (int k = 0; k < 4; ++k) {
            const uint32_t corner = part->quads[4 * (size_t)m->quads[n] + k];
            for (int a = 0; a < 3; ++a)
                sum[a] += (double)part->positions[3 * (size_t)corner + a];
        }
    const double corners = 4.0 * (double)(m->starts[v + 1] - m->starts[v]);
    double normal[3] = {0, 0, 0};
    if (m->push != 0)
        normal_at(m, v, normal);
    for (int a = 0; a < 3; ++a)
        to[a] = (float)(0.5 * ((double)part->positions[3 * v + a] + sum[a] / corners) +
                        m->push * normal[a]);
}

static void move_all(mender *m) {
    qni_mesh_part *part = &m->part;
    memcpy(m->next, part->positions, (size_t)part->vertex_count * 3 * sizeof *m->next);
    for (int64_t v = 0; v < part->vertex_count; ++v)
        if (m->moving[v])
            step(m, v, m->next + 3 * v);
    float *positions = part->positions;
    part->positions = m->next;
    m->next = positions;
}

/* ---- rounds ---------------------------------------------------------------------------------- */

typedef struct work {
    qn_context *context;
    qn_mesh *mesh;
    double to_lattice[3][4];
    double push;         /* world units along the normals, where a push is needed */
    qni_mesh_part whole; /* what is searched; its places change */
    uint8_t *marks;      /* [whole.vertex_count]: corners of crossing triangles */
    qni_untangle_report *report;
} work;

/* The quads within reach of the marks. */
static qn_status cut_part(const work *w, int reach, qni_mesh_part *part, qn_error *error) {
    const qn_mesh_view view = view_of(&w->whole);
    qni_vertex_set near;
    QN_TRY(qni_vertex_set_alloc(w->context, view.vertex_count, &near, error));
    for (int64_t v = 0; v < view.vertex_count; ++v)
        near.bits[v / 64] |= (uint64_t)w->marks[v] << (v % 64);
    const qn_status status =
        qni_mesh_part_near(w->context, &view, w->to_lattice, &near, reach, part, error);
    qni_vertex_set_free(w->context, &near);
    return status;
}

/* Move what is marked and `width` rings of neighbours, and look what crosses then. Beyond the part
 * nothing changes, and all that crossed before is in it. */
static qn_status mend_part(work *w, mender *m, int width, int64_t *left, qn_error *error) {
    const qni_mesh_part *part = &m->part;
    fill_fans(m);
    for (int64_t v = 0; v < part->vertex_count; ++v) {
        m->moving[v] = w->marks[part->vertices[v]] ? QNI_WANTED : 0;
        w->marks[part->vertices[v]] = 0;
    }
    for (int n = 0; n < width; ++n)
        widen(m);
    move_all(m);
    QN_TRY(find_crossings(w->context, part, m->moving, m->scratch, left, error));
    for (int64_t v = 0; v < part->vertex_count; ++v) {
        w->marks[part->vertices[v]] = m->scratch[v];
        memcpy(w->whole.positions + 3 * (size_t)part->vertices[v], part->positions + 3 * v,
               3 * sizeof(float));
    }
    return QN_OK;
}

/* How many rings of neighbours are moved along. */
static int width_of_round(int round) {
    return (round >= 3) + (round >= 8) + 2 * (round >= 14);
}

/* First to the likelier side; what that did not part goes back and to the other. */
static double push_of_round(const work *w, int round) {
    if (round < FIRST_PUSH)
        return 0;
    return round < FIRST_PUSH + 4 ? w->push : -2 * w->push;
}

static qn_status one_round(work *w, int round, int64_t *left, qn_error *error) {
    const int width = width_of_round(round);
    mender m = {.context = w->context, .push = push_of_round(w, round)};
    QN_TRY(cut_part(w, MEND_REACH + 2 * width, &m.part, error));
    const qn_status status = alloc_mender(&m) ? mend_part(w, &m, width, left, error)
                                              : qni_fail_memory(error, "mending crossings");
    free_mender(&m);
    return status;
}

/* ---- all of it ------------------------------------------------------------------------------- */

/* The inverse of the linear part by its minors, then of the shift. */
static void invert(const double m[4][4], double inverse[3][4]) {
    double determinant = 0;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            inverse[c][r] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        }
    for (int c = 0; c < 3; ++c)
        determinant += m[0][c] * inverse[c][0];
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            inverse[r][c] /= determinant;
        inverse[r][3] =
            -(inverse[r][0] * m[0][3] + inverse[r][1] * m[1][3] + inverse[r][2] * m[2][3]);
    }
}

/* A twentieth of the shortest side of a cell, to the side to which the mesh may give way. */
static double push_of(const qni_untangle_options *options) {
    double shortest = INFINITY;
    for (int c = 0; c < 3; ++c) {
        double squares = 0;
        for (int r = 0; r < 3; ++r)
            squares += options->to_world[r][c] * options->to_world[r][c];
        shortest = fmin(shortest, sqrt(squares));
    }
    return (options->gives_inward ? -0.05 : 0.05) * shortest;
}

static double length_in_cells(const double to_lattice[3][4], const float *from, const float *to) {
    double squares = 0;
    for (int a = 0; a < 3; ++a) {
        double along = 0;
        for (int b = 0; b < 3; ++b)
            along += to_lattice[a][b] * ((double)to[b] - (double)from[b]);
        squares += along * along;
    }
    return sqrt(squares);
}

static void put_back(const work *w) {
    qni_untangle_report *report = w->report;
    for (int64_t v = 0; v < w->whole.vertex_count; ++v) {
        float *to = w->mesh->positions + 3 * (size_t)w->whole.vertices[v];
        const float *from = w->whole.positions + 3 * v;
        if (memcmp(to, from, 3 * sizeof *to) == 0)
            continue;
        report->farthest = fmax(report->farthest, length_in_cells(w->to_lattice, to, from));
        ++report->moved_vertices;
        memcpy(to, from, 3 * sizeof *to);
    }
}

/* Rounds until nothing crosses, or it gets no better. `best` keeps the places of the best round. */
static qn_status run_rounds(work *w, float *best, int64_t *left, qn_error *error) {
    const size_t bytes = (size_t)w->whole.vertex_count * 3 * sizeof *best;
    int64_t now = *left;
    for (int round = 0, since = 0; now > 0 && round < MOST_ROUNDS && since < PATIENCE; ++round) {
        QN_TRY(one_round(w, round, &now, error));
        w->report->rounds = round + 1;
        ++since;
        if (now < *left) {
            *left = now;
            since = 0;
            memcpy(best, w->whole.positions, bytes);
        }
    }
    memcpy(w->whole.positions, best, bytes);
    return QN_OK;
}

static qn_status mend(work *w, const uint8_t *wanted, qn_error *error) {
    qni_untangle_report *report = w->report;
    const int64_t count = w->whole.vertex_count;
    report->searched_quads = w->whole.quad_count;
    QN_TRY(find_crossings(w->context, &w->whole, wanted, w->marks, &report->crossings, error));
    report->crossings_left = report->crossings;
    if (report->crossings == 0)
        return QN_OK;
    float *best = qni_alloc(w->context, count, 3 * sizeof *best);
    if (!best)
        return qni_fail_memory(error, "mending crossings");
    memcpy(best, w->whole.positions, (size_t)count * 3 * sizeof *best);
    const qn_status status = run_rounds(w, best, &report->crossings_left, error);
    if (status == QN_OK)
        put_back(w);
    qni_free(w->context, best, count, 3 * sizeof *best);
    return status;
}

/* Search the quads at suspects and what is near them. */
static qn_status mend_near(work *w, const qn_mesh_view *view, const qni_vertex_set *suspects,
                           qn_error *error) {
    QN_TRY(qni_mesh_part_near(w->context, view, w->to_lattice, suspects, SEARCH_REACH, &w->whole,
                              error));
    const int64_t count = w->whole.vertex_count;
    w->marks = qni_alloc(w->context, count, 1);
    uint8_t *wanted = qni_alloc(w->context, count, 1);
    qn_status status = QN_OK;
    if (w->marks && wanted) {
        for (int64_t v = 0; v < count; ++v)
            wanted[v] = qni_in_set(suspects, w->whole.vertices[v]) ? QNI_WANTED : 0;
        status = mend(w, wanted, error);
    } else {
        status = qni_fail_memory(error, "the search for crossings");
    }
    qni_free(w->context, wanted, count, 1);
    return status;
}

static qn_status mend_at_suspects(work *w, const qn_mesh_view *view, qn_error *error) {
    qni_vertex_set suspects;
    QN_TRY(qni_untangle_suspects(w->context, view, w->to_lattice, &suspects, error));
    const qn_status status =
        qni_vertex_set_count(&suspects) > 0 ? mend_near(w, view, &suspects, error) : QN_OK;
    qni_vertex_set_free(w->context, &suspects);
    return status;
}

static qn_status mend_everywhere(work *w, const qn_mesh_view *view, qn_error *error) {
    QN_TRY(qni_mesh_part_all(w->context, view, &w->whole, error));
    w->marks = qni_alloc(w->context, w->whole.vertex_count, 1);
    return w->marks ? mend(w, NULL, error) : qni_fail_memory(error, "the search for crossings");
}

qn_status qni_mesh_untangle(qn_context *context, qn_mesh *mesh, const qni_untangle_options *options,
                            qni_untangle_report *report, qn_error *error) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    work w = {.context = context, .mesh = mesh, .report = report};
    invert(options->to_world, w.to_lattice);
    w.push = push_of(options);
    memset(report, 0, sizeof *report);
    const qn_status status = options->everywhere ? mend_everywhere(&w, &view, error)
                                                 : mend_at_suspects(&w, &view, error);
    qni_free(context, w.marks, w.whole.vertex_count, 1);
    qni_mesh_part_free(context, &w.whole);
    return status;
}
