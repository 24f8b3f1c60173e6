/* SPDX-License-Identifier: Apache-2.0 */
/* The sides of solids: along which part of a ray it is inside of one. */
#ifndef MCVISI_KERNELS_SPANS_H
#define MCVISI_KERNELS_SPANS_H

#include "world.h"

/*
 * Where along a ray a condition holds: from enter to exit, or up to exit and again from enter where
 * that is the larger one.
 */
typedef struct mcv_span {
    float enter, exit;
} mcv_span;

MCV_LOOP_FUNCTION mcv_span mcv_span_of(float enter, float exit) {
    mcv_span span;
    span.enter = enter;
    span.exit = exit;
    return span;
}

MCV_LOOP_FUNCTION mcv_span mcv_everywhere(void) { return mcv_span_of(-INFINITY, INFINITY); }
MCV_LOOP_FUNCTION mcv_span mcv_nowhere(void) { return mcv_span_of(INFINITY, -INFINITY); }

MCV_LOOP_FUNCTION mcv_span mcv_either_span(int first, mcv_span a, mcv_span b) {
    return mcv_span_of(first ? a.enter : b.enter, first ? a.exit : b.exit);
}

MCV_LOOP_FUNCTION int mcv_span_holds(mcv_span span, float t) {
    const int entered = t >= span.enter, stays = t <= span.exit;
    return span.enter <= span.exit ? entered & stays : entered | stays;
}

/* Where the condition ends for a ray on which it holds at 0, though rounding may say that it does
 * not, quite. */
MCV_LOOP_FUNCTION float mcv_span_end(mcv_span span) {
    const float end = span.exit > 0.0f ? span.exit : 0.0f;
    const float gap_end = ((span.enter > 0.0f) & (-span.exit < span.enter)) ? 0.0f : INFINITY;
    return ((span.enter <= span.exit) | (span.exit >= 0.0f)) ? end : gap_end;
}

/* `on`: the ray starts on the side; `up`: and goes outwards. */
MCV_LOOP_FUNCTION mcv_span mcv_cylinder_span(float radius, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float a = mcv_fma(d.x, d.x, d.y * d.y);
    const float b = mcv_fma(d.x, p.x, d.y * p.y);
    const int along = !(a > 0.0f);
    const float other = -2.0f * b / a;
    const mcv_span inside = mcv_span_of(-INFINITY, along ? INFINITY : other > 0.0f ? other : 0.0f);
    const float c = mcv_fma(p.x, p.x, mcv_difference_of_products(p.y, p.y, radius, radius));
    const float cross = mcv_difference_of_products(p.x, d.y, p.y, d.x);
    const float discriminant = mcv_difference_of_products(a * radius, radius, cross, cross);
    const float root = mcv_sqrt(discriminant);
    const float q = b > 0.0f ? -b - root : root - b;
    const float at_q = q / a, at_c = c / q;
    const mcv_span crossed = mcv_span_of(b > 0.0f ? at_q : at_c, b > 0.0f ? at_c : at_q);
    const int holds = along ? c <= 0.0f : discriminant > 0.0f;
    const mcv_span met = mcv_either_span(along, mcv_everywhere(), crossed);
    return mcv_either_span(on ? !up : holds, mcv_either_span(on, inside, met), mcv_nowhere());
}

MCV_LOOP_FUNCTION mcv_span mcv_sphere_span(float radius, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float b = mcv_dot(p, d);
    const mcv_span inside = mcv_span_of(-INFINITY, b < 0.0f ? -2.0f * b : 0.0f);
    const mcv_vec3 foot = mcv_along(p, -b, d);
    const float distance = mcv_sqrt(mcv_dot(foot, foot));
    const float discriminant = (radius - distance) * (radius + distance);
    const float root = mcv_sqrt(discriminant);
    return mcv_either_span(on ? !up : discriminant > 0.0f,
                           mcv_either_span(on, inside, mcv_span_of(-b - root, root - b)),
                           mcv_nowhere());
}

/* Between two planes. */
MCV_LOOP_FUNCTION mcv_span mcv_slab_span(float half_size, float at, float along, int on) {
    const float first = (-half_size - at) / along, second = (half_size - at) / along;
    const mcv_span crossed =
        mcv_span_of(first < second ? first : second, first < second ? second : first);
    const mcv_span parallel =
        mcv_either_span(!on & (mcv_abs(at) > half_size), mcv_nowhere(), mcv_everywhere());
    return mcv_either_span(along == 0.0f, parallel, crossed);
}

MCV_LOOP_FUNCTION mcv_span mcv_box_span(__global const float *half_size, mcv_vec3 p, mcv_vec3 d,
                                        int on, int up) {
    const mcv_span x = mcv_slab_span(half_size[0], p.x, d.x, on),
                   y = mcv_slab_span(half_size[1], p.y, d.y, on);
    const float enter = x.enter > y.enter ? x.enter : y.enter;
    const float exit = x.exit < y.exit ? x.exit : y.exit;
    const mcv_span inside = mcv_span_of(-INFINITY, exit > 0.0f ? exit : 0.0f);
    return mcv_either_span(on ? !up : enter <= exit,
                           mcv_either_span(on, inside, mcv_span_of(enter, exit)), mcv_nowhere());
}

#endif
