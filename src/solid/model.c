// SPDX-License-Identifier: MIT
/* From a mesh to a polygon model: which rule says what is inside, caps over what is open, trees,
 * and lines that tell how far the rules agree. */
#include "solid/model.h"

#include <qn/mesh.h>

#include <string.h>

void qni_model_release(qni_model *model) {
    if (!model || __atomic_sub_fetch(&model->references, 1, __ATOMIC_ACQ_REL) != 0)
        return;
    qni_cap_field_free(&model->field);
    qni_panel_tree_free(model->context, &model->surface);
    qni_panel_tree_free(model->context, &model->caps);
    qni_free(model->context, model, 1, sizeof *model);
}

static void find_box(qni_model *model) {
    const qni_panel_tree *trees[2] = {&model->surface, &model->caps};
    model->box = qni_box_nothing();
    for (int t = 0; t < 2; ++t)
        for (int k = 0; k < 3 && trees[t]->count; ++k) {
            const qni_panel_node *root = &trees[t]->nodes[0];
            double low = (double)root->low[k], high = (double)root->high[k];
            model->box.low[k] = t == 0 ? low : qni_lesser(model->box.low[k], low);
            model->box.high[k] = t == 0 ? high : qni_greater(model->box.high[k], high);
            model->size = qni_greater(model->size, qni_greater(fabs(low), fabs(high)));
        }
}

/* Turn what is wrongly turned, and choose. A chain that cancels has a winding number as it is; one
 * that does so after turning, too; one whose edges are all even has a parity. */
static bool choose(qni_chain *chain, qn_mesh_sign asked, bool *parity_out) {
    *parity_out = asked == QN_MESH_SIGN_PARITY;
    if (*parity_out || chain->rim_edges == 0)
        return true;
    if (!qni_chain_orient(chain))
        return false;
    if (chain->rim_edges == 0)
        return true;
    *parity_out = asked == QN_MESH_SIGN_AUTO && chain->odd_edges == 0;
    if (*parity_out)
        return true;
    if (!qni_chain_turn_pieces(chain))
        return false;
    if (chain->volume < 0)
        qni_chain_turn_all(chain);
    return true;
}

static bool add_surface(const qni_chain *chain, qni_panel_tree *tree) {
    if (!qni_panel_tree_reserve(chain->context, tree, chain->count))
        return false;
    for (int64_t n = 0; n < chain->count; ++n) {
        qni_panel panel = qni_chain_panel(chain, n);
        if (!qni_panel_tree_add(chain->context, tree, &panel))
            return false;
    }
    return true;
}

static bool fill(qni_chain *chain, const qn_solid_mesh_options *options, qni_model *model,
                 qn_solid_mesh_report *report) {
    if (!qni_chain_find_edges(chain))
        return false;
    report->rim_edges = chain->rim_edges;
    report->odd_edges = chain->odd_edges;
    bool good = choose(chain, options->sign, &model->parity) &&
                add_surface(chain, &model->surface) &&
                qni_chain_cap(chain, model->parity, model->parity ? &model->surface : &model->caps,
                              &report->holes);
    if (!good)
        return false;
    qni_chain_drop_edges(chain);
    report->turned_triangles = chain->turned;
    report->cap_triangles = model->surface.count - chain->count + model->caps.count;
    report->used = model->parity ? QN_MESH_SIGN_PARITY : QN_MESH_SIGN_WINDING;
    report->closed = report->cap_triangles == 0;
    return qni_panel_tree_build(model->context, &model->surface, false) &&
           qni_panel_tree_build(model->context, &model->caps, true);
}

/* ---- lines on which the rules are compared -----------------------------------------------------
 */

enum { LINES = 32 };

/* Where parity changes at every panel, but the sign in use does not, or changes elsewhere. */
static qn_status compare_line(const qni_meshed *solid, const double a[3], const double b[3],
                              bool *differs_out) {
    qni_hits hits;
    qni_crossing found[QNI_CROSSINGS];
    int32_t count = 0;
    int64_t panels = 0;
    bool good = qni_meshed_hits(solid, a, b, &hits);
    for (int64_t n = 0; n < hits.count; ++n)
        panels += !hits.items[n].cap;
    qni_hits_free(&hits);
    if (!good)
        return QN_ERROR_OUT_OF_MEMORY;
    QN_TRY(qni_meshed_crossings(&solid->base, a, b, QNI_CROSSINGS, found, &count));
    *differs_out = panels <= QNI_CROSSINGS && panels != count;
    return QN_OK;
}

static qn_status compare_lines(const qni_meshed *solid, qn_solid_mesh_report *report) {
    const qni_box *box = &solid->model->box;
    for (int n = 0; n < 3 * LINES * LINES; ++n) {
        int axis = n / (LINES * LINES), u = (axis + 1) % 3, v = (axis + 2) % 3;
        double a[3], b[3], margin = 0.01 * (box->high[axis] - box->low[axis]);
        a[u] = b[u] = box->low[u] + (n % LINES + 0.4375) / LINES * (box->high[u] - box->low[u]);
        a[v] = b[v] =
            box->low[v] + (n / LINES % LINES + 0.4375) / LINES * (box->high[v] - box->low[v]);
        a[axis] = box->low[axis] - margin;
        b[axis] = box->high[axis] + margin;
        bool differs;
        QN_TRY(compare_line(solid, a, b, &differs));
        ++report->lines;
        report->disagreeing_lines += differs;
    }
    return QN_OK;
}

static qn_status make(qn_context *context, qni_chain *chain, const qn_solid_mesh_options *options,
                      qn_solid **solid_out, qn_solid_mesh_report *report, qn_error *error) {
    qni_model *model = qni_alloc_zero(context, 1, sizeof *model);
    if (!model)
        return qni_fail_memory(error, "a polygon model");
    model->context = context;
    model->references = 1;
    if (!fill(chain, options, model, report)) {
        qni_model_release(model);
        return qni_fail_memory(error, "a polygon model");
    }
    find_box(model);
    if (!qni_cap_field_start(context, &model->caps, &model->box, &model->field)) {
        qni_model_release(model);
        return qni_fail_memory(error, "a polygon model");
    }
    qn_solid *solid = qni_meshed_create(model);
    if (!solid)
        return qni_fail_memory(error, "a polygon model");
    solid->owner = options->owner;
    if (compare_lines((const qni_meshed *)solid, report) != QN_OK) {
        qn_solid_destroy(solid);
        return qni_fail_memory(error, "a polygon model");
    }
    model->hole_crossings = 0;
    *solid_out = solid;
    return QN_OK;
}

qn_status qn_solid_from_mesh(qn_context *context, const qn_mesh *mesh,
                             const qn_solid_mesh_options *options, qn_solid **solid_out,
                             qn_solid_mesh_report *report_out, qn_error *error) {
    qn_solid_mesh_options defaults;
    qn_solid_mesh_options_init(&defaults);
    *solid_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_solid_mesh_options_init", error);
    options = options ? options : &defaults;
    if (!mesh)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a polygon model was asked for without a mesh");
    if (options->sign < QN_MESH_SIGN_AUTO || options->sign > QN_MESH_SIGN_WINDING)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "sign %d of a polygon model: take auto, parity or winding",
                        (int)options->sign);
    qn_mesh_view view = qn_mesh_get_view(mesh);
    if (2 * view.quad_count + view.triangle_count > INT32_MAX / 8)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a polygon model of %lld faces is too large: split it",
                        (long long)(view.quad_count + view.triangle_count));
    qn_solid_mesh_report report;
    memset(&report, 0, sizeof report);
    qni_chain chain;
    qn_status status =
        qni_chain_from_mesh(context, &view, options->owner, !options->one_owner, &chain)
            ? QN_OK
            : qni_fail_memory(error, "a polygon model");
    report.triangles = chain.count;
    report.dropped_triangles = chain.dropped;
    report.joined_vertices = chain.joined;
    if (status == QN_OK && chain.count == 0)
        status = qni_fail(error, QN_ERROR_INPUT,
                          "the model has no triangle with three different corners");
    if (status == QN_OK)
        status = make(context, &chain, options, solid_out, &report, error);
    qni_chain_free(&chain);
    qni_return_memory(context);
    if (status == QN_OK && report_out)
        *report_out = report;
    return status;
}

int64_t qn_solid_get_hole_crossings(const qn_solid *solid) {
    return qni_is_meshed(solid)
               ? __atomic_load_n(&((const qni_meshed *)solid)->model->hole_crossings,
                                 __ATOMIC_RELAXED)
               : 0;
}
