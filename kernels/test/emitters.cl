/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Next-event estimation from receivers anywhere in a scene, and what rays from there meet, one
 * work-item per case: how tests/kernels/test_emitter_sampling.c sees the functions that the stages
 * call.
 */
#undef MCV_WITH_DIFFUSE
#define MCV_WITH_DIFFUSE 1 /* the receivers */
#undef MCV_WITH_NEXT_EVENT
#define MCV_WITH_NEXT_EVENT 1

#include "stage/sample_emitters.h"

/* What a ray from a receiver meets of an emitter: cosine to its face, radiance (first channel) and
 * the density of next-event estimation there. */
static void mcv_shade_emitter_hit(mcv_world world, mcv_vec3 receiver, mcv_vec3 direction,
                                  uint emitter, __global float *met) {
    const mcv_hit hit =
        mcv_intersect_closest_ray(world.nodes, world.leaves, receiver, direction, INFINITY);
    met[0] = 1.0f;
    met[1] = 0.0f;
    met[2] = 0.0f;
    (void)hit, (void)emitter;
#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
    if (hit.primitive == MCV_NONE && world.emitters[emitter].type == MCV_EMITTER_ENVIRONMENT) {
        const mcv_pixel pixel = mcv_sky_pixel_at(world.emitters + emitter, direction);
        met[1] = mcv_pixel_radiance(world, world.emitters + emitter, pixel).c[0];
        met[2] = mcv_environment_density(world, world.emitters + emitter, pixel);
    }
#endif
#if MCV_HAS_EMISSION
    if (hit.primitive == MCV_NONE ||
        world.instances[mcv_instance_of(world, hit.primitive)].emitter != emitter)
        return;
    const mcv_surface there = mcv_surface_at(world, hit.primitive, hit.u, hit.v);
    met[0] = mcv_abs(mcv_dot(direction, there.ng));
    met[1] = mcv_emitted(world, there, emitter, mcv_scale(direction, -1.0f)).c[0];
    __global const mcv_device_emitter *e = world.emitters + emitter;
    met[2] =
        mcv_density_towards(e, mcv_is_rectangle(e), mcv_triangle_pmf(world, e, there.primitive),
                            receiver, there, direction, hit.t);
#endif
}

/* cases: receiver, its normal, ξ, η; results: unit direction, light, density, and what
 * mcv_shade_emitter_hit says along it. */
__kernel void sample_towards(MCV_WORLD_PARAMETERS uint emitter, __global const float *cases,
                             __global float *results) {
    MCV_MAKE_WORLD(world)
    const uint i = get_global_id(0);
    __global const float *in = cases + 8 * i;
    __global float *out = results + 8 * i;
    mcv_receiver at;
    mcv_pair pair;
    at.point = mcv_vec(in[0], in[1], in[2]);
    at.error = mcv_vec(0.0f, 0.0f, 0.0f);
    at.ng = mcv_vec(in[3], in[4], in[5]);
    pair.x = in[6];
    pair.y = in[7];
    const mcv_light_sample sample = mcv_sample_towards(world, at, emitter, pair);
    const mcv_vec3 direction = mcv_normalize(sample.direction);
    out[0] = direction.x;
    out[1] = direction.y;
    out[2] = direction.z;
    out[3] = sample.radiance_over_pdf.c[0];
    out[4] = sample.pdf;
    mcv_shade_emitter_hit(world, at.point, direction, emitter, out + 5);
}

/* cases: receiver, unit direction, two words of no account; results as above, the first five of no
 * account. */
__kernel void meet_emitter(MCV_WORLD_PARAMETERS uint emitter, __global const float *cases,
                           __global float *results) {
    MCV_MAKE_WORLD(world)
    const uint i = get_global_id(0);
    __global const float *in = cases + 8 * i;
    mcv_shade_emitter_hit(world, mcv_vec(in[0], in[1], in[2]), mcv_vec(in[3], in[4], in[5]),
                          emitter, results + 8 * i + 5);
}

#if MCV_WITH_LIGHT_TREE
/* cases: receiver, its normal or 0, ξ, η; results: the emitter that these choose, -1 if none, its
 * chance, the chance with which mcv_tree_ratio says that it is chosen; the same for `emitter`. */
__kernel void choose_emitter(MCV_WORLD_PARAMETERS uint emitter, __global const float *cases,
                             __global float *results) {
    MCV_MAKE_WORLD(world)
    const uint i = get_global_id(0);
    __global const float *in = cases + 8 * i;
    __global float *out = results + 8 * i;
    const mcv_vec3 receiver = mcv_vec(in[0], in[1], in[2]), normal = mcv_vec(in[3], in[4], in[5]);
    float ratio;
    const uint chosen = mcv_select_by_tree(world, receiver, normal, in[6], in[7], &ratio);
    const uint some = chosen == MCV_NONE ? 0u : chosen;
    out[0] = chosen == MCV_NONE ? -1.0f : (float)chosen;
    out[1] = ratio * world.emitters[some].probability;
    out[2] = mcv_tree_ratio(world, some, receiver, normal) * world.emitters[some].probability;
    out[3] = mcv_tree_ratio(world, emitter, receiver, normal) * world.emitters[emitter].probability;
}
#endif
