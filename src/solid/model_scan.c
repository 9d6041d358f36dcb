// SPDX-License-Identifier: MIT
/* A block of lattice cells by scan conversion: each panel near it says which lattice lines it
 * meets, and where. So a block costs what its panels and crossings cost, not what its points do.
 * Signs follow from one point by walking: along z, from there along y, and from there along x. */
#include "solid/model.h"

#include <string.h>

enum { CELLS = QNI_SCAN_CELLS, POINTS = QNI_SCAN_CELLS + 1, AT_ONCE = 256 };

typedef struct scan_hit {
    qni_hit hit;
    int32_t edge;
} scan_hit;

typedef struct scan_job {
    const qni_meshed *solid;
    const double (*planes)[POINTS];
    double tame[3][POINTS];
    /* What passing an edge adds to the winding number: of those along x all, of those along y the
     * ones at the first x, of those along z the ones at the first x and y. */
    int32_t along_x[POINTS][POINTS][CELLS], along_y[POINTS][CELLS], along_z[CELLS];
    int64_t winding[QNI_SCAN_POINTS];
    scan_hit first[AT_ONCE], *hits;
    int64_t count, capacity;
    bool failed;
} scan_job;

static scan_hit *new_hit(scan_job *job) {
    qn_context *context = job->solid->base.context;
    if (job->count == job->capacity) {
        const bool grown = job->hits != job->first;
        scan_hit *hits = qni_realloc(context, grown ? job->hits : NULL, grown ? job->capacity : 0,
                                     4 * job->capacity, sizeof *hits);
        if (!hits) {
            job->failed = true;
            return NULL;
        }
        if (!grown)
            memcpy(hits, job->first, sizeof job->first);
        job->hits = hits;
        job->capacity *= 4;
    }
    return &job->hits[job->count++];
}

/* ---- one panel
 * ----------------------------------------------------------------------------------- */

/* A panel seen along an axis. */
typedef struct view {
    const qni_panel *panel;
    bool cap;
    int axis;
    int32_t at[3]; /* the line's, along the axis the edge's */
} view;

static void point_of(const scan_job *job, const int32_t at[3], double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = job->tame[k][at[k]];
}

static int side_at(const scan_job *job, const view *seen, int32_t plane) {
    double point[3];
    point_of(job, seen->at, point);
    point[seen->axis] = job->tame[seen->axis][plane];
    return qni_panel_side(seen->panel, point);
}

/* The cell in which the line passes the panel: where the sides of its ends differ; -1: none here.
 * `below`: the side of all before it. */
static int32_t find_cell(const scan_job *job, const view *seen, int below) {
    if (below == side_at(job, seen, CELLS))
        return -1;
    double low[3], high[3];
    point_of(job, seen->at, low);
    memcpy(high, low, sizeof high);
    low[seen->axis] = job->tame[seen->axis][0];
    high[seen->axis] = job->tame[seen->axis][CELLS];
    int32_t cell = (int32_t)(qni_panel_place(seen->panel, low, high) * CELLS);
    cell = cell < 0 ? 0 : cell >= CELLS ? CELLS - 1 : cell;
    while (cell > 0 && side_at(job, seen, cell) != below)
        --cell;
    while (cell < CELLS - 1 && side_at(job, seen, cell + 1) == below)
        ++cell;
    return cell;
}

/* Blocks own the edges whose lower ends are not on their upper sides. */
static int32_t edge_at(const view *seen) {
    for (int k = 0; k < 3; ++k)
        if (seen->at[k] == CELLS)
            return -1;
    return 512 * seen->axis + 64 * seen->at[2] + 8 * seen->at[1] + seen->at[0];
}

static void note_change(scan_job *job, const view *seen, int32_t change) {
    const int32_t *at = seen->at;
    if (seen->axis == 0)
        job->along_x[at[2]][at[1]][at[0]] += change;
    else if (seen->axis == 1 && at[0] == 0)
        job->along_y[at[2]][at[1]] += change;
    else if (seen->axis == 2 && at[0] == 0 && at[1] == 0)
        job->along_z[at[2]] += change;
}

static void meet_line(scan_job *job, view *seen) {
    double a[3], b[3];
    seen->at[seen->axis] = 0;
    point_of(job, seen->at, a);
    if (!qni_panel_is_on_line(seen->panel, a, seen->axis))
        return;
    const int below = side_at(job, seen, 0);
    const int32_t cell = find_cell(job, seen, below);
    if (cell < 0)
        return;
    seen->at[seen->axis] = cell;
    note_change(job, seen, below);
    const int32_t edge = edge_at(seen);
    scan_hit *hit = edge < 0 ? NULL : new_hit(job);
    if (!hit)
        return;
    point_of(job, seen->at, a);
    memcpy(b, a, sizeof b);
    b[seen->axis] = job->tame[seen->axis][cell + 1];
    *hit = (scan_hit){{qni_panel_place(seen->panel, a, b), seen->panel, below, seen->cap}, edge};
}

/* The planes of an axis that a panel's extent holds. */
static void planes_between(const double planes[POINTS], double low, double high, int32_t range[2]) {
    range[0] = 0;
    range[1] = -1;
    for (int n = 0; n < POINTS; ++n) {
        range[0] += planes[n] < low;
        range[1] += planes[n] <= high;
    }
}

static void scan_panel(scan_job *job, const qni_panel *panel, bool cap) {
    int32_t range[3][2];
    for (int k = 0; k < 3; ++k) {
        const float x = panel->at[0][k], y = panel->at[1][k], z = panel->at[2][k];
        const float less = x < y ? x : y, more = x < y ? y : x;
        planes_between(job->tame[k], (double)(z < less ? z : less), (double)(z > more ? z : more),
                       range[k]);
    }
    view seen = {.panel = panel, .cap = cap};
    for (seen.axis = 0; seen.axis < 3; ++seen.axis) {
        const int u = (seen.axis + 1) % 3, v = (seen.axis + 2) % 3;
        for (seen.at[v] = range[v][0]; seen.at[v] <= range[v][1]; ++seen.at[v])
            for (seen.at[u] = range[u][0]; seen.at[u] <= range[u][1]; ++seen.at[u])
                meet_line(job, &seen);
    }
}

/* ---- the block
 * ----------------------------------------------------------------------------------- */

static void walk_signs(scan_job *job, qni_block_scan *scan) {
    const double corner[3] = {job->planes[0][0], job->planes[1][0], job->planes[2][0]};
    int64_t at_z = qni_meshed_winding(job->solid, corner);
    int64_t *winding = job->winding;
    for (int z = 0; z < POINTS; ++z) {
        int64_t at_y = at_z;
        for (int y = 0; y < POINTS; ++y) {
            *winding++ = at_y;
            for (int x = 0; x < CELLS; ++x, ++winding)
                *winding = winding[-1] + job->along_x[z][y][x];
            at_y += y < CELLS ? job->along_y[z][y] : 0;
        }
        at_z += z < CELLS ? job->along_z[z] : 0;
    }
    for (int n = 0; n < QNI_SCAN_POINTS; ++n)
        scan->inside[n] = qni_whole_is_inside(job->solid->model, job->winding[n]);
    for (int n = 0; n < QNI_SCAN_POINTS && job->solid->smooth; ++n) {
        const double point[3] = {job->planes[0][n % 9], job->planes[1][n / 9 % 9],
                                 job->planes[2][n / 81]};
        scan->inside[n] = qni_model_excess(job->solid->model, job->winding[n], point, NULL) >= 0;
    }
}

/* Hits by edge, in the order found. */
static bool sort_by_edge(scan_job *job, qni_block_scan *scan, scan_hit **sorted) {
    *sorted = qni_alloc(job->solid->base.context, job->count, sizeof **sorted);
    if (!*sorted)
        return false;
    memset(scan->starts, 0, sizeof scan->starts);
    for (int64_t n = 0; n < job->count; ++n)
        ++scan->starts[job->hits[n].edge + 1];
    for (int n = 0; n < QNI_SCAN_EDGES; ++n)
        scan->starts[n + 1] += scan->starts[n];
    for (int64_t n = 0; n < job->count; ++n)
        (*sorted)[scan->starts[job->hits[n].edge]++] = job->hits[n];
    for (int n = QNI_SCAN_EDGES; n > 0; --n)
        scan->starts[n] = scan->starts[n - 1];
    scan->starts[0] = 0;
    return true;
}

/* The signs at the ends of an edge. */
static void ends_of(const qni_block_scan *scan, int edge, bool ends[2]) {
    static const int strides[3] = {1, 9, 81};
    const int corner = 81 * (edge >> 6 & 7) + 9 * (edge >> 3 & 7) + (edge & 7);
    ends[0] = scan->inside[corner];
    ends[1] = scan->inside[corner + strides[edge >> 9]];
}

/* Where no panel is met there can be a crossing over a hole, between ends that differ. */
static bool may_cross(const scan_job *job, const qni_block_scan *scan, int edge, int32_t hits) {
    bool ends[2];
    ends_of(scan, edge, ends);
    return hits > 0 || (job->solid->smooth && ends[0] != ends[1]);
}

/* The crossings of one edge, behind those that are there. */
static bool sweep_edge(const scan_job *job, int edge, const scan_hit *hits, int32_t count,
                       int32_t most, qni_block_scan *scan) {
    const int axis = edge >> 9, at[3] = {edge & 7, edge >> 3 & 7, edge >> 6 & 7};
    double a[3], b[3];
    bool ends[2];
    ends_of(scan, edge, ends);
    for (int k = 0; k < 3; ++k) {
        a[k] = job->planes[k][at[k]];
        b[k] = job->planes[k][at[k] + (k == axis)];
    }
    qni_hits own = {.context = job->solid->base.context, .items = own.first, .count = count};
    const int32_t room = (int32_t)(sizeof own.first / sizeof *own.first);
    own.capacity = count > room ? count : room;
    if (count > room)
        own.items = qni_alloc(own.context, count, sizeof *own.items);
    if (!own.items)
        return false;
    for (int32_t n = 0; n < count; ++n)
        own.items[n] = hits[n].hit;
    qni_hits_sort(&own);
    const int32_t found =
        qni_meshed_sweep(job->solid, a, b, &own, job->winding[81 * at[2] + 9 * at[1] + at[0]], ends,
                         job->solid->smooth, most, scan->crossings + scan->count);
    scan->count += found;
    scan->crossed[edge >> 6] |= (uint64_t)(found > 0) << (edge & 63);
    qni_hits_free(&own);
    return true;
}

/* One at each hit at most, and over holes one between two hits. */
static int64_t most_crossings(const scan_job *job, const qni_block_scan *scan) {
    int64_t most = job->count;
    for (int edge = 0; edge < QNI_SCAN_EDGES && job->solid->smooth; ++edge) {
        const int32_t hits = scan->starts[edge + 1] - scan->starts[edge];
        most += may_cross(job, scan, edge, hits) ? hits + 1 : 0;
    }
    return most;
}

static qn_status find_crossings(scan_job *job, int32_t most, qni_block_scan *scan) {
    scan_hit *sorted;
    bool room = sort_by_edge(job, scan, &sorted);
    scan->capacity = room ? most_crossings(job, scan) : 0;
    scan->crossings =
        room ? qni_alloc(job->solid->base.context, scan->capacity, sizeof *scan->crossings) : NULL;
    room = scan->crossings != NULL;
    for (int edge = 0, from = 0; room && edge < QNI_SCAN_EDGES; ++edge) {
        const int32_t to = scan->starts[edge + 1];
        scan->starts[edge] = (int32_t)scan->count;
        if (may_cross(job, scan, edge, to - from))
            room = sweep_edge(job, edge, sorted + from, to - from, most, scan);
        from = to;
    }
    scan->starts[QNI_SCAN_EDGES] = (int32_t)scan->count;
    qni_free(job->solid->base.context, sorted, job->count, sizeof *sorted);
    return room ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static void start(scan_job *job, const qni_meshed *solid, const double planes[3][9]) {
    job->solid = solid;
    job->planes = planes;
    job->hits = job->first;
    job->count = 0;
    job->capacity = AT_ONCE;
    job->failed = false;
    for (int k = 0; k < 3; ++k)
        for (int n = 0; n < POINTS; ++n)
            job->tame[k][n] = qni_tame(planes[k][n]);
    memset(job->along_x, 0, sizeof job->along_x);
    memset(job->along_y, 0, sizeof job->along_y);
    memset(job->along_z, 0, sizeof job->along_z);
}

qn_status qni_meshed_scan(const qn_solid *base, const double planes[3][9], int32_t most,
                          qni_block_scan *scan, bool *known_out) {
    const qni_meshed *solid = (const qni_meshed *)base;
    const double low[3] = {planes[0][0], planes[1][0], planes[2][0]},
                 high[3] = {planes[0][8], planes[1][8], planes[2][8]};
    scan->crossings = NULL;
    scan->count = scan->capacity = 0;
    memset(scan->crossed, 0, sizeof scan->crossed);
    *known_out = solid->listed && qni_meshed_holds(solid, low) && qni_meshed_holds(solid, high);
    if (!*known_out)
        return QN_OK;
    scan_job job;
    start(&job, solid, planes);
    for (int32_t n = 0; n < solid->near.count && !job.failed; ++n)
        scan_panel(&job, qni_meshed_near_panel(solid, n), n >= solid->near.surface_count);
    qn_status status = job.failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
    if (status == QN_OK) {
        walk_signs(&job, scan);
        status = find_crossings(&job, most, scan);
    }
    if (job.hits != job.first)
        qni_free(base->context, job.hits, job.capacity, sizeof *job.hits);
    return status == QN_OK ? qni_model_status(solid->model) : status;
}
