/* SPDX-License-Identifier: Apache-2.0 */
/* What the steps of finding a circle share (analysis/circle.c); nothing else calls them. */
#ifndef MCVISI_HOST_ANALYSIS_CIRCLE_FINDER_H
#define MCVISI_HOST_ANALYSIS_CIRCLE_FINDER_H

#include "analysis/circle.h"
#include "analysis/form.h"
#include "analysis/region_noise.h"

#include <math.h>

typedef struct mcv_circle_guess {
    double centre[2], radius;
} mcv_circle_guess;

enum { MCV_CIRCLE_SECTORS = 256 };

/* One row or column where it crosses the circle. `turn`: 1 where it leaves the circle towards
 * higher columns or rows, else -1. */
typedef struct mcv_circle_scan {
    bool along_rows, used;
    uint32_t line;
    double turn, from, to; /* the window along it, in columns or rows */
    double place, model;   /* where the step is, and where the circle's would be */
    double gradient[3];    /* of the model by column, row and radius */
    double by_spread;      /* of the model by σ² */
    double cosine;         /* of its angle to the normal */
    double by_level[2];    /* of the place by the levels outside and inside */
    double variance;       /* of the place by its own pixels */
    double shared;         /* what it adds to the variance of a sum over many scans */
} mcv_circle_scan;

typedef struct mcv_circle_finder {
    mcv_circle *circle;
    const mcv_readings *readings;
    mcv_circle_guess at;
    double level[2]; /* outside, inside */
    double window;   /* from the circle, both ways, to where the plateaus begin */
    double spread2;  /* σ² as measured */
    int sectors;
    bool seen[MCV_CIRCLE_SECTORS]; /* all scans there count */
    mcv_circle_scan *scans;
    size_t scan_count;
    double normal[3][3], inverse[3][3]; /* of the least squares */
} mcv_circle_finder;

typedef struct mcv_ring_sums {
    double count[2], sum[2]; /* outside, inside */
    /* sums over the window's pixels: of their weights, of |E - step|, of 2|x| |E - step| */
    double density, deviation, moment;
} mcv_ring_sums;

static inline double mcv_length2(double x, double y) { return sqrt(x * x + y * y); }

/* The measured σ², but at least that of a pixel, 1/12. */
static inline double mcv_circle_spread2(const mcv_circle_finder *f) {
    return fmax(f->spread2, 1.0 / 12);
}

/* The sector of a direction. It is counted along the unit square turned by 45°, which goes round as
 * the angle does. */
static inline int mcv_circle_sector(const mcv_circle_finder *f, double x, double y) {
    const double share = y / (fabs(x) + fabs(y)), turn = 0.25 * (x < 0   ? 2 - share
                                                                 : y < 0 ? 4 + share
                                                                         : share);
    const int sector = (int)(turn * f->sectors);
    return sector < f->sectors ? sector : f->sectors - 1;
}

static inline bool mcv_circle_on_plateau(const mcv_circle_finder *f, double distance) {
    return fabs(distance) >= f->window + 0.75;
}

mcv_result mcv_circle_fail(const mcv_circle *circle, mcv_error *error, const char *why);

/*
 * Scans within 45° keep the window's ends beyond it from the circle: R²/2 - 2RW + W² >= 0. The
 * circle over ±√3 σ of the scan's own width must exist, too: R/√2 + √3 σ < 0.95 R.
 */
double mcv_circle_widest_window(double radius);

/* circle_guess.c */

mcv_result mcv_circle_find_guess(const mcv_image *image, const mcv_circle *circle,
                                 mcv_circle_guess *g, double *bright, mcv_error *error);

/* circle_scans.c */

void mcv_circle_make_scans(mcv_circle_finder *f);

/*
 * Rejects places farther off than five times the noise, or the median of all distances, but none
 * within a tenth of a pixel. A sector is seen if it has places and none is rejected.
 */
bool mcv_circle_judge_scans(mcv_circle_finder *f, double *sizes);

/* One step of least squares. Distances are weighted by arc length: a scan has 1/cosine of it. False
 * where they do not determine three numbers. */
bool mcv_circle_solve(mcv_circle_finder *f, bool move);

/* circle_ring.c: calls for every pixel of a seen sector in the ring of the window and the plateaus,
 * with its index and its distance from the circle. */
typedef void mcv_circle_visit(mcv_circle_finder *f, size_t index, double distance, void *user);
void mcv_circle_visit_ring(mcv_circle_finder *f, mcv_circle_visit *call, void *user);

/* False where a side is not seen. */
bool mcv_circle_find_levels(mcv_circle_finder *f, mcv_ring_sums *r);
bool mcv_circle_find_spread(mcv_circle_finder *f, mcv_ring_sums *r);
mcv_result mcv_circle_estimate_noise(mcv_circle_finder *f, mcv_readings *readings, double least,
                                     double *freedom, mcv_error *error);

/* circle_uncertainty.c */

bool mcv_circle_find_covariance(mcv_circle_finder *f, const mcv_ring_sums *ring,
                                double covariance[3][3]);

/* The scans' distances from the circle, by arc length; what noise makes of them, less what the fit
 * takes out. */
mcv_scatter mcv_circle_scatter(const mcv_circle_finder *f);

#endif
