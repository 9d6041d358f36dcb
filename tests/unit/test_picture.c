// SPDX-License-Identifier: MIT
/* Pictures: what stands where, which side is seen, the same bytes for every thread count. */
#include "lib/failing.h"
#include "lib/scratch.h"
#include "lib/support.h"

#include "qni_config.h"

#include <math.h>

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

/* A cube of side 2 round the origin, wound outward or inward, beside a vertex that no face uses. */
static qn_mesh *make_cube(qn_context *context, bool inward) {
    static const float positions[9][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1},
                                          {1, 1, -1},   {-1, -1, 1}, {1, -1, 1},
                                          {-1, 1, 1},   {1, 1, 1},   {1000, 0, 0}};
    static const uint32_t outward[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    uint32_t quads[6][4];
    for (int f = 0; f < 6; ++f)
        for (int c = 0; c < 4; ++c)
            quads[f][c] = outward[f][inward ? 3 - c : c];
    qn_mesh_view view = {
        .vertex_count = 9, .quad_count = 6, .positions = &positions[0][0], .quads = &quads[0][0]};
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    return mesh;
}

static qn_view_options view_options(int32_t width, int32_t height) {
    qn_view_options options;
    qn_view_options_init(&options);
    options.width = width;
    options.height = height;
    return options;
}

#if QNI_HAVE_PNG

#include <png.h>

typedef struct pixels {
    png_image image;
    unsigned char *rgb;
} pixels;

static pixels draw(qn_context *context, const qn_mesh *mesh, const qn_view_options *options) {
    const char *path = test_scratch_path(&scratch, "m.png");
    qn_error error;
    if (qn_mesh_write_picture(context, mesh, path, options, &error) != QN_OK)
        fail_msg("%s", error.message);
    pixels p;
    memset(&p, 0, sizeof p);
    p.image.version = PNG_IMAGE_VERSION;
    assert_true(png_image_begin_read_from_file(&p.image, path));
    p.image.format = PNG_FORMAT_RGB;
    p.rgb = test_alloc(PNG_IMAGE_SIZE(p.image), 1);
    assert_true(png_image_finish_read(&p.image, NULL, p.rgb, 0, NULL));
    return p;
}

static const unsigned char *at(const pixels *p, int x, int y) {
    return p->rgb + 3 * ((size_t)y * p->image.width + (size_t)x);
}

/* The background is a little blue or grey; faces are warm. */
static bool is_mesh(const unsigned char *rgb) {
    return rgb[0] > rgb[2] + 2 || rgb[0] + rgb[1] + rgb[2] < 500;
}

static void a_cube_stands_in_the_middle_and_fills_the_picture(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    qn_mesh *mesh = make_cube(context, false);
    qn_view_options options = view_options(200, 150);
    options.has_angles = true; /* straight at the face x = 1 */
    pixels p = draw(context, mesh, &options);
    assert_int_equal(p.image.width, 200);
    assert_int_equal(p.image.height, 150);
    int x0 = 200, x1 = -1, y0 = 150, y1 = -1;
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 200; ++x)
            if (is_mesh(at(&p, x, y))) {
                x0 = x < x0 ? x : x0;
                x1 = x > x1 ? x : x1;
                y0 = y < y0 ? y : y0;
                y1 = y > y1 ? y : y1;
            }
    assert_in_range(x0 + x1, 198, 200); /* centred */
    assert_in_range(y0 + y1, 148, 150);
    assert_in_range(y1 - y0 + 1, 136, 143);             /* 93 percent of the height */
    assert_in_range(x1 - x0, y1 - y0 - 1, y1 - y0 + 1); /* square */
    assert_false(is_mesh(at(&p, 2, 2)));
    const unsigned char *centre = at(&p, 100, 75);
    assert_true(centre[0] > centre[1] && centre[1] > centre[2]); /* warm */
    free(p.rgb);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void the_back_of_faces_is_of_another_colour(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_cube(context, true);
    qn_view_options options = view_options(100, 100);
    pixels p = draw(context, mesh, &options);
    const unsigned char *centre = at(&p, 50, 50);
    assert_true(centre[0] > centre[2] && centre[2] > centre[1]); /* red with some blue */
    assert_true(centre[0] > centre[1] + 30);
    free(p.rgb);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void edges_are_drawn_and_diagonals_are_not(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_cube(context, false);
    qn_view_options options = view_options(200, 200);
    options.has_angles = true;
    pixels plain = draw(context, mesh, &options);
    options.edges = true;
    pixels p = draw(context, mesh, &options);
    int dark = 0, dark_inside = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x)
            if (at(&p, x, y)[0] + 25 < at(&plain, x, y)[0]) {
                ++dark;
                dark_inside += x > 20 && x < 180 && y > 20 && y < 180;
            }
    assert_in_range(dark, 500, 2500); /* a square of 4 x 186 pixels */
    free(plain.rgb);
    assert_int_equal(dark_inside, 0);
    free(p.rgb);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void zoom_and_angles_change_the_picture(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_cube(context, false);
    qn_view_options options = view_options(64, 64);
    options.zoom = 8;
    pixels near = draw(context, mesh, &options);
    for (int i = 0; i < 64; ++i)
        assert_true(is_mesh(at(&near, i, i)));
    options.zoom = 0.25;
    pixels far = draw(context, mesh, &options);
    for (int i = 0; i < 20; ++i)
        assert_false(is_mesh(at(&far, i, 32)));
    assert_true(is_mesh(at(&far, 32, 32)));
    free(near.rgb);
    free(far.rgb);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void nothing_to_see_gives_the_background(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    static const float positions[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}, {1, 1, INFINITY}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 1, 3}};
    for (int faces = 0; faces <= 2; faces += 2) {
        qn_mesh_view view = {.vertex_count = faces ? 4 : 0,
                             .triangle_count = faces,
                             .positions = &positions[0][0],
                             .triangles = &triangles[0][0]};
        qn_mesh *mesh;
        assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
        qn_view_options options = view_options(40, 30);
        pixels p = draw(context, mesh, &options);
        for (int y = 0; y < 30; ++y)
            for (int x = 0; x < 40; ++x)
                assert_false(is_mesh(at(&p, x, y)));
        free(p.rgb);
        qn_mesh_destroy(mesh);
    }
    test_context_end(context);
}

/* A bumpy sheet of many faces, some seen from behind, with normals. */
static qn_mesh *make_sheet(qn_context *context) {
    enum { SIDE = 120 };
    static float positions[SIDE][SIDE][3], normals[SIDE][SIDE][3];
    static uint32_t quads[SIDE - 1][SIDE - 1][4];
    for (uint32_t i = 0; i < SIDE; ++i)
        for (uint32_t j = 0; j < SIDE; ++j) {
            positions[i][j][0] = (float)i;
            positions[i][j][1] = (float)j;
            positions[i][j][2] = (float)(12 * sin(0.3 * i) * cos(0.21 * j));
            normals[i][j][2] = 1;
            uint32_t v = i * SIDE + j;
            const uint32_t corners[4] = {v, v + SIDE, v + SIDE + 1, v + 1};
            if (i + 1 < SIDE && j + 1 < SIDE)
                memcpy(quads[i][j], corners, sizeof corners);
        }
    qn_mesh_view view = {.vertex_count = SIDE * SIDE,
                         .quad_count = (SIDE - 1) * (SIDE - 1),
                         .positions = &positions[0][0][0],
                         .normals = &normals[0][0][0],
                         .quads = &quads[0][0][0]};
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    return mesh;
}

static void threads_do_not_change_a_byte(void **state) {
    (void)state;
    char *first = NULL;
    size_t first_size = 0;
    for (int32_t threads = 1; threads <= 8; threads += threads == 3 ? 5 : 1) {
        qn_context *context = test_context(threads);
        qn_mesh *mesh = make_sheet(context);
        qn_view_options options = view_options(161, 121);
        options.edges = true;
        const char *path = test_scratch_path(&scratch, "m.png");
        assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, NULL), QN_OK);
        size_t size;
        char *bytes = test_get_file(path, &size);
        if (first) {
            assert_int_equal(size, first_size);
            assert_memory_equal(bytes, first, size);
            free(bytes);
        } else {
            first = bytes;
            first_size = size;
        }
        qn_mesh_destroy(mesh);
        test_context_end(context);
    }
    free(first);
}

static void wrong_options_are_refused(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_cube(context, false);
    qn_error error;
    const char *path = test_scratch_path(&scratch, "m.png");
    qn_view_options options = view_options(-1, 10);
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options = view_options(10, 100000);
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options = view_options(10, 10);
    options.zoom = -2;
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options.zoom = 1;
    options.has_angles = true;
    options.azimuth = NAN;
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options.azimuth = 0;
    options.struct_size = 0;
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options = view_options(10, 10);
    path = test_scratch_path(&scratch, "none/m.png");
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error), QN_ERROR_OUTPUT);
    assert_int_equal(test_scratch_count(&scratch), 0);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void failing_memory_and_cancelling_leave_nothing(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; ++kind)
        for (int64_t n = 0, done = 0; !done; ++n) {
            test_failing failing = {-1, -1, 0};
            qn_context *context = test_failing_context(&failing);
            qn_mesh *mesh = make_cube(context, false);
            *(kind ? &failing.looks_left : &failing.allocations_left) = n;
            qn_view_options options = view_options(32, 24);
            const char *path = test_scratch_path(&scratch, "m.png");
            qn_status status = qn_mesh_write_picture(context, mesh, path, &options, NULL);
            done = status == QN_OK;
            if (!done)
                assert_int_equal(status, kind ? QN_ERROR_CANCELLED : QN_ERROR_OUT_OF_MEMORY);
            assert_int_equal(test_scratch_count(&scratch), done ? 1 : 0);
            remove(path);
            qn_mesh_destroy(mesh);
            test_context_end(context);
            assert_int_equal(failing.held, 0);
            assert_true(n < 1000);
        }
}

#else

static void pictures_are_not_built_in(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_cube(context, false);
    qn_error error;
    qn_view_options options = view_options(8, 8);
    const char *path = test_scratch_path(&scratch, "m.png");
    assert_int_equal(qn_mesh_write_picture(context, mesh, path, &options, &error),
                     QN_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "-Dpng"));
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

#endif

int main(void) {
#define PICTURE_TEST(name) cmocka_unit_test_setup_teardown(name, make_scratch, remove_scratch)
    const struct CMUnitTest tests[] = {
#if QNI_HAVE_PNG
        PICTURE_TEST(a_cube_stands_in_the_middle_and_fills_the_picture),
        PICTURE_TEST(the_back_of_faces_is_of_another_colour),
        PICTURE_TEST(edges_are_drawn_and_diagonals_are_not),
        PICTURE_TEST(zoom_and_angles_change_the_picture),
        PICTURE_TEST(nothing_to_see_gives_the_background),
        PICTURE_TEST(threads_do_not_change_a_byte),
        PICTURE_TEST(wrong_options_are_refused),
        PICTURE_TEST(failing_memory_and_cancelling_leave_nothing),
#else
        PICTURE_TEST(pictures_are_not_built_in),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
