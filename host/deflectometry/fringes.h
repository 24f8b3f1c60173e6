/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a camera sees of fringes on a screen, from a light transport matrix: its rows say which
 * pixels of the screen light a pixel of the camera, so that no further render is needed.
 */
#ifndef MCVISI_HOST_DEFLECTOMETRY_FRINGES_H
#define MCVISI_HOST_DEFLECTOMETRY_FRINGES_H

#include "deflectometry/phase.h"
#include "transport/matrix.h"

enum { MCV_UNWRAP_HETERODYNE, MCV_UNWRAP_GRAY };

typedef struct mcv_fringe_plan {
    uint32_t steps;     /* N */
    double periods;     /* P across the screen */
    uint32_t length;    /* the screen's pixels across the fringes */
    double gamma;       /* what a pixel sends is its value to this power */
    int unwrap;         /* MCV_UNWRAP_… */
    double noise;       /* standard deviation of the camera's values [as the matrix] */
    uint32_t seed;      /* of the noise */
    uint32_t direction; /* 0: across columns, 1: across rows */
} mcv_fringe_plan;

/* What is decoded of a pixel of the camera. */
typedef struct mcv_decoded {
    double place;       /* on the screen, in its pixels; NaN: the pixel does not see it */
    double deviation;   /* standard uncertainty of the place, of render and camera */
    double modulation;  /* B of the fringes */
    double contrast;    /* B/A */
    double phase_noise; /* of the camera alone, √(2/N) u(I)/B [rad] */
} mcv_decoded;

/*
 * Decodes all pixels of a matrix whose elements [first, first + length) are the columns or rows of
 * the screen; light of other elements is ambient. decoded: width * height. MCV_FAILED without
 * memory.
 */
mcv_result mcv_fringes_decode(const mcv_matrix *matrix, uint32_t first, const mcv_fringe_plan *plan,
                              mcv_decoded *decoded, mcv_error *error);

/*
 * The period [the screen's pixels] of the least uncertainty of a slope, which is proportional to
 * period/contrast. A pixel of the camera sees the contrast |Σ T_j exp(2πi x_j/period)|/Σ T_j.
 * *contrast: its root mean square over the pixels for which `valid` says so, at that period. 0
 * where no pixel is valid.
 */
double mcv_best_period(const mcv_matrix *matrix, uint32_t first, uint32_t length, const bool *valid,
                       double *contrast);

#endif
