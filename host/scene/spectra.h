/* SPDX-License-Identifier: Apache-2.0 */
/* What depends on the wavelength: indices of materials, and the channels of a scene. */
#ifndef MCVISI_HOST_SCENE_SPECTRA_H
#define MCVISI_HOST_SCENE_SPECTRA_H

#include "scene/scene.h"

/* Sets the indices of a material at the wavelengths of the channels, or at the one of a grey scene.
 */
void mcv_material_settle_spectra(const mcv_scene *scene, mcv_material *material, bool coloured);

/* A scene's wavelengths lie between [m]. */
#define MCV_LEAST_WAVELENGTH 1e-7
#define MCV_LARGEST_WAVELENGTH 1e-4

/*
 * The wavelength that a channel stands for [m]. Unless the scene says, a grey scene is rendered at
 * the d line of helium, 587.6 nm, and the channels of a coloured one at 611.4, 549.1 and 464.2 nm.
 */
double mcv_scene_wavelength(const mcv_scene *scene, int channel);

/* Sets n and k of conductors given by name. Call it when all else is in the scene: what it holds
 * decides whether it is grey. */
void mcv_scene_settle_spectra(mcv_scene *scene);

/* The index of a glass (an option of `glass`) at a wavelength [m]. */
double mcv_glass_index(int glass, double wavelength);

/* The index at a wavelength [m] by Cauchy's first two terms from n_d and Abbe's number; at least 1.
 */
double mcv_cauchy_index(double n_d, double abbe_number, double wavelength);

/* n and k of a metal (an option of `metal`), between the wavelengths of its table by line, beyond
 * them at their ends. */
void mcv_metal_index(int metal, double wavelength, double *n, double *k);

bool mcv_is_grey(const double spectrum[3]);

/* The number of channels that the spectra need: 1 if all are grey and no texture is coloured,
 * else 3. */
uint32_t mcv_scene_channels(const mcv_scene *scene);

#endif
