/* SPDX-License-Identifier: Apache-2.0 */
/* Range images that the program has written. */
#ifndef MCVISI_TESTS_RANGE_IMAGE_H
#define MCVISI_TESTS_RANGE_IMAGE_H

#include "test.h"

#include "io/exr.h"

#include <math.h>
#include <string.h>

/* The mean of what is seen in a part of a range image's row, and how many places that are (or
 * NULL). */
static inline double row_mean(const char *path, const char *part, uint32_t row, uint32_t *seen) {
    mcv_exr exr;
    mcv_error error;
    double sum = 0, count = 0;
    if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    uint32_t number = 0;
    while (number < exr.part_count && strcmp(exr.parts[number].name, part) != 0) ++number;
    assert_true(number < exr.part_count);
    const mcv_image *image = &exr.parts[number].image;
    for (uint32_t i = 0; i < image->width; ++i) {
        const double value = (double)image->pixels[row * image->width + i];
        if (isnan(value)) continue;
        sum += value;
        ++count;
    }
    mcv_exr_free(&exr);
    if (seen) *seen = (uint32_t)count;
    return sum / count;
}

#endif
