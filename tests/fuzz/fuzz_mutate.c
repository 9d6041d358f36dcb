// SPDX-License-Identifier: MIT
/* Runs a fuzz target over damaged copies of every file of a folder: cut short, single bits flipped,
 * bytes and numbers overwritten. The damage follows from QUOIN_SEED and is the same everywhere;
 * QUOIN_LONG=1 tries 2,500 copies of the folder's files in all, else 150 or the number given. Peak
 * memory is watched, that of processes started too, and the longest time of a copy. */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <zlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MOST_FILES = 64, LARGEST_FILE = 1 << 20, MOST_MEMORY_KB = 3 << 20 };

typedef struct file {
    uint8_t *bytes;
    size_t size;
} file;

static uint64_t next(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* The whole file, unpacked when it is a gzip file. */
static int load(const char *path, file *to) {
    gzFile from = gzopen(path, "rb");
    to->bytes = malloc(LARGEST_FILE);
    const int size = from && to->bytes ? gzread(from, to->bytes, LARGEST_FILE) : -1;
    if (from)
        gzclose(from);
    to->size = size > 0 ? (size_t)size : 0;
    return size > 0;
}

static int load_folder(const char *folder, file files[MOST_FILES]) {
    char *names[MOST_FILES];
    int count = 0, loaded = 0;
    DIR *entries = opendir(folder);
    for (struct dirent *entry; entries && (entry = readdir(entries));)
        if (entry->d_name[0] != '.' && count < MOST_FILES)
            names[count++] = strdup(entry->d_name);
    if (entries)
        closedir(entries);
    qsort(names, (size_t)count, sizeof *names, compare_names);
    for (int n = 0; n < count; ++n) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, names[n]);
        loaded += load(path, files + loaded);
        free(names[n]);
    }
    return loaded;
}

/* Damage is done near the beginning more often than not: there the headers are. */
static size_t place(uint64_t *random, size_t size) {
    const size_t reach = next(random) % 3 == 0 ? size : size < 2048 ? size : 2048;
    return (size_t)(next(random) % reach);
}

static size_t damage(uint64_t *random, uint8_t *bytes, size_t size) {
    static const uint64_t numbers[] = {0,
                                       1,
                                       0x7f,
                                       0xff,
                                       0xffff,
                                       0x7fffffff,
                                       0xffffffff,
                                       UINT64_C(0x7fffffffffffffff),
                                       UINT64_C(0xffffffffffffffff)};
    const int times = 1 + (int)(next(random) % 4);
    for (int n = 0; n < times; ++n) {
        const size_t at = place(random, size), width = (size_t)1 << next(random) % 4;
        switch (next(random) % 4) {
        case 0:
            bytes[at] ^= (uint8_t)(1u << next(random) % 8);
            break;
        case 1:
            bytes[at] = (uint8_t)next(random);
            break;
        case 2:
            if (at + width <= size)
                memcpy(bytes + at, numbers + next(random) % 9, width);
            break;
        default:
            if (n == 0 && next(random) % 2)
                return place(random, size);
            bytes[at] ^= 0x80;
        }
    }
    return size;
}

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int main(int argument_count, char **arguments) {
    file files[MOST_FILES];
    const char *seed_text = getenv("QUOIN_SEED"), *long_text = getenv("QUOIN_LONG");
    const char *from_text = getenv("QUOIN_FROM");
    const uint64_t seed = seed_text ? strtoull(seed_text, NULL, 10) : 1;
    const long total = long_text && *long_text == '1' ? 2500
                       : argument_count > 2           ? atol(arguments[2])
                                                      : 150;
    const int count = argument_count > 1 ? load_folder(arguments[1], files) : 0;
    struct rusage use, started;
    double longest = 0;
    if (count == 0)
        return 1;
    printf("seed: QUOIN_SEED=%llu\n", (unsigned long long)seed);
    for (long n = from_text ? atol(from_text) : 0; n < total; ++n) {
        uint64_t random = seed * 1000003 + (uint64_t)n;
        const file *from = files + n % count;
        uint8_t *copy = malloc(from->size);
        if (!copy)
            return 1;
        memcpy(copy, from->bytes, from->size);
        const size_t size = damage(&random, copy, from->size);
        uint8_t *exact = malloc(size ? size : 1); /* reads beyond the end are seen */
        if (!exact)
            return 1;
        memcpy(exact, copy, size);
        fprintf(stderr, "\rcopy %ld ", n); /* the last one named is the one that broke it */
        const double before = seconds();
        LLVMFuzzerTestOneInput(exact, size);
        longest = seconds() - before > longest ? seconds() - before : longest;
        free(exact);
        free(copy);
    }
    getrusage(RUSAGE_SELF, &use);
    getrusage(RUSAGE_CHILDREN, &started);
    printf("%ld damaged files, peak memory %ld MB, of processes started %ld MB, longest %.2f s\n",
           total, use.ru_maxrss >> 10, started.ru_maxrss >> 10, longest);
    for (int n = 0; n < count; ++n)
        free(files[n].bytes);
    return use.ru_maxrss > MOST_MEMORY_KB || started.ru_maxrss > MOST_MEMORY_KB;
}
