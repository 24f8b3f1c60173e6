/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage, once per sensor: finds for each pixel which camera rays run into the narrow cone of a
 * parallel emitter, directly or through smooth surfaces. Of the angles q between emitter and ray
 * (sines, about the emitter's axis) first-order optics says how they change with the point p of the
 * pupil and the place s in the pixel: q = q0 + A (p - p0) + B s. Newton's method finds the centre,
 * q = 0; the cone |q| <= sin β is an ellipse about it. Only how fast an image converges depends on
 * it, not what it shows.
 */
#ifndef MCVISI_KERNELS_GUIDE_PUPIL_H
#define MCVISI_KERNELS_GUIDE_PUPIL_H

#include "traverse/closest.h"
#include "bsdf/bsdf.h"
#include "path/sensor_ray.h"

#if MCV_WITH_PUPIL_GUIDE
/* Rays are compared this far apart in the pupil, in its radii: wide against rounding, and facets of
 * a lens; narrow against aberrations. */
#define MCV_GUIDE_STEP 0.0625f
/* The ellipse is this much larger than to first order. */
#define MCV_GUIDE_MARGIN 1.25f

/* A camera ray that ends on a parallel emitter's front. */
typedef struct mcv_arrival {
    float q_x, q_y;
    uint emitter; /* MCV_NONE: it ends elsewhere */
} mcv_arrival;

/* Follows a camera ray, always refracted where that is possible. */
static mcv_arrival mcv_follow(mcv_world world, mcv_film_sample film, float p_x, float p_y) {
    const mcv_ray begun =
        mcv_place_sensor_ray(world.frame, mcv_sensor_through(world.sensor, film, p_x, p_y));
    mcv_vec3 origin = begun.origin;
    mcv_vec3 direction = begun.direction;
    uint media = world.frame->initial_media;
    uint origin_surface = MCV_NONE;
    mcv_arrival arrival;
    arrival.q_x = arrival.q_y = 0.0f;
    arrival.emitter = MCV_NONE;
    for (uint depth = 0; depth < world.frame->depth; ++depth) {
        uint unmatched = 0;
        const mcv_hit hit = mcv_closest(world, origin, direction, origin_surface);
        if (hit.primitive == MCV_NONE) return arrival;
        const mcv_interaction interaction = mcv_hit_interaction(world, origin, direction, hit);
        const uint emitter = world.instances[interaction.surface.instance].emitter;
        if (emitter != MCV_NONE) {
            __global const mcv_device_emitter *e = world.emitters + emitter;
            if (interaction.back_face || e->type != MCV_EMITTER_PARALLEL ||
                !e->parallel.from_receiver)
                return arrival;
            mcv_vec3 x, y;
            mcv_basis(mcv_vec_at(e->parallel.axis), &x, &y);
            arrival.q_x = mcv_dot(direction, x);
            arrival.q_y = mcv_dot(direction, y);
            arrival.emitter = emitter;
            return arrival;
        }
        const mcv_scattering on = mcv_scatter_through(world, interaction, media, &unmatched);
        if (on.event == MCV_EVENT_NON_SPECULAR) return arrival;
        origin = mcv_onward_origin(interaction, on.direction);
        direction = on.direction;
        origin_surface = mcv_origin_surface_of(world, interaction, direction);
        media = on.media;
    }
    return arrival;
}

/* How the angles change from the one ray to the other, per `step`. 0 if they end on different
 * emitters. */
static int mcv_angle_change(mcv_arrival from, mcv_arrival to, float step, float *change_x,
                            float *change_y) {
    *change_x = (to.q_x - from.q_x) / step;
    *change_y = (to.q_y - from.q_y) / step;
    return to.emitter == from.emitter;
}

/* Where q = 0 lies to first order, and how far the pupil's points change q. */
typedef struct mcv_pupil_optics {
    mcv_arrival at;               /* the ray through … */
    float p_x, p_y;               /* … this point */
    float c_x, c_y;               /* centre */
    float i_xx, i_xy, i_yx, i_yy; /* inverse of A */
} mcv_pupil_optics;

/* The centre and A from the neighbours of the point p; 0 where there are none. */
static int mcv_find_pupil_centre(mcv_world world, mcv_film_sample film, mcv_pupil_optics *o) {
    /* Towards the middle of the pupil: the neighbours lie in it, too. */
    const float step_x = o->p_x > 0.0f ? -MCV_GUIDE_STEP : MCV_GUIDE_STEP;
    const float step_y = o->p_y > 0.0f ? -MCV_GUIDE_STEP : MCV_GUIDE_STEP;
    float a_xx, a_xy, a_yx, a_yy;
    if (!mcv_angle_change(o->at, mcv_follow(world, film, o->p_x + step_x, o->p_y), step_x, &a_xx,
                          &a_yx) ||
        !mcv_angle_change(o->at, mcv_follow(world, film, o->p_x, o->p_y + step_y), step_y, &a_xy,
                          &a_yy))
        return 0;
    const float determinant = mcv_difference_of_products(a_xx, a_yy, a_xy, a_yx);
    o->i_xx = a_yy / determinant;
    o->i_xy = -a_xy / determinant;
    o->i_yx = -a_yx / determinant;
    o->i_yy = a_xx / determinant;
    o->c_x = o->p_x - mcv_fma(o->i_xx, o->at.q_x, o->i_xy * o->at.q_y);
    o->c_y = o->p_y - mcv_fma(o->i_yx, o->at.q_x, o->i_yy * o->at.q_y);
    return 1;
}

/* By Newton's method from the point p; 0 if no first-order optics is found. */
static int mcv_find_pupil_optics(mcv_world world, mcv_film_sample film, mcv_pupil_optics *o) {
    int found = 0;
    for (int turn = 0; turn < 4 && o->at.emitter != MCV_NONE; ++turn) {
        if (!mcv_find_pupil_centre(world, film, o)) break;
        const float distance = mcv_sqrt(mcv_fma(o->c_x, o->c_x, o->c_y * o->c_y));
        /* Rays that leave all points of the pupil in parallel have no centre. */
        if (!(distance < INFINITY)) break;
        found = 1;
        const float onto = distance > 1.0f ? 1.0f / distance : 1.0f;
        const float p_x = o->c_x * onto, p_y = o->c_y * onto;
        const float moved = mcv_abs(p_x - o->p_x) + mcv_abs(p_y - o->p_y);
        const mcv_arrival next = mcv_follow(world, film, p_x, p_y);
        if (next.emitter != o->at.emitter) break;
        o->p_x = p_x;
        o->p_y = p_y;
        o->at = next;
        if (moved < MCV_GUIDE_STEP) break;
    }
    return found;
}

/* The part of the pupil that first-order optics maps into the emitter's cone. */
static void mcv_write_guide(mcv_world world, mcv_film_sample film, mcv_pupil_optics o,
                            __global mcv_device_pupil_guide *guide) {
    __global const mcv_parallel *cone = &world.emitters[o.at.emitter].parallel;
    const float sine =
        2.0f * cone->sin_half * mcv_sqrt(mcv_fma(-cone->sin_half, cone->sin_half, 1.0f));
    const float size = MCV_GUIDE_MARGIN * sine;
    mcv_film_sample across = film;
    mcv_film_sample down = film;
    float b_xx, b_xy, b_yx, b_yy;
    across.x = 1.0f;
    down.y = 1.0f;
    if (!mcv_angle_change(o.at, mcv_follow(world, across, o.p_x, o.p_y), 0.5f, &b_xx, &b_yx))
        b_xx = b_yx = 0.0f;
    if (!mcv_angle_change(o.at, mcv_follow(world, down, o.p_x, o.p_y), 0.5f, &b_xy, &b_yy))
        b_xy = b_yy = 0.0f;
    guide->centre[0] = o.c_x;
    guide->centre[1] = o.c_y;
    guide->shift[0] = -mcv_fma(o.i_xx, b_xx, o.i_xy * b_yx);
    guide->shift[1] = -mcv_fma(o.i_xx, b_xy, o.i_xy * b_yy);
    guide->shift[2] = -mcv_fma(o.i_yx, b_xx, o.i_yy * b_yx);
    guide->shift[3] = -mcv_fma(o.i_yx, b_xy, o.i_yy * b_yy);
    guide->spread[0] = size * o.i_xx;
    guide->spread[1] = size * o.i_xy;
    guide->spread[2] = size * o.i_yx;
    guide->spread[3] = size * o.i_yy;
    const float area = mcv_abs(mcv_difference_of_products(guide->spread[0], guide->spread[3],
                                                          guide->spread[1], guide->spread[2]));
    const float distance =
        mcv_sqrt(mcv_fma(o.c_x, o.c_x, o.c_y * o.c_y)) -
        (mcv_abs(guide->spread[0]) + mcv_abs(guide->spread[1]) + mcv_abs(guide->spread[2]) +
         mcv_abs(guide->spread[3]) + mcv_abs(guide->shift[0]) + mcv_abs(guide->shift[1]) +
         mcv_abs(guide->shift[2]) + mcv_abs(guide->shift[3]));
    /* An ellipse that fills the pupil, or misses it, is of no use. */
    guide->advantage =
        area > 0.0f && area < 0.25f * (MCV_PUPIL_AREA / MCV_PI) && distance < MCV_PUPIL_REACH
            ? 1.0f / area
            : 0.0f;
}

/* 0 if no first-order optics is found from the point p of the pupil. */
static int mcv_guide_from(mcv_world world, mcv_film_sample film, float p_x, float p_y,
                          __global mcv_device_pupil_guide *guide) {
    mcv_pupil_optics o;
    o.at = mcv_follow(world, film, p_x, p_y);
    o.p_x = p_x;
    o.p_y = p_y;
    if (!mcv_find_pupil_optics(world, film, &o)) return 0;
    mcv_write_guide(world, film, o, guide);
    return 1;
}

static void mcv_guide_pupil(mcv_world world, uint pixel, __global mcv_device_pupil_guide *guide) {
    mcv_film_sample film;
    film.column = pixel % world.frame->width;
    film.row = pixel / world.frame->width;
    film.x = film.y = 0.5f;
    guide->advantage = 0.0f;
    /* Where the middle of the pupil sees something else, other places may see the emitter. */
    if (mcv_guide_from(world, film, 0.0f, 0.0f, guide)) return;
    for (int i = 0; i < 4; ++i) {
        if (mcv_guide_from(world, film, i & 1 ? 0.6f : -0.6f, i & 2 ? 0.6f : -0.6f, guide)) return;
    }
}
#endif

#endif
