/* SPDX-License-Identifier: Apache-2.0 */
/* A scene whose emitters show white, so that a matrix has the light of all their pixels. */
#ifndef MCVISI_HOST_TRANSPORT_WHITE_H
#define MCVISI_HOST_TRANSPORT_WHITE_H

#include "transport/matrix.h"

/*
 * Gives each emitter with an image whose pixels are told apart an image of ones, at the same
 * radiance: a light field, a projector, or an image without interpolation (magFilter nearest,
 * patterns). With `lamps` all emitters are one element each. An environment is one element. The
 * matrix gets its groups and the pattern of the scene.
 *
 * Squares of `bin` x `bin` pixels are an element together, whose pattern is their mean; of a light
 * field emitter so many directions, which must divide those of a macro pixel. *columns: the matrix
 * column of each element of the scene, owned by the caller; NULL where all are told apart.
 */
mcv_result mcv_scene_show_white(mcv_scene *scene, bool lamps, uint32_t bin, uint32_t channels,
                                mcv_matrix *matrix, uint32_t **columns, mcv_error *error);

/* How many elements the scene's emitters have in all; MCV_BAD_INPUT for none or more than 2^31. */
mcv_result mcv_scene_elements(const mcv_scene *scene, uint32_t *count, mcv_error *error);

#endif
