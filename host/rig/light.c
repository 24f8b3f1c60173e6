/* SPDX-License-Identifier: Apache-2.0 */
/* Position and size of a rig's light: outside the camera's view, and large enough for the part. */
#include "rig/rig.h"

#include <math.h>

/* The diameter of the lens; of a light field camera the diagonal. */
static double lens_diameter(const mcv_rig_design *r) {
    const double side = r->focal_length * (1 + r->magnification) / r->f_number; /* b/N */
    return r->directions > 1 ? M_SQRT2 * side : side;
}

/* The diameter of the view at a distance: the field there plus the bundle of rays of each of its
 * points. */
static double widen(const mcv_rig_design *r, double field, double distance) {
    if (r->wishes.kind == MCV_RIG_TELECENTRIC)
        return field + fabs(distance) * r->magnification / r->f_number; /* 2 NA */
    const double share = distance / r->working_distance;
    return field * (1 - share) + lens_diameter(r) * fabs(share);
}

double mcv_rig_view(const mcv_rig_design *r, double distance) {
    return widen(r, hypot(r->field[0], r->field[1]), distance);
}

double mcv_rig_view_side(const mcv_rig_design *r, int axis, double distance) {
    return widen(r, r->field[axis], distance);
}

/*
 * The radius, on the square lens, of a parallel panel's cone. From a place on the part it lies
 * about that place. It stays within the lens wherever the part is: what of it leaves the lens shows
 * no deflection. Half the lens is the least, so that a deflection may be as large; of a small lens,
 * so much that light from the field's corner comes to it.
 */
static double cone_on_lens(const mcv_rig_design *r) {
    const double half = 0.5 * lens_diameter(r) / M_SQRT2;
    return fmax(fmax(0.5 * half, half - 0.5 * fmax(r->across[0], r->across[1])),
                0.525 * hypot(r->field[0], r->field[1]) - 0.5 * half);
}

/*
 * A light behind the part. Telecentric: a parallel panel with a cone slightly wider than the
 * camera's. Transparent: a parallel panel whose cone has its edge within the J x K directions, so
 * that a deflection shifts it in full. Otherwise a diffuse panel that fills the view.
 */
static void behind(mcv_rig_design *r, mcv_rig_light *light) {
    const double degrees = 180 / M_PI;
    light->distance = 0.5 * r->depth + 0.5 * r->field[0];
    for (int i = 0; i < 2; ++i)
        light->size[i] = 1.2 * (r->wishes.kind == MCV_RIG_TELECENTRIC
                                    ? r->field[i]
                                    : mcv_rig_view_side(r, i, -light->distance));
    if (r->wishes.kind == MCV_RIG_TELECENTRIC)
        light->half_angle = fmin(
            90, mcv_rig_usual(1.2 * degrees * asin(fmin(1, r->magnification / (2 * r->f_number))),
                              true));
    if (r->wishes.kind == MCV_RIG_TRANSPARENT)
        light->half_angle = degrees * atan(cone_on_lens(r) / r->working_distance);
}

/* A flat ring around the view, half-way to the camera. */
static void around(const mcv_rig_design *r, mcv_rig_light *light) {
    light->distance = 0.5 * (r->working_distance + 0.5 * r->depth);
    light->inner = mcv_rig_usual(1.1 * mcv_rig_view(r, light->distance), true);
    light->outer = 1.6 * light->inner;
    light->reach = light->distance;
}

/* A low ring close to the part's front. Seen from the middle of the part, its band faces the part
 * and spans 7° to 23° of elevation, with its centre at 15°. */
static void low(const mcv_rig_design *r, mcv_rig_light *light) {
    const double radius = mcv_rig_usual(
        1.3 * 0.5 * fmax(mcv_rig_view(r, 0.5 * r->depth), mcv_rig_view(r, -0.5 * r->depth)), true);
    const double elevation = 15, half = 0.15 * radius;
    light->distance = 0.5 * r->depth + radius * tan(elevation * M_PI / 180);
    light->inner = 2 * (radius - half);
    light->outer = 2 * (radius + half);
    light->tilt = 90 - elevation;
    light->reach = light->distance + half;
}

/*
 * A half mirror before the part, at a tenth of the window's height from it. Window and panel are as
 * large as the panel would appear in a mirror in the part's place: the view, at the distance of the
 * panel's image. A cone keeps light that misses the half mirror off the part.
 */
static void along(const mcv_rig_design *r, mcv_rig_light *light) {
    light->size[0] = light->size[1] = 0;
    for (int i = 0; i < 50;
         ++i) { /* until it converges; for a camera that is too near the size diverges */
        light->distance = 0.5 * r->depth + 0.6 * light->size[1];
        const double way = light->distance + 0.55 * light->size[1];
        for (int k = 0; k < 2; ++k)
            light->size[k] =
                fmin(1.1 * fmax(mcv_rig_view_side(r, k, -way), mcv_rig_view_side(r, k, way)),
                     10 * r->working_distance);
    }
    light->half_angle = 30;
    light->reach = light->distance + 0.5 * light->size[1];
}

/* A dome with its opening at the part's front, three times as wide as its hole: a ninth of the
 * light is missing. */
static void over(const mcv_rig_design *r, mcv_rig_light *light) {
    double radius = 0;
    for (int i = 0; i < 50; ++i) {
        const double top = 0.5 * r->depth + radius;
        light->inner = 1.1 * fmax(mcv_rig_view(r, top), mcv_rig_view(r, 0.5 * r->depth));
        radius =
            fmin(0.5 * mcv_rig_usual(
                           fmax(3 * light->inner, 1.5 * hypot(r->across[0], r->across[1])), true),
                 10 * r->working_distance);
    }
    light->outer = 2 * radius;
    light->distance = 0.5 * r->depth;
    light->reach = light->distance + radius;
}

/*
 * A laser line from where the camera would look. On the film its standard deviation is a pixel, and
 * its waist stays within the part's depth; its fan is wider than the part.
 */
static void line(const mcv_rig_design *r, mcv_rig_light *light) {
    const double on_film = 4 * r->pixel / (r->magnification * cos(MCV_RIG_ANGLE * (M_PI / 180))),
                 waist = 2 * sqrt(MCV_RIG_WAVELENGTH * r->depth / (2 * M_PI));
    light->distance = r->working_distance;
    light->size[0] = mcv_rig_usual(fmax(on_film, waist), true);
    light->half_angle = 180 / M_PI * atan(0.65 * r->across[0] / (light->distance - 0.5 * r->depth));
}

void mcv_rig_choose_light(mcv_rig_design *r) {
    const bool back =
        r->wishes.kind == MCV_RIG_TELECENTRIC || r->wishes.kind == MCV_RIG_TRANSPARENT;
    r->light = (mcv_rig_light){.type = r->wishes.light};
    if (r->wishes.kind == MCV_RIG_LASER) r->light.type = MCV_RIG_LIGHT_LASER;
    if (r->light.type == MCV_RIG_LIGHT_AUTO)
        r->light.type = back ? MCV_RIG_LIGHT_BACKLIGHT : MCV_RIG_LIGHT_RING;
    switch (r->light.type) {
    case MCV_RIG_LIGHT_RING:
        around(r, &r->light);
        break;
    case MCV_RIG_LIGHT_DARK_FIELD:
        low(r, &r->light);
        break;
    case MCV_RIG_LIGHT_COAXIAL:
        along(r, &r->light);
        break;
    case MCV_RIG_LIGHT_DOME:
        over(r, &r->light);
        break;
    case MCV_RIG_LIGHT_LASER:
        line(r, &r->light);
        break;
    default:
        behind(r, &r->light);
        break;
    }
}
