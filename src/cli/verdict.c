// SPDX-License-Identifier: MIT
/* What is wrong with a mesh, by one table of faults. */
#include "verdict.h"
#include "number.h"
#include "session.h"

#include <stdio.h>
#include <string.h>

static const struct {
    uint32_t fault;
    const char *name, *singular, *plural;
} rows[] = {
    {FAULT_OPEN, "open", "boundary edge", "boundary edges"},
    {FAULT_NONMANIFOLD, "nonmanifold", "non-manifold edge or vertex",
     "non-manifold edges and vertices"},
    {FAULT_ORIENTATION, "orientation", "orientation conflict", "orientation conflicts"},
    {FAULT_INTERSECT, "intersect", "self-intersection", "self-intersections"},
    {FAULT_DEGENERATE, "degenerate", "degenerate face", "degenerate faces"},
    {FAULT_DUPLICATE, "duplicate", "duplicate face", "duplicate faces"},
    {FAULT_NONFINITE, "nonfinite", "vertex that is not finite", "vertices that are not finite"},
};
enum { ROW_COUNT = sizeof rows / sizeof rows[0] };

static uint32_t find_fault(const char *name, size_t length) {
    if (length == 3 && strncmp(name, "all", 3) == 0)
        return FAULT_ALL;
    for (int i = 0; i < ROW_COUNT; ++i)
        if (strlen(rows[i].name) == length && strncmp(rows[i].name, name, length) == 0)
            return rows[i].fault;
    return 0;
}

bool verdict_parse_faults(const char *text, uint32_t *faults_out) {
    *faults_out = 0;
    if (strcmp(text, "none") == 0)
        return true;
    for (const char *name = text;; ++name) {
        size_t length = strcspn(name, ",");
        uint32_t fault = find_fault(name, length);
        if (!fault) {
            cli_say("--fail-on %s: '%.*s' is no fault; they are open, nonmanifold, orientation, "
                    "intersect, degenerate, duplicate, nonfinite; or all, or none",
                    text, (int)length, name);
            return false;
        }
        *faults_out |= fault;
        name += length;
        if (!*name)
            return true;
    }
}

int64_t verdict_count(const qn_mesh_report *report, uint32_t fault) {
    switch (fault) {
    case FAULT_OPEN:
        return report->boundary_edges;
    case FAULT_NONMANIFOLD:
        return report->nonmanifold_edges + report->nonmanifold_vertices;
    case FAULT_ORIENTATION:
        return report->orientation_conflicts;
    case FAULT_INTERSECT:
        return report->self_intersections > 0 ? report->self_intersections : 0;
    case FAULT_DEGENERATE:
        return report->degenerate_faces;
    case FAULT_DUPLICATE:
        return report->duplicate_faces;
    case FAULT_NONFINITE:
        return report->nonfinite_vertices;
    }
    return 0;
}

uint32_t verdict_faults(const qn_mesh_report *report) {
    uint32_t faults = 0;
    for (int i = 0; i < ROW_COUNT; ++i)
        if (verdict_count(report, rows[i].fault) > 0)
            faults |= rows[i].fault;
    return faults;
}

const char *verdict_name(uint32_t fault) {
    for (int i = 0; i < ROW_COUNT; ++i)
        if (rows[i].fault == fault)
            return rows[i].name;
    return "";
}

const char *verdict_describe(const qn_mesh_report *report, uint32_t faults,
                             char text[VERDICT_TEXT_SIZE]) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < ROW_COUNT; ++i) {
        int64_t count = verdict_count(report, rows[i].fault);
        if (!(faults & rows[i].fault) || count == 0 || used >= VERDICT_TEXT_SIZE)
            continue;
        char number[NUMBER_TEXT_SIZE];
        int written = snprintf(text + used, VERDICT_TEXT_SIZE - used, "%s%s %s", used ? ", " : "",
                               number_format_count(count, number),
                               count == 1 ? rows[i].singular : rows[i].plural);
        used += written > 0 ? (size_t)written : 0;
    }
    return text;
}
