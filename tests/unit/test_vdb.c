// SPDX-License-Identifier: MIT
/* OpenVDB files: what is written comes back, the files of the data folder are read as their README
 * says, and what cannot be read is refused by name. */
#include "lib/random_sparse.h"
#include "lib/scratch.h"
#include "qni_config.h"
#include "volume/field.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#if QNI_HAVE_OPENVDB

#include "volume/sparse.h"

static test_scratch scratch;

static int make_scratch(void **state) {
    (void)state;
    test_scratch_make(&scratch);
    return 0;
}

static int remove_scratch(void **state) {
    (void)state;
    test_scratch_remove(&scratch);
    return 0;
}

static qn_volume *read_volume(qn_context *context, const char *path, const char *grid) {
    qn_volume_read_options options;
    qn_volume *volume;
    qn_error error;
    qn_volume_read_options_init(&options);
    snprintf(options.grid, sizeof options.grid, "%s", grid);
    if (qn_volume_read(context, path, &options, &volume, &error) != QN_OK)
        fail_msg("%s", error.message);
    return volume;
}

static void expect_refusal(const char *path, const char *grid, qn_status status,
                           const char *words) {
    qn_context *context = test_context(1);
    qn_volume_read_options options;
    qn_volume *volume;
    qn_error error;
    qn_volume_read_options_init(&options);
    snprintf(options.grid, sizeof options.grid, "%s", grid);
    assert_int_equal(qn_volume_read(context, path, &options, &volume, &error), status);
    assert_null(volume);
    if (!strstr(error.message, words))
        fail_msg("'%s' does not say '%s'", error.message, words);
    test_context_end(context);
}

/* All values of the box and one block round it. */
static void expect_same_values(const test_sparse *sparse, const qn_volume *volume) {
    qni_field field;
    assert_int_equal(qni_field_init(volume, 0, true, false, &field, NULL), QN_OK);
    const qni_sparse *found = volume->sparse;
    for (int64_t k = 8 * (sparse->low[2] - 1); k < 8 * (sparse->high[2] + 1); ++k)
        for (int64_t j = 8 * (sparse->low[1] - 1); j < 8 * (sparse->high[1] + 1); ++j)
            for (int64_t i = 8 * (sparse->low[0] - 1); i < 8 * (sparse->high[0] + 1); ++i) {
                const double value =
                    qni_field_value(&field, i - 8 * found->first_block[0],
                                    j - 8 * found->first_block[1], k - 8 * found->first_block[2]);
                assert_true(value == test_sparse_value(sparse, i, j, k));
            }
}

static void what_is_written_comes_back(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    for (int64_t i = 0; i < test_count(12, 200); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_sparse sparse = test_random_sparse(&random, TEST_GAUSSIAN, QN_F32, 4);
        const double matrix[4][4] = {
            {0.5, 0.125, 0, -3}, {0, -0.75, 0.25, 11}, {0.25, 0, 1, 0.25}, {0, 0, 0, 1}};
        if (i % 2)
            memcpy(sparse.grid.index_to_world, matrix, sizeof matrix);
        sparse.grid.kind = i % 3 ? QN_SPARSE_FOG : QN_SPARSE_LEVEL_SET;
        sparse.grid.background = -1.5; /* no gap is filled */
        snprintf(sparse.grid.name, sizeof sparse.grid.name, "grid %d", (int)i);
        qn_context *context = test_context(2);
        qn_volume *volume, *again;
        qn_error error;
        qn_sparse_info info[2];
        const char *path = test_scratch_path(&scratch, "round.vdb");
        assert_int_equal(qn_volume_create_sparse(context, &sparse.grid, NULL, NULL, &volume, NULL),
                         QN_OK);
        if (qn_volume_write(context, volume, path, &error) != QN_OK)
            fail_msg("%s", error.message);
        again = read_volume(context, path, "");
        expect_same_values(&sparse, again);
        const qn_sparse_grid *grid = qn_volume_sparse_grid(again);
        assert_int_equal(grid->kind, sparse.grid.kind);
        assert_string_equal(grid->name, sparse.grid.name);
        assert_true(grid->background == sparse.grid.background);
        assert_memory_equal(grid->index_to_world, qn_volume_sparse_grid(volume)->index_to_world,
                            sizeof matrix);
        qn_volume_sparse_info(context, volume, info, NULL);
        qn_volume_sparse_info(context, again, info + 1, NULL);
        assert_int_equal(info[0].active_count, info[1].active_count);
        qn_volume_destroy(volume);
        qn_volume_destroy(again);
        test_context_end(context);
        test_sparse_free(&sparse);
    }
}

static void dense_files_hold_the_box(void **state) {
    (void)state;
    test_random random = {5};
    test_sparse sparse = test_random_sparse(&random, TEST_GAUSSIAN, QN_F32, 3);
    static const char *const names[] = {"box.npy", "box.nii"};
    for (int n = 0; n < 2; ++n) {
        qn_context *context = test_context(1);
        qn_volume *volume, *again;
        qn_error error;
        const char *path = test_scratch_path(&scratch, names[n]);
        assert_int_equal(qn_volume_create_sparse(context, &sparse.grid, NULL, NULL, &volume, NULL),
                         QN_OK);
        if (qn_volume_write(context, volume, path, &error) != QN_OK)
            fail_msg("%s", error.message);
        if (n == 1 && !QNI_HAVE_NIFTI) {
            qn_volume_destroy(volume);
            test_context_end(context);
            continue;
        }
        again = read_volume(context, path, "");
        const qn_grid *box = qn_volume_grid(again);
        for (int a = 0; a < 3; ++a)
            assert_int_equal(box->size[a], qn_volume_grid(volume)->size[a]);
        for (int64_t k = 0; k < box->size[2]; ++k)
            for (int64_t j = 0; j < box->size[1]; ++j)
                for (int64_t i = 0; i < box->size[0]; ++i)
                    assert_true(qni_grid_value(box, i, j, k) ==
                                test_sparse_value(&sparse, i + 8 * sparse.low[0],
                                                  j + 8 * sparse.low[1], k + 8 * sparse.low[2]));
        for (int a = 0; n == 1 && a < 3; ++a)
            assert_true(box->index_to_world[a][3] == (double)(8 * sparse.low[a]));
        qn_volume_destroy(volume);
        qn_volume_destroy(again);
        test_context_end(context);
    }
    test_sparse_free(&sparse);
}

static void data_files_are_what_their_readme_says(void **state) {
    (void)state;
    static const struct {
        const char *file, *name;
        qn_sparse_class kind;
        int64_t active;
        double voxel;
    } files[] = {
        {"vdb/armadillo_ls.vdb", "ls_armadillo", QN_SPARSE_LEVEL_SET, 1214003, 0.002857},
        {"vdb/arnold_torus01.vdb", "voxel_fog_density", QN_SPARSE_FOG, 2450, 0.4032},
        {"vdb/cube.vdb", "ls_cube", QN_SPARSE_LEVEL_SET, 1452218, 0.05},
        {"vdb/rocker-arm_ls.vdb", "ls_rocker-arm", QN_SPARSE_LEVEL_SET, 699584, 0.003333},
        {"vdb/smoke.vdb", "density", QN_SPARSE_FOG, 1049275, 0.4762},
        {"vdb/sphere.vdb", "ls_sphere", QN_SPARSE_LEVEL_SET, 270638, 0.05},
#if QNI_HAVE_NANOVDB && QNI_HAVE_BLOSC
        {"vdb/smoke-blosc.nvdb", "", QN_SPARSE_UNKNOWN, 1049275, 1},
#endif
    };
    for (size_t n = 0; n < sizeof files / sizeof files[0]; ++n) {
        char path[1024];
        if (!test_data_path(files[n].file, path, sizeof path))
            continue;
        qn_context *context = test_context(2);
        qn_volume *volume = read_volume(context, path, files[n].name);
        const qn_sparse_grid *grid = qn_volume_sparse_grid(volume);
        qn_sparse_info info;
        assert_non_null(grid);
        assert_string_equal(grid->name, files[n].name);
        assert_int_equal(grid->kind, files[n].kind);
        qn_volume_sparse_info(context, volume, &info, NULL);
        assert_int_equal(info.active_count, files[n].active);
        assert_int_equal(info.filled_blocks, 0);
        assert_true(fabs(grid->index_to_world[0][0] / files[n].voxel - 1) < 1e-3);
        qn_volume_destroy(volume);
        test_context_end(context);
    }
}

static void what_cannot_be_read_is_refused_by_name(void **state) {
    (void)state;
    char path[1024];
    if (test_data_path("vdb/oiio_sphereCd.vdb", path, sizeof path)) {
        qn_context *context = test_context(1);
        qn_grid_info info;
        int32_t count;
        expect_refusal(path, "", QN_ERROR_INPUT, "'Cd' holds vectors");
        expect_refusal(path, "density", QN_ERROR_INVALID_ARGUMENT, "it has: Cd (vec3s)");
        assert_int_equal(qn_volume_list_grids(context, path, &info, 1, &count, NULL), QN_OK);
        assert_int_equal(count, 1);
        assert_string_equal(info.name, "Cd");
        assert_false(info.readable);
        test_context_end(context);
    }
    const char *cut = test_scratch_path(&scratch, "short.vdb");
    test_put_file(cut, " BDV\0\0\0\0\xe0", 9);
    expect_refusal(cut, "", QN_ERROR_INPUT, "short.vdb");
}

static int count_descriptors(void) {
    int count = 0;
    for (int n = 0; n < 256; ++n)
        count += fcntl(n, F_GETFD) >= 0;
    return count;
}

static int cancel(void *user, const char *stage, double fraction) {
    (void)user;
    (void)stage;
    (void)fraction;
    return 1;
}

/* A good file of one grid, written into the scratch folder. */
static const char *write_one(const char *name) {
    test_random random = {7};
    test_sparse sparse = test_random_sparse(&random, TEST_GAUSSIAN, QN_F32, 4);
    qn_context *context = test_context(1);
    const char *path = test_scratch_path(&scratch, name);
    qn_volume *volume;
    assert_int_equal(qn_volume_create_sparse(context, &sparse.grid, NULL, NULL, &volume, NULL),
                     QN_OK);
    assert_int_equal(qn_volume_write(context, volume, path, NULL), QN_OK);
    qn_volume_destroy(volume);
    test_context_end(context);
    test_sparse_free(&sparse);
    return path;
}

/* Two leaves at the ends of a large box: legal, and gigabytes of nothing as a dense file. */
static void an_empty_box_is_not_written_densely(void **state) {
    (void)state;
    static float values[2][512];
    const int32_t origins[2][3] = {{0, 0, 0}, {896, 896, 896}};
    const qn_sparse_grid grid = {
        .scalar = QN_F32, .leaf_count = 2, .origins = origins, .values = values, .background = 1};
    qn_context *context = test_context(1);
    qn_volume *volume;
    qn_error error;
    assert_int_equal(qn_volume_create_sparse(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    const char *path = test_scratch_path(&scratch, "large.npy");
    assert_int_equal(qn_volume_write(context, volume, path, &error), QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "904 x 904 x 904 samples"));
    assert_non_null(strstr(error.message, "3.0 GB"));
    struct stat status;
    assert_int_not_equal(stat(path, &status), 0);
    qn_volume_destroy(volume);
    test_context_end(context);
}

static void a_file_that_is_cut_short_is_refused(void **state) {
    (void)state;
    struct stat status;
    const char *path = write_one("cut.vdb");
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(truncate(path, status.st_size - 40), 0);
    expect_refusal(path, "", QN_ERROR_INPUT, "cut short");
}

/* The program is missing, is no such program, dies, is silent and cancelled: one sentence each, no
 * child and no descriptor left. */
static void a_reader_that_fails_leaves_nothing(void **state) {
    (void)state;
    const char *program = getenv("QUOIN_VDB_PROGRAM");
    char *kept = program ? strdup(program) : NULL;
    const char *path = write_one("one.vdb");
    const int before = count_descriptors();
    setenv("QUOIN_VDB_PROGRAM", "/nowhere/quoin-vdb", 1);
    expect_refusal(path, "", QN_ERROR_UNSUPPORTED, "/nowhere/quoin-vdb");
    setenv("QUOIN_VDB_PROGRAM", "/bin/true", 1);
    expect_refusal(path, "", QN_ERROR_INPUT, "the reader stopped");
    qn_context_options options;
    qn_context *context;
    qn_volume *volume;
    qn_error error;
    qn_context_options_init(&options);
    options.progress = cancel;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    setenv("QUOIN_VDB_PROGRAM", "/bin/cat", 1); /* waits for more input than it gets */
    assert_int_equal(qn_volume_read(context, path, NULL, &volume, &error), QN_ERROR_CANCELLED);
    assert_null(volume);
    qn_context_destroy(context);
    if (kept)
        setenv("QUOIN_VDB_PROGRAM", kept, 1);
    else
        unsetenv("QUOIN_VDB_PROGRAM");
    free(kept);
    assert_int_equal(count_descriptors(), before);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_comes_back),
        cmocka_unit_test(dense_files_hold_the_box),
        cmocka_unit_test(data_files_are_what_their_readme_says),
        cmocka_unit_test(what_cannot_be_read_is_refused_by_name),
        cmocka_unit_test(an_empty_box_is_not_written_densely),
        cmocka_unit_test(a_file_that_is_cut_short_is_refused),
        cmocka_unit_test(a_reader_that_fails_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, make_scratch, remove_scratch);
}

#else

int main(void) {
    printf("skipped: built without OpenVDB\n");
    return 77;
}

#endif
