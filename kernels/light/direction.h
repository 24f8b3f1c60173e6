/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Emitters that next-event estimation samples in a direction of theirs, without a point on a
 * surface. Each is one function of the same parameters and one line of MCV_DIRECTION_SAMPLERS.
 */
#ifndef MCVISI_KERNELS_DIRECTION_H
#define MCVISI_KERNELS_DIRECTION_H

#include "light/emission.h"
#include "light/environment.h"
#include "light/laser.h"
#include "light/light_sample.h"

#if MCV_WITH_NEXT_EVENT
#if MCV_WITH_BEAM
/* Back along the beam, where it goes through the receiver: its emitter must be the closest hit. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_beam(mcv_world world, mcv_receiver at,
                                                   __global const mcv_device_emitter *e,
                                                   mcv_pair pair) {
    mcv_light_sample sample =
        mcv_light_sample_along(at, mcv_scale(mcv_vec_at(e->beam.axis), -1.0f), e->instance, 0.0f);
    const int lit = mcv_collimated_beam_covers(&e->beam, mcv_sub(at.point, mcv_vec_at(e->middle)));
    sample.radiance_over_pdf = mcv_radiance_over_pdf(e, lit, 1.0f, e->probability);
    (void)world, (void)pair;
    return sample;
}
#endif

#if MCV_WITH_PUNCTUAL
/* The ray ends at the light's position. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_point_light(mcv_world world, mcv_receiver at,
                                                          __global const mcv_device_emitter *e,
                                                          mcv_pair pair) {
    const mcv_vec3 position = mcv_vec_at(e->light.position), towards = mcv_sub(position, at.point);
    const mcv_vec3 direction = mcv_normalize(towards);
    mcv_light_sample sample = mcv_light_sample_along(at, direction, MCV_NONE, 0.0f);
    const float attenuated = mcv_point_light_profile(&e->light, mcv_scale(direction, -1.0f)) *
                             mcv_point_light_attenuation(&e->light, mcv_dot(towards, towards));
    sample.direction = mcv_sub(position, sample.origin);
    sample.radiance_over_pdf = mcv_radiance_over_pdf(e, 1, attenuated, e->probability);
    (void)world, (void)pair;
    return sample;
}

MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_directional(mcv_world world, mcv_receiver at,
                                                          __global const mcv_device_emitter *e,
                                                          mcv_pair pair) {
    mcv_light_sample sample = mcv_light_sample_along(
        at, mcv_scale(mcv_vec_at(e->directional.axis), -1.0f), MCV_SKY, 0.0f);
    sample.radiance_over_pdf = mcv_radiance_over_pdf(e, 1, 1.0f, e->probability);
    (void)world, (void)pair;
    return sample;
}
#endif

#if MCV_WITH_PARALLEL
/*
 * Whether a ray, of unit direction, may meet an emitter: it passes the middle at |way × direction|,
 * which rounds by γ(4) |way|, within its radius. The traversal rounds by γ(6) of the corners'
 * coordinates from the ray's origin (mcv_interaction_error).
 */
MCV_LOOP_FUNCTION int mcv_may_hit(__global const mcv_device_emitter *e, mcv_vec3 origin,
                                  mcv_vec3 direction) {
    const mcv_vec3 way = mcv_sub(mcv_vec_at(e->middle), origin);
    const mcv_vec3 beside = mcv_cross(way, direction);
    const float distance = mcv_abs(way.x) + mcv_abs(way.y) + mcv_abs(way.z);
    const float within = mcv_fma(MCV_GAMMA(32), distance + e->radius, e->radius);
    const int close = mcv_dot(beside, beside) <= within * within,
              ahead = mcv_dot(way, direction) >= -within;
    return close & ahead;
}

/* A direction in the emitter's cone. Most rays from beside a parallel beam pass the emitter by:
 * they bring nothing. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_parallel(mcv_world world, mcv_receiver at,
                                                       __global const mcv_device_emitter *e,
                                                       mcv_pair pair) {
    const mcv_vec3 in_cone = mcv_from_frame(mcv_sample_cone(e->parallel.sin_half, pair.x, pair.y),
                                            mcv_vec_at(e->parallel.axis));
    mcv_light_sample sample = mcv_light_sample_along(at, mcv_scale(in_cone, -1.0f), e->instance,
                                                     mcv_uniform_pdf(e, e->parallel.solid_angle));
    const int lit = mcv_may_hit(e, sample.origin, sample.direction);
    sample.radiance_over_pdf = mcv_radiance_over_pdf(e, lit, 1.0f, sample.pdf);
    (void)world;
    return sample;
}
#endif

#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
/* The numbers by which the sky's rows are searched, and the columns of a row. */
MCV_LOOP_FUNCTION uint mcv_sky_row_bits(mcv_pair pair) { return mcv_cdf_bits(pair.y, pair.x); }

MCV_LOOP_FUNCTION uint mcv_sky_column_bits(mcv_pair pair) { return mcv_cdf_bits(pair.x, pair.y); }

/* A direction into a pixel that was chosen by the same pair. What rounding puts into a neighbouring
 * pixel counts as that one's. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_sky_pixel(mcv_world world, mcv_receiver at,
                                                        __global const mcv_device_emitter *e,
                                                        mcv_pixel chosen, mcv_pair pair) {
    const float across = mcv_cdf_remainder(mcv_environment_row(world, e, chosen.row), chosen.column,
                                           mcv_sky_column_bits(pair)),
                down = mcv_cdf_remainder(world.emitter_cdf + e->cdf, chosen.row,
                                         mcv_sky_row_bits(pair));
    mcv_light_sample sample = mcv_light_sample_along(
        at, mcv_environment_sample(&e->environment, chosen.column, chosen.row, across, down),
        MCV_SKY, 0.0f);
    const mcv_pixel pixel = mcv_sky_pixel_at(e, sample.direction);
    const mcv_color radiance = mcv_pixel_radiance(world, e, pixel);
    sample.pdf = mcv_environment_density(world, e, pixel);
    const float inverse_pdf = 1.0f / sample.pdf;
    MCV_EACH_CHANNEL(i)
    sample.radiance_over_pdf.c[i] = sample.pdf > 0.0f ? radiance.c[i] * inverse_pdf : 0.0f;
    return sample;
}

/* A pixel by what it brings, then a direction into it. */
MCV_FUNCTION mcv_light_sample mcv_sample_environment(mcv_world world, mcv_receiver at,
                                                     __global const mcv_device_emitter *e,
                                                     mcv_pair pair) {
    mcv_pixel chosen;
    chosen.row =
        mcv_search_cdf(world.emitter_cdf + e->cdf, e->environment.height, mcv_sky_row_bits(pair));
    chosen.column = mcv_search_cdf(mcv_environment_row(world, e, chosen.row), e->environment.width,
                                   mcv_sky_column_bits(pair));
    return mcv_sample_sky_pixel(world, at, e, chosen, pair);
}
#endif

/* X(type, sample), of the types that the scene has: sample(world, receiver, emitter, pair). */
#define MCV_DIRECTION_SAMPLERS(X) \
    MCV_WHERE(MCV_WITH_PARALLEL, X(MCV_EMITTER_PARALLEL, mcv_sample_parallel)) \
    MCV_WHERE(MCV_WITH_BEAM, X(MCV_EMITTER_COLLIMATED_BEAM, mcv_sample_beam)) \
    MCV_WHERE(MCV_WITH_LASER, X(MCV_EMITTER_LASER, mcv_sample_laser)) \
    MCV_WHERE(MCV_WITH_PUNCTUAL, X(MCV_EMITTER_POINT, mcv_sample_point_light)) \
    MCV_WHERE(MCV_WITH_PUNCTUAL, X(MCV_EMITTER_DIRECTIONAL, mcv_sample_directional)) \
    MCV_WHERE(MCV_WITH_ENVIRONMENT_IMAGE, \
              MCV_WHERE(MCV_WITH_TEXTURE, X(MCV_EMITTER_ENVIRONMENT, mcv_sample_environment)))

/* Whether an emitter is sampled in a direction, not at a point: parallel emitters have points, too.
 */
MCV_LOOP_FUNCTION int mcv_samples_direction(__global const mcv_device_emitter *e,
                                            mcv_vec3 receiver) {
    int direction = 0;
#define MCV_X(TYPE, sample) direction |= e->type == TYPE;
    MCV_DIRECTION_SAMPLERS(MCV_X)
#undef MCV_X
#if MCV_WITH_PARALLEL
    direction &= (e->type != MCV_EMITTER_PARALLEL) | mcv_samples_cone(e, receiver);
#endif
    (void)e, (void)receiver;
    return direction;
}

/* What comes from an emitter of such a type. Schedules that sort by type give it as a constant. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_direction(mcv_world world, mcv_receiver at,
                                                        __global const mcv_device_emitter *e,
                                                        uint type, mcv_pair pair) {
#define MCV_X(TYPE, sample) \
    if (type == TYPE) return sample(world, at, e, pair);
    MCV_DIRECTION_SAMPLERS(MCV_X)
#undef MCV_X
    (void)world, (void)e, (void)type, (void)pair;
    return mcv_light_sample_along(at, at.ng, MCV_NONE, 0.0f);
}
#endif

#endif
