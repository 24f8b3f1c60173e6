/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns for light transport matrices by the options of `mcvisi relight`, and what is told of
 * matrices. */
#ifndef MCVISI_HOST_VERBS_TRANSPORT_H
#define MCVISI_HOST_VERBS_TRANSPORT_H

#include "options/command.h"
#include "transport/matrix.h"
#include "verbs/report.h"

/*
 * The pattern that --pattern and --set ask for, [element][channel]; the caller frees it. What they
 * do not mention is as in the scene. MCV_USAGE for an emitter that the matrix does not have or that
 * has no pixels, MCV_BAD_INPUT for an image of another size.
 */
mcv_result mcv_pattern_read(const mcv_command *command, const mcv_matrix *matrix, float **pattern,
                            mcv_error *error);

/* Reads an image of linear values: .exr, .npy, or .png of 8 bits, which is decoded as sRGB. */
mcv_result mcv_pattern_image_read(const char *path, mcv_image *image, mcv_error *error);

/* What is told of a matrix: its size, its elements, its entries. */
void mcv_matrix_report(const mcv_matrix *matrix, mcv_report *report);

#endif
