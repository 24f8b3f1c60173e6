/* SPDX-License-Identifier: Apache-2.0 */
/* Retroreflectors (mcvisi/materials/retroreflector.h): n is the unit normal on the side of o, which
 * points to where the path comes from. */
#ifndef MCVISI_KERNELS_RETROREFLECTOR_H
#define MCVISI_KERNELS_RETROREFLECTOR_H

#include "bsdf/scattering.h"
#include "path/sampler.h"

#if MCV_WITH_REFLECTOR
/* Seen from o. */
typedef struct mcv_retroreflection {
    float cosine;     /* of o; 0: the surface is seen edge-on and black */
    float efficiency; /* s²(θ) */
    float chance;     /* with which the path returns rather than being scattered diffusely */
} mcv_retroreflection;

static mcv_retroreflection mcv_retroreflection_at(__global const mcv_device_material *m, mcv_vec3 n,
                                                  mcv_vec3 o) {
    mcv_retroreflection back = {mcv_dot(o, n), 0.0f, 0.0f};
    float most = 0.0f, diffuse = 0.0f;
    if (!(back.cosine > 0.0f)) return back;
    back.efficiency = mcv_retroreflector_efficiency(m->as.retroreflector.fall, back.cosine);
    MCV_EACH_CHANNEL(i) {
        most = m->color[i] > most ? m->color[i] : most;
        diffuse = m->passed[i] > diffuse ? m->passed[i] : diffuse;
    }
    most *= back.efficiency;
    if (most > 0.0f) back.chance = most / (most + diffuse);
    return back;
}

/* What returns exactly is no part of it. */
static mcv_response mcv_retroreflector_respond(__global const mcv_device_material *m, mcv_vec3 n,
                                               mcv_vec3 o, mcv_vec3 i) {
    mcv_response response;
    const mcv_retroreflection back = mcv_retroreflection_at(m, n, o);
    const float cosine = mcv_dot(i, n);
    response.f_cos = mcv_grey(0.0f);
    response.density = 0.0f;
    response.media = 0;
    if (!(cosine > 0.0f) || !(back.cosine > 0.0f)) return response;
    const float diffuse = cosine * (1.0f / MCV_PI);
    const float lobe = m->as.retroreflector.spread > 0.0f
                           ? mcv_retroreflector_density(m->as.retroreflector.spread, o, i)
                           : 0.0f;
    const float efficiency = mcv_sqrt(
        back.efficiency * mcv_retroreflector_efficiency(m->as.retroreflector.fall, cosine));
    const float returned = lobe * efficiency * (cosine < back.cosine ? cosine / back.cosine : 1.0f);
    MCV_EACH_CHANNEL(k)
    response.f_cos.c[k] = mcv_fma(m->color[k], returned, m->passed[k] * diffuse);
    response.density = mcv_fma(back.chance, lobe, (1.0f - back.chance) * diffuse);
    return response;
}

/* A direction with the density that mcv_retroreflector_respond gives, if `returns` has its chance.
 */
static mcv_vec3 mcv_retroreflector_choose(__global const mcv_device_material *m, mcv_vec3 n,
                                          mcv_vec3 o, float xi, float eta, int returns) {
    if (returns) return mcv_retroreflector_sample(m->as.retroreflector.spread, o, xi, eta);
    return mcv_normalize(mcv_from_frame(mcv_sample_cosine(xi, eta), n));
}

/* The direction is unit. Where ns and ng disagree on its side nothing comes. */
MCV_FUNCTION mcv_response mcv_respond_retroreflector(mcv_world world, mcv_interaction interaction,
                                                     uint material, uint media,
                                                     mcv_vec3 direction) {
    mcv_response response =
        mcv_retroreflector_respond(world.materials + material, interaction.ns,
                                   mcv_scale(interaction.direction, -1.0f), direction);
    if (!(mcv_dot(direction, interaction.ng) > 0.0f)) {
        response.f_cos = mcv_grey(0.0f);
        response.density = 0.0f;
    }
    response.media = media;
    return response;
}

MCV_FUNCTION mcv_scattering mcv_scatter_retroreflector(mcv_world world, mcv_interaction interaction,
                                                       uint material, uint media, mcv_pair pair,
                                                       float choice) {
    __global const mcv_device_material *from = world.materials + material;
    const mcv_vec3 o = mcv_scale(interaction.direction, -1.0f);
    const mcv_retroreflection back = mcv_retroreflection_at(from, interaction.ns, o);
    const int returns = back.chance > 0.0f && choice >= 1.0f - back.chance;
    if (returns && from->as.retroreflector.spread == 0.0f) {
        mcv_scattering scattering = mcv_scatter_into(o, media, MCV_EVENT_REFLECT);
        MCV_EACH_CHANNEL(i) scattering.factor.c[i] = from->color[i] * back.efficiency / back.chance;
        scattering.chance = back.chance;
        return scattering;
    }
    const mcv_vec3 direction =
        mcv_retroreflector_choose(from, interaction.ns, o, pair.x, pair.y, returns);
    return mcv_scatter_by(
        direction, mcv_respond_retroreflector(world, interaction, material, media, direction));
}
#endif

#endif
