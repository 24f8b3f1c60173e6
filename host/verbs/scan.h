/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The verb scan: profiles of a laser head from its scene. Light that is rendered at sub-pixels
 * makes the image and its speckle; the camera of the options reads it; what it reads becomes a
 * profile. For a budget each cause of error has a run of its own.
 */
#ifndef MCVISI_HOST_VERBS_SCAN_H
#define MCVISI_HOST_VERBS_SCAN_H

#include "analysis/read_out.h"
#include "verbs/render_picture.h"
#include "verbs/triangulate.h"

/* What a run differs in from a scan as it is. */
typedef struct mcv_scan_run {
    bool again;    /* rendered with another seed */
    bool direct;   /* without light that has met another surface before */
    bool straight; /* by lasers whose lines do not bend */
    bool noise;    /* with photons, read noise and fixed pattern */
    bool speckle;
    bool bits;                    /* with the camera's own bits, not 16 */
    bool calibrated, undistorted; /* with heights by --calibration, by --distortion ignored */
} mcv_scan_run;

/* Runs of one render stand beside each other. */
enum {
    MCV_SCAN_ALL,
    MCV_SCAN_CLEAN, /* none of the causes but the light's own */
    MCV_SCAN_NOISE,
    MCV_SCAN_SPECKLE,
    MCV_SCAN_BITS,
    MCV_SCAN_CALIBRATED,
    MCV_SCAN_UNDISTORTED,
    MCV_SCAN_AGAIN,
    MCV_SCAN_DIRECT,
    MCV_SCAN_STRAIGHT,
    MCV_SCAN_IDEAL,
    MCV_SCAN_RUNS
};
extern const mcv_scan_run mcv_scan_runs[MCV_SCAN_RUNS];

/* An interference filter of two cavities: to the blue of its centre at a slant. */
typedef struct mcv_bandpass {
    double centre, width; /* at normal incidence, and full at half maximum [m]; 0: there is none */
    double index;         /* effective, of its layers */
} mcv_bandpass;

typedef struct mcv_scan {
    char *name;          /* of the scene's file, borrowed, for messages */
    mcv_command command; /* as profiles need it: its texts are borrowed */
    mcv_bandpass filter;
    mcv_camera_settings camera; /* of the laser's wavelength */
    mcv_camera_model model;     /* owned: of the whole film */
    mcv_transform laser;        /* of its node, without scale */
    mcv_profiles profiles[MCV_SCAN_RUNS];
    double motion;  /* patterns of speckle that the motion during an exposure makes, at least 1 */
    double pose[2]; /* standard uncertainties of the camera's place and turns [m, rad] */
    double locking; /* root of the mean square of the places' error by peak locking [pixel] */
    uint32_t subpixels; /* along each side of a pixel */
    uint32_t axis;      /* of the image, across the line */
    bool straight;      /* no line bends */
    bool budget;
} mcv_scan;

/* scan_head.c: the options that a sensor of type laserTriangulation gives a scan, over which
 * `defaults` (an object or NULL) go; `given`: what the command alone says. NULL without memory. */
json_t *mcv_scan_head(const mcv_sensor *sensor, const char *scene, const mcv_command *given,
                      const json_t *defaults);

/* Reads the options and what the scene's head is. MCV_BAD_INPUT where other lamps light the scene,
 * which make no speckle. After failure, too, it is freed by mcv_scan_free. */
mcv_result mcv_scan_begin(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                          mcv_scan *scan, mcv_error *error);
void mcv_scan_free(mcv_scan *scan);

/* scan_filter.c: the share of light that passes at this sine of the angle of incidence: 1/(1 + (2
 * (λ - λ(θ))/width)⁴), λ(θ) = centre √(1 - (sin θ/index)²). */
double mcv_filter_transmittance(const mcv_bandpass *filter, double wavelength, double sine);

/* Reads the filter of the options. MCV_USAGE where half of the laser's light does not pass it. */
mcv_result mcv_filter_read(const mcv_command *command, const mcv_scan *scan, mcv_bandpass *filter,
                           mcv_error *error);

/* What passes the filter along the chief ray of a place of the whole film. */
double mcv_scan_transmittance(const mcv_scan *scan, double column, double row);

/* Filters the light of a window and its sub-pixels in place. */
mcv_result mcv_scan_filter(const mcv_scan *scan, uint32_t first, mcv_exr *light, mcv_exr *laser,
                           mcv_error *error);

/* Is the run needed? */
bool mcv_scan_needs(const mcv_scan *scan, int run);

/* The film of q x q times fewer pixels: each has the samples of all that it holds. */
mcv_result mcv_film_bin(const mcv_film *fine, uint32_t q, mcv_film *binned, mcv_error *error);

/*
 * Rows of the film (or columns, across the line) that the line's light may reach: [0] and the one
 * behind the last. `film` is of the whole one, of one sample a pixel.
 */
mcv_result mcv_scan_window(const mcv_scan *scan, const mcv_film *film, uint32_t window[2],
                           mcv_error *error);

/* Exposes the light of profile number `profile` for a run, and finds the heights. `laser`: the same
 * light at sub-pixels. `first`: the window's beginning. */
mcv_result mcv_scan_expose(mcv_scan *scan, int run, uint32_t profile, const mcv_exr *light,
                           const mcv_exr *laser, uint32_t first, mcv_error *error);

/* The same, but for the window, into other profiles. */
mcv_result mcv_scan_find(mcv_scan *scan, int run, uint32_t profile, const mcv_exr *light,
                         const mcv_exr *laser, mcv_profiles *profiles, mcv_error *error);

/* scan_locking.c: finds the error of peak locking of this light, of sub-pixels. */
mcv_result mcv_scan_lock(mcv_scan *scan, const mcv_exr *light, const mcv_exr *laser,
                         mcv_error *error);

/* Tells the profiles, the head's figures and the budget. */
void mcv_scan_report(const mcv_scan *scan, mcv_report *report);

#endif
