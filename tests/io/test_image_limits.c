/* SPDX-License-Identifier: Apache-2.0 */
/* Images whose files are small, and whose pixels are more than half of the memory, are refused by
 * their headers, before there is memory for their pixels. What is not their pixels counts, or takes
 * none. */
#include "test.h"

#include "core/memory_limit.h"
#include "io/exr.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tiffio.h>
#include <unistd.h>
#include <zlib.h>

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

/* One pixel, and 40 texts of our key that say that they are packed: 8000 bytes each, which may grow
 * to libpng's limit of 8 MB. */
static void write_texts(const char *path) {
    enum { TEXTS = 40 };
    static png_byte text[8000] = MCV_CAMERA_MODEL_KEY;
    FILE *file = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    assert_true(file && info);
    png_init_io(png, file);
    png_set_IHDR(png, info, 1, 1, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int i = 0; i < TEXTS; ++i)
        png_write_chunk(png, (png_const_bytep) "zTXt", text, sizeof text);
    png_write_row(png, (png_const_bytep) "z");
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

/* 4 GiB of nothing. */
static void write_hole(const char *path) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(ftruncate(fileno(file), (off_t)1 << 32), 0);
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

/* Black pixels, of which the system gives no memory to zeros that are only read. */
static void write_exr(const char *path) {
    float *pixels = calloc((size_t)SIDE * SIDE, sizeof *pixels);
    assert_non_null(pixels);
    const mcv_exr_part part = {
        .image = {.width = SIDE, .height = SIDE, .channels = 1, .pixels = pixels}};
    mcv_error error = {""};
    if (mcv_exr_write(path, &part, 1, NULL, 0, &error) != MCV_OK) fail_msg("%s", error.text);
    free(pixels);
}

/* Fails with the sentence in a child that may take 256 MB of addresses more than it has; 0 if so.
 */
static int refuses(const char *path, const char *reason) {
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
        _exit(result == MCV_BAD_INPUT && strstr(error.text, path) && strstr(error.text, reason)
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
        const char *reason;
    } cases[] = {
        {"image_limits.png", write_png, "takes 1074 MB, more than the limit of "},
        {"image_limits_key.png", write_texts, "takes 320.3 MB, more than the limit of "},
        {"image_limits.npy", write_npy, "takes 1141 MB, more than the limit of "}, /* its file */
        {"image_limits.tif", write_tiff, "takes 1074 MB, more than the limit of "},
        {"image_limits.exr", write_exr, "takes 107"}, /* its file, a chunk */
        {"image_limits.tiff", write_hole, "is larger than "}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        cases[i].write(cases[i].path);
        const int code = refuses(cases[i].path, cases[i].reason);
        if (code != 0) fail_msg("%s is not refused: %d", cases[i].path, code);
        assert_int_equal(unlink(cases[i].path), 0);
    }
}

/* Up to half of the memory is taken. */
static void test_limit(void **state) {
    (void)state;
    const uint64_t most = mcv_memory_default();
    mcv_error error = {""};
    const uint64_t pixels = most / 16, left = most - 12 * pixels;
    assert_int_equal(mcv_memory_check_image("a.png", pixels, left, &error), MCV_OK);
    assert_int_equal(mcv_memory_check_image("a.png", pixels, left + 1, &error), MCV_BAD_INPUT);
}

/* 16 texts of 7.9 MB, packed: libpng would keep them all. */
static void test_packed_texts(void **state) {
    (void)state;
    enum { LENGTH = 7900000, TEXTS = 16 };
    const char *path = "image_limits_texts.png";
    uLongf size = compressBound(LENGTH);
    Bytef *text = calloc(LENGTH, 1), *packed = malloc(size + 3);
    FILE *file = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    assert_true(file && info && text && packed);
    memcpy(packed, "k\0", 3);
    memset(text, 'a', LENGTH);
    assert_int_equal(compress(packed + 3, &size, text, LENGTH), Z_OK);
    png_init_io(png, file);
    png_set_IHDR(png, info, 8, 1, 1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int i = 0; i < TEXTS; ++i)
        png_write_chunk(png, (png_const_bytep) "zTXt", packed, size + 3);
    png_write_row(png, (png_const_bytep) "\125");
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
    free(packed);

    struct rusage before, after;
    mcv_image image = {0};
    mcv_error error = {""};
    getrusage(RUSAGE_SELF, &before);
    if (mcv_values_read(path, &image, &error) != MCV_OK) fail_msg("%s", error.text);
    getrusage(RUSAGE_SELF, &after);
    assert_true(image.width == 8 && image.pixels[0] == 0 && image.pixels[1] == 255);
    /* 126 MB with the texts; two of them are allowed. */
    assert_in_range(after.ru_maxrss - before.ru_maxrss, 0, 2 * LENGTH / 1024);
    mcv_image_free(&image);
    free(text);
    assert_int_equal(unlink(path), 0);
}

/* The text of our key is found as another program may pack it, beside others. */
static void test_kinds_of_text(void **state) {
    (void)state;
    static const int kinds[] = {PNG_TEXT_COMPRESSION_NONE, PNG_TEXT_COMPRESSION_zTXt,
                                PNG_ITXT_COMPRESSION_NONE, PNG_ITXT_COMPRESSION_zTXt};
    const char *path = "image_limits_kind.png";
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        png_text texts[2] = {
            {.compression = kinds[(i + 1) % 4], .key = (char[]){"other"}, .text = (char[]){"x"}},
            {.compression = kinds[i],
             .key = (char[]){MCV_CAMERA_MODEL_KEY},
             .text = (char[]){"y"}}};
        FILE *file = fopen(path, "wb");
        png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
        png_infop info = png ? png_create_info_struct(png) : NULL;
        mcv_image image = {0};
        mcv_error error = {""};
        assert_true(file && info);
        png_init_io(png, file);
        png_set_IHDR(png, info, 1, 1, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_text(png, info, texts, 2);
        png_write_info(png, info);
        png_write_row(png, (png_const_bytep) "z");
        png_write_end(png, NULL);
        png_destroy_write_struct(&png, &info);
        assert_int_equal(fclose(file), 0);
        if (mcv_values_read(path, &image, &error) != MCV_OK) fail_msg("%s", error.text);
        if (!image.description || strcmp(image.description, "y") != 0)
            fail_msg("kind %d: %s", kinds[i], image.description ? image.description : "no text");
        mcv_image_free(&image);
    }
    assert_int_equal(unlink(path), 0);
}

/* A TIFF of one row in libtiff's mode, with three tags of 40000 bytes. */
static void write_tags(const char *path, const char *mode) {
    static const uint8_t row[SMALL] = {1, 2, 3, 4, 5, 6, 7, 8};
    static uint8_t values[40000];
    TIFF *tiff = TIFFOpen(path, mode);
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, SMALL);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 1);
    TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)sizeof values, values);
    TIFFSetField(tiff, TIFFTAG_PHOTOSHOP, (uint32_t)sizeof values, values);
    TIFFSetField(tiff, TIFFTAG_XMLPACKET, (uint32_t)sizeof values, values);
    assert_int_equal(TIFFWriteScanline(tiff, (void *)row, 0, 0), 1);
    TIFFClose(tiff);
}

static void begin_with(const char *path, const char *letters) {
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fwrite(letters, 1, strlen(letters), file), strlen(letters));
    assert_int_equal(fclose(file), 0);
}

static mcv_result read_tiff(const char *path, mcv_error *error) {
    mcv_image image = {0};
    const mcv_result result = mcv_values_read(path, &image, error);
    if (result == MCV_OK) assert_true(image.width == SMALL && image.pixels[7] == 8);
    mcv_image_free(&image);
    return result;
}

/* Tags that have their bytes each for itself are read, in each kind of TIFF; those that share them
 * are refused: libtiff would take memory for each. */
static void test_tags_that_share_bytes(void **state) {
    (void)state;
    static const char *const modes[] = {"wl", "wb", "w8l", "w8b", "wl (EP)"};
    const char *path = "image_limits_tags.tif";
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; ++i) {
        static uint8_t bytes[1 << 18];
        const bool is_large = modes[i][1] == '8', is_little = strchr(modes[i], 'l');
        const size_t word = is_large ? 8 : 4, entry = is_large ? 20 : 12;
        mcv_error error = {""};
        write_tags(path, modes[i]);
        if (strstr(modes[i], "EP")) begin_with(path, "EP"); /* which libtiff takes for "II" */
        if (read_tiff(path, &error) != MCV_OK) fail_msg("%s: %s", modes[i], error.text);
        /* Each tag gets 65344 bytes, which lie in the file: 196 kB in a file of 120 kB. */
        FILE *file = fopen(path, "r+b");
        assert_non_null(file);
        const size_t size = fread(bytes, 1, sizeof bytes, file);
        uint64_t at = 0;
        for (size_t k = 0; k < word; ++k)
            at = at << 8 | bytes[(is_large ? 8 : 4) + (is_little ? word - 1 - k : k)];
        int changed = 0;
        for (at += is_large ? 8 : 2; at + entry <= size; at += entry) {
            const unsigned tag =
                bytes[at + (is_little ? 0 : 1)] | (unsigned)bytes[at + (is_little ? 1 : 0)] << 8;
            if (tag != TIFFTAG_ICCPROFILE && tag != TIFFTAG_PHOTOSHOP && tag != TIFFTAG_XMLPACKET)
                continue;
            /* 40000 = 0x9c40 becomes 65344 = 0xff40. */
            bytes[at + 4 + (is_little ? 1 : word - 2)] = 0xff;
            ++changed;
        }
        assert_int_equal(changed, 3);
        rewind(file);
        assert_int_equal(fwrite(bytes, 1, size, file), size);
        assert_int_equal(fclose(file), 0);
        assert_int_equal(read_tiff(path, &error), MCV_BAD_INPUT);
        assert_non_null(strstr(error.text, "its tags have more bytes than the file"));
    }
    assert_int_equal(unlink(path), 0);
}

/* What is no array of two or three dimensions, or of a type that we know, is refused. */
static void test_npy_headers(void **state) {
    (void)state;
    static const struct {
        const char *header;
        mcv_result result;
    } cases[] = {
        {"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3), }", MCV_OK},
        {"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3,), }", MCV_OK},
        {"{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3), }", MCV_OK},
        {"{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3, 1), }", MCV_BAD_INPUT},
        {"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3x), }", MCV_BAD_INPUT},
        {"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3", MCV_BAD_INPUT},
        {"{'descr': '<u16', 'fortran_order': False, 'shape': (2, 3), }", MCV_BAD_INPUT}};
    const char *path = "image_limits_header.npy";
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_image image = {0};
        mcv_error error = {""};
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        fwrite("\x93NUMPY\x01\0\x76\0", 1, 10, file);
        fprintf(file, "%-117s\n", cases[i].header);
        fwrite("123456", 1, 6, file);
        assert_int_equal(fclose(file), 0);
        const mcv_result result = mcv_values_read(path, &image, &error);
        if (result != cases[i].result) fail_msg("%s: %d", cases[i].header, result);
        mcv_image_free(&image);
    }
    assert_int_equal(unlink(path), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_packed_texts),
        cmocka_unit_test(test_kinds_of_text),
        cmocka_unit_test(test_tags_that_share_bytes),
        cmocka_unit_test(test_npy_headers),
        cmocka_unit_test(test_large_images_are_refused),
        cmocka_unit_test(test_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
