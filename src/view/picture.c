// SPDX-License-Identifier: MIT
/* Pixels into a PNG file, through libpng, whose memory comes from the context as all other. */
#include "view/picture.h"
#include "core/context.h"
#include "core/file.h"
#include "core/status.h"

#include "qni_config.h"

#if QNI_HAVE_PNG

#include <png.h>

qn_status qni_picture_supported(qn_error *error) {
    (void)error;
    return QN_OK;
}

/* What libpng frees it does not give the size of: a header before each block keeps it. */
enum { BLOCK_HEADER = 64 };

static png_voidp allocate(png_structp png, png_alloc_size_t size) {
    qn_context *context = png_get_mem_ptr(png);
    if (size > (png_alloc_size_t)PTRDIFF_MAX - BLOCK_HEADER)
        return NULL;
    char *block = qni_alloc(context, (int64_t)size + BLOCK_HEADER, 1);
    if (!block)
        return NULL;
    *(int64_t *)(void *)block = (int64_t)size + BLOCK_HEADER;
    return block + BLOCK_HEADER;
}

static void release(png_structp png, png_voidp pointer) {
    if (!pointer)
        return;
    char *block = (char *)pointer - BLOCK_HEADER;
    qni_free(png_get_mem_ptr(png), block, *(int64_t *)(void *)block, 1);
}

static void write_bytes(png_structp png, png_bytep bytes, size_t size) {
    qni_output_write(png_get_io_ptr(png), bytes, size);
}

static void flush_nothing(png_structp png) {
    (void)png;
}

/* Leaving by longjmp is libpng's way: the one function that may be left so owns nothing. */
static void fail(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

static bool encode(png_structp png, png_infop info, int32_t width, int32_t height,
                   const uint8_t *rgb, qni_output *output) {
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_set_write_fn(png, output, write_bytes, flush_nothing);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (int32_t row = 0; row < height; ++row) {
        if (row % 64 == 0 && qni_output_stopped(output, (double)row / height))
            return true; /* the reason is kept by the output */
        png_write_row(png, rgb + (size_t)row * (size_t)width * 3);
    }
    png_write_end(png, NULL);
    return true;
}

qn_status qni_picture_write(qn_context *context, const char *path, int32_t width, int32_t height,
                            const uint8_t *rgb, qn_error *error) {
    png_structp png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, NULL, fail, ignore_warning,
                                                context, allocate, release);
    if (!png)
        return qni_fail_memory(error, "a picture");
    png_infop info = png_create_info_struct(png);
    if (!info) {
        png_destroy_write_struct(&png, NULL);
        return qni_fail_memory(error, "a picture");
    }
    qni_output output;
    qn_status status = qni_output_open(&output, context, path, error);
    if (status == QN_OK) {
        if (encode(png, info, width, height, rgb, &output)) {
            status = qni_output_commit(&output, error);
        } else {
            qni_output_abandon(&output);
            status = qni_fail_memory(error, "a picture");
        }
    }
    png_destroy_write_struct(&png, &info);
    return status;
}

#else

qn_status qni_picture_supported(qn_error *error) {
    return qni_fail(error, QN_ERROR_UNSUPPORTED,
                    "pictures are not built in: install libpng-dev and build with -Dpng=enabled");
}

qn_status qni_picture_write(qn_context *context, const char *path, int32_t width, int32_t height,
                            const uint8_t *rgb, qn_error *error) {
    (void)context;
    (void)path;
    (void)width;
    (void)height;
    (void)rgb;
    return qni_picture_supported(error);
}

#endif
