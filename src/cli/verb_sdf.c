// SPDX-License-Identifier: MIT
/* quoin sdf: the signed distance field of a mesh, or the values of a solid, as a volume file. */
#include "band_input.h"
#include "input.h"
#include "number.h"
#include "verbs.h"

#include <string.h>

static int check_output(const cli_options *options) {
    static const char *const endings[] = {"vdb", "npy", "nii"};
    char ending[8];
    if (!options->output)
        return cli_usage("where to? name the output: quoin sdf %s -o distances.vdb",
                         options->input);
    input_ending(options->output, ending);
    for (size_t n = 0; n < sizeof endings / sizeof *endings; ++n)
        if (strcmp(ending, endings[n]) == 0)
            return 0;
    return cli_usage("%s: distances are written as .vdb, .npy or .nii", options->output);
}

static void tell(cli_session *session, const band_input *input) {
    char active[NUMBER_TEXT_SIZE], leaves[NUMBER_TEXT_SIZE];
    cli_tell(session, "%s: %s samples in the band, %s leaves, voxels of %.6g, in %.2f s",
             session->options->output, number_format_count(input->band.active_count, active),
             number_format_count(input->band.leaf_count, leaves), input->band.voxel,
             input->seconds_band);
}

static int write_report(cli_session *session, const band_input *input, double seconds_write) {
    const cli_options *options = session->options;
    json_t *report = report_start("sdf");
    json_object_set_new(report, "input", report_path(options->input));
    json_object_set_new(report, "output", report_path(options->output));
    json_object_set(report, "band", input->report);
    json_object_set_new(report, "seconds_read", report_real(input->seconds_read));
    json_object_set_new(report, "seconds_write", report_real(seconds_write));
    json_object_set_new(report, "memory", report_memory(session));
    return report_write(report, options->report);
}

int verb_sdf(cli_session *session) {
    const cli_options *options = session->options;
    band_input input;
    int exit_code = check_output(options);
    if (exit_code)
        return exit_code;
    exit_code = band_read(session, &input);
    const double started = cli_seconds();
    qn_error error;
    if (!exit_code)
        exit_code = cli_fail(
            session, qn_volume_write(session->context, input.volume, options->output, &error),
            &error);
    if (!exit_code)
        tell(session, &input);
    if (!exit_code && options->report)
        exit_code = write_report(session, &input, cli_seconds() - started);
    band_free(&input);
    return exit_code;
}
