/* SPDX-License-Identifier: Apache-2.0 */
/* The verb deflectometry: fringes on a screen, seen in a part, give its slopes and heights. */
#ifndef MCVISI_HOST_VERBS_DEFLECTOMETRY_H
#define MCVISI_HOST_VERBS_DEFLECTOMETRY_H

#include "deflectometry/form.h"
#include "options/command.h"
#include "verbs/picture.h"
#include "verbs/report.h"

typedef struct mcv_deflectometry {
    mcv_decoded *decoded[2]; /* across columns and rows of the screen, [pixel] */
    double period[2];        /* of the fringes [m] */
    double beats[2];         /* periods P that a beat tells apart; 0: a Gray code does */
    double best[2];          /* the period of the least uncertainty of slopes [m] */
    double best_contrast[2];
    mcv_shape shape;
    mcv_form plane;   /* the best one */
    int form;         /* MCV_FORM_…, what was taken from heights and slopes */
    mcv_form quadric; /* where that is one */
} mcv_deflectometry;

/* The screen of the option `screen`, else the only one. It must show a phaseShift pattern.
 * MCV_USAGE or MCV_BAD_INPUT with a sentence. */
mcv_result mcv_deflectometry_screen(const mcv_scene *scene, const mcv_command *command,
                                    uint32_t *emitter, mcv_error *error);

/* Makes the columns (direction 0) or the rows (1) of a screen its elements: it shows a white line
 * of pixels. */
mcv_result mcv_deflectometry_show(mcv_scene *scene, uint32_t emitter, uint32_t direction,
                                  mcv_error *error);

/* Decodes the fringes of a direction from the matrix of a scene that shows them so. */
mcv_result mcv_deflectometry_decode(const mcv_command *command, const mcv_scene *scene,
                                    uint32_t emitter, uint32_t direction, const mcv_matrix *matrix,
                                    mcv_deflectometry *d, mcv_error *error);

/* Slopes and heights, when both directions are decoded. */
mcv_result mcv_deflectometry_shape(const mcv_command *command, const mcv_scene *scene,
                                   uint32_t sensor, uint32_t emitter, mcv_deflectometry *d,
                                   mcv_error *error);

/* The maps as a picture: "image" are the heights, "error" their uncertainties. */
mcv_result mcv_deflectometry_picture(const mcv_deflectometry *d, mcv_picture **picture,
                                     mcv_error *error);

/* Checks, and writes, the files of the options. */
mcv_result mcv_deflectometry_check(const mcv_command *command, mcv_error *error);
mcv_result mcv_deflectometry_write(const mcv_command *command, const mcv_picture *picture,
                                   mcv_error *error);

void mcv_deflectometry_report(const mcv_deflectometry *d, mcv_report *report);

void mcv_deflectometry_free(mcv_deflectometry *d);

#endif
