// SPDX-License-Identifier: MIT
/* quoin compare: how far two meshes are apart. */
#include "input.h"
#include "number.h"
#include "report.h"
#include "verbs.h"

#include <stdio.h>
#include <string.h>

static void print_row(const char *label, double there, double back, double both, double diagonal) {
    printf("  %-24s%13.6g%13.6g%13.6g%12.4f %%\n", label, there, back, both, 100 * both / diagonal);
}

static void print_place(const char *label, const double p[3]) {
    printf("  %-24s%13.6g%13.6g%13.6g\n", label, p[0], p[1], p[2]);
}

static void print_angles(const char *label, double there, double back) {
    printf("  %-24s%13.6g%13.6g\n", label, there, back);
}

static void print_sizes(const char *label, double a, double b) {
    printf("  %-24s%13.6g%13.6g", label, a, b);
    if (a != 0)
        printf("%25.4f %%", 100 * (b - a) / a);
    putchar('\n');
}

static void print_table(const cli_options *options, const qn_mesh_comparison *c) {
    const qn_mesh_distance *a = &c->a_to_b, *b = &c->b_to_a;
    char first[NUMBER_TEXT_SIZE], second[NUMBER_TEXT_SIZE];
    printf("a = %s, b = %s\n", options->input, options->second);
    printf("  %-24s%13s%13s%13s%14s\n", "distances", "a to b", "b to a", "both", "of diagonal");
    print_row("largest", a->max, b->max, c->max, c->diagonal);
    print_row("root mean square", a->rms, b->rms, c->rms, c->diagonal);
    print_row("mean", a->mean, b->mean, c->mean, c->diagonal);
    printf("  %-24s%13s%13s\n", "points measured", number_format_count(a->points, first),
           number_format_count(b->points, second));
    print_place("largest at, a to b", a->farthest);
    print_place("largest at, b to a", b->farthest);
    printf("angles between normals, degrees\n");
    print_angles("mean", a->normal_mean, b->normal_mean);
    print_angles("largest", a->normal_max, b->normal_max);
    print_angles("beyond 30, % of area", 100 * a->normal_beyond_30, 100 * b->normal_beyond_30);
    printf("  %-24s%13s%13s%27s\n", "sizes", "a", "b", "b more than a");
    print_sizes("area", c->area_a, c->area_b);
    print_sizes("volume", c->volume_a, c->volume_b);
}

static json_t *distance_object(const qn_mesh_distance *d) {
    json_t *object = json_object();
    json_object_set_new(object, "points", json_integer(d->points));
    json_object_set_new(object, "max", report_real(d->max));
    json_object_set_new(object, "mean", report_real(d->mean));
    json_object_set_new(object, "rms", report_real(d->rms));
    json_object_set_new(object, "farthest", report_reals(d->farthest, 3));
    json_object_set_new(object, "normal_mean", report_real(d->normal_mean));
    json_object_set_new(object, "normal_max", report_real(d->normal_max));
    json_object_set_new(object, "normal_beyond_30", report_real(d->normal_beyond_30));
    return object;
}

static json_t *comparison_object(const qn_mesh_comparison *c) {
    const struct {
        const char *key;
        double value;
    } rows[] = {
        {"max", c->max},           {"mean", c->mean},         {"rms", c->rms},
        {"diagonal", c->diagonal}, {"area_a", c->area_a},     {"area_b", c->area_b},
        {"volume_a", c->volume_a}, {"volume_b", c->volume_b},
    };
    json_t *object = json_object();
    json_object_set_new(object, "a_to_b", distance_object(&c->a_to_b));
    json_object_set_new(object, "b_to_a", distance_object(&c->b_to_a));
    for (size_t n = 0; n < sizeof rows / sizeof *rows; ++n)
        json_object_set_new(object, rows[n].key, report_real(rows[n].value));
    return object;
}

static bool is_good(const cli_options *options, const qn_mesh_comparison *c) {
    return options->solid.tolerance == 0 || c->max <= options->solid.tolerance;
}

static json_t *make_report(cli_session *session, const qn_mesh_comparison *c, double seconds) {
    const cli_options *options = session->options;
    const double tolerance = options->solid.tolerance;
    json_t *report = report_start("compare");
    json_object_set_new(report, "input", report_path(options->input));
    json_object_set_new(report, "second", report_path(options->second));
    json_object_set_new(report, "comparison", comparison_object(c));
    json_object_set_new(report, "tolerance", tolerance > 0 ? report_real(tolerance) : json_null());
    json_object_set_new(report, "good", json_boolean(is_good(options, c)));
    json_object_set_new(report, "seconds_compare", report_real(seconds));
    json_object_set_new(report, "memory", report_memory(session));
    return report;
}

static int conclude(cli_session *session, const qn_mesh_comparison *c, double seconds) {
    const cli_options *options = session->options;
    int exit_code = 0;
    if (options->json)
        exit_code = report_write(make_report(session, c, seconds), "-");
    else if (!options->quiet) {
        print_table(options, c);
        exit_code = cli_finish_stdout(0);
    }
    if (!exit_code && options->report)
        exit_code = report_write(make_report(session, c, seconds), options->report);
    if (exit_code || is_good(options, c))
        return exit_code;
    cli_say("%s and %s are %.6g apart, more than --tol %.6g", options->input, options->second,
            c->max, options->solid.tolerance);
    return CLI_QUALITY;
}

int verb_compare(cli_session *session) {
    const cli_options *options = session->options;
    qn_mesh *a = NULL, *b = NULL;
    qn_mesh_comparison comparison;
    qn_mesh_compare_options compare;
    qn_mesh_compare_options_init(&compare);
    compare.samples = options->samples;
    qn_error error;
    int exit_code = input_read_mesh(session, &a);
    if (!exit_code)
        exit_code = input_read_mesh_from(session, options->second, &b);
    const double started = cli_seconds();
    if (!exit_code)
        exit_code = cli_fail(session,
                             qn_mesh_compare(session->context, a, b, &compare, &comparison, &error),
                             &error);
    const double seconds = cli_seconds() - started;
    qn_mesh_destroy(a);
    qn_mesh_destroy(b);
    progress_erase(&session->progress);
    return exit_code ? exit_code : conclude(session, &comparison, seconds);
}
