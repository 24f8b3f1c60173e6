/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A rectangle as a receiver sees it: its solid angle, and the choice of points on it uniformly in
 * solid angle (Ureña, Fajardo and King, An Area-Preserving Parametrization for Spherical
 * Rectangles, 2013). Unlike the density of a choice by area, this density contains neither 1/d² nor
 * the cosine at the rectangle. Both vary much over an emitter close by.
 *
 * The receiver is the origin, z its height above the rectangle's plane, and c(x) = x/√(x² + z²).
 * The solid angle of [x, 0] x [y, 0] is A(x, y) = asin c(x) c(y) [sr], up to its sign. Let t(x) =
 * A(x, y1) - A(x, y0): the solid angle below x is t(x) - t(x0). The law of sines in the triangle
 * with the sides c(y0), c(y1) and the angle t between them says
 *
 *     c(x) = sin t/√(c(y1)² + c(y0)² - 2 c(y1) c(y0) cos t)
 *
 * Along y, at that x, solid angle is uniform in y/√(x² + y² + z²). Angles are stored as pairs
 * (cosine, sine), whose sums lose no digits.
 */
#ifndef MCVISI_RECTANGLE_H
#define MCVISI_RECTANGLE_H

#include "mcvisi/sampling.h"

typedef struct mcv_rectangle {
    float corner[3]; /* point (0, 0) [m] */
    float width;     /* the shorter side, for which t is closer to linear; 0: not a rectangle */
    float x[3];      /* unit, along it */
    float height;
    float y[3];
    uint padding;
    float to_triangle[2][6]; /* for each of the two triangles: the point (s, t), in sides, has u =
                                a[0] + a[1] s + a[2] t; the other three give v */
} mcv_rectangle;
MCV_ASSERT_SIZE(mcv_rectangle, 96);

/*
 * Points are chosen by solid angle if the solid angle is at least this [sr]. The sum of angles has
 * an error of 4 u, here 1e-5 of its value. A rectangle that appears smaller (a quarter of its
 * distance across) varies so little that a choice by area is as good.
 */
#define MCV_LEAST_SOLID_ANGLE 0.03f

typedef struct mcv_rectangle_view {
    float x0, x1, y0, y1, z; /* of its sides; z > 0: the receiver is in front of it [m] */
    float low, high;         /* c(y0), c(y1) */
    float cosine, sine;      /* of t(x0) */
    float solid_angle;       /* [sr]; valid only if z > 0 */
} mcv_rectangle_view;

/* The cosine and sine of t. */
typedef struct mcv_turn {
    float cosine, sine;
} mcv_turn;

/* c(x), and 1 - c(x)². */
typedef struct mcv_slope {
    float c, rest;
} mcv_slope;

MCV_LOOP_FUNCTION mcv_slope mcv_slope_of(float x, float z_squared) {
    mcv_slope slope;
    const float inverse = 1.0f / mcv_fma(x, x, z_squared);
    slope.c = x * mcv_sqrt(inverse);
    slope.rest = z_squared * inverse;
    return slope;
}

/* t at x, for y between `low` and `high`. */
MCV_LOOP_FUNCTION mcv_turn mcv_turn_at(mcv_slope x, mcv_slope low, mcv_slope high) {
    mcv_turn t;
    const float squared = x.c * x.c;
    const float below = x.c * low.c, below_cosine = mcv_sqrt(mcv_fma(squared, low.rest, x.rest));
    const float above = x.c * high.c, above_cosine = mcv_sqrt(mcv_fma(squared, high.rest, x.rest));
    t.cosine = mcv_fma(above_cosine, below_cosine, above * below);
    t.sine = mcv_difference_of_products(above, below_cosine, above_cosine, below);
    return t;
}

/* `facing` is the unit normal of the front. */
MCV_LOOP_FUNCTION mcv_rectangle_view mcv_view_rectangle(MCV_GLOBAL const mcv_rectangle *r,
                                                        mcv_vec3 facing, mcv_vec3 receiver) {
    mcv_rectangle_view view;
    const mcv_vec3 way = mcv_sub(mcv_vec(r->corner[0], r->corner[1], r->corner[2]), receiver);
    view.x0 = mcv_dot(way, mcv_vec(r->x[0], r->x[1], r->x[2]));
    view.y0 = mcv_dot(way, mcv_vec(r->y[0], r->y[1], r->y[2]));
    view.x1 = view.x0 + r->width;
    view.y1 = view.y0 + r->height;
    view.z = -mcv_dot(way, facing);
    const float z_squared = view.z * view.z;
    const mcv_slope low = mcv_slope_of(view.y0, z_squared), high = mcv_slope_of(view.y1, z_squared);
    const mcv_turn from = mcv_turn_at(mcv_slope_of(view.x0, z_squared), low, high);
    const mcv_turn to = mcv_turn_at(mcv_slope_of(view.x1, z_squared), low, high);
    const float angle =
        mcv_atan2(mcv_difference_of_products(to.sine, from.cosine, to.cosine, from.sine),
                  mcv_fma(to.cosine, from.cosine, to.sine * from.sine));
    view.low = low.c;
    view.high = high.c;
    view.cosine = from.cosine;
    view.sine = from.sine;
    view.solid_angle = angle < 0.0f ? angle + 2.0f * MCV_PI : angle;
    return view;
}

/* Whether a receiver chooses points by solid angle (else by area). */
MCV_FUNCTION int mcv_samples_solid_angle(mcv_rectangle_view view) {
    return (view.z > 0.0f) & (view.solid_angle >= MCV_LEAST_SOLID_ANGLE);
}

MCV_FUNCTION float mcv_clamp_share(float share) {
    return share > 0.0f ? share < 1.0f ? share : 1.0f : 0.0f;
}

/* The point (s, t), in units of the sides, at the shares xi and eta of the solid angle. */
MCV_LOOP_FUNCTION void mcv_sample_rectangle(MCV_GLOBAL const mcv_rectangle *r,
                                            mcv_rectangle_view view, float xi, float eta, float *s,
                                            float *t) {
    float turn_sine, turn_cosine;
    mcv_sin_cos_turn(0.5f / MCV_PI * xi * view.solid_angle, &turn_sine, &turn_cosine);
    const float sine = mcv_fma(view.sine, turn_cosine, view.cosine * turn_sine);
    const float cosine = mcv_difference_of_products(view.cosine, turn_cosine, view.sine, turn_sine);
    /* 1 ∓ cos t = sin² t/(1 ± cos t) */
    const int ahead = cosine > 0.0f;
    const float side = ahead ? view.high - view.low : view.high + view.low;
    const float rest = 2.0f * view.high * view.low * (sine * sine / (1.0f + mcv_abs(cosine)));
    const float third = mcv_fma(side, side, ahead ? rest : -rest);
    const float level = mcv_fma(-sine, sine, third);
    const float x = view.z * sine / mcv_sqrt(level > 0.0f ? level : 0.0f);
    *s = mcv_clamp_share((x - view.x0) / r->width);
    const float across = mcv_fma(*s, r->width, view.x0);
    const float squared = mcv_fma(across, across, view.z * view.z);
    const float bottom = view.y0 / mcv_sqrt(mcv_fma(view.y0, view.y0, squared));
    const float top = view.y1 / mcv_sqrt(mcv_fma(view.y1, view.y1, squared));
    const float h = mcv_fma(eta, top - bottom, bottom);
    const float y = h * mcv_sqrt(squared / mcv_fma(-h, h, 1.0f));
    *t = mcv_clamp_share((y - view.y0) / r->height);
}

#endif
