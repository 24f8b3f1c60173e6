/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of `mcvisi measure` by name, for expressions: "dent.contrast_to_noise", "left.mtf50".
 */
#ifndef MCVISI_HOST_CLI_METRICS_H
#define MCVISI_HOST_CLI_METRICS_H

#include "analysis/circle.h"
#include "analysis/line.h"
#include "cli/options.h"

/* X(member of mcv_roi_figures, "name") and of mcv_contrast_figures, mcv_edge, mcv_line,
 * mcv_caliper, mcv_circle; those that are quantities.
 */
#define MCV_REGION_METRICS(X) \
    X(mean, "mean") \
    X(deviation, "deviation") \
    X(snr, "snr") \
    X(rms_contrast, "rms_contrast") \
    X(uniformity, "uniformity")
#define MCV_CONTRAST_METRICS(X) \
    X(difference, "difference") \
    X(weber, "weber_contrast") \
    X(michelson, "michelson_contrast") \
    X(contrast_to_noise, "contrast_to_noise")
#define MCV_EDGE_METRICS(X) \
    X(position, "position") \
    X(tilt, "tilt") \
    X(dark, "dark") \
    X(bright, "bright") \
    X(width_10_90, "width_10_90") \
    X(sagitta, "sagitta")
#define MCV_LINE_METRICS(X) \
    X(edge.position, "position") \
    X(edge.tilt, "tilt") \
    X(straightness, "straightness")
#define MCV_CALIPER_METRICS(X) \
    X(width, "width") \
    X(angle, "angle")
#define MCV_CIRCLE_METRICS(X) \
    X(column, "column") \
    X(row, "row") \
    X(radius, "radius") \
    X(diameter, "diameter") \
    X(roundness, "roundness")

/* What is found in boxes: X(form, FORM, kind of figures, what to give); the form is the option's
 * name, and form + "s" the list in JSON. */
#define MCV_FORMS(X) \
    X(edge, EDGE, edge, "a rectangle with one straight edge in it") \
    X(line, LINE, line, "rectangles that one straight edge passes") \
    X(caliper, CALIPER, caliper, "a rectangle across two opposite edges") \
    X(circle, CIRCLE, circle, "a rectangle around a circle") \
    X(arc, ARC, circle, "a rectangle with a part of a circle in it")
enum {
#define MCV_X(form, FORM, figures, what) MCV_FORM_##FORM,
    MCV_FORMS(MCV_X)
#undef MCV_X
        MCV_FORM_COUNT
};

/* One image with the regions and edges of the command line. */
typedef struct mcv_metrics {
    const mcv_command *command;
    mcv_readings readings; /* owned */
    bool known;            /* the readings' deviations, from elsewhere than the values */
    bool whole;            /* values are whole numbers */
    double pixel[2];       /* width and height in the object plane [m], 0: not known */
} mcv_metrics;

/*
 * A figure by its name: NAME.FIGURE of a region or of what is found in a box, or FIGURE alone of
 * the first that has it; without a region the whole image. Besides those above: mtf50 and
 * mtf_at_nyquist of edges; figures in pixels that have a length have it as …_length; distance and
 * length from the first edge or line to another, or from the first circle or arc to another;
 * line_distance and line_length from the first edge or line to a circle or arc. An mcv_lookup whose
 * user is the mcv_metrics. MCV_USAGE for an unknown name, which lists what there is; MCV_FAILED
 * where nothing is found.
 */
mcv_result mcv_metric_look_up(void *user, const char *name, mcv_quantity *quantity,
                              mcv_error *error);

/* Whether there is such a figure, without an image: region and edge of that name on the command
 * line, and the figure. */
mcv_result mcv_metric_known(void *user, const char *name, mcv_quantity *quantity, mcv_error *error);

/* Why there is no signal-to-noise or contrast-to-noise ratio: `samples` of mcv_roi_figures or
 * mcv_contrast_figures. */
void mcv_samples_words(double samples, char words[160]);

/* Estimates the noise of a region where the readings' deviations are not known; rounding to whole
 * numbers alone makes 1/√12. */
void mcv_know_noise(mcv_readings *readings, bool known, bool whole, mcv_roi *region);

/* One that was found. */
typedef struct mcv_found {
    unsigned form;
    union {
        mcv_edge edge;
        mcv_line line;
        mcv_caliper caliper;
        mcv_circle circle; /* or arc */
    } as;
} mcv_found;

/* The boxes of a form on the command line. */
const mcv_compact_indices *mcv_form_boxes(const mcv_command *command, unsigned form);

/* Finds what the text, a box or more, asks for; with its noise as above. MCV_FAILED for a curved
 * edge, too. */
mcv_result mcv_locate(mcv_readings *readings, bool known, bool whole, unsigned form,
                      const char *text, size_t number, mcv_found *found, mcv_error *error);
const char *mcv_found_name(const mcv_found *found);

/* The line of an edge or a line; NULL of others. */
const mcv_edge *mcv_found_straight(const mcv_found *found);
bool mcv_found_is_round(const mcv_found *found);

/*
 * From a to b, neither a caliper, a no circle unless b is one: in pixels, and the unit vector along
 * which it counts. NaN between edges and lines that are not parallel within 10°.
 */
#define MCV_NOT_PARALLEL "they are not parallel within 10°, and have no distance"
mcv_quantity mcv_found_distance(const mcv_found *a, const mcv_found *b, double direction[2]);

/* Metres in the object for a pixel along a direction, or in every direction (NULL); NaN where that
 * is not known. */
double mcv_scale_along(const double pixel[2], const double direction[2]);

/* One channel of an image (0: the mean of all); of deviations, those of the mean of independent
 * channels. `path` is for messages. */
mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image,
                              bool deviations, mcv_image *out, mcv_error *error);

#endif
