// SPDX-License-Identifier: MIT
/* What was found on a face is not looked for twice: of an ambiguous face the same pairs are traced
 * to choose between pairings and again to make segments, and a chain that grows has most bends it
 * had before. */
#include "cms/face_job.h"

#include <string.h>

void qni_trace_memo_start(qni_trace_memo *memo) {
    memo->pair_count = memo->bend_count = 0;
}

bool qni_face_trace(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace) {
    qni_trace_memo *memo = job->memo;
    const int known = memo->pair_count < QNI_MEMO_PAIRS ? memo->pair_count : QNI_MEMO_PAIRS;
    for (int n = 0; n < known; ++n)
        if (memo->pairs[n].enter == enter && memo->pairs[n].leave == leave) {
            *trace = memo->pairs[n].trace;
            return memo->pairs[n].found;
        }
    const bool found = qni_trace_pair(job, enter, leave, trace);
    qni_memo_pair *pair = &memo->pairs[memo->pair_count++ % QNI_MEMO_PAIRS];
    pair->enter = enter;
    pair->leave = leave;
    pair->trace = *trace;
    pair->found = found;
    return found;
}

static bool same_line(const qni_face_line *a, const qni_face_line *b) {
    return memcmp(a->at, b->at, sizeof a->at) == 0 &&
           memcmp(a->normal, b->normal, sizeof a->normal) == 0 &&
           memcmp(a->space_normal, b->space_normal, sizeof a->space_normal) == 0 &&
           a->owner == b->owner;
}

const qni_memo_bend *qni_memo_find_bend(const qni_trace_memo *memo, const qni_face_line *first,
                                        const qni_face_line *second) {
    const int known = memo->bend_count < QNI_MEMO_BENDS ? memo->bend_count : QNI_MEMO_BENDS;
    for (int n = 0; n < known; ++n)
        if (same_line(&memo->bends[n].first, first) && same_line(&memo->bends[n].second, second))
            return &memo->bends[n];
    return NULL;
}

qni_memo_bend *qni_memo_add_bend(qni_trace_memo *memo) {
    return &memo->bends[memo->bend_count++ % QNI_MEMO_BENDS];
}
