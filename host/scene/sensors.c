/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/sensors.h"

#include "scene/aperture.h"
#include "scene/illumination.h"
#include "scene/laser.h"
#include "scene/lens_map.h"
#include "scene/motion.h"
#include "scene/params.h"

/* --- what is read out --- */

/* The parameters of the readout, of any sensor; resolution counts macro pixels of `angular` pixels
 * each. */
typedef struct film {
    const uint32_t *resolution, *region, *binning;
    const double *principal_point, *pixel_size;
    uint32_t angular[2];
} film;

#define MCV_FILM(p) \
    ((film){(p)->resolution, \
            (p)->regionOfInterest, \
            (p)->binning, \
            (p)->principalPoint, \
            (p)->pixelSize, \
            {1, 1}})

static film light_field_film(const mcv_light_field_params *p) {
    return (film){p->spatialResolution, p->regionOfInterest,
                  p->binning,           p->principalPoint,
                  p->pixelSize,         {p->angularResolution[0], p->angularResolution[1]}};
}

static const void *parameter(const mcv_sensor *sensor, const char *key) {
    return mcv_params_find(mcv_sensor_table(sensor->type), key, &sensor->as);
}

static film film_of(const mcv_sensor *sensor) {
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD) return light_field_film(&sensor->as.light_field);
    return (film){parameter(sensor, "resolution"), parameter(sensor, "regionOfInterest"),
                  parameter(sensor, "binning"),    parameter(sensor, "principalPoint"),
                  parameter(sensor, "pixelSize"),  {1, 1}};
}

static mcv_readout read_out(film f) {
    mcv_readout readout;
    for (int i = 0; i < 2; ++i) {
        const bool all = f.region[0] == MCV_NONE;
        readout.film[i] = f.resolution[i];
        readout.first[i] = all ? 0 : f.region[i];
        readout.binning[i] = f.binning[i];
        readout.size[i] = (all ? f.resolution[i] : f.region[i + 2]) / f.binning[i];
        readout.angular[i] = f.angular[i];
        readout.pitch[i] = f.angular[i] * f.pixel_size[i];
        readout.centre[i] = isnan(f.principal_point[0]) ? f.resolution[i] / 2.0
                                                        : f.principal_point[i] / f.angular[i];
    }
    return readout;
}

mcv_readout mcv_sensor_readout(const mcv_sensor *sensor) { return read_out(film_of(sensor)); }

static mcv_result check_film(film f, const mcv_json_path *place, mcv_error *error) {
    static const char *const lines[] = {"columns", "rows"};
    const mcv_json_path region = mcv_json_path_key(place, "regionOfInterest"),
                        binning = mcv_json_path_key(place, "binning");
    const bool all = f.region[0] == MCV_NONE;
    for (int i = 0; i < 2; ++i) {
        const uint32_t first = all ? 0 : f.region[i],
                       size = all ? f.resolution[i] : f.region[i + 2];
        if (size == 0)
            return mcv_fail_at(&region, error, "has no %s: it is [column, row, width, height]",
                               lines[i]);
        if (first + size > f.resolution[i])
            return mcv_fail_at(
                &region, error,
                "%s %u to %u exceed the film, which has %u: it is [column, row, width, height]",
                lines[i], first, first + size, f.resolution[i]);
        if (size % f.binning[i] != 0)
            return mcv_fail_at(&binning, error, "%u does not divide the %u %s that are read out",
                               f.binning[i], size, lines[i]);
    }
    return MCV_OK;
}

/* The principal point, from the first pixel that is read out, in binned pixels. */
static mcv_centre centre(const mcv_readout *readout, int axis, uint32_t binning) {
    const double from_first = (readout->centre[axis] - readout->first[axis]) / binning;
    const double halves = rint(2 * from_first);
    return (mcv_centre){(int)halves, (float)(from_first - halves / 2)};
}

/* --- pinhole --- */

mcv_result mcv_pinhole_resolve(mcv_pinhole_params *params, const mcv_json_path *place,
                               mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "radiometry");
    if (params->radiometry == MCV_RADIOMETRY_RADIANCE) return MCV_OK;
    return mcv_fail_at(
        &here, error,
        "a pinhole has no aperture, so no irradiance: use \"radiance\" or a thinLens");
}

void mcv_pinhole_prepare(const mcv_pinhole_params *params, mcv_pinhole *device) {
    const mcv_readout readout = read_out(MCV_FILM(params));
    *device = (mcv_pinhole){
        .centre_x = centre(&readout, 0, readout.binning[0]),
        .centre_y = centre(&readout, 1, readout.binning[1]),
        .slope_x = (float)(readout.binning[0] * params->pixelSize[0] / params->imageDistance),
        .slope_y = (float)(readout.binning[1] * params->pixelSize[1] / params->imageDistance),
    };
    mcv_distortion_prepare(&params->tilt, params->imageDistance, &device->distortion);
}

/* --- what agrees --- */

/*
 * Derived values may be given too, rounded: the tolerance is half a unit in the fourth digit of a
 * datasheet's number. Larger differences are contradictions.
 */
static const double agreement = 5e-4;

static mcv_result settle(double *value, double follows, const char *key, const char *from,
                         const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, key);
    if (isnan(*value))
        *value = follows;
    else if (!(fabs(*value - follows) <=
               agreement *
                   *value)) /* a given value never agrees with an infinite or negative one */
        return mcv_fail_at(
            &here, error,
            "%.6g contradicts %s, from which %.6g follows: give one of them, or equal "
            "values",
            *value, from, follows);
    return MCV_OK;
}

/* --- thin lens --- */

/* A/h² if irradiance is measured, else 0. */
static double etendue(int radiometry, double area, double distance) {
    return radiometry == MCV_RADIOMETRY_IRRADIANCE ? area / (distance * distance) : 0;
}

/* 1/f for falloff by image-side angles, else 0. */
static double bend(int falloff, double focal_length) {
    return falloff == MCV_FALLOFF_IMAGE_SIDE ? 1 / focal_length : 0;
}

static double disk_area(double diameter) { return M_PI / 4 * diameter * diameter; }

mcv_result mcv_lens_resolve(mcv_lens l, const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path focus = mcv_json_path_key(place, "focusDistance");
    if (isnan(*l.b) && isnan(*l.w))
        return mcv_fail_at(place, error, "needs imageDistance or focusDistance for its focus");
    if (*l.w <= l.f)
        return mcv_fail_at(&focus, error, "%g m must exceed focalLength %g m", *l.w, l.f);
    if (isnan(*l.b)) *l.b = l.f * *l.w / (*l.w - l.f);
    const double depth = 1 / mcv_kappa(l.f, *l.b);
    if (!isnan(*l.w) || (depth > 0 && isfinite(depth)))
        MCV_TRY(settle(l.w, depth, "focusDistance", "focalLength and imageDistance", place, error));

    if (isnan(*l.diameter) && isnan(*l.f_number))
        return mcv_fail_at(place, error, "needs lensDiameter or fNumber for its aperture");
    if (isnan(*l.diameter)) *l.diameter = *l.b / *l.f_number;
    return settle(l.f_number, *l.b / *l.diameter, "fNumber", "imageDistance and lensDiameter",
                  place, error);
}

mcv_result mcv_thin_lens_resolve(mcv_thin_lens_params *p, const mcv_json_path *place,
                                 mcv_error *error) {
    return mcv_lens_resolve((mcv_lens){p->focalLength, &p->imageDistance, &p->focusDistance,
                                       &p->lensDiameter, &p->fNumber},
                            place, error);
}

void mcv_thin_lens_prepare(const mcv_thin_lens_params *params, mcv_thin_lens *device) {
    const mcv_readout readout = read_out(MCV_FILM(params));
    *device = (mcv_thin_lens){
        .centre_x = centre(&readout, 0, readout.binning[0]),
        .centre_y = centre(&readout, 1, readout.binning[1]),
        .slope_x = (float)(readout.binning[0] * params->pixelSize[0] / params->imageDistance),
        .slope_y = (float)(readout.binning[1] * params->pixelSize[1] / params->imageDistance),
        .kappa = (float)mcv_kappa(params->focalLength, params->imageDistance),
        .radius = (float)(params->lensDiameter / 2),
        .etendue = (float)etendue(params->radiometry, disk_area(params->lensDiameter),
                                  params->imageDistance),
        .bend = (float)bend(params->falloff, params->focalLength),
    };
    mcv_distortion_prepare(&params->tilt, params->imageDistance, &device->distortion);
    mcv_aperture_prepare(&MCV_APERTURE_SHAPE_OF(params),
                         params->radiometry == MCV_RADIOMETRY_IRRADIANCE, &device->aperture);
}

/* --- telecentric --- */

/*
 * Derives f and b from any two of f, b, m, W; settle() compares the others with them. If more are
 * given, f and b have precedence, because they are the report's parameters.
 */
static mcv_result resolve_distances(mcv_telecentric_params *p, const char **from,
                                    const mcv_json_path *place, mcv_error *error) {
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
        const mcv_json_path here = mcv_json_path_key(place, "workingDistance");
        if (w <= p->focalLength)
            return mcv_fail_at(&here, error, "%g m must exceed focalLength %g m", w,
                               p->focalLength);
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
        return mcv_fail_at(place, error,
                           "a telecentric camera needs two of focalLength, imageDistance, "
                           "magnification, workingDistance");
    }
    const mcv_json_path here = mcv_json_path_key(place, "imageDistance");
    if (p->imageDistance > p->focalLength) return MCV_OK;
    return mcv_fail_at(
        &here, error,
        "%g m must exceed focalLength %g m: the stop lies in the focal plane, the image behind it",
        p->imageDistance, p->focalLength);
}

mcv_result mcv_telecentric_resolve(mcv_telecentric_params *p, const mcv_json_path *place,
                                   mcv_error *error) {
    const char *from = NULL;
    MCV_TRY(resolve_distances(p, &from, place, error));
    const double f = p->focalLength, b = p->imageDistance;
    MCV_TRY(settle(&p->magnification, (b - f) / f, "magnification", from, place, error));
    MCV_TRY(settle(&p->workingDistance, b * f / (b - f), "workingDistance", from, place, error));

    const char *stop = "stopDiameter";
    if (isnan(p->stopDiameter)) {
        if (isnan(p->numericalAperture) && isnan(p->fNumber))
            return mcv_fail_at(
                place, error,
                "a telecentric camera needs stopDiameter, fNumber or numericalAperture");
        stop = isnan(p->numericalAperture) ? "fNumber" : "numericalAperture";
        p->stopDiameter =
            isnan(p->numericalAperture) ? (b - f) / p->fNumber : 2 * f * p->numericalAperture;
    }
    MCV_TRY(settle(&p->numericalAperture, p->stopDiameter / (2 * f), "numericalAperture", stop,
                   place, error));
    MCV_TRY(settle(&p->fNumber, (b - f) / p->stopDiameter, "fNumber", stop, place, error));
    return MCV_OK;
}

/* A lens that passes all that the whole film sees through the stop. */
static void derive_lens_diameter(mcv_sensor *sensor) {
    mcv_telecentric_params *p = &sensor->as.telecentric;
    const mcv_readout readout = read_out(MCV_FILM(p));
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    const double h = p->imageDistance - p->focalLength;
    if (!mcv_lens_map_is_used(&map)) {
        /* The field about the axis; its diagonal where the principal point is in the middle. */
        double corner[2];
        for (int i = 0; i < 2; ++i)
            corner[i] =
                fmax(readout.centre[i], readout.film[i] - readout.centre[i]) * p->pixelSize[i];
        p->lensDiameter = 2 * hypot(corner[0], corner[1]) / p->magnification +
                          2 * p->workingDistance * p->numericalAperture;
        return;
    }
    p->lensDiameter = 0;
    for (int corner = 0; corner < 4; ++corner) {
        double at[2], u[2], stretch;
        for (int i = 0; i < 2; ++i)
            at[i] = ((corner >> i & 1 ? readout.film[i] : 0) - readout.centre[i]) *
                    readout.pitch[i] / h;
        mcv_lens_map_look(&map, at, u, &stretch);
        p->lensDiameter =
            fmax(p->lensDiameter, 2 * p->focalLength * hypot(u[0], u[1]) +
                                      p->stopDiameter * (1 + p->focalLength / (h * stretch)));
    }
}

void mcv_telecentric_prepare(const mcv_telecentric_params *params, mcv_telecentric *device) {
    const double f = params->focalLength, b = params->imageDistance;
    const mcv_readout readout = read_out(MCV_FILM(params));
    *device = (mcv_telecentric){
        .centre_x = centre(&readout, 0, readout.binning[0]),
        .centre_y = centre(&readout, 1, readout.binning[1]),
        .pixel_x = (float)(readout.binning[0] * params->pixelSize[0] * f / (b - f)),
        .pixel_y = (float)(readout.binning[1] * params->pixelSize[1] * f / (b - f)),
        .stop_radius = (float)(params->stopDiameter / 2),
        .stop_to_lens = (float)(b / (b - f)),
        .stop_to_direction = (float)(1 / f),
        .lens_radius = (float)(params->lensDiameter / 2),
        .etendue = (float)etendue(params->radiometry, disk_area(params->stopDiameter), b - f),
        .bend = (float)bend(params->falloff, f),
    };
    mcv_distortion_prepare(&params->tilt, b - f, &device->distortion);
    mcv_illumination_prepare(&params->relativeIllumination, b - f, &device->distortion);
    mcv_aperture_prepare(&MCV_APERTURE_SHAPE_OF(params),
                         params->radiometry == MCV_RADIOMETRY_IRRADIANCE, &device->aperture);
}

/* --- light field --- */

mcv_result mcv_light_field_resolve(mcv_light_field_params *p, const mcv_json_path *place,
                                   mcv_error *error) {
    return mcv_lens_resolve((mcv_lens){p->focalLength, &p->imageDistance, &p->focusDistance,
                                       &p->lensDiameter, &p->fNumber},
                            place, error);
}

void mcv_light_field_prepare(const mcv_light_field_params *params, mcv_light_field *device) {
    const double d = params->lensDiameter, b = params->imageDistance;
    const mcv_readout readout = read_out(light_field_film(params));
    *device = (mcv_light_field){
        .centre_x = centre(&readout, 0, 1),
        .centre_y = centre(&readout, 1, 1),
        .binning_x = readout.binning[0],
        .binning_y = readout.binning[1],
        .angular_width = params->angularResolution[0],
        .angular_height = params->angularResolution[1],
        .slope_x = (float)(readout.pitch[0] / b),
        .slope_y = (float)(readout.pitch[1] / b),
        .kappa = (float)mcv_kappa(params->focalLength, b),
        .radius = (float)(d / 2),
        .etendue = (float)etendue(params->radiometry, d * d, b),
        .bend = (float)bend(params->falloff, params->focalLength),
        .circle = params->aperture == MCV_APERTURE_CIRCLE,
    };
}

/* --- flying spot --- */

void mcv_flying_spot_prepare(const mcv_flying_spot_params *params, mcv_flying_spot *device) {
    const mcv_readout readout = read_out(MCV_FILM(params));
    const mcv_laser_beam beam = mcv_flying_spot_beam(params);
    *device = (mcv_flying_spot){
        .centre_x = centre(&readout, 0, 1),
        .centre_y = centre(&readout, 1, 1),
        .pixel_x = (float)params->pixelSize[0],
        .pixel_y = (float)params->pixelSize[1],
        .spot = {(float)(beam.waist[0] / 2), (float)(beam.waist[1] / 2)},
        .slope = {(float)(beam.divergence[0] / 2), (float)(beam.divergence[1] / 2)},
        .distance = (float)params->workingDistance,
    };
}

/* --- all --- */

mcv_result mcv_sensor_resolve(mcv_sensor *sensor, const mcv_json_path *place, mcv_error *error) {
    MCV_TRY(mcv_params_check(mcv_sensor_table(sensor->type), &sensor->as, place, error));
    MCV_TRY(check_film(film_of(sensor), place, error));
    switch (sensor->type) {
#define MCV_X(name, key, NAME) \
    case MCV_SENSOR_##NAME: \
        MCV_TRY(mcv_##name##_resolve(&sensor->as.name, place, error)); \
        break;
        MCV_SENSORS(MCV_X)
#undef MCV_X
    }
    MCV_TRY(mcv_sensor_resolve_aperture(sensor, place, error));
    MCV_TRY(mcv_sensor_resolve_exposure(sensor, place, error));
    MCV_TRY(mcv_sensor_resolve_distortion(sensor, place, error));
    const mcv_readout readout = read_out(film_of(sensor));
    if (sensor->type == MCV_SENSOR_TELECENTRIC)
        MCV_TRY(mcv_illumination_check(&sensor->as.telecentric, &readout, place, error));
    if (sensor->type == MCV_SENSOR_TELECENTRIC && isnan(sensor->as.telecentric.lensDiameter))
        derive_lens_diameter(sensor);
    /* Checks the derived values too. */
    return mcv_params_check(mcv_sensor_table(sensor->type), &sensor->as, place, error);
}

void mcv_sensor_film_size(const mcv_sensor *sensor, uint32_t *width, uint32_t *height) {
    const mcv_readout readout = mcv_sensor_readout(sensor);
    *width = readout.size[0] * readout.angular[0];
    *height = readout.size[1] * readout.angular[1];
}
