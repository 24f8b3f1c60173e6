/* SPDX-License-Identifier: Apache-2.0 */
/* What depends on the wavelength: indices of materials, and the channels of a scene. */
#ifndef MCVISI_HOST_SCENE_SPECTRA_H
#define MCVISI_HOST_SCENE_SPECTRA_H

#include "scene/scene.h"

/* Sets the indices of a material at the wavelengths of the channels, or at the one of a grey scene.
 */
void mcv_material_settle_spectra(const mcv_scene *scene, mcv_material *material, bool coloured);

#endif
