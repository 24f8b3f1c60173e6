/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Laser speckle in the image of a rough surface (subjective speckle; Goodman, Speckle Phenomena in
 * Optics, 2007, chapters 3 to 6). The lens adds up fields of random phase: with the mean irradiance
 * E of the laser's light and independent circular complex normal numbers n,
 *
 *     U = F⁻¹(P · F(√E n))    I = Σ w |U|² / ∫|h|²    Σ w = 1
 *
 * The numbers n belong to the surface where it is known, and to the film's sub-pixels elsewhere.
 * P is the pupil, 1 within the frequency 1/(2λN) where the aperture is open, and h = F⁻¹ P.
 * So grains are as large as the lens's diffraction at the working f-number N makes them. The mean
 * of I is E blurred by diffraction. Each w is a pattern of its own: two polarisations have (1 ±
 * p)/2, and M patterns that other causes make have contrast 1/√M.
 */
#ifndef MCVISI_HOST_ANALYSIS_SPECKLE_H
#define MCVISI_HOST_ANALYSIS_SPECKLE_H

#include "analysis/surface_noise.h"
#include "scene/aperture.h"

typedef struct mcv_speckle {
    double f_number;             /* of the full disc: working, image side, above 0 */
    mcv_aperture_shape aperture; /* what of the disc is open: of valid numbers */
    bool disc_blurred;           /* the light's mean is blurred by the full disc, not by P */
    double wavelength;           /* [m] */
    double pitch[2];             /* width and height of a sub-pixel [m], at most λN/4 */
    double polarization;         /* degree of polarisation of the scattered light: 0 … 1 */
    double patterns;             /* M >= 1 */
    uint32_t seed;
    uint32_t exposure; /* of a part that moves: numbers of the film are others in each */
    const mcv_surface_noise *surface; /* with which n moves: of width x height pixels; or NULL */
} mcv_speckle;

/* Sub-pixels across a pixel of this size [m] that resolve the grains: 4 p/(λN), rounded up. */
uint32_t mcv_speckle_subpixels(double pixel, double wavelength, double f_number);

/*
 * How many patterns a spectrum of this full width at half maximum [m] makes on a surface of this
 * standard deviation of height [m], seen and lit near its normal:
 * √(1 + 64 π² (σ_λ/λ)² (σ_h/λ)²).
 */
double mcv_speckle_spectral_patterns(double linewidth, double wavelength, double roughness);

/*
 * Adds to `light`, width x height pixels, what speckle changes of it: the mean over each pixel of I
 * less its expected value; with disc_blurred less E as the full disc blurs it. `laser` is E at q x
 * q sub-pixels of each pixel, in the unit of light. The sum is at least 0 where `light` holds E
 * blurred by diffraction. The same seed gives the same speckle for every E. MCV_FAILED without
 * memory.
 */
mcv_result mcv_speckle_add(const mcv_speckle *given, const float *laser, uint32_t q, uint32_t width,
                           uint32_t height, float *light, mcv_error *error);

#endif
