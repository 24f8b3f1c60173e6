/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a cluster of emitters may bring to a receiver: its power, thinned out by its distance as in
 * kernels/light/selection.h, times the cosines to the receiver's normal and to the emitters'
 * normals, both for the direction within the cluster for which they are largest (Conty Estevez and
 * Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, Proc. ACM CGIT 1(2),
 * 2018; cosines of differences as in Pharr, Jakob and Humphreys, Physically Based Rendering, 4th
 * ed. 2023, 12.6.3).
 */
#ifndef MCVISI_LIGHT_TREE_H
#define MCVISI_LIGHT_TREE_H

#include "mcvisi/tables.h"
#include "mcvisi/vector.h"

/* The sine of an angle of 0 to 180°. */
MCV_LOOP_FUNCTION float mcv_sine_of(float cosine) {
    const float squared = 1.0f - cosine * cosine;
    return squared > 0.0f ? mcv_sqrt(squared) : 0.0f;
}

/* cos(max(0, a - b)). */
MCV_LOOP_FUNCTION float mcv_cosine_beyond(float cosine_a, float sine_a, float cosine_b,
                                          float sine_b) {
    const float apart = mcv_fma(cosine_a, cosine_b, sine_a * sine_b);
    return cosine_a >= cosine_b ? 1.0f : apart;
}

/* An upper bound up to a factor, where the power is spread as evenly as at its narrowest. `normal`:
 * of the receiver's one side that spreads light, 0 if both do. */
MCV_LOOP_FUNCTION float mcv_cluster_importance(MCV_GLOBAL const mcv_light_node *node,
                                               mcv_vec3 receiver, mcv_vec3 normal) {
    const mcv_vec3 way =
        mcv_sub(mcv_vec(node->centre[0], node->centre[1], node->centre[2]), receiver);
    const mcv_vec3 axis = mcv_vec(node->axis[0], node->axis[1], node->axis[2]);
    const float squared = mcv_dot(way, way), size = node->radius * node->radius;
    const int within = squared <= size, nowhere = node->radius < 0.0f,
              two_sided = mcv_dot(normal, normal) < 0.5f;
    const float per_distance = 1.0f / mcv_sqrt(within ? 1.0f : squared);
    /* The sphere, seen from the receiver. */
    const float sine = within ? 1.0f : node->radius * per_distance, cosine = mcv_sine_of(sine);
    const float to_axis = -mcv_dot(axis, way) * per_distance, beside = mcv_sine_of(to_axis);
    const int in_cone = to_axis >= node->cosine;
    const float turn = mcv_fma(beside, node->cosine, -to_axis * node->sine);
    const float sent =
        mcv_cosine_beyond(mcv_cosine_beyond(to_axis, beside, node->cosine, node->sine),
                          in_cone ? 0.0f : turn, cosine, sine);
    const float to_normal = mcv_dot(normal, way) * per_distance;
    const float received = mcv_cosine_beyond(to_normal, mcv_sine_of(to_normal), cosine, sine);
    const int lit = (sent > node->widest) & (two_sided | (received > 0.0f));
    const float cosines = sent * (two_sided ? 1.0f : received);
    const float width = mcv_fma(node->widening, within ? size : squared, node->narrowest);
    const float importance = node->power / width;
    return within | nowhere ? importance : lit ? importance * cosines : 0.0f;
}

#endif
