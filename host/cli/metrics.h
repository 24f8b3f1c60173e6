/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of `mcvisi measure` by name, for expressions: "dent.contrast_to_noise", "left.mtf50". */
#ifndef MCVISI_HOST_CLI_METRICS_H
#define MCVISI_HOST_CLI_METRICS_H

#include "analysis/edge.h"
#include "cli/options.h"

/* X(member of mcv_roi_figures, "name") and of mcv_contrast_figures, mcv_edge; figures that are quantities. */
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
    X(width_10_90, "width_10_90")

/* One image with the regions and edges of the command line. */
typedef struct mcv_metrics {
    const mcv_command *command;
    mcv_readings readings; /* owned */
    bool known;            /* the readings' deviations, from elsewhere than the values */
    bool whole;            /* values are whole numbers */
    double pixel[2];       /* width and height in the object plane [m], 0: not known */
} mcv_metrics;

/*
 * A figure by its name: NAME.FIGURE of a region or an edge, or FIGURE alone of the first that has it; without a region the whole image.
 * Of edges besides those above: mtf50, mtf_at_nyquist, width_10_90_length, and from the first edge to this one distance and length. An
 * mcv_lookup whose user is the mcv_metrics. MCV_USAGE for an unknown name, which lists what there is; MCV_FAILED where there is no edge.
 */
mcv_result mcv_metric_look_up(void *user, const char *name, mcv_quantity *quantity, mcv_error *error);

/* Whether there is such a figure, without an image: region and edge of that name on the command line, and the figure. */
mcv_result mcv_metric_known(void *user, const char *name, mcv_quantity *quantity, mcv_error *error);

/* Why there is no signal-to-noise or contrast-to-noise ratio: `samples` of mcv_roi_figures or mcv_contrast_figures. */
void mcv_samples_words(double samples, char words[160]);

/* Estimates the noise of a region where the readings' deviations are not known; rounding to whole numbers alone makes 1/√12. */
void mcv_know_noise(mcv_readings *readings, bool known, bool whole, mcv_roi *region);

/* The edge of "[NAME=]X,Y,W,H", with its noise as above. */
mcv_result mcv_locate_edge(mcv_readings *readings, bool known, bool whole, const char *text, size_t number, mcv_edge *edge,
                           mcv_error *error);

/* One channel of an image (0: the mean of all); of deviations, those of the mean of independent channels. `path` is for messages. */
mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image, bool deviations, mcv_image *out, mcv_error *error);

#endif
