/* SPDX-License-Identifier: Apache-2.0 */
/* Images whose files are small, and whose pixels are more than half of the memory, are refused by
 * their headers, before there is memory for their pixels. */
#include "test.h"

#include "io/exr.h"
#include "io/values.h"
#include "scene/memory.h"

#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* 67 million pixels, of which a reader says that they take 1.07 GB. */
enum { SIDE = 8192, SMALL = 8 };

/* A black mask of one bit: 8 kB, as libpng writes it. */
static void write_png(const char *path) {
    static const png_byte row[SIDE / 8];
    FILE *file = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    assert_true(file && info);
    png_init_io(png, file);
    png_set_IHDR(png, info, SIDE, SIDE, 1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (uint32_t y = 0; y < SIDE; ++y) png_write_row(png, row);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
}

/* Values of one byte; all but the header is a hole. */
static void write_npy(const char *path) {
    char header[129];
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    snprintf(header, sizeof header, "%-117s\n",
             "{'descr': '|u1', 'fortran_order': False, 'shape': (8192, 8192), }");
    assert_int_equal(fwrite("\x93NUMPY\x01\0\x76\0", 1, 10, file), 10);
    assert_int_equal(fwrite(header, 1, 118, file), 118);
    assert_int_equal(fflush(file), 0);
    assert_int_equal(ftruncate(fileno(file), 128 + (off_t)SIDE * SIDE), 0);
    assert_int_equal(fclose(file), 0);
}

static uint8_t *find_bytes(uint8_t *bytes, size_t count, const char *text, size_t length) {
    for (size_t i = 0; i + length <= count; ++i)
        if (memcmp(bytes + i, text, length) == 0) return bytes + i;
    fail_msg("a file without its header");
    return NULL;
}

/* Puts `side` at two places of a file's header, counted from the first place that holds `key`. */
static void claim(const char *path, const char *key, size_t length, const size_t places[2],
                  uint32_t side) {
    static uint8_t bytes[4096];
    const uint8_t number[4] = {(uint8_t)side, (uint8_t)(side >> 8), 0, 0};
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    const size_t count = fread(bytes, 1, sizeof bytes, file);
    uint8_t *at = find_bytes(bytes, count, key, length);
    for (int i = 0; i < 2; ++i) memcpy(at + places[i], number, sizeof number);
    rewind(file);
    assert_int_equal(fwrite(bytes, 1, count, file), count);
    assert_int_equal(fclose(file), 0);
}

static void write_tiff(const char *path) {
    static float pixels[SMALL * SMALL];
    const mcv_image image = {.width = SMALL, .height = SMALL, .channels = 1, .pixels = pixels};
    mcv_error error;
    assert_int_equal(mcv_values_write(path, &image, 8, &error), MCV_OK);
    /* The first two tags of its directory: 256 and 257, of type 3 (16 bits) and count 1. */
    claim(path, "\0\1\3\0\1\0\0\0", 8, (const size_t[2]){8, 20}, SIDE);
}

static void write_exr(const char *path) {
    static float pixels[SMALL * SMALL];
    const mcv_exr_part part = {
        .image = {.width = SMALL, .height = SMALL, .channels = 1, .pixels = pixels}};
    mcv_error error = {""};
    if (mcv_exr_write(path, &part, 1, NULL, 0, &error) != MCV_OK) fail_msg("%s", error.text);
    claim(path, "dataWindow\0box2i\0\20\0\0\0", 21, (const size_t[2]){29, 33}, SIDE - 1);
}

/* Fails with the sentence in a child that may take 256 MB of addresses more than it has; 0 if so.
 */
static int refuses(const char *path) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        char line[128] = "";
        mcv_image image = {0};
        mcv_exr exr;
        mcv_error error = {""};
        FILE *file = fopen("/proc/self/statm", "r");
        if (!file || !fgets(line, sizeof line, file)) _exit(101);
        fclose(file);
        const rlim_t most =
            strtoul(line, NULL, 10) * (rlim_t)sysconf(_SC_PAGESIZE) + ((rlim_t)256 << 20);
        const struct rlimit limit = {most, most};
        if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(102);
        const mcv_result result = strstr(path, ".exr") ? mcv_exr_read(path, &exr, &error)
                                                       : mcv_values_read(path, &image, &error);
        fprintf(stderr, "%s\n", error.text);
        _exit(result == MCV_BAD_INPUT && strstr(error.text, path) &&
                      strstr(error.text, "an image of 67.11 million pixels takes 1074 MB, more "
                                         "than the limit of ")
                  ? 0
                  : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 100;
}

static void test_large_images_are_refused(void **state) {
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    skip(); /* it takes addresses of its own */
#endif
    static const struct {
        const char *path;
        void (*write)(const char *path);
    } cases[] = {{"image_limits.png", write_png},
                 {"image_limits.npy", write_npy},
                 {"image_limits.tif", write_tiff},
                 {"image_limits.exr", write_exr}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        cases[i].write(cases[i].path);
        const int code = refuses(cases[i].path);
        if (code != 0) fail_msg("%s is not refused: %d", cases[i].path, code);
        assert_int_equal(unlink(cases[i].path), 0);
    }
}

/* Up to half of the memory is taken. */
static void test_limit(void **state) {
    (void)state;
    const uint64_t most = mcv_memory_default();
    mcv_error error = {""};
    assert_int_equal(mcv_memory_check_image("a.png", most / 16, most / 16, &error), MCV_OK);
    assert_int_equal(mcv_memory_check_image("a.png", most / 16 + 1, most / 16 + 1, &error),
                     MCV_BAD_INPUT);
    /* Three channels: 24 bytes a pixel. */
    assert_int_equal(mcv_memory_check_image("a.png", most / 24, 3 * (most / 24), &error), MCV_OK);
    assert_int_equal(mcv_memory_check_image("a.png", most / 24 + 1, 3 * (most / 24 + 1), &error),
                     MCV_BAD_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_large_images_are_refused),
        cmocka_unit_test(test_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
