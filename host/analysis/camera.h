/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From light to the grey values of a camera: the linear model of EMVA Standard 1288 (release 4.0
 * Linear). A pixel collects a Poisson number of electrons, at most u_e.sat. Its mean is mu_e from
 * light plus mu_d = mu_I t_exp of dark current. Read noise with the standard deviation sigma_d0 is
 * added. The system gain K converts the sum to grey values [DN]; the black level is added; the
 * result is rounded and clipped to the bits of the converter:
 *
 *     mean                 mu_y = black level + K (mu_e + mu_d)
 *     temporal variance    sigma_y² = K² (mu_e + mu_d + sigma_d0²) + 1/12
 *
 * Each pixel has an offset, normal with the standard deviation DSNU1288 [e-], and a sensitivity,
 * normal about 1 with the standard deviation PRNU1288. This fixed pattern belongs to one camera and
 * is the same in all its exposures.
 */
#ifndef MCVISI_HOST_ANALYSIS_CAMERA_H
#define MCVISI_HOST_ANALYSIS_CAMERA_H

#include "analysis/region.h"

enum { MCV_CAMERA_MAX_BITS = 16 };

/* X(NAME, "pattern"): the colours of the top-left 2 x 2 pixels, row by row; without one each pixel
 * reads all channels of the image. */
#define MCV_BAYER_PATTERNS(X) \
    X(NONE, "none") \
    X(RGGB, "RGGB") \
    X(BGGR, "BGGR") \
    X(GRBG, "GRBG") \
    X(GBRG, "GBRG")
enum {
#define MCV_X(NAME, pattern) MCV_BAYER_##NAME,
    MCV_BAYER_PATTERNS(MCV_X)
#undef MCV_X
};
extern const char *const mcv_bayer_patterns[];

typedef struct mcv_camera {
    double electrons_per_unit[3]; /* mu_e over the value of the image, >= 0, for red, green and
                                     blue; grey images use the first */
    double dark_electrons;        /* mu_d = mu_I t_exp [e-], >= 0 */
    double full_well;             /* u_e.sat [e-], above 0, at most 1e12 */
    double gain;                  /* K [DN/e-], above 0 */
    double read_noise;            /* sigma_d0 [e-], >= 0 */
    double dsnu;                  /* DSNU1288 [e-], >= 0 */
    double prnu;                  /* PRNU1288, a fraction, >= 0 */
    uint32_t bits;                /* 1 … 16 */
    uint32_t black_level;         /* [DN], below 2^bits */
    uint32_t bayer;               /* MCV_BAYER_… */
    uint32_t specimen;            /* number of the specimen, which determines the fixed pattern */
    uint32_t seed;                /* of the exposure */
    bool noise_free; /* neither noise nor fixed pattern: only full well, rounding and clipping */
} mcv_camera;

/*
 * mu_e for 1 W/m²: quantum_efficiency eta (0 … 1] times the photons of energy h c / wavelength [m]
 * that fall on pixel_area [m²] in exposure_time t_exp [s].
 */
double mcv_camera_electrons_per_irradiance(double exposure_time, double quantum_efficiency,
                                           double wavelength, double pixel_area);

/*
 * The level of the bright parts of an image, in electrons. Its expected value does not depend on
 * the render's error: it is the same for few samples and for many. It is the larger of two levels,
 * both means weighed by brightness μ:
 *
 *     - of single pixels Σμ²/Σμ, from values y and their standard errors u: Σ(y² - u²)/Σy. It
 *       suits bright lines and spots on a dark background.
 *     - of blocks of 16 x 16 pixels Σμ^16/Σμ^15, near that of the brightest block. A block's 16
 *       interleaved lattices have independent errors, and a product of means of different
 *       lattices is free of their error on average.
 *
 * The uncertainty is that of the render's error, to first order; with few samples the brightest
 * block is uncertain. `shared` is the correlation of channels (mcv_film_channel_correlation). It
 * counts by each channel's slope of the level, which the brightest one rules.
 * light_error NULL: the second level, if it exists, with the uncertainty NaN. 0 for a dark image.
 * The errors of neighbours must be independent, so the image must not be blurred by a lens before.
 */
mcv_quantity mcv_camera_level(const mcv_image *light, const mcv_image *light_error, double shared,
                              const double electrons_per_unit[3]);

typedef struct mcv_exposure {
    mcv_image grey;        /* whole numbers 0 … 2^bits - 1; one channel with a Bayer pattern */
    mcv_image uncertainty; /* standard uncertainty of a grey value [DN]: noise, fixed pattern,
                              rounding, and the light's own error */
    mcv_image render;   /* of that the light's own error [DN], none where the pixel is saturated; no
                           pixels where it is not known */
    double electrons;   /* mu_e on average over the image */
    double brightest;   /* the largest mu_e */
    uint64_t saturated; /* values at full well or at the largest grey value */
    uint64_t
        below_zero; /* values that read noise took below grey value 0, where they were clipped */
} mcv_exposure;

/* Is it finite and not negative? MCV_BAD_INPUT names the first pixel that is not. */
mcv_result mcv_camera_check_light(const mcv_image *light, mcv_error *error);

/*
 * Exposes; light_error is the standard error of the light, or NULL. The images in *exposure are
 * made here and freed by mcv_exposure_free. The same camera and light give the same grey values.
 * MCV_BAD_INPUT for light that is negative or not finite (the sentence names the pixel), MCV_USAGE
 * for parameters out of range.
 */
mcv_result mcv_camera_expose(const mcv_camera *camera, const mcv_image *light,
                             const mcv_image *light_error, mcv_exposure *exposure,
                             mcv_error *error);
void mcv_exposure_free(mcv_exposure *exposure);

#endif
