/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Time: sensors and parts that move while rows are exposed. MCVISI_motion on a node gives the
 * motion; the node stands where the file says at the time 0. A point p of it is at
 *
 *     c + v t + R(ω t) (p - c)          R about the axis a through the centre c
 *
 * Each path has one time. Parts that move, all in one way, have a hierarchy of their own, for the
 * time 0: rays are moved back to it, and what they hit is moved on. So nothing is built anew for a
 * time. Lights stand still.
 *
 * Row r of what is read out is exposed from t_r on, for exposureTime:
 *
 *     global   t_r = 0
 *     rolling  t_r = r lineTime
 *     line     t_r = r lineTime + e_r; each row of the image is the film's row at the principal
 * point. With stages N > 1 (TDI) a row is the mean over N rows of the film, j - (N - 1)/2 rows
 * farther up and line times later
 *
 * An encoder begins lines, by e_r too late: encoderJitter times a standard normal number of the
 * line, and encoderRipple sin(2π r/encoderPeriod). The normal number is √(-2 ln u) cos(2π u'), with
 * u and u' of mcv_line_draw: the errors are those of one run of the machine, encoderSeed chooses
 * another.
 *
 * A strobe lights from strobeDelay on for strobeTime: a row sees what of this lies in its exposure,
 * and gets that share of the light.
 */
#ifndef MCVISI_MOTION_H
#define MCVISI_MOTION_H

#include "mcvisi/elementary.h"
#include "mcvisi/offset.h"
#include "mcvisi/sensors/sensor.h"

enum { MCV_SHUTTER_GLOBAL, MCV_SHUTTER_ROLLING, MCV_SHUTTER_LINE };

typedef struct mcv_rigid_motion {
    float velocity[3]; /* [m/s] */
    float axis[3];     /* unit */
    float centre[3];   /* [m] */
    float turns_per_second;
} mcv_rigid_motion;

/* A sensor's is in the optical frame, which is left-handed: turns have the opposite sign there. */
typedef struct mcv_motion {
    mcv_rigid_motion sensor;
    float exposure, line_time;      /* [s] */
    float strobe_begin, strobe_end; /* equal: no strobe [s] */
    uint shutter, stages;
    float jitter, ripple; /* of the encoder [s] */
    float ripples_per_line;
    uint seed; /* of the jitter */
} mcv_motion;
MCV_ASSERT_SIZE(mcv_motion, 80);

/* Number `which`, 0 or 1, of a line: in (0, 1], the same in each sample of the line. */
MCV_FUNCTION float mcv_line_draw(uint seed, uint line, uint which) {
    return (float)((mcv_hash_2(2u * line + which, seed) >> 8) + 1u) * 0x1p-24f;
}

#if !MCV_ON_DEVICE || MCV_WITH_MOTION

/* A moment of a row's exposure. */
typedef struct mcv_moment {
    float time, weight;
    float stage; /* rows of the film above the principal point */
} mcv_moment;

/* How much too late the encoder begins a line, whose place of the image is `row` [s]. */
MCV_LOOP_FUNCTION float mcv_line_error(MCV_CONSTANT const mcv_motion *m, uint line, float row) {
    const float u = mcv_line_draw(m->seed, line, 0u);
    const float ripples = row * m->ripples_per_line;
    float sine, cosine, normal_sine, normal_cosine;
    mcv_sin_cos_turn(ripples - mcv_floor(ripples), &sine, &cosine);
    mcv_sin_cos_turn(mcv_line_draw(m->seed, line, 1u), &normal_sine, &normal_cosine);
    const float normal = mcv_sqrt(2.0f * mcv_log_1_plus((1.0f - u) / u)) * normal_cosine;
    return mcv_fma(m->jitter, normal, m->ripple * sine);
}

MCV_LOOP_FUNCTION mcv_moment mcv_expose(MCV_CONSTANT const mcv_motion *m, uint row, float xi,
                                        float eta) {
    mcv_moment moment;
    const uint stages = m->shutter == MCV_SHUTTER_LINE ? m->stages : 1u;
    const uint stage = mcv_cell(eta, stages);
    moment.stage = (float)stage - 0.5f * (float)(stages - 1u);
    const float rows = m->shutter == MCV_SHUTTER_GLOBAL ? 0.0f : (float)row + moment.stage;
    float from = rows * m->line_time;
    if (m->shutter == MCV_SHUTTER_LINE) from += mcv_line_error(m, row + stage, rows);
    float to = from + m->exposure;
    moment.weight = 1.0f;
    if (m->strobe_end > m->strobe_begin) {
        from = from > m->strobe_begin ? from : m->strobe_begin;
        to = to < m->strobe_end ? to : m->strobe_end;
        moment.weight = to > from ? (to - from) / (m->strobe_end - m->strobe_begin) : 0.0f;
    }
    moment.time = mcv_fma(xi, to - from, from);
    return moment;
}

/* The same place of the film's row at the principal point, whose coordinate is `centre`. */
MCV_LOOP_FUNCTION mcv_film_sample mcv_on_line(mcv_film_sample film, mcv_centre centre,
                                              float stage) {
    mcv_film_sample line = film;
    line.row = centre.halves > 0 ? (uint)centre.halves / 2u : 0u;
    line.y = film.y - 0.5f - stage + centre.low + 0.5f * (float)(centre.halves - 2 * (int)line.row);
    return line;
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_turned(mcv_vec3 axis, float sine, float cosine, mcv_vec3 p) {
    const mcv_vec3 across =
        mcv_vec(mcv_fma(axis.y, p.z, -axis.z * p.y), mcv_fma(axis.z, p.x, -axis.x * p.z),
                mcv_fma(axis.x, p.y, -axis.y * p.x));
    const float along = mcv_dot(axis, p) * (1.0f - cosine);
    return mcv_along(mcv_along(mcv_scale(p, cosine), sine, across), along, axis);
}

/* How far a motion has come. */
typedef struct mcv_pose {
    float time, sine, cosine;
} mcv_pose;

MCV_LOOP_FUNCTION mcv_pose mcv_pose_at(MCV_CONSTANT const mcv_rigid_motion *m, float time) {
    const float turns = m->turns_per_second * time;
    mcv_pose pose;
    pose.time = time;
    mcv_sin_cos_turn(turns - mcv_floor(turns), &pose.sine, &pose.cosine);
    return pose;
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_moved_direction(MCV_CONSTANT const mcv_rigid_motion *m,
                                               mcv_pose pose, mcv_vec3 direction) {
    return mcv_turned(mcv_vec(m->axis[0], m->axis[1], m->axis[2]), pose.sine, pose.cosine,
                      direction);
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_moved_point(MCV_CONSTANT const mcv_rigid_motion *m, mcv_pose pose,
                                           mcv_vec3 point) {
    const mcv_vec3 velocity = mcv_vec(m->velocity[0], m->velocity[1], m->velocity[2]);
    const mcv_vec3 centre = mcv_vec(m->centre[0], m->centre[1], m->centre[2]);
    return mcv_along(mcv_add(centre, mcv_moved_direction(m, pose, mcv_sub(point, centre))),
                     pose.time, velocity);
}

/* The ray of a sensor that has moved for a time; the direction's z is no longer 1. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_moved(MCV_CONSTANT const mcv_rigid_motion *m,
                                           mcv_sensor_ray ray, float time) {
    const mcv_pose pose = mcv_pose_at(m, time);
    mcv_sensor_ray moved = ray;
    moved.origin = mcv_moved_point(m, pose, ray.origin);
    moved.direction = mcv_moved_direction(m, pose, ray.direction);
    return moved;
}
#endif

#if !MCV_ON_DEVICE || MCV_WITH_MOVING
/* Back: where a direction and a point have been at the time 0. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_direction_at_rest(MCV_CONSTANT const mcv_rigid_motion *m,
                                                 mcv_pose pose, mcv_vec3 direction) {
    pose.sine = -pose.sine;
    return mcv_moved_direction(m, pose, direction);
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_point_at_rest(MCV_CONSTANT const mcv_rigid_motion *m, mcv_pose pose,
                                             mcv_vec3 point) {
    const mcv_vec3 velocity = mcv_vec(m->velocity[0], m->velocity[1], m->velocity[2]);
    const mcv_vec3 centre = mcv_vec(m->centre[0], m->centre[1], m->centre[2]);
    return mcv_add(centre, mcv_direction_at_rest(
                               m, pose, mcv_along(mcv_sub(point, centre), -pose.time, velocity)));
}

MCV_LOOP_FUNCTION float mcv_sum_of_sizes(mcv_vec3 v) {
    return mcv_abs(v.x) + mcv_abs(v.y) + mcv_abs(v.z);
}

/*
 * Bounds how far off rounding puts a point that has moved to p, and a ray from there that is moved
 * back. With u = 2^-24, the two sums of each way err by u of p, p - c and q = p - c - v t, where c
 * is the centre; a turn errs by 8 u of |q|, sine and cosine by 2 u of it.
 */
MCV_LOOP_FUNCTION float mcv_moving_error(MCV_CONSTANT const mcv_rigid_motion *m, mcv_pose pose,
                                         mcv_vec3 p) {
    const mcv_vec3 velocity = mcv_vec(m->velocity[0], m->velocity[1], m->velocity[2]);
    const mcv_vec3 from_centre = mcv_sub(p, mcv_vec(m->centre[0], m->centre[1], m->centre[2]));
    const mcv_vec3 arm = mcv_along(from_centre, -pose.time, velocity);
    const float turned = m->turns_per_second != 0.0f ? mcv_sum_of_sizes(arm) : 0.0f;
    return MCV_GAMMA(4) *
               (mcv_sum_of_sizes(p) + mcv_sum_of_sizes(from_centre) + mcv_sum_of_sizes(arm)) +
           MCV_GAMMA(20) * turned;
}
#endif

#endif
