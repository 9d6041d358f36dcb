// SPDX-License-Identifier: MIT
/* Files appear whole or not at all: every way to fail leaves nothing behind and keeps what was
 * there. */
#include "core/file.h"
#include "lib/failing.h"
#include "lib/scratch.h"
#include "lib/support.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

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

static void assert_content(const char *path, const char *text) {
    size_t size;
    char *bytes = test_get_file(path, &size);
    assert_int_equal(size, strlen(text));
    assert_string_equal(bytes, text);
    free(bytes);
}

static void a_file_is_written_and_replaced(void **state) {
    (void)state;
    const char *path = test_scratch_path(&scratch, "a.txt");
    assert_int_equal(qn_write_file(path, "first", 5, NULL), QN_OK);
    assert_content(path, "first");
    assert_int_equal(chmod(path, 0640), 0);
    assert_int_equal(qn_write_file(path, "second", 6, NULL), QN_OK);
    assert_content(path, "second");
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
    assert_int_equal(qn_write_file(path, NULL, 0, NULL), QN_OK);
    assert_content(path, "");
    assert_int_equal(test_scratch_count(&scratch), 1);
}

static void a_new_file_s_rights_follow_the_umask(void **state) {
    (void)state;
    mode_t old = umask(027);
    const char *path = test_scratch_path(&scratch, "a.txt");
    assert_int_equal(qn_write_file(path, "x", 1, NULL), QN_OK);
    umask(old);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
}

static void a_link_stays_a_link(void **state) {
    (void)state;
    const char *path = test_scratch_path(&scratch, "a.txt");
    const char *link = test_scratch_path(&scratch, "link");
    test_put_file(path, "old", 3);
    assert_int_equal(symlink("a.txt", link), 0);
    assert_int_equal(qn_write_file(link, "new", 3, NULL), QN_OK);
    struct stat info;
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    assert_content(path, "new");
}

static void assert_refused(const char *path, const char *words) {
    qn_error error = {0};
    assert_int_equal(qn_write_file(path, "x", 1, &error), QN_ERROR_OUTPUT);
    assert_int_equal(error.status, QN_ERROR_OUTPUT);
    if (!strstr(error.message, words))
        fail_msg("'%s' does not say '%s'", error.message, words);
}

static void wrong_places_are_named(void **state) {
    (void)state;
    assert_refused(test_scratch_path(&scratch, "none/a.txt"), "make the folder first");
    assert_refused(scratch.folder, "that is a folder");
    assert_refused("", "cannot write");
    char path[8192];
    memset(path, 'a', sizeof path);
    path[sizeof path - 1] = 0;
    assert_refused(path, "shorter");
    assert_int_equal(test_scratch_count(&scratch), 0);
}

static void a_file_that_may_not_be_written_is_kept(void **state) {
    (void)state;
    if (geteuid() == 0) {
        printf("skipped: root may write everything\n");
        return;
    }
    const char *path = test_scratch_path(&scratch, "a.txt");
    test_put_file(path, "old", 3);
    assert_int_equal(chmod(path, 0444), 0);
    assert_refused(path, "right to write");
    assert_content(path, "old");
}

static void special_files_are_written_directly(void **state) {
    (void)state;
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    char path[64];
    snprintf(path, sizeof path, "/dev/fd/%d", ends[1]);
    assert_int_equal(qn_write_file(path, "through", 7, NULL), QN_OK);
    char bytes[16];
    assert_int_equal(read(ends[0], bytes, sizeof bytes), 7);
    assert_memory_equal(bytes, "through", 7);
    close(ends[0]);
    close(ends[1]);
    if (access("/dev/full", W_OK) != 0)
        printf("skipped: no /dev/full\n");
    else
        assert_refused("/dev/full", "make room");
}

/* As on a full disk: the system takes the first 100,000 bytes and no more. */
static void write_beyond_limit(const char *path, qn_error *error) {
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 100000;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    qn_context *context = test_context(1);
    qni_output output;
    qn_status status = qni_output_open(&output, context, path, error);
    for (int i = 0; status == QN_OK && i < 100000; ++i)
        qni_output_write(&output, "0123456789abcdef0123456789abcdef", 32);
    bool stopped = status == QN_OK && qni_output_stopped(&output, 1);
    if (status == QN_OK)
        status = qni_output_commit(&output, error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_true(stopped);
    assert_int_equal(status, QN_ERROR_OUTPUT);
    test_context_end(context);
}

static void failing_midway_leaves_nothing(void **state) {
    (void)state;
    qn_error error = {0};
    const char *path = test_scratch_path(&scratch, "a.txt");
    write_beyond_limit(path, &error);
    assert_non_null(strstr(error.message, "limit for a file's size"));
    assert_int_equal(test_scratch_count(&scratch), 0);
    test_put_file(path, "old", 3);
    write_beyond_limit(path, &error);
    assert_content(path, "old");
    assert_int_equal(test_scratch_count(&scratch), 1);
}

static void cancelling_leaves_nothing(void **state) {
    (void)state;
    test_failing failing = {-1, 2, 0};
    qn_context *context = test_failing_context(&failing);
    qni_output output;
    const char *path = test_scratch_path(&scratch, "a.txt");
    qn_error error = {0};
    assert_int_equal(qni_output_open(&output, context, path, &error), QN_OK);
    int looks = 0;
    while (!qni_output_stopped(&output, 0.5)) {
        qni_output_write(&output, "abc", 3);
        ++looks;
    }
    assert_int_equal(looks, 2);
    assert_int_equal(qni_output_commit(&output, &error), QN_ERROR_CANCELLED);
    assert_int_equal(test_scratch_count(&scratch), 0);
    test_context_end(context);
    assert_int_equal(failing.held, 0);
}

static void large_and_small_writes_keep_their_order(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qni_output output;
    const char *path = test_scratch_path(&scratch, "a.bin");
    assert_int_equal(qni_output_open(&output, context, path, NULL), QN_OK);
    enum { LARGE = 3 * QNI_OUTPUT_BUFFER + 5 };
    char *large = test_alloc(LARGE, 1);
    for (int i = 0; i < LARGE; ++i)
        large[i] = (char)(i * 7 + i / 251);
    qni_output_write(&output, large, 10);
    qni_output_write(&output, large + 10, LARGE - 20);
    char *room = qni_output_reserve(&output, QNI_OUTPUT_BUFFER);
    memcpy(room, large + LARGE - 10, 10);
    qni_output_advance(&output, 10);
    assert_int_equal(output.bytes, LARGE);
    assert_int_equal(qni_output_commit(&output, NULL), QN_OK);
    size_t size;
    char *read_back = test_get_file(path, &size);
    assert_int_equal(size, LARGE);
    assert_memory_equal(read_back, large, LARGE);
    free(read_back);
    free(large);
    test_context_end(context);
}

int main(void) {
#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, make_scratch, remove_scratch)
    const struct CMUnitTest tests[] = {
        FILE_TEST(a_file_is_written_and_replaced),
        FILE_TEST(a_new_file_s_rights_follow_the_umask),
        FILE_TEST(a_link_stays_a_link),
        FILE_TEST(wrong_places_are_named),
        FILE_TEST(a_file_that_may_not_be_written_is_kept),
        FILE_TEST(special_files_are_written_directly),
        FILE_TEST(failing_midway_leaves_nothing),
        FILE_TEST(cancelling_leaves_nothing),
        FILE_TEST(large_and_small_writes_keep_their_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
