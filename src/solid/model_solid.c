// SPDX-License-Identifier: MIT
/* A polygon model as a solid: distance to the nearest panel, with the sign that the winding number
 * or the parity gives; over holes the distance to first order to where that sign changes. */
#include "solid/model.h"

#include <string.h>

static void destroy(qn_solid *solid) {
    qni_meshed *meshed = (qni_meshed *)solid;
    qni_near_free(solid->context, &meshed->near);
    if (meshed->larger)
        qn_solid_destroy(&meshed->larger->base);
    qni_model_release(meshed->model);
    qni_solid_free(solid, sizeof *meshed);
}

static bool usable(const double p[3]) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static double length_of(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Sign, distance, and the direction in which the value grows. */
typedef struct answer {
    bool inside;
    double distance;
    double nearest[3];
    int32_t panel;
    bool over_hole; /* the cap's angle says more than the nearest panel */
    double slope[3];
} answer;

/* How far a point lies within the box of a local solid, less what rounding may hide. */
static double depth_within(const qni_meshed *solid, const double p[3]) {
    double least = QNI_INFINITY;
    for (int k = 0; k < 3; ++k)
        least = qni_lesser(least,
                           qni_lesser(p[k] - solid->within.low[k], solid->within.high[k] - p[k]));
    return least - 1e-9 * solid->model->size;
}

/* The nearest panel: that of the list, when none beyond the box can be nearer. */
static int32_t nearest_panel(const qni_meshed *solid, const double p[3], int32_t guess,
                             double *square, double nearest[3]) {
    const qni_panel_tree *surface = &solid->model->surface;
    for (; solid; solid = solid->larger) {
        if (!solid->listed || !solid->near.surface_count || !qni_meshed_holds(solid, p))
            continue;
        guess =
            qni_near_nearest(&solid->near, surface, solid->model->size, p, guess, square, nearest);
        if (sqrt(*square) < depth_within(solid, p))
            return guess;
    }
    return qni_panel_tree_nearest(surface, p, guess, square, nearest);
}

/* No sign is asked for, and only what is as near as that. */
static bool meshed_distance(const qn_solid *solid, const double p[3], double most,
                            double *distance_out) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    double square, nearest[3];
    if (!usable(p) || qni_meshed_is_smooth(meshed, p))
        return false;
    for (; meshed; meshed = meshed->larger)
        if (meshed->listed && qni_meshed_holds(meshed, p) && depth_within(meshed, p) > most) {
            *distance_out = sqrt(qni_near_square(&meshed->near, &meshed->model->surface,
                                                 meshed->model->size, p, most));
            return true;
        }
    const qni_panel_tree *surface = &((const qni_meshed *)solid)->model->surface;
    meshed = (const qni_meshed *)solid;
    nearest_panel(meshed, p, __atomic_load_n(&meshed->guess, __ATOMIC_RELAXED), &square, nearest);
    *distance_out = surface->count ? sqrt(square) : QNI_INFINITY;
    return true;
}

static void ask(const qni_meshed *solid, const double p[3], answer *out) {
    const qni_model *model = solid->model;
    int64_t winding = qni_meshed_winding(solid, p);
    double square;
    int32_t *guess = (int32_t *)&solid->guess; /* a memory that changes no answer */
    out->panel =
        nearest_panel(solid, p, __atomic_load_n(guess, __ATOMIC_RELAXED), &square, out->nearest);
    __atomic_store_n(guess, out->panel, __ATOMIC_RELAXED);
    out->distance = sqrt(square);
    out->over_hole = false;
    out->inside = qni_whole_is_inside(model, winding);
    if (!qni_meshed_is_smooth(solid, p))
        return;
    memset(out->slope, 0, sizeof out->slope);
    double excess = qni_model_excess(solid->model, winding, p, out->slope);
    out->inside = excess >= 0;
    double steep = length_of(out->slope), first_order = fabs(excess) / steep;
    if (steep > 0 && first_order < out->distance) {
        out->over_hole = true;
        out->distance = first_order;
    }
}

static double signed_value(const answer *a) {
    double size = a->distance > 0 ? a->distance : QNI_TIE;
    return a->inside ? -size : size;
}

static qn_status meshed_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                               double *values) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    for (int64_t n = 0; n < count; ++n) {
        answer here;
        values[n] = QNI_INFINITY;
        if (!usable(points[n]))
            continue;
        ask(meshed, points[n], &here);
        values[n] = signed_value(&here);
    }
    return qni_model_status(meshed->model);
}

static qn_status meshed_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                               bool *inside) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    for (int64_t n = 0; n < count; ++n) {
        inside[n] = false;
        if (!usable(points[n]))
            continue;
        int64_t winding = qni_meshed_winding(meshed, points[n]);
        inside[n] = qni_whole_is_inside(meshed->model, winding);
        if (qni_meshed_is_smooth(meshed, points[n]))
            inside[n] = qni_model_excess(meshed->model, winding, points[n], NULL) >= 0;
    }
    return qni_model_status(meshed->model);
}

/* On a panel: across it, to the side that is outside. */
static void across(const qni_meshed *solid, const double p[3], const answer *here,
                   double gradient[3]) {
    double normal[3], step = 1e-9 * (solid->model->size + 1e-30), beside[1][3], value;
    qni_panel_normal(&solid->model->surface.panels[here->panel], normal);
    for (int k = 0; k < 3; ++k)
        beside[0][k] = p[k] + step * normal[k];
    meshed_values(&solid->base, 1, (const double(*)[3])beside, &value);
    for (int k = 0; k < 3; ++k)
        gradient[k] = value < 0 ? -normal[k] : normal[k];
}

static void gradient_of(const qni_meshed *solid, const double p[3], const answer *here,
                        double gradient[3], int32_t *owner) {
    double away[3], up[3] = {0, 0, 1};
    *owner = here->panel < 0 ? solid->base.owner : solid->model->surface.panels[here->panel].owner;
    if (here->over_hole) {
        qni_unit(here->slope, up, gradient);
        return;
    }
    for (int k = 0; k < 3; ++k)
        away[k] = here->inside ? here->nearest[k] - p[k] : p[k] - here->nearest[k];
    if (here->panel >= 0 && length_of(away) <= 1e-12 * solid->model->size)
        across(solid, p, here, gradient);
    else
        qni_unit(away, up, gradient);
}

static qn_status meshed_first_order(const qn_solid *solid, const double p[3], double *value,
                                    double gradient[3], int32_t *owner) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    answer here;
    *value = QNI_INFINITY;
    *owner = solid->owner;
    gradient[0] = gradient[1] = gradient[2] = 0;
    if (!usable(p))
        return QN_OK;
    ask(meshed, p, &here);
    *value = signed_value(&here);
    gradient_of(meshed, p, &here, gradient, owner);
    return qni_model_status(meshed->model);
}

static qn_status meshed_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double (*gradients)[3], int32_t *owners) {
    for (int64_t n = 0; n < count; ++n) {
        double value, gradient[3];
        int32_t owner;
        meshed_first_order(solid, points[n], &value, gradient, &owner);
        if (gradients)
            memcpy(gradients[n], gradient, sizeof gradient);
        if (owners)
            owners[n] = owner;
    }
    return qni_model_status(((const qni_meshed *)solid)->model);
}

static double half_diagonal(const qni_box *box, double centre[3]) {
    double squares = 0;
    for (int k = 0; k < 3; ++k) {
        centre[k] = 0.5 * (box->low[k] + box->high[k]);
        double half = qni_greater(box->high[k] - centre[k], centre[k] - box->low[k]);
        squares += half * half;
    }
    return sqrt(squares);
}

/* Whether the caps' angle can reach 1/2 within `reach` of a point. */
static bool caps_matter(const qni_meshed *solid, const double centre[3], double reach) {
    const qni_panel_tree *caps = &solid->model->caps;
    if (caps->count == 0 || (qni_meshed_holds(solid, centre) && !solid->smooth))
        return false;
    if (qni_panel_tree_is_near(caps, centre, reach))
        return true;
    double most = fabs(qni_cap_field_angle(&solid->model->field, centre, NULL)) +
                  reach * qni_panel_tree_slope_bound(caps, centre, reach);
    return !(most < 0.5 - QNI_ANGLE_SLACK);
}

/* Whether the sign can change within `reach` of a point though no panel of the surface is so near:
 * the winding number is smooth there, whatever the caps do. */
static bool may_tear(const qni_meshed *solid, const double centre[3], double reach) {
    const qni_panel_tree *caps = &solid->model->caps;
    if (caps->count == 0 || (qni_meshed_holds(solid, centre) && !solid->smooth))
        return false;
    double excess = qni_model_excess(solid->model, qni_meshed_winding(solid, centre), centre, NULL);
    double change = reach * qni_panel_tree_slope_bound(caps, centre, reach);
    return !(fabs(excess) > change + QNI_ANGLE_SLACK);
}

static qn_status meshed_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    double centre[3], half = half_diagonal(box, centre);
    if (!usable(centre) || !isfinite(half)) {
        range[0] = -QNI_INFINITY;
        range[1] = QNI_INFINITY;
        return QN_OK;
    }
    answer here;
    ask(meshed, centre, &here);
    const double away[3] = {centre[0] - here.nearest[0], centre[1] - here.nearest[1],
                            centre[2] - here.nearest[2]};
    double distance = length_of(away), size = length_of(centre) + meshed->model->size;
    double reach = half + 64 * QNI_EPSILON * (distance + half + size) + QNI_TIE;
    bool torn = distance <= reach || may_tear(meshed, centre, reach);
    range[0] = torn || here.inside ? -distance - reach : distance - reach;
    range[1] = torn || !here.inside ? distance + reach : reach - distance;
    if (here.over_hole || meshed->model->caps.count) { /* over holes values are nearer to 0 */
        range[0] = range[0] > 0 ? QNI_TIE : range[0];
        range[1] = range[1] < 0 ? -QNI_TIE : range[1];
    }
    return qni_model_status(meshed->model);
}

/* Can a panel whose box meets a box do so? Its plane must, too. */
static bool plane_meets(const qni_panel *panel, const qni_box *box) {
    double normal[3], height = 0, reach = 0, size = 0;
    qni_panel_normal(panel, normal);
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * (box->low[k] + box->high[k]), at = (double)panel->at[0][k];
        height += normal[k] * (middle - at);
        reach += fabs(normal[k]) * 0.5 * (box->high[k] - box->low[k]);
        size += fabs(middle) + fabs(at);
        for (int i = 1; i < 3; ++i)
            size += fabs((double)panel->at[i][k]);
    }
    return fabs(height) <= reach + 1e-9 * size; /* the plane of a sliver is not known any better */
}

typedef struct plane_job {
    const qni_panel_tree *tree;
    const qni_box *box;
} plane_job;

static bool misses(void *user, int32_t panel) {
    const plane_job *job = user;
    return !plane_meets(&job->tree->panels[panel], job->box);
}

/* Far from holes the sign changes at panels only. */
static bool meshed_changes(const qn_solid *solid, const qni_box *box, bool *may_out) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    if (!meshed->listed && meshed->model->caps.count == 0) {
        plane_job job = {&meshed->model->surface, box};
        *may_out = !qni_panel_tree_visit(job.tree, box, misses, &job);
        return true;
    }
    if (!meshed->listed || meshed->smooth || !qni_meshed_holds(meshed, box->low) ||
        !qni_meshed_holds(meshed, box->high))
        return false;
    int32_t chosen[QNI_MOST_NEAR];
    const int32_t count = qni_near_meeting(&meshed->near, box, chosen);
    *may_out = false;
    for (int32_t n = 0; n < count && !*may_out; ++n)
        *may_out = plane_meets(qni_meshed_near_panel(meshed, chosen[n]), box);
    return true;
}

static qn_solid *new_node(qni_model *model);

/* The panels that meet the box, when they are few. */
static bool list_panels(const qni_meshed *from, const qni_box *box, qni_meshed *into) {
    qn_context *context = from->base.context;
    into->listed = true;
    if (from->listed && qni_meshed_holds(from, box->low) && qni_meshed_holds(from, box->high)) {
        into->larger = (qni_meshed *)qni_solid_retain(&from->base);
        return qni_near_from_larger(context, &from->model->surface, &from->model->caps, &from->near,
                                    box, &into->near);
    }
    return qni_near_from_trees(context, &from->model->surface, &from->model->caps, box, &into->near,
                               &into->listed);
}

static qn_status meshed_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const qni_meshed *meshed = (const qni_meshed *)solid;
    double centre[3], half = half_diagonal(box, centre);
    *solid_out = NULL;
    if (!usable(centre) || !isfinite(half))
        return qni_restrict_to_itself(solid, box, solid_out);
    __atomic_add_fetch(&meshed->model->references, 1, __ATOMIC_RELAXED);
    qni_meshed *local = (qni_meshed *)new_node(meshed->model);
    if (!local)
        return QN_ERROR_OUT_OF_MEMORY;
    local->base.owner = solid->owner;
    local->guess = __atomic_load_n(&meshed->guess, __ATOMIC_RELAXED);
    local->within = *box;
    local->smooth = caps_matter(meshed, centre, half * (1 + 1e-12) + QNI_TIE);
    bool good = list_panels(meshed, box, local);
    local->local = true;
    for (int k = 0; k < 3; ++k)
        local->known_at[k] = qni_tame(box->low[k]);
    if (good && local->listed)
        local->known_winding = qni_meshed_winding(meshed, box->low);
    if (!good || qni_model_status(meshed->model) != QN_OK) {
        qn_solid_destroy(&local->base);
        return QN_ERROR_OUT_OF_MEMORY;
    }
    if (!local->listed && meshed->model->caps.count == 0) { /* it would know nothing more */
        qn_solid_destroy(&local->base);
        return qni_restrict_to_itself(solid, box, solid_out);
    }
    *solid_out = &local->base;
    return QN_OK;
}

static const qni_solid_ops meshed_ops = {
    .destroy = destroy,
    .values = meshed_values,
    .gradients = meshed_gradients,
    .bounds = meshed_bounds,
    .crossings = qni_meshed_crossings,
    .restrict_to = meshed_restrict,
    .inside = meshed_inside,
    .first_order = meshed_first_order,
    .distance = meshed_distance,
    .changes = meshed_changes,
    .scan = qni_meshed_scan,
};

static qn_solid *new_node(qni_model *model) {
    qni_meshed *solid = (qni_meshed *)qni_solid_new(model->context, sizeof *solid, &meshed_ops);
    if (!solid) {
        qni_model_release(model);
        return NULL;
    }
    solid->model = model;
    solid->base.box = model->box;
    solid->base.ends_in_box = solid->base.direct = model->caps.count == 0;
    solid->base.listed = true;
    return &solid->base;
}

bool qni_is_meshed(const qn_solid *solid) {
    return solid && solid->ops == &meshed_ops;
}

qn_solid *qni_meshed_create(qni_model *model) {
    return new_node(model);
}
