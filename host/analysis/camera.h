/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From light to the grey values of a camera, the linear model of EMVA Standard 1288 (release 4.0 Linear). A pixel collects
 * mu_e electrons on average, a Poisson number of them, at most u_e.sat; noise of standard deviation sigma_d is added, the system
 * gain K makes grey values [DN] of it, the black level is added and the sum is rounded and clipped to the bits of the converter:
 *
 *     mean mu_y = black level + K mu_e        variance sigma_y² = K² (mu_e + sigma_d²) + 1/12
 */
#ifndef MCVISI_HOST_ANALYSIS_CAMERA_H
#define MCVISI_HOST_ANALYSIS_CAMERA_H

#include "film/film.h"

enum { MCV_CAMERA_MAX_BITS = 16 };

typedef struct mcv_camera {
    double electrons_per_unit; /* mu_e over the value of the image, >= 0 */
    double full_well;          /* u_e.sat [e-], above 0, at most 1e12 */
    double gain;               /* K [DN/e-], above 0 */
    double read_noise;         /* sigma_d [e-], the temporal dark noise, >= 0 */
    uint32_t bits;             /* 1 … 16 */
    uint32_t black_level;      /* [DN], below 2^bits */
    uint32_t seed;
    bool noise_free; /* neither shot nor read noise: what remains is full well, rounding and clipping */
} mcv_camera;

/*
 * mu_e for 1 W/m²: quantum_efficiency eta (0 … 1] times the photons of energy h c / wavelength [m] that fall on pixel_area [m²] in
 * exposure_time t_exp [s].
 */
double mcv_camera_electrons_per_irradiance(double exposure_time, double quantum_efficiency, double wavelength, double pixel_area);

typedef struct mcv_exposure {
    mcv_image grey;      /* whole numbers 0 … 2^bits - 1 */
    double electrons;    /* mu_e on average over the image */
    double brightest;    /* the largest mu_e */
    uint64_t saturated;  /* values at full well or at the largest grey value */
    uint64_t below_zero; /* values that read noise took below grey value 0, where they were clipped */
} mcv_exposure;

/*
 * Exposes; the image in *exposure is made here and freed by the caller. The same camera and light give the same grey values.
 * MCV_BAD_INPUT for light that is negative or not finite (the sentence names the pixel), MCV_USAGE for parameters out of range.
 */
mcv_result mcv_camera_expose(const mcv_camera *camera, const mcv_image *light, mcv_exposure *exposure, mcv_error *error);

#endif
