/* SPDX-License-Identifier: Apache-2.0 */
/* The laws of the heights of defects. */
#include "defects/defects.h"

#include <math.h>

/* --- dents and bumps --- */

/* Beyond this radius, in s, a Gaussian is below 4e-6 of its height. */
static const double gaussian_end = 5;

/* The height of 1 at the radius r of a size of 1, and its derivative divided by r. */
static double round_law(int shape, double r, double *over_r) {
    if (shape == MCV_SHAPE_GAUSSIAN) {
        const double s = 0.25, h = r < gaussian_end * s ? exp(-r * r / (2 * s * s)) : 0;
        *over_r = -h / (s * s);
        return h;
    }
    *over_r = 0;
    if (r >= 0.5) return 0;
    /* d/dr cos²(π r) = -π sin(2π r); over r it is -2π² in the middle. */
    *over_r = r > 1e-9 ? -M_PI * sin(2 * M_PI * r) / r : -2 * M_PI * M_PI;
    return 0.5 * (1 + cos(2 * M_PI * r));
}

/* --- the cross-section of a scratch --- */

/* Half-width of the triangle that rounds the corners; the unit is half of the scratch's width. */
static const double rounding = 0.25;

/* First and second integral of the sharp groove f(|x|) from 0: V 1 - x, U 1 - x². */
static double integral(int profile, double x) {
    const double t = fmin(fabs(x), 1);
    return copysign(profile == MCV_PROFILE_V ? t - t * t / 2 : t - t * t * t / 3, x);
}

static double second_integral(int profile, double x) {
    const double a = fabs(x), t = fmin(a, 1), beyond = a - t;
    return profile == MCV_PROFILE_V ? t * t / 2 - t * t * t / 6 + beyond / 2
                                    : t * t / 2 - t * t * t * t / 12 + beyond * 2 / 3;
}

/* The groove, convolved with the triangle. */
static double groove(int profile, double x, double *slope) {
    const double r = rounding, below = x - r, above = x + r;
    *slope = 0;
    if (fabs(x) >= 1 + r) return 0;
    *slope =
        (integral(profile, above) - 2 * integral(profile, x) + integral(profile, below)) / (r * r);
    return (second_integral(profile, above) - 2 * second_integral(profile, x) +
            second_integral(profile, below)) /
           (r * r);
}

/* What stands beside it for a pile-up of 1, as a share of the depth: one ridge from 1 to 3 on
 * either side, with the area of the groove together. */
static double ridges(int profile, double x, double *slope) {
    const double t = fabs(x) - 2, height = integral(profile, 1);
    *slope = 0;
    if (fabs(t) >= 1) return 0;
    *slope = copysign(-height * M_PI / 2 * sin(M_PI * t), x);
    return height * 0.5 * (1 + cos(M_PI * t));
}

/* 1, falling as cos² to 0 over `fade` before the end. */
static double fading(double u, double half_length, double fade, double *slope) {
    const double t = (fabs(u) - (half_length - fade)) / fade;
    *slope = 0;
    if (t <= 0) return 1;
    if (t >= 1) return 0;
    *slope = copysign(-M_PI / (2 * fade) * sin(M_PI * t), u);
    return 0.5 * (1 + cos(M_PI * t));
}

static double scratch_height(const mcv_defect *d, double u, double v, double slope[2]) {
    double down, up, along, unused;
    const double half = d->size / 2, fade = fmin(3 * d->size, d->length / 2);
    const double deepest = groove(d->form, 0, &unused);
    const double cut = groove(d->form, v / half, &down), beside = ridges(d->form, v / half, &up);
    const double share = fading(u, d->length / 2, fade, &along);
    const double h = d->depth / deepest * (d->pile_up * beside - cut);
    slope[0] = h * along;
    slope[1] = d->depth / deepest * (d->pile_up * up - down) / half * share;
    return h * share;
}

double mcv_defect_height(const mcv_defect *defect, double u, double v, double slope[2]) {
    if (defect->type == MCV_DEFECT_SCRATCH) return scratch_height(defect, u, v, slope);
    double over_r;
    const double sign = defect->type == MCV_DEFECT_DENT ? -1 : 1, depth = sign * defect->depth,
                 h = round_law(defect->form, hypot(u, v) / defect->size, &over_r);
    slope[0] = depth * over_r * u / (defect->size * defect->size);
    slope[1] = depth * over_r * v / (defect->size * defect->size);
    return depth * h;
}

mcv_footprint mcv_defect_footprint(const mcv_defect *d) {
    if (d->type == MCV_DEFECT_SCRATCH) {
        const double radius = d->size / 2 * (d->pile_up > 0 ? 3 : 1 + rounding);
        return (mcv_footprint){.half_length = d->length / 2,
                               .radius = radius,
                               .fine = radius,
                               .edge = d->size / 24,
                               .stretch = 16};
    }
    if (d->form == MCV_SHAPE_COSINE)
        return (mcv_footprint){
            .radius = d->size / 2, .fine = d->size / 2, .edge = d->size / 64, .stretch = 1};
    return (mcv_footprint){.radius = gaussian_end * d->size / 4,
                           .fine = 3 * d->size / 4,
                           .edge = d->size / 32,
                           .stretch = 1};
}
