/* SPDX-License-Identifier: Apache-2.0 */
/* What shading needs to know of a material. */
#ifndef MCVISI_HOST_SCENE_MATERIALS_H
#define MCVISI_HOST_SCENE_MATERIALS_H

#include "scene/scene.h"

/* The albedos of microfacets are tabulated for the indices of one channel: green. */
enum { MCV_ALBEDO_CHANNEL = 1 };

/* The microfacets of a material; all 0 if it is smooth or has none. */
typedef struct mcv_roughness {
    double roughness;  /* α is its square */
    double anisotropy; /* 0 … 1 */
    double rotation;   /* of the rougher direction from the tangent, counter-clockwise [rad] */
} mcv_roughness;
mcv_roughness mcv_material_roughness(const mcv_material *material);
bool mcv_material_is_rough(const mcv_material *material); /* it consists of microfacets */
bool mcv_material_has_own_bsdf(uint32_t type);            /* one of MCV_OWN_BSDFS */
bool mcv_material_is_plate(uint32_t type);                /* one of MCV_PLATES */
bool mcv_material_has_medium(uint32_t type); /* one of MCV_MEDIUM_MATERIALS: `as.medium` */
double mcv_material_coating(const mcv_material *material,
                            double outside); /* its R0 against a medium of an index, or 0: none */
uint32_t mcv_material_surface_texture(
    const mcv_material *material);                     /* of roughness and metallic, or MCV_NONE */
bool mcv_scene_has_directions(const mcv_scene *scene); /* whether a material is anisotropic */

#endif
