/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of `mcvisi measure`: reading the image, and the report. */
#ifndef MCVISI_HOST_CLI_MEASURE_H
#define MCVISI_HOST_CLI_MEASURE_H

#include "analysis/found.h"
#include "cli/command.h"

/* The image and what is known about it. */
typedef struct mcv_subject {
    const mcv_command *command;
    mcv_places places; /* where to measure, as pixels */
    mcv_readings readings;
    const char *noise; /* source of the deviations; NULL: none yet */
    bool whole;        /* a file of integers */
    double largest;    /* largest grey value, NaN if not known */
    double pixel[2];   /* width and height in the object plane [m], 0: not known */
    mcv_camera_model model;
    bool has_model;
    char unit[64];
    mcv_roi *regions, background; /* background.inside: NULL without one */
    size_t region_count;
    mcv_scene *scene; /* of --scene, or NULL */
    uint32_t sensor;
    mcv_found *found; /* results in the boxes, one form after the other */
    size_t found_count;
} mcv_subject;

/* Reads the image at `path` by the command's options. It must be freed by mcv_subject_free even
 * after a failure. */
mcv_result mcv_subject_read(const mcv_command *command, const char *path, mcv_subject *subject,
                            mcv_error *error);
void mcv_subject_free(mcv_subject *subject);

/* --minus: subtracts another image. */
mcv_result mcv_subject_subtract(mcv_subject *subject, mcv_error *error);

/* --scene: takes the scale of the image's sensor. */
mcv_result mcv_subject_scale_by_scene(mcv_subject *subject, mcv_error *error);

/* Prints all figures of the regions and of the results. */
mcv_result mcv_subject_report(mcv_subject *subject, mcv_error *error);

#endif
