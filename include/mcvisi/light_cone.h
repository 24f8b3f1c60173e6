/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where light paths aim: at balls around smooth surfaces. They leave a place of a light for one of
 * the cones that the balls fill from there, chosen by solid angle, in a direction uniform in it:
 * one that lies in n of the cones has the density n/ΣΩ. Where the light shines into a smaller cone,
 * or from within a ball, its own cone takes the ball's place.
 *
 * Cones and angles are by half-angle sines and chords, Ω = 4π sin²(β/2): a float32 cosine cannot
 * tell 0.02° from 0.
 */
#ifndef MCVISI_LIGHT_CONE_H
#define MCVISI_LIGHT_CONE_H

#include "mcvisi/sampling.h"
#include "mcvisi/tables.h"
#include "mcvisi/vector.h"

MCV_LOOP_FUNCTION mcv_vec3 mcv_ball_centre(mcv_ball ball) {
    return mcv_vec(ball.centre[0], ball.centre[1], ball.centre[2]);
}

typedef struct mcv_cone {
    mcv_vec3 axis;
    float squared; /* sin²(β/2); 0: nothing */
    int own;       /* the light's own: that a direction is in it need not be asked */
} mcv_cone;

MCV_LOOP_FUNCTION int mcv_is_in_cone(mcv_cone cone, mcv_vec3 direction) {
    const mcv_vec3 chord = mcv_sub(direction, cone.axis);
    return cone.squared > 0.0f && (cone.own || 0.25f * mcv_dot(chord, chord) <= cone.squared);
}

/* The part of the light's own cone that a ball fills, or a larger one. Four roundings of unit
 * vectors more: whatever meets the ball is in it.
 */
MCV_LOOP_FUNCTION mcv_cone mcv_cone_to(mcv_ball ball, mcv_vec3 from, mcv_cone own) {
    mcv_cone cone;
    const mcv_vec3 way = mcv_sub(mcv_ball_centre(ball), from);
    const float distance = mcv_sqrt(mcv_dot(way, way));
    const float sine = ball.radius / distance + 9.5367432e-7f; /* 2^-20 */
    own.own = 1;
    if (!(sine < 1.0f)) return own;
    cone.axis = mcv_scale(way, 1.0f / distance);
    cone.squared = 0.5f * sine * sine / (1.0f + mcv_sqrt(mcv_fma(-sine, sine, 1.0f)));
    cone.own = 0;
    if (cone.squared + own.squared < 1.0f) {
        const float apart = mcv_fma(mcv_sqrt(cone.squared), mcv_sqrt(1.0f - own.squared),
                                    mcv_sqrt(own.squared * (1.0f - cone.squared)));
        const mcv_vec3 chord = mcv_sub(cone.axis, own.axis);
        if (0.25f * mcv_dot(chord, chord) > apart * apart) cone.squared = 0.0f;
    }
    return cone.squared > own.squared ? own : cone;
}

/* What is known of all cones: their solid angle [sr], and how many of them hold a direction. */
typedef struct mcv_aiming {
    float angle;
    uint within;
} mcv_aiming;

MCV_FUNCTION mcv_aiming mcv_aim_at(MCV_CONSTANT const mcv_ball *balls, uint count, mcv_vec3 from,
                                   mcv_cone own, mcv_vec3 direction) {
    mcv_aiming aimed;
    float sum = 0.0f;
    aimed.within = 0;
    for (uint i = 0; i < count; ++i) {
        const mcv_cone cone = mcv_cone_to(balls[i], from, own);
        sum += cone.squared;
        aimed.within += mcv_is_in_cone(cone, direction);
    }
    aimed.angle = 4.0f * MCV_PI * sum;
    return aimed;
}

/* The cone that a number has chosen of those asked so far: by its share of their sum. */
typedef struct mcv_aim {
    mcv_cone cone;
    float ahead;     /* what the number is above the sum of the cones asked, of the squared sines */
    float remainder; /* of the number within the cone: as good as a new one */
} mcv_aim;

MCV_LOOP_FUNCTION mcv_aim mcv_begin_aim(mcv_cone own, float ahead) {
    mcv_aim aim;
    aim.cone = own;
    aim.cone.squared = 0.0f;
    aim.ahead = ahead;
    aim.remainder = 0.0f;
    return aim;
}

MCV_LOOP_FUNCTION mcv_aim mcv_ask_cone(mcv_aim aim, mcv_cone cone) {
    const int takes = (aim.ahead >= 0.0f) & (cone.squared > 0.0f);
    const float remainder = aim.ahead / cone.squared;
    aim.cone.axis = mcv_choose(takes, cone.axis, aim.cone.axis);
    aim.cone.squared = takes ? cone.squared : aim.cone.squared;
    aim.cone.own = takes ? cone.own : aim.cone.own;
    aim.remainder = takes ? remainder : aim.remainder;
    aim.ahead -= takes ? cone.squared : 0.0f;
    return aim;
}

/* A direction in the cone that was chosen. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_aim_direction(mcv_aim aim, float eta) {
    const float xi = aim.remainder < 0.99999994f ? aim.remainder : 0.99999994f;
    return mcv_from_frame(mcv_sample_cone(mcv_sqrt(aim.cone.squared), xi, eta), aim.cone.axis);
}

/*
 * A direction to one of the balls, and what is known of it (mcv_aim_at); *own becomes the cone that
 * was chosen. xi, eta: in [0, 1).
 */
MCV_FUNCTION mcv_vec3 mcv_aim_anywhere(MCV_CONSTANT const mcv_ball *balls, uint count,
                                       mcv_vec3 from, mcv_cone *own, float xi, float eta,
                                       mcv_aiming *aimed) {
    float sum = 0.0f;
    for (uint i = 0; i < count; ++i) sum += mcv_cone_to(balls[i], from, *own).squared;
    mcv_aim aim = mcv_begin_aim(*own, xi * sum);
    for (uint i = 0; i < count; ++i) aim = mcv_ask_cone(aim, mcv_cone_to(balls[i], from, *own));
    const mcv_vec3 direction = mcv_aim_direction(aim, eta);
    *aimed = mcv_aim_at(balls, count, from, *own, direction);
    *own = aim.cone;
    return direction;
}

#endif
