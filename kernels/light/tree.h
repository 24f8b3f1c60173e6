/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Choosing among many emitters by a tree of clusters (host/device/light_tree.c), from its root: at
 * each node one of two children, by mcv_cluster_importance.
 * Of all choices MCV_DEFENSIVE_PROBABILITY go by power at large.
 */
#ifndef MCVISI_KERNELS_TREE_H
#define MCVISI_KERNELS_TREE_H

#include "light/discrete.h"
#include "mcvisi/light_tree.h"
#include "world.h"

#if MCV_WITH_LIGHT_TREE
/* A way from the root down: by a number, or to an emitter that is known. */
typedef struct mcv_light_walk {
    uint node;
    uint trail;  /* of the emitter that is known: bit i is the child at level i */
    int follows; /* 1: by the trail. A flag of its own: all bits set, MCV_NONE, is a trail, too */
    float xi;
    float chance; /* of all choices so far */
} mcv_light_walk;

MCV_LOOP_FUNCTION mcv_light_walk mcv_start_walk(int follows, uint trail, float xi) {
    mcv_light_walk walk;
    walk.node = 0u;
    walk.trail = trail;
    walk.follows = follows;
    walk.xi = xi;
    walk.chance = 1.0f;
    return walk;
}

/* One node further, unless it has come to an emitter. */
MCV_LOOP_FUNCTION mcv_light_walk mcv_walk_on(mcv_world world, mcv_light_walk walk,
                                             mcv_vec3 receiver, mcv_vec3 normal) {
    const uint child = world.light_tree[walk.node].child;
    const float near = mcv_cluster_importance(world.light_tree + child, receiver, normal),
                far = mcv_cluster_importance(world.light_tree + child + 1u, receiver, normal);
    const float both = near + far;
    const float per_both = both > 0.0f ? 1.0f / both : 0.0f;
    const float chance_near = near * per_both, chance_far = far * per_both;
    const int goes_far =
        walk.follows ? (int)(walk.trail & 1u) : (walk.xi >= chance_near) & (chance_far > 0.0f);
    const float chance = goes_far ? chance_far : chance_near;
    const float before = goes_far ? walk.xi - chance_near : walk.xi;
    const float rest = chance > 0.0f ? before / chance : 0.0f;
    const int on = child != 0u;
    walk.trail = on ? walk.trail >> 1 : walk.trail;
    walk.xi = !on ? walk.xi : rest < 0.99999994f ? rest : 0.99999994f;
    walk.chance *= on ? chance : 1.0f;
    walk.node = on ? child + (uint)goes_far : walk.node;
    return walk;
}

/* The walk for the number xi; `other` as of mcv_cdf_bits. */
MCV_FUNCTION mcv_light_walk mcv_begin_walk(mcv_world world, float xi, float other) {
    const float by_power = (xi - MCV_INFORMED_PROBABILITY) * (1.0f / MCV_DEFENSIVE_PROBABILITY);
    if (!(by_power >= 0.0f)) return mcv_start_walk(0, 0u, xi * (1.0f / MCV_INFORMED_PROBABILITY));
    const uint emitter = mcv_search_cdf(world.emitter_cdf, world.frame->emitter_count,
                                        mcv_cdf_bits(by_power, other));
    return mcv_start_walk(1, world.emitters[emitter].trail, 0.0f);
}

/* The emitter to which a walk has come, or MCV_NONE: nothing there reaches the receiver. */
MCV_LOOP_FUNCTION uint mcv_emitter_of(mcv_world world, mcv_light_walk walk) {
    const uint emitter = world.light_tree[walk.node].emitter;
    return (walk.follows | (walk.chance > 0.0f)) ? emitter : MCV_NONE;
}

/* How much more often than at large, where its chance is e->probability, an emitter is chosen to
 * which such a walk leads. */
MCV_LOOP_FUNCTION float mcv_walk_ratio(mcv_world world, uint emitter, mcv_light_walk walk) {
    const float probability = world.emitters[emitter].probability;
    return mcv_fma(MCV_INFORMED_PROBABILITY, walk.chance, MCV_DEFENSIVE_PROBABILITY * probability) /
           probability;
}

/* The same for an emitter that a receiver may have chosen. */
MCV_FUNCTION float mcv_tree_ratio(mcv_world world, uint emitter, mcv_vec3 receiver,
                                  mcv_vec3 normal) {
    mcv_light_walk walk = mcv_start_walk(1, world.emitters[emitter].trail, 0.0f);
    for (uint level = 0; level < world.frame->light_tree_depth; ++level)
        walk = mcv_walk_on(world, walk, receiver, normal);
    return mcv_walk_ratio(world, emitter, walk);
}

/* The emitter that a pair chooses; *ratio as of mcv_tree_ratio. */
MCV_FUNCTION uint mcv_select_by_tree(mcv_world world, mcv_vec3 receiver, mcv_vec3 normal, float xi,
                                     float other, float *ratio) {
    mcv_light_walk walk = mcv_begin_walk(world, xi, other);
    for (uint level = 0; level < world.frame->light_tree_depth; ++level)
        walk = mcv_walk_on(world, walk, receiver, normal);
    const uint emitter = mcv_emitter_of(world, walk);
    *ratio = mcv_walk_ratio(world, emitter == MCV_NONE ? 0u : emitter, walk);
    return emitter;
}
#endif

#endif
