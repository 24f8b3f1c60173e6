/* SPDX-License-Identifier: Apache-2.0 */
/* How far a defect stands out of its surroundings. */
#ifndef MCVISI_HOST_ANALYSIS_CONTRAST_H
#define MCVISI_HOST_ANALYSIS_CONTRAST_H

#include "film/film.h"

/* A ring about the image's centre, inner <= r <= outer, in the unit of the pitch between pixels. */
typedef struct mcv_ring {
    double inner, outer;
    double pitch[2];
} mcv_ring;

/* Of the first channel, NaN left out. The deviation is that of a sample (n - 1), NaN for fewer than
 * two values; the rest of none. */
typedef struct mcv_spread {
    uint64_t count;
    double mean, deviation, largest;
} mcv_spread;

/* In the ring, or everywhere (NULL). */
mcv_spread mcv_image_spread(const mcv_image *image, const mcv_ring *ring);

/*
 * The peak-to-noise ratio: the largest |v - mean of the background| in the region, over the
 * deviation of the background. Of noise alone it is the larger the more pixels the region has,
 * about 3 to 4. The contrast-to-noise ratio is another: that of the means (analysis/region.h).
 */
double mcv_peak_to_noise(const mcv_image *image, const mcv_ring *region,
                         const mcv_ring *background);

#endif
