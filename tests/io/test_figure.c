/* SPDX-License-Identifier: Apache-2.0 */
/* Colours of numbers, and where they stand in a picture. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/axis.h"
#include "io/figure.h"

static const char PATH[] = "test_figure.png";

/* Relative luminance of linear light, IEC 61966-2-1. */
static double luminance(uint32_t rgb) {
    const double weights[] = {0.2126, 0.7152, 0.0722};
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        const double value = (rgb >> (16 - 8 * c) & 255) / 255.0;
        sum += weights[c] * (value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4));
    }
    return sum;
}

static void test_colormaps(void **state) {
    (void)state;
    /* Colours of viridis' own table of 256, 8 bits: both ends, and places that are none of our
     * control colours. */
    const struct {
        int index;
        uint8_t rgb[3];
    } viridis[] = {{0, {68, 1, 84}},      {28, {72, 40, 120}},   {85, {49, 104, 142}},
                   {128, {33, 145, 140}}, {170, {53, 183, 121}}, {227, {181, 222, 43}},
                   {255, {253, 231, 37}}};
    for (size_t i = 0; i < sizeof viridis / sizeof viridis[0]; ++i) {
        const uint32_t rgb = mcv_colormap_rgb(MCV_COLORMAP_VIRIDIS, viridis[i].index / 255.0);
        for (int c = 0; c < 3; ++c) {
            /* 1.7 by linear interpolation, 0.5 each by rounding here and in the table. */
            const int off = (int)(rgb >> (16 - 8 * c) & 255) - viridis[i].rgb[c];
            if (off < -2 || off > 2)
                fail_msg("viridis at %d/255: channel %d is off by %d", viridis[i].index, c, off);
        }
    }
    for (int map = MCV_COLORMAP_GREY; map <= MCV_COLORMAP_VIRIDIS; ++map) {
        double last = -1;
        for (int i = 0; i <= 64; ++i) {
            const double bright = luminance(mcv_colormap_rgb(map, i / 64.0));
            if (!(bright > last))
                fail_msg("colours %d: position %d/64 is not brighter than the one before", map, i);
            last = bright;
        }
        assert_int_equal(mcv_colormap_rgb(map, -INFINITY), mcv_colormap_rgb(map, 0));
        assert_int_equal(mcv_colormap_rgb(map, INFINITY), mcv_colormap_rgb(map, 1));
    }
    assert_int_equal(mcv_colormap_rgb(MCV_COLORMAP_GREY, 0.4), 0x666666);
}

/* Each value's square holds its colour, NaN is grey, and the bar runs from the first colour at its
 * foot to the last. */
static void test_picture(void **state) {
    (void)state;
    enum { ZOOM = 6, X = 10, Y = 20 };
    const float values[] = {-1, 0, 0.5F, 2, 3, NAN};
    mcv_image image;
    mcv_error error = {""};
    const mcv_color_scale scale = {.map = MCV_COLORMAP_VIRIDIS, .low = 0, .high = 2};
    cairo_t *page;
    assert_int_equal(mcv_image_new(&image, 3, 2, 1, &error), MCV_OK);
    memcpy(image.pixels, values, sizeof values);
    assert_int_equal(mcv_page_new(&page, 200, 150, 12, &error), MCV_OK);
    mcv_page_image(page, X, Y, &image, ZOOM, &scale);
    mcv_page_color_bar(page, 60, Y, 100, "label", &scale);
    assert_int_equal(mcv_page_write(page, PATH, &error), MCV_OK);

    cairo_surface_t *read = cairo_image_surface_create_from_png(PATH);
    assert_int_equal(cairo_surface_status(read), CAIRO_STATUS_SUCCESS);
    assert_int_equal(cairo_image_surface_get_width(read), 200);
    assert_int_equal(cairo_image_surface_get_height(read), 150);
    const unsigned char *bytes = cairo_image_surface_get_data(read);
    const size_t stride = (size_t)cairo_image_surface_get_stride(read);
    for (int i = 0; i < 6; ++i) {
        for (int y = 0; y < ZOOM; ++y) {
            for (int x = 0; x < ZOOM; ++x) {
                uint32_t rgb;
                memcpy(&rgb,
                       bytes + (size_t)(Y + i / 3 * ZOOM + y) * stride +
                           4 * (size_t)(X + i % 3 * ZOOM + x),
                       sizeof rgb);
                rgb &= 0xffffff;
                const bool right = isnan(values[i])
                                       ? (rgb >> 16 == (rgb & 255) && rgb >> 16 == (rgb >> 8 & 255))
                                       : rgb == mcv_colormap_rgb(scale.map, (double)values[i] / 2);
                if (!right) fail_msg("value %g is shown as %06x", (double)values[i], rgb);
            }
        }
    }
    for (int row = 2; row < 98; ++row) {
        uint32_t rgb;
        memcpy(&rgb, bytes + (size_t)(Y + row) * stride + 4 * 65, sizeof rgb);
        assert_int_equal(rgb & 0xffffff, mcv_colormap_rgb(scale.map, 1 - (row + 0.5) / 100));
    }
    cairo_surface_destroy(read);
    mcv_image_free(&image);
    unlink(PATH);
}

static void test_bad_path(void **state) {
    (void)state;
    mcv_image image;
    mcv_error error = {""};
    const mcv_color_scale scale = {.map = MCV_COLORMAP_GREY, .high = 1};
    assert_int_equal(mcv_image_new(&image, 3, 2, 1, &error), MCV_OK);
    assert_int_equal(
        mcv_figure_write("nowhere/figure.png", &image, "title", "label", &scale, &error),
        MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "nowhere/figure.png"));
    mcv_image_free(&image);
}

/* The numbers of a horizontal axis stand apart, also long ones: half of each, of 7.7 pixels a digit
 * as DejaVu Sans has at 12 pixels. Ticks lie at 1, 2 or 5 times a power of ten, so that at least
 * one number in three fits. */
static void test_numbers_stand_apart(void **state) {
    static const double ranges[][2] = {{0.00056, 0.000605}, {0, 10}, {-3.7e-7, -3.2e-7}};
    (void)state;
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; ++i) {
        char *text = NULL;
        size_t size, numbers = 0, lines = 0;
        double before = -INFINITY;
        FILE *out = open_memstream(&text, &size);
        assert_non_null(out);
        const mcv_axis across = mcv_axis_over(ranges[i][0], ranges[i][1], false, MCV_PLOT_LEFT,
                                              MCV_PLOT_WIDTH - MCV_PLOT_RIGHT),
                       up = mcv_axis_over(0, 1, false, 0, 100);
        mcv_axes_put(out, &across, &up, "x", "y");
        assert_int_equal(fclose(out), 0);
        for (const char *at = text; (at = strstr(at, "<text x=\"")); ++at) {
            char *rest;
            const double x = strtod(at + strlen("<text x=\""), &rest);
            const char *words = strstr(rest, ">") + 1;
            if (strncmp(words - 9, "\"middle\"", 8) != 0) continue;
            const double half = 7.7 / 2 * (double)strcspn(words, "<");
            if (x - half < before) fail_msg("the number at %g begins before %g", x, before);
            before = x + half;
            ++numbers;
        }
        for (const char *at = text; (at = strstr(at, "V288\"/>")); ++at) ++lines;
        assert_true(lines >= 5 && 3 * numbers >= lines);
        free(text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colormaps), cmocka_unit_test(test_picture),
        cmocka_unit_test(test_bad_path), cmocka_unit_test(test_numbers_stand_apart)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
