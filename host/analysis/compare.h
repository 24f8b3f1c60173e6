/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whether two renders of the same picture differ by more than their noise. Four tests, each of
 * which wrongly calls two correct renders different in at most 2.5 of 10 000 cases:
 *
 *   unit    the smallest p-value of all pixels, channels and 8 x 8 tiles (Šidák-corrected for their
 * number) tiles   Kolmogorov-Smirnov: the tiles' p-values are not smaller than uniform ones count
 * the number of tiles with p < 0.01 against its binomial distribution image   the means of the
 * whole image
 *
 * The image means are compared by Welch's t test with the Welch-Satterthwaite degrees of freedom.
 * The replicate means of a pixel or tile are seldom normal: a sample more or less on an edge gives
 * two values, a caustic rare bursts, and t is then far too sure of itself. So films are compared
 * there by Mann and Whitney's exact rank test, which asks only that the replicates be independent;
 * a unit's p-value is the larger of both. The smallest p that R replicates can give is 2/(2R choose
 * R): 0.03 for 4, 3e-9 for 16, 1e-18 for 32. Comparisons want 16; single pixels of pictures above
 * some 70 000 values want 32. KS and count look upwards only (too many small p-values): a picture
 * equals itself. Differences below 10^-6 of the value, the rounding of float32 renderers, never
 * count.
 */
#ifndef MCVISI_HOST_ANALYSIS_COMPARE_H
#define MCVISI_HOST_ANALYSIS_COMPARE_H

#include "film/film.h"

#define MCV_COMPARE_ALPHA 2.5e-4
#define MCV_COMPARE_ROUNDING 1e-6
enum { MCV_COMPARE_TILE = 8, MCV_COMPARE_BINS = 10 };

/* Where the smallest p-value is, in pixels. */
typedef struct mcv_region {
    uint32_t channel, column, row, width, height;
} mcv_region;

typedef struct mcv_comparison {
    bool different;
    char reason[512]; /* one sentence: what differs and by how much, or what would have been seen */
    double p_unit, p_tiles, p_count, p_image; /* each different below MCV_COMPARE_ALPHA */
    mcv_region worst;                         /* the unit of the smallest p-value */
    uint64_t units, tiles,
        small_tiles; /* tested; tiles that KS and count look at; of them with p < 0.01 */
    uint64_t histogram[MCV_COMPARE_BINS]; /* of these tiles' p-values, by tenths: level without a
                                             difference, or rising */
    double mean_x, mean_y;                /* of the whole image */
    double detectable; /* relative bias of the image mean that would be seen in 9 of 10 cases */
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
 * The same from files. Without the replicates' values all tests are Welch's: noise with rare bursts
 * may be called a difference, and KS and count leave out tiles with a relative standard deviation
 * above 20 % per replicate. The p-value of a single pixel is at least the smallest one of a rank
 * test, for its replicates may be alike by chance. Pixels are taken as independent of each other,
 * as they are here, and channels as fully correlated. Pixels that are not finite in both are left
 * out; one that is so in a single image makes them different.
 */
mcv_result mcv_compare_images(const mcv_measured *x, const mcv_measured *y,
                              mcv_comparison *comparison, mcv_error *error);

/*
 * The difference x - y of each pixel in units of its standard error, channels summed up; one plane,
 * made here. Infinite where a difference has no error, 0 where neither is, NaN where a value is
 * none. For looking at: with few replicates large values are not rare.
 */
mcv_result mcv_compare_difference(const mcv_measured *x, const mcv_measured *y,
                                  mcv_image *difference, mcv_error *error);

#endif
