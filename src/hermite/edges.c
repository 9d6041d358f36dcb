// SPDX-License-Identifier: MIT
/* One block: signs at its 9^3 lattice points, then all crossings of the edges it owns.
 *
 * Edges whose ends differ are always asked for. Edges with equal ends can still be crossed twice (a
 * thin wall): they are asked for where neither the slopes in the block, nor bounds over 2^3 cells,
 * nor those over the edge itself rule that out. */
#include "core/context.h"
#include "core/status.h"
#include "hermite/hermite.h"

#include <math.h>
#include <string.h>

typedef struct edge_job {
    qni_sampling *sampling;
    const qni_lattice *lattice;
    const qn_solid *solid; /* restricted to the block */
    qni_hermite_block *block;
    qni_hermite_crossing *found;
    int32_t found_count, found_capacity;
    uint16_t starts[QNI_BLOCK_EDGES + 1];
    uint64_t asked, undecided;  /* 2^3 cells each: 16 z + 4 y + x */
    const qni_block_scan *scan; /* knows all; NULL where the solid is asked point by point */
    bool has_slopes;            /* f is continuous in the block, and its slopes are known */
    double slopes[3][2];
    double values[QNI_BLOCK_CORNERS];
    double planes[3][9];
} edge_job;

static bool in_bounds(const qni_box *bounds, int axis, double coordinate) {
    return coordinate >= bounds->low[axis] && coordinate <= bounds->high[axis];
}

/* The values; their signs alone (-1 and 1) where these cost less and no slopes ask for more. */
static qn_status find_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                             double *values) {
    if (!solid->ops->inside || solid->ops->slopes)
        return solid->ops->values(solid, count, points, values);
    bool inside[QNI_BLOCK_CORNERS];
    QN_TRY(solid->ops->inside(solid, count, points, inside));
    for (int64_t n = 0; n < count; ++n)
        values[n] = inside[n] ? -1 : 1;
    return QN_OK;
}

/* So many primitives are cut down once more for each of eight parts of a block. */
enum { MANY_PRIMITIVES = 8 };

/* The values of one part, by 4 or 5 points along each axis. */
static qn_status values_of_part(edge_job *job, int part) {
    double points[125][3], values[125];
    int corners[125], count = 0, from[3], to[3];
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        from[k] = part >> k & 1 ? 5 : 0;
        to[k] = part >> k & 1 ? 8 : 4;
        box.low[k] = job->planes[k][from[k]];
        box.high[k] = job->planes[k][to[k]];
    }
    for (int z = from[2]; z <= to[2]; ++z)
        for (int y = from[1]; y <= to[1]; ++y)
            for (int x = from[0]; x <= to[0]; ++x, ++count) {
                const int at[3] = {x, y, z};
                corners[count] = 81 * z + 9 * y + x;
                for (int k = 0; k < 3; ++k)
                    points[count][k] = job->planes[k][at[k]];
            }
    qn_solid *solid;
    QN_TRY(job->solid->ops->restrict_to(job->solid, &box, &solid));
    const qn_status status = find_values(solid, count, (const double(*)[3])points, values);
    qn_solid_destroy(solid);
    for (int n = 0; n < count; ++n)
        job->values[corners[n]] = values[n];
    return status;
}

static qn_status values_of_block(edge_job *job, const double (*points)[3]) {
    if (job->solid->weight < MANY_PRIMITIVES)
        return find_values(job->solid, QNI_BLOCK_CORNERS, points, job->values);
    for (int part = 0; part < 8; ++part)
        QN_TRY(values_of_part(job, part));
    return QN_OK;
}

/* Does the whole block lie within the bounds? */
static bool lies_within(const edge_job *job) {
    for (int k = 0; k < 3; ++k)
        if (!in_bounds(&job->lattice->bounds, k, job->planes[k][0]) ||
            !in_bounds(&job->lattice->bounds, k, job->planes[k][8]))
            return false;
    return true;
}

static qn_status sample_signs(edge_job *job) {
    double points[QNI_BLOCK_CORNERS][3], *values = job->values;
    for (int n = 0; n < QNI_BLOCK_CORNERS; ++n) {
        points[n][0] = job->planes[0][n % 9];
        points[n][1] = job->planes[1][n / 9 % 9];
        points[n][2] = job->planes[2][n / 81];
    }
    for (int n = 0; n < QNI_BLOCK_CORNERS && job->scan; ++n)
        values[n] = job->scan->inside[n] ? -1 : 1;
    if (!job->scan)
        QN_TRY(values_of_block(job, (const double(*)[3])points));
    job->sampling->evaluations += QNI_BLOCK_CORNERS;
    const bool all_within = lies_within(job);
    job->block->straddles = !all_within;
    for (int n = 0; n < QNI_BLOCK_CORNERS; ++n) {
        bool within = true;
        for (int k = 0; k < 3 && !all_within; ++k)
            within = within && in_bounds(&job->lattice->bounds, k, points[n][k]);
        job->block->inside[n >> 6] |= (uint64_t)(within && values[n] < 0) << (n & 63);
    }
    return QN_OK;
}

/* Is it open whether the surface is in a box, as far as the solid knows? */
static qn_status may_hold_surface(const edge_job *job, const qni_box *box, bool *may) {
    double range[2];
    if (job->solid->ops->changes && job->solid->ops->changes(job->solid, box, may))
        return QN_OK;
    QN_TRY(job->solid->ops->bounds(job->solid, box, range));
    *may = range[0] < 0 && range[1] >= 0; /* a value of 0 is outside */
    return QN_OK;
}

/* The same for 2^3 cells, asked once. */
static qn_status box_is_undecided(edge_job *job, int n, bool *undecided) {
    const uint64_t bit = UINT64_C(1) << n;
    const int at[3] = {2 * (n & 3), 2 * (n >> 2 & 3), 2 * (n >> 4)};
    qni_box box;
    *undecided = job->undecided & bit;
    if ((job->asked & bit) || job->lattice->samples) /* linear along edges: their ends say all */
        return QN_OK;
    for (int k = 0; k < 3; ++k) {
        box.low[k] = job->planes[k][at[k]];
        box.high[k] = job->planes[k][at[k] + 2];
    }
    QN_TRY(may_hold_surface(job, &box, undecided));
    job->asked |= bit;
    job->undecided |= *undecided ? bit : 0;
    return QN_OK;
}

/* The solid ends at the bounds: what of its crossings remains, and where its caps stand. Only edges
 * across the bounds. */
static qn_status clip(edge_job *job, int axis, const double a[3], const double b[3],
                      qni_crossing *list, int32_t *count) {
    const qni_box *bounds = &job->lattice->bounds;
    for (int side = 0; side < 2; ++side) {
        const double plane = side ? bounds->high[axis] : bounds->low[axis];
        if (!(side ? b[axis] > plane : a[axis] < plane))
            continue;
        double point[3] = {a[0], a[1], a[2]}, value;
        point[axis] = plane;
        QN_TRY(job->solid->ops->values(job->solid, 1, (const double(*)[3])point, &value));
        const double at = (plane - a[axis]) / (b[axis] - a[axis]);
        const double slack =
            value < 0 ? 0 : 1e-6; /* a surface that lies on the bounds is the solid's own */
        int32_t kept = 0;
        for (int32_t n = 0; n < *count; ++n)
            if (side ? list[n].at < at + slack : list[n].at > at - slack)
                list[kept++] = list[n];
        if (value < 0) {
            qni_crossing cap = {at, {0, 0, 0}, -1, side == 0};
            cap.normal[axis] = side ? 1 : -1;
            const int32_t place = side ? kept : 0;
            memmove(list + place + 1, list + place, sizeof *list * (size_t)(kept - place));
            list[place] = cap;
            ++kept;
        }
        *count = kept;
    }
    return QN_OK;
}

/* One crossing that nobody found, though the ends differ: bisection on the values. */
static qn_status bisect(edge_job *job, const double a[3], const double b[3], bool enters,
                        qni_crossing *out) {
    double low = 0, high = 1;
    double point[3], gradient[3];
    for (int step = 0; step < 50; ++step) {
        const double middle = 0.5 * (low + high);
        double value;
        for (int k = 0; k < 3; ++k)
            point[k] = a[k] + middle * (b[k] - a[k]);
        QN_TRY(job->solid->ops->values(job->solid, 1, (const double(*)[3])point, &value));
        if ((value < 0) == enters)
            high = middle;
        else
            low = middle;
    }
    QN_TRY(job->solid->ops->gradients(job->solid, 1, (const double(*)[3])point,
                                      (double(*)[3])gradient, &out->owner));
    out->at = low;
    out->enters = enters;
    memcpy(out->normal, gradient, sizeof gradient);
    return QN_OK;
}

/* Keep an alternating list that agrees with the signs at the ends. */
static qn_status mend(edge_job *job, const double a[3], const double b[3], bool start, bool end,
                      qni_crossing *list, int32_t *count) {
    int32_t kept = 0;
    bool inside = start;
    for (int32_t n = 0; n < *count; ++n)
        if (list[n].enters != inside && list[n].at >= 0 && list[n].at <= 1) {
            inside = list[n].enters;
            list[kept++] = list[n];
        }
    job->sampling->mended_edges += kept != *count || inside != end;
    if (inside != end && kept > 0)
        --kept;
    else if (inside != end)
        QN_TRY(bisect(job, a, b, !start, &list[kept++]));
    *count = kept;
    return QN_OK;
}

/* Unit length, and a direction even where there is none. */
static void normalize(double normal[3], int axis, bool enters) {
    const double length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    const bool good = length > 0 && isfinite(length);
    for (int k = 0; k < 3; ++k)
        normal[k] = good ? normal[k] / length : 0;
    if (!good)
        normal[axis] = enters ? -1 : 1;
}

/* Floats strictly between the ends and ascending; pairs for which there is no room are dropped. */
static void round_places(edge_job *job, qni_hermite_crossing *list, int32_t *count, int axis,
                         float low, float high) {
    for (;;) {
        float before = low;
        for (int32_t n = 0; n < *count; ++n) {
            const float least = nextafterf(before, high);
            const float here = (float)list[n].at;
            list[n].place[axis] = before = here > least ? here : least;
        }
        float after = high;
        for (int32_t n = *count - 1; n >= 0 && list[n].place[axis] >= after; --n) {
            list[n].place[axis] = nextafterf(after, low);
            after = list[n].place[axis];
        }
        if (*count == 0 || list[0].place[axis] > low)
            return;
        *count -= 2;
        ++job->sampling->mended_edges;
    }
}

static bool grow(edge_job *job) {
    if (job->found_count + QNI_EDGE_CAPACITY + 4 <= job->found_capacity)
        return true;
    qn_context *context = job->sampling->hermite->context;
    const int32_t capacity = job->found_capacity ? 2 * job->found_capacity : 512;
    qni_hermite_crossing *found =
        qni_realloc(context, job->found, job->found_capacity, capacity, sizeof *found);
    if (!found)
        return false;
    job->found = found;
    job->found_capacity = capacity;
    return true;
}

static qn_status keep(edge_job *job, int edge, int axis, const double a[3], const double b[3],
                      const qni_crossing *list, int32_t count) {
    if (count == 0)
        return QN_OK;
    if (!grow(job))
        return QN_ERROR_OUT_OF_MEMORY;
    qni_hermite_crossing *out = job->found + job->found_count;
    for (int32_t n = 0; n < count; ++n) {
        out[n].at = a[axis] + list[n].at * (b[axis] - a[axis]);
        out[n].owner = list[n].owner;
        out[n].enters = list[n].enters;
        out[n].axis = (uint8_t)axis;
        for (int k = 0; k < 3; ++k)
            out[n].place[k] = (float)a[k];
        memcpy(out[n].normal, list[n].normal, sizeof out[n].normal);
        normalize(out[n].normal, axis, out[n].enters);
    }
    const double room = job->lattice->clearance;
    round_places(job, out, &count, axis, (float)(a[axis] + room), (float)(b[axis] - room));
    if (count == 0)
        return QN_OK;
    qni_hermite_block *block = job->block;
    block->crossed[edge >> 6] |= UINT64_C(1) << (edge & 63);
    job->found_count += count;
    job->starts[++block->edge_count] = (uint16_t)job->found_count;
    if (count > 1) {
        block->multiple = true;
        ++job->sampling->multiple_edges;
    }
    return QN_OK;
}

/* Can an edge with equal ends be crossed? Its four 2^3 neighbours within the block all hold it. */
static qn_status edge_is_undecided(edge_job *job, const int at[3], const double a[3],
                                   const double b[3], bool *undecided) {
    QN_TRY(box_is_undecided(job, 16 * (at[2] >> 1) + 4 * (at[1] >> 1) + (at[0] >> 1), undecided));
    if (!*undecided)
        return QN_OK;
    qni_box box;
    memcpy(box.low, a, sizeof box.low);
    memcpy(box.high, b, sizeof box.high);
    return may_hold_surface(job, &box, undecided);
}

/* All crossings of an edge; where f is known to rise or fall all the way, and its crossings are
 * found by values, what is known of it is not asked again. */
static qn_status find_crossings(edge_job *job, int edge, int corner, int stride, const double a[3],
                                const double b[3], qni_crossing *list, int32_t *count) {
    const qn_solid *solid = job->solid;
    const int axis = edge >> 9;
    if (job->scan) {
        const int32_t first = job->scan->starts[edge];
        *count = job->scan->starts[edge + 1] - first;
        memcpy(list, job->scan->crossings + first, sizeof *list * (size_t)*count);
        return QN_OK;
    }
    const double ends[2] = {job->values[corner], job->values[corner + stride]};
    const bool monotone = job->has_slopes && (job->slopes[axis][0] > 0 || job->slopes[axis][1] < 0);
    if (monotone && solid->ops->slope && solid->ops->crossings == qni_find_crossings &&
        (ends[0] < 0) != (ends[1] < 0)) {
        *count = 1;
        return qni_find_single(solid, a, b, ends, list);
    }
    return solid->ops->crossings(solid, a, b, QNI_EDGE_CAPACITY, list, count);
}

static qn_status one_edge(edge_job *job, int edge) {
    const int axis = edge >> 9, at[3] = {edge & 7, edge >> 3 & 7, edge >> 6 & 7};
    const int corner = 81 * at[2] + 9 * at[1] + at[0], stride = axis == 0 ? 1 : axis == 1 ? 9 : 81;
    const bool start = qni_bit(job->block->inside, corner),
               end = qni_bit(job->block->inside, corner + stride);
    const qni_box *bounds = &job->lattice->bounds;
    double a[3], b[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = b[k] = job->planes[k][at[k]];
        if (k != axis && !in_bounds(bounds, k, a[k]))
            return QN_OK;
    }
    b[axis] = job->planes[axis][at[axis] + 1];
    if (b[axis] < bounds->low[axis] || a[axis] > bounds->high[axis])
        return QN_OK;
    bool ask = start != end || (job->scan && qni_bit(job->scan->crossed, edge));
    if (!ask && !job->scan)
        QN_TRY(edge_is_undecided(job, at, a, b, &ask));
    if (!ask)
        return QN_OK;
    qni_crossing list[QNI_EDGE_CAPACITY + 4];
    int32_t count = 0;
    QN_TRY(find_crossings(job, edge, corner, stride, a, b, list, &count));
    count = count > QNI_EDGE_CAPACITY ? QNI_EDGE_CAPACITY : count;
    if (a[axis] < bounds->low[axis] || b[axis] > bounds->high[axis])
        QN_TRY(clip(job, axis, a, b, list, &count));
    QN_TRY(mend(job, a, b, start, end, list, &count));
    return keep(job, edge, axis, a, b, list, count);
}

static qn_status store(edge_job *job) {
    qn_context *context = job->sampling->hermite->context;
    qni_hermite_block *block = job->block;
    int before = 0;
    for (int word = 0; word < 24; ++word) {
        block->rank[word] = (uint16_t)before;
        before += qni_count_bits(block->crossed[word]);
    }
    block->crossings = qni_alloc(context, job->found_count, sizeof *block->crossings);
    block->starts = qni_alloc(context, block->edge_count + 1, sizeof *block->starts);
    block->crossing_count = job->found_count;
    if (!block->crossings || !block->starts)
        return QN_ERROR_OUT_OF_MEMORY;
    if (job->found_count)
        memcpy(block->crossings, job->found, sizeof *job->found * (size_t)job->found_count);
    memcpy(block->starts, job->starts, sizeof *job->starts * (size_t)(block->edge_count + 1));
    return QN_OK;
}

/* The edges of one axis with differing ends, and those that slopes do not rule out: from values of
 * one sign at its ends, f cannot reach 0 between them if that takes a steeper slope than there is,
 * down from one and up to the other. */
static void choose_edges(const edge_job *job, int axis, uint64_t wanted[8]) {
    const int stride = axis == 0 ? 1 : axis == 1 ? 9 : 81;
    const double *range = job->slopes[axis], *planes = job->planes[axis];
    const double steepest = -range[0] > range[1] ? -range[0] : range[1];
    double least[8];
    for (int n = 0; n < 8; ++n)
        least[n] = steepest * (planes[n + 1] - planes[n]) * (1 + 1e-6);
    for (int n = 0; n < 512; ++n) {
        const int at[3] = {n & 7, n >> 3 & 7, n >> 6}, corner = 81 * at[2] + 9 * at[1] + at[0];
        const double sum = fabs(job->values[corner]) + fabs(job->values[corner + stride]);
        const bool differ =
            qni_bit(job->block->inside, corner) != qni_bit(job->block->inside, corner + stride);
        wanted[n >> 6] |= (uint64_t)(differ || !(sum > least[at[axis]])) << (n & 63);
    }
}

/* A row of nine signs along x. */
static unsigned row_of_signs(const qni_hermite_block *block, int y, int z) {
    const int first = 81 * z + 9 * y, shift = first & 63;
    uint64_t bits = block->inside[first >> 6] >> shift;
    if (shift > 64 - 9)
        bits |= block->inside[(first >> 6) + 1] << (64 - shift);
    return (unsigned)bits & 0x1ff;
}

/* The edges of one axis with differing ends, or with crossings by the scan. */
static void choose_scanned_edges(const edge_job *job, int axis, uint64_t wanted[8]) {
    for (int z = 0; z < 8; ++z) {
        wanted[z] = job->scan->crossed[8 * axis + z];
        for (int y = 0; y < 8; ++y) {
            const unsigned row = row_of_signs(job->block, y, z),
                           next = axis == 0
                                      ? row >> 1
                                      : row_of_signs(job->block, y + (axis == 1), z + (axis == 2));
            wanted[z] |= (uint64_t)((row ^ next) & 0xff) << 8 * y;
        }
    }
}

static qn_status sample(edge_job *job) {
    QN_TRY(sample_signs(job));
    for (int axis = 0; axis < 3; ++axis) {
        uint64_t wanted[8] = {0};
        if (job->scan)
            choose_scanned_edges(job, axis, wanted);
        else if (job->has_slopes)
            choose_edges(job, axis, wanted);
        else
            memset(wanted, 0xff, sizeof wanted);
        for (int word = 0; word < 8; ++word)
            for (uint64_t bits = wanted[word]; bits; bits &= bits - 1)
                QN_TRY(one_edge(job, 512 * axis + 64 * word + __builtin_ctzll(bits)));
    }
    return store(job);
}

static qn_status scan_and_sample(edge_job *job) {
    qni_block_scan scan;
    bool known = false;
    if (!job->solid->ops->scan)
        return sample(job);
    qn_status status = job->solid->ops->scan(job->solid, (const double(*)[9])job->planes,
                                             QNI_EDGE_CAPACITY, &scan, &known);
    job->scan = known ? &scan : NULL;
    if (status == QN_OK)
        status = sample(job);
    qni_free(job->sampling->hermite->context, scan.crossings, scan.capacity,
             sizeof *scan.crossings);
    return status;
}

qn_status qni_sample_block(qni_sampling *sampling, qni_hermite_block *block) {
    qni_hermite *hermite = sampling->hermite;
    edge_job job = {.sampling = sampling, .lattice = &hermite->lattice, .block = block};
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        for (int n = 0; n < 9; ++n)
            job.planes[k][n] = qni_lattice_at(&hermite->lattice, k, 8 * block->place[k] + n);
        box.low[k] = job.planes[k][0];
        box.high[k] = job.planes[k][8];
    }
    const int32_t low[3] = {8 * block->place[0], 8 * block->place[1], 8 * block->place[2]};
    job.solid = qni_region_cube(sampling->region, low, 3);
    if (!job.solid)
        return QN_ERROR_OUT_OF_MEMORY;
    job.has_slopes = job.solid->ops->slopes && job.solid->ops->slopes(job.solid, &box, job.slopes);
    const qn_status status = scan_and_sample(&job);
    qni_free(hermite->context, job.found, job.found_capacity, sizeof *job.found);
    return status;
}
