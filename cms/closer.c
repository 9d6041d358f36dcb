// SPDX-License-Identifier: MIT
/* A closer look: finest cells whose creases do not lie where the solid's are have their faces
 * solved again, looking for low steps.
 *
 * Where two creases come together at a small angle, as the walls of a step that runs out, two
 * crossings of like normals lie on both sides of the step, and nothing tells of it. To look for low
 * steps between all such crossings takes ten times as long. But the cell before, where the step was
 * still high, has creases that come in and do not go on, and its triangles are not as the solid is
 * there: so its faces are looked at, and then the next cell has such creases. Less clear are doubts
 * where the step is low already, or the way across it oblique; and where a crease ends, or creases
 * come out of a corner beyond a wall. The clearest are looked into first, all where they are few.
 */
#include "cms/stages.h"
#include "core/context.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

static int compare_places(const void *a, const void *b) {
    const int32_t *p = a, *q = b;
    for (int k = 2; k >= 0; --k)
        if (p[k] != q[k])
            return p[k] < q[k] ? -1 : 1;
    return 0;
}

bool qni_is_close(const qni_stages *stages, const int32_t low[3]) {
    return stages->close_count > 0 && bsearch(low, stages->close, (size_t)stages->close_count,
                                              sizeof *stages->close, compare_places);
}

void qni_close_free(qni_stages *stages) {
    qni_free(stages->context, stages->close, stages->close_capacity, sizeof *stages->close);
    stages->close = NULL;
    stages->close_count = stages->close_capacity = 0;
}

/* Those of one kind that are not known yet go to the end of the list; how many it has then. */
static int64_t add_doubted(qni_stages *stages, qni_doubt doubt, int64_t count) {
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t m = 0; m < stages->chunks[n].doubt_count; ++m) {
            const qni_doubted *cell = &stages->chunks[n].doubts[m];
            if (cell->doubt == doubt && !qni_is_close(stages, cell->low))
                memcpy(stages->close[count++], cell->low, sizeof *stages->close);
        }
    return count;
}

/* Steps that run out are few. Where there seem to be many the model's own facets are as small as
 * the cells, and half of the surface would be made again for them. */
static bool are_few(const qni_stages *stages, int64_t count) {
    enum { FEW = 8, LEAVES_FOR_EACH = 1000 };
    return count <= FEW || count <= stages->octree->leaf_count / LEAVES_FOR_EACH;
}

qn_status qni_stages_look_closer(qni_stages *stages, int64_t *added) {
    const int64_t before = stages->close_count;
    int64_t wanted = before;
    *added = 0;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        wanted += stages->chunks[n].doubt_count;
    if (!qni_stages_grow(stages, (void **)&stages->close, &stages->close_capacity, wanted,
                         sizeof *stages->close))
        return qni_fail_memory(stages->error, "a surface");
    int64_t all = before;
    for (int doubt = QNI_CLEAR_DOUBT; doubt > QNI_NO_DOUBT; --doubt) {
        all = add_doubted(stages, (qni_doubt)doubt, all);
        *added = are_few(stages, all - before) ? all - before : *added;
    }
    stages->skipped_steps = all - before - *added;
    if (*added == 0)
        return QN_OK;
    qni_stages_mark_none(stages);
    for (int64_t n = before; n < before + *added; ++n)
        qni_stages_mark_cell(stages, stages->close[n]);
    qni_stages_mark_made(stages);
    stages->close_count = before + *added;
    qsort(stages->close, (size_t)stages->close_count, sizeof *stages->close, compare_places);
    return QN_OK;
}
