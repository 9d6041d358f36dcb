// SPDX-License-Identifier: MIT
/* Seeds, random numbers, the data folder, hashes and contexts for the tests. */
#include "lib/support.h"

#include <math.h>

uint64_t test_random_bits(test_random *random) {
    uint64_t z = random->state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

double test_random_unit(test_random *random) {
    return (double)(test_random_bits(random) >> 11) * 0x1p-53;
}

double test_random_gaussian(test_random *random) {
    double radius = sqrt(-2 * log(1 - test_random_unit(random)));
    return radius * cos(2 * 3.14159265358979323846 * test_random_unit(random));
}

int64_t test_random_range(test_random *random, int64_t low, int64_t high) {
    return low + (int64_t)(test_random_bits(random) % (uint64_t)(high - low + 1));
}

uint64_t test_seed(void) {
    const char *text = getenv("QUOIN_SEED");
    uint64_t seed = text && *text ? strtoull(text, NULL, 0) : 20240607;
    printf("seed: QUOIN_SEED=%llu\n", (unsigned long long)seed);
    return seed;
}

bool test_is_long(void) {
    const char *text = getenv("QUOIN_LONG");
    return text && *text && strcmp(text, "0") != 0;
}

int64_t test_count(int64_t short_count, int64_t long_count) {
    return test_is_long() ? long_count : short_count;
}

bool test_data_path(const char *name, char *path, size_t capacity) {
    const char *folder = getenv("QUOIN_DATA");
    if (folder && *folder)
        snprintf(path, capacity, "%s/%s", folder, name);
    else
        snprintf(path, capacity, "%s/../shared/data/%s", TEST_SOURCE_ROOT, name);
    FILE *file = fopen(path, "rb");
    if (file)
        fclose(file);
    else
        printf("skipped: no file %s (QUOIN_DATA names the data folder)\n", path);
    return file != NULL;
}

uint64_t test_hash(uint64_t hash, const void *bytes, size_t count) {
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < count; ++i)
        hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}

uint64_t test_hash_mesh(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    const int64_t counts[3] = {view.vertex_count, view.quad_count, view.triangle_count};
    uint64_t hash = test_hash(TEST_HASH_START, counts, sizeof counts);
    if (view.positions)
        hash = test_hash(hash, view.positions, (size_t)view.vertex_count * 3 * sizeof(float));
    if (view.normals)
        hash = test_hash(hash, view.normals, (size_t)view.vertex_count * 3 * sizeof(float));
    if (view.quads)
        hash = test_hash(hash, view.quads, (size_t)view.quad_count * 4 * sizeof(uint32_t));
    if (view.triangles)
        hash = test_hash(hash, view.triangles, (size_t)view.triangle_count * 3 * sizeof(uint32_t));
    return hash;
}

qn_context *test_context(int32_t threads) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = threads;
    qn_context *context;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    return context;
}

void test_context_end(qn_context *context) {
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_destroy(context);
}

void *test_alloc(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    assert_non_null(memory);
    return memory;
}
