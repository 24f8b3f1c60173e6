/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a path continues from a surface.
 *
 * The shading normal ns bends light, the geometric normal ng decides on which side it continues:
 * where both disagree (at a silhouette) ng is used for both.
 */
#ifndef MCVISI_KERNELS_SCATTERING_H
#define MCVISI_KERNELS_SCATTERING_H

#include "geometry/interaction.h"
#include "mcvisi/events.h"

/* How a path goes on. */
typedef struct mcv_scattering {
    mcv_vec3 direction;
    mcv_color factor; /* of the throughput; all 0: the path ends */
    float density;    /* [1/sr], 0 for smooth surfaces */
    float chance;    /* with which a surface of glass, a plate or a retroreflector chose this way on
                        of its two */
    float remainder; /* rough glass: what is left of the number that chose it */
    uint media;
    uint event; /* MCV_EVENT_… */
} mcv_scattering;

/* All light continues in a direction, in the same media. */
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_into(mcv_vec3 direction, uint media, uint event) {
    mcv_scattering scattering;
    scattering.direction = direction;
    scattering.factor = mcv_grey(1.0f);
    scattering.density = 0.0f;
    scattering.chance = 1.0f;
    scattering.remainder = 0.0f;
    scattering.media = media;
    scattering.event = event;
    return scattering;
}

/* Scatters into a direction that is chosen with the density of its response. */
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_by(mcv_vec3 direction, mcv_response response) {
    mcv_scattering scattering = mcv_scatter_into(direction, response.media, MCV_EVENT_NON_SPECULAR);
    const float scale = 1.0f / response.density;
    MCV_EACH_CHANNEL(c)
    scattering.factor.c[c] = response.density > 0.0f ? response.f_cos.c[c] * scale : 0.0f;
    scattering.density = response.density;
    return scattering;
}

/* a or b, word by word as in mcv_either: all but the remainder. Of rough glass that is read before
 * (mcv_shade_hit). */
MCV_LOOP_FUNCTION mcv_scattering mcv_either_scattering(int condition, mcv_scattering a,
                                                       mcv_scattering b) {
    mcv_scattering chosen;
    chosen.direction = mcv_either(condition, a.direction, b.direction);
    MCV_EACH_CHANNEL(i) chosen.factor.c[i] = condition ? a.factor.c[i] : b.factor.c[i];
    chosen.density = condition ? a.density : b.density;
    chosen.chance = condition ? a.chance : b.chance;
    chosen.media = condition ? a.media : b.media;
    chosen.event = condition ? a.event : b.event;
    return chosen;
}

/* One of a smooth surface's two ways on; *other is the other one. */
MCV_LOOP_FUNCTION mcv_scattering mcv_either_way(mcv_scattering reflected, mcv_scattering passed,
                                                int reflects, mcv_scattering *other) {
    *other = mcv_either_scattering(reflects, passed, reflected);
    return mcv_either_scattering(reflects, reflected, passed);
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_reflected(mcv_interaction interaction) {
    const mcv_vec3 d = mcv_reflect(interaction.direction, interaction.ns);
    return mcv_either(mcv_dot(d, interaction.ng) > 0.0f, d,
                      mcv_reflect(interaction.direction, interaction.ng));
}

/* As a mirror does. */
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_mirrored(mcv_interaction interaction, uint media) {
    return mcv_scatter_into(mcv_reflected(interaction), media, MCV_EVENT_REFLECT);
}

#endif
