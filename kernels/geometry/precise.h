/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mixed precision. Which surface a ray meets is found in float, as ever: watertight and fast. Where
 * a smooth surface is met and which way the ray goes on is then worked out once more in double, for
 * a ray that is known in double. The rays of the traversal start and end where they do without all
 * this; each is but the precise ray's direction rounded, so that errors do not add up from surface
 * to surface.
 *
 * Whether light is reflected or refracted, and how much, floats decide. Where the precise ray would
 * come or go on another side of the surface than the one in floats (grazing it, within rounding),
 * or would miss it, the latter goes on and is the precise one from then on.
 */
#ifndef MCVISI_KERNELS_PRECISE_H
#define MCVISI_KERNELS_PRECISE_H

#include "bsdf/bsdf.h"
#include "geometry/precise_surface.h"

#if MCV_WITH_MIXED
typedef struct mcv_onward {
    mcv_precise_ray ray;
    int precise; /* 0: only the rounded ray is known */
} mcv_onward;

MCV_FUNCTION mcv_vec3 mcv_onward_low(const mcv_onward *onward, mcv_dvec whole, mcv_vec3 v) {
    return onward->precise ? mcv_low_of(whole, v) : mcv_vec(0.0f, 0.0f, 0.0f);
}

MCV_FUNCTION mcv_precise_ray mcv_precise_ray_of(mcv_vec3 origin, mcv_vec3 origin_low,
                                                mcv_vec3 direction, mcv_vec3 direction_low) {
    mcv_precise_ray ray;
    ray.origin = mcv_whole(origin, origin_low);
    ray.direction = mcv_whole(direction, direction_low);
    return ray;
}

MCV_FUNCTION mcv_dvec mcv_reflect_d(mcv_dvec d, mcv_dvec n) {
    return mcv_normalize_d(mcv_along_d(d, -2.0 * mcv_dot_d(d, n), n));
}

#if MCV_WITH_DIELECTRIC
/* As mcv_refract, from the index n1 into n2; the zero vector at total reflection. */
static mcv_dvec mcv_refract_d(double n1, double n2, mcv_dvec d, mcv_dvec n) {
    const double eta = n1 / n2, delta = (n2 - n1) * (n2 + n1) / (n2 * n2);
    const double cosine = -mcv_dot_d(d, n), c1 = cosine < 1.0 ? cosine : 1.0;
    const double squared = fma(c1, c1, fma(-c1, c1, 1.0) * delta);
    if (!(squared > 0.0)) return mcv_dvec_of(0.0, 0.0, 0.0);
    return mcv_normalize_d(
        mcv_along_d(mcv_scale_d(d, eta), -delta / fma(eta, c1, sqrt(squared)), n));
}
#endif

/* The direction in which a ray goes on that scatters as `on` says; the zero vector where none is
 * known. */
static mcv_dvec mcv_turn_precisely(mcv_world world, const mcv_interaction *interaction,
                                   const mcv_precise_interaction *met, mcv_dvec d, uint media,
                                   const mcv_scattering *on) {
    mcv_dvec turned = d;
    (void)world, (void)media;
    if (on->event == MCV_EVENT_REFLECT) {
        const uint material = world.instances[interaction->surface.instance].material,
                   type = world.materials[material].type;
        if (type == MCV_MATERIAL_RETROREFLECTOR) return mcv_scale_d(d, -1.0);
        /* Another law of its own: only floats know it. */
        if (MCV_IS_MATERIAL_OF(MCV_OWN_BSDFS, type)) return mcv_dvec_of(0.0, 0.0, 0.0);
        turned = mcv_reflect_d(d, met->ns);
        if (!(mcv_dot_d(turned, met->ng) > 0.0)) turned = mcv_reflect_d(d, met->ng);
    }
#if MCV_WITH_DIELECTRIC
    if (on->event == MCV_EVENT_REFRACT) {
        const uint before = mcv_cross_surface(world, interaction, media).before;
        const double n1 = world.refractive_indices[mcv_filling_medium(before)];
        const double n2 = world.refractive_indices[mcv_filling_medium(on->media)];
        turned = mcv_refract_d(n1, n2, d, met->ns);
        if (!(mcv_dot_d(turned, met->ng) < 0.0)) turned = mcv_refract_d(n1, n2, d, met->ng);
    }
#endif
    return turned;
}

/* The ray that goes on from a surface as `on` says, whose direction becomes that ray's, rounded. */
static mcv_onward mcv_go_on_precisely(mcv_world world, const mcv_interaction *interaction,
                                      const mcv_precise_interaction *met, mcv_dvec d, uint media,
                                      mcv_scattering *on) {
    mcv_onward onward;
    onward.precise = 0;
    if (!met->found || on->event == MCV_EVENT_NON_SPECULAR) return onward;
    onward.ray.origin = met->point;
    onward.ray.direction = mcv_turn_precisely(world, interaction, met, d, media, on);
    const mcv_vec3 rounded = mcv_narrow(onward.ray.direction);
    const float side = mcv_dot(rounded, interaction->ng),
                side_of_floats = mcv_dot(on->direction, interaction->ng);
    onward.precise = side * side_of_floats > 0.0f;
    if (onward.precise) on->direction = rounded;
    return onward;
}
#endif

#endif
