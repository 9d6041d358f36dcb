// SPDX-License-Identifier: MIT
/* Several loops in one finest cell: their pieces must not meet. Each way is tried on exact
 * predicates until one is clean. */
#include "cms/cms.h"
#include "mesh/triangle_pair.h"

#include <string.h>

enum { NEST_ATTEMPTS = 6 };

static bool boxes_apart(const float *const a[3], const float *const b[3]) {
    for (int k = 0; k < 3; ++k) {
        float a_low = a[0][k], a_high = a[0][k], b_low = b[0][k], b_high = b[0][k];
        for (int n = 1; n < 3; ++n) {
            a_low = a[n][k] < a_low ? a[n][k] : a_low;
            a_high = a[n][k] > a_high ? a[n][k] : a_high;
            b_low = b[n][k] < b_low ? b[n][k] : b_low;
            b_high = b[n][k] > b_high ? b[n][k] : b_high;
        }
        if (a_high < b_low || b_high < a_low)
            return true;
    }
    return false;
}

/* Do two triangles of the patch meet beyond the vertices they share? */
static bool triangles_meet(const qni_patch *patch, const int32_t a[3], const int32_t b[3]) {
    const float *a_place[3], *b_place[3];
    float places[18];
    uint32_t a_index[3] = {0, 1, 2}, b_index[3];
    for (int n = 0; n < 3; ++n) {
        a_place[n] = qni_patch_place(patch, a[n]);
        b_place[n] = qni_patch_place(patch, b[n]);
        memcpy(places + 3 * n, a_place[n], 3 * sizeof(float));
        memcpy(places + 9 + 3 * n, b_place[n], 3 * sizeof(float));
    }
    if (boxes_apart(a_place, b_place))
        return false;
    for (int n = 0; n < 3; ++n) {
        b_index[n] = (uint32_t)(3 + n);
        for (int m = 0; m < 3; ++m)
            if (a[m] == b[n])
                b_index[n] = (uint32_t)m;
    }
    return qni_triangles_meet(places, a_index, b_index);
}

/* Triangles of different loops only: those of one loop are clean by construction. */
bool qni_patch_loops_meet(const qni_patch *patch) {
    for (int64_t i = 0; i < patch->loop_count; ++i)
        for (int64_t j = i + 1; j < patch->loop_count; ++j) {
            const qni_loop *a = &patch->loops[i], *b = &patch->loops[j];
            for (int32_t s = 0; s < a->triangle_count; ++s)
                for (int32_t t = 0; t < b->triangle_count; ++t)
                    if (triangles_meet(patch, patch->triangles[a->triangle_first + s],
                                       patch->triangles[b->triangle_first + t]))
                        return true;
        }
    return false;
}

static void apex_to_mean(const qni_patch *patch, qni_loop *loop) {
    double mean[3] = {0, 0, 0};
    for (int32_t n = 0; n < loop->count; ++n)
        for (int k = 0; k < 3; ++k)
            mean[k] += (double)patch->vertices[loop->first + n].place[k] / loop->count;
    for (int k = 0; k < 3; ++k)
        loop->apex[k] = qni_between(mean[k], patch->clear_low[k], patch->clear_high[k]);
}

void qni_patch_rebuild_simply(qni_patch *patch, qni_loop *loop, bool fan) {
    apex_to_mean(patch, loop);
    if (fan || !qni_patch_flat(patch, loop, true))
        qni_patch_fan(patch, loop);
}

/* Own vertices only where that works, or fans from the loops' means. */
static void rebuild_simply(qni_patch *patch, bool fans) {
    patch->triangle_count = 0;
    for (int64_t n = 0; n < patch->loop_count; ++n)
        qni_patch_rebuild_simply(patch, &patch->loops[n], fans);
}

/* Inner points are rounded, so that even the last way is tested whole: pairs of one loop too. */
bool qni_patch_meets_itself(const qni_patch *patch) {
    for (int64_t s = 0; s < patch->triangle_count; ++s)
        for (int64_t t = s + 1; t < patch->triangle_count; ++t)
            if (triangles_meet(patch, patch->triangles[s], patch->triangles[t]))
                return true;
    return false;
}

qn_status qni_patch_separate(qni_patch *patch, qni_cms_tally *tally) {
    if (patch->loop_count < 2 || patch->split)
        return QN_OK;
    ++tally->multiple_cells;
    int tube[2];
    double middle[3];
    if (qni_patch_find_tube(patch, tube, middle)) {
        if (qni_patch_make_tube(patch, tube, middle, tally))
            return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
        rebuild_simply(patch, false);
    }
    if (!qni_patch_loops_meet(patch))
        return QN_OK;
    tally->moved_loops += patch->loop_count;
    for (int attempt = 0; attempt < 2 && !patch->failed; ++attempt) {
        rebuild_simply(patch, attempt == 1);
        if (!qni_patch_loops_meet(patch))
            return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
    }
    for (int attempt = 0; attempt < NEST_ATTEMPTS && !patch->failed; ++attempt)
        if (qni_patch_nest(patch, NULL, attempt) && !qni_patch_meets_itself(patch)) {
            ++tally->nested_cells;
            return QN_OK;
        }
    patch->inner_count = 0;
    rebuild_simply(patch, true);
    ++tally->unresolved_cells;
    return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}
