/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns for light transport matrices by the options of `mcvisi relight`, and what is told of
 * matrices. */
#ifndef MCVISI_HOST_VERBS_TRANSPORT_H
#define MCVISI_HOST_VERBS_TRANSPORT_H

#include "options/command.h"
#include "scene/pattern.h"
#include "transport/matrix.h"
#include "verbs/report.h"

/*
 * The pattern that --pattern and --set ask for, [element][channel]; the caller frees it. What they
 * do not mention is as in the scene. MCV_USAGE for an emitter that the matrix does not have or that
 * has no pixels, MCV_BAD_INPUT for an image of another size.
 */
mcv_result mcv_pattern_read(const mcv_command *command, const mcv_matrix *matrix, float **pattern,
                            mcv_error *error);

/* Splits [EMITTER=]WHAT of an option. The emitter may be left out where only one has pixels.
 * MCV_USAGE where it is not clear, or has no pixels. */
mcv_result mcv_pattern_group(const mcv_matrix *matrix, const char *option, const char *item,
                             const mcv_element_group **group, const char **shown, mcv_error *error);

/* The patterns of --sequence, shown one after the other by an emitter. */
typedef struct mcv_sequence {
    const mcv_element_group *group;
    mcv_pattern pattern;
} mcv_sequence;

/* MCV_USAGE for what is no pattern of a scene, or has another size than the emitter's image. */
mcv_result mcv_sequence_read(const mcv_command *command, const mcv_matrix *matrix,
                             mcv_sequence *sequence, mcv_error *error);

/* Puts image `index` into the emitter's part of a pattern, [element][channel]. */
void mcv_sequence_show(const mcv_sequence *sequence, uint32_t channels, uint32_t index,
                       float *pattern);

/* The weights of the emitters that --fit finds. */
typedef struct mcv_fitted {
    double *weights, *errors; /* of each emitter */
} mcv_fitted;

/* Fits, and multiplies the pattern by the weights. After failure, too, it is freed by
 * mcv_fitted_free. */
mcv_result mcv_fitted_find(const mcv_command *command, const mcv_matrix *matrix, float *pattern,
                           mcv_fitted *fitted, mcv_error *error);
void mcv_fitted_report(const mcv_fitted *fitted, const mcv_matrix *matrix, mcv_report *report);
void mcv_fitted_free(mcv_fitted *fitted);

/* Reads an image of linear values: .exr, .npy, or .png of 8 bits, which is decoded as sRGB. */
mcv_result mcv_pattern_image_read(const char *path, mcv_image *image, mcv_error *error);

/* What is told of a matrix: its size, its elements, its entries. */
void mcv_matrix_report(const mcv_matrix *matrix, mcv_report *report);

#endif
