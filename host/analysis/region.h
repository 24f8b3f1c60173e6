/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Figures of regions of an image, each with its standard uncertainty: that of the pixels, taken as
 * independent, propagated to first order (Guide to the Expression of Uncertainty in Measurement,
 * JCGM 100:2008, 5.1).
 */
#ifndef MCVISI_HOST_ANALYSIS_REGION_H
#define MCVISI_HOST_ANALYSIS_REGION_H

#include "film/film.h"

/* A measured number and its standard uncertainty, in the same unit. */
typedef struct mcv_quantity {
    double value, uncertainty;
} mcv_quantity;

/*
 * How a lens has correlated errors of neighbours that were independent before: sums over all
 * distances of the correlation and of its square; the variance that the stencil of
 * mcv_roi_estimate_noise sees, over the one that it would see without correlation; and the sum of
 * the squares of the shares that pixels have in the variance of one. All 1, or the sum 0, where
 * errors are independent.
 */
typedef struct mcv_correlation {
    double sum, squares, stencil, shares;
} mcv_correlation;

/*
 * One channel of values and their standard uncertainties. Values that are NaN belong to no region.
 *
 * The image `render` is the part of the deviations that is the Monte Carlo error of the render
 * itself, which no camera would see; without pixels there is none. It comes from the spread of
 * `render_freedom` + 1 replicates (0: known without error).
 */
typedef struct mcv_readings {
    mcv_image values, deviation, render;
    double render_freedom;
    mcv_correlation correlation; /* of the render's errors */
} mcv_readings;

/* A set of pixels. */
typedef struct mcv_roi {
    char name[64];
    uint32_t width, height; /* of the image */
    uint8_t *inside;        /* one per pixel */
    uint64_t count;
    uint64_t estimated; /* from how many of the values' differences the pixels' deviations are; 0:
                           they are known */
} mcv_roi;

/*
 * Reads "[NAME=]X,Y,W,H" (a rectangle), "[NAME=]X,Y,X,Y,X,Y,…" (a polygon, even-odd) or
 * "[NAME=]FILE" (an image of the same size, whose pixels above 0 belong to the region), in pixels
 * from the top-left corner; a pixel belongs where its centre does. Without a name it is called by
 * its number. MCV_USAGE with a sentence where it reaches outside the image or holds no pixel.
 */
mcv_result mcv_roi_parse(const char *text, size_t number, const mcv_image *image, mcv_roi *region,
                         mcv_error *error);
void mcv_roi_free(mcv_roi *region);

/* Refuses the text of a place ("region", "edge" …) whose NAME is longer than 63 bytes. */
mcv_result mcv_place_check_name(const char *what, const char *text, mcv_error *error);

/* Splits "[NAME=]A,B,C…" into the name and the rest, and reads at most `most` numbers. Returns how
 * many, or 0 where the rest is no list of numbers. */
size_t mcv_roi_numbers(const char *text, size_t number, char name[64], const char **rest,
                       double *numbers, size_t most);

/*
 * The noise of a region whose pixels' uncertainties are not known: from second differences of
 * neighbours in both directions, which smooth shading leaves at 0, by their median, which edges
 * hardly move (after Immerkær, Fast noise variance estimation, 1996). Sets the deviation of the
 * region's pixels, at least to `least`. NaN where no pixel has all of its neighbours in the region.
 * What the readings say of the render's error is taken out of the estimate, and is part of the
 * deviations.
 *
 * From few differences the estimate is itself uncertain. The uncertainties below are then those
 * that make value ± 1.96 uncertainty hold the truth in 95 % of cases, by Student's t with the
 * degrees of freedom of the estimate (GUM, annex G).
 */
double mcv_roi_estimate_noise(mcv_readings *readings, mcv_roi *region, double least);

/* The degrees of freedom of a variance that mcv_roi_estimate_noise found from so many differences;
 * infinite for none, where the variance is known. */
double mcv_roi_estimate_freedom(uint64_t differences);

/*
 * Of a region: the mean; the deviation of the values from it, noise and all, but for the error of
 * the render; their noise (the root of the mean of the pixels' variances, without the render's),
 * and the render's; rms_contrast, the deviation that is not noise over the mean; snr, mean over
 * deviation; uniformity, 1 less such a contrast of the means of 8 x 8 cells of the region's frame,
 * those that lie in it by half (the darkest cell would show the noise rather than the light).
 *
 * Where taking out the render's error leaves the deviation² uncertain by more than MCV_ROI_HIDDEN
 * of it, the figures that divide by the deviation are NaN, and `samples` says how many times the
 * render's samples would do, at least; else it is 0.
 */
#define MCV_ROI_HIDDEN 0.2
typedef struct mcv_roi_figures {
    uint64_t count;
    double smallest, largest, noise, render_noise, samples;
    mcv_quantity mean, deviation, rms_contrast, snr, uniformity;
} mcv_roi_figures;
mcv_roi_figures mcv_roi_measure(const mcv_readings *readings, const mcv_roi *region);

/*
 * Of a region (mean m) before a background (mean b, deviation s): m - b; Weber's contrast (m -
 * b)/b; Michelson's (m - b)/(m + b); the contrast-to-noise ratio (m - b)/s. Negative where the
 * region is the darker one. `samples` as above, of the background.
 */
typedef struct mcv_contrast_figures {
    double samples;
    mcv_quantity difference, weber, michelson, contrast_to_noise;
} mcv_contrast_figures;
mcv_contrast_figures mcv_roi_contrast(const mcv_readings *readings, const mcv_roi *region,
                                      const mcv_roi *background);

#endif
