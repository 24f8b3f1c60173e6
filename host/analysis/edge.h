/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One straight edge in a rectangle of an image: where it is, and how sharp (ISO 12233, slanted
 * edge).
 *
 * Across the edge's nearest axis each line of pixels gives the place at which an ideal step would
 * hold the same light between the plateaus on both sides: exact for every symmetric spread and for
 * square pixels, whatever their phase. A straight line through those places is the edge. All
 * pixels, projected on its normal, make the edge spread function, four values a pixel; its
 * difference is the line spread function, whose Fourier transform the modulation transfer function
 * (MTF).
 */
#ifndef MCVISI_HOST_ANALYSIS_EDGE_H
#define MCVISI_HOST_ANALYSIS_EDGE_H

#include "analysis/box.h"

/* How the places of the pixels' lines lie about the straight line through them, all along the axis
 * across the edge. */
typedef struct mcv_edge_rows {
    double count, middle, spread;       /* how many, the mean of their rows, Σ(row - middle)² */
    double at, slope;                   /* the line's place in the middle row, and by row */
    double variance_at, variance_slope; /* of the noise; that of the plateaus is in the first */
    double squares;       /* Σ of the squared distances of the places from the line */
    double noise, noise2; /* Σ of the rows' own variances, and of their squared covariances */
    double shared;        /* the mean of what a row adds to the variance of a sum over many */
} mcv_edge_rows;

typedef struct mcv_edge {
    char name[64];
    mcv_pixel_box box;
    bool across_rows;      /* the edge is nearer to vertical: its lines are rows */
    double point[2];       /* column and row, where it passes the middle line of the rectangle */
    double normal[2];      /* unit, towards the brighter side */
    mcv_quantity position; /* of the point along the axis across the edge, column or row [pixel] */
    mcv_quantity tilt;     /* from the column (across rows) or the row [rad] */
    mcv_quantity dark, bright; /* the plateaus */
    mcv_quantity width_10_90;  /* from 10 % to 90 % of the step, along the normal [pixel] */
    mcv_quantity sagitta; /* of the arc that fits best: how far its middle stands out of its chord,
                             towards the brighter side [pixel] */
    mcv_edge_rows rows;
    double window;  /* half of what a row sums, along the axis across the edge [pixel] */
    double freedom; /* degrees of freedom of the pixels' noise, infinite where it is known */
} mcv_edge;

/* How much of a pixel, from its number to the next, lies between two places. */
double mcv_overlap(size_t pixel, double from, double to);

/* "[NAME=]X,Y,W,H", as mcv_boxes_parse() reads it. */
mcv_result mcv_edge_parse(const char *text, size_t number, const mcv_image *image, mcv_edge *edge,
                          mcv_error *error);

/*
 * Finds the edge; of edge only the name and the box are read. MCV_FAILED says why there is none: no
 * step, or too little room on its sides.
 */
mcv_result mcv_edge_find(const mcv_readings *readings, mcv_edge *edge, mcv_error *error);

/*
 * MCV_FAILED with the sagitta where the edge is curved: by more than 4 standard uncertainties,
 * which one straight edge in 16000 is by chance, and by more than 0.01 pixel, to which places are
 * exact without noise.
 */
mcv_result mcv_edge_is_straight(const mcv_edge *edge, mcv_error *error);

/*
 * Finds the edge where the noise of the pixels may not be known. `least` is NaN where the
 * deviations say it. Otherwise the noise is estimated on both sides, at least `least` each: the
 * box's deviations are set, and all uncertainties widened by Student's t.
 */
mcv_result mcv_edge_locate(mcv_readings *readings, double least, mcv_edge *edge, mcv_error *error);

/* From the line of a to that of b along their mean normal, through the points; negative where b
 * lies on the darker side of a [pixel]. */
mcv_quantity mcv_edge_distance(const mcv_edge *a, const mcv_edge *b);

/* Frequencies in cycles per pixel along the normal: 0, 1/64, … 1. The spread functions stand at
 * `place` [pixel] from the edge. */
enum { MCV_MTF_COUNT = 65, MCV_ESF_PER_PIXEL = 4 };

typedef struct mcv_edge_mtf {
    double frequency[MCV_MTF_COUNT];
    mcv_quantity modulation[MCV_MTF_COUNT];
    mcv_quantity
        mtf50; /* the lowest frequency with a modulation of 1/2; NaN if there is none up to 1 */
    mcv_quantity nyquist;
    size_t count;
    double *place;
    mcv_quantity *esf; /* from 0 to 1 */
    double *lsf;       /* per pixel, between place[i] and place[i + 1]; the last is 0 */
} mcv_edge_mtf;

/*
 * Of an edge that was found. MCV_FAILED where its tilt leaves phases of the pixel grid unseen: it
 * must cross one pixel or more, and be below 45°. The modulation is corrected for the bins and the
 * difference, not for the pixel, which belongs to the image.
 */
mcv_result mcv_edge_spread(const mcv_readings *readings, const mcv_edge *edge, mcv_edge_mtf *mtf,
                           mcv_error *error);
void mcv_edge_mtf_free(mcv_edge_mtf *mtf);

#endif
