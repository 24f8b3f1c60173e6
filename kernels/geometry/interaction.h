/* SPDX-License-Identifier: Apache-2.0 */
/* A surface as the ray sees it that hits it, and the rays that leave it. */
#ifndef MCVISI_KERNELS_INTERACTION_H
#define MCVISI_KERNELS_INTERACTION_H

#include "geometry/surface.h"
#include "geometry/solid_surface.h"

/* A surface seen from where the ray comes from. */
typedef struct mcv_interaction {
    mcv_surface surface;
    mcv_vec3 direction; /* of the ray, unit */
    mcv_vec3 ng, ns;    /* geometric and shading normal, unit, on the ray's side: both have
                           cosines < 0 to the direction */
    uint back_face;     /* 1: the ray comes from behind the front side */
#if MCV_WITH_CONTACT
    uint exited, entered; /* media of other bodies whose surfaces are in the same place */
    mcv_vec3 beyond_point, beyond_error; /* of the last of these surfaces */
    uint touched; /* if this is a triangle: an exact one of them, or MCV_NONE */
    mcv_vec3 touched_ng;
#endif
#if MCV_TILE && MCV_WITH_DIFFUSE
    int bounces; /* 1: worked out beforehand for many paths is where it goes on if the surface is
                    diffuse */
    mcv_vec3 bounce;
    float bounce_density;
#endif
#if MCV_TILE && MCV_WITH_GLOSSY
    struct mcv_glossy_interaction
        *glossy;        /* where to keep what is worked out of a glossy surface, or NULL */
    uint *glossy_known; /* 1: it is there */
#endif
} mcv_interaction;

MCV_LOOP_FUNCTION mcv_interaction mcv_surface_interaction(mcv_surface surface, mcv_vec3 direction) {
    mcv_interaction interaction;
    interaction.surface = surface;
    interaction.direction = direction;
    interaction.back_face = mcv_dot(direction, interaction.surface.ng) > 0.0f;
    interaction.ng = mcv_scale(interaction.surface.ng, interaction.back_face ? -1.0f : 1.0f);
    interaction.ns = mcv_scale(interaction.surface.ns, interaction.back_face ? -1.0f : 1.0f);
    interaction.ns =
        mcv_either(mcv_dot(direction, interaction.ns) < 0.0f, interaction.ns, interaction.ng);
#if MCV_TILE && MCV_WITH_DIFFUSE
    interaction.bounces = 0;
#endif
#if MCV_TILE && MCV_WITH_GLOSSY
    interaction.glossy = 0;
#endif
    return interaction;
}

/* The surface that a ray from the origin has met. */
MCV_LOOP_FUNCTION mcv_surface mcv_hit_surface(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                              mcv_hit hit) {
    if (mcv_is_exact(hit.primitive))
        return mcv_exact_surface_at(world, hit.primitive, hit.u, origin, direction, hit.t);
    return mcv_surface_at(world, hit.primitive, hit.u, hit.v);
}

/* The origin of a ray that goes on from there. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_onward_origin(mcv_interaction interaction, mcv_vec3 direction) {
    mcv_vec3 point = interaction.surface.point, error = interaction.surface.error;
#if MCV_WITH_CONTACT
    const int passes = mcv_dot(direction, interaction.ng) < 0.0f;
    point = mcv_either(passes, interaction.beyond_point, point);
    error = mcv_either(passes, interaction.beyond_error, error);
#endif
    return mcv_offset_origin(point, error, interaction.ng, direction);
}

/* What a ray remembers of the exact surface that it starts on (mcv_mark_origin_surface), or
 * MCV_NONE. */
MCV_LOOP_FUNCTION uint mcv_origin_surface_of(mcv_world world, mcv_interaction interaction,
                                             mcv_vec3 direction) {
    mcv_surface surface = interaction.surface;
#if MCV_WITH_CONTACT
    const int touches = interaction.touched != MCV_NONE;
    surface.primitive = touches ? interaction.touched : surface.primitive;
    surface.ng = mcv_either(touches, interaction.touched_ng, surface.ng);
#endif
    return mcv_mark_origin_surface(world, surface, direction);
}

#endif
