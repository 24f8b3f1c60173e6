/* SPDX-License-Identifier: Apache-2.0 */
/* Regions of an image: their shapes, and an estimate of the noise inside. */
#include "analysis/region_noise.h"

#include "analysis/form.h"
#include "io/values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_NUMBERS = 256 };

mcv_result mcv_place_check_name(const char *what, const char *text, mcv_error *error) {
    const char *equals = strchr(text, '=');
    if (!equals || equals - text < 64) return MCV_OK;
    return mcv_fail(error, MCV_USAGE, "%s %s: its name has %td bytes: at most 63 are allowed", what,
                    text, equals - text);
}

size_t mcv_roi_numbers(const char *text, size_t number, char name[64], const char **rest,
                       double *numbers, size_t most) {
    const char *equals = strchr(text, '=');
    if (equals && equals > text)
        snprintf(name, 64, "%.*s", (int)(equals - text), text);
    else
        snprintf(name, 64, "%zu", number);
    *rest = equals ? equals + 1 : text;
    if ((*rest)[strspn(*rest, "0123456789.+-eE, ")] != '\0') return 0;
    size_t count = 0;
    for (const char *c = *rest; count < most; ++c) {
        char *end;
        numbers[count] = strtod(c, &end);
        if (end == c || !isfinite(numbers[count])) return 0;
        ++count;
        c = end + strspn(end, " ");
        if (*c == '\0') return count;
        if (*c != ',') return 0;
    }
    return 0;
}

/* Even-odd: how many edges a ray to the left meets. */
static bool in_polygon(const double *corners, size_t count, double x, double y) {
    bool inside = false;
    for (size_t i = 0, j = count - 1; i < count; j = i++) {
        const double *a = corners + 2 * i, *b = corners + 2 * j;
        if ((a[1] > y) != (b[1] > y) && x > a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
            inside = !inside;
    }
    return inside;
}

static mcv_result fill_polygon(const char *text, const double *corners, size_t count,
                               mcv_roi *region, mcv_error *error) {
    for (size_t i = 0; i < count; ++i)
        if (!(corners[2 * i] >= 0 && corners[2 * i] <= region->width && corners[2 * i + 1] >= 0 &&
              corners[2 * i + 1] <= region->height))
            return mcv_fail(
                error, MCV_USAGE,
                "region %s extends to column %g, row %g: the image has only %u x %u pixels", text,
                corners[2 * i], corners[2 * i + 1], region->width, region->height);
    for (uint32_t y = 0; y < region->height; ++y)
        for (uint32_t x = 0; x < region->width; ++x)
            region->inside[(size_t)y * region->width + x] =
                in_polygon(corners, count, x + 0.5, y + 0.5);
    return MCV_OK;
}

static mcv_result fill_mask(const char *text, const char *path, mcv_roi *region, mcv_error *error) {
    mcv_image mask;
    if (!mcv_values_named(path))
        return mcv_fail(
            error, MCV_USAGE,
            "region %s must be X,Y,W,H, a polygon X,Y,X,Y,X,Y,… or an image " MCV_VALUES_ENDINGS,
            text);
    MCV_TRY(mcv_values_read(path, &mask, error));
    const bool fits = mask.width == region->width && mask.height == region->height;
    const mcv_result result =
        fits ? MCV_OK
             : mcv_fail(error, MCV_BAD_INPUT, "%s: a mask of %u x %u pixels: the image has %u x %u",
                        path, mask.width, mask.height, region->width, region->height);
    for (size_t i = 0; fits && i < (size_t)region->width * region->height; ++i)
        region->inside[i] = mask.pixels[i] > 0;
    mcv_image_free(&mask);
    return result;
}

mcv_result mcv_roi_parse(const char *text, size_t number, const mcv_image *image, mcv_roi *region,
                         mcv_error *error) {
    double n[MAX_NUMBERS];
    const char *rest;
    *region = (mcv_roi){.width = image->width, .height = image->height};
    MCV_TRY(mcv_place_check_name("region", text, error));
    const size_t count = mcv_roi_numbers(text, number, region->name, &rest, n, MAX_NUMBERS),
                 plane = (size_t)image->width * image->height;
    region->inside = calloc(plane, 1);
    if (!region->inside) return mcv_fail(error, MCV_FAILED, "region %s: no memory for it", text);
    mcv_result result;
    if (count == 4) {
        const double box[] = {n[0],        n[1],        n[0] + n[2], n[1],
                              n[0] + n[2], n[1] + n[3], n[0],        n[1] + n[3]};
        result = fill_polygon(text, box, 4, region, error);
    } else if (count >= 6 && count % 2 == 0) {
        result = fill_polygon(text, n, count / 2, region, error);
    } else {
        result = fill_mask(text, rest, region, error);
    }
    for (size_t i = 0; result == MCV_OK && i < plane; ++i) {
        region->inside[i] = region->inside[i] && !isnan(image->pixels[i]);
        region->count += region->inside[i];
    }
    if (result == MCV_OK && region->count == 0)
        result = mcv_fail(error, MCV_USAGE, "region %s contains no pixel of the image", text);
    if (result != MCV_OK) mcv_roi_free(region);
    return result;
}

void mcv_roi_free(mcv_roi *region) {
    free(region->inside);
    region->inside = NULL;
}

/* --- noise --- */

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static bool has_neighbours(const mcv_roi *r, uint32_t x, uint32_t y) {
    for (uint32_t j = y - 1; j <= y + 1; ++j)
        for (uint32_t i = x - 1; i <= x + 1; ++i)
            if (!r->inside[(size_t)j * r->width + i]) return false;
    return true;
}

double mcv_roi_estimate_freedom(uint64_t differences) {
    return differences ? ((double)differences + 4) / 6 : INFINITY;
}

double mcv_roi_estimate_noise(mcv_readings *readings, mcv_roi *region, double least) {
    static const float stencil[3][3] = {
        {1, -2, 1}, {-2, 4, -2}, {1, -2, 1}};   /* noise of 1 makes 6 */
    const double median_of_normal = 0.67448975; /* of |Z| */
    const uint32_t width = region->width;
    float *found = malloc(region->count * sizeof *found);
    size_t count = 0;
    for (uint32_t y = 1; found && y + 1 < region->height; ++y)
        for (uint32_t x = 1; x + 1 < width; ++x) {
            float sum = 0;
            if (!has_neighbours(region, x, y)) continue;
            for (uint32_t j = 0; j < 3; ++j)
                for (uint32_t i = 0; i < 3; ++i)
                    sum += stencil[j][i] *
                           readings->values.pixels[(size_t)(y - 1 + j) * width + x - 1 + i];
            found[count++] = fabsf(sum);
        }
    double noise = NAN, render = 0;
    for (size_t i = 0; i < (size_t)width * region->height; ++i)
        if (region->inside[i])
            render += mcv_readings_render_variance(readings, i) / (double)region->count;
    if (count) {
        qsort(found, count, sizeof *found, compare_floats);
        const double median = 0.5 * ((double)found[(count - 1) / 2] + found[count / 2]);
        const double all =
            median / (6 * median_of_normal * sqrt(mcv_roi_estimate_bias((double)count)));
        noise = render > 0
                    ? sqrt(fmax(0, all * all - mcv_readings_correlation(readings).stencil * render))
                    : all;
        noise = fmax(least, noise);
    }
    free(found);
    region->estimated = count;
    for (size_t i = 0; i < (size_t)width * region->height; ++i)
        if (region->inside[i])
            readings->deviation.pixels[i] =
                (float)hypot(noise, sqrt(mcv_readings_render_variance(readings, i)));
    return noise;
}
