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

enum { MEND_REACH = 3, FIRST_PUSH = 5, MOST_ROUNDS = 32, PATIENCE = 12 };

static qn_mesh_view view_of(const qni_mesh_part *part) {
    qn_mesh_view view;
    memset(&view, 0, sizeof view);
    view.vertex_count = part->vertex_count;
    view.quad_count = part->quad_count;
    view.positions = part->positions;
    view.quads = part->quads;
    return view;
}

/* The crossing pairs of a part that are wanted (box_tree.h); `marks` become those of their
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

/* A vertex that was moved: where it was, and where it was in the best round. */
typedef struct moved {
    uint32_t vertex;
    float before[3], best[3];
} moved;

typedef struct work {
    qn_context *context;
    qn_mesh *mesh; /* its places change */
    moved *moves;
    int64_t move_count, move_capacity;
    qni_vertex_set touched; /* which vertices `moves` has */
    double to_lattice[3][4];
    double push;         /* world units along the normals, where a push is needed */
    uint8_t *marks;      /* [vertices of the mesh]: corners of crossing triangles */
    qni_mesh_part whole; /* all that rounds look at: what is near the marks, and beyond reach */
    qni_vertex_set core; /* of its vertices: where marks may be */
    int reach;           /* of rounds */
    qni_untangle_report *report;
} work;

/* The vertices of `whole` that are marked. */
static qn_status find_marked(const work *w, qni_vertex_set *marked, qn_error *error) {
    QN_TRY(qni_vertex_set_alloc(w->context, w->whole.vertex_count, marked, error));
    for (int64_t v = 0; v < w->whole.vertex_count; ++v)
        marked->bits[v / 64] |= (uint64_t)w->marks[w->whole.vertices[v]] << (v % 64);
    return QN_OK;
}

/* The quads within reach of the marks. */
static qn_status cut_part(const work *w, qni_mesh_part *part, qn_error *error) {
    const qn_mesh_view view = view_of(&w->whole);
    qni_vertex_set marked;
    QN_TRY(find_marked(w, &marked, error));
    const qn_status status =
        qni_mesh_part_near(w->context, &view, w->to_lattice, &marked, w->reach, part, error);
    qni_vertex_set_free(w->context, &marked);
    return status;
}

static void free_whole(work *w) {
    qni_vertex_set_free(w->context, &w->core);
    qni_mesh_part_free(w->context, &w->whole);
}

/* What is twice as far as rounds reach, and than the core reaches: so that a round does what it
 * would in the whole mesh. */
static qn_status cut_whole(work *w, qn_error *error) {
    enum { CORE = 2 };
    const qn_mesh_view mesh = qn_mesh_get_view(w->mesh);
    qni_vertex_set marked;
    free_whole(w);
    QN_TRY(qni_vertex_set_alloc(w->context, mesh.vertex_count, &marked, error));
    for (int64_t v = 0; v < mesh.vertex_count; ++v)
        marked.bits[v / 64] |= (uint64_t)w->marks[v] << (v % 64);
    qn_status status = qni_mesh_part_near(w->context, &mesh, w->to_lattice, &marked,
                                          2 * w->reach + 2 * CORE, &w->whole, error);
    qni_vertex_set_free(w->context, &marked);
    if (status != QN_OK)
        return status;
    const qn_mesh_view view = view_of(&w->whole);
    QN_TRY(find_marked(w, &marked, error));
    status = qni_vertices_near(w->context, &view, w->to_lattice, &marked, CORE, &w->core, error);
    qni_vertex_set_free(w->context, &marked);
    return status;
}

static bool marks_left_core(const work *w) {
    bool left = false;
    for (int64_t v = 0; v < w->whole.vertex_count; ++v)
        left = left || (w->marks[w->whole.vertices[v]] && !qni_in_set(&w->core, v));
    return left;
}

/* Room for all that moves in a part. */
static bool reserve_moves(work *w, int64_t more) {
    const int64_t wanted = w->move_count + more;
    if (wanted <= w->move_capacity)
        return true;
    moved *grown =
        qni_realloc(w->context, w->moves, w->move_capacity, 2 * wanted, sizeof *w->moves);
    if (!grown)
        return false;
    w->moves = grown;
    w->move_capacity = 2 * wanted;
    return true;
}

/* Remember where a vertex was before it moves for the first time. */
static void touch(work *w, uint32_t vertex) {
    moved *own = w->moves + w->move_count;
    if (qni_in_set(&w->touched, vertex))
        return;
    w->touched.bits[vertex / 64] |= UINT64_C(1) << (vertex % 64);
    own->vertex = vertex;
    memcpy(own->before, w->mesh->positions + 3 * (size_t)vertex, sizeof own->before);
    memcpy(own->best, own->before, sizeof own->best);
    ++w->move_count;
}

/* The vertex of the mesh that a part of `whole` has at this place. */
static uint32_t number_of(const work *w, const qni_mesh_part *part, int64_t v) {
    return w->whole.vertices[part->vertices[v]];
}

/* Move what is marked and `width` rings of neighbours, and look what crosses then. Beyond the part
 * nothing changes, and all that crossed before is in it. */
static qn_status mend_part(work *w, mender *m, int width, int64_t *left, qn_error *error) {
    const qni_mesh_part *part = &m->part;
    fill_fans(m);
    for (int64_t v = 0; v < part->vertex_count; ++v) {
        m->moving[v] = w->marks[number_of(w, part, v)] ? QNI_WANTED : 0;
        w->marks[number_of(w, part, v)] = 0;
    }
    for (int n = 0; n < width; ++n)
        widen(m);
    move_all(m);
    QN_TRY(find_crossings(w->context, part, m->moving, m->scratch, left, error));
    for (int64_t v = 0; v < part->vertex_count; ++v) {
        const uint32_t vertex = number_of(w, part, v);
        w->marks[vertex] = m->scratch[v];
        if (!m->moving[v])
            continue;
        touch(w, vertex);
        memcpy(w->whole.positions + 3 * (size_t)part->vertices[v], part->positions + 3 * v,
               3 * sizeof(float));
        memcpy(w->mesh->positions + 3 * (size_t)vertex, part->positions + 3 * v, 3 * sizeof(float));
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
    const bool farther = MEND_REACH + 2 * width > w->reach;
    w->reach = MEND_REACH + 2 * width;
    if (farther || marks_left_core(w))
        QN_TRY(cut_whole(w, error));
    QN_TRY(cut_part(w, &m.part, error));
    const qn_status status = alloc_mender(&m) && reserve_moves(w, m.part.vertex_count)
                                 ? mend_part(w, &m, width, left, error)
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

static void keep_best(const work *w) {
    for (moved *own = w->moves; own < w->moves + w->move_count; ++own)
        memcpy(own->best, w->mesh->positions + 3 * (size_t)own->vertex, sizeof own->best);
}

static void go_back_to_best(const work *w) {
    qni_untangle_report *report = w->report;
    for (const moved *own = w->moves; own < w->moves + w->move_count; ++own) {
        memcpy(w->mesh->positions + 3 * (size_t)own->vertex, own->best, sizeof own->best);
        if (memcmp(own->before, own->best, sizeof own->best) == 0)
            continue;
        report->farthest =
            fmax(report->farthest, length_in_cells(w->to_lattice, own->best, own->before));
        ++report->moved_vertices;
    }
}

/* Rounds until nothing crosses, or it gets no better; the best round counts. */
static qn_status run_rounds(work *w, qn_error *error) {
    int64_t now = w->report->crossings, *left = &w->report->crossings_left;
    for (int round = 0, since = 0; now > 0 && round < MOST_ROUNDS && since < PATIENCE; ++round) {
        QN_TRY(one_round(w, round, &now, error));
        w->report->rounds = round + 1;
        ++since;
        if (now < *left) {
            *left = now;
            since = 0;
            keep_best(w);
        }
    }
    go_back_to_best(w);
    return QN_OK;
}

static qn_status mend(work *w, qn_error *error) {
    QN_TRY(qni_vertex_set_alloc(w->context, w->mesh->vertex_count, &w->touched, error));
    const qn_status status = run_rounds(w, error);
    free_whole(w);
    qni_free(w->context, w->moves, w->move_capacity, sizeof *w->moves);
    qni_vertex_set_free(w->context, &w->touched);
    return status;
}

/* ---- the search ------------------------------------------------------------------------------ */

/* Look in a part of the mesh, in which no two quads at `sound` vertices cross; NULL for none such.
 * Marks become those of the crossing triangles' corners. */
static qn_status search_part(const work *w, const qni_mesh_part *part, const qni_vertex_set *sound,
                             qn_error *error) {
    const int64_t count = part->vertex_count;
    uint8_t *wanted = qni_alloc(w->context, count, 1), *found = qni_alloc(w->context, count, 1);
    qn_status status = wanted && found ? QN_OK : qni_fail_memory(error, "the search for crossings");
    w->report->searched_quads = part->quad_count;
    for (int64_t v = 0; v < count && status == QN_OK; ++v)
        wanted[v] = (uint8_t)(QNI_WANTED_WITH_ALL |
                              (sound && qni_in_set(sound, part->vertices[v]) ? QNI_SOUND : 0));
    if (status == QN_OK)
        status = find_crossings(w->context, part, wanted, found, &w->report->crossings, error);
    for (int64_t v = 0; v < count && status == QN_OK; ++v)
        w->marks[part->vertices[v]] = found[v];
    qni_free(w->context, found, count, 1);
    qni_free(w->context, wanted, count, 1);
    return status;
}

static qn_status search_suspects(const work *w, const qn_mesh_view *mesh, qn_error *error) {
    qni_suspects suspects;
    qni_mesh_part part;
    QN_TRY(qni_untangle_suspects(w->context, mesh, w->to_lattice, &suspects, error));
    qn_status status = QN_OK;
    if (suspects.too_large)
        status = qni_mesh_part_all(w->context, mesh, &part, error);
    else if (suspects.count > 0)
        status = qni_mesh_part_of(w->context, mesh, &suspects.quads, &suspects.near, &part, error);
    if (suspects.count > 0 && status == QN_OK) {
        status = search_part(w, &part, &suspects.sound, error);
        qni_mesh_part_free(w->context, &part);
    }
    qni_suspects_free(w->context, &suspects);
    return status;
}

static qn_status search_all(const work *w, const qn_mesh_view *mesh, qn_error *error) {
    qni_mesh_part part;
    QN_TRY(qni_mesh_part_all(w->context, mesh, &part, error));
    const qn_status status = search_part(w, &part, NULL, error);
    qni_mesh_part_free(w->context, &part);
    return status;
}

qn_status qni_mesh_untangle(qn_context *context, qn_mesh *mesh, const qni_untangle_options *options,
                            qni_untangle_report *report, qn_error *error) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    work w = {.context = context, .mesh = mesh, .report = report};
    invert(options->to_world, w.to_lattice);
    w.push = push_of(options);
    memset(report, 0, sizeof *report);
    if (view.quad_count == 0)
        return QN_OK;
    w.marks = qni_alloc_zero(context, view.vertex_count, 1);
    if (!w.marks)
        return qni_fail_memory(error, "the search for crossings");
    qn_status status =
        options->everywhere ? search_all(&w, &view, error) : search_suspects(&w, &view, error);
    report->crossings_left = report->crossings;
    if (status == QN_OK && report->crossings > 0)
        status = mend(&w, error);
    qni_free(context, w.marks, view.vertex_count, 1);
    return status;
}
