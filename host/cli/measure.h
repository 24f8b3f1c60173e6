/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of `mcvisi measure`: what is read, and what is told of it. */
#ifndef MCVISI_HOST_CLI_MEASURE_H
#define MCVISI_HOST_CLI_MEASURE_H

#include "analysis/found.h"
#include "cli/command.h"

/* The image, and what is known of it. */
typedef struct mcv_subject {
    const mcv_command *command;
    mcv_places places; /* where to measure, as pixels */
    mcv_readings readings;
    const char *noise; /* where the deviations come from; NULL: nowhere yet */
    bool whole;        /* a file of whole numbers */
    double largest;    /* grey value, NaN where that is not known */
    double pixel[2];   /* width and height in the object plane [m], 0: not known */
    mcv_camera_model model;
    bool has_model;
    char unit[64];
    mcv_roi *regions, background; /* background.inside: NULL without one */
    size_t region_count;
    mcv_scene *scene; /* of --scene, or NULL */
    uint32_t sensor;
    mcv_found *found; /* in the boxes of all forms, one form after the other */
    size_t found_count;
} mcv_subject;

/* Reads the image at `path` by the command's options. After failure, too, it is freed by
 * mcv_subject_free. */
mcv_result mcv_subject_read(const mcv_command *command, const char *path, mcv_subject *subject,
                            mcv_error *error);
void mcv_subject_free(mcv_subject *subject);

/* --minus: takes the values of another image off. */
mcv_result mcv_subject_subtract(mcv_subject *subject, mcv_error *error);

/* --scene: the scale of the sensor that the image is of. */
mcv_result mcv_subject_scale_by_scene(mcv_subject *subject, mcv_error *error);

/* Prints all figures of the regions and of what was found. */
mcv_result mcv_subject_report(mcv_subject *subject, mcv_error *error);

#endif
