// SPDX-License-Identifier: MIT
/* JSON. Keys are the field names of the public structs, so that the headers document them. */
#include "report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

json_t *report_start(const char *verb) {
    return json_pack("{s:s, s:i, s:s}", "quoin", qn_version(), "schema", REPORT_SCHEMA, "verb",
                     verb);
}

json_t *report_real(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *report_reals(const double *values, int count) {
    json_t *array = json_array();
    for (int i = 0; i < count; ++i)
        json_array_append_new(array, report_real(values[i]));
    return array;
}

static void set_integer(json_t *object, const char *key, int64_t value) {
    json_object_set_new(object, key, json_integer(value));
}

static void set_real(json_t *object, const char *key, double value) {
    json_object_set_new(object, key, report_real(value));
}

/* File names need not be UTF-8; JSON must be. */
static json_t *text(const char *value) {
    json_t *string = json_string(value);
    if (string)
        return string;
    char *copy = strdup(value);
    for (char *c = copy; c && *c; ++c)
        *c = (unsigned char)*c < 128 ? *c : '?';
    string = json_string(copy ? copy : "");
    free(copy);
    return string;
}

json_t *report_path(const char *path) {
    return text(path);
}

/* The length of a column of the matrix: distance between neighbours along that index axis. */
static double spacing_of(const qn_grid *grid, int axis) {
    double x = grid->index_to_world[0][axis], y = grid->index_to_world[1][axis];
    double z = grid->index_to_world[2][axis];
    return sqrt(x * x + y * y + z * z);
}

json_t *report_volume(const char *path, const qn_volume *volume) {
    const qn_grid *grid = qn_volume_grid(volume);
    json_t *object = json_object();
    json_object_set_new(object, "path", text(path));
    json_object_set_new(object, "format", text(qn_volume_format(volume)));
    json_t *shape = json_array(), *spacing = json_array(), *matrix = json_array();
    for (int axis = 0; axis < 3; ++axis) {
        json_array_append_new(shape, json_integer(grid->size[axis]));
        json_array_append_new(spacing, report_real(spacing_of(grid, axis)));
    }
    for (int row = 0; row < 4; ++row)
        json_array_append_new(matrix, report_reals(grid->index_to_world[row], 4));
    json_object_set_new(object, "shape", shape);
    json_object_set_new(object, "dtype", text(qn_scalar_name(grid->scalar)));
    set_real(object, "slope", grid->slope);
    set_real(object, "intercept", grid->intercept);
    json_object_set_new(object, "spacing", spacing);
    json_object_set_new(object, "index_to_world", matrix);
    json_object_set_new(object, "space", text(grid->space));
    json_object_set_new(object, "unit", text(grid->unit));
    return object;
}

json_t *report_statistics(const qn_volume_statistics *s) {
    json_t *object = json_object(), *histogram = json_array();
    set_integer(object, "sample_count", s->sample_count);
    set_integer(object, "nan_count", s->nan_count);
    set_integer(object, "infinite_count", s->infinite_count);
    set_real(object, "minimum", s->minimum);
    set_real(object, "maximum", s->maximum);
    set_real(object, "mean", s->mean);
    json_object_set_new(object, "suggestions", report_reals(s->suggestions, s->suggestion_count));
    json_object_set_new(object, "suggested",
                        s->suggestion_count > 0 ? report_real(s->suggested) : json_null());
    for (int bin = 0; bin < QN_HISTOGRAM_BINS; ++bin)
        json_array_append_new(histogram, json_integer(s->histogram[bin]));
    json_object_set_new(object, "histogram", histogram);
    return object;
}

json_t *report_surface(const qn_surface_report *s) {
    json_t *object = json_object();
    set_real(object, "isovalue", s->isovalue);
    set_integer(object, "cells", s->cells);
    set_integer(object, "active_leaves", s->active_leaves);
    set_integer(object, "active_cells", s->active_cells);
    set_integer(object, "ambiguous_faces", s->ambiguous_faces);
    set_integer(object, "multiple_cells", s->multiple_cells);
    set_integer(object, "tied_faces", s->tied_faces);
    set_integer(object, "vertices", s->vertices);
    set_integer(object, "quads", s->quads);
    set_integer(object, "slice_points", s->slice_points);
    set_integer(object, "degenerate_points", s->degenerate_points);
    set_integer(object, "fallback_points", s->fallback_points);
    set_integer(object, "zero_gradients", s->zero_gradients);
    set_integer(object, "doubled_edges", s->doubled_edges);
    set_integer(object, "repaired_edges", s->repaired_edges);
    set_integer(object, "tunnels", s->tunnels);
    set_integer(object, "restored_tunnels", s->restored_tunnels);
    set_integer(object, "split_rim_vertices", s->split_rim_vertices);
    set_integer(object, "nan_samples", s->nan_samples);
    set_integer(object, "infinite_samples", s->infinite_samples);
    set_integer(object, "output_bytes", s->output_bytes);
    set_integer(object, "scratch_bytes", s->scratch_bytes);
    set_real(object, "seconds_classify", s->seconds_classify);
    set_real(object, "seconds_emit", s->seconds_emit);
    set_real(object, "seconds_total", s->seconds_total);
    set_integer(object, "merged_quads", s->merged_quads);
    set_integer(object, "shrunk_quads", s->shrunk_quads);
    set_integer(object, "unprojected_points", s->unprojected_points);
    set_integer(object, "relaxed_vertices", s->relaxed_vertices);
    set_integer(object, "simplify_passes", s->simplify_passes);
    set_real(object, "seconds_simplify", s->seconds_simplify);
    set_real(object, "seconds_relax", s->seconds_relax);
    set_integer(object, "crossings", s->crossings);
    set_integer(object, "crossings_left", s->crossings_left);
    set_integer(object, "untangled_vertices", s->untangled_vertices);
    set_real(object, "untangled_farthest", s->untangled_farthest);
    set_real(object, "seconds_untangle", s->seconds_untangle);
    json_object_set_new(object, "device",
                        json_string(s->device == QN_DEVICE_CUDA ? "cuda" : "cpu"));
    json_object_set_new(object, "device_note",
                        s->device_note[0] ? json_string(s->device_note) : json_null());
    json_object_set_new(object, "device_slabs", json_integer(s->device_slabs));
    return object;
}

static void set_solid_integers(json_t *object, const qn_solid_surface_report *s) {
    const struct {
        const char *key;
        int64_t value;
    } rows[] = {
        {"blocks", s->blocks},
        {"evaluations", s->evaluations},
        {"crossings", s->crossings},
        {"multiple_edges", s->multiple_edges},
        {"mended_edges", s->mended_edges},
        {"leaves", s->leaves},
        {"segments", s->segments},
        {"ambiguous_faces", s->ambiguous_faces},
        {"face_features", s->face_features},
        {"dropped_face_features", s->dropped_face_features},
        {"loops", s->loops},
        {"smooth_loops", s->smooth_loops},
        {"crease_loops", s->crease_loops},
        {"corner_loops", s->corner_loops},
        {"flat_loops", s->flat_loops},
        {"divided_leaves", s->divided_leaves},
        {"escaped_corners", s->escaped_corners},
        {"reaching_corners", s->reaching_corners},
        {"united_cells", s->united_cells},
        {"split_loops", s->split_loops},
        {"flat_vertices", s->flat_vertices},
        {"kept_regions", s->kept_regions},
        {"skipped_steps", s->skipped_steps},
        {"multiple_cells", s->multiple_cells},
        {"moved_loops", s->moved_loops},
        {"nested_cells", s->nested_cells},
        {"sharp_crossings", s->sharp_crossings},
        {"tubes", s->tubes},
        {"nested_tubes", s->nested_tubes},
        {"lost_tubes", s->lost_tubes},
        {"unresolved_cells", s->unresolved_cells},
        {"vertices", s->vertices},
        {"triangles", s->triangles},
        {"crease_edges", s->crease_edges},
        {"output_bytes", s->output_bytes},
        {"scratch_bytes", s->scratch_bytes},
    };
    for (size_t n = 0; n < sizeof rows / sizeof *rows; ++n)
        json_object_set_new(object, rows[n].key, json_integer(rows[n].value));
}

json_t *report_solid_surface(const qn_solid_surface_report *s) {
    json_t *object = json_object(), *levels = json_array();
    json_object_set_new(object, "finest_cell", report_real(s->finest_cell));
    set_solid_integers(object, s);
    for (int n = 0; n < 16; ++n)
        json_array_append_new(levels, json_integer(s->leaves_by_level[n]));
    json_object_set_new(object, "leaves_by_level", levels);
    json_object_set_new(object, "rounded", json_boolean(s->rounded));
    json_object_set_new(object, "creases", json_boolean(s->creases));
    json_object_set_new(object, "distance_share", report_real(s->distance_share));
    json_object_set_new(object, "seconds_sampling", report_real(s->seconds_sampling));
    json_object_set_new(object, "seconds_octree", report_real(s->seconds_octree));
    json_object_set_new(object, "seconds_cms", report_real(s->seconds_cms));
    json_object_set_new(object, "seconds_total", report_real(s->seconds_total));
    return object;
}

json_t *report_mesh_check(const qn_mesh_report *c) {
    json_t *object = json_object(), *bounds = json_array();
    set_integer(object, "vertex_count", c->vertex_count);
    set_integer(object, "quad_count", c->quad_count);
    set_integer(object, "triangle_count", c->triangle_count);
    set_integer(object, "edge_count", c->edge_count);
    set_integer(object, "unused_vertices", c->unused_vertices);
    set_integer(object, "boundary_edges", c->boundary_edges);
    set_integer(object, "nonmanifold_edges", c->nonmanifold_edges);
    set_integer(object, "orientation_conflicts", c->orientation_conflicts);
    set_integer(object, "nonmanifold_vertices", c->nonmanifold_vertices);
    set_integer(object, "degenerate_faces", c->degenerate_faces);
    set_integer(object, "duplicate_faces", c->duplicate_faces);
    set_integer(object, "duplicate_positions", c->duplicate_positions);
    set_integer(object, "nonfinite_vertices", c->nonfinite_vertices);
    set_integer(object, "self_intersections", c->self_intersections);
    set_integer(object, "components", c->components);
    set_integer(object, "closed_components", c->closed_components);
    set_integer(object, "euler_characteristic", c->euler_characteristic);
    set_integer(object, "genus_sum", c->genus_sum);
    set_integer(object, "largest_genus", c->largest_genus);
    json_object_set_new(object, "closed", json_boolean(c->closed));
    json_object_set_new(object, "manifold", json_boolean(c->manifold));
    json_object_set_new(object, "oriented", json_boolean(c->oriented));
    set_real(object, "area", c->area);
    set_real(object, "volume", c->volume);
    json_array_append_new(bounds, report_reals(c->bounds[0], 3));
    json_array_append_new(bounds, report_reals(c->bounds[1], 3));
    json_object_set_new(object, "bounds", bounds);
    set_real(object, "quad_quality_mean", c->quad_quality_mean);
    set_real(object, "quad_quality_min", c->quad_quality_min);
    set_real(object, "triangle_quality_mean", c->triangle_quality_mean);
    set_real(object, "triangle_quality_min", c->triangle_quality_min);
    set_real(object, "smallest_angle", c->smallest_angle);
    set_real(object, "irregular_vertices", c->irregular_vertices);
    return object;
}

json_t *report_memory(const cli_session *session) {
    json_t *object = json_object();
    set_integer(object, "context_peak_bytes", qn_context_memory(session->context).peak_bytes);
    set_integer(object, "process_peak_bytes", cli_process_peak_bytes());
    return object;
}

int report_write(json_t *report, const char *path) {
    char *dump = json_dumps(report, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(report);
    if (!dump) {
        cli_say("not enough memory for the report");
        return CLI_OUTPUT;
    }
    int exit_code = 0;
    if (strcmp(path, "-") == 0) {
        puts(dump);
        exit_code = cli_finish_stdout(0);
    } else {
        size_t length = strlen(dump);
        dump[length] = '\n'; /* in the place of the final zero byte, which no one needs now */
        qn_error error;
        qn_status status = qn_write_file(path, dump, length + 1, &error);
        if (status != QN_OK)
            cli_say("%s", error.message);
        exit_code = qn_status_exit_code(status);
    }
    free(dump);
    return exit_code;
}
