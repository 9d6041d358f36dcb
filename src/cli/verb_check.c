// SPDX-License-Identifier: MIT
/* quoin check: what a mesh is, and whether it is fit for use. */
#include "input.h"
#include "number.h"
#include "report.h"
#include "verbs.h"
#include "verdict.h"

#include <inttypes.h>
#include <stdio.h>

static void print_count(const char *label, int64_t count, uint32_t fault, uint32_t fail_on) {
    char text[NUMBER_TEXT_SIZE];
    const char *mark = fault == 0        ? ""
                       : count == 0      ? "  ok"
                       : fault & fail_on ? "  FAIL"
                                         : "  seen";
    printf("  %-24s%15s%s\n", label, number_format_count(count, text), mark);
}

static void print_real(const char *label, double value) {
    printf("  %-24s%15.6g\n", label, value);
}

static void print_counts(const qn_mesh_report *report) {
    printf("counts\n");
    print_count("vertices", report->vertex_count, 0, 0);
    print_count("quads", report->quad_count, 0, 0);
    print_count("triangles", report->triangle_count, 0, 0);
    print_count("edges", report->edge_count, 0, 0);
    print_count("unused vertices", report->unused_vertices, 0, 0);
    print_count("vertices at one place", report->duplicate_positions, 0, 0);
    print_count("components", report->components, 0, 0);
    print_count("closed components", report->closed_components, 0, 0);
    print_count("Euler characteristic", report->euler_characteristic, 0, 0);
    print_count("genus, sum", report->genus_sum, 0, 0);
    print_count("genus, largest", report->largest_genus, 0, 0);
}

static void print_faults(const qn_mesh_report *report, uint32_t fail_on) {
    printf("faults\n");
    print_count("boundary edges", report->boundary_edges, FAULT_OPEN, fail_on);
    print_count("non-manifold edges", report->nonmanifold_edges, FAULT_NONMANIFOLD, fail_on);
    print_count("non-manifold vertices", report->nonmanifold_vertices, FAULT_NONMANIFOLD, fail_on);
    print_count("orientation conflicts", report->orientation_conflicts, FAULT_ORIENTATION, fail_on);
    if (report->self_intersections < 0)
        printf("  %-24s%15s\n", "self-intersections", "not tested");
    else
        print_count("self-intersections", report->self_intersections, FAULT_INTERSECT, fail_on);
    print_count("degenerate faces", report->degenerate_faces, FAULT_DEGENERATE, fail_on);
    print_count("duplicate faces", report->duplicate_faces, FAULT_DUPLICATE, fail_on);
    print_count("not finite vertices", report->nonfinite_vertices, FAULT_NONFINITE, fail_on);
}

static void print_shape(const qn_mesh_report *report) {
    printf("shape\n");
    print_real("area", report->area);
    print_real("volume", report->volume);
    for (int axis = 0; axis < 3; ++axis)
        printf("  bounds %c                %.6g to %.6g\n", 'x' + axis, report->bounds[0][axis],
               report->bounds[1][axis]);
    if (report->quad_count > 0) {
        print_real("quad quality, mean", report->quad_quality_mean);
        print_real("quad quality, least", report->quad_quality_min);
    }
    print_real("triangle quality, mean", report->triangle_quality_mean);
    print_real("triangle quality, least", report->triangle_quality_min);
    print_real("smallest angle, degrees", report->smallest_angle);
    printf("  %-24s%13.2f %%\n", "irregular vertices", 100 * report->irregular_vertices);
}

static void print_verdict(const qn_mesh_report *report, uint32_t fail_on, const char *path) {
    uint32_t faults = verdict_faults(report);
    char text[VERDICT_TEXT_SIZE];
    printf("\n%s: ", path);
    if (faults & fail_on)
        printf("FAILED: %s\n", verdict_describe(report, faults & fail_on, text));
    else if (faults)
        printf("good (not failed on: %s)\n", verdict_describe(report, faults, text));
    else
        printf("good: closed, manifold, oriented, no self-intersections\n");
}

static json_t *make_report(cli_session *session, const qn_mesh_report *check, uint32_t fail_on,
                           double seconds) {
    json_t *report = report_start("check"), *list = json_array();
    uint32_t failed = verdict_faults(check) & fail_on;
    for (uint32_t fault = 1; fault < FAULT_ALL; fault <<= 1)
        if (failed & fault)
            json_array_append_new(list, json_string(verdict_name(fault)));
    json_object_set_new(report, "input", report_path(session->options->input));
    json_object_set_new(report, "check", report_mesh_check(check));
    json_object_set_new(report, "failed", list);
    json_object_set_new(report, "good", json_boolean(failed == 0));
    json_object_set_new(report, "seconds_check", report_real(seconds));
    json_object_set_new(report, "memory", report_memory(session));
    return report;
}

/* Prints and writes what was found; the exit code 6 when a fault that counts is there. */
static int conclude(cli_session *session, const qn_mesh_report *check, double seconds) {
    const cli_options *options = session->options;
    uint32_t fail_on = options->fail_on_given ? options->fail_on : VERDICT_DEFAULT;
    int exit_code = 0;
    if (options->json)
        exit_code = report_write(make_report(session, check, fail_on, seconds), "-");
    else if (!options->quiet) {
        print_counts(check);
        print_faults(check, fail_on);
        print_shape(check);
        print_verdict(check, fail_on, options->input);
        exit_code = cli_finish_stdout(0);
    }
    if (!exit_code && options->report)
        exit_code = report_write(make_report(session, check, fail_on, seconds), options->report);
    if (exit_code)
        return exit_code;
    if (check->quad_count + check->triangle_count == 0) {
        cli_say("%s: there is no face in this mesh", options->input);
        return CLI_EMPTY;
    }
    return verdict_faults(check) & fail_on ? CLI_QUALITY : 0;
}

int verb_check(cli_session *session) {
    qn_mesh *mesh = NULL;
    qn_mesh_report check;
    qn_error error;
    int exit_code = input_read_mesh(session, &mesh);
    double started = cli_seconds();
    if (!exit_code)
        exit_code =
            cli_fail(session, qn_mesh_check(session->context, mesh, NULL, &check, &error), &error);
    double seconds = cli_seconds() - started;
    qn_mesh_destroy(mesh);
    progress_erase(&session->progress);
    return exit_code ? exit_code : conclude(session, &check, seconds);
}
