/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The place of a laser line along one column or row of an image, to a fraction of a pixel. Manuals
 * call such methods extractors or peak detectors (R. B. Fisher and D. K. Naidu, A comparison of
 * algorithms for subpixel peak detection, 1996). v are the values above the background, and v_0 is
 * the brightest pixel:
 *
 *   cog        centre of gravity Σ k v_k/Σ v_k of a window; it misses light beyond the window
 *   parabola   (v_-1 - v_1)/(2 (v_-1 - 2 v_0 + v_1)): exact for parabolas only
 *   logGauss   the same for ln v: exact for a Gaussian that pixels sample; as pixels integrate,
 *              thin lines have an error
 *   blaisRioux zero of v_-2 + v_-1 - v_1 - v_2, centred at each pixel and interpolated linearly
 *              (F. Blais and M. Rioux, Signal Processing 11, 145, 1986): exact in the middle of
 *              pixels and halfway between them
 *   gauss      least-squares fit of a Gaussian integrated over pixels: exact for such lines
 *   steger     top of the values after smoothing by a Gaussian of an eighth of the window: the
 *              ridge of C. Steger (An unbiased detector of curvilinear structures, 1998),
 *              across the line
 *
 * Places count as those of the camera model: the middle of the first pixel is at 0.5.
 */
#ifndef MCVISI_HOST_TRIANGULATION_LASER_LINE_H
#define MCVISI_HOST_TRIANGULATION_LASER_LINE_H

#include "scene/aperture.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* In the order of the option `extractor`. */
enum {
    MCV_LINE_COG,
    MCV_LINE_PARABOLA,
    MCV_LINE_LOG_GAUSS,
    MCV_LINE_BLAIS_RIOUX,
    MCV_LINE_GAUSS,
    MCV_LINE_STEGER,
    MCV_LINE_EXTRACTOR_COUNT
};

typedef struct mcv_line_settings {
    int extractor;     /* MCV_LINE_… */
    double background; /* of the values */
    double threshold;  /* above the background: what is brighter belongs to the line */
    uint32_t window;   /* pixels that cog, gauss and steger take: odd, 3 … MCV_LINE_WINDOW; peaks
                          nearer   than half of it are one, as speckle breaks a line */
} mcv_line_settings;

enum { MCV_LINE_WINDOW = 63 };

/*
 * X(NAME, "word"): what was found. MISSING: no pixel is above the threshold. CUT: the pixels that
 * the extractor needs reach beyond the image. UNFIT: the line has no single top. DOUBLE: a second
 * peak has at least half of the light; the place is that of the brighter one.
 */
#define MCV_LINE_STATES(X) \
    X(SEEN, "seen") X(MISSING, "missing") X(CUT, "cut") X(UNFIT, "unfit") X(DOUBLE, "double")

enum {
#define MCV_X(NAME, word) MCV_LINE_##NAME,
    MCV_LINE_STATES(MCV_X) MCV_LINE_STATE_COUNT
#undef MCV_X
};
extern const char *const mcv_line_states[MCV_LINE_STATE_COUNT];

typedef struct mcv_line_place {
    int state;
    double place;       /* from the first pixel's beginning [pixel]; NaN where there is none */
    double peak, sum;   /* the brightest value, and the sum of those above the threshold; less the
                           background */
    double sigma;       /* standard deviation of the light across the line [pixel] */
    double uncertainty; /* of the place, by `deviations`; NaN without them [pixel] */
} mcv_line_place;

/* Does this state have a place? */
bool mcv_line_has_place(int state);

/*
 * Finds the line in `count` values, each `stride` apart. `deviations` are their standard
 * uncertainties, laid out alike, taken as independent; or NULL.
 */
mcv_line_place mcv_line_find(const mcv_line_settings *settings, const float *values,
                             const float *deviations, size_t count, size_t stride);

/* The stop that makes speckle: what of its disc is open, NULL: all of it; and does a line whose
 * places are rows run up the aperture, or to its right? */
typedef struct mcv_line_stop {
    const mcv_aperture_shape *aperture;
    bool rows;
} mcv_line_stop;

/*
 * Standard deviation of the centre of gravity of a line of laser light by speckle [m]: a Gaussian
 * line of standard deviation `sigma` on the film, summed over pixels of `height` along it,
 *
 *     σ² = C² ∬ x x' E(x) E(x') |µ|² /(∬E)²
 *
 * where µ is the transform of what is open of the stop, of the full disc 2 J1(πr/(λN))/(πr/(λN)).
 * grain: λN of the full disc [m]; contrast: C of the field. Diffraction's own blur of the line
 * counts in sigma. NaN without memory.
 */
double mcv_line_speckle_noise(double contrast, double grain, double sigma, double height,
                              mcv_line_stop stop);

#endif
