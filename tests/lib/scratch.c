// SPDX-License-Identifier: MIT
/* A folder of a test's own, and whole files in it. */
#include "lib/scratch.h"
#include "lib/support.h"

#include <dirent.h>
#include <unistd.h>

void test_scratch_make(test_scratch *scratch) {
    const char *base = getenv("TMPDIR");
    snprintf(scratch->folder, sizeof scratch->folder, "%s/quoin-test-XXXXXX",
             base && *base ? base : "/tmp");
    assert_non_null(mkdtemp(scratch->folder));
}

const char *test_scratch_path(const test_scratch *scratch, const char *name) {
    static char paths[8][512];
    static int next;
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", scratch->folder, name);
    return path;
}

static int for_each_file(const test_scratch *scratch, bool remove_them) {
    DIR *folder = opendir(scratch->folder);
    assert_non_null(folder);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(folder));) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
            continue;
        ++count;
        const char *path = test_scratch_path(scratch, entry->d_name);
        if (remove_them && unlink(path) != 0)
            rmdir(path);
    }
    closedir(folder);
    return count;
}

int test_scratch_count(const test_scratch *scratch) {
    return for_each_file(scratch, false);
}

void test_scratch_remove(test_scratch *scratch) {
    for_each_file(scratch, true);
    assert_int_equal(rmdir(scratch->folder), 0);
}

void test_put_file(const char *path, const void *bytes, size_t size) {
    unlink(path); /* cutting a file off and writing it anew makes some file systems wait for the
                     disk */
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

char *test_get_file(const char *path, size_t *size_out) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = 0, capacity = 1 << 16;
    char *bytes = malloc(capacity + 1);
    assert_non_null(bytes);
    for (size_t taken; (taken = fread(bytes + size, 1, capacity - size, file)) > 0;) {
        size += taken;
        if (size == capacity) {
            bytes = realloc(bytes, (capacity *= 2) + 1);
            assert_non_null(bytes);
        }
    }
    fclose(file);
    bytes[size] = 0;
    *size_out = size;
    return bytes;
}
