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

/* A cap of the sphere through the rim and the middle. */
static double dig_height(const mcv_defect *d, double u, double v, double slope[2]) {
    const double radius = (d->size * d->size / 4 + d->depth * d->depth) / (2 * d->depth),
                 up = sqrt(fmax(0, radius * radius - u * u - v * v));
    slope[0] = u / up;
    slope[1] = v / up;
    return radius - d->depth - up;
}

static double burr_height(const mcv_defect *d, double u, double v, double slope[2]) {
    double along, over_v;
    const double share = fading(u, d->length / 2, fmin(3 * d->size, d->length / 2), &along),
                 h = d->depth * round_law(MCV_SHAPE_COSINE, fabs(v) / d->size, &over_v);
    slope[0] = h * along;
    slope[1] = d->depth * over_v * v / (d->size * d->size) * share;
    return h * share;
}

double mcv_defect_height(const mcv_defect *defect, double u, double v, double slope[2]) {
    if (defect->type == MCV_DEFECT_SCRATCH) return scratch_height(defect, u, v, slope);
    if (defect->type == MCV_DEFECT_DIG) return dig_height(defect, u, v, slope);
    if (defect->type == MCV_DEFECT_BURR) return burr_height(defect, u, v, slope);
    double over_r;
    const double sign = defect->type == MCV_DEFECT_DENT ? -1 : 1, depth = sign * defect->depth,
                 h = round_law(defect->form, hypot(u, v) / defect->size, &over_r);
    slope[0] = depth * over_r * u / (defect->size * defect->size);
    slope[1] = depth * over_r * v / (defect->size * defect->size);
    return depth * h;
}

/* --- outlines --- */

/* The height of the middle of a chip's ball. */
static double ball_middle(const mcv_defect *d) { return d->size / 2 - d->depth; }

double mcv_defect_outline(const mcv_defect *d, const double p[3]) {
    if (d->type == MCV_DEFECT_MISSING_PART) return p[2] + d->size;
    /* Above its middle the ball goes on as a cylinder: whatever stands there is cut off, too. */
    const double below = d->type == MCV_DEFECT_CHIP ? fmin(0, p[2] - ball_middle(d)) : 0;
    return d->size * d->size / 4 - p[0] * p[0] - p[1] * p[1] - below * below;
}

double mcv_defect_cut(const mcv_defect *d, double u, double v, double normal[3]) {
    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (d->type == MCV_DEFECT_MISSING_PART) return -d->size;
    const double radius = d->size / 2, down = sqrt(fmax(0, radius * radius - u * u - v * v));
    normal[0] = -u / radius;
    normal[1] = -v / radius;
    normal[2] = down / radius;
    return ball_middle(d) - down;
}

/* --- footprints --- */

static mcv_footprint round_footprint(double radius, double edge) {
    return (mcv_footprint){
        .radius = radius, .lowest = -INFINITY, .fine = radius, .edge = edge, .stretch = 1};
}

static mcv_footprint long_footprint(const mcv_defect *d, double radius, double edge) {
    mcv_footprint f = round_footprint(radius, edge);
    f.half_length = d->length / 2;
    f.stretch = 16;
    return f;
}

mcv_footprint mcv_defect_footprint(const mcv_defect *d) {
    mcv_footprint f = round_footprint(d->size / 2, d->size / 64);
    switch (d->type) {
    case MCV_DEFECT_SCRATCH:
        return long_footprint(d, d->size / 2 * (d->pile_up > 0 ? 3 : 1 + rounding), d->size / 24);
    case MCV_DEFECT_BURR:
        return long_footprint(d, d->size / 2, d->size / 64);
    case MCV_DEFECT_CHIP:
        f.lowest = -d->depth;
        return f;
    case MCV_DEFECT_MISSING_PART: /* a plane cuts triangles along straight lines */
        f = round_footprint(INFINITY, INFINITY);
        f.lowest = -d->size;
        return f;
    case MCV_DEFECT_STAIN:
    case MCV_DEFECT_ROUGH_PATCH:
        return round_footprint(d->size / 2, d->size / 32);
    default:
        break;
    }
    if (d->type == MCV_DEFECT_DIG || d->form == MCV_SHAPE_COSINE) return f;
    f = round_footprint(gaussian_end * d->size / 4, d->size / 32);
    f.fine = 3 * d->size / 4;
    return f;
}
