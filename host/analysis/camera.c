/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/camera.h"
#include "analysis/noise.h"

#include <math.h>

double mcv_camera_electrons_per_irradiance(double exposure_time, double quantum_efficiency, double wavelength, double pixel_area) {
    const double planck = 6.62607015e-34; /* [J s], exact in the SI of 2019, as is c [m/s] */
    const double light_speed = 299792458;
    return quantum_efficiency * pixel_area * exposure_time * wavelength / (planck * light_speed);
}

static mcv_result check_camera(const mcv_camera *c, mcv_error *error) {
    if (c->bits < 1 || c->bits > MCV_CAMERA_MAX_BITS)
        return mcv_fail(error, MCV_USAGE, "a camera of %u bits: must be 1 to %d", c->bits, MCV_CAMERA_MAX_BITS);
    if (c->black_level >= 1u << c->bits) {
        return mcv_fail(error, MCV_USAGE, "a black level of %u DN: must be below %u, the grey values of %u bits", c->black_level,
                        1u << c->bits, c->bits);
    }
    if (!(c->full_well > 0 && c->full_well <= 1e12 && c->gain > 0 && isfinite(c->gain))) {
        return mcv_fail(error, MCV_USAGE, "a full well of %g e- and a gain of %g DN/e-: must be above 0 and at most 1e12, and above 0",
                        c->full_well, c->gain);
    }
    if (!(c->read_noise >= 0 && isfinite(c->read_noise) && c->electrons_per_unit >= 0 && isfinite(c->electrons_per_unit))) {
        return mcv_fail(error, MCV_USAGE, "a read noise of %g e- and a scale of %g e- per unit: both must be at least 0 and finite",
                        c->read_noise, c->electrons_per_unit);
    }
    return MCV_OK;
}

static mcv_result check_light(const mcv_image *light, mcv_error *error) {
    const size_t plane = (size_t)light->width * light->height;
    for (size_t i = 0; i < plane * light->channels; ++i) {
        if (light->pixels[i] >= 0 && isfinite(light->pixels[i])) continue;
        return mcv_fail(error, MCV_BAD_INPUT, "the pixel in column %zu, row %zu, channel %zu, is %g: light must be finite and not negative",
                        i % plane % light->width, i % plane / light->width, i / plane, light->pixels[i]);
    }
    return MCV_OK;
}

/* Electrons that are read from a pixel. */
static double collect(const mcv_camera *c, double mean, mcv_noise *noise) {
    /* Far above any full well the noise does not matter, and its doubles are no whole numbers any more. */
    if (c->noise_free || mean > 0x1p50) return fmin(mean, c->full_well);
    return fmin(mcv_noise_poisson(noise, mean), c->full_well);
}

mcv_result mcv_camera_expose(const mcv_camera *camera, const mcv_image *light, mcv_exposure *exposure, mcv_error *error) {
    *exposure = (mcv_exposure){0};
    MCV_TRY(check_camera(camera, error));
    MCV_TRY(check_light(light, error));
    MCV_TRY(mcv_image_new(&exposure->grey, light->width, light->height, light->channels, error));
    const double largest = (double)((1u << camera->bits) - 1);
    const size_t plane = (size_t)light->width * light->height;
    for (size_t i = 0; i < plane * light->channels; ++i) {
        mcv_noise noise = mcv_noise_begin(camera->seed, (uint32_t)(i / plane), i % plane);
        const double mean = camera->electrons_per_unit * (double)light->pixels[i];
        const double electrons = collect(camera, mean, &noise);
        const double dark = camera->noise_free || camera->read_noise == 0 ? 0 : camera->read_noise * mcv_noise_normal(&noise);
        const double grey = floor(camera->black_level + camera->gain * (electrons + dark) + 0.5);
        exposure->grey.pixels[i] = (float)fmin(fmax(grey, 0), largest);
        exposure->electrons += mean;
        exposure->brightest = fmax(exposure->brightest, mean);
        exposure->saturated += electrons >= camera->full_well || grey >= largest;
        exposure->below_zero += grey < 0;
    }
    exposure->electrons /= (double)(plane * light->channels);
    return MCV_OK;
}
