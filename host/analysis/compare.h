/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Do two renders of the same picture differ by more than their noise? There are four tests. Each
 * calls two correct renders different in at most 2.5 of 10 000 cases.
 *
 *     unit    the smallest p-value of all pixels, channels and 8 x 8 tiles, with Šidák's
 *             correction for their number
 *     tiles   Kolmogorov-Smirnov: the tiles' p-values are not smaller than uniform ones
 *     count   the number of tiles with p < 0.01, against its binomial distribution
 *     image   the means of the whole image
 *
 * The image means are compared by Welch's t test with the Welch-Satterthwaite degrees of freedom.
 * The replicate means of a pixel or tile are seldom normal: one sample more on an edge gives two
 * values, a caustic gives rare bursts. There t would give too small p-values. Films are therefore
 * also compared by Mann and Whitney's exact rank test, which only requires independent replicates;
 * the p-value of a unit is the larger of both.
 *
 * The smallest p that R replicates can give is 2/(2R choose R): 0.03 for 4, 3e-9 for 16, 1e-18 for
 * 32. 16 replicates are recommended, 32 for single pixels of pictures above some 70 000 values. KS
 * and count are one-sided (too many small p-values), so that a picture equals itself. Differences
 * below 10^-6 of the value, the rounding of float32 renderers, never count.
 */
#ifndef MCVISI_HOST_ANALYSIS_COMPARE_H
#define MCVISI_HOST_ANALYSIS_COMPARE_H

#include "film/film.h"

#define MCV_COMPARE_ALPHA 2.5e-4
#define MCV_COMPARE_ROUNDING 1e-6
enum { MCV_COMPARE_TILE = 8, MCV_COMPARE_BINS = 10 };

/* The region with the smallest p-value, in pixels. */
typedef struct mcv_region {
    uint32_t channel, column, row, width, height;
} mcv_region;

typedef struct mcv_comparison {
    bool different;
    char reason[512]; /* one sentence: the difference, or the smallest one that would have been
                         detected */
    double p_unit, p_tiles, p_count, p_image; /* each means a difference below MCV_COMPARE_ALPHA */
    mcv_region worst;                         /* the unit of the smallest p-value */
    uint64_t units, tiles,
        small_tiles; /* tested units; tiles that KS and count use; those with p < 0.01 */
    uint64_t histogram[MCV_COMPARE_BINS]; /* p-values of these tiles, by tenths: uniform or rising
                                             without a difference */
    double mean_x, mean_y;                /* of the whole image */
    double detectable;      /* relative bias of the image mean that is detected in 9 of 10 cases */
    double detectable_tile; /* of a tile, relative to the image mean; after Šidák */
} mcv_comparison;

/* Compares films of equal width, height and channels with two or more replicates each, rendered
 * with different seeds. */
mcv_result mcv_compare_films(const mcv_film *x, const mcv_film *y, mcv_comparison *comparison,
                             mcv_error *error);

/* A mean image and its standard error from R replicates, as files hold them. */
typedef struct mcv_measured {
    const mcv_image *mean, *error;
    uint32_t replicates;
} mcv_measured;

/*
 * The same for files. Without the replicates' values all tests are Welch's. Noise with rare bursts
 * may then count as a difference; KS and count ignore tiles with a relative standard deviation
 * above 20 % per replicate. The p-value of a single pixel is at least the smallest one of a rank
 * test, because its replicates may be equal by chance. Pixels are taken as independent of each
 * other, which is true here, and channels as fully correlated. Pixels that are not finite in both
 * images are ignored; pixels that are not finite in one image are a difference.
 */
mcv_result mcv_compare_images(const mcv_measured *x, const mcv_measured *y,
                              mcv_comparison *comparison, mcv_error *error);

/*
 * Makes the image of the difference x - y of each pixel in units of its standard error, summed over
 * the channels. It is infinite for a difference without an error, 0 if both are 0, NaN if a value
 * is NaN. It is for viewing: with few replicates large values are not rare.
 */
mcv_result mcv_compare_difference(const mcv_measured *x, const mcv_measured *y,
                                  mcv_image *difference, mcv_error *error);

#endif
