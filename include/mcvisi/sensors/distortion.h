/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tilted films and lens distortion, of pinhole, thin lens and telecentric cameras.
 *
 * Slopes are lengths on the film over h: x right, y down, z forward, as in an upright image. h is
 * the distance from the centre of the aperture to the film along the axis: the image distance b, of
 * a telecentric camera b - f. Three maps lie between a pixel and its rays:
 *
 *   film     The pixel's place on the film (X, Y), over h, lies at e (s_x, s_y, 1) = (0, 0, 1) + X
 *            a1 + Y a2 in space, over h. a1 and a2 are the film's axes, e the stretch of its
 *            distance. tilt τ turns the axes by τ about (cosρ, sinρ, 0), ρ is tiltDirection:
 *            HALCON's Tilt and Rot (C. Steger, IJCV 123, 2017). tiltX and tiltY are OpenCV's τx,
 *            τy: rows 1 and 2 of R_y R_x.
 *   lens     The slope s is the distorted one, u that without distortion. k1…k6, p1, p2, s1…s4 are
 *            OpenCV's, with r² = |u|²:
 *                s_x = u_x (1 + k1 r² + k2 r⁴ + k3 r⁶)/(1 + k4 r² + k5 r⁴ + k6 r⁶)
 *                      + 2 p1 u_x u_y + p2 (r² + 2 u_x²) + s1 r² + s2 r⁴
 *                s_y = u_y (…)/(…) + p1 (r² + 2 u_y²) + 2 p2 u_x u_y + s3 r² + s4 r⁴
 *            kappa [1/m²] is HALCON's division model: u = s/(1 + κ h² |s|²).
 *   aperture The rays through the points a of the aperture have the slopes u + a/(h e) behind it,
 *            so that each pixel is in focus at its own depth.
 *
 * Irradiance keeps what "falloff" says (mcvisi/sensors/sensor.h). Object side: the light that
 * enters the lens is distributed over the film by the area that a pixel sees, |∂(u + a/(h e))/∂(X,
 * Y)|. Image side: the angles of the film's true place count, |∂(s + a/(h e))/∂(X, Y)|.
 */
#ifndef MCVISI_SENSORS_DISTORTION_H
#define MCVISI_SENSORS_DISTORTION_H

#include "mcvisi/sensors/sensor.h"

enum { MCV_UNDISTORTED, MCV_BROWN_CONRADY, MCV_DIVISION };

typedef struct mcv_distortion {
    uint model;         /* MCV_UNDISTORTED … */
    float a1[3], a2[3]; /* axes of the film */
    float k[6], p[2];
    float s[4];
    float kappa;        /* κ h² */
    float per_distance; /* 1/h [1/m] */
    float reach;        /* largest |u|² that the film sees: what lies beyond may fold back */
    /* What falls on the film beside the above, straight between these distances over h. */
    uint illumination_count; /* 0: all */
    float distance[MCV_CURVE_POINTS], illumination[MCV_CURVE_POINTS];
} mcv_distortion;

#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
MCV_ASSERT_SIZE(mcv_distortion, MCV_DISTORTION_SIZE);

/* A place on the film as rays see it. */
typedef struct mcv_film_view {
    float u_x, u_y;     /* the chief ray's slope, before the lens */
    float s_x, s_y;     /* and behind it */
    float stretch;      /* e */
    float object_share; /* |∂(u + a/(h e))/∂(X, Y)| */
    float image_share;  /* |∂(s + a/(h e))/∂(X, Y)| */
    float illumination; /* relative, of the place */
} mcv_film_view;

/* A pair and its derivatives by another pair. */
typedef struct mcv_mapped {
    float x, y;
    float x_x, x_y, y_x, y_y; /* x_y = ∂x/∂y */
} mcv_mapped;

MCV_LOOP_FUNCTION mcv_mapped mcv_distort(MCV_CONSTANT const mcv_distortion *d, float u_x,
                                         float u_y) {
    mcv_mapped to;
    const float r = mcv_fma(u_x, u_x, u_y * u_y);
    if (d->model == MCV_DIVISION) {
        /* s = c u with c = 2/(1 + √(1 - 4κ r²)); dc/dr² = κ c²/√… */
        const float inside = mcv_fma(-4.0f * d->kappa, r, 1.0f);
        const float root = mcv_sqrt(inside > 1e-6f ? inside : 1e-6f);
        const float c = 2.0f / (1.0f + root);
        const float grow = 2.0f * d->kappa * c * c / root;
        to.x = c * u_x;
        to.y = c * u_y;
        to.x_x = mcv_fma(grow, u_x * u_x, c);
        to.x_y = to.y_x = grow * u_x * u_y;
        to.y_y = mcv_fma(grow, u_y * u_y, c);
        return to;
    }
    const float above = mcv_fma(r, mcv_fma(r, mcv_fma(r, d->k[2], d->k[1]), d->k[0]), 1.0f);
    const float below = mcv_fma(r, mcv_fma(r, mcv_fma(r, d->k[5], d->k[4]), d->k[3]), 1.0f);
    const float above_r = mcv_fma(r, mcv_fma(3.0f * r, d->k[2], 2.0f * d->k[1]), d->k[0]);
    const float below_r = mcv_fma(r, mcv_fma(3.0f * r, d->k[5], 2.0f * d->k[4]), d->k[3]);
    const float radial = above / below;
    const float grow = 2.0f * (above_r - radial * below_r) / below; /* ∂radial/∂u = grow u */
    const float prism_x = mcv_fma(r, d->s[1], d->s[0]);
    const float prism_y = mcv_fma(r, d->s[3], d->s[2]);
    const float prism_x_r = 2.0f * mcv_fma(2.0f * r, d->s[1], d->s[0]);
    const float prism_y_r = 2.0f * mcv_fma(2.0f * r, d->s[3], d->s[2]);
    const float cross = u_x * u_y;
    to.x = mcv_fma(radial, u_x, 2.0f * d->p[0] * cross) +
           mcv_fma(d->p[1], mcv_fma(2.0f * u_x, u_x, r), r * prism_x);
    to.y = mcv_fma(radial, u_y, 2.0f * d->p[1] * cross) +
           mcv_fma(d->p[0], mcv_fma(2.0f * u_y, u_y, r), r * prism_y);
    to.x_x = mcv_fma(grow * u_x, u_x, radial) +
             mcv_fma(2.0f * d->p[0], u_y, mcv_fma(6.0f * d->p[1], u_x, prism_x_r * u_x));
    to.x_y =
        mcv_fma(grow, cross, 2.0f * d->p[0] * u_x) + mcv_fma(2.0f * d->p[1], u_y, prism_x_r * u_y);
    to.y_x =
        mcv_fma(grow, cross, 2.0f * d->p[1] * u_y) + mcv_fma(2.0f * d->p[0], u_x, prism_y_r * u_x);
    to.y_y = mcv_fma(grow * u_y, u_y, radial) +
             mcv_fma(2.0f * d->p[1], u_x, mcv_fma(6.0f * d->p[0], u_y, prism_y_r * u_y));
    return to;
}

/* The host refuses a lens for which so many steps of Newton's method do not reach each place of the
 * film. */
#define MCV_UNDISTORT_STEPS 12

/* u of s, with the derivatives of u by s. */
MCV_LOOP_FUNCTION mcv_mapped mcv_undistort(MCV_CONSTANT const mcv_distortion *d, float s_x,
                                           float s_y) {
    mcv_mapped u, at;
    u.x = s_x;
    u.y = s_y;
    u.x_x = u.y_y = 1.0f;
    u.x_y = u.y_x = 0.0f;
    if (d->model == MCV_UNDISTORTED) return u;
    if (d->model == MCV_DIVISION) {
        const float c = 1.0f / mcv_fma(d->kappa, mcv_fma(s_x, s_x, s_y * s_y), 1.0f);
        u.x = c * s_x;
        u.y = c * s_y;
    } else {
        for (int step = 0; step < MCV_UNDISTORT_STEPS; ++step) {
            at = mcv_distort(d, u.x, u.y);
            const float inverse = 1.0f / mcv_fma(at.x_x, at.y_y, -at.x_y * at.y_x);
            const float x = at.x - s_x;
            const float y = at.y - s_y;
            u.x -= mcv_fma(at.y_y, x, -at.x_y * y) * inverse;
            u.y -= mcv_fma(at.x_x, y, -at.y_x * x) * inverse;
        }
    }
    at = mcv_distort(d, u.x, u.y);
    const float inverse = 1.0f / mcv_fma(at.x_x, at.y_y, -at.x_y * at.y_x);
    u.x_x = at.y_y * inverse;
    u.x_y = -at.x_y * inverse;
    u.y_x = -at.y_x * inverse;
    u.y_y = at.x_x * inverse;
    return u;
}

/* The relative illumination of the place (X, Y) of the film. */
MCV_LOOP_FUNCTION float mcv_illumination(MCV_CONSTANT const mcv_distortion *d, float film_x,
                                         float film_y) {
    if (d->illumination_count == 0u) return 1.0f;
    const float r = mcv_sqrt(mcv_fma(film_x, film_x, film_y * film_y));
    uint i = 1u;
    while (i + 1u < d->illumination_count && d->distance[i] < r) ++i;
    const float share = (r - d->distance[i - 1u]) / (d->distance[i] - d->distance[i - 1u]);
    return mcv_fma(share, d->illumination[i] - d->illumination[i - 1u], d->illumination[i - 1u]);
}

/* How rays through (a_x, a_y) = a/h of the aperture, y down, see the place (X, Y) of the film. */
MCV_LOOP_FUNCTION mcv_film_view mcv_view_film(MCV_CONSTANT const mcv_distortion *d, float film_x,
                                              float film_y, float a_x, float a_y) {
    mcv_film_view view;
    const float e = mcv_fma(film_x, d->a1[2], mcv_fma(film_y, d->a2[2], 1.0f));
    const float per = 1.0f / e;
    const float s_x = mcv_fma(film_x, d->a1[0], film_y * d->a2[0]) * per;
    const float s_y = mcv_fma(film_x, d->a1[1], film_y * d->a2[1]) * per;
    const mcv_mapped u = mcv_undistort(d, s_x, s_y);
    /* ∂s/∂(X, Y), and of a/(h e) */
    const float x_1 = mcv_fma(-s_x, d->a1[2], d->a1[0]) * per;
    const float x_2 = mcv_fma(-s_x, d->a2[2], d->a2[0]) * per;
    const float y_1 = mcv_fma(-s_y, d->a1[2], d->a1[1]) * per;
    const float y_2 = mcv_fma(-s_y, d->a2[2], d->a2[1]) * per;
    const float lean_1 = -d->a1[2] * per * per;
    const float lean_2 = -d->a2[2] * per * per;
    const float q_1 = mcv_fma(u.x_x, x_1, mcv_fma(u.x_y, y_1, a_x * lean_1));
    const float q_2 = mcv_fma(u.x_x, x_2, mcv_fma(u.x_y, y_2, a_x * lean_2));
    const float r_1 = mcv_fma(u.y_x, x_1, mcv_fma(u.y_y, y_1, a_y * lean_1));
    const float r_2 = mcv_fma(u.y_x, x_2, mcv_fma(u.y_y, y_2, a_y * lean_2));
    view.u_x = u.x;
    view.u_y = u.y;
    view.s_x = s_x;
    view.s_y = s_y;
    view.stretch = e;
    view.illumination = mcv_illumination(d, film_x, film_y);
    view.object_share = mcv_abs(mcv_fma(q_1, r_2, -q_2 * r_1));
    view.image_share = mcv_abs(mcv_fma(mcv_fma(a_x, lean_1, x_1), mcv_fma(a_y, lean_2, y_2),
                                       -mcv_fma(a_x, lean_2, x_2) * mcv_fma(a_y, lean_1, y_1)));
    return view;
}

/*
 * The weight of a ray, as mcv_sensor_ray_weight: `direction` before the lens, y up; (a_x, a_y) =
 * a/h, y down.
 */
MCV_LOOP_FUNCTION float mcv_film_weight(float etendue, float bend, mcv_film_view view,
                                        mcv_vec3 direction, float a_x, float a_y) {
    const float per = 1.0f / view.stretch;
    const mcv_vec3 counted =
        bend > 0.0f ? mcv_vec(mcv_fma(a_x, per, view.s_x), mcv_fma(a_y, per, view.s_y), 1.0f)
                    : direction;
    const float share = bend > 0.0f ? view.image_share : view.object_share;
    const float squared = mcv_dot(counted, counted);
    return etendue > 0.0f ? etendue * share / (squared * squared) * view.illumination : 1.0f;
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/*
 * The place (X, Y) that the ray with the slope q = u + a/(h e) behind the aperture meets; 0 if it
 * is none of the film. Without distortion the first e is right; each step brings the error of one
 * with distortion down by the tilt's tangent over the f-number.
 */
MCV_FUNCTION int mcv_find_on_film(MCV_CONSTANT const mcv_distortion *d, float q_x, float q_y,
                                  float a_x, float a_y, float *film_x, float *film_y) {
    const mcv_vec3 n = mcv_vec(d->a1[1] * d->a2[2] - d->a1[2] * d->a2[1],
                               d->a1[2] * d->a2[0] - d->a1[0] * d->a2[2],
                               d->a1[0] * d->a2[1] - d->a1[1] * d->a2[0]);
    float e = mcv_fma(n.x, a_x, mcv_fma(n.y, a_y, n.z)) / mcv_fma(n.x, q_x, mcv_fma(n.y, q_y, n.z));
    float s_x = 0.0f, s_y = 0.0f;
    for (int step = 0; step < 6; ++step) {
        const float u_x = q_x - a_x / e;
        const float u_y = q_y - a_y / e;
        if (!(e > 0.0f) || !(mcv_fma(u_x, u_x, u_y * u_y) <= d->reach)) return 0;
        s_x = u_x;
        s_y = u_y;
        if (d->model != MCV_UNDISTORTED) {
            const mcv_mapped s = mcv_distort(d, u_x, u_y);
            s_x = s.x;
            s_y = s.y;
        }
        e = n.z / mcv_fma(n.x, s_x, mcv_fma(n.y, s_y, n.z));
    }
    const mcv_vec3 at = mcv_vec(e * s_x, e * s_y, e - 1.0f);
    *film_x = mcv_dot(at, mcv_vec(d->a1[0], d->a1[1], d->a1[2]));
    *film_y = mcv_dot(at, mcv_vec(d->a2[0], d->a2[1], d->a2[2]));
    return 1;
}
#endif
#endif

#endif
