/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR files of every compression, of half and float, in lines and in tiles with levels: written
 * by OpenEXR's C++ library, and read by ours. test_exr_kinds.cpp writes. */
#include "test.h"

#include "io/exr.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

void write_kind(const char *path, int width, int height, const float *rgb, int compression,
                int is_half, int levels);
void read_kind(const char *path, int width, int height, float *rgb);

/* More lines than a chunk of DWAB has, which are 256; no side is a multiple of a tile's. */
enum { WIDTH = 37, HEIGHT = 261, VALUES = 3 * WIDTH * HEIGHT };

static const char *const compressions[] = {"none",  "RLE", "ZIPS", "ZIP",  "PIZ",
                                           "PXR24", "B44", "B44A", "DWAA", "DWAB"};

/*
 * The largest error relative to the largest value, 1. Lossless ones keep float, half rounds to 11
 * bits. PXR24 cuts float to 24 bits, 16 of them of the mantissa. B44 keeps 6 bits of differences in
 * a block of 4 x 4, whose values differ by less than 0.5 here: 0.5 / 2^6 and half's rounding, twice
 * for safety. DWA is tuned to the eye at level 45: its coefficients are exact to 45 / 100000 of a
 * perceptual unit; with 64 of them and a slope of the unit below 3, the error stays below 0.01.
 */
static double tolerance(int compression, bool is_half) {
    if (compression >= 8) return 1e-2;
    if (is_half && compression >= 6) return 1.6e-2;
    if (is_half) return 0x1p-12;
    return compression == 5 ? 0x1p-16 : 0;
}

static void check(int compression, bool is_half, int levels, const float *rgb) {
    char path[64];
    static float by_library[VALUES];
    mcv_exr exr;
    mcv_error error = {""};
    snprintf(path, sizeof path, "%s-%d-%d.exr", compressions[compression], is_half, levels);
    write_kind(path, WIDTH, HEIGHT, rgb, compression, is_half, levels);
    read_kind(path, WIDTH, HEIGHT, by_library);
    if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    const mcv_image *image = &exr.parts[0].image;
    assert_int_equal(image->width, WIDTH);
    assert_int_equal(image->height, HEIGHT);
    assert_int_equal(image->channels, 3);
    for (size_t i = 0; i < VALUES; ++i) {
        if (memcmp(image->pixels + i, by_library + i, sizeof(float)) != 0)
            fail_msg("%s: value %zu is %g, but %g to OpenEXR", path, i, (double)image->pixels[i],
                     (double)by_library[i]);
        const double wrong = fabs((double)image->pixels[i] - (double)rgb[i]);
        if (!(wrong <= tolerance(compression, is_half)))
            fail_msg("%s: value %zu is %g instead of %g", path, i, (double)image->pixels[i],
                     (double)rgb[i]);
    }
    mcv_exr_free(&exr);
    unlink(path);
}

static void test_every_kind(void **state) {
    (void)state;
    static float rgb[VALUES];
    for (int k = 0; k < 3; ++k)
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x)
                rgb[(k * HEIGHT + y) * WIDTH + x] =
                    (float)(0.5 + 0.4 * sin(0.1 * x + k) * cos(0.05 * y));
    for (int compression = 0; compression < 10; ++compression)
        for (int is_half = 0; is_half < 2; ++is_half)
            for (int levels = -1; levels < 3; ++levels) check(compression, is_half, levels, rgb);
}

/* Each byte of a tiled file's head and of its first chunks, changed: no crash, and one sentence. */
static void test_damaged_tiles(void **state) {
    (void)state;
    static float rgb[VALUES];
    const char *path = "damaged.exr";
    for (int compression = 1; compression < 10; ++compression) {
        write_kind(path, 40, 30, rgb, compression, 1, 1);
        FILE *file = fopen(path, "rb");
        static uint8_t bytes[1 << 16];
        const size_t size = fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        assert_in_range(size, 500, sizeof bytes - 1);
        for (size_t at = 0; at < size; at += compression < 4 ? 7 : 3) {
            const uint8_t kept = bytes[at];
            bytes[at] ^= (uint8_t)(at % 3 == 0 ? 0x80 : at % 3 == 1 ? 0xff : 0x01);
            file = fopen(path, "wb");
            assert_int_equal(fwrite(bytes, 1, size, file), size);
            fclose(file);
            bytes[at] = kept;
            mcv_exr exr;
            mcv_error error = {""};
            const mcv_result result = mcv_exr_read(path, &exr, &error);
            if (result == MCV_OK)
                mcv_exr_free(&exr);
            else if (result != MCV_BAD_INPUT || !strstr(error.text, path))
                fail_msg("%s, byte %zu: %d: %s", compressions[compression], at, result, error.text);
        }
    }
    unlink(path);
}

/* Makes the tiles of a file 32768 x 16383 pixels large. */
static void enlarge_tiles(const char *path) {
    static const char key[] = "tiles\0tiledesc\0\11\0\0";
    static uint8_t bytes[1 << 16];
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    size_t at = 0;
    while (at + sizeof key < size && memcmp(bytes + at, key, sizeof key) != 0) ++at;
    assert_true(at + sizeof key < size);
    memcpy(bytes + at + sizeof key, "\0\200\0\0\377\77\0\0", 8);
    rewind(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Allows so many addresses more than those in use; the limit of before is the answer. Under
 * sanitizers, which take addresses of their own, there is none. */
static struct rlimit allow(rlim_t more) {
    char line[128] = "";
    struct rlimit before;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_true(file && fgets(line, sizeof line, file));
    fclose(file);
    assert_int_equal(getrlimit(RLIMIT_AS, &before), 0);
#ifdef __SANITIZE_ADDRESS__
    more = before.rlim_cur;
#else
    more += strtoul(line, NULL, 10) * (rlim_t)sysconf(_SC_PAGESIZE);
#endif
    const struct rlimit now = {more, before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_AS, &now), 0);
    return before;
}

/* A tile may be larger than its image: it takes what the image does, not gigabytes. */
static void test_tiles_larger_than_the_image(void **state) {
    (void)state;
    enum { SMALL_WIDTH = 13, SMALL_HEIGHT = 11, SMALL_VALUES = 3 * SMALL_WIDTH * SMALL_HEIGHT };
    const char *path = "large_tiles.exr";
    float rgb[SMALL_VALUES], read[SMALL_VALUES];
    for (int i = 0; i < SMALL_VALUES; ++i) rgb[i] = (float)i / SMALL_VALUES;
    for (int compression = 0; compression < 10; ++compression)
        for (int levels = 0; levels < 3; ++levels) {
            mcv_exr exr;
            mcv_error error = {""};
            write_kind(path, SMALL_WIDTH, SMALL_HEIGHT, rgb, compression, 1, levels);
            read_kind(path, SMALL_WIDTH, SMALL_HEIGHT, read);
            enlarge_tiles(path);
            const struct rlimit before = allow((rlim_t)64 << 20);
            const mcv_result result = mcv_exr_read(path, &exr, &error);
            assert_int_equal(setrlimit(RLIMIT_AS, &before), 0);
            if (result != MCV_OK) fail_msg("%s: %s", compressions[compression], error.text);
            assert_memory_equal(exr.parts[0].image.pixels, read, sizeof read);
            mcv_exr_free(&exr);
        }
    unlink(path);
}

/* What reading takes, without its attributes: values, and three times a chunk, which has no more
 * lines than the image. */
static void test_chunks_count(void **state) {
    (void)state;
    enum { LINES = 3, CHANNELS = 3 };
    const char *path = "counted_chunks.exr";
    float rgb[CHANNELS * WIDTH * LINES] = {0};
    mcv_error error = {""};
    uint64_t pixels, reading, one_line;
    write_kind(path, WIDTH, LINES, rgb, 2, 0, -1); /* ZIPS: one line */
    assert_int_equal(mcv_exr_size(path, &pixels, &one_line, &error), MCV_OK);
    assert_int_equal(pixels, WIDTH * LINES);
    write_kind(path, WIDTH, LINES, rgb, 9, 0, -1); /* DWAB: up to 256 */
    assert_int_equal(mcv_exr_size(path, &pixels, &reading, &error), MCV_OK);
    /* OpenEXR adds the attribute dwaCompressionLevel, of 4 bytes, which are kept four times. */
    const uint64_t lines = (LINES - 1) * WIDTH * CHANNELS * sizeof(float);
    assert_in_range(reading - one_line, 3 * lines, 3 * lines + 16);
    unlink(path);
}

/* An image for which there is memory to be read, but not half of it to be measured: it is read
 * where the caller counts. 50 MB of values, and 12 bytes for each of 4.2 million pixels. */
static void test_counted(void **state) {
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    skip(); /* there is no limit */
#endif
    enum { SIDE = 2048 };
    const char *path = "counted.exr";
    float *rgb = calloc((size_t)3 * SIDE * SIDE, sizeof *rgb);
    mcv_exr exr;
    mcv_error error = {""};
    assert_non_null(rgb);
    write_kind(path, SIDE, SIDE, rgb, 3, 0, -1);
    free(rgb);
    const struct rlimit before = allow((rlim_t)80 << 20);
    const mcv_result result = mcv_exr_read(path, &exr, &error),
                     counted = mcv_exr_read_counted(path, &exr, &error);
    assert_int_equal(setrlimit(RLIMIT_AS, &before), 0);
    assert_int_equal(result, MCV_BAD_INPUT);
    if (counted != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(exr.parts[0].image.width, SIDE);
    mcv_exr_free(&exr);
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_kind), cmocka_unit_test(test_tiles_larger_than_the_image),
        cmocka_unit_test(test_counted), cmocka_unit_test(test_chunks_count),
        cmocka_unit_test(test_damaged_tiles)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
