/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Laser (type "laser"): Gaussian beams along the node's -z, round or elliptical, or fans of light
 * that draw lines. It has no surface: rays leave the node's xy plane, the exit window.
 *
 * Across each axis the beam is a Gaussian Schell beam of quality M² (Siegman 1990):
 *
 *     Θ = M² λ/(π w₀)    z_R = w₀/Θ    w(z) = w₀ √(1 + (z/z_R)²)
 *
 * with the 1/e² radius w and the distance z from the waist, which lies at `workingDistance`. Its
 * Wigner density is positive: at the waist, position N(0, w₀/2) and slope N(0, Θ/2) are
 * independent. Rays drawn so have the exact second moments in every first-order optical system. At
 * a distance z, the slope given the position x is N(x z/(z² + z_R²), Θ/2 · w₀/w).
 *
 * A line is Gaussian across, in y, at the distance ρ from the node in the xz plane, the plane of
 * the fan. The fan sends the power q(φ) per angle, |φ| <= Φ/2: on a surface that faces the node
 *
 *     E = P q(φ)/ρ · √(2/π)/w(ρ - workingDistance) · exp(-2 y²/w²).
 *
 * q is 1/(2 tan(Φ/2) cos²φ), even on a plane; or 1/Φ; or ~ exp(-2(2φ/Φ)²); or the columns of an
 * image, over equal angles, each even. A line that is not straight bends by the angle
 * β = 2 tan(Φ/2) b (2φ/Φ)², which `straightness` b gives: its ends lie b times its length aside.
 * Several lines share the power evenly; their fans are turned about x.
 *
 * Only next-event estimation and light paths find it: it draws the slope from the conditional
 * density. Light paths start with a tangent of φ that is even within the fan.
 *
 *     {"type": "laser", "wavelength": "660nm", "power": 0.02, "lineThickness": "60um",
 *      "widthMeasure": "1/e2", "workingDistance": "200mm", "fanAngle": "30deg"}
 */
#ifndef MCVISI_EMITTERS_LASER_H
#define MCVISI_EMITTERS_LASER_H

#include "mcvisi/elementary.h"
#include "mcvisi/emitters/emitter.h"
#include "mcvisi/normal.h"

#define MCV_LASER_PARAMS(X) \
    X(length, wavelength, MCV_REQUIRED, 1e-7, 1e-4, "wavelength λ [m]") \
    X(spectrum, power, MCV_REQUIRED, 0, 1e30, "power P of the whole laser [W]") \
    X(number2, M2, 1, 1, 1e6, "beam quality M² in x and y, at least 1; a line has that in y") \
    X(length2, beamDiameter, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "diameter of the waist in x and y, of a beam without fan [m]") \
    X(length, lineThickness, MCV_UNSET, MCV_POSITIVE, 1e3, "thickness of the line's waist [m]") \
    X(choice, widthMeasure, 0, 0, 2, \
      "what diameter and thickness are: \"1/e2\", down to 13.5 % of the peak, or \"FWHM\", to " \
      "half of it") \
    X(length, workingDistance, 0, 0, 1e6, "distance of the waist from the node [m]") \
    X(angle, fanAngle, MCV_UNSET, MCV_POSITIVE, 2.0943951023931953, \
      "full angle Φ of the fan, which draws a line along x [rad]") \
    X(choice, fanProfile, 0, 0, 3, \
      "\"plane\": even along a line on a plane; \"angle\": even in angle; \"gaussian\": 1/e² at " \
      "the ends; \"table\": by the image") \
    X(image, image, MCV_UNSET, 0, 4294967294.0, \
      "index or name of one of the file's images, or {\"uri\": FILE.exr}: the power per angle, " \
      "column by column from -x to +x") \
    X(length, linewidth, 0, 0, 1e-6, \
      "full width at half maximum of the spectrum, which makes speckle fainter [m]") \
    X(number, straightness, 0, -0.1, 0.1, \
      "how far the line's ends lie aside in y, over its length: b") \
    X(integer, lineCount, 1, 1, 64, "number of lines or beams") \
    X(angle, interBeamAngle, 0, 0, 0.5, "angle between neighbouring ones, about x [rad]") \
    X(angle, boresightX, 0, -0.5, 0.5, "angle by which the beam misses -z towards x [rad]") \
    X(angle, boresightY, 0, -0.5, 0.5, "angle by which the beam misses -z towards y [rad]")

enum {
    MCV_LASER_PLANE,
    MCV_LASER_ANGLE,
    MCV_LASER_GAUSSIAN,
    MCV_LASER_TABLE,
    MCV_LASER_BEAM /* no fan */
};

typedef struct mcv_laser {
    float position[3];            /* of the node [m] */
    float x[3], y[3], forward[3]; /* unit; axes in the world */
    float waist[2], slope[2];     /* w₀ [m] and Θ/2, in x and y */
    float inverse_rayleigh[2];    /* 1/z_R [1/m] */
    float distance;               /* of the waist [m] */
    float edge, inverse_half_fan; /* tan(Φ/2), 2/Φ */
    float height;                 /* q at φ = 0; of a table 1/Φ times its columns */
    float bow;                    /* β at the ends */
    float first[2], step[2];      /* cosine and sine: of the first line's angle, between lines */
    uint count, profile;          /* of lines; MCV_LASER_… */
    uint columns;                 /* of the table */
    uint padding[2];
} mcv_laser;
MCV_ASSERT_SIZE(mcv_laser, 128);

/* A line's turn about x: cosine and sine. */
typedef struct mcv_laser_turn {
    float cosine, sine;
} mcv_laser_turn;

MCV_LOOP_FUNCTION mcv_laser_turn mcv_laser_first(MCV_GLOBAL const mcv_laser *laser) {
    mcv_laser_turn turn;
    turn.cosine = laser->first[0];
    turn.sine = laser->first[1];
    return turn;
}

MCV_LOOP_FUNCTION mcv_laser_turn mcv_laser_next(MCV_GLOBAL const mcv_laser *laser,
                                                mcv_laser_turn at) {
    mcv_laser_turn turn;
    turn.cosine = at.cosine * laser->step[0] - at.sine * laser->step[1];
    turn.sine = at.sine * laser->step[0] + at.cosine * laser->step[1];
    return turn;
}

/* From the world's axes to x, y and forward of a line. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_laser_to_line(MCV_GLOBAL const mcv_laser *laser, mcv_laser_turn turn,
                                             mcv_vec3 v) {
    const float x = mcv_dot(v, mcv_vec(laser->x[0], laser->x[1], laser->x[2])),
                y = mcv_dot(v, mcv_vec(laser->y[0], laser->y[1], laser->y[2])),
                z = mcv_dot(v, mcv_vec(laser->forward[0], laser->forward[1], laser->forward[2]));
    return mcv_vec(x, y * turn.cosine - z * turn.sine, y * turn.sine + z * turn.cosine);
}

/* And back. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_laser_to_world(MCV_GLOBAL const mcv_laser *laser,
                                              mcv_laser_turn turn, mcv_vec3 v) {
    const float y = v.y * turn.cosine + v.z * turn.sine, z = v.z * turn.cosine - v.y * turn.sine;
    const mcv_vec3 in_plane =
        mcv_along(mcv_scale(mcv_vec(laser->x[0], laser->x[1], laser->x[2]), v.x), y,
                  mcv_vec(laser->y[0], laser->y[1], laser->y[2]));
    return mcv_along(in_plane, z, mcv_vec(laser->forward[0], laser->forward[1], laser->forward[2]));
}

/* 1 + (z/z_R)² at a distance from the node. */
MCV_LOOP_FUNCTION float mcv_laser_growth(MCV_GLOBAL const mcv_laser *laser, int axis, float z) {
    const float from_waist = (z - laser->distance) * laser->inverse_rayleigh[axis];
    return mcv_fma(from_waist, from_waist, 1.0f);
}

/* The power per length, over the power [1/m]. */
MCV_LOOP_FUNCTION float mcv_laser_section(MCV_GLOBAL const mcv_laser *laser, int axis, float z,
                                          float x) {
    const float w_squared =
        laser->waist[axis] * laser->waist[axis] * mcv_laser_growth(laser, axis, z);
    return 0.79788456f / mcv_sqrt(w_squared) * mcv_exp_minus(2.0f * x * x / w_squared);
}

/* A slope given the position x, from a normal number. */
MCV_LOOP_FUNCTION float mcv_laser_slope(MCV_GLOBAL const mcv_laser *laser, int axis, float z,
                                        float x, float normal) {
    const float rate = laser->inverse_rayleigh[axis], growth = mcv_laser_growth(laser, axis, z);
    const float mean = x * (z - laser->distance) * rate * rate / growth;
    return mcv_fma(laser->slope[axis] / mcv_sqrt(growth), normal, mean);
}

/* The power per tangent of the fan's angle, and its bend β there; 0 beyond the fan. `table`: the
 * CDF of the columns, 2^31 = 1. */
MCV_LOOP_FUNCTION float mcv_laser_fan(MCV_GLOBAL const mcv_laser *laser,
                                      MCV_GLOBAL const uint *table, float tangent, float *bend) {
    const float at = mcv_atan2(tangent, 1.0f) * laser->inverse_half_fan; /* from -1 to 1 */
    const float by_angle = laser->height / mcv_fma(tangent, tangent, 1.0f);
    const uint column = mcv_cell(mcv_fma(0.5f, at, 0.5f), laser->columns);
    const float pmf = mcv_cdf_pmf(table, column);
    float power = by_angle;
    power = laser->profile == MCV_LASER_PLANE ? laser->height : power;
    power = laser->profile == MCV_LASER_GAUSSIAN ? by_angle * mcv_exp_minus(2.0f * at * at) : power;
    power = laser->profile == MCV_LASER_TABLE ? by_angle * pmf : power;
    *bend = laser->bow * at * at;
    return mcv_abs(tangent) <= laser->edge ? power : 0.0f;
}

/* Where a line's light goes through a point of its axes: a point of the exit window sees it in
 * this direction. */
typedef struct mcv_laser_section_at {
    float irradiance; /* over the power, across the fan's or the beam's axis [1/m²] */
    float distance;   /* ρ or z [m] */
    float bend;       /* β */
} mcv_laser_section_at;

MCV_LOOP_FUNCTION mcv_laser_section_at mcv_laser_cut(MCV_GLOBAL const mcv_laser *laser,
                                                     MCV_GLOBAL const uint *table, mcv_vec3 p) {
    mcv_laser_section_at cut;
    const int ahead = p.z > 0.0f;
    const float z = ahead ? p.z : 1.0f;
    const int is_beam = laser->profile == MCV_LASER_BEAM;
    const float radial = mcv_sqrt(mcv_fma(p.x, p.x, z * z));
    const float fan = mcv_laser_fan(laser, table, p.x / z, &cut.bend) * radial / (z * z);
    cut.distance = is_beam ? z : radial;
    cut.bend = is_beam ? 0.0f : cut.bend;
    const float across =
        mcv_laser_section(laser, 1, cut.distance, mcv_fma(-cut.bend, cut.distance, p.y));
    const float along = is_beam ? mcv_laser_section(laser, 0, z, p.x) : fan;
    cut.irradiance = ahead ? across * along : 0.0f;
    return cut;
}

/* May light come to a point, relative to the node? The beam ends where exp(-2 x²/w²) rounds to 0.
 */
MCV_LOOP_FUNCTION int mcv_laser_covers(MCV_GLOBAL const mcv_laser *laser, mcv_vec3 from_node) {
    int covers = 0;
    mcv_laser_turn turn = mcv_laser_first(laser);
    for (uint i = 0; i < laser->count; ++i) {
        const mcv_vec3 p = mcv_laser_to_line(laser, turn, from_node);
        const float z = p.z > 0.0f ? p.z : 1.0f;
        const int is_beam = laser->profile == MCV_LASER_BEAM;
        const float at = mcv_atan2(p.x, z) * laser->inverse_half_fan;
        const float distance = is_beam ? z : mcv_sqrt(mcv_fma(p.x, p.x, z * z));
        const float y = mcv_fma(is_beam ? 0.0f : -laser->bow * at * at, distance, p.y);
        const float widest[2] = {
            44.0f * laser->waist[0] * laser->waist[0] * mcv_laser_growth(laser, 0, z),
            44.0f * laser->waist[1] * laser->waist[1] * mcv_laser_growth(laser, 1, distance)};
        const int within = is_beam ? p.x * p.x <= widest[0] : mcv_abs(p.x) <= laser->edge * z;
        covers |= (p.z > 0.0f) & within & (y * y <= widest[1]);
        turn = mcv_laser_next(laser, turn);
    }
    return covers;
}

/* What next-event estimation finds at a point. */
typedef struct mcv_laser_sight {
    mcv_vec3 exit;    /* where the ray leaves the window, relative to the node */
    float irradiance; /* over the power, across the ray [1/m²]; 0: nothing comes */
} mcv_laser_sight;

/* One ray of those that go through a point, relative to the node: of a line chosen by what it
 * brings, with a slope by its conditional density. */
MCV_LOOP_FUNCTION mcv_laser_sight mcv_laser_look(MCV_GLOBAL const mcv_laser *laser,
                                                 MCV_GLOBAL const uint *table, mcv_vec3 from_node,
                                                 float xi, float eta) {
    mcv_laser_sight sight;
    float all = 0.0f, before = 0.0f, rest = eta, normal[2];
    mcv_laser_turn turn = mcv_laser_first(laser), chosen = turn;
    for (uint i = 0; i < laser->count; ++i) {
        all += mcv_laser_cut(laser, table, mcv_laser_to_line(laser, turn, from_node)).irradiance;
        turn = mcv_laser_next(laser, turn);
    }
    turn = mcv_laser_first(laser);
    for (uint i = 0; i < laser->count; ++i) {
        const float one =
            mcv_laser_cut(laser, table, mcv_laser_to_line(laser, turn, from_node)).irradiance;
        const float ahead = mcv_fma(eta, all, -before);
        const int takes = (one > 0.0f) & (ahead >= 0.0f);
        chosen.cosine = takes ? turn.cosine : chosen.cosine;
        chosen.sine = takes ? turn.sine : chosen.sine;
        rest = takes ? ahead / one : rest;
        before += one;
        turn = mcv_laser_next(laser, turn);
    }
    const mcv_vec3 p = mcv_laser_to_line(laser, chosen, from_node);
    const mcv_laser_section_at cut = mcv_laser_cut(laser, table, p);
    const int is_beam = laser->profile == MCV_LASER_BEAM;
    mcv_normal_pair(xi, rest < 1.0f ? rest : 1.0f, normal);
    const float y = mcv_fma(-cut.bend, cut.distance, p.y);
    const float up = mcv_laser_slope(laser, 1, cut.distance, y, normal[1]) + cut.bend;
    const float aside = is_beam ? mcv_laser_slope(laser, 0, cut.distance, p.x, normal[0]) : 0.0f;
    const float squared = mcv_fma(up, up, mcv_fma(aside, aside, 1.0f));
    const mcv_vec3 exit = mcv_vec(is_beam ? mcv_fma(-aside, cut.distance, p.x) : 0.0f,
                                  mcv_fma(-up, cut.distance, p.y), 0.0f);
    sight.exit = mcv_laser_to_world(laser, chosen, exit);
    sight.irradiance = all * mcv_sqrt(squared) / (float)laser->count;
    return sight;
}

/* How a light path leaves: origin, relative to the node, and direction (unit); returns its power,
 * relative to the laser's, over its density. Four numbers in [0, 1). */
MCV_LOOP_FUNCTION float mcv_laser_leave(MCV_GLOBAL const mcv_laser *laser,
                                        MCV_GLOBAL const uint *table, const float xi[4],
                                        mcv_vec3 *origin, mcv_vec3 *direction) {
    float across[2], along[2], bend;
    const float lines = xi[3] * (float)laser->count;
    const uint line = mcv_cell(xi[3], laser->count);
    mcv_laser_turn turn = mcv_laser_first(laser);
    for (uint i = 0; i < line; ++i) turn = mcv_laser_next(laser, turn);
    const int is_beam = laser->profile == MCV_LASER_BEAM;
    const float tangent = laser->edge * mcv_fma(2.0f, xi[2], -1.0f);
    const float power = 2.0f * laser->edge * mcv_laser_fan(laser, table, tangent, &bend);
    const float length = mcv_sqrt(mcv_fma(tangent, tangent, 1.0f));
    mcv_normal_pair(xi[0], xi[1], across);
    mcv_normal_pair(xi[2], lines - (float)line, along);
    const float s_y = laser->slope[1] * across[1], s_x = laser->slope[0] * along[1];
    const float y = mcv_fma(-s_y, laser->distance, 0.5f * laser->waist[1] * across[0]),
                x = mcv_fma(-s_x, laser->distance, 0.5f * laser->waist[0] * along[0]);
    *origin = mcv_laser_to_world(laser, turn, mcv_vec(is_beam ? x : 0.0f, y, 0.0f));
    *direction = mcv_normalize(
        mcv_laser_to_world(laser, turn,
                           mcv_vec(is_beam ? s_x : tangent / length, is_beam ? s_y : s_y + bend,
                                   is_beam ? 1.0f : 1.0f / length)));
    return is_beam ? 1.0f : power;
}

#endif
