/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of sets for pages: rendered for them alone, not measured. */
#ifndef MCVISI_HOST_EXPERIMENT_SET_PICTURE_H
#define MCVISI_HOST_EXPERIMENT_SET_PICTURE_H

#include "experiment/experiment.h"

/* Renders a scene as the experiment's sets are, with the random numbers of its first one, so that
 * the difference of two pictures has little noise. The image is to be freed; there is none after an
 * interruption. */
mcv_result mcv_set_picture(const mcv_sweep *sweep, mcv_scene *scene, mcv_image *image,
                           mcv_error *error);

/* Writes the pictures of the set whose rig the page shows and, of an optimisation, of the first one
 * before it. A set that cannot be rendered has none. Fails only after an interruption, and has
 * written nothing then. */
mcv_result mcv_put_set_pictures(FILE *out, const mcv_sweep *sweep, size_t shown, mcv_error *error);

#endif
