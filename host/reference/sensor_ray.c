/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/sensor_ray.h"

typedef struct point {
    double x, y;
} point;

/* Uniform on the disk of the given radius. */
static point on_disk(double radius, double u, double v) {
    const double r = radius * sqrt(u), angle = 2 * M_PI * v;
    const point p = {r * cos(angle), r * sin(angle)};
    return p;
}

/* The image point of the position (column, row) in pixels of the whole film. The lens turns the
 * image, the read-out turns it back. */
static point image_point(const uint32_t resolution[2], const double principal[2],
                         const double pixel[2], double column, double row) {
    const bool given = !isnan(principal[0]);
    const double across = given ? principal[0] : resolution[0] / 2.0,
                 down = given ? principal[1] : resolution[1] / 2.0;
    return (point){(across - column) * pixel[0], (row - down) * pixel[1]};
}

/* A coordinate in the image, in pixels of the whole film. */
static double on_film(const uint32_t region[4], const uint32_t binning[2], int axis,
                      double coordinate) {
    return (region[0] == MCV_NONE ? 0 : region[axis]) + binning[axis] * coordinate;
}

#define FILM_POINT(p, column, row) \
    image_point((p)->resolution, (p)->principalPoint, (p)->pixelSize, \
                on_film((p)->regionOfInterest, (p)->binning, 0, column), \
                on_film((p)->regionOfInterest, (p)->binning, 1, row))

/* In the optical frame: the ray through o on the lens to the point in focus, w = -w_z/b (p, -b), of
 * the image point p; d = (w - o)/w_z. */
static ref_vec through_focus(point p, point o, double focal_length, double image_distance) {
    const double reciprocal_depth =
        1 / focal_length - 1 / image_distance; /* 1/w_z; 0: in focus at infinity */
    return (ref_vec){-p.x / image_distance - o.x * reciprocal_depth,
                     -p.y / image_distance - o.y * reciprocal_depth, 1};
}

/* From the optical frame (z towards the scene) to the node's, which looks along -z, and to the
 * world. */
static ref_sensor_ray in_world(const mcv_sensor *sensor, point o, ref_vec d) {
    const double origin[3] = {o.x, o.y, 0}, direction[3] = {d.x, d.y, -d.z};
    double world[3];
    ref_sensor_ray sensor_ray = {.weight = 1};
    mcv_transform_point(&sensor->to_world, origin, world);
    sensor_ray.origin = ref_from(world);
    mcv_transform_vector(&sensor->to_world, direction, world);
    sensor_ray.direction = ref_unit(ref_from(world));
    return sensor_ray;
}

/*
 * A cos⁴θ/h²: the aperture's area A at distance h from the image plane, θ the angle to the axis of
 * the ray d before the lens, or of the line from the image point p to the place a on that aperture.
 */
static double throughput(int falloff, double area, double distance, ref_vec d, point p, point a) {
    const ref_vec behind = {a.x - p.x, a.y - p.y, distance},
                  counted = falloff == MCV_FALLOFF_IMAGE_SIDE ? behind : d;
    return area / (distance * distance) * pow(counted.z / ref_length(counted), 4);
}

static ref_sensor_ray pinhole(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                              double y) {
    const mcv_pinhole_params *p = &sensor->as.pinhole;
    const point s = FILM_POINT(p, column + x, row + y);
    return in_world(sensor, (point){0, 0},
                    (ref_vec){-s.x / p->imageDistance, -s.y / p->imageDistance, 1});
}

static ref_sensor_ray thin_lens(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                double y, double u, double v) {
    const mcv_thin_lens_params *p = &sensor->as.thin_lens;
    const point s = FILM_POINT(p, column + x, row + y);
    const point o = on_disk(p->lensDiameter / 2, u, v);
    const ref_vec d = through_focus(s, o, p->focalLength, p->imageDistance);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight = throughput(p->falloff, M_PI * p->lensDiameter * p->lensDiameter / 4,
                                       p->imageDistance, d, s, o);
    return sensor_ray;
}

static ref_sensor_ray telecentric(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                  double y, double u, double v) {
    const mcv_telecentric_params *p = &sensor->as.telecentric;
    const double f = p->focalLength, b = p->imageDistance;
    const point s = FILM_POINT(p, column + x, row + y);
    const point a = on_disk(p->stopDiameter / 2, u, v);
    const point o = {s.x + (a.x - s.x) * b / (b - f),
                     s.y + (a.y - s.y) * b / (b - f)}; /* the line s a at the lens */
    const ref_vec d = through_focus(s, o, f, b);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight =
            throughput(p->falloff, M_PI * p->stopDiameter * p->stopDiameter / 4, b - f, d, s, a);
    if (hypot(o.x, o.y) > p->lensDiameter / 2) sensor_ray.weight = 0;
    return sensor_ray;
}

static ref_sensor_ray light_field(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                  double y, double u, double v) {
    const mcv_light_field_params *p = &sensor->as.light_field;
    const uint32_t *angular = p->angularResolution;
    const uint32_t resolution[2] = {p->spatialResolution[0] * angular[0],
                                    p->spatialResolution[1] * angular[1]};
    /* Of binned macro pixels (u, v) chooses one. */
    const uint32_t macro_column = column / angular[0], macro_row = row / angular[1];
    const double m =
        on_film(p->regionOfInterest, p->binning, 0, macro_column) + floor(u * p->binning[0]);
    const double n =
        on_film(p->regionOfInterest, p->binning, 1, macro_row) + floor(v * p->binning[1]);
    const point c = image_point(resolution, p->principalPoint, p->pixelSize, (m + 0.5) * angular[0],
                                (n + 0.5) * angular[1]);
    /* The place in the macro pixel, -1 … 1, from whole pixels so that no sample slips into the next
     * one. */
    const double across = 2 * (column % angular[0] + x) / angular[0] - 1,
                 down = 2 * (row % angular[1] + y) / angular[1] - 1;
    const point o = {across * p->lensDiameter / 2, -down * p->lensDiameter / 2};
    const ref_vec d = through_focus(c, o, p->focalLength, p->imageDistance);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight =
            throughput(p->falloff, p->lensDiameter * p->lensDiameter, p->imageDistance, d, c, o);
    if (p->aperture == MCV_APERTURE_CIRCLE && hypot(across, down) > 1) sensor_ray.weight = 0;
    return sensor_ray;
}

ref_sensor_ray ref_sensor_ray_sample(const mcv_sensor *sensor, uint32_t column, uint32_t row,
                                     double x, double y, double u, double v) {
    switch (sensor->type) {
    case MCV_SENSOR_THIN_LENS:
        return thin_lens(sensor, column, row, x, y, u, v);
    case MCV_SENSOR_TELECENTRIC:
        return telecentric(sensor, column, row, x, y, u, v);
    case MCV_SENSOR_LIGHT_FIELD:
        return light_field(sensor, column, row, x, y, u, v);
    default:
        return pinhole(sensor, column, row, x, y);
    }
}
