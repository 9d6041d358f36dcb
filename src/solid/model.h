// SPDX-License-Identifier: MIT
/* A polygon model ready to be asked, and the solid that asks it.
 *
 * With caps over its rims every model is a closed chain, whose winding number is a whole number and
 * changes only where a segment crosses a panel: both are exact. What the caps add is taken off
 * again as the solid angle they are seen under: the difference is the generalized winding number
 * (Jacobson, Kavan, Sorkine-Hornung, 2013), smooth but at the model's own panels. Far from holes
 * that angle cannot matter, and is not asked for. */
#ifndef QNI_SOLID_MODEL_H
#define QNI_SOLID_MODEL_H

#include "solid/cap_field.h"
#include "solid/chain.h"
#include "solid/model_near.h"

typedef struct qni_model {
    qn_context *context;
    int64_t references;     /* changed with atomic operations */
    qni_panel_tree surface; /* with parity, caps are surface too */
    qni_panel_tree caps;    /* what is taken off the winding number */
    qni_cap_field field;    /* the angle of the caps */
    bool parity;            /* inside is odd; else: not 0, or with caps 1/2 and above */
    qni_box box;
    double size;            /* largest coordinate */
    int64_t hole_crossings; /* found where no panel is; changed with atomic operations */
} qni_model;

typedef struct qni_meshed {
    qn_solid base;
    qni_model *model;
    bool local; /* what follows holds within the box */
    qni_box within;
    bool smooth; /* caps can matter */
    bool listed; /* `near` has all panels that meet the box */
    qni_near_list near;
    struct qni_meshed *larger; /* of a larger box, whose list serves beyond this one; NULL: none */
    /* Memories that change no answer: a place in the box whose whole winding number is known, held
     * by one thread at a time, and the panel that was nearest last (atomic operations). */
    double known_at[3];
    int64_t known_winding;
    int32_t busy, guess;
} qni_meshed;

/* The panel at a place of the list. */
static inline const qni_panel *qni_meshed_near_panel(const qni_meshed *solid, int32_t place) {
    const int32_t number = solid->near.numbers[place];
    return number < 0 ? &solid->model->caps.panels[~number] : &solid->model->surface.panels[number];
}

/* One panel on a segment. */
typedef struct qni_hit {
    double at;
    const qni_panel *panel;
    int32_t change; /* of the whole winding number, towards b */
    bool cap;
} qni_hit;

typedef struct qni_hits {
    qn_context *context;
    qni_hit first[32], *items;
    int64_t count, capacity;
} qni_hits;

void qni_model_release(qni_model *model);
qn_solid *qni_meshed_create(qni_model *model); /* takes the reference */
bool qni_is_meshed(const qn_solid *solid);

/* ---- model_winding.c */
/* The whole winding number of model and caps: by a ray, or by a walk from a known place near. */
int64_t qni_model_winding(const qni_model *model, const double p[3]);
int64_t qni_meshed_winding(const qni_meshed *solid, const double p[3]);
/* All panels on the segment, by place; false: no memory. */
bool qni_meshed_hits(const qni_meshed *solid, const double a[3], const double b[3], qni_hits *hits);
void qni_hits_sort(qni_hits *hits);
void qni_hits_free(qni_hits *hits);
bool qni_meshed_holds(const qni_meshed *solid, const double p[3]);
/* The smallest solid of this one and the larger ones whose list knows all between two points; NULL
 * when there is none. */
const qni_meshed *qni_meshed_lister(const qni_meshed *solid, const double a[3], const double b[3]);
/* Whether caps matter at p; the angle is then asked for. */
bool qni_meshed_is_smooth(const qni_meshed *solid, const double p[3]);
/* The generalized winding number less 1/2, and the gradient of what was taken off. */
static inline double qni_model_excess(qni_model *model, int64_t winding, const double p[3],
                                      double gradient[3]) {
    return (double)winding - qni_cap_field_angle(&model->field, p, gradient) - 0.5;
}
/* Out of memory when cells of the field could not be made. */
static inline qn_status qni_model_status(const qni_model *model) {
    return qni_cap_field_failed(&model->field) ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}
/* How wrong the angle of the caps may be: bounds keep that far off. */
#define QNI_ANGLE_SLACK 0.02

static inline bool qni_whole_is_inside(const qni_model *model, int64_t winding) {
    return model->parity ? winding & 1 : model->caps.count ? winding > 0 : winding != 0;
}

/* ---- model_crossings.c */
qn_status qni_meshed_crossings(const qn_solid *solid, const double a[3], const double b[3],
                               int32_t capacity, qni_crossing *crossings, int32_t *count_out);
/* The same from the hits on a segment, sorted, the winding number at a, and the signs at both ends;
 * `smooth`: caps can matter. */
int32_t qni_meshed_sweep(const qni_meshed *solid, const double a[3], const double b[3],
                         const qni_hits *hits, int64_t winding, const bool ends[2], bool smooth,
                         int32_t capacity, qni_crossing *crossings);

/* ---- model_scan.c */
qn_status qni_meshed_scan(const qn_solid *solid, const double planes[3][9], int32_t most,
                          qni_block_scan *scan, bool *known_out);

#endif
