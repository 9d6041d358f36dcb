// SPDX-License-Identifier: MIT
/* Faces of polyhedra become triangles: ears are cut off in the plane that sees most of the face. */
#include <math.h>
#include <string.h>

#include "solid/polyhedron.h"

/* Newell's normal: it is right for faces that are not convex, and a mean for those not quite flat.
 */
static void face_normal(int64_t count, const int64_t *face, const double (*points)[3],
                        double normal[3]) {
    memset(normal, 0, 3 * sizeof *normal);
    for (int64_t n = 0; n < count; ++n) {
        const double *a = points[face[n]], *b = points[face[(n + 1) % count]];
        for (int k = 0; k < 3; ++k) {
            int u = (k + 1) % 3, v = (k + 2) % 3;
            normal[k] += (a[u] - b[u]) * (a[v] + b[v]);
        }
    }
}

/* Twice the signed area of a, b, c as the normal sees it. */
static double area(const double normal[3], const double *a, const double *b, const double *c) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        int u = (k + 1) % 3, v = (k + 2) % 3;
        sum += normal[k] * ((b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]));
    }
    return sum;
}

static bool is_ear(int64_t count, const int64_t *left, int64_t n, const double (*points)[3],
                   const double normal[3]) {
    const double *a = points[left[(n + count - 1) % count]], *b = points[left[n]],
                 *c = points[left[(n + 1) % count]];
    if (!(area(normal, a, b, c) > 0))
        return false;
    for (int64_t i = 0; i < count; ++i) {
        const double *p = points[left[i]];
        if (memcmp(p, a, 3 * sizeof *p) == 0 || memcmp(p, b, 3 * sizeof *p) == 0 ||
            memcmp(p, c, 3 * sizeof *p) == 0)
            continue;
        if (area(normal, a, b, p) >= 0 && area(normal, b, c, p) >= 0 && area(normal, c, a, p) >= 0)
            return false;
    }
    return true;
}

void qni_cut_face(int64_t count, const int64_t *face, const double (*points)[3], int64_t *left,
                  int64_t (*corners)[3]) {
    double normal[3];
    int64_t made = 0;
    face_normal(count, face, points, normal);
    memcpy(left, face, (size_t)count * sizeof *left);
    while (count >= 3) {
        int64_t ear = 0;
        while (ear < count && !is_ear(count, left, ear, points, normal))
            ++ear;
        ear %=
            count; /* none: a face that meets itself; the parity of its triangles is still right */
        corners[made][0] = left[(ear + count - 1) % count];
        corners[made][1] = left[ear];
        corners[made++][2] = left[(ear + 1) % count];
        memmove(left + ear, left + ear + 1, (size_t)(count - ear - 1) * sizeof *left);
        --count;
    }
}

static qn_status make(qn_context *context, const char *where, int64_t point_count,
                      const double (*points)[3], int64_t triangles, const int64_t (*corners)[3],
                      int32_t owner, qn_solid **solid_out, qn_error *error) {
    bool closed;
    if (!qni_triangles_are_closed(context, triangles, corners, &closed))
        return qni_fail_memory(error, "a polyhedron");
    if (!closed)
        return qni_fail(
            error, QN_ERROR_INPUT,
            "%s: the polyhedron is not closed: some edge belongs to an odd number of faces", where);
    *solid_out = qni_polyhedron_create(context, point_count, points, triangles, corners, owner);
    return *solid_out ? QN_OK : qni_fail_memory(error, "a polyhedron");
}

qn_status qni_polyhedron_from_faces(qn_context *context, const char *where, int64_t point_count,
                                    const double (*points)[3], int64_t face_count,
                                    const int64_t *face_sizes, const int64_t *indices,
                                    int32_t owner, qn_solid **solid_out, qn_error *error) {
    int64_t triangles = 0, longest = 0, used = 0, first = 0;
    *solid_out = NULL;
    for (int64_t n = 0; n < face_count; ++n) {
        if (face_sizes[n] < 3)
            return qni_fail(error, QN_ERROR_INPUT,
                            "%s: face %lld has %lld points: a face has 3 or more", where,
                            (long long)n, (long long)face_sizes[n]);
        triangles += face_sizes[n] - 2;
        longest = face_sizes[n] > longest ? face_sizes[n] : longest;
    }
    int64_t(*corners)[3] = qni_alloc(context, triangles, sizeof *corners);
    int64_t *left = qni_alloc(context, longest, sizeof *left);
    qn_status status = corners && left ? QN_OK : qni_fail_memory(error, "a polyhedron");
    for (int64_t n = 0; status == QN_OK && n < face_count; first += face_sizes[n++]) {
        qni_cut_face(face_sizes[n], indices + first, points, left, corners + used);
        used += face_sizes[n] - 2;
    }
    if (status == QN_OK)
        status = make(context, where, point_count, points, triangles, (const int64_t(*)[3])corners,
                      owner, solid_out, error);
    qni_free(context, corners, triangles, sizeof *corners);
    qni_free(context, left, longest, sizeof *left);
    return status;
}
