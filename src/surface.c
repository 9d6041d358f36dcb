// SPDX-License-Identifier: MIT
/* The facade: checks the options, runs the surfacer for each iso-value; contains no numerics. */
#include <qn/surface.h>
#include "cms/cms.h"
#include "core/parallel.h"
#include "core/status.h"
#include "dmc/dmc.h"
#include "gpu/gpu.h"
#include "mesh/mesh.h"
#include "mesh/untangle.h"
#include "solid/sampled.h"
#include "qni_config.h"

#include <math.h>
#include <string.h>

static qn_status untangle(qn_context *context, const qn_volume *volume,
                          const qn_surface_options *options, qn_mesh *mesh,
                          qn_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    qni_untangle_options settings = {.everywhere = options->untangle == QN_UNTANGLE_ALL,
                                     .gives_inward = options->inside == QN_INSIDE_BELOW};
    qni_untangle_report done;
    memcpy(settings.to_world, qn_volume_grid(volume)->index_to_world, sizeof settings.to_world);
    QN_TRY(qni_mesh_untangle(context, mesh, &settings, &done, error));
    report->crossings = done.crossings;
    report->crossings_left = done.crossings_left;
    report->untangled_vertices = done.moved_vertices;
    report->untangled_farthest = done.farthest;
    report->seconds_untangle = qni_seconds() - start;
    report->seconds_total += report->seconds_untangle;
    return QN_OK;
}

static qn_status one_isovalue(qn_context *context, const qn_volume *volume, double isovalue,
                              const qn_surface_options *options, qn_mesh **mesh_out,
                              qn_surface_report *report, qn_error *error) {
    qn_surface_report on_gpu = {.isovalue = isovalue};
    bool done = false;
    if (options->device != QN_DEVICE_CPU)
        QN_TRY(
            qni_gpu_surface(context, volume, isovalue, options, &done, mesh_out, &on_gpu, error));
    if (done) {
        *report = on_gpu;
    } else {
        QN_TRY(qni_dmc_surface(context, volume, isovalue, options, mesh_out, report, error));
        report->device = QN_DEVICE_CPU;
        memcpy(report->device_note, on_gpu.device_note, sizeof report->device_note);
    }
    if (*mesh_out && options->untangle != QN_UNTANGLE_OFF)
        QN_TRY(untangle(context, volume, options, *mesh_out, report, error));
    if (*mesh_out && options->triangles)
        QN_TRY(qn_mesh_triangulate(context, *mesh_out, error));
    return QN_OK;
}

static qn_status check_options(const qn_surface_options *options, qn_mesh **meshes_out,
                               qn_error *error) {
    QNI_CHECK_OPTIONS(options, "qn_surface_options_init", error);
    if (options->isovalue_count < 0 || (options->isovalue_count > 0 && !options->isovalues))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "isovalue_count does not go with isovalues");
    if (options->simplify_passes < -1)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "simplify_passes is %d: take 0 (until done), a number of passes, or -1",
                        (int)options->simplify_passes);
    if (options->relax < 0)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "relax is %d: it counts sweeps and cannot be negative",
                        (int)options->relax);
    if ((unsigned)options->untangle > QN_UNTANGLE_ALL)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "untangle is %d: there is none such",
                        (int)options->untangle);
    if ((unsigned)options->device > QN_DEVICE_CUDA)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "device is %d: there is none such",
                        (int)options->device);
    if (!meshes_out && !options->count_only)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "meshes_out may be NULL only with count_only");
    return QN_OK;
}

qn_status qn_surface(qn_context *context, const qn_volume *volume,
                     const qn_surface_options *options, qn_mesh **meshes_out,
                     qn_surface_report *reports_out, qn_error *error) {
    static const double zero = 0;
    qn_surface_options defaults;
    qn_surface_options_init(&defaults);
    options = options ? options : &defaults;
    QN_TRY(check_options(options, meshes_out, error));
    const int32_t count = options->isovalue_count ? options->isovalue_count : 1;
    const double *isovalues = options->isovalue_count ? options->isovalues : &zero;
    for (int32_t n = 0; meshes_out && n < count; ++n)
        meshes_out[n] = NULL;
    for (int32_t n = 0; n < count; ++n) {
        qn_surface_report report;
        qn_mesh *mesh = NULL;
        qn_status status =
            one_isovalue(context, volume, isovalues[n], options, &mesh, &report, error);
        if (meshes_out)
            meshes_out[n] = mesh;
        if (status != QN_OK) {
            for (int32_t m = 0; meshes_out && m <= n; ++m) {
                qn_mesh_destroy(meshes_out[m]);
                meshes_out[m] = NULL;
            }
            return status;
        }
        if (reports_out)
            reports_out[n] = report;
    }
    return QN_OK;
}

/* ---- solids ---------------------------------------------------------------------------------- */

static qn_status check_solid_options(const qn_solid_surface_options *options, qn_error *error) {
    QNI_CHECK_OPTIONS(options, "qn_solid_surface_options_init", error);
    const int32_t depth = options->depth ? options->depth : 7,
                  base = options->base ? options->base : 8;
    if (depth < QN_MIN_DEPTH || depth > QN_MAX_DEPTH)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "depth %d: give a number from %d to %d",
                        depth, QN_MIN_DEPTH, QN_MAX_DEPTH);
    if (!(options->cell >= 0) || !isfinite(options->cell) || (options->cell > 0 && options->depth))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "cell %g and depth %d: give the size of the finest cells or a depth",
                        options->cell, options->depth);
    if (base < 1 || (base & (base - 1)) || (base > 1 << depth && !(options->cell > 0)))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "base %d: give a power of two from 1 to 2^depth = %d", base, 1 << depth);
    if (!(options->tolerance >= 0) || !isfinite(options->tolerance))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "tolerance %g: give a length, or 0 for a twentieth of a finest cell",
                        options->tolerance);
    if (!(options->crease >= 0) || options->crease > 180)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "crease angle %g: give degrees from 0 to 180", options->crease);
    return QN_OK;
}

qn_status qn_solid_surface(qn_context *context, const qn_solid *solid,
                           const qn_solid_surface_options *options, qn_mesh **mesh_out,
                           qn_solid_surface_report *report_out, qn_error *error) {
    qn_solid_surface_options defaults;
    qn_solid_surface_options_init(&defaults);
    options = options ? options : &defaults;
    *mesh_out = NULL;
    QN_TRY(check_solid_options(options, error));
    if (!QNI_HAVE_LAPACKE)
        return qni_fail(error, QN_ERROR_UNSUPPORTED,
                        "this build has no surfaces of solids: install liblapacke-dev and build "
                        "with -Dlapacke=enabled");
    qn_solid_surface_report report;
    memset(&report, 0, sizeof report);
    const qni_cms_job job = {.solid = solid, .creases = true};
    QN_TRY(qni_cms_surface(context, &job, options, mesh_out, &report, error));
    if (report_out)
        *report_out = report;
    return QN_OK;
}

/* ---- volumes by the same surfacer -------------------------------------------------------------
 */

static qn_status check_volume_options(const qn_solid_surface_options *options, qn_error *error) {
    QN_TRY(check_solid_options(options, error));
    if (options->depth || options->cell > 0)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "depth %d, cell %g: the finest cells of a volume are those between its "
                        "samples; leave both out",
                        options->depth, options->cell);
    if (options->has_box)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a box cannot be cut out of a volume on its own lattice; make a solid of "
                        "it and intersect that with a box");
    return QN_OK;
}

static qn_status surface_of_samples(qn_context *context, const qn_solid *solid, qn_inside inside,
                                    const qn_solid_surface_options *options, qn_mesh **mesh_out,
                                    qn_solid_surface_report *report, qn_error *error) {
    const qni_cms_job job = {.solid = solid,
                             .samples = true,
                             .join_ties = inside == QN_INSIDE_ABOVE,
                             .creases = qni_sampled_has_creases(solid)};
    QN_TRY(qni_cms_surface(context, &job, options, mesh_out, report, error));
    const qni_sample_frame *frame = qni_sampled_frame(solid);
    qni_mesh_move(*mesh_out, (const double(*)[4])frame->to_world, frame->turned);
    report->rounded = !frame->exact;
    report->creases = qni_sampled_has_creases(solid);
    report->distance_share = qni_sampled_distance_share(solid);
    report->sharp_crossings = qni_sampled_sharp_crossings(solid);
    return QN_OK;
}

qn_status qn_surface_adaptive(qn_context *context, const qn_volume *volume, double isovalue,
                              qn_inside inside, const qn_solid_surface_options *options,
                              qn_mesh **mesh_out, qn_solid_surface_report *report_out,
                              qn_error *error) {
    qn_solid_surface_options defaults;
    qn_solid_surface_options_init(&defaults);
    options = options ? options : &defaults;
    *mesh_out = NULL;
    QN_TRY(check_volume_options(options, error));
    if (!QNI_HAVE_LAPACKE)
        return qni_fail(error, QN_ERROR_UNSUPPORTED,
                        "this build has no Cubical Marching Squares: install liblapacke-dev and "
                        "build with -Dlapacke=enabled");
    const double pi = 3.14159265358979323846;
    const qni_sampled_settings settings = {
        .isovalue = isovalue,
        .inside_below = inside == QN_INSIDE_BELOW,
        .creases = options->creases != QN_CREASES_OFF && !options->no_features,
        .least_share = options->creases == QN_CREASES_AUTO ? 0.9 : 0,
        .crease_cosine = cos((options->crease > 0 ? options->crease : 30) * pi / 180),
    };
    qn_solid *solid;
    QN_TRY(qni_sampled_create(context, volume, &settings, &solid, error));
    qn_solid_surface_report report;
    memset(&report, 0, sizeof report);
    const qn_status status =
        surface_of_samples(context, solid, inside, options, mesh_out, &report, error);
    qn_solid_destroy(solid);
    if (status == QN_OK) {
        const qn_grid *grid = qn_volume_grid(volume);
        memcpy((*mesh_out)->space, grid->space, sizeof grid->space);
        memcpy((*mesh_out)->unit, grid->unit, sizeof grid->unit);
    }
    if (status == QN_OK && report_out)
        *report_out = report;
    return status;
}
