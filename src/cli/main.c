// SPDX-License-Identifier: MIT
/* The quoin tool: finds the verb, reads its options, runs it. */
#include "help.h"
#include "nearest.h"
#include "session.h"
#include "verbs.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static int find_verb(const char *name) {
    for (int verb = 0; verb < VERB_COUNT; ++verb)
        if (strcmp(name, cli_verbs[verb].name) == 0)
            return verb;
    return -1;
}

static int unknown_verb(const char *name) {
    const char *names[VERB_COUNT];
    for (int verb = 0; verb < VERB_COUNT; ++verb)
        names[verb] = cli_verbs[verb].name;
    const char *close = nearest_word(name, names, VERB_COUNT);
    if (close)
        return cli_usage("'%s' is not a verb; did you mean 'quoin %s'?", name, close);
    if (name[0] != '-' && access(name, F_OK) == 0)
        return cli_usage("'%s' is a file: a verb comes first, for example 'quoin info %s'", name,
                         name);
    return cli_usage("'%s' is not a verb; they are mesh, csg, remesh, sdf, info, check, compare, "
                     "convert, view ('quoin help' "
                     "tells more)",
                     name);
}

static int print_version(void) {
    printf("quoin %s\n", qn_version());
    return cli_finish_stdout(0);
}

static int run_help(const cli_options *options) {
    int verb = options->input ? find_verb(options->input) : -1;
    if (options->man)
        help_man(stdout);
    else if (options->completion)
        help_completion(stdout);
    else if (options->input && verb < 0)
        return unknown_verb(options->input);
    else if (verb >= 0)
        help_verb(stdout, (cli_verb)verb);
    else
        help_tool(stdout);
    return cli_finish_stdout(0);
}

static int run_verb(const cli_options *options) {
    static int (*const verbs[])(cli_session *) = {verb_mesh,    verb_csg,     verb_remesh,
                                                  verb_sdf,     verb_info,    verb_check,
                                                  verb_compare, verb_convert, verb_view};
    cli_session session;
    int exit_code = cli_session_open(&session, options);
    if (!exit_code)
        exit_code = verbs[options->verb](&session);
    cli_session_close(&session);
    return exit_code;
}

int main(int argc, char **argv) {
    if (argc < 2) {
        help_tool(stderr);
        return CLI_USAGE;
    }
    const char *name = argv[1];
    if (strcmp(name, "--version") == 0)
        return print_version();
    if (strcmp(name, "-h") == 0 || strcmp(name, "--help") == 0)
        name = "help";
    int verb = find_verb(name);
    if (verb < 0)
        return unknown_verb(name);
    cli_options options;
    int exit_code = cli_options_parse((cli_verb)verb, argc, argv, &options);
    if (exit_code)
        ; /* already said */
    else if (options.version)
        exit_code = print_version();
    else if (options.help) {
        help_verb(stdout, (cli_verb)verb);
        exit_code = cli_finish_stdout(0);
    } else if (verb == VERB_HELP)
        exit_code = run_help(&options);
    else
        exit_code = run_verb(&options);
    cli_options_free(&options);
    return exit_code;
}
