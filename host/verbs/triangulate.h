/* SPDX-License-Identifier: Apache-2.0 */
/* The verb triangulate: from images of a laser line to profiles. */
#ifndef MCVISI_HOST_VERBS_TRIANGULATE_H
#define MCVISI_HOST_VERBS_TRIANGULATE_H

#include "core/basics.h"
#include "options/command.h"
#include "triangulation/light_plane.h"
#include "triangulation/profile.h"
#include "verbs/measure.h"
#include "verbs/picture.h"
#include "verbs/report.h"

typedef struct mcv_profiles {
    const mcv_command *command;
    uint32_t count, length;    /* profiles, and points of each */
    uint32_t added;            /* profiles so far */
    mcv_profile_point *points; /* owned */
    mcv_transform frame;       /* of the first image */
    bool moved;                /* by --feed, or with the frame */
    bool speckled;             /* the uncertainty has speckle */
    bool noisy;                /* the images state their noise */
    bool calibrated;           /* heights are by `plane` */
    bool undistorted;          /* heights are by a lens without distortion */
    mcv_light_plane plane;     /* of --calibration, or the one that --calibrate fits */
    double (*lit)[3];          /* owned: with --calibrate, places of the target */
    size_t lit_count;
} mcv_profiles;

/* Checks the options for `count` images, and that the files can be written. MCV_USAGE with a
 * sentence. */
mcv_result mcv_profiles_begin(const mcv_command *command, mcv_texts images, mcv_profiles *profiles,
                              mcv_error *error);

/* Finds the profile of the next image. MCV_BAD_INPUT where it has another size than the first, or
 * its header lacks what heights need. */
mcv_result mcv_profiles_add(mcv_profiles *profiles, const mcv_picture *picture, mcv_error *error);

/* A node of the header, without scale; `option` is for messages. */
mcv_result mcv_subject_node(const mcv_subject *subject, const char *name, const char *option,
                            mcv_transform *rigid, mcv_error *error);

/* triangulate_files.c: writes the files of --output. */
mcv_result mcv_profiles_write(const mcv_profiles *profiles, mcv_error *error);

/* The range image: heights with their uncertainty, and what else is known of each point. */
mcv_result mcv_profiles_picture(const mcv_profiles *profiles, mcv_picture **picture,
                                mcv_error *error);

/* Tells what was found. */
void mcv_profiles_report(const mcv_profiles *profiles, mcv_report *report);

/* Also after failure. */
void mcv_profiles_free(mcv_profiles *profiles);

#endif
