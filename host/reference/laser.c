/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/laser.h"

#include "reference/texture.h"

/* A line or a beam: its axes, and the point in them. */
typedef struct line {
    ref_vec x, y, forward;
    double at[3];
    double distance; /* ρ or z [m] */
    double bend;
    double irradiance; /* across the fan's or the beam's axis, of the power 1 */
} line;

/* 1/e² radius of the waist, from a diameter: exp(-2 (F/2)²/w²) = 1/2 at half of the FWHM F. */
static double waist_of(const mcv_laser_params *p, int axis) {
    const double width = isnan(p->fanAngle) ? p->beamDiameter[axis] : p->lineThickness;
    return p->widthMeasure == 2 ? width / sqrt(2 * log(2)) : width / 2;
}

/* Standard deviations of position and slope at the waist. */
static void wigner_of(const mcv_laser_params *p, int axis, double *position, double *slope) {
    const double w = waist_of(p, axis);
    *position = w / 2;
    *slope = p->M2[axis] * p->wavelength / (2 * M_PI * w);
}

/* The density of the position at a distance from the node: the variance of position plus distance
 * times slope. */
static double section(const mcv_laser_params *p, int axis, double distance, double at) {
    double position, slope;
    wigner_of(p, axis, &position, &slope);
    const double sigma = hypot(position, slope * (distance - p->workingDistance));
    return exp(-at * at / (2 * sigma * sigma)) / (sqrt(2 * M_PI) * sigma);
}

/* The slope given the position, by the regression of two normal variables. */
static double slope_at(const mcv_laser_params *p, int axis, double distance, double at,
                       double normal) {
    double position, slope;
    wigner_of(p, axis, &position, &slope);
    const double way = distance - p->workingDistance, sigma = hypot(position, slope * way);
    return at * way * slope * slope / (sigma * sigma) + normal * slope * position / sigma;
}

/* The share of the power per angle of a fan. */
static double fan_at(const mcv_scene *scene, const mcv_laser_params *p, double angle) {
    const double half = p->fanAngle / 2;
    if (fabs(angle) > half) return 0;
    if (p->fanProfile == MCV_LASER_PLANE) return pow(cos(angle), -2) / (2 * tan(half));
    if (p->fanProfile == MCV_LASER_ANGLE) return 1 / p->fanAngle;
    if (p->fanProfile == MCV_LASER_GAUSSIAN)
        return exp(-2 * pow(angle / half, 2)) / (half * sqrt(M_PI / 2) * erf(sqrt(2)));
    const mcv_texture *image = &scene->textures[p->image];
    const uint32_t column =
        (uint32_t)fmin(floor((angle / half + 1) / 2 * image->width), image->width - 1.0);
    double own = 0, all = 0, rgb[3];
    for (uint32_t i = 0; i < image->width; ++i)
        for (uint32_t row = 0; row < image->height; ++row) {
            ref_texel(image, i, row, rgb);
            all += rgb[0] + rgb[1] + rgb[2];
            if (i == column) own += rgb[0] + rgb[1] + rgb[2];
        }
    return own / all * image->width / p->fanAngle;
}

/* The axes of line `number`, and what it sends through the point. */
static line line_at(const mcv_scene *scene, const mcv_emitter *emitter, uint32_t number,
                    ref_vec point) {
    const mcv_laser_params *p = &emitter->as.laser;
    const double *m = emitter->to_world.m;
    const ref_vec node_x = {m[0], m[3], m[6]}, node_y = {m[1], m[4], m[7]},
                  node_z = {m[2], m[5], m[8]}, place = {m[9], m[10], m[11]};
    const double turn = (number - (p->lineCount - 1) / 2.0) * p->interBeamAngle;
    const ref_vec aim = ref_unit(ref_add(ref_scale(tan(p->boresightX), node_x),
                                         ref_sub(ref_scale(tan(p->boresightY), node_y), node_z)));
    const ref_vec up = ref_unit(ref_cross(node_x, aim)), x = ref_cross(aim, up);
    line l = {.x = x,
              .y = ref_sub(ref_scale(cos(turn), up), ref_scale(sin(turn), aim)),
              .forward = ref_add(ref_scale(cos(turn), aim), ref_scale(sin(turn), up))};
    const ref_vec way = ref_sub(point, place);
    l.at[0] = ref_dot(way, l.x);
    l.at[1] = ref_dot(way, l.y);
    l.at[2] = ref_dot(way, l.forward);
    if (!(l.at[2] > 0)) return l;
    if (isnan(p->fanAngle)) {
        l.distance = l.at[2];
        l.irradiance = section(p, 0, l.distance, l.at[0]) * section(p, 1, l.distance, l.at[1]);
        return l;
    }
    const double angle = atan(l.at[0] / l.at[2]);
    l.distance = hypot(l.at[0], l.at[2]);
    l.bend = 2 * tan(p->fanAngle / 2) * p->straightness * pow(2 * angle / p->fanAngle, 2);
    l.irradiance = fan_at(scene, p, angle) / l.distance *
                   section(p, 1, l.distance, l.at[1] - l.bend * l.distance);
    return l;
}

bool ref_laser_at(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec point,
                  ref_random *random, ref_light *light) {
    const mcv_laser_params *p = &emitter->as.laser;
    double all = 0;
    for (uint32_t i = 0; i < p->lineCount; ++i) all += line_at(scene, emitter, i, point).irradiance;
    if (!(all > 0)) return false;
    double left = ref_random_unit(random) * all;
    line l = {0};
    for (uint32_t i = 0; i < p->lineCount && left >= 0; ++i) {
        const line next = line_at(scene, emitter, i, point);
        if (next.irradiance > 0) l = next;
        left -= next.irradiance;
    }
    const double radius = sqrt(-2 * log(1 - ref_random_unit(random))),
                 turn = 2 * M_PI * ref_random_unit(random);
    const double up =
        l.bend + slope_at(p, 1, l.distance, l.at[1] - l.bend * l.distance, radius * sin(turn));
    const bool is_beam = isnan(p->fanAngle);
    const double aside = is_beam ? slope_at(p, 0, l.distance, l.at[0], radius * cos(turn)) : 0;
    /* From the point back to where the ray leaves the window. */
    const double x = is_beam ? -aside * l.distance : -l.at[0], z = is_beam ? l.distance : l.at[2];
    const ref_vec back = ref_add(
        ref_scale(x, l.x), ref_sub(ref_scale(-up * l.distance, l.y), ref_scale(z, l.forward)));
    light->distance = ref_length(back);
    light->direction = ref_unit(back);
    for (int channel = 0; channel < 3; ++channel)
        light->irradiance[channel] *= all / p->lineCount * light->distance / l.distance;
    return true;
}
