/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Approximately how much of an emitter's light a receiver sends on along the path. A receiver
 * chooses among emitters by this, too (light/selection.h): few lamps of a ring lie in the
 * highlights of a metal.
 */
#ifndef MCVISI_KERNELS_LOBE_H
#define MCVISI_KERNELS_LOBE_H

#include "world.h"

/*
 * The approximate response of a receiver to light from a direction, with d the density of
 * microfacets and θ the angle to the normal (mcv_lobe_towards):
 *
 *     f cosθ = microfacet d + spread cosθ/π + even
 *
 * It only ranks emitters. A lobe that is narrower than an emitter is taken as wide as that.
 */
typedef struct mcv_receiver_lobe {
    mcv_vec3 along;                      /* unit, along the brushing */
    float along_squared, across_squared; /* α² */
    float microfacet, spread, even;      /* weights of the three terms */
} mcv_receiver_lobe;

/* Of a receiver without a lobe. */
MCV_LOOP_FUNCTION mcv_receiver_lobe mcv_even_lobe(void) {
    const mcv_receiver_lobe all = {{1.0f, 0.0f, 0.0f}, 1.0f, 1.0f, 0.0f, 0.0f, 1.0f};
    return all;
}

#if MCV_WITH_GLOSSY
/* The way from a receiver to where an emitter's light comes from, unit; *spread: the square of the
 * tangent of half its angle, about. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_way_of_light(__global const mcv_device_emitter *e, mcv_vec3 receiver,
                                            float *spread) {
    const mcv_vec3 way = mcv_sub(mcv_vec(e->middle[0], e->middle[1], e->middle[2]), receiver);
    const float squared = mcv_dot(way, way);
    const float per_squared = squared > 0.0f ? 1.0f / squared : 0.0f;
    mcv_vec3 towards = mcv_scale(way, mcv_sqrt(squared) * per_squared);
    *spread = e->radius * e->radius * per_squared;
#if MCV_WITH_PARALLEL
    const int parallel = e->type == MCV_EMITTER_PARALLEL;
    const float sine = e->parallel.sin_half;
    towards = mcv_either(parallel, mcv_scale(mcv_vec_at(e->parallel.axis), -1.0f), towards);
    *spread = parallel ? sine * sine : *spread;
#endif
#if MCV_WITH_BEAM
    const int beam = e->type == MCV_EMITTER_COLLIMATED_BEAM;
    towards = mcv_either(beam, mcv_scale(mcv_vec_at(e->beam.axis), -1.0f), towards);
    *spread = beam ? 0.0f : *spread;
#endif
    return towards;
}

/*
 * What a receiver sends of an emitter's light against `direction`, about [1/sr]: GGX's density of
 * the microfacets that send its middle there, of an α that the emitter's angle widens. From an
 * emitter without a place comes the mean over the hemisphere.
 */
MCV_LOOP_FUNCTION float mcv_lobe_towards(__global const mcv_device_emitter *e, mcv_vec3 receiver,
                                         mcv_vec3 direction, mcv_vec3 ns, mcv_receiver_lobe lobe) {
    float spread;
    const mcv_vec3 way = mcv_way_of_light(e, receiver, &spread);
    const float upright = mcv_dot(way, ns), cosine = mcv_abs(upright);
    const mcv_vec3 above = mcv_along(way, cosine - upright, ns);
    const mcv_vec3 h = mcv_sub(above, direction);
    const float x = mcv_dot(h, lobe.along), z = mcv_dot(h, ns), all = mcv_dot(h, h);
    const float rest = all - x * x - z * z, y_squared = rest > 0.0f ? rest : 0.0f;
    const float a = mcv_fma(0.25f, spread, lobe.along_squared),
                b = mcv_fma(0.25f, spread, lobe.across_squared);
    const float tilted = mcv_fma(x * x, b, mcv_fma(y_squared, a, z * z * (a * b)));
    const float slope = tilted > 0.0f ? all / tilted : 0.0f;
    const float facets = slope * slope * (a * b) * mcv_sqrt(a * b) * (0.25f / MCV_PI);
    const float wide = cosine * (1.0f / MCV_PI);
    const int nowhere = e->radius < 0.0f;
    const float mean = 0.5f / MCV_PI;
    return mcv_fma(lobe.microfacet, nowhere ? mean : facets,
                   mcv_fma(lobe.spread, nowhere ? mean : wide, lobe.even));
}
#endif

#endif
