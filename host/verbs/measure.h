/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of `mcvisi measure`: reading the image, and the report. */
#ifndef MCVISI_HOST_VERBS_MEASURE_H
#define MCVISI_HOST_VERBS_MEASURE_H

#include "analysis/found.h"
#include "options/command.h"
#include "verbs/picture.h"
#include "verbs/report.h"

/* The image and what is known about it. */
typedef struct mcv_subject {
    const mcv_command *command;
    const mcv_picture *picture, *minus; /* minus may be NULL */
    mcv_places places;                  /* where to measure, as pixels */
    mcv_readings readings;
    const char *noise; /* source of the deviations; NULL: none yet */
    bool whole;        /* a file of integers */
    uint32_t averaged; /* of how many channels a value is the mean */
    double largest;    /* largest grey value, NaN if not known */
    double pixel[2];   /* width and height in the object plane [m], 0: not known */
    mcv_camera_model model;
    bool has_model;
    char unit[64];
    mcv_roi *regions, background; /* background.inside: NULL without one */
    size_t region_count;
    const mcv_scene *scene; /* of --scene, or NULL */
    uint32_t sensor;
    mcv_found *found; /* results in the boxes, one form after the other */
    size_t found_count;
} mcv_subject;

/*
 * Measures in a picture, or in the difference of two, by the options of `mcvisi measure`, and tells
 * all figures. `scene`: that of --scene, or NULL.
 */
mcv_result mcv_measure(const mcv_command *command, const mcv_picture *picture,
                       const mcv_picture *minus, const mcv_scene *scene, mcv_report *report,
                       mcv_error *error);

/* The parts of it. */

/* Takes the values of the picture by the command's options. After failure, too, the subject is
 * freed by mcv_subject_free. */
mcv_result mcv_subject_read(const mcv_command *command, const mcv_picture *picture,
                            mcv_subject *subject, mcv_error *error);
void mcv_subject_free(mcv_subject *subject);

/* Takes the values of subject->minus off. */
mcv_result mcv_subject_subtract(mcv_subject *subject, mcv_error *error);

/* The scale of the sensor of subject->scene that the image is of. */
mcv_result mcv_subject_scale_by_scene(mcv_subject *subject, mcv_error *error);

/* Tells all figures of the regions and of what was found. */
void mcv_subject_report(mcv_subject *subject, mcv_report *report);

#endif
