// SPDX-License-Identifier: MIT
/* Edges, fans, components and genus. Everything about an edge or a fan is seen from one vertex: the
 * face corners of each vertex are listed (a counting sort), and each vertex is then looked at
 * alone. Faces that share an edge are joined in a union-find whose result does not depend on the
 * order of joining.
 *
 * Memory: 8 bytes a corner and a vertex, 17 bytes a face. */
#include "mesh/check.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/sort_keys.h"

enum { FACE_BLOCK = 65536, VERTEX_BLOCK = 16384, FEW_CORNERS = 64 };
/* What is known of a face's component, gathered at its faces. */
enum { HAS_BOUNDARY = 1, NOT_MANIFOLD = 2, NOT_ORIENTED = 4, NOT_POLYGON = 8 };

typedef struct vertex_counts {
    int64_t edges, boundary, nonmanifold_edges, conflicts, pinched, duplicate_faces;
    int64_t inner_vertices, irregular_quad, irregular_triangle;
} vertex_counts;

typedef struct topology {
    qni_check *check;
    const qn_mesh_view *mesh;
    int64_t face_count, corner_count;
    int64_t *first_corner; /* [vertex_count + 1]: where a vertex's corners begin */
    int64_t *corners;      /* corner numbers: 4 q + k for quads, then 3 t + k for triangles */
    int64_t *joined_to;    /* [face_count]: a face of the same component, lower or itself */
    int64_t *euler;        /* [face_count]: what vertices and edges add to the component's number */
    uint8_t *face_flags;   /* [face_count] */
    vertex_counts *blocks;
    int64_t most_corners;
} topology;

/* Room to look at one vertex: two keys a corner, and the fan of each corner. */
typedef struct scratch {
    qni_key *keys;
    int64_t *fan;
} scratch;

/* ---- corners --------------------------------------------------------------------------------- */

static int64_t face_of(const topology *t, int64_t corner) {
    int64_t quad_corners = 4 * t->mesh->quad_count;
    return corner < quad_corners ? corner / 4 : t->mesh->quad_count + (corner - quad_corners) / 3;
}

static int64_t corner_number(const topology *t, int64_t face, int k) {
    int64_t quads = t->mesh->quad_count;
    return face < quads ? 4 * face + k : 4 * quads + 3 * (face - quads) + k;
}

/* Of equal neighbouring corners only the last one stands for the vertex. */
static bool corner_counts(const uint32_t *indices, int corners, int k) {
    return indices[k] != indices[k + 1 < corners ? k + 1 : 0];
}

static void neighbors_of(const topology *t, int64_t corner, uint32_t *previous, uint32_t *next) {
    const uint32_t *indices;
    int64_t face = face_of(t, corner);
    int count = qni_face_corners(t->mesh, face, &indices);
    int k = (int)(corner - corner_number(t, face, 0));
    int before = (k + count - 1) % count;
    if (indices[before] == indices[k])
        before = (before + count - 1) % count;
    *previous = indices[before];
    *next = indices[(k + 1) % count];
}

static void count_corners(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    topology *t = pointer;
    for (int64_t face = begin; face < end; ++face) {
        const uint32_t *indices;
        int corners = qni_face_corners(t->mesh, face, &indices);
        bool polygon = qni_face_is_polygon(indices, corners);
        t->joined_to[face] = face;
        t->face_flags[face] = polygon ? 0 : NOT_POLYGON;
        t->euler[face] = polygon;
        for (int k = 0; polygon && k < corners; ++k)
            if (corner_counts(indices, corners, k))
                __atomic_fetch_add(&t->first_corner[indices[k]], 1, __ATOMIC_RELAXED);
    }
}

/* Counts become the ends of the vertices' parts; list_corners() then fills each part from its end.
 */
static void scan_corners(topology *t) {
    int64_t total = 0;
    for (int64_t v = 0; v < t->mesh->vertex_count; ++v) {
        int64_t count = t->first_corner[v];
        t->most_corners = count > t->most_corners ? count : t->most_corners;
        total += count;
        t->first_corner[v] = total;
    }
    t->first_corner[t->mesh->vertex_count] = total;
    t->corner_count = total;
}

/* The order of a vertex's corners depends on the threads; nothing that is reported does. */
static void list_corners(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    topology *t = pointer;
    for (int64_t face = begin; face < end; ++face) {
        const uint32_t *indices;
        int corners = qni_face_corners(t->mesh, face, &indices);
        if (t->face_flags[face] & NOT_POLYGON)
            continue;
        for (int k = 0; k < corners; ++k)
            if (corner_counts(indices, corners, k)) {
                int64_t at = __atomic_sub_fetch(&t->first_corner[indices[k]], 1, __ATOMIC_RELAXED);
                t->corners[at] = corner_number(t, face, k);
            }
    }
}

/* ---- joining faces to components ---------------------------------------------------------------
 */

static int64_t component_of(const topology *t, int64_t face) {
    for (;;) {
        int64_t up = __atomic_load_n(&t->joined_to[face], __ATOMIC_RELAXED);
        if (up == face)
            return face;
        int64_t higher = __atomic_load_n(&t->joined_to[up], __ATOMIC_RELAXED);
        if (higher != up) /* shorten the way; if another thread did so first, no harm */
            __atomic_compare_exchange_n(&t->joined_to[face], &up, higher, false, __ATOMIC_RELAXED,
                                        __ATOMIC_RELAXED);
        face = higher;
    }
}

/* Links go from higher to lower faces only, so a component's root is its lowest face. */
static void join_faces(topology *t, int64_t a, int64_t b) {
    for (;;) {
        a = component_of(t, a);
        b = component_of(t, b);
        if (a == b)
            return;
        int64_t high = a > b ? a : b, low = a > b ? b : a, expected = high;
        if (__atomic_compare_exchange_n(&t->joined_to[high], &expected, low, false,
                                        __ATOMIC_RELAXED, __ATOMIC_RELAXED))
            return;
    }
}

/* ---- one vertex --------------------------------------------------------------------------------
 */

static int64_t fan_of(int64_t *fan, int64_t corner) {
    while (fan[corner] != corner) {
        fan[corner] = fan[fan[corner]];
        corner = fan[corner];
    }
    return corner;
}

static void join_fans(int64_t *fan, int64_t a, int64_t b) {
    a = fan_of(fan, a);
    b = fan_of(fan, b);
    fan[a > b ? a : b] = a > b ? b : a;
}

/* Fill the scratch of vertex v: keys (neighbour; 2 corner + 1 if the edge comes in) sorted by
 * neighbour, and corners joined to fans across every edge, however many faces use it. */
static int64_t find_fans(const topology *t, int64_t v, scratch *s) {
    const int64_t *corners = t->corners + t->first_corner[v];
    int64_t count = t->first_corner[v + 1] - t->first_corner[v];
    for (int64_t i = 0; i < count; ++i) {
        uint32_t previous, next;
        neighbors_of(t, corners[i], &previous, &next);
        s->keys[2 * i] = (qni_key){next, 2 * (uint64_t)i};
        s->keys[2 * i + 1] = (qni_key){previous, 2 * (uint64_t)i + 1};
        s->fan[i] = i;
    }
    qni_sort_keys(s->keys, 2 * count);
    for (int64_t i = 1; i < 2 * count; ++i)
        if (s->keys[i].high == s->keys[i - 1].high)
            join_fans(s->fan, (int64_t)(s->keys[i].low / 2), (int64_t)(s->keys[i - 1].low / 2));
    return count;
}

/* An edge from v to a higher vertex, used by `uses` corners. */
static void count_edge(topology *t, const int64_t *corners, const qni_key *keys, int64_t uses,
                       vertex_counts *counts) {
    int64_t face = face_of(t, corners[keys[0].low / 2]);
    unsigned flags = 0;
    counts->edges += 1;
    if (uses == 1)
        flags = HAS_BOUNDARY;
    else if (uses > 2)
        flags = NOT_MANIFOLD;
    else if (keys[0].low % 2 == keys[1].low % 2)
        flags = NOT_ORIENTED;
    counts->boundary += flags == HAS_BOUNDARY;
    counts->nonmanifold_edges += flags == NOT_MANIFOLD;
    counts->conflicts += flags == NOT_ORIENTED;
    __atomic_fetch_sub(&t->euler[face], 1, __ATOMIC_RELAXED);
    if (flags)
        __atomic_fetch_or(&t->face_flags[face], (uint8_t)flags, __ATOMIC_RELAXED);
    for (int64_t i = 1; i < uses; ++i)
        join_faces(t, face, face_of(t, corners[keys[i].low / 2]));
}

/* Faces of which v is the lowest vertex and whose vertices another such face has too, less one a
 * set. */
static int64_t count_duplicates(const topology *t, int64_t v, int64_t count, scratch *s) {
    const int64_t *corners = t->corners + t->first_corner[v];
    int64_t found = 0, duplicates = 0;
    for (int64_t i = 0; i < count; ++i) {
        const uint32_t *indices;
        int n = qni_face_corners(t->mesh, face_of(t, corners[i]), &indices);
        uint32_t rest[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
        int m = 0;
        for (int k = 0; k < n; ++k)
            if ((int64_t)indices[k] != v && corner_counts(indices, n, k))
                rest[m++] = indices[k];
        for (int a = 1; a < 3; ++a)
            for (int b = a; b > 0 && rest[b] < rest[b - 1]; --b) {
                uint32_t swapped = rest[b];
                rest[b] = rest[b - 1];
                rest[b - 1] = swapped;
            }
        if ((int64_t)rest[0] > v)
            s->keys[found++] = (qni_key){((uint64_t)rest[0] << 32) | rest[1], rest[2]};
    }
    qni_sort_keys(s->keys, found);
    for (int64_t i = 1; i < found; ++i)
        duplicates += !qni_key_less(s->keys[i - 1], s->keys[i]);
    return duplicates;
}

static void look_at_vertex(topology *t, int64_t v, scratch *s, vertex_counts *counts) {
    const int64_t *corners = t->corners + t->first_corner[v];
    int64_t count = find_fans(t, v, s), valence = 0, fans = 0;
    bool inner = true;
    for (int64_t begin = 0, end; begin < 2 * count; begin = end) {
        for (end = begin + 1; end < 2 * count && s->keys[end].high == s->keys[begin].high;)
            ++end;
        inner = inner && end - begin != 1;
        ++valence;
        if ((int64_t)s->keys[begin].high > v)
            count_edge(t, corners, s->keys + begin, end - begin, counts);
    }
    for (int64_t i = 0; i < count; ++i)
        if (s->fan[i] == i) {
            ++fans;
            __atomic_fetch_add(&t->euler[face_of(t, corners[i])], 1, __ATOMIC_RELAXED);
        }
    if (fans > 1) {
        counts->pinched += 1;
        t->check->vertex_flags[v] |= QNI_VERTEX_PINCHED;
    }
    if (count && inner) {
        counts->inner_vertices += 1;
        counts->irregular_quad += valence != 4;
        counts->irregular_triangle += valence != 6;
    }
    if (count > 1)
        counts->duplicate_faces += count_duplicates(t, v, count, s);
}

static void look_at_vertices(void *pointer, int64_t block, int64_t begin, int64_t end) {
    topology *t = pointer;
    qni_key keys[2 * FEW_CORNERS];
    int64_t fan[FEW_CORNERS];
    scratch s = {keys, fan};
    vertex_counts counts = {0};
    for (int64_t v = begin; v < end; ++v)
        if (t->first_corner[v + 1] - t->first_corner[v] <= FEW_CORNERS)
            look_at_vertex(t, v, &s, &counts);
    t->blocks[block] = counts;
}

/* A component is not a manifold when two of its own fans meet at a vertex. */
static void mark_pinched(topology *t, int64_t v, scratch *s) {
    const int64_t *corners = t->corners + t->first_corner[v];
    int64_t count = find_fans(t, v, s), fans = 0;
    for (int64_t i = 0; i < count; ++i)
        if (s->fan[i] == i)
            s->keys[fans++] = (qni_key){(uint64_t)component_of(t, face_of(t, corners[i])), 0};
    qni_sort_keys(s->keys, fans);
    for (int64_t i = 1; i < fans; ++i)
        if (s->keys[i].high == s->keys[i - 1].high)
            t->face_flags[s->keys[i].high] |= NOT_MANIFOLD;
}

/* The few vertices with many corners, or with more than one fan, need room for all their corners.
 */
static qn_status look_at_the_rest(topology *t, vertex_counts *counts) {
    qn_context *context = t->check->context;
    scratch s = {qni_alloc(context, 2 * t->most_corners, sizeof *s.keys),
                 qni_alloc(context, t->most_corners, sizeof *s.fan)};
    bool good = s.keys && s.fan;
    for (int64_t v = 0; good && v < t->mesh->vertex_count; ++v)
        if (t->first_corner[v + 1] - t->first_corner[v] > FEW_CORNERS)
            look_at_vertex(t, v, &s, counts);
    for (int64_t v = 0; good && v < t->mesh->vertex_count; ++v)
        if (t->check->vertex_flags[v] & QNI_VERTEX_PINCHED)
            mark_pinched(t, v, &s);
    qni_free(context, s.keys, 2 * t->most_corners, sizeof *s.keys);
    qni_free(context, s.fan, t->most_corners, sizeof *s.fan);
    return good ? QN_OK : qni_fail_memory(t->check->error, "a mesh check");
}

/* ---- the whole ---------------------------------------------------------------------------------
 */

static void add_counts(vertex_counts *to, const vertex_counts *from) {
    to->edges += from->edges;
    to->boundary += from->boundary;
    to->nonmanifold_edges += from->nonmanifold_edges;
    to->conflicts += from->conflicts;
    to->pinched += from->pinched;
    to->duplicate_faces += from->duplicate_faces;
    to->inner_vertices += from->inner_vertices;
    to->irregular_quad += from->irregular_quad;
    to->irregular_triangle += from->irregular_triangle;
}

static void report_components(topology *t) {
    qn_mesh_report *report = t->check->report;
    for (int64_t face = 0; face < t->face_count; ++face) {
        int64_t root = component_of(t, face);
        if (root != face) {
            t->euler[root] += t->euler[face];
            t->face_flags[root] |= t->face_flags[face];
        }
    }
    for (int64_t face = 0; face < t->face_count; ++face) {
        unsigned flags = t->face_flags[face];
        if (t->joined_to[face] != face || (flags & NOT_POLYGON))
            continue;
        report->components += 1;
        report->closed_components += !(flags & HAS_BOUNDARY);
        if (flags)
            continue;
        int64_t genus = (2 - t->euler[face]) / 2;
        report->genus_sum += genus;
        if (genus > report->largest_genus)
            report->largest_genus = genus;
    }
}

static void report_counts(const topology *t, const vertex_counts *counts) {
    qn_mesh_report *report = t->check->report;
    int64_t polygons = 0;
    for (int64_t face = 0; face < t->face_count; ++face)
        polygons += !(t->face_flags[face] & NOT_POLYGON);
    report->edge_count = counts->edges;
    report->boundary_edges = counts->boundary;
    report->nonmanifold_edges = counts->nonmanifold_edges;
    report->orientation_conflicts = counts->conflicts;
    report->nonmanifold_vertices = counts->pinched;
    report->duplicate_faces = counts->duplicate_faces;
    report->euler_characteristic =
        report->vertex_count - report->unused_vertices - counts->edges + polygons;
    report->closed = counts->boundary == 0;
    report->manifold = counts->nonmanifold_edges == 0 && counts->pinched == 0;
    report->oriented = counts->conflicts == 0;
    int64_t irregular = t->mesh->quad_count ? counts->irregular_quad : counts->irregular_triangle;
    if (counts->inner_vertices)
        report->irregular_vertices = (double)irregular / (double)counts->inner_vertices;
}

static qn_status run(topology *t, qni_check_span span) {
    double part = (span.to - span.from) / 4;
    const qni_check_span counting = {span.from, span.from + part};
    const qni_check_span listing = {counting.to, counting.to + part},
                         looking = {listing.to, span.to};
    int64_t vertices = t->mesh->vertex_count;
    QN_TRY(qni_check_blocks(t->check, t->face_count, FACE_BLOCK, counting, count_corners, t));
    scan_corners(t);
    t->corners = qni_alloc(t->check->context, t->corner_count, sizeof *t->corners);
    if (!t->corners)
        return qni_fail_memory(t->check->error, "the corners of a mesh check");
    QN_TRY(qni_check_blocks(t->check, t->face_count, FACE_BLOCK, listing, list_corners, t));
    QN_TRY(qni_check_blocks(t->check, vertices, VERTEX_BLOCK, looking, look_at_vertices, t));
    vertex_counts total = {0};
    for (int64_t b = 0; b < qni_block_count(vertices, VERTEX_BLOCK); ++b)
        add_counts(&total, &t->blocks[b]);
    QN_TRY(look_at_the_rest(t, &total));
    report_counts(t, &total);
    report_components(t);
    return QN_OK;
}

qn_status qni_check_topology(qni_check *check, qni_check_span span) {
    qn_context *context = check->context;
    int64_t vertices = check->mesh.vertex_count;
    int64_t faces = check->mesh.quad_count + check->mesh.triangle_count;
    int64_t blocks = qni_block_count(vertices, VERTEX_BLOCK);
    topology t = {.check = check, .mesh = &check->mesh, .face_count = faces};
    t.first_corner = qni_alloc_zero(context, vertices + 1, sizeof *t.first_corner);
    t.joined_to = qni_alloc(context, faces, sizeof *t.joined_to);
    t.euler = qni_alloc(context, faces, sizeof *t.euler);
    t.face_flags = qni_alloc(context, faces, sizeof *t.face_flags);
    t.blocks = qni_alloc(context, blocks, sizeof *t.blocks);
    qn_status status;
    if (t.first_corner && t.joined_to && t.euler && t.face_flags && t.blocks)
        status = run(&t, span);
    else
        status = qni_fail_memory(check->error, "the edges of a mesh check");
    qni_free(context, t.first_corner, vertices + 1, sizeof *t.first_corner);
    qni_free(context, t.joined_to, faces, sizeof *t.joined_to);
    qni_free(context, t.euler, faces, sizeof *t.euler);
    qni_free(context, t.face_flags, faces, sizeof *t.face_flags);
    qni_free(context, t.blocks, blocks, sizeof *t.blocks);
    qni_free(context, t.corners, t.corner_count, sizeof *t.corners);
    return status;
}
