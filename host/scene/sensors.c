/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/sensors.h"

#include "scene/params.h"

/* --- pinhole ---------------------------------------------------------------------------------------------------- */

mcv_result mcv_pinhole_resolve(mcv_pinhole_params *params, const mcv_place *place, mcv_error *error) {
    const mcv_place here = mcv_place_key(place, "radiometry");
    if (params->radiometry == MCV_RADIOMETRY_RADIANCE) return MCV_OK;
    return mcv_fail_at(&here, error, "a pinhole has no aperture, so no irradiance: use \"radiance\" or a thinLens");
}

void mcv_pinhole_prepare(const mcv_pinhole_params *params, mcv_pinhole *device) {
    *device = (mcv_pinhole){
        .width = params->resolution[0],
        .height = params->resolution[1],
        .slope_x = (float)(params->pixelSize[0] / params->imageDistance),
        .slope_y = (float)(params->pixelSize[1] / params->imageDistance),
    };
}

/* --- what agrees ------------------------------------------------------------------------------------------------- */

/*
 * Values that follow from others may be given too, rounded: half a unit in the fourth digit of a datasheet's number. What
 * differs by more contradicts.
 */
static const double agreement = 5e-4;

static mcv_result settle(double *value, double follows, const char *key, const char *from, const mcv_place *place, mcv_error *error) {
    const mcv_place here = mcv_place_key(place, key);
    if (isnan(*value))
        *value = follows;
    else if (!(fabs(*value - follows) <= agreement * *value)) /* nothing given agrees with an infinite or negative one */
        return mcv_fail_at(&here, error, "%.6g contradicts %s, from which %.6g follows: give one of them, or both alike", *value, from,
                           follows);
    return MCV_OK;
}

/* --- thin lens -------------------------------------------------------------------------------------------------- */

/* κ = (b - f)/(b f), the inverse of the focused depth. */
static double kappa(double focal_length, double image_distance) {
    return (image_distance - focal_length) / (image_distance * focal_length);
}

/* A/h² where irradiance is measured, else 0. */
static double etendue(int radiometry, double area, double distance) {
    return radiometry == MCV_RADIOMETRY_IRRADIANCE ? area / (distance * distance) : 0;
}

static double disk_area(double diameter) { return M_PI / 4 * diameter * diameter; }

/* The parameters that MCV_LENS_PARAMS gives two sensors. */
typedef struct lens {
    double f, *b, *w, *diameter, *f_number;
} lens;

/* b and D_l from what stands for them, and the other way round. A focus at infinity or behind the lens has no focusDistance. */
static mcv_result resolve_lens(lens l, const mcv_place *place, mcv_error *error) {
    const mcv_place focus = mcv_place_key(place, "focusDistance");
    if (isnan(*l.b) && isnan(*l.w)) return mcv_fail_at(place, error, "needs imageDistance or focusDistance, to say where it is in focus");
    if (*l.w <= l.f) return mcv_fail_at(&focus, error, "%g m must exceed focalLength %g m", *l.w, l.f);
    if (isnan(*l.b)) *l.b = l.f * *l.w / (*l.w - l.f);
    const double depth = 1 / kappa(l.f, *l.b);
    if (!isnan(*l.w) || (depth > 0 && isfinite(depth)))
        MCV_TRY(settle(l.w, depth, "focusDistance", "focalLength and imageDistance", place, error));

    if (isnan(*l.diameter) && isnan(*l.f_number))
        return mcv_fail_at(place, error, "needs lensDiameter or fNumber, to say how wide it is open");
    if (isnan(*l.diameter)) *l.diameter = *l.b / *l.f_number;
    return settle(l.f_number, *l.b / *l.diameter, "fNumber", "imageDistance and lensDiameter", place, error);
}

mcv_result mcv_thin_lens_resolve(mcv_thin_lens_params *p, const mcv_place *place, mcv_error *error) {
    return resolve_lens((lens){p->focalLength, &p->imageDistance, &p->focusDistance, &p->lensDiameter, &p->fNumber}, place, error);
}

void mcv_thin_lens_prepare(const mcv_thin_lens_params *params, mcv_thin_lens *device) {
    *device = (mcv_thin_lens){
        .width = params->resolution[0],
        .height = params->resolution[1],
        .slope_x = (float)(params->pixelSize[0] / params->imageDistance),
        .slope_y = (float)(params->pixelSize[1] / params->imageDistance),
        .kappa = (float)kappa(params->focalLength, params->imageDistance),
        .radius = (float)(params->lensDiameter / 2),
        .etendue = (float)etendue(params->radiometry, disk_area(params->lensDiameter), params->imageDistance),
    };
}

/* --- telecentric ------------------------------------------------------------------------------------------------ */

/*
 * f and b from any two of f, b, m, W; settle() compares the rest with them. Where more are given f and b count first: they
 * are the report's parameters.
 */
static mcv_result resolve_distances(mcv_telecentric_params *p, const char **from, const mcv_place *place, mcv_error *error) {
    const double m = p->magnification, w = p->workingDistance;
    const bool f = !isnan(p->focalLength), b = !isnan(p->imageDistance);
    if (f && b) {
        *from = "focalLength and imageDistance";
    } else if (f && !isnan(m)) {
        *from = "focalLength and magnification";
        p->imageDistance = p->focalLength * (1 + m);
    } else if (b && !isnan(m)) {
        *from = "imageDistance and magnification";
        p->focalLength = p->imageDistance / (1 + m);
    } else if (f && !isnan(w)) {
        const mcv_place here = mcv_place_key(place, "workingDistance");
        if (w <= p->focalLength) return mcv_fail_at(&here, error, "%g m must exceed focalLength %g m", w, p->focalLength);
        *from = "focalLength and workingDistance";
        p->imageDistance = p->focalLength * w / (w - p->focalLength);
    } else if (b && !isnan(w)) {
        *from = "imageDistance and workingDistance";
        p->focalLength = p->imageDistance * w / (p->imageDistance + w);
    } else if (!isnan(m) && !isnan(w)) {
        *from = "magnification and workingDistance";
        p->focalLength = w * m / (1 + m);
        p->imageDistance = w * m;
    } else {
        return mcv_fail_at(place, error, "a telecentric camera needs two of focalLength, imageDistance, magnification, workingDistance");
    }
    const mcv_place here = mcv_place_key(place, "imageDistance");
    if (p->imageDistance > p->focalLength) return MCV_OK;
    return mcv_fail_at(&here, error, "%g m must exceed focalLength %g m: the stop lies in the focal plane, the image behind it",
                       p->imageDistance, p->focalLength);
}

mcv_result mcv_telecentric_resolve(mcv_telecentric_params *p, const mcv_place *place, mcv_error *error) {
    const char *from = NULL;
    MCV_TRY(resolve_distances(p, &from, place, error));
    const double f = p->focalLength, b = p->imageDistance;
    MCV_TRY(settle(&p->magnification, (b - f) / f, "magnification", from, place, error));
    MCV_TRY(settle(&p->workingDistance, b * f / (b - f), "workingDistance", from, place, error));

    const char *stop = "stopDiameter";
    if (isnan(p->stopDiameter)) {
        if (isnan(p->numericalAperture) && isnan(p->fNumber))
            return mcv_fail_at(place, error, "a telecentric camera needs stopDiameter, fNumber or numericalAperture");
        stop = isnan(p->numericalAperture) ? "fNumber" : "numericalAperture";
        p->stopDiameter = isnan(p->numericalAperture) ? (b - f) / p->fNumber : 2 * f * p->numericalAperture;
    }
    MCV_TRY(settle(&p->numericalAperture, p->stopDiameter / (2 * f), "numericalAperture", stop, place, error));
    MCV_TRY(settle(&p->fNumber, (b - f) / p->stopDiameter, "fNumber", stop, place, error));

    if (isnan(p->lensDiameter)) {
        const double diagonal = hypot(p->resolution[0] * p->pixelSize[0], p->resolution[1] * p->pixelSize[1]) / p->magnification;
        p->lensDiameter = diagonal + 2 * p->workingDistance * p->numericalAperture;
    }
    return MCV_OK;
}

void mcv_telecentric_prepare(const mcv_telecentric_params *params, mcv_telecentric *device) {
    const double f = params->focalLength, b = params->imageDistance;
    *device = (mcv_telecentric){
        .width = params->resolution[0],
        .height = params->resolution[1],
        .pixel_x = (float)(params->pixelSize[0] * f / (b - f)),
        .pixel_y = (float)(params->pixelSize[1] * f / (b - f)),
        .stop_radius = (float)(params->stopDiameter / 2),
        .stop_to_lens = (float)(b / (b - f)),
        .stop_to_direction = (float)(1 / f),
        .lens_radius = (float)(params->lensDiameter / 2),
        .etendue = (float)etendue(params->radiometry, disk_area(params->stopDiameter), b - f),
    };
}

/* --- light field ------------------------------------------------------------------------------------------------ */

mcv_result mcv_light_field_resolve(mcv_light_field_params *p, const mcv_place *place, mcv_error *error) {
    return resolve_lens((lens){p->focalLength, &p->imageDistance, &p->focusDistance, &p->lensDiameter, &p->fNumber}, place, error);
}

void mcv_light_field_prepare(const mcv_light_field_params *params, mcv_light_field *device) {
    const double d = params->lensDiameter, b = params->imageDistance;
    *device = (mcv_light_field){
        .macro_width = params->spatialResolution[0],
        .macro_height = params->spatialResolution[1],
        .angular_width = params->angularResolution[0],
        .angular_height = params->angularResolution[1],
        .slope_x = (float)(params->angularResolution[0] * params->pixelSize[0] / b),
        .slope_y = (float)(params->angularResolution[1] * params->pixelSize[1] / b),
        .kappa = (float)kappa(params->focalLength, b),
        .radius = (float)(d / 2),
        .etendue = (float)etendue(params->radiometry, d * d, b),
        .circle = params->aperture == MCV_APERTURE_CIRCLE,
    };
}

/* --- all -------------------------------------------------------------------------------------------------------- */

mcv_result mcv_sensor_resolve(mcv_sensor *sensor, const mcv_place *place, mcv_error *error) {
    MCV_TRY(mcv_params_check(mcv_sensor_table(sensor->type), &sensor->as, place, error));
    switch (sensor->type) {
#define MCV_X(name, key, NAME) \
    case MCV_SENSOR_##NAME: \
        MCV_TRY(mcv_##name##_resolve(&sensor->as.name, place, error)); \
        break;
        MCV_SENSORS(MCV_X)
#undef MCV_X
    }
    /* Once more, for what has just been derived. */
    return mcv_params_check(mcv_sensor_table(sensor->type), &sensor->as, place, error);
}

void mcv_sensor_film_size(const mcv_sensor *sensor, uint32_t *width, uint32_t *height) {
    uint32_t size[2] = {0, 0};
    for (int i = 0; i < 2; ++i) switch (sensor->type) {
        case MCV_SENSOR_PINHOLE:
            size[i] = sensor->as.pinhole.resolution[i];
            break;
        case MCV_SENSOR_THIN_LENS:
            size[i] = sensor->as.thin_lens.resolution[i];
            break;
        case MCV_SENSOR_TELECENTRIC:
            size[i] = sensor->as.telecentric.resolution[i];
            break;
        case MCV_SENSOR_LIGHT_FIELD:
            size[i] = sensor->as.light_field.spatialResolution[i] * sensor->as.light_field.angularResolution[i];
            break;
        }
    *width = size[0];
    *height = size[1];
}

/*
 * Field, f-number, NA and depth of field of a lens of diameter D that images with (f, b) on `size` wide film whose pixels
 * are p: a point at depth z is blurred to b D |1/z - κ| on the film, so the limits are 1/z = κ ± blur, blur = p/(b D).
 */
static mcv_optics entocentric(double f, double b, double diameter, const double size[2], double blur) {
    const double k = kappa(f, b);
    mcv_optics optics = {
        .focused_depth = 1 / k,
        .magnification = b * k,
        .f_number = b / diameter,
        .numerical_aperture = fabs(diameter / 2 * k),
        .depth_of_field = {k + blur > 0 ? 1 / (k + blur) : NAN, k > blur       ? 1 / (k - blur)
                                                                : k + blur > 0 ? INFINITY
                                                                               : NAN},
        .macro_pixel = {NAN, NAN},
    };
    for (int i = 0; i < 2; ++i) {
        optics.field[i] = size[i] / fabs(b * k);
        optics.field_angle[i] = 2 * atan(size[i] / (2 * b));
    }
    return optics;
}

mcv_optics mcv_sensor_optics(const mcv_sensor *sensor) {
    uint32_t width, height;
    mcv_sensor_film_size(sensor, &width, &height);
    mcv_optics optics = {.focused_depth = NAN,
                         .magnification = NAN,
                         .field = {NAN, NAN},
                         .f_number = NAN,
                         .numerical_aperture = NAN,
                         .depth_of_field = {NAN, NAN},
                         .macro_pixel = {NAN, NAN}};
    switch (sensor->type) {
    case MCV_SENSOR_PINHOLE: {
        const mcv_pinhole_params *p = &sensor->as.pinhole;
        for (int i = 0; i < 2; ++i) optics.field_angle[i] = 2 * atan(p->resolution[i] * p->pixelSize[i] / (2 * p->imageDistance));
        break;
    }
    case MCV_SENSOR_THIN_LENS: {
        const mcv_thin_lens_params *p = &sensor->as.thin_lens;
        const double size[2] = {width * p->pixelSize[0], height * p->pixelSize[1]};
        const double blur = fmin(p->pixelSize[0], p->pixelSize[1]) / (p->imageDistance * p->lensDiameter);
        optics = entocentric(p->focalLength, p->imageDistance, p->lensDiameter, size, blur);
        break;
    }
    case MCV_SENSOR_LIGHT_FIELD: {
        const mcv_light_field_params *p = &sensor->as.light_field;
        const double size[2] = {width * p->pixelSize[0], height * p->pixelSize[1]};
        double blur[2];
        for (int i = 0; i < 2; ++i) {
            const double n = p->angularResolution[i];
            blur[i] = n * p->pixelSize[i] / (p->imageDistance * p->lensDiameter / n);
        }
        optics = entocentric(p->focalLength, p->imageDistance, p->lensDiameter, size, fmin(blur[0], blur[1]));
        for (int i = 0; i < 2; ++i) optics.macro_pixel[i] = p->angularResolution[i] * p->pixelSize[i];
        break;
    }
    case MCV_SENSOR_TELECENTRIC: {
        const mcv_telecentric_params *p = &sensor->as.telecentric;
        /* A point Δz out of focus is blurred to 2 m NA Δz on the film, before the plane in focus as behind it. */
        const double depth = fmin(p->pixelSize[0], p->pixelSize[1]) / (2 * p->magnification * p->numericalAperture);
        optics.focused_depth = p->workingDistance;
        optics.magnification = p->magnification;
        optics.f_number = p->fNumber;
        optics.numerical_aperture = p->numericalAperture;
        for (int i = 0; i < 2; ++i) optics.field[i] = p->resolution[i] * p->pixelSize[i] / p->magnification;
        optics.depth_of_field[0] = fmax(0, p->workingDistance - depth);
        optics.depth_of_field[1] = p->workingDistance + depth;
        break;
    }
    }
    return optics;
}
