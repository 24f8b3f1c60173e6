/* SPDX-License-Identifier: Apache-2.0 */
/* Places to measure in, in the coordinates of a part: @NODE:X,Y,Z,W,H instead of the pixels
 * X,Y,W,H. */
#ifndef MCVISI_HOST_ANALYSIS_PART_PLACE_H
#define MCVISI_HOST_ANALYSIS_PART_PLACE_H

#include "scene/camera_model.h"

/*
 * The text "[NAME=]PLACE[+PLACE…]" with each PLACE of the form @NODE:X,Y,Z,W,H as X,Y,W,H in whole
 * pixels; others stay as they are. X, Y, Z lie along the axes of the node (mcv_placement), W and H
 * along the columns and rows of the image in the depth of the place, which is the middle of the
 * rectangle; numbers with a unit, or metres. `what` ("--edge") stands in messages. The caller frees
 * *out. model: that of the image of width x height pixels, or NULL. MCV_USAGE where a place cannot
 * be read, its node is none or it leaves the image.
 */
mcv_result mcv_part_place_resolve(const char *what, const char *text, const mcv_camera_model *model,
                                  char **out, mcv_error *error);

#endif
