/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How well a defect can be told from the noise of a camera: the detectability of a known signal in
 * independent normal noise,
 *
 *     d'² = Σ Δ²/σ²
 *
 * with the difference Δ of the mean electrons with and without the defect, and the variance σ² of a
 * pixel without it (H. H. Barrett and K. J. Myers, Foundations of Image Science, 13.2.8: the
 * prewhitening matched filter). d' is how many deviations lie between the filter's outputs for
 * either case: the area under its ROC curve is Φ(d'/√2), and it finds Φ(d' - z) of the defects at
 * false calls of the upper tail of z.
 *
 * Δ comes from R pairs of replicates x_r = with - without, whose errors are part of Σ mean²: each
 * pixel's mean has the variance v/R of its pairs, which is taken out,
 *
 *     d'² ≈ Σ (mean² - v/R)/σ²
 *
 * without bias. The pairs may share their random numbers: what both have in common is no part of v.
 */
#ifndef MCVISI_HOST_ANALYSIS_DETECT_H
#define MCVISI_HOST_ANALYSIS_DETECT_H

#include "analysis/camera.h"

/* Values in electrons, [replicate][channel][row][column]. */
typedef struct mcv_pairs {
    uint32_t width, height, channels, replicates; /* two or more */
    const double *with, *without;
    const uint8_t *inside;       /* one per pixel; NULL: all */
    mcv_correlation correlation; /* of the errors of neighbours */
} mcv_pairs;

typedef struct mcv_detection {
    uint64_t values;           /* pixels times channels that the camera reads */
    double mean;               /* without the defect [e-] */
    mcv_quantity difference;   /* of the means [e-] */
    mcv_quantity contrast;     /* that over the mean */
    mcv_quantity rms_contrast; /* the root of the mean of Δ², over the mean */
    mcv_quantity squared;      /* d'²; below 0 where the errors hide it */
    double detectability;      /* d' */
    double low, high;          /* of d', 95 % */
    uint64_t visible;          /* values with |Δ| of at least `threshold` σ */
} mcv_detection;

/*
 * Uncertainties to first order from the variances v of the pairs; errors of pixels are independent,
 * or correlated as stated. Channels share them as the pairs show. `visible` (NULL: not wanted) gets
 * the image of one channel with |Δ|/σ, the largest of the channels; 0 outside. MCV_FAILED without
 * memory.
 */
mcv_result mcv_detect(const mcv_pairs *pairs, const mcv_camera *camera, double threshold,
                      mcv_image *visible, mcv_detection *detection, mcv_error *error);

/* The variance of a pixel with this mean [e-²]: shot noise, dark current, read noise, rounding, and
 * the fixed pattern, which one image cannot tell from a defect. */
double mcv_detect_variance(const mcv_camera *camera, double electrons);

/* Φ(x), of the normal distribution. */
double mcv_normal_below(double x);

#endif
