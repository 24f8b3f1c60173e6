/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include <arpa/inet.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "io/png.h"

static const char PATH[] = "test_png.png";

/* What libpng finds in a file: rows of bytes and the text "White level". */
typedef struct decoded {
    uint32_t width, height;
    int bits, colour;
    bool srgb;
    char white[128], early[128];
    uint8_t bytes[4096];
} decoded;

static decoded decode(void) {
    decoded d = {0};
    FILE *file = fopen(PATH, "rb");
    assert_non_null(file);
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_read_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    d.width = png_get_image_width(png, info);
    d.height = png_get_image_height(png, info);
    d.bits = png_get_bit_depth(png, info);
    d.colour = png_get_color_type(png, info);
    int intent;
    d.srgb = png_get_sRGB(png, info, &intent) != 0;
    png_textp text;
    int count = 0;
    png_get_text(png, info, &text, &count);
    for (int i = 0; i < count; ++i) {
        if (strcmp(text[i].key, "White level") == 0)
            snprintf(d.white, sizeof d.white, "%s", text[i].text);
        if (strcmp(text[i].key, "Preview") == 0)
            snprintf(d.early, sizeof d.early, "%s", text[i].text);
    }
    const size_t stride = png_get_rowbytes(png, info);
    assert_true(stride * d.height <= sizeof d.bytes);
    for (uint32_t row = 0; row < d.height; ++row)
        memcpy(d.bytes + row * stride, png_get_rows(png, info)[row], stride);
    png_destroy_read_struct(&png, &info, NULL);
    fclose(file);
    unlink(PATH);
    return d;
}

/* A coarse picture of the size of the image, that says what it is. */
static void test_early_preview_is_enlarged(void **state) {
    (void)state;
    float pixels[] = {0, 1, 1, 0, /* red */ 0, 0, 1, 1, /* green */ 0, 1, 0, 1};
    const mcv_image image = {.width = 2, .height = 2, .channels = 3, .pixels = pixels};
    mcv_preview preview = {.white = 1, .early = "coarse", .repeat = 3, .size = {5, 4}};
    mcv_error error;
    assert_int_equal(mcv_png_write_preview(PATH, &image, "W/m^2", &preview, &error), MCV_OK);
    const decoded d = decode();
    assert_int_equal(d.width, 5);
    assert_int_equal(d.height, 4);
    assert_string_equal(d.early, "coarse");
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x)
            for (int c = 0; c < 3; ++c)
                assert_int_equal(d.bytes[3 * (5 * y + x) + c],
                                 255 * (int)pixels[4 * c + 2 * (y / 3) + x / 3]);
}

static void test_grey_preview_is_srgb_with_its_white_level(void **state) {
    (void)state;
    /* Linear 0.5 is 187.52 of 255 and 0.002 is 6.59 in sRGB (IEC 61966-2-1), worked out by hand. */
    float pixels[] = {0, 2, 1, 0.004f, 4, NAN, INFINITY, -1};
    const mcv_image image = {.width = 4, .height = 2, .channels = 1, .pixels = pixels};
    const uint8_t expected[] = {0, 255, 188, 7, 255, 0, 255, 0};
    mcv_preview preview = {.white = 2};
    mcv_error error = {""};
    assert_int_equal(mcv_png_write_preview(PATH, &image, "W/(m^2 sr)", &preview, &error), MCV_OK);
    assert_true(preview.white == 2);
    assert_true(preview.saturated == 2.0 / 8); /* 4 and infinity */
    const decoded d = decode();
    assert_int_equal(d.width, 4);
    assert_int_equal(d.height, 2);
    assert_int_equal(d.bits, 8);
    assert_int_equal(d.colour, PNG_COLOR_TYPE_GRAY);
    assert_true(d.srgb);
    assert_string_equal(d.white, "2 W/(m^2 sr)");
    assert_string_equal(d.early, "");
    assert_memory_equal(d.bytes, expected, sizeof expected);
}

static void test_colour_preview_interleaves_planes(void **state) {
    (void)state;
    float pixels[] = {1, 0, /* R */ 0, 1, /* G */ 0, 2 /* B */};
    const mcv_image image = {.width = 2, .height = 1, .channels = 3, .pixels = pixels};
    const uint8_t expected[] = {255, 0, 0, 0, 255, 255};
    mcv_preview preview = {.white = 1};
    mcv_error error = {""};
    assert_int_equal(mcv_png_write_preview(PATH, &image, "W/m^2", &preview, &error), MCV_OK);
    assert_true(preview.saturated == 0.5);
    const decoded d = decode();
    assert_int_equal(d.colour, PNG_COLOR_TYPE_RGB);
    assert_memory_equal(d.bytes, expected, sizeof expected);
}

static void test_white_level_is_the_quantile(void **state) {
    (void)state;
    enum { COUNT = 1001 };
    float pixels[COUNT];
    mcv_image image = {.width = COUNT, .height = 1, .channels = 1, .pixels = pixels};
    /* 0 … 1000 times a step that fills all 32 bits of the float, in mixed order: rank 0.995 x 1000
     * is 995. */
    const float step = 1.2345678e-3f;
    for (int i = 0; i < COUNT; ++i) pixels[i] = (float)(i * 389 % COUNT) * step;
    assert_true(mcv_preview_white(&image) == 995.0f * step);
    /* Values that are not finite do not count. */
    for (int i = 0; i < COUNT; ++i) {
        if (pixels[i] > 995.5f * step) pixels[i] = pixels[i] > 998.5f * step ? NAN : INFINITY;
    }
    assert_true(mcv_preview_white(&image) == 990.0f * step); /* 996 are left: floor(0.995 x 995) */
    /* A spot on black: its brightest value. Black: 1. */
    for (int i = 0; i < COUNT; ++i) pixels[i] = i < 3 ? 5.0f + (float)i : 0.0f;
    assert_true(mcv_preview_white(&image) == 7);
    for (int i = 0; i < COUNT; ++i) pixels[i] = -(float)i;
    assert_true(mcv_preview_white(&image) == 1);
    mcv_preview preview = {0};
    mcv_error error = {""};
    assert_int_equal(mcv_png_write_preview(PATH, &image, "W/m^2", &preview, &error), MCV_OK);
    assert_true(preview.white == 1 && preview.saturated == 0);
    unlink(PATH);
}

static void test_grey_values_stay_as_they_are(void **state) {
    (void)state;
    float values[] = {0, 1, 255, 256, 4095, 65535};
    mcv_image image = {.width = 3, .height = 2, .channels = 1, .pixels = values};
    const uint8_t wide[] = {0, 0, 0, 1, 0, 255, 1, 0, 15, 255, 255, 255};
    const uint8_t narrow[] = {0, 1, 255};
    const uint8_t colour[] = {0, 0,   0,   255, 255, 255, 0,   1,   1,
                              0, 255, 255, 0,   255, 15,  255, 255, 255};
    mcv_error error = {""};
    assert_int_equal(mcv_png_write_values(PATH, &image, 16, &error), MCV_OK);
    decoded d = decode();
    assert_int_equal(d.bits, 16);
    assert_false(d.srgb);
    assert_memory_equal(d.bytes, wide, sizeof wide);
    image.height = 1;
    assert_int_equal(mcv_png_write_values(PATH, &image, 8, &error), MCV_OK);
    d = decode();
    assert_int_equal(d.bits, 8);
    assert_memory_equal(d.bytes, narrow, sizeof narrow);
    assert_int_equal(mcv_png_write_values(PATH, &image, 12, &error), MCV_USAGE);

    float planes[] = {0, 1, 255, /* R */ 255, 256, 4095, /* G */ 65535, 65535.4F, 70000 /* B */};
    image.channels = 3;
    image.pixels = planes;
    assert_int_equal(mcv_png_write_values(PATH, &image, 16, &error), MCV_OK);
    d = decode();
    assert_int_equal(d.colour, PNG_COLOR_TYPE_RGB);
    assert_memory_equal(d.bytes, colour, sizeof colour);
}

static void test_failures_leave_no_file(void **state) {
    (void)state;
    float pixels[2] = {0};
    mcv_image image = {.width = 1, .height = 1, .channels = 2, .pixels = pixels};
    mcv_preview preview = {0};
    mcv_error error = {""};
    assert_int_equal(mcv_png_write_preview(PATH, &image, "W/m^2", &preview, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "2 channels"));
    image.channels = 1;
    assert_int_equal(mcv_png_write_preview("no/such/folder.png", &image, "W/m^2", &preview, &error),
                     MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "no/such/folder.png"));
    image.width = 0;
    assert_int_equal(mcv_png_write_preview(PATH, &image, "W/m^2", &preview, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, PATH));
    assert_int_equal(access(PATH, F_OK), -1);
}

/* Appends a chunk to a file: length, name, data, checksum. `length` may lie. */
static void put_chunk(FILE *file, const char *name, const void *data, size_t size,
                      uint32_t length) {
    uint32_t sum = (uint32_t)crc32(0, (const Bytef *)name, 4);
    if (size > 0) sum = (uint32_t)crc32(sum, data, (uInt)size);
    const uint32_t words[2] = {htonl(length), htonl(sum)};
    assert_int_equal(fwrite(words, 4, 1, file), 1);
    assert_int_equal(fwrite(name, 4, 1, file), 1);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fwrite(words + 1, 4, 1, file), 1);
}

/* The most addresses that the process has had. */
static long peak_kilobytes(void) {
    char line[256];
    long peak = -1;
    FILE *file = fopen("/proc/self/status", "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        if (strncmp(line, "VmPeak:", 7) == 0) peak = strtol(line + 7, NULL, 10);
    assert_int_equal(fclose(file), 0);
    assert_true(peak > 0);
    return peak;
}

/* Files of less than 100 bytes that announce a gigabyte of text, and 32 GiB of pixels, are refused
 * before there is memory for it. */
static void test_small_files_take_little_memory(void **state) {
    (void)state;
    static const uint8_t signature[8] = {137, 80, 78, 71, 13, 10, 26, 10};
    for (uint8_t side = 0; side < 2; ++side) {
        /* Sides of 1 or 65536, big-endian; bits, RGBA, compression, filter, interlace. */
        const uint8_t head[13] = {0, side, 0, !side, 0, side, 0, !side, 16, 6, 0, 0, 0};
        const uint8_t data[8] = {0};
        FILE *file = fopen(PATH, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(signature, 1, 8, file), 8);
        put_chunk(file, "IHDR", head, sizeof head, sizeof head);
        put_chunk(file, "tEXt", data, sizeof data, side ? (uint32_t)sizeof data : 0x40000000U);
        put_chunk(file, "IDAT", data, sizeof data, sizeof data);
        assert_int_equal(fclose(file), 0);
        mcv_image image = {0};
        mcv_error error = {""};
        const long before = peak_kilobytes();
        assert_int_equal(mcv_png_read_values(PATH, &image, &error), MCV_BAD_INPUT);
        assert_string_equal(error.text, "test_png.png: damaged PNG file: it ends early");
        const long more = peak_kilobytes() - before;
        if (more > 65536) fail_msg("%ld kB were asked for", more); /* a sixteenth of the least */
    }
    assert_int_equal(unlink(PATH), 0);
}

/* A white square, as libpng writes it. */
static void write_white(uint32_t side, int bits, int type) {
    static const png_color white[2] = {{255, 255, 255}, {255, 255, 255}};
    static png_byte row[1024];
    FILE *file = fopen(PATH, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    assert_true(file && info);
    memset(row, type == PNG_COLOR_TYPE_PALETTE ? 0 : 255, sizeof row);
    png_init_io(png, file);
    png_set_IHDR(png, info, side, side, bits, type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 9);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, white, 2);
    png_write_info(png, info);
    for (uint32_t y = 0; y < side; ++y) png_write_row(png, row);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
}

/* Masks of one bit and of a palette, whose files hold less than a 1032nd of their grey values. */
static void test_few_bits_are_read(void **state) {
    (void)state;
    static const int kinds[][2] = {{1, PNG_COLOR_TYPE_GRAY},
                                   {1, PNG_COLOR_TYPE_PALETTE},
                                   {8, PNG_COLOR_TYPE_PALETTE},
                                   {8, PNG_COLOR_TYPE_GRAY}};
    enum { SIDE = 1024 };
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        mcv_image image = {0};
        mcv_error error = {""};
        write_white(SIDE, kinds[i][0], kinds[i][1]);
        if (mcv_png_read_values(PATH, &image, &error) != MCV_OK)
            fail_msg("%d bits, type %d: %s", kinds[i][0], kinds[i][1], error.text);
        assert_true(image.width == SIDE && image.height == SIDE);
        assert_true(image.pixels[0] == 255 && image.pixels[SIDE * SIDE - 1] == 255);
        mcv_image_free(&image);
    }
    assert_int_equal(unlink(PATH), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_early_preview_is_enlarged),
        cmocka_unit_test(test_grey_preview_is_srgb_with_its_white_level),
        cmocka_unit_test(test_colour_preview_interleaves_planes),
        cmocka_unit_test(test_white_level_is_the_quantile),
        cmocka_unit_test(test_grey_values_stay_as_they_are),
        cmocka_unit_test(test_failures_leave_no_file),
        cmocka_unit_test(test_small_files_take_little_memory),
        cmocka_unit_test(test_few_bits_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
