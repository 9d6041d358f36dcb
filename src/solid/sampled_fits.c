// SPDX-License-Identifier: MIT
/* Creases in the cells of a sampled solid: what planes make of a cell (sampled_sharp.h), kept with
 * the block that it was found in. */
#include "solid/node.h"
#include "solid/sampled_parts.h"

static const qni_sharp_fit no_crease = {.count = 0};

double qni_read_sample(const void *samples, const int32_t point[3]) {
    const sampled_solid *s = samples;
    const qni_sample_frame *frame = &s->whole->frame;
    int32_t at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = qni_clamped(point[k], 0, frame->count[k] - 1);
    return qni_sample(s, at);
}

double qni_read_plane(const void *samples, int axis, int64_t point) {
    return qni_sample_plane(&((const sampled_solid *)samples)->whole->frame, axis, point);
}

static void make_fit(const sampled_solid *s, const int32_t cell[3], const double corner[8],
                     qni_sharp_fit *fit) {
    const qni_sample_reader reader = {s, qni_read_sample, qni_read_plane};
    fit->crease = false;
    if (!qni_cell_is_plain(corner, s->whole->frame.step))
        qni_fit_cell(&reader, cell, s->whole->frame.step, s->whole->crease_cosine, fit);
}

/* The fit of a cell of a block, kept once it is made; NULL where there is no crease. `room` is used
 * when memory is short. */
static const qni_sharp_fit *kept_fit(const sampled_solid *s, int64_t at, const int32_t cell[3],
                                     const double corner[8], qni_sharp_fit *room) {
    const qni_sharp_fit **slot = &s->block.fits[at];
    const qni_sharp_fit *known = __atomic_load_n(slot, __ATOMIC_ACQUIRE);
    if (!known) {
        make_fit(s, cell, corner, room);
        qni_sharp_fit *kept = NULL;
        if (room->crease) {
            kept = qni_alloc(s->base.context, 1, sizeof *kept);
            if (!kept)
                return room;
            *kept = *room;
        }
        const qni_sharp_fit *fresh = kept ? kept : &no_crease;
        if (__atomic_compare_exchange_n(slot, &known, fresh, false, __ATOMIC_ACQ_REL,
                                        __ATOMIC_ACQUIRE))
            known = fresh;
        else
            qni_free(s->base.context, kept, 1, sizeof *kept);
    }
    return known == &no_crease ? NULL : known;
}

/* What planes make of the cell when a crease runs through it, else NULL. */
const qni_sharp_fit *qni_sampled_fit(const sampled_solid *s, const int32_t cell[3],
                                     const double corner[8], qni_sharp_fit *room) {
    if (!s->whole->creases)
        return NULL;
    const double *first = s->block.fits ? qni_block_find(s, cell) : NULL;
    if (first)
        return kept_fit(s, first - s->block.values, cell, corner, room);
    make_fit(s, cell, corner, room);
    return room->crease ? room : NULL;
}

/* Frees what is kept. */
void qni_sampled_free_fits(sampled_solid *s) {
    const int64_t cells = qni_block_samples(&s->block);
    for (int64_t n = 0; s->block.fits && n < cells; ++n)
        if (s->block.fits[n] != &no_crease)
            qni_free(s->base.context, (void *)(uintptr_t)s->block.fits[n], 1,
                     sizeof **s->block.fits);
    qni_free(s->base.context, s->block.fits, cells, sizeof *s->block.fits);
}
