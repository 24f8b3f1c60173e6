/* SPDX-License-Identifier: Apache-2.0 */
/* Small pictures inside pages: their size, and the means of blocks. */
#include "test.h"

#include "io/png.h"
#include "io/thumbnail.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The picture of an <img>, decoded by coreutils and our own reader. */
static void decode(const mcv_image *image, mcv_image *shown, const char *starts_with) {
    char path[] = "/tmp/thumbnail-XXXXXX.png", command[128];
    char *text = NULL;
    size_t size = 0;
    mcv_error error;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    mcv_thumbnail_put(out, image, "a \"b\"");
    fclose(out);
    if (strncmp(text, starts_with, strlen(starts_with)) != 0) fail_msg("%.80s", text);
    char *data = strstr(text, "base64,"), *end = data ? strrchr(text, '"') : NULL;
    if (!end) {
        fail_msg("there is no picture: %s", text);
        return;
    }
    *end = '\0';
    const int file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    snprintf(command, sizeof command, "base64 -d >%s", path);
    FILE *pipe = popen(command, "w");
    assert_non_null(pipe);
    fputs(data + strlen("base64,"), pipe);
    assert_int_equal(pclose(pipe), 0);
    assert_int_equal(mcv_png_read_values(path, shown, &error), MCV_OK);
    unlink(path);
    free(text);
}

/* 400 x 100 pixels of three colours become 134 x 34: a block of three by three is their mean, those
 * at the border what is there. */
static void test_blocks(void **state) {
    mcv_image image, shown;
    mcv_error error;
    (void)state;
    assert_int_equal(mcv_image_new(&image, 400, 100, 3, &error), MCV_OK);
    for (size_t i = 0; i < (size_t)3 * 400 * 100; ++i) image.pixels[i] = 0.25f;
    for (size_t i = 0; i < 400 * 100; ++i) image.pixels[i] = 1; /* red: white is 1 */
    /* Eight of the first block's nine green values are left; the infinite one does not count. */
    image.pixels[400 * 100] = INFINITY;
    image.pixels[400 * 100 + 1] = 2.25f;
    decode(&image, &shown, "<img alt=\"a &quot;b&quot;\" width=\"134\" height=\"34\" src=\"data:");
    assert_true(shown.width == 134 && shown.height == 34 && shown.channels == 3);
    const size_t pixels = (size_t)134 * 34;
    for (size_t i = 0; i < pixels; ++i) {
        /* (2.25 + 7 · 0.25)/8 = 0.5 */
        const double green = i == 0 ? 0.5 : 0.25;
        assert_true(shown.pixels[i] == 255 &&
                    shown.pixels[pixels + i] == (float)mcv_srgb_of(green) &&
                    shown.pixels[2 * pixels + i] == (float)mcv_srgb_of(0.25));
    }
    mcv_image_free(&shown);
    mcv_image_free(&image);
}

/* A small one stays as it is; what has no colours has no picture. */
static void test_small_and_none(void **state) {
    mcv_image image, shown;
    mcv_error error;
    char *text = NULL;
    size_t size = 0;
    (void)state;
    assert_int_equal(mcv_image_new(&image, 5, 2, 1, &error), MCV_OK);
    for (size_t i = 0; i < 10; ++i) image.pixels[i] = (float)i / 8;
    decode(&image, &shown, "<img alt=\"a &quot;b&quot;\" width=\"5\" height=\"2\" src=\"data:");
    assert_true(shown.width == 5 && shown.height == 2 && shown.channels == 1);
    assert_true(shown.pixels[0] == 0 && shown.pixels[9] == 255);
    mcv_image_free(&shown);
    image.channels = 2;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    mcv_thumbnail_put(out, &image, "none");
    fclose(out);
    assert_int_equal(size, 0);
    free(text);
    image.channels = 1;
    mcv_image_free(&image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks),
        cmocka_unit_test(test_small_and_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
