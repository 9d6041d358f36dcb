// SPDX-License-Identifier: MIT
/* golden.csv: counts and bytes of meshes as they were agreed on. With --update the table is
 * rewritten with what comes out now, so that a change is seen as a diff of the table. "-" stays: it
 * stands for the bytes of fields that need sin, cos or exp, which C libraries round differently. */
#include "golden/golden_case.h"

static const char *table_path;
static bool update;

static void check_text(const golden_case *one, const char *what, char *expected, size_t capacity,
                       const char *found, int *wrong) {
    if (update && strcmp(expected, "-") != 0)
        snprintf(expected, capacity, "%s", found);
    else if (strcmp(expected, "-") != 0 && strcmp(expected, found) != 0) {
        printf("%s %s %lld %s %s: %s is %s, was %s\n", one->name, one->scalar, (long long)one->n,
               one->inside, one->border, what, found, expected);
        *wrong += 1;
    }
}

static int check_case(qn_context *context, golden_case *one) {
    int wrong = 0;
    char found[24];
    qn_mesh *mesh = golden_mesh(context, one);
    qn_mesh_view view = qn_mesh_get_view(mesh);
    snprintf(found, sizeof found, "%lld", (long long)view.vertex_count);
    check_text(one, "the number of vertices", one->vertices, sizeof one->vertices, found, &wrong);
    snprintf(found, sizeof found, "%lld", (long long)(view.quad_count + view.triangle_count));
    check_text(one, "the number of faces", one->face_count, sizeof one->face_count, found, &wrong);
    snprintf(found, sizeof found, "%016llx", (unsigned long long)test_hash_mesh(mesh));
    check_text(one, "the hash of the bytes", one->hash, sizeof one->hash, found, &wrong);
    qn_mesh_destroy(mesh);
    return wrong;
}

static void meshes_are_those_of_the_table(void **state) {
    (void)state;
    char line[256], head[256];
    golden_case cases[256];
    int count = 0, wrong = 0;
    FILE *file = fopen(table_path, "r");
    assert_non_null(file);
    assert_non_null(fgets(head, sizeof head, file));
    while (count < 256 && fgets(line, sizeof line, file)) {
        if (!golden_parse(line, &cases[count++]))
            fail_msg("%s: no case: %s", table_path, line);
    }
    fclose(file);
    assert_true(count > 10);
    qn_context *context = test_context(0);
    for (int i = 0; i < count; ++i)
        wrong += check_case(context, &cases[i]);
    test_context_end(context);
    if (update) {
        assert_non_null(file = fopen(table_path, "w"));
        fputs(head, file);
        for (int i = 0; i < count; ++i)
            golden_print(file, &cases[i]);
        fclose(file);
    }
    printf("%d cases%s\n", count, update ? ", table rewritten" : "");
    assert_int_equal(wrong, 0);
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; ++i)
        if (strcmp(argv[i], "--update") == 0)
            update = true;
        else
            table_path = argv[i];
    if (!table_path) {
        fprintf(stderr, "use: test_golden [--update] golden.csv\n");
        return 2;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(meshes_are_those_of_the_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
