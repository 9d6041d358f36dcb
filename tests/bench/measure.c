// SPDX-License-Identifier: MIT
/* Clocks, resident memory, and where and of what a measurement was made. */
#include "bench/measure.h"

#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static double seconds_of(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

bench_time bench_now(void) {
    const bench_time now = {seconds_of(CLOCK_MONOTONIC), seconds_of(CLOCK_PROCESS_CPUTIME_ID)};
    return now;
}

bench_time bench_since(bench_time start) {
    const bench_time now = bench_now(), passed = {now.wall - start.wall, now.cpu - start.cpu};
    return passed;
}

bool bench_run_apart(void (*work)(const void *job, void *result), const void *job, void *result,
                     size_t size) {
    int ends[2];
    if (pipe(ends) != 0)
        return false;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        work(job, result);
        _exit(write(ends[1], result, size) == (ssize_t)size ? 0 : 1);
    }
    close(ends[1]);
    const bool good = child > 0 && read(ends[0], result, size) == (ssize_t)size;
    close(ends[0]);
    if (child > 0)
        waitpid(child, NULL, 0);
    return good;
}

/* The first line of a file or a command's output that starts with `key`, after it and what
 * separates them. */
static void find_line(FILE *file, const char *key, char *text, size_t capacity) {
    char line[512];
    text[0] = 0;
    while (file && fgets(line, sizeof line, file)) {
        if (strncmp(line, key, strlen(key)) != 0)
            continue;
        const char *from = line + strlen(key);
        from += strspn(from, " \t:");
        snprintf(text, capacity, "%.*s", (int)strcspn(from, "\n"), from);
        return;
    }
}

static int64_t status_bytes(const char *key) {
    char text[64];
    long long kibibytes = 0;
    FILE *file = fopen("/proc/self/status", "r");
    find_line(file, key, text, sizeof text);
    if (file)
        fclose(file);
    return sscanf(text, "%lld", &kibibytes) == 1 ? kibibytes * 1024 : 0;
}

int64_t bench_resident(void) {
    return status_bytes("VmRSS:");
}

int64_t bench_peak_resident(void) {
    return status_bytes("VmHWM:");
}

void bench_reset_peak_resident(void) {
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file)
        return;
    fputs("5", file);
    fclose(file);
}

const char *bench_processor(void) {
    static char name[128];
    FILE *file = fopen("/proc/cpuinfo", "r");
    find_line(file, "model name", name, sizeof name);
    if (file)
        fclose(file);
    return name[0] ? name : "unknown processor";
}

const char *bench_compiler(void) {
#if defined(__clang__)
    return "clang " __clang_version__;
#else
    return "gcc " __VERSION__;
#endif
}

const char *bench_commit(void) {
    static char commit[128];
    FILE *file = popen("git -C '" TEST_SOURCE_ROOT "' describe --always --dirty 2>/dev/null", "r");
    find_line(file, "", commit, sizeof commit);
    if (file)
        pclose(file);
    return commit;
}
