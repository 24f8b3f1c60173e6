/* SPDX-License-Identifier: Apache-2.0 */
/* mcv_sensor_optics: the quantities of a datasheet. */
#include "scene/lens_map.h"
#include "scene/sensors.h"

/* Width and height of the region that is read out, and the distance of the pixels at its edges from
 * the principal point [m]. */
typedef struct image_area {
    double size[2], edge[2][2];
} image_area;

static image_area area_of(const mcv_readout *readout) {
    image_area area;
    for (int i = 0; i < 2; ++i) {
        const double read = (double)readout->size[i] * readout->binning[i];
        area.size[i] = read * readout->pitch[i];
        area.edge[i][0] = (readout->centre[i] - readout->first[i]) * readout->pitch[i];
        area.edge[i][1] = area.size[i] - area.edge[i][0];
    }
    return area;
}

static double field_angle(const image_area *area, int axis, double image_distance) {
    return atan(area->edge[axis][0] / image_distance) + atan(area->edge[axis][1] / image_distance);
}

/*
 * Field, f-number, NA and depth of field of a lens of diameter D that images with (f, b) on film
 * with pixels of size p. A point at depth z is blurred to b D |1/z - κ| on the film, so the limits
 * are 1/z = κ ± p/(b D).
 */
static mcv_optics entocentric(double f, double b, double diameter, const image_area *area,
                              double blur) {
    const double k = mcv_kappa(f, b);
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
        optics.field[i] = area->size[i] / fabs(b * k);
        optics.field_angle[i] = field_angle(area, i, b);
    }
    return optics;
}

/* The depth in focus where the film lies at e times its distance on the axis; infinite where it is
 * none. */
static double depth_in_focus(const mcv_sensor *sensor, double e) {
    if (sensor->type == MCV_SENSOR_TELECENTRIC) {
        const double f = sensor->as.telecentric.focalLength;
        return f * (1 + f / (mcv_sensor_film_distance(sensor) * e));
    }
    const double kappa =
        mcv_kappa(sensor->as.thin_lens.focalLength, sensor->as.thin_lens.imageDistance * e);
    return kappa > 0 ? 1 / kappa : INFINITY;
}

/* Scheimpflug: the plane in focus meets those of film and lens in one line. */
static void tilt_plane_in_focus(const mcv_sensor *sensor, const image_area *area,
                                mcv_optics *optics) {
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    const double h = mcv_sensor_film_distance(sensor);
    const double(*a)[3] = map.axes;
    const double facing = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    optics->object_tilt = NAN;
    for (int i = 0; i < 2; ++i) optics->plane_depths[i] = optics->focused_depth;
    if (!map.tilted || !(optics->magnification > 0)) return;
    optics->object_tilt = atan(sqrt(1 - facing * facing) / facing / optics->magnification);
    for (int corner = 0; corner < 4; ++corner) {
        const double x = corner & 1 ? area->edge[0][1] : -area->edge[0][0],
                     y = corner & 2 ? area->edge[1][1] : -area->edge[1][0],
                     depth = depth_in_focus(sensor, 1 + (x * a[0][2] + y * a[1][2]) / h);
        optics->plane_depths[0] = fmin(optics->plane_depths[0], depth);
        optics->plane_depths[1] = fmax(optics->plane_depths[1], depth);
    }
}

mcv_optics mcv_sensor_optics(const mcv_sensor *sensor) {
    const mcv_readout readout = mcv_sensor_readout(sensor);
    const image_area area = area_of(&readout);
    const double pixel =
        fmin(readout.binning[0] * readout.pitch[0], readout.binning[1] * readout.pitch[1]);
    mcv_optics optics = {.focused_depth = NAN,
                         .magnification = NAN,
                         .field = {NAN, NAN},
                         .f_number = NAN,
                         .numerical_aperture = NAN,
                         .depth_of_field = {NAN, NAN},
                         .macro_pixel = {NAN, NAN}};
    switch (sensor->type) {
    case MCV_SENSOR_PINHOLE:
        for (int i = 0; i < 2; ++i)
            optics.field_angle[i] = field_angle(&area, i, sensor->as.pinhole.imageDistance);
        break;
    case MCV_SENSOR_THIN_LENS: {
        const mcv_thin_lens_params *p = &sensor->as.thin_lens;
        const double blur = pixel / (p->imageDistance * p->lensDiameter);
        optics = entocentric(p->focalLength, p->imageDistance, p->lensDiameter, &area, blur);
        break;
    }
    case MCV_SENSOR_LIGHT_FIELD: {
        const mcv_light_field_params *p = &sensor->as.light_field;
        double blur[2];
        for (int i = 0; i < 2; ++i) {
            const double n = p->angularResolution[i];
            blur[i] =
                readout.binning[i] * n * p->pixelSize[i] / (p->imageDistance * p->lensDiameter / n);
        }
        optics = entocentric(p->focalLength, p->imageDistance, p->lensDiameter, &area,
                             fmin(blur[0], blur[1]));
        for (int i = 0; i < 2; ++i) optics.macro_pixel[i] = readout.pitch[i];
        break;
    }
    case MCV_SENSOR_TELECENTRIC: {
        const mcv_telecentric_params *p = &sensor->as.telecentric;
        /* A point Δz out of focus is blurred to 2 m NA Δz on the film, on both sides of the plane
         * in focus. */
        const double depth = pixel / (2 * p->magnification * p->numericalAperture);
        optics.focused_depth = p->workingDistance;
        optics.magnification = p->magnification;
        optics.f_number = p->fNumber;
        optics.numerical_aperture = p->numericalAperture;
        for (int i = 0; i < 2; ++i) optics.field[i] = area.size[i] / p->magnification;
        optics.depth_of_field[0] = fmax(0, p->workingDistance - depth);
        optics.depth_of_field[1] = p->workingDistance + depth;
        break;
    }
    case MCV_SENSOR_FLYING_SPOT:
        optics.focused_depth = sensor->as.flying_spot.workingDistance;
        optics.magnification = 1;
        for (int i = 0; i < 2; ++i) optics.field[i] = area.size[i];
        break;
    }
    tilt_plane_in_focus(sensor, &area, &optics);
    return optics;
}
