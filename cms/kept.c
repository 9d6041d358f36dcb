// SPDX-License-Identifier: MIT
/* What a cell made before it hands over again, where nothing about it has changed. */
#include "cms/stages.h"
#include "core/context.h"

#include <string.h>

void qni_chunk_free_notes(qn_context *context, qni_chunk *chunk) {
    qni_free(context, chunk->made, chunk->made_capacity, sizeof *chunk->made);
    qni_free(context, chunk->vetoes, chunk->veto_capacity, sizeof *chunk->vetoes);
    qni_free(context, chunk->troubles, chunk->trouble_capacity, sizeof *chunk->troubles);
    qni_free(context, chunk->doubts, chunk->doubt_capacity, sizeof *chunk->doubts);
    chunk->made = NULL;
    chunk->vetoes = NULL;
    chunk->troubles = NULL;
    chunk->doubts = NULL;
    chunk->made_capacity = chunk->veto_capacity = chunk->trouble_capacity = chunk->doubt_capacity =
        0;
}

void qni_chunk_free_made(qn_context *context, qni_chunk *chunk) {
    qni_chunk_free_notes(context, chunk);
    qni_free(context, chunk->triangles, chunk->triangle_capacity, sizeof *chunk->triangles);
    qni_free(context, chunk->owners, chunk->owner_capacity, sizeof *chunk->owners);
    qni_free(context, chunk->apexes, chunk->apex_capacity, sizeof *chunk->apexes);
    qni_free(context, chunk->creases, chunk->crease_capacity, sizeof *chunk->creases);
    chunk->triangles = NULL;
    chunk->owners = NULL;
    chunk->apexes = NULL;
    chunk->creases = NULL;
    chunk->triangle_capacity = chunk->owner_capacity = chunk->apex_capacity =
        chunk->crease_capacity = 0;
}

void qni_chunk_trim_made(qni_stages *stages, qni_chunk *chunk) {
    qni_stages_trim(stages, (void **)&chunk->triangles, &chunk->triangle_capacity,
                    chunk->triangle_count, sizeof *chunk->triangles);
    qni_stages_trim(stages, (void **)&chunk->owners, &chunk->owner_capacity, chunk->triangle_count,
                    sizeof *chunk->owners);
    qni_stages_trim(stages, (void **)&chunk->apexes, &chunk->apex_capacity, chunk->apex_count,
                    sizeof *chunk->apexes);
    qni_stages_trim(stages, (void **)&chunk->creases, &chunk->crease_capacity, chunk->crease_count,
                    sizeof *chunk->creases);
    qni_stages_trim(stages, (void **)&chunk->troubles, &chunk->trouble_capacity,
                    chunk->trouble_count, sizeof *chunk->troubles);
    qni_stages_trim(stages, (void **)&chunk->made, &chunk->made_capacity,
                    chunk->leaf_end - chunk->leaf_first, sizeof *chunk->made);
}

/* The chunk starts with nothing made. */
void qni_kept_start(qni_chunk *chunk, qni_kept_walk *walk) {
    const qni_cms_tally none = {0};
    memset(walk, 0, sizeof *walk);
    walk->before = *chunk;
    chunk->made = NULL;
    chunk->triangles = NULL;
    chunk->owners = NULL;
    chunk->apexes = NULL;
    chunk->creases = NULL;
    chunk->vetoes = NULL;
    chunk->troubles = NULL;
    chunk->doubts = NULL;
    chunk->made_capacity = chunk->triangle_capacity = chunk->owner_capacity = chunk->apex_capacity =
        chunk->crease_capacity = chunk->veto_capacity = chunk->trouble_capacity =
            chunk->doubt_capacity = 0;
    chunk->triangle_count = chunk->apex_count = chunk->crease_count = chunk->veto_count =
        chunk->trouble_count = chunk->doubt_count = 0;
    chunk->tally = none;
}

void qni_kept_end(const qni_stages *stages, qni_kept_walk *walk) {
    qni_chunk_free_made(stages->context, &walk->before);
}

static int notes_of(const qni_leaf_made *made, int note) {
    return (made->notes & note) != 0;
}

static void pass_by(qni_kept_walk *walk) {
    const qni_leaf_made *made = &walk->before.made[walk->leaf++];
    walk->triangle += made->triangles;
    walk->apex += made->apexes;
    walk->crease += made->creases;
    walk->veto += notes_of(made, QNI_NOTED_VETO);
    walk->trouble += notes_of(made, QNI_NOTED_TROUBLE);
    walk->doubt += notes_of(made, QNI_NOTED_DOUBT);
    walk->lost = walk->lost || made->apexes == QNI_MOST_MADE || made->creases == QNI_MOST_MADE;
}

bool qni_kept_skip_to(qni_kept_walk *walk, int64_t leaf) {
    while (walk->leaf < leaf)
        pass_by(walk);
    const qni_leaf_made *made = &walk->before.made[leaf];
    return !walk->lost && made->apexes != QNI_MOST_MADE && made->creases != QNI_MOST_MADE;
}

static bool make_room(qni_stages *stages, qni_chunk *chunk, const qni_leaf_made *made) {
    return qni_stages_grow(stages, (void **)&chunk->apexes, &chunk->apex_capacity,
                           chunk->apex_count + made->apexes, sizeof *chunk->apexes) &&
           qni_stages_grow(stages, (void **)&chunk->triangles, &chunk->triangle_capacity,
                           chunk->triangle_count + made->triangles, sizeof *chunk->triangles) &&
           qni_stages_grow(stages, (void **)&chunk->owners, &chunk->owner_capacity,
                           chunk->triangle_count + made->triangles, sizeof *chunk->owners) &&
           qni_stages_grow(stages, (void **)&chunk->creases, &chunk->crease_capacity,
                           chunk->crease_count + made->creases, sizeof *chunk->creases) &&
           qni_stages_grow(stages, (void **)&chunk->vetoes, &chunk->veto_capacity,
                           chunk->veto_count + notes_of(made, QNI_NOTED_VETO),
                           sizeof *chunk->vetoes) &&
           qni_stages_grow(stages, (void **)&chunk->troubles, &chunk->trouble_capacity,
                           chunk->trouble_count + notes_of(made, QNI_NOTED_TROUBLE),
                           sizeof *chunk->troubles) &&
           qni_stages_grow(stages, (void **)&chunk->doubts, &chunk->doubt_capacity,
                           chunk->doubt_count + notes_of(made, QNI_NOTED_DOUBT),
                           sizeof *chunk->doubts);
}

/* Apexes are called by their place in the chunk. */
static uint32_t moved(uint32_t ref, int64_t by) {
    return QNI_REF_KIND(ref) == QNI_REF_APEX ? (uint32_t)(ref + by) : ref;
}

static void hand_over_shape(const qni_kept_walk *walk, const qni_leaf_made *made,
                            qni_chunk *chunk) {
    const int64_t by = chunk->apex_count - walk->apex;
    for (uint32_t t = 0; t < made->triangles; ++t) {
        for (int k = 0; k < 3; ++k)
            chunk->triangles[chunk->triangle_count][k] =
                moved(walk->before.triangles[walk->triangle + t][k], by);
        chunk->owners[chunk->triangle_count++] = walk->before.owners[walk->triangle + t];
    }
    for (uint32_t c = 0; c < made->creases; ++c, ++chunk->crease_count)
        for (int k = 0; k < 2; ++k)
            chunk->creases[chunk->crease_count][k] =
                moved(walk->before.creases[walk->crease + c][k], by);
    for (uint32_t a = 0; a < made->apexes; ++a)
        memcpy(chunk->apexes[chunk->apex_count++], walk->before.apexes[walk->apex + a],
               sizeof *chunk->apexes);
}

bool qni_kept_hand_over(qni_stages *stages, qni_kept_walk *walk, qni_chunk *chunk) {
    const qni_leaf_made *made = &walk->before.made[walk->leaf];
    int64_t *tally = (int64_t *)&chunk->tally;
    if (!make_room(stages, chunk, made))
        return false;
    hand_over_shape(walk, made, chunk);
    if (made->notes & QNI_NOTED_VETO)
        chunk->vetoes[chunk->veto_count++] = walk->before.vetoes[walk->veto];
    if (made->notes & QNI_NOTED_TROUBLE)
        chunk->troubles[chunk->trouble_count++] = walk->before.troubles[walk->trouble];
    if (made->notes & QNI_NOTED_DOUBT)
        chunk->doubts[chunk->doubt_count++] = walk->before.doubts[walk->doubt];
    for (int n = 0; n < QNI_TALLIES; ++n)
        tally[n] += qni_tally_of(made, n);
    pass_by(walk);
    return true;
}
