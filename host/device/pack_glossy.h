/* SPDX-License-Identifier: Apache-2.0 */
/* Glossy materials for the device, with the albedos of their microfacets. */
#ifndef MCVISI_HOST_DEVICE_PACK_GLOSSY_H
#define MCVISI_HOST_DEVICE_PACK_GLOSSY_H

#include "device/pack.h"

/* Fills packed->glossy, the values of rough conductors, and the albedos of reflecting materials.
 * Fails only without memory. `earlier`: see mcv_pack. */
mcv_result mcv_pack_glossy(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                           mcv_error *error);

/* The albedos of the interfaces between media 0 … count, of which m > 0 bounds bodies of the
 * material materials[m]. */
mcv_result mcv_pack_interfaces(const mcv_scene *scene, const mcv_packed *earlier,
                               mcv_packed *packed, uint32_t count, const uint32_t *materials,
                               const double *index, mcv_error *error);

#endif
