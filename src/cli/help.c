// SPDX-License-Identifier: MIT
/* Help texts, man page and bash completion, all made from the tables of options.h. */
#include "help.h"

#include <string.h>

enum { LINE_WIDTH = 80, NAME_WIDTH = 28 };

static const struct {
    int code;
    const char *text;
} exit_codes[] = {
    {0, "all is well"},
    {1, "internal error (please report it)"},
    {2, "wrong command line"},
    {3, "cannot read the input"},
    {4, "empty surface: the iso-value misses the data"},
    {5, "out of memory, or cannot write the output"},
    {6, "a check failed"},
    {7, "not built in"},
    {130, "interrupted by Ctrl-C; no unfinished file is left"},
};
enum { EXIT_CODE_COUNT = sizeof exit_codes / sizeof exit_codes[0] };

/* Prints words from column `column` on, each line starting at `indent`. */
static void print_wrapped(FILE *file, const char *text, int column, int indent) {
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (column > indent && column + 1 + length > LINE_WIDTH) {
            fprintf(file, "\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            fputc(' ', file);
            ++column;
        }
        fprintf(file, "%.*s", length, text);
        column += length;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', file);
}

static void print_option(FILE *file, const cli_option_row *row) {
    char name[96];
    int length = snprintf(name, sizeof name, "  %c%c%s--%s%s%s", row->letter ? '-' : ' ',
                          row->letter ? row->letter : ' ', row->letter ? ", " : "  ", row->name,
                          row->argument ? " " : "", row->argument ? row->argument : "");
    if (length >= NAME_WIDTH - 1)
        fprintf(file, "%s\n%*s", name, NAME_WIDTH, "");
    else
        fprintf(file, "%-*s", NAME_WIDTH, name);
    print_wrapped(file, row->help, NAME_WIDTH, NAME_WIDTH);
}

/* Calls for each section of a verb its title, for each option its row. */
static void each_option(FILE *file, cli_verb verb, void (*title)(FILE *, const char *),
                        void (*option)(FILE *, const cli_option_row *)) {
    const char *section = NULL, *printed = NULL;
    for (int i = 0; i < cli_option_count; ++i) {
        const cli_option_row *row = &cli_option_rows[i];
        section = row->section ? row->section : section;
        if (!(row->verbs & 1u << verb))
            continue;
        if (section != printed)
            title(file, section);
        printed = section;
        option(file, row);
    }
}

static void print_section(FILE *file, const char *section) {
    fprintf(file, "\n%s:\n", section);
}

/* Every line of `lines` behind an indent. */
static void print_lines(FILE *file, const char *lines, const char *indent) {
    while (*lines) {
        int length = (int)strcspn(lines, "\n");
        fprintf(file, "%s%.*s\n", indent, length, lines);
        lines += length + (lines[length] == '\n');
    }
}

void help_verb(FILE *file, cli_verb verb) {
    const cli_verb_row *row = &cli_verbs[verb];
    fprintf(file, "usage: quoin %s %s\n\n", row->name, row->synopsis);
    print_wrapped(file, row->summary, 0, 0);
    if (row->description) {
        fputc('\n', file);
        print_wrapped(file, row->description, 0, 0);
    }
    each_option(file, verb, print_section, print_option);
    fputs("\nExamples:\n", file);
    print_lines(file, row->examples, "  ");
}

void help_tool(FILE *file) {
    fprintf(file,
            "quoin %s: surfaces of volumes as clean meshes\n\n"
            "usage: quoin VERB INPUT -o OUTPUT [options]\n\n",
            qn_version());
    for (int verb = 0; verb < VERB_COUNT; ++verb) {
        fprintf(file, "  %-9s ", cli_verbs[verb].name);
        print_wrapped(file, cli_verbs[verb].summary, 12, 12);
    }
    fputs("\n'quoin help VERB' lists the options of a verb.\n\nExit codes:\n", file);
    for (int i = 0; i < EXIT_CODE_COUNT; ++i)
        fprintf(file, "  %3d  %s\n", exit_codes[i].code, exit_codes[i].text);
}

/* ---- the man page ---------------------------------------------------------------------------- */

/* Text with what roff would take as a command escaped. */
static void print_roff(FILE *file, const char *text) {
    for (const char *c = text; *c; ++c) {
        bool starts_line = c == text || c[-1] == '\n';
        if (starts_line && (*c == '.' || *c == '\''))
            fputs("\\&", file);
        if (*c == '\\')
            fputs("\\e", file);
        else if (*c == '-')
            fputs("\\-", file);
        else if (*c == '\'')
            fputs("\\(aq", file);
        else
            fputc(*c, file);
    }
}

static void man_section(FILE *file, const char *section) {
    fprintf(file, ".PP\n%s:\n", section);
}

static void man_option(FILE *file, const cli_option_row *row) {
    fputs(".TP\n", file);
    if (row->letter)
        fprintf(file, "\\fB\\-%c\\fR, ", row->letter);
    fputs("\\fB\\-\\-", file);
    print_roff(file, row->name);
    fputs("\\fR", file);
    if (row->argument) {
        fputs(" \\fI", file);
        print_roff(file, row->argument);
        fputs("\\fR", file);
    }
    fputc('\n', file);
    print_roff(file, row->help);
    fputc('\n', file);
}

static void man_verb(FILE *file, cli_verb verb) {
    const cli_verb_row *row = &cli_verbs[verb];
    fprintf(file, ".SS quoin %s ", row->name);
    print_roff(file, row->synopsis);
    fputc('\n', file);
    print_roff(file, row->summary);
    fputs(".\n", file);
    if (row->description)
        print_roff(file, row->description);
    fputc('\n', file);
    each_option(file, verb, man_section, man_option);
    fputs(".PP\nExamples:\n.PP\n.nf\n", file);
    print_roff(file, row->examples);
    fputs("\n.fi\n", file);
}

void help_man(FILE *file) {
    fprintf(file, ".TH QUOIN 1 \"\" \"quoin %s\" \"User Commands\"\n", qn_version());
    fputs(".SH NAME\nquoin \\- surfaces of volumes as clean meshes\n.SH SYNOPSIS\n", file);
    fputs(".B quoin\n.I VERB INPUT\n.B \\-o\n.I OUTPUT\n[options]\n.SH DESCRIPTION\n", file);
    print_roff(file,
               "Turns volumes (CT, MRI, distance fields) into quad or triangle meshes in world "
               "coordinates. All talk goes to stderr; stdout carries only what was asked for. "
               "Files appear whole or not at all. The result is the same for any number of "
               "threads.");
    fputs("\n.SH VERBS\n", file);
    for (int verb = 0; verb < VERB_COUNT; ++verb)
        man_verb(file, (cli_verb)verb);
    fputs(".SH EXIT STATUS\n", file);
    for (int i = 0; i < EXIT_CODE_COUNT; ++i)
        fprintf(file, ".TP\n.B %d\n%s\n", exit_codes[i].code, exit_codes[i].text);
}

/* ---- bash ------------------------------------------------------------------------------------ */

void help_completion(FILE *file) {
    fputs("# bash completion for quoin; made by 'quoin help --completion'\n"
          "_quoin() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} verb=${COMP_WORDS[1]} options=\n"
          "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
          "        COMPREPLY=($(compgen -W \"",
          file);
    for (int verb = 0; verb < VERB_COUNT; ++verb)
        fprintf(file, "%s%s", verb ? " " : "", cli_verbs[verb].name);
    fputs("\" -- \"$word\"))\n        return\n    fi\n    case $verb in\n", file);
    for (int verb = 0; verb < VERB_COUNT; ++verb) {
        fprintf(file, "    %s) options=\"", cli_verbs[verb].name);
        const char *space = "";
        for (int i = 0; i < cli_option_count; ++i)
            if (cli_option_rows[i].verbs & 1u << verb) {
                fprintf(file, "%s--%s", space, cli_option_rows[i].name);
                space = " ";
            }
        fputs("\" ;;\n", file);
    }
    fputs("    esac\n"
          "    case $word in\n"
          "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
          "    *) COMPREPLY=($(compgen -f -- \"$word\")) ;;\n"
          "    esac\n"
          "}\n"
          "complete -o filenames -F _quoin quoin\n",
          file);
}
