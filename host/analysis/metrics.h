/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of `mcvisi measure` by name, for expressions: "dent.contrast_to_noise", "left.mtf50".
 */
#ifndef MCVISI_HOST_ANALYSIS_METRICS_H
#define MCVISI_HOST_ANALYSIS_METRICS_H

#include "analysis/found.h"
#include "analysis/light_pairs.h"

/* As a unit: that of the image's values. */
#define MCV_UNIT_OF_VALUES "values"

/* The units of figures that others choose: of the image's values, and of the step of a bound. */
typedef struct mcv_metric_units {
    const char *values, *step;
} mcv_metric_units;

/* X(member of mcv_roi_figures, "name", unit) and of mcv_contrast_figures, mcv_edge, mcv_line,
 * mcv_caliper, mcv_circle; those that are quantities. Without a unit: ratios.
 */
#define MCV_REGION_METRICS(X) \
    X(mean, "mean", MCV_UNIT_OF_VALUES) \
    X(deviation, "deviation", MCV_UNIT_OF_VALUES) \
    X(snr, "snr", "") \
    X(rms_contrast, "rms_contrast", "") \
    X(uniformity, "uniformity", "")
#define MCV_CONTRAST_METRICS(X) \
    X(difference, "difference", MCV_UNIT_OF_VALUES) \
    X(weber, "weber_contrast", "") \
    X(michelson, "michelson_contrast", "") \
    X(contrast_to_noise, "contrast_to_noise", "")
#define MCV_EDGE_METRICS(X) \
    X(position, "position", "pixels") \
    X(tilt, "tilt", "rad") \
    X(dark, "dark", MCV_UNIT_OF_VALUES) \
    X(bright, "bright", MCV_UNIT_OF_VALUES) \
    X(width_10_90, "width_10_90", "pixels") \
    X(sagitta, "sagitta", "pixels")
#define MCV_LINE_METRICS(X) \
    X(edge.position, "position", "pixels") \
    X(edge.tilt, "tilt", "rad") \
    X(straightness, "straightness", "pixels")
#define MCV_CALIPER_METRICS(X) \
    X(width, "width", "pixels") \
    X(angle, "angle", "rad")
#define MCV_CIRCLE_METRICS(X) \
    X(column, "column", "pixels") \
    X(row, "row", "pixels") \
    X(radius, "radius", "pixels") \
    X(diameter, "diameter", "pixels") \
    X(roundness, "roundness", "pixels")

/* One image, and where to measure in it. */
typedef struct mcv_metrics {
    const mcv_places *places;     /* as pixels */
    mcv_readings readings;        /* owned */
    bool known;                   /* the readings' deviations, from elsewhere than the values */
    bool whole;                   /* values are whole numbers */
    const mcv_light_pairs *pairs; /* with a step of a parameter, and without; or NULL */
    double step;                  /* of that parameter */
    double pixel[2];              /* width and height in the object plane [m], 0: not known */
} mcv_metrics;

/*
 * A figure by its name: NAME.FIGURE of a region or of what is found in a box, or FIGURE alone of
 * the first that has it; without a region the whole image. `bound` of a region is the least
 * standard uncertainty with which its pixels tell the parameter that differs between the pairs.
 * Besides those above: mtf50 and mtf_at_nyquist of edges; figures in pixels that have a length have
 * it as …_length; distance and length from the first edge or line to another, or from the first
 * circle or arc to another; line_distance and line_length from the first edge or line to a circle
 * or arc. An mcv_lookup whose user is the mcv_metrics. MCV_USAGE for an unknown name, which lists
 * what there is; MCV_FAILED where nothing is found.
 */
mcv_result mcv_metric_look_up(void *user, const char *name, mcv_quantity *quantity,
                              mcv_error *error);

/* Whether there is such a figure, without an image: a place of that name, and the figure. An
 * mcv_lookup whose user is the mcv_places. */
mcv_result mcv_metric_known(void *user, const char *name, mcv_quantity *quantity, mcv_error *error);

/* The unit of a metric that is one figure, or u(figure): "pixels", "rad", "m", "cycles/pixel" or
 * one of `units`. "" for ratios, and for other expressions. */
const char *mcv_metric_unit(const char *expression, mcv_metric_units units);

/* Why there is no signal-to-noise or contrast-to-noise ratio: `samples` of mcv_roi_figures or
 * mcv_contrast_figures. */
void mcv_samples_words(double samples, char words[160]);

#endif
