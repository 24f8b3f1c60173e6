/* SPDX-License-Identifier: Apache-2.0 */
/* Tilt and distortion of sensors: from parameters to maps. */
#include "scene/lens_map.h"

#include "scene/params.h"
#include "scene/sensors.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* The parameters of MCV_DISTORTION_PARAMS as they lie in those of each sensor: all are numbers. */
typedef struct params {
    MCV_DISTORTION_PARAMS(MCV_DEFINE_FIELD)
} params;

static params read_params(const void *from) {
    params p;
    memcpy(&p, from, sizeof p);
    return p;
}

/* NULL for a light field camera. */
static const void *params_of(const mcv_sensor *sensor) {
    switch (sensor->type) {
    case MCV_SENSOR_PINHOLE:
        return &sensor->as.pinhole.tilt;
    case MCV_SENSOR_THIN_LENS:
        return &sensor->as.thin_lens.tilt;
    case MCV_SENSOR_TELECENTRIC:
        return &sensor->as.telecentric.tilt;
    default:
        return NULL;
    }
}

static double or_0(double value) { return isnan(value) ? 0 : value; }

static mcv_lens_map map_of(const params *p, double h) {
    mcv_lens_map map = mcv_lens_map_none();
    const double numbers[12] = {or_0(p->k1), or_0(p->k2), or_0(p->k3), or_0(p->k4),
                                or_0(p->k5), or_0(p->k6), or_0(p->p1), or_0(p->p2),
                                or_0(p->s1), or_0(p->s2), or_0(p->s3), or_0(p->s4)};
    if (!isnan(p->tilt)) mcv_lens_map_tilt(&map, p->tilt, or_0(p->tiltDirection));
    if (!isnan(p->tiltX) || !isnan(p->tiltY))
        mcv_lens_map_tilt_xy(&map, or_0(p->tiltX), or_0(p->tiltY));
    for (int i = 0; i < 12; ++i)
        if (numbers[i] != 0) map.model = MCV_BROWN_CONRADY;
    memcpy(map.k, numbers, sizeof map.k);
    memcpy(map.p, numbers + 6, sizeof map.p);
    memcpy(map.s, numbers + 8, sizeof map.s);
    map.kappa = or_0(p->kappa) * h * h;
    if (map.kappa != 0) map.model = MCV_DIVISION;
    return map;
}

double mcv_sensor_film_distance(const mcv_sensor *sensor) {
    switch (sensor->type) {
    case MCV_SENSOR_PINHOLE:
        return sensor->as.pinhole.imageDistance;
    case MCV_SENSOR_THIN_LENS:
        return sensor->as.thin_lens.imageDistance;
    case MCV_SENSOR_TELECENTRIC:
        return sensor->as.telecentric.imageDistance - sensor->as.telecentric.focalLength;
    case MCV_SENSOR_FLYING_SPOT:
        return 1; /* it has no film: lengths are those of the part */
    default:
        return sensor->as.light_field.imageDistance;
    }
}

mcv_lens_map mcv_sensor_lens_map(const mcv_sensor *sensor) {
    const void *from = params_of(sensor);
    if (!from) return mcv_lens_map_none();
    const params p = read_params(from);
    return map_of(&p, mcv_sensor_film_distance(sensor));
}

/* --- what a datasheet states --- */

/* k1 of the bend of a line, of a film of w x h over its distance: Newton's method from the value
 * of a weak bend. The line through the corner's place without distortion (x, y) has its middle at
 * y (1 + k1 y²). */
static double k1_of_tv(double bend, double w, double h) {
    mcv_lens_map map = mcv_lens_map_none();
    const double corner[2] = {w / 2, h / 2};
    double k1 = 8 * bend / (w * w), step = k1 != 0 ? 1e-6 * fabs(k1) : 1, last[2];
    map.model = MCV_BROWN_CONRADY;
    for (int round = 0; round < 40; ++round) {
        for (int i = 0; i < 2; ++i) {
            double u[2];
            map.k[0] = k1 + i * step;
            if (!mcv_lens_map_undistort(&map, corner, u)) return NAN;
            last[i] = (corner[1] - u[1] * (1 + map.k[0] * u[1] * u[1])) / h - bend;
        }
        const double change = last[0] * step / (last[1] - last[0]);
        k1 -= change;
        if (!(fabs(change) > 1e-12 * fabs(k1))) break;
    }
    return k1;
}

/* (r' - r)/r = k1 r² with r = r'/(1 + D) */
static double k1_of_corner(double shift, double w, double h) {
    const double corner = (w * w + h * h) / 4;
    return shift * (1 + shift) * (1 + shift) / corner;
}

static mcv_result settle_k1(params *p, const mcv_readout *readout, double h,
                            const mcv_json_path *place, mcv_error *error) {
    const double *stated[] = {&p->tvDistortion, &p->geometricDistortion};
    static const char *const keys[] = {"tvDistortion", "geometricDistortion"};
    const double width = readout->film[0] * readout->pitch[0] / h,
                 height = readout->film[1] * readout->pitch[1] / h;
    for (int i = 0; i < 2; ++i) {
        const mcv_json_path here = mcv_json_path_key(place, keys[i]);
        if (isnan(*stated[i])) continue;
        const double k1 = *stated[i] == 0 ? 0
                          : i == 0        ? k1_of_tv(*stated[i], width, height)
                                          : k1_of_corner(*stated[i], width, height);
        if (isnan(k1))
            return mcv_fail_at(&here, error,
                               "%g: no k1 bends lines by so much: the lens would fold the picture",
                               *stated[i]);
        if (isnan(p->k1)) {
            p->k1 = k1;
        } else if (!(fabs(p->k1 - k1) <= 5e-4 * fabs(k1))) {
            return mcv_fail_at(&here, error,
                               "%g contradicts k1 %.6g, %.6g follows from it: give one of them",
                               *stated[i], p->k1, k1);
        }
    }
    return MCV_OK;
}

/* --- what is refused --- */

static mcv_result refuse_pairs(const params *p, const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path tilt = mcv_json_path_key(place, "tilt"),
                        direction = mcv_json_path_key(place, "tiltDirection"),
                        kappa = mcv_json_path_key(place, "kappa");
    const double others[] = {p->k1, p->k2, p->k3, p->k4, p->k5, p->k6,
                             p->p1, p->p2, p->s1, p->s2, p->s3, p->s4};
    if (!isnan(p->tilt) && (!isnan(p->tiltX) || !isnan(p->tiltY)))
        return mcv_fail_at(&tilt, error,
                           "and tiltX, tiltY tell the same thing: give HALCON's or OpenCV's");
    if (!isnan(p->tiltDirection) && isnan(p->tilt))
        return mcv_fail_at(&direction, error, "needs tilt, which says by how much");
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        if (or_0(p->kappa) != 0 && or_0(others[i]) != 0)
            return mcv_fail_at(&kappa, error,
                               "is of the division model, k1 to k6, p1, p2 and s1 to s4 of "
                               "OpenCV's: give one of the two");
    return MCV_OK;
}

/* The radius of what rays pass at the distance h before the film [m]. */
static double aperture_radius(const mcv_sensor *sensor) {
    return sensor->type == MCV_SENSOR_TELECENTRIC ? sensor->as.telecentric.stopDiameter / 2
           : sensor->type == MCV_SENSOR_THIN_LENS ? sensor->as.thin_lens.lensDiameter / 2
                                                  : 0;
}

/* The plane of the film must not cut the aperture, and each place of the film must lie behind it
 * and see something. */
static mcv_result check_film(const mcv_sensor *sensor, const mcv_json_path *place,
                             mcv_error *error) {
    enum { GRID = 64 };
    mcv_lens_map map = mcv_sensor_lens_map(sensor);
    const mcv_readout readout = mcv_sensor_readout(sensor);
    const double h = mcv_sensor_film_distance(sensor), radius = aperture_radius(sensor);
    const double(*a)[3] = map.axes;
    const double facing = a[0][0] * a[1][1] - a[0][1] * a[1][0],
                 leaning = sqrt(fmax(0, 1 - facing * facing));
    const mcv_json_path tilt = mcv_json_path_key(place, isnan(map.tilt) ? "tiltX" : "tilt");
    if (!(facing * h > leaning * radius))
        return mcv_fail_at(&tilt, error,
                           "the plane of the film meets the %s, of %.3g m at %.3g m: tilt it less",
                           sensor->type == MCV_SENSOR_TELECENTRIC ? "stop" : "lens", 2 * radius, h);
    mcv_lens_map_find_reach(&map);
    for (int i = 0; i <= GRID; ++i)
        for (int j = 0; j <= GRID; ++j) {
            const double at[2] = {readout.film[0] * (double)i / GRID,
                                  readout.film[1] * (double)j / GRID};
            double film[2], u[2], stretch;
            for (int k = 0; k < 2; ++k)
                film[k] = (at[k] - readout.centre[k]) * readout.pitch[k] / h;
            if (mcv_lens_map_look(&map, film, u, &stretch)) continue;
            if (!(stretch > 0))
                return mcv_fail_at(&tilt, error,
                                   "the film's column %g, row %g lies before the lens: tilt the "
                                   "film less",
                                   at[0], at[1]);
            return mcv_fail_at(place, error,
                               "the distortion folds the picture: no direction is seen at column "
                               "%g, row %g of the film, which must lie where distances from the "
                               "axis grow",
                               at[0], at[1]);
        }
    return MCV_OK;
}

mcv_result mcv_sensor_resolve_distortion(mcv_sensor *sensor, const mcv_json_path *place,
                                         mcv_error *error) {
    const void *from = params_of(sensor);
    if (!from) return MCV_OK;
    params p = read_params(from);
    const mcv_readout readout = mcv_sensor_readout(sensor);
    MCV_TRY(refuse_pairs(&p, place, error));
    MCV_TRY(settle_k1(&p, &readout, mcv_sensor_film_distance(sensor), place, error));
    MCV_TRY(refuse_pairs(&p, place, error));
    *(double *)mcv_params_find(mcv_sensor_table(sensor->type), "k1", &sensor->as) = p.k1;
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    return mcv_lens_map_is_used(&map) ? check_film(sensor, place, error) : MCV_OK;
}

void mcv_distortion_prepare(const void *from, double h, mcv_distortion *device) {
    const params p = read_params(from);
    mcv_lens_map map = map_of(&p, h);
    mcv_lens_map_find_reach(&map);
    *device = (mcv_distortion){.model = map.model,
                               .kappa = (float)map.kappa,
                               .per_distance = (float)(1 / h),
                               .reach = (float)fmin(map.reach * map.reach, FLT_MAX)};
    for (int i = 0; i < 3; ++i) {
        device->a1[i] = (float)map.axes[0][i];
        device->a2[i] = (float)map.axes[1][i];
    }
    for (int i = 0; i < 6; ++i) device->k[i] = (float)map.k[i];
    for (int i = 0; i < 2; ++i) device->p[i] = (float)map.p[i];
    for (int i = 0; i < 4; ++i) device->s[i] = (float)map.s[i];
}
