/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Random numbers that belong to a surface and move with it, as its roughness does. A lattice of
 * cells lies on it, each with a circular complex normal number. A sub-pixel of the film has the sum
 * of the cells whose middles it sees. Each cell is in one sub-pixel alone, so that these sums are
 * independent, as those of the film itself are.
 */
#ifndef MCVISI_HOST_ANALYSIS_SURFACE_NOISE_H
#define MCVISI_HOST_ANALYSIS_SURFACE_NOISE_H

#include "film/film.h"

/* Name of the part of a laser's picture with the places, and that of its channels. */
#define MCV_SURFACE_PART "surface"
extern const char *const mcv_surface_channels[4];

typedef struct mcv_surface_noise {
    /*
     * What the corners of pixels see, one more of them than pixels along each side: the place on a
     * node's surface in its own coordinates, without scale [m], and the surface's number; 0 where
     * there is none.
     */
    const mcv_image *places;
    double edge; /* of a cell [m] */
} mcv_surface_noise;

/* A pixel's sub-pixels, q x q of them: the sums, real and imaginary, and how many cells each has.
 * Rows lie `stride` sub-pixels apart. */
typedef struct mcv_surface_sums {
    uint32_t q;
    double *values;
    size_t stride;
    uint16_t *counts;
    size_t count_stride;
} mcv_surface_sums;

/* Adds the cells of a pixel. None where its corners see several surfaces or none, or more than 64
 * cells for each sub-pixel at a slant. */
void mcv_surface_noise_add(const mcv_surface_noise *surface, uint32_t seed, uint32_t pattern,
                           uint32_t column, uint32_t row, const mcv_surface_sums *sums);

#endif
