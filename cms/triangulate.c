// SPDX-License-Identifier: MIT
/* Triangles of a loop: a fan from its apex, or, when it is flat, none but its own vertices.
 *
 * Without an apex no diagonal may lie in a wall of the cell: the cell across could have a triangle
 * there. */
#include "cms/cms.h"
#include "core/status.h"
#include "mesh/predicates.h"
#include "mesh/triangle_pair.h"

#include <math.h>
#include <string.h>

enum { MOST_FLAT = 40 };

const float *qni_patch_place(const qni_patch *patch, int32_t vertex) {
    if (vertex < 0)
        return patch->loops[-1 - vertex].apex;
    return vertex >= QNI_INNER ? patch->inner[vertex - QNI_INNER] : patch->vertices[vertex].place;
}

static void add_triangle(qni_patch *patch, int32_t a, int32_t b, int32_t c, int32_t plane) {
    if (!qni_patch_grow(patch, (void **)&patch->triangles, &patch->triangle_capacity,
                        patch->triangle_count + 1, sizeof *patch->triangles))
        return;
    int32_t *triangle = patch->triangles[patch->triangle_count++];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
    triangle[3] = plane;
}

void qni_patch_fan(qni_patch *patch, qni_loop *loop) {
    loop->has_apex = true;
    loop->triangle_first = (int32_t)patch->triangle_count;
    for (int32_t n = 0; n < loop->count; ++n)
        add_triangle(patch, loop->first + n, loop->first + (n + 1) % loop->count,
                     -1 - (int32_t)(loop - patch->loops), -1);
    loop->triangle_count = (int32_t)patch->triangle_count - loop->triangle_first;
}

/* Newell's normal of the loop. */
static void loop_normal(const qni_loop_vertex *v, int32_t count, double normal[3]) {
    normal[0] = normal[1] = normal[2] = 0;
    for (int32_t n = 0; n < count; ++n) {
        const float *a = v[n].place, *b = v[(n + 1) % count].place;
        for (int k = 0; k < 3; ++k) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            normal[k] += ((double)a[l] - (double)b[l]) *
                         ((double)a[m] + (double)b[m] - 2 * (double)v[0].place[m]);
        }
    }
}

typedef struct flat_job {
    const qni_patch *patch;
    const qni_loop_vertex *v;
    int count;
    bool force; /* any triangle that faces the loop's way will do */
    double tolerance;
    double facing[3];                     /* unit length */
    uint8_t sheets[MOST_FLAT];            /* bits: on which side of a crease that comes through */
    bool curved;                          /* sheets that curve may be followed */
    double crease_height;                 /* four times the sag of the crease that comes through */
    int own[MOST_FLAT];                   /* of these planes, each vertex' own; -1: it has none */
    int planes[MOST_FLAT], plane_count;   /* vertices whose tangent planes differ */
    double heights[MOST_FLAT][MOST_FLAT]; /* of each vertex over each of these planes */
    double cost[MOST_FLAT][MOST_FLAT];
    int8_t choice[MOST_FLAT][MOST_FLAT], plane[MOST_FLAT][MOST_FLAT];
} flat_job;

static bool same_plane(const qni_loop_vertex *a, const qni_loop_vertex *b) {
    double height = 0;
    for (int k = 0; k < 3; ++k) {
        if (fabs(a->normal[k] - b->normal[k]) > 1e-9)
            return false;
        height += a->normal[k] * (b->at[k] - a->at[k]);
    }
    return fabs(height) <= 1e-9 * (1 + fabs(a->at[0]) + fabs(a->at[1]) + fabs(a->at[2])) &&
           a->owner == b->owner;
}

/* How far the crease that comes through leaves its chord: 0 without one; infinite where it is not
 * known, or there are several. */
static double crease_sag(const qni_patch *patch, const qni_loop *loop) {
    const float *ends[2];
    int count = 0;
    if (loop->sharp_count == 0)
        return 0;
    if (loop->sharp_count != 2 || !loop->has_apex || loop->escaped)
        return HUGE_VAL;
    for (int32_t n = 0; n < loop->count && count < 2; ++n)
        if (patch->vertices[loop->first + n].sharp)
            ends[count++] = patch->vertices[loop->first + n].place;
    double length2 = 0, along = 0, squares = 0;
    for (int k = 0; k < 3; ++k) {
        const double way = (double)ends[1][k] - (double)ends[0][k],
                     off = (double)loop->apex[k] - (double)ends[0][k];
        length2 += way * way;
        along += way * off;
        squares += off * off;
    }
    return length2 > 0 ? sqrt(fmax(squares - along * along / length2, 0)) : HUGE_VAL;
}

static void measure_heights(flat_job *job) {
    job->plane_count = 0;
    for (int n = 0; n < job->count; ++n) {
        int m = 0;
        while (job->v[n].has_plane && m < job->plane_count &&
               !same_plane(&job->v[job->planes[m]], &job->v[n]))
            ++m;
        job->own[n] = job->v[n].has_plane ? m : -1;
        if (job->v[n].has_plane && m == job->plane_count)
            job->planes[job->plane_count++] = n;
    }
    for (int m = 0; m < job->plane_count; ++m) {
        const qni_loop_vertex *plane = &job->v[job->planes[m]];
        for (int n = 0; n < job->count; ++n) {
            double height = 0;
            for (int k = 0; k < 3; ++k)
                height += plane->normal[k] * ((double)job->v[n].place[k] - plane->at[k]);
            job->heights[m][n] = fabs(height);
        }
    }
}

/* One crease through the loop: no triangle may lie on both sides of it. */
static void mark_sheets(flat_job *job, int32_t sharp_count) {
    uint8_t sheet = 1;
    for (int n = 0; n < job->count; ++n) {
        job->sheets[n] = sharp_count != 2 || job->v[n].sharp ? 3 : sheet;
        if (job->v[n].sharp)
            sheet = 3 - sheet;
    }
}

static double largest(double a, double b) {
    return a > b ? a : b;
}

/* The height of a triangle over a plane. */
static double height_over(const flat_job *job, int plane, int i, int j, int k) {
    const double *heights = job->heights[plane];
    return largest(heights[i], largest(heights[j], heights[k]));
}

/* Does a triangle lie in the tangent plane of any crossing on its side of the crease? */
static bool lies_flat(const flat_job *job, int i, int j, int k) {
    const uint8_t sheet = job->sheets[i] & job->sheets[j] & job->sheets[k];
    for (int m = 0; m < job->plane_count; ++m)
        if ((job->sheets[job->planes[m]] & sheet) && height_over(job, m, i, j, k) < job->tolerance)
            return true;
    return false;
}

/* The crossing, on the triangle's side of the crease, whose tangent plane the triangle lies in,
 * within the tolerance, and whose way it faces; -1 for none. */
static int plane_of(const flat_job *job, int i, int j, int k, const double normal[3], double area,
                    double *best_out) {
    const uint8_t sheet = job->sheets[i] & job->sheets[j] & job->sheets[k];
    double best = job->tolerance;
    int plane = -1;
    for (int m = 0; m < job->plane_count; ++m) {
        if (!(job->sheets[job->planes[m]] & sheet))
            continue;
        const double height = height_over(job, m, i, j, k);
        const double *tangent = job->v[job->planes[m]].normal;
        if (height < best &&
            tangent[0] * normal[0] + tangent[1] * normal[1] + tangent[2] * normal[2] >=
                job->patch->settings->facing_cosine * area) {
            best = height;
            plane = job->planes[m];
        }
    }
    *best_out = best;
    return plane;
}

/* The height of one vertex over the tangent plane of the other, or of this one over that. Sharp
 * features have no plane; two of them are the ends of a crease. */
static double height_between(const flat_job *job, int a, int b) {
    const int own_a = job->own[a], own_b = job->own[b];
    if (own_a < 0 && own_b < 0)
        return job->crease_height;
    return largest(own_a < 0 ? 0 : job->heights[own_a][b], own_b < 0 ? 0 : job->heights[own_b][a]);
}

/* How far a triangle is from a sheet that curves. Along an edge a quadratic surface leaves the
 * chord by h / 4, where h is the height of one end over the tangent plane at the other, and within
 * the triangle by the sum of l_i l_j h_ij over its edges, which is h / 3 at most. */
static double curved_height(const flat_job *job, int i, int j, int k) {
    return largest(height_between(job, i, j),
                   largest(height_between(job, j, k), height_between(job, k, i))) /
           3;
}

/* The plane of one of its vertices; -1 when it faces another way than one of theirs. */
static int curved_plane_of(const flat_job *job, const int corner[3], const double normal[3],
                           double area) {
    int plane = -1;
    for (int n = 0; n < 3; ++n) {
        const int own = job->own[corner[n]];
        if (own < 0)
            continue;
        const double *tangent = job->v[job->planes[own]].normal;
        if (tangent[0] * normal[0] + tangent[1] * normal[1] + tangent[2] * normal[2] <
            job->patch->settings->facing_cosine * area)
            return -1;
        plane = job->planes[own];
    }
    return plane;
}

/* What a triangle costs; infinite when it will not do. */
static double triangle_cost(const flat_job *job, int i, int j, int k, int *plane) {
    double a[3], b[3], normal[3], height = 0;
    bool curved = false;
    *plane = -1;
    if (!job->force) {
        if (!(job->sheets[i] & job->sheets[j] & job->sheets[k]))
            return HUGE_VAL;
        height = job->curved ? curved_height(job, i, j, k) : HUGE_VAL;
        curved = height < job->tolerance;
        if (!curved && !lies_flat(job, i, j, k))
            return HUGE_VAL;
    }
    for (int n = 0; n < 3; ++n) {
        a[n] = (double)job->v[j].place[n] - (double)job->v[i].place[n];
        b[n] = (double)job->v[k].place[n] - (double)job->v[i].place[n];
    }
    for (int n = 0; n < 3; ++n)
        normal[n] = a[(n + 1) % 3] * b[(n + 2) % 3] - a[(n + 2) % 3] * b[(n + 1) % 3];
    const double area = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    const double along =
        normal[0] * job->facing[0] + normal[1] * job->facing[1] + normal[2] * job->facing[2];
    const int corner[3] = {i, j, k};
    if (curved)
        *plane = curved_plane_of(job, corner, normal, area);
    if (*plane < 0 && !job->force)
        *plane = plane_of(job, i, j, k, normal, area, &height);
    if (job->force ? !(along > 0.2 * area) : *plane < 0)
        return HUGE_VAL;
    if (qni_collinear(job->v[i].place, job->v[j].place, job->v[k].place))
        return HUGE_VAL;
    return area * (height + 0.01 * job->tolerance); /* near to its plane first, then small */
}

static void add_range(qni_patch *patch, const qni_loop *loop, const flat_job *job, int i, int j) {
    if (j - i < 2)
        return;
    const int k = job->choice[i][j], plane = job->plane[i][j];
    add_triangle(patch, loop->first + i, loop->first + k, loop->first + j,
                 plane < 0 ? -1 : loop->first + plane);
    add_range(patch, loop, job, i, k);
    add_range(patch, loop, job, k, j);
}

/* Do two triangles of the range meet beyond what they share? */
static bool overlaps_itself(const qni_patch *patch, const qni_loop *loop) {
    float places[3 * MOST_FLAT];
    for (int32_t n = 0; n < loop->count; ++n)
        memcpy(places + 3 * n, patch->vertices[loop->first + n].place, 3 * sizeof(float));
    for (int64_t s = loop->triangle_first; s < patch->triangle_count; ++s)
        for (int64_t t = s + 1; t < patch->triangle_count; ++t) {
            uint32_t a[3], b[3];
            for (int k = 0; k < 3; ++k) {
                a[k] = (uint32_t)(patch->triangles[s][k] - loop->first);
                b[k] = (uint32_t)(patch->triangles[t][k] - loop->first);
            }
            if (qni_triangles_meet(places, a, b))
                return true;
        }
    return false;
}

/* Least cost over all triangulations of the loop's own vertices, by ranges i .. j. */
static bool choose_triangles(flat_job *job) {
    const qni_loop_vertex *v = job->v;
    const int count = job->count;
    for (int i = 0; i + 1 < count; ++i)
        job->cost[i][i + 1] = 0;
    for (int length = 2; length < count; ++length)
        for (int i = 0; i + length < count; ++i) {
            const int j = i + length;
            job->cost[i][j] = HUGE_VAL;
            if (length < count - 1 && (v[i].walls & v[j].walls))
                continue; /* a diagonal in a wall */
            for (int k = i + 1; k < j; ++k) {
                const double parts = job->cost[i][k] + job->cost[k][j];
                int plane = -1;
                if (!(parts < job->cost[i][j]))
                    continue;
                const double total = parts + triangle_cost(job, i, k, j, &plane);
                if (total < job->cost[i][j]) {
                    job->cost[i][j] = total;
                    job->choice[i][j] = (int8_t)k;
                    job->plane[i][j] = (int8_t)plane;
                }
            }
        }
    return job->cost[0][count - 1] < HUGE_VAL;
}

/* Triangles between the loop's own vertices: each in a tangent plane of the loop within the
 * tolerance, so that flat pieces, creases and even several creases that meet beyond the cell come
 * out as they are. With `force` any that face the loop's way. */
static bool flat_within(qni_patch *patch, qni_loop *loop, bool force, double tolerance) {
    flat_job job;
    if (loop->count > MOST_FLAT || loop->count < 3)
        return false;
    job.patch = patch;
    job.v = patch->vertices + loop->first;
    job.count = loop->count;
    job.tolerance = tolerance;
    job.force = force || !patch->settings->features;
    job.crease_height = 4 * crease_sag(patch, loop);
    job.curved = job.crease_height < HUGE_VAL;
    if (!job.force && job.curved && job.crease_height > 4 * tolerance)
        return false; /* the crease would be off by more */
    loop_normal(job.v, job.count, job.facing);
    const double length = sqrt(job.facing[0] * job.facing[0] + job.facing[1] * job.facing[1] +
                               job.facing[2] * job.facing[2]);
    for (int k = 0; k < 3; ++k)
        job.facing[k] /= length > 0 ? length : 1;
    mark_sheets(&job, loop->sharp_count);
    measure_heights(&job);
    if (!choose_triangles(&job))
        return false;
    loop->triangle_first = (int32_t)patch->triangle_count;
    add_range(patch, loop, &job, 0, job.count - 1);
    loop->triangle_count = (int32_t)patch->triangle_count - loop->triangle_first;
    loop->has_apex = false;
    if (!overlaps_itself(patch, loop))
        return true;
    patch->triangle_count = loop->triangle_first;
    loop->has_apex = true;
    return false;
}

/* A corner in the cell, or the end of a crease, has its fan: triangles that miss it a little are
 * not taken instead. Where several creases come through, neither are any that miss one just beyond
 * the cell; those that do well tell that the creases pass side by side. */
bool qni_patch_flat(qni_patch *patch, qni_loop *loop, bool force) {
    const bool corner = (loop->clusters > 2 || loop->sharp_count == 1) && !loop->escaped;
    const bool several = loop->sharp_count > 2;
    const double exact = 2e-5 * patch->hermite->lattice.cell,
                 tolerance = patch->settings->tolerance;
    if ((corner && !force) ||
        !flat_within(patch, loop, force, several ? fmin(tolerance, exact) : tolerance))
        return false;
    loop->escaped = loop->escaped && (force || !several);
    return true;
}

/* How far the loop's triangles are from the surface at their centroids, by the solid's values; no
 * matter how much above `most`. */
static qn_status measure(const qni_patch *patch, const qni_loop *loop, double most, double *worst) {
    const qn_solid *solid = patch->solid;
    *worst = 0;
    for (int32_t t = 0; t < loop->triangle_count && *worst < most; ++t) {
        const int32_t *triangle = patch->triangles[loop->triangle_first + t];
        double point[3] = {0, 0, 0}, value;
        for (int n = 0; n < 3; ++n)
            for (int k = 0; k < 3; ++k)
                point[k] += (double)qni_patch_place(patch, triangle[n])[k] / 3;
        if (!solid->ops->distance || !solid->ops->distance(solid, point, most, &value))
            QN_TRY(solid->ops->values(solid, 1, (const double(*)[3])point, &value));
        *worst = fmax(*worst, fabs(value));
    }
    return QN_OK;
}

/* Loops that no rule fits: a corner beyond the cell, a crease that curves or comes through twice.
 * Of a fan and of triangles in ever looser planes the one is taken that is nearest to the surface.
 */
static qn_status triangulate_odd(qni_patch *patch, qni_loop *loop) {
    const double size = patch->size;
    double best, worst, choice = 0;
    qni_patch_fan(patch, loop);
    QN_TRY(measure(patch, loop, HUGE_VAL, &best));
    patch->triangle_count = loop->triangle_first;
    for (double tolerance = 0.05 * size; tolerance < size; tolerance *= 2.5) {
        if (!flat_within(patch, loop, false, tolerance))
            continue;
        QN_TRY(measure(patch, loop, best, &worst));
        patch->triangle_count = loop->triangle_first;
        if (worst < best) {
            best = worst;
            choice = tolerance;
        }
    }
    if (choice == 0 || !flat_within(patch, loop, false, choice))
        qni_patch_fan(patch, loop);
    return QN_OK;
}

static bool is_odd(const qni_patch *patch, const qni_loop *loop) {
    return patch->settings->features && loop->clusters > 1 && loop->escaped;
}

/* Can it be a loop of several corners or creases? */
static bool is_many(const qni_patch *patch, const qni_loop *loop) {
    return patch->settings->features && patch->may_split && patch->octree &&
           patch->loop_count == 1 && loop->escaped && loop->sharp_count >= 4;
}

int64_t qni_patch_flaws(const qni_patch *patch) {
    int64_t flaws = patch->dropped;
    for (int64_t n = 0; n < patch->loop_count; ++n)
        flaws += patch->loops[n].escaped;
    return flaws;
}

/* Is a trial lost, whatever comes of the loops that are not triangulated yet? Of those a corner
 * that is not in the cell can still turn out to be flat, or several, where more than two features
 * tell. */
static bool is_lost(const qni_patch *patch, int64_t done) {
    int64_t flaws = qni_patch_flaws(patch);
    for (int64_t n = done; n < patch->loop_count; ++n)
        flaws -= patch->loops[n].escaped && patch->loops[n].sharp_count > 2;
    return flaws > patch->most_bad;
}

qn_status qni_patch_triangulate(qni_patch *patch, qni_cms_tally *tally) {
    for (int64_t n = 0; n < patch->loop_count; ++n) {
        qni_loop *loop = &patch->loops[n];
        if (is_lost(patch, n))
            break;
        if (qni_patch_flat(patch, loop, false))
            ++tally->flat_loops;
        else if (is_many(patch, loop) && qni_patch_split(patch)) {
            ++tally->split_loops;
            break;
        } else if (is_lost(patch, n + 1))
            break;
        else if (patch->cell.level == 0 && is_odd(patch, loop))
            QN_TRY(triangulate_odd(patch, loop));
        else {
            QN_TRY(qni_patch_settle_apex(patch, loop));
            qni_patch_fan(patch, loop);
        }
    }
    for (int64_t n = 0; n < patch->loop_count; ++n)
        tally->escaped_corners +=
            patch->loops[n].escaped && (patch->loops[n].has_apex || patch->cell.level == 0);
    return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}
