/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Peak locking: what an extractor errs by where in a pixel the line lies. Light at sub-pixels is
 * gathered into pixels that begin a sub-pixel later each time, so that the same line moves through
 * a pixel by known steps.
 */
#include "verbs/scan.h"

#include "io/exr_make.h"

#include <math.h>
#include <stdlib.h>

/* Gathers the light of pixels that begin `shift` sub-pixels later across the line. */
static void gather(const mcv_scan *s, const mcv_image *laser, uint32_t shift, mcv_image *light) {
    const uint32_t q = s->subpixels, right = s->axis ? 0 : shift, down = s->axis ? shift : 0;
    const size_t plane = (size_t)light->width * light->height;
    for (size_t i = 0; i < plane * light->channels; ++i) {
        const size_t channel = i / plane, row = i % plane / light->width, column = i % light->width;
        double sum = 0;
        for (size_t y = row * q + down; y < (row + 1) * q + down && y < laser->height; ++y)
            for (size_t x = column * q + right; x < (column + 1) * q + right && x < laser->width;
                 ++x)
                sum += (double)laser->pixels[(channel * laser->height + y) * laser->width + x];
        light->pixels[i] = (float)(sum / ((double)q * q));
    }
}

/* The places of one shift, with what it has moved them. */
static mcv_result find_places(mcv_scan *s, const mcv_exr *light, const mcv_exr *laser,
                              uint32_t shift, double *places, mcv_error *error) {
    mcv_profiles profiles;
    mcv_exr shifted;
    MCV_TRY(mcv_profiles_begin(&s->command, (mcv_texts){NULL, 0}, &profiles, error));
    profiles.count = 1;
    MCV_TRY(mcv_exr_copy(light, &shifted, error));
    gather(s, &laser->parts[0].image, shift, &shifted.parts[0].image);
    const mcv_result result = mcv_scan_find(s, MCV_SCAN_CLEAN, 0, &shifted, NULL, &profiles, error);
    for (uint32_t i = 0; result == MCV_OK && i < profiles.length; ++i) {
        const mcv_line_place *line = &profiles.points[i].line;
        places[i] = line->state == MCV_LINE_SEEN ? line->place + (double)shift / s->subpixels : NAN;
    }
    mcv_exr_free(&shifted);
    mcv_profiles_free(&profiles);
    return result;
}

mcv_result mcv_scan_lock(mcv_scan *s, const mcv_exr *light, const mcv_exr *laser,
                         mcv_error *error) {
    const uint32_t q = s->subpixels, length = s->model.size[!s->axis];
    double *places = calloc((size_t)q * length + 1, sizeof *places), squares = 0, count = 0;
    if (!places) return mcv_fail(error, MCV_FAILED, "%s: no memory for a scan", s->name);
    mcv_result result = MCV_OK;
    for (uint32_t k = 0; result == MCV_OK && k < q; ++k)
        result = find_places(s, light, laser, k, places + (size_t)k * length, error);
    for (uint32_t i = 0; result == MCV_OK && i < length; ++i) {
        double mean = 0;
        for (uint32_t k = 0; k < q; ++k) mean += places[(size_t)k * length + i] / q;
        if (isnan(mean)) continue;
        for (uint32_t k = 0; k < q; ++k) squares += pow(places[(size_t)k * length + i] - mean, 2);
        count += q - 1.0;
    }
    free(places);
    s->locking = sqrt(squares / count);
    return result;
}
