// SPDX-License-Identifier: MIT
/* Runs a fuzz target over every file of the folders given: the corpus as a common test. */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int replay_file(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file)
        return 1;
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    rewind(file);
    /* A block of exactly the file's size, so that a read beyond it is seen by the sanitizer. */
    uint8_t *data = size >= 0 ? malloc(size ? (size_t)size : 1) : NULL;
    int failed = !data || fread(data, 1, (size_t)size, file) != (size_t)size;
    fclose(file);
    if (!failed)
        LLVMFuzzerTestOneInput(data, (size_t)size);
    free(data);
    return failed;
}

static int replay_folder(const char *folder, int *count) {
    DIR *entries = opendir(folder);
    if (!entries) {
        fprintf(stderr, "no folder %s\n", folder);
        return 1;
    }
    int failed = 0;
    for (struct dirent *entry; (entry = readdir(entries));) {
        char path[4096];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (replay_file(path)) {
            fprintf(stderr, "cannot read %s\n", path);
            failed = 1;
        }
        ++*count;
    }
    closedir(entries);
    return failed;
}

int main(int argument_count, char **arguments) {
    int count = 0, failed = argument_count < 2;
    for (int a = 1; a < argument_count; ++a)
        failed |= replay_folder(arguments[a], &count);
    printf("%d files replayed\n", count);
    return failed || count == 0;
}
