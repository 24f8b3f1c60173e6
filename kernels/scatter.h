/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a path goes on from a surface: the materials.
 *
 * Interpolated normals bend light, the triangle's face decides on which side it goes on: where both disagree (at a silhouette) the face's
 * normal is used.
 */
#ifndef MCVISI_KERNELS_SCATTER_H
#define MCVISI_KERNELS_SCATTER_H

#include "sampler.h"
#include "surface.h"

/* A surface seen from where the ray comes from. */
typedef struct mcv_meeting {
    mcv_surface surface;
    mcv_vec3 direction;    /* of the ray, unit */
    mcv_vec3 face, normal; /* unit, on the ray's side: direction·face < 0, direction·normal < 0 */
    uint inside;           /* 1: the ray comes from behind the front side */
#if MCV_TILE && MCV_WITH_DIFFUSE
    int bounces; /* 1: worked out beforehand for many paths is where it goes on if the surface is diffuse */
    mcv_vec3 bounce;
    float bounce_density;
#endif
} mcv_meeting;

MCV_LOOP_FUNCTION mcv_meeting mcv_meet_at(mcv_surface surface, mcv_vec3 direction) {
    mcv_meeting meeting;
    meeting.surface = surface;
    meeting.direction = direction;
    meeting.inside = mcv_dot(direction, meeting.surface.face) > 0.0f;
    meeting.face = mcv_scale(meeting.surface.face, meeting.inside ? -1.0f : 1.0f);
    meeting.normal = mcv_scale(meeting.surface.normal, meeting.inside ? -1.0f : 1.0f);
    meeting.normal = mcv_choose(mcv_dot(direction, meeting.normal) < 0.0f, meeting.normal, meeting.face);
#if MCV_TILE && MCV_WITH_DIFFUSE
    meeting.bounces = 0;
#endif
    return meeting;
}

MCV_FUNCTION mcv_meeting mcv_meet(mcv_world world, mcv_vec3 direction, uint triangle, float u, float v) {
    return mcv_meet_at(mcv_surface_at(world, triangle, u, v), direction);
}

/* How a path goes on. */
typedef struct mcv_scattering {
    mcv_vec3 direction;
    mcv_color factor; /* of the throughput; all 0: the path ends */
    float density;    /* [1/sr], 0 for smooth surfaces */
    float chance;     /* with which a smooth surface chose this way on of its two */
    uint media;
    uint event; /* MCV_EVENT_… */
} mcv_scattering;

#if MCV_WITH_DIELECTRIC || MCV_WITH_SHEET || MCV_WITH_MIRROR
MCV_FUNCTION mcv_vec3 mcv_reflected(mcv_meeting meeting) {
    const mcv_vec3 d = mcv_reflect(meeting.direction, meeting.normal);
    return mcv_dot(d, meeting.face) > 0.0f ? d : mcv_reflect(meeting.direction, meeting.face);
}
#endif

#if MCV_WITH_DIELECTRIC
/* xi in [0, 1) chooses reflection with probability R; 1 always refracts where that is possible. */
static mcv_scattering mcv_scatter_dielectric(mcv_world world, mcv_meeting meeting, uint media, uint medium, float xi, uint *unmatched) {
    mcv_scattering scattering;
    const uint bit = 1u << (medium - 1u);
    const uint before = meeting.inside ? media | bit : media & ~bit;
    const uint after = before ^ bit;
    if (before != media) *unmatched += 1u;
    const mcv_device_interface between = world.interfaces[mcv_filling_medium(before) * (MCV_MAX_MEDIA + 1u) + mcv_filling_medium(after)];
    scattering.factor = mcv_grey(1.0f);
    scattering.density = 0.0f;
    scattering.media = after;
    scattering.direction = meeting.direction;
    scattering.event = MCV_EVENT_PASS;
    scattering.chance = 1.0f;
    if (between.delta == 0.0f) return scattering;

    const float c1 = -mcv_dot(meeting.direction, meeting.normal);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    const float c2 = mcv_refracted_cosine(between, cosine);
    const float reflectance = mcv_fresnel(between, cosine, c2);
    if (xi < reflectance || !(c2 > 0.0f)) {
        scattering.chance = reflectance;
        scattering.media = before;
        scattering.direction = mcv_reflected(meeting);
        scattering.event = MCV_EVENT_REFLECT;
        return scattering;
    }
    scattering.chance = 1.0f - reflectance;
    scattering.event = MCV_EVENT_REFRACT;
    scattering.direction = mcv_refract(between, meeting.direction, meeting.normal, cosine, c2);
    if (!(mcv_dot(scattering.direction, meeting.face) < 0.0f)) {
        const float f1 = -mcv_dot(meeting.direction, meeting.face);
        const float f2 = mcv_refracted_cosine(between, f1);
        scattering.direction = f2 > 0.0f ? mcv_refract(between, meeting.direction, meeting.face, f1, f2) : meeting.direction;
    }
    return scattering;
}
#endif

#if MCV_WITH_SHEET
static mcv_scattering mcv_scatter_sheet(mcv_world world, mcv_meeting meeting, mcv_device_material material, mcv_color transmittance,
                                        uint media, float xi) {
    mcv_scattering scattering;
    mcv_device_interface into;
    into.eta = material.eta;
    into.delta = material.delta;
#if MCV_WITH_DIELECTRIC
    /* The table holds it in vacuum. */
    if (media != 0) {
        const float squared = material.eta * material.eta / world.media[mcv_filling_medium(media)].inverse_index_squared;
        into.eta = mcv_sqrt(squared);
        into.delta = 1.0f - squared;
    }
#else
    (void)world;
#endif
    const float c1 = -mcv_dot(meeting.direction, meeting.normal);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    const float reflectance = mcv_sheet_reflectance(into, cosine);
    const int reflected = xi < reflectance;
    scattering.chance = reflected ? reflectance : 1.0f - reflectance;
    scattering.direction = reflected ? mcv_reflected(meeting) : meeting.direction;
    scattering.factor = reflected ? mcv_grey(1.0f) : transmittance;
    scattering.density = 0.0f;
    scattering.media = media;
    scattering.event = reflected ? MCV_EVENT_REFLECT : MCV_EVENT_PASS;
    return scattering;
}
#endif

#if MCV_WITH_SHEET
static mcv_scattering mcv_scatter_beam_splitter(mcv_meeting meeting, mcv_device_material material, uint media, float xi) {
    mcv_scattering scattering;
    const int reflected = xi < material.chance;
    scattering.chance = reflected ? material.chance : 1.0f - material.chance;
    scattering.direction = reflected ? mcv_reflected(meeting) : meeting.direction;
    MCV_EACH_CHANNEL(i) scattering.factor.c[i] = (reflected ? material.value[i] : material.passed[i]) / scattering.chance;
    scattering.density = 0.0f;
    scattering.media = media;
    scattering.event = reflected ? MCV_EVENT_REFLECT : MCV_EVENT_PASS;
    return scattering;
}
#endif

#if MCV_WITH_DIFFUSE
static mcv_scattering mcv_scatter_diffuse(mcv_meeting meeting, mcv_color reflectance, uint media, mcv_pair pair) {
    mcv_scattering scattering;
#if MCV_TILE
    if (meeting.bounces) {
        scattering.direction = meeting.bounce;
        scattering.density = meeting.bounce_density;
    } else
#endif
        scattering.direction = mcv_diffuse_sample(meeting.normal, pair.x, pair.y, &scattering.density);
    scattering.chance = 1.0f;
    scattering.factor = mcv_dot(scattering.direction, meeting.face) > 0.0f ? reflectance : mcv_grey(0.0f);
    scattering.media = media;
    scattering.event = MCV_EVENT_END;
    return scattering;
}
#endif

#if MCV_WITH_NEXT_EVENT
/* What a surface that spreads light makes of light from a direction. */
typedef struct mcv_response {
    mcv_color value; /* f cosθ [1/sr]: the share that goes on towards the ray */
    float density;   /* with which mcv_scatter chooses the direction [1/sr] */
} mcv_response;

/* The direction is unit and leads away from the surface; what cannot come from there is 0. */
static mcv_response mcv_respond(mcv_world world, mcv_meeting meeting, mcv_vec3 direction) {
    mcv_response response;
    const uint material = world.instances[meeting.surface.instance].material;
    response.value = mcv_grey(0.0f);
    response.density = 0.0f;
#if MCV_WITH_DIFFUSE
    if (world.materials[material].type == MCV_MATERIAL_DIFFUSE) {
        const float cosine = mcv_dot(direction, meeting.normal);
        if (!(cosine > 0.0f) || !(mcv_dot(direction, meeting.face) > 0.0f)) return response;
        response.density = mcv_diffuse_density(cosine);
        response.value = mcv_dim(mcv_material_value(world, meeting.surface, material), response.density);
    }
#endif
    return response;
}
#endif

/* What the surface emits towards the ray, L/n², weighed against next-event estimation by the balance heuristic. */
MCV_FUNCTION mcv_color mcv_emission_met(mcv_world world, mcv_meeting meeting, uint emitter, uint media, float density, float distance) {
#if MCV_WITH_EMISSION
    mcv_color radiance = mcv_emitted(world, meeting.surface, emitter, mcv_scale(meeting.direction, -1.0f));
#if MCV_WITH_DIELECTRIC
    radiance = mcv_dim(radiance, world.media[mcv_filling_medium(media)].inverse_index_squared);
#else
    (void)media;
#endif
#if MCV_WITH_NEXT_EVENT
    if (density > 0.0f && mcv_brightest(radiance) > 0.0f) {
        const mcv_vec3 receiver = mcv_along(meeting.surface.point, -distance, meeting.direction);
        const float other = mcv_emitter_density(world, receiver, meeting.surface, emitter, meeting.direction, distance);
        radiance = mcv_dim(radiance, density / (density + other));
    }
#else
    (void)density;
    (void)distance;
#endif
    return radiance;
#else
    (void)world, (void)meeting, (void)emitter, (void)media, (void)density, (void)distance;
    return mcv_grey(0.0f);
#endif
}

/* Chooses how the path goes on from the surface it met. */
static mcv_scattering mcv_scatter(mcv_world world, mcv_meeting meeting, uint media, mcv_pair pair, uint *unmatched) {
    mcv_scattering scattering;
    const mcv_device_instance instance = world.instances[meeting.surface.instance];
    const mcv_device_material material = world.materials[instance.material];
    scattering.direction = meeting.direction;
    scattering.factor = mcv_grey(0.0f);
    scattering.density = 0.0f;
    scattering.chance = 1.0f;
    scattering.media = media;
    scattering.event = MCV_EVENT_END;
#if MCV_WITH_DIELECTRIC
    if (material.type == MCV_MATERIAL_DIELECTRIC) return mcv_scatter_dielectric(world, meeting, media, instance.medium, pair.x, unmatched);
#else
    (void)unmatched;
#endif
#if MCV_WITH_DIFFUSE
    if (material.type == MCV_MATERIAL_DIFFUSE) {
        return mcv_scatter_diffuse(meeting, mcv_material_value(world, meeting.surface, instance.material), media, pair);
    }
#endif
#if MCV_WITH_SHEET
    if (material.type == MCV_MATERIAL_SHEET) {
        return mcv_scatter_sheet(world, meeting, material, mcv_material_value(world, meeting.surface, instance.material), media, pair.x);
    }
#endif
#if MCV_WITH_SHEET
    if (material.type == MCV_MATERIAL_BEAM_SPLITTER) return mcv_scatter_beam_splitter(meeting, material, media, pair.x);
#endif
#if MCV_WITH_MIRROR
    if (material.type == MCV_MATERIAL_MIRROR) {
        scattering.direction = mcv_reflected(meeting);
        scattering.factor = mcv_material_value(world, meeting.surface, instance.material);
        scattering.event = MCV_EVENT_REFLECT;
    }
#endif
    (void)material;
    (void)pair;
    return scattering;
}

#endif
