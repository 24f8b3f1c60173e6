/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The caps of solids: along which part of a ray it is above one.
 *
 * Along a ray p + t d, in the frame of the solid and about the foot of the perpendicular from its
 * middle, so that t is no larger than the solid, a conic of revolution c (r² + (1 + k) z²) = 2 z is
 * A t² - 2 G t + F = 0 with
 *
 *     A = c (L² + M² + (1 + k) N²)   G = N - c (L x + M y + (1 + k) N z)   F = c (r² + (1 + k) z²)
 * - 2 z t = F/(G + sgn(G) √(G² - A F)) and (G + sgn(G) √(G² - A F))/A
 *
 * without cancellation in either root and stable as c goes to 0. A root counts on the sheet of the
 * vertex, 1 > (1 + k) c z. A ray that starts on the surface has F = 0, whatever rounds: only the
 * other root, 2 G/A, is left, and it needs no offset.
 *
 * An asphere is marched: with g the height above it and M a bound of |g''| along the ray nothing is
 * met within the h that solves |g| + s g' h - M h²/2 = 0, s the sign of g. The steps end at the
 * surface as fast as Newton's and cannot leave it out.
 *
 */
#ifndef MCVISI_KERNELS_CAPS_H
#define MCVISI_KERNELS_CAPS_H

#include "geometry/spans.h"

/* `within`: a place inside of the side; `on`: the ray starts on the cap; `up`: and goes above it. z
 * counts from the vertex. */
MCV_LOOP_FUNCTION mcv_span mcv_conic_above(__global const mcv_device_cap *cap, mcv_vec3 p,
                                           mcv_vec3 d, float within, int on, int up) {
    const float c = cap->curvature;
    const float w = cap->across;
    const float e = 1.0f + cap->conic;
    const float a = c * mcv_fma(w * d.x, d.x, mcv_fma(d.y, d.y, e * d.z * d.z));
    const float g = mcv_fma(-c, mcv_fma(w * d.x, p.x, mcv_fma(d.y, p.y, e * d.z * p.z)), d.z);

    const float other = 2.0f * g / a;
    const float meets =
        1.0f - e * c * mcv_fma(other, d.z, p.z) > 0.0f ? (other > 0.0f ? other : 0.0f) : INFINITY;
    const mcv_span rising = mcv_span_of(-INFINITY, a > 0.0f ? meets : INFINITY);
    const mcv_span falling = mcv_either_span((a < 0.0f) & (meets < INFINITY),
                                             mcv_span_of(meets, INFINITY), mcv_nowhere());

    const float f =
        mcv_fma(c, mcv_fma(w * p.x, p.x, mcv_fma(p.y, p.y, e * p.z * p.z)), -2.0f * p.z);
    const float discriminant = mcv_difference_of_products(g, g, a, f);
    const float root = mcv_sqrt(discriminant);
    const float q = g >= 0.0f ? g + root : g - root;
    const float first = f / q, second = q / a;
    const float t_rise = g >= 0.0f ? first : second;
    const float t_fall = g >= 0.0f ? second : first;
    const int crosses = discriminant > 0.0f;
    const int rises = crosses & (mcv_abs(t_rise) < INFINITY) &
                      (mcv_fma(-e * c, mcv_fma(t_rise, d.z, p.z), 1.0f) > 0.0f);
    const int falls = crosses & (mcv_abs(t_fall) < INFINITY) &
                      (mcv_fma(-e * c, mcv_fma(t_fall, d.z, p.z), 1.0f) > 0.0f);
    const mcv_span crossed = mcv_span_of(rises ? t_rise : -INFINITY, falls ? t_fall : INFINITY);
    /* No crossing: it is on the same side everywhere. */
    const mcv_vec3 m = mcv_along(p, within, d);
    const float bent = e * c * m.z;
    const float height =
        mcv_fma(c, mcv_fma(w * m.x, m.x, mcv_fma(m.y, m.y, e * m.z * m.z)), -2.0f * m.z);
    const int above = bent < 1.0f ? height < 0.0f : e * c > 0.0f;
    const mcv_span met = mcv_either_span(rises | falls, crossed,
                                         mcv_either_span(above, mcv_everywhere(), mcv_nowhere()));
    return mcv_either_span(on, mcv_either_span(up, rising, falling), met);
}

/* dz/dr² of a cap at r², and *height its z. */
MCV_FUNCTION float mcv_cap_slope(__global const mcv_device_cap *cap, float r2, float *height) {
    const float c = cap->curvature;
    const float u = cap->scale * r2;
    const float under = mcv_fma(-(1.0f + cap->conic) * c * c, r2, 1.0f);
    const float root = mcv_sqrt(under > 0.0f ? under : 0.0f);
    float value = 0.0f, slope = 0.0f;
    for (uint i = cap->terms; i > 0; --i) {
        slope = mcv_fma(slope, u, (float)(i + 1u) * cap->term[i - 1u]);
        value = mcv_fma(value, u, cap->term[i - 1u]);
    }
    *height = c * r2 / (1.0f + root) + value * u * u;
    return mcv_fma(slope * u, cap->scale, 0.5f * c / root);
}

/* The height above an asphere at t and its derivative along the ray. */
MCV_FUNCTION float mcv_height_above(__global const mcv_device_cap *cap, mcv_vec3 p, mcv_vec3 d,
                                    float t, float *derivative) {
    const mcv_vec3 at = mcv_along(p, t, d);
    const float w = cap->across;
    float height;
    const float slope = mcv_cap_slope(cap, mcv_fma(w * at.x, at.x, at.y * at.y), &height);
    *derivative = mcv_fma(-2.0f * slope, mcv_fma(w * at.x, d.x, at.y * d.y), d.z);
    return at.z - height;
}

#define MCV_MARCHES 64

/* From low to high, the part of the ray within the side; its first two crossings there. */
MCV_FUNCTION mcv_span mcv_asphere_above(__global const mcv_device_cap *cap, float bound, mcv_vec3 p,
                                        mcv_vec3 d, float low, float high, int on, int up) {
    /* z, the height and what leads to them are at most twice the bound and round 6 times: less than
     * that is no height. */
    const float zero = 2.0f * MCV_GAMMA(6) * bound;
    const float bend = cap->bend * mcv_fma(cap->across * d.x, d.x, d.y * d.y);
    const float least = mcv_sqrt(2.0f * zero / bend); /* it can bend by `zero` */
    float t = on ? 0.0f : low;
    float crossing[2] = {INFINITY, INFINITY};
    float derivative;
    const float height = mcv_height_above(cap, p, d, t, &derivative);
    const int above = on ? up : height > 0.0f;
    float sign = above ? 1.0f : -1.0f;
    float distance = on ? 0.0f : mcv_abs(height);
    float speed =
        on ? fmax(sign * derivative, 0.0f) : sign * derivative; /* with which the distance grows */
    int found = 0;
    for (int i = 0; i < MCV_MARCHES; ++i) {
        if (distance <= zero && speed < 0.0f) {
            t += distance / -speed;
            if (!(t <= high)) break;
            crossing[found++] = t;
            if (found == 2) break;
            sign = -sign;
            (void)mcv_height_above(cap, p, d, t, &derivative);
            distance = 0.0f;
            speed = fmax(sign * derivative, 0.0f);
        }
        const float root = mcv_sqrt(mcv_fma(speed, speed, 2.0f * bend * distance));
        const float step = speed < 0.0f ? 2.0f * distance / (root - speed) : (root + speed) / bend;
        t += speed >= 0.0f && distance <= zero ? fmax(step, least) : step;
        if (!(t <= high)) break;
        distance = fmax(sign * mcv_height_above(cap, p, d, t, &derivative), 0.0f);
        speed = sign * derivative;
    }
    if (found == 0) return above ? mcv_everywhere() : mcv_nowhere();
    return above ? mcv_span_of(crossing[1], crossing[0]) : mcv_span_of(crossing[0], crossing[1]);
}

#endif
