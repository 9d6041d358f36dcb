// SPDX-License-Identifier: MIT
/* Where crossings are looked for (untangle.h): at bent quads, and where several vertices lie on one
 * face, edge or point of the lattice. */
#include "core/sort.h"
#include "core/status.h"
#include "mesh/untangle.h"
#include "mesh/untangle_table.h"

enum { BITS_A_VERTEX = 16 };

/* ---- bent quads --------------------------------------------------------------------------------
 */

/* Twice the area of a quad's corner, as a vector. */
static void corner_area(const float *o, const float *a, const float *b, double area[3]) {
    double u[3], v[3];
    for (int n = 0; n < 3; ++n) {
        u[n] = (double)a[n] - (double)o[n];
        v[n] = (double)b[n] - (double)o[n];
    }
    for (int n = 0; n < 3; ++n)
        area[n] = u[(n + 1) % 3] * v[(n + 2) % 3] - u[(n + 2) % 3] * v[(n + 1) % 3];
}

static bool is_bent(const float *positions, const uint32_t quad[4]) {
    double areas[4][3], sum[3] = {0, 0, 0};
    bool bent = false;
    for (int k = 0; k < 4; ++k) {
        corner_area(positions + 3 * (size_t)quad[k], positions + 3 * (size_t)quad[(k + 1) & 3],
                    positions + 3 * (size_t)quad[(k + 3) & 3], areas[k]);
        for (int a = 0; a < 3; ++a)
            sum[a] += areas[k][a];
    }
    for (int k = 0; k < 4; ++k) {
        const double rise = areas[k][0] * sum[0] + areas[k][1] * sum[1] + areas[k][2] * sum[2];
        bent = bent || !(rise > 0);
    }
    return bent;
}

static void take_bent(qn_context *context, const qn_mesh_view *mesh, qni_vertex_set *suspects) {
    (void)context;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int64_t q = 0; q < mesh->quad_count; ++q) {
        const uint32_t *quad = mesh->quads + 4 * q;
        if (is_bent(mesh->positions, quad))
            for (int k = 0; k < 4; ++k)
                __atomic_fetch_or(&suspects->bits[quad[k] / 64], UINT64_C(1) << (quad[k] % 64),
                                  __ATOMIC_RELAXED);
    }
}

/* ---- vertices on lattice faces ----------------------------------------------------------------
 */

/* Whether a vertex lies on lattice planes; `face` becomes the name of the lattice face, edge or
 * point it lies on. */
static bool lies_on_plane(const double to_lattice[3][4], const float *position, int64_t face[3]) {
    const double near = 1e-5, whole = 0x1.8p52; /* added and taken off: rounds to a whole number */
    double local[3];
    bool on_any = false;
    qni_local_place(to_lattice, position, local);
    for (int a = 0; a < 3; ++a) {
        const double nearest = (local[a] + whole) - whole;
        const bool on_plane = fabs(local[a] - nearest) < near;
        on_any = on_any || on_plane;
        face[a] = 2 * (int64_t)nearest + (on_plane ? 0 : local[a] > nearest ? 1 : -1);
    }
    return on_any;
}

static int64_t count_on_planes(qn_context *context, const qn_mesh_view *mesh,
                               const double to_lattice[3][4]) {
    int64_t count = 0;
    (void)context;
#pragma omp parallel for schedule(static) reduction(+ : count)                                     \
    num_threads(qn_context_threads(context))
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        int64_t face[3];
        count += lies_on_plane(to_lattice, mesh->positions + 3 * v, face);
    }
    return count;
}

/* Enter the faces of vertices that lie on one. */
static void enter_faces(qn_context *context, const qn_mesh_view *mesh,
                        const double to_lattice[3][4], qni_bit_table *once, qni_bit_table *twice) {
    (void)context;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        int64_t face[3];
        if (lies_on_plane(to_lattice, mesh->positions + 3 * v, face) &&
            qni_table_put(once, qni_mix_place(face)))
            qni_table_put(twice, qni_mix_place(face));
    }
}

/* Vertices whose face may hold another one: the table can mistake a face for another. */
static void take_doubtful(qn_context *context, const qn_mesh_view *mesh,
                          const double to_lattice[3][4], const qni_bit_table *twice,
                          qni_vertex_set *doubtful) {
    (void)context;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int64_t word = 0; word <= mesh->vertex_count / 64; ++word)
        for (int64_t v = 64 * word; v < 64 * word + 64 && v < mesh->vertex_count; ++v) {
            int64_t face[3];
            if (lies_on_plane(to_lattice, mesh->positions + 3 * v, face) &&
                qni_table_has(twice, qni_mix_place(face)))
                doubtful->bits[word] |= UINT64_C(1) << (v % 64);
        }
}

typedef struct faced {
    int64_t face[3], vertex;
} faced;

static int compare_faces(const void *first, const void *second) {
    const faced *a = first, *b = second;
    for (int n = 0; n < 3; ++n)
        if (a->face[n] != b->face[n])
            return a->face[n] < b->face[n] ? -1 : 1;
    return 0;
}

/* Of the doubtful, those that do share a face. */
static bool add_shared(qn_context *context, const qn_mesh_view *mesh, const double to_lattice[3][4],
                       const qni_vertex_set *doubtful, qni_vertex_set *suspects) {
    const int64_t count = qni_vertex_set_count(doubtful);
    faced *list = qni_alloc(context, count, sizeof *list);
    if (!list)
        return false;
    int64_t n = 0;
    for (int64_t word = 0; word <= doubtful->count / 64; ++word)
        for (uint64_t left = doubtful->bits[word]; left; left &= left - 1, ++n) {
            list[n].vertex = 64 * word + __builtin_ctzll(left);
            lies_on_plane(to_lattice, mesh->positions + 3 * list[n].vertex, list[n].face);
        }
    const bool good = qni_sort(context, list, count, sizeof *list, compare_faces);
    for (int64_t i = 0; good && i < count; ++i)
        if ((i > 0 && compare_faces(list + i, list + i - 1) == 0) ||
            (i + 1 < count && compare_faces(list + i, list + i + 1) == 0))
            suspects->bits[list[i].vertex / 64] |= UINT64_C(1) << (list[i].vertex % 64);
    qni_free(context, list, count, sizeof *list);
    return good;
}

/* What lies on lattice planes: nothing in most meshes, nearly all in some. */
static bool take_planes(qn_context *context, const qn_mesh_view *mesh,
                        const double to_lattice[3][4], qni_vertex_set *suspects) {
    qni_bit_table once = {0, NULL}, twice = {0, NULL};
    qni_vertex_set doubtful = {0, NULL};
    const int64_t count = count_on_planes(context, mesh, to_lattice);
    if (count == 0)
        return true;
    bool good = qni_table_alloc(context, BITS_A_VERTEX * count, &once) &&
                qni_table_alloc(context, BITS_A_VERTEX * count, &twice) &&
                qni_vertex_set_alloc(context, mesh->vertex_count, &doubtful, NULL) == QN_OK;
    if (good) {
        enter_faces(context, mesh, to_lattice, &once, &twice);
        take_doubtful(context, mesh, to_lattice, &twice, &doubtful);
        good = add_shared(context, mesh, to_lattice, &doubtful, suspects);
    }
    if (doubtful.bits)
        qni_vertex_set_free(context, &doubtful);
    qni_table_free(context, &twice);
    qni_table_free(context, &once);
    return good;
}

qn_status qni_untangle_suspects(qn_context *context, const qn_mesh_view *mesh,
                                const double to_lattice[3][4], qni_vertex_set *suspects,
                                qn_error *error) {
    QN_TRY(qni_vertex_set_alloc(context, mesh->vertex_count, suspects, error));
    take_bent(context, mesh, suspects);
    if (take_planes(context, mesh, to_lattice, suspects))
        return QN_OK;
    qni_vertex_set_free(context, suspects);
    return qni_fail_memory(error, "the search for crossings");
}
