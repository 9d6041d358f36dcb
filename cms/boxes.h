// SPDX-License-Identifier: MIT
/* What boxes of finest cells come to when they are made as one: judged once each, and remembered.
 */
#ifndef QNI_CMS_BOXES_H
#define QNI_CMS_BOXES_H

#include "cms/stages.h"

enum { QNI_CELLS_AROUND = 27 };

/* How much better a box comes out than its cells. */
typedef struct qni_box_gain {
    int32_t low[3];
    int32_t gain;
    uint8_t doubled; /* bits of the axes along which the box has two cells */
    bool split;
    bool used; /* this place of the table */
    bool perfect;
} qni_box_gain;

/* By box; open addressing. */
typedef struct qni_box_table {
    qni_box_gain *items;
    int64_t count, capacity;
} qni_box_table;

typedef struct qni_box_judge {
    qni_stages *stages;
    const qni_trouble **troubles; /* of all chunks, by cell */
    int64_t count;
    qni_box_table known;  /* to all threads */
    qni_box_table *fresh; /* of each thread, until they are joined */
} qni_box_judge;

typedef struct qni_cell_verdict {
    int64_t pieces, loops, bad;
    bool tube;
} qni_cell_verdict;

/* What the cells round one come to, each on its own: boxes that hold it share them. */
typedef struct qni_surroundings {
    int32_t low[3]; /* of the lowest one */
    bool known[QNI_CELLS_AROUND];
    qni_cell_verdict verdicts[QNI_CELLS_AROUND];
} qni_surroundings;

/* All troubles of the chunks. False: no memory; end it all the same. */
bool qni_box_judge_start(qni_stages *stages, qni_box_judge *judge);
void qni_box_judge_end(qni_box_judge *judge);

/* Ascending z, y, x. */
int qni_compare_places(const int32_t a[3], const int32_t b[3]);

/* How much better does the box come out than its cells, if by more than `least`? Any thread may
 * ask; what it finds is known to it alone until qni_box_judge_join(). */
qn_status qni_judge_box(const qni_box_judge *judge, qni_surroundings *around,
                        const qni_cell_box *box, int64_t least, int64_t *gain, bool *perfect);
/* What the threads found becomes known to all. False: no memory. */
bool qni_box_judge_join(qni_box_judge *judge);

#endif
