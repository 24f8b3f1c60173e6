/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How light paths choose a direction: towards bounding balls of the smooth surfaces. From a point
 * of an emitter each ball fills a cone. A path chooses one of these cones by solid angle, and a
 * direction uniform in it. A direction that lies in n of the cones has the density n/ΣΩ. Where the
 * emitter's emission cone is smaller than the ball's, or the point lies inside the ball, the
 * emission cone replaces it.
 *
 * Cones and angles are stored as sines of half-angles and chords, Ω = 4π sin²(β/2), because a
 * float32 cosine cannot tell 0.02° from 0.
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
    float squared;        /* sin²(β/2); 0: empty */
    int is_emission_cone; /* 1: the emitter's own; it holds all directions that are asked for */
} mcv_cone;

MCV_LOOP_FUNCTION int mcv_is_in_cone(mcv_cone cone, mcv_vec3 direction) {
    const mcv_vec3 chord = mcv_sub(direction, cone.axis);
    return cone.squared > 0.0f &&
           (cone.is_emission_cone || 0.25f * mcv_dot(chord, chord) <= cone.squared);
}

/* The cone of a ball if it overlaps the emission cone (otherwise it is empty), or the emission cone
 * if that is smaller. It is wider by four roundings of unit vectors: every ray that hits the ball
 * is in it. */
MCV_LOOP_FUNCTION mcv_cone mcv_cone_to(mcv_ball ball, mcv_vec3 from, mcv_cone emission) {
    mcv_cone cone;
    const mcv_vec3 way = mcv_sub(mcv_ball_centre(ball), from);
    const float distance = mcv_sqrt(mcv_dot(way, way));
    const float sine = ball.radius / distance + 9.5367432e-7f; /* 2^-20 */
    emission.is_emission_cone = 1;
    if (!(sine < 1.0f)) return emission;
    cone.axis = mcv_scale(way, 1.0f / distance);
    cone.squared = 0.5f * sine * sine / (1.0f + mcv_sqrt(mcv_fma(-sine, sine, 1.0f)));
    cone.is_emission_cone = 0;
    if (cone.squared + emission.squared < 1.0f) {
        const float apart = mcv_fma(mcv_sqrt(cone.squared), mcv_sqrt(1.0f - emission.squared),
                                    mcv_sqrt(emission.squared * (1.0f - cone.squared)));
        const mcv_vec3 chord = mcv_sub(cone.axis, emission.axis);
        if (0.25f * mcv_dot(chord, chord) > apart * apart) cone.squared = 0.0f;
    }
    return cone.squared > emission.squared ? emission : cone;
}

/* What all cones have together: their solid angle [sr], and the number of them that contain a
 * direction. */
typedef struct mcv_aiming {
    float angle;
    uint within;
} mcv_aiming;

MCV_FUNCTION mcv_aiming mcv_aim_at(MCV_CONSTANT const mcv_ball *balls, uint count, mcv_vec3 from,
                                   mcv_cone emission, mcv_vec3 direction) {
    mcv_aiming aimed;
    float sum = 0.0f;
    aimed.within = 0;
    for (uint i = 0; i < count; ++i) {
        const mcv_cone cone = mcv_cone_to(balls[i], from, emission);
        sum += cone.squared;
        aimed.within += mcv_is_in_cone(cone, direction);
    }
    aimed.angle = 4.0f * MCV_PI * sum;
    return aimed;
}

/*
 * Chooses a direction towards one of the balls; *aimed gets what mcv_aim_at says of it, *emission
 * becomes the chosen cone. xi and eta lie in [0, 1).
 */
MCV_FUNCTION mcv_vec3 mcv_aim_anywhere(MCV_CONSTANT const mcv_ball *balls, uint count,
                                       mcv_vec3 from, mcv_cone *emission, float xi, float eta,
                                       mcv_aiming *aimed) {
    mcv_cone cones[MCV_MAX_BALLS], chosen = *emission;
    float sum = 0.0f, remainder = 0.0f;
    for (uint i = 0; i < count; ++i) {
        cones[i] = mcv_cone_to(balls[i], from, *emission);
        sum += cones[i].squared;
    }
    float ahead = xi * sum;
    chosen.squared = 0.0f;
    for (uint i = 0; i < count && ahead >= 0.0f; ++i) {
        if (!(cones[i].squared > 0.0f)) continue;
        chosen = cones[i];
        remainder = ahead / cones[i].squared;
        ahead -= cones[i].squared;
    }
    /* The remainder of xi is uniform again. */
    const mcv_vec3 direction =
        mcv_from_frame(mcv_sample_cone(mcv_sqrt(chosen.squared),
                                       remainder < 0.99999994f ? remainder : 0.99999994f, eta),
                       chosen.axis);
    aimed->angle = 4.0f * MCV_PI * sum;
    aimed->within = 0;
    for (uint i = 0; i < count; ++i) aimed->within += (uint)mcv_is_in_cone(cones[i], direction);
    *emission = chosen;
    return direction;
}

#endif
