/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/sensor_ray.h"

#include "reference/motion.h"

#include "scene/aperture.h"
#include "scene/lens_map.h"
#include "scene/motion.h"
#include "scene/param_lists.h"
#include "scene/sensors.h"

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

/* Euler's criterion: i is a square mod p if i^((p-1)/2) = 1. */
static bool is_square(uint32_t p, uint32_t i) {
    uint32_t power = 1;
    for (uint32_t k = 0; k < (p - 1) / 2; ++k) power = power * i % p;
    return power == 1;
}

/* What a cell of a mask passes; y goes up and rows go down. */
static double of_mask(const mcv_mask *mask, double x, double y) {
    const double side = mask->side;
    const uint32_t i = (uint32_t)fmin(floor((x + 1) / 2 * side), side - 1),
                   j = (uint32_t)fmin(floor((1 - y) / 2 * side), side - 1);
    return (double)mask->values[j * mask->side + i];
}

/* Whether the aperture is open at a place of the disc, in its radii. */
static bool is_open(const mcv_aperture_shape *s, double x, double y) {
    const double r = hypot(x, y), sector = 2 * M_PI / s->blades,
                 angle = fmod(atan2(y, x) - s->rotation + 100 * M_PI, sector) - sector / 2;
    if (s->shape == MCV_APERTURE_RING) return r > s->ratio;
    if (s->shape == MCV_APERTURE_HALF) return cos(atan2(y, x) - s->rotation) > 0;
    if (s->shape == MCV_APERTURE_BLADES) return r * cos(angle) < cos(sector / 2);
    if (s->shape != MCV_APERTURE_CODED) return true;
    const double across = (1 + x * M_SQRT2) / 2 * s->order, down = (1 - y * M_SQRT2) / 2 * s->order;
    if (!(across > 0 && down > 0 && across < s->order && down < s->order)) return false;
    const uint32_t i = (uint32_t)across, j = (uint32_t)down;
    return i > 0 && (j == 0 || is_square(s->order, i) == is_square(s->order, j));
}

/* The weight of a ray through (x, y) of a disc, of places that are uniform on it. */
static double aperture_weight(const mcv_sensor *sensor, int radiometry, point on, double radius) {
    const mcv_aperture_shape s = mcv_sensor_aperture(sensor);
    if (s.shape == MCV_APERTURE_DISC) return 1;
    if (!is_open(&s, on.x / radius, on.y / radius)) return 0;
    const double share =
        s.shape == MCV_APERTURE_MASK ? of_mask(s.mask, on.x / radius, on.y / radius) : 1;
    return radiometry == MCV_RADIOMETRY_IRRADIANCE ? share : share / mcv_aperture_open(&s);
}

/*
 * What a place of the image sees through the point a of the aperture, both over h and upside down:
 * the chief ray's slope u before the lens, and the film's stretch e. `behind` is the slope behind
 * the aperture, from the film's true place.
 */
typedef struct look {
    point u, behind;
    double stretch;
} look;

static look look_from(const mcv_lens_map *map, point p, point a) {
    /* p is upside down and y up; the map is upright and y down. */
    const double film[2] = {-p.x, p.y};
    double u[2];
    look l;
    mcv_lens_map_look(map, film, u, &l.stretch);
    const double s[2] = {(film[0] * map->axes[0][0] + film[1] * map->axes[1][0]) / l.stretch,
                         (film[0] * map->axes[0][1] + film[1] * map->axes[1][1]) / l.stretch};
    l.u = (point){-u[0], u[1]};
    l.behind = (point){-s[0] - a.x / l.stretch, s[1] - a.y / l.stretch};
    return l;
}

/*
 * Irradiance: A/h² over |d|⁴, times the area of slopes that an area of the film sees: by central
 * differences, before the lens (objectSide) or behind it.
 */
static double distorted_throughput(const mcv_lens_map *map, int falloff, double etendue, point p,
                                   point a, ref_vec d) {
    const double step = 1e-5;
    point by[2];
    for (int k = 0; k < 2; ++k) {
        point seen[2];
        for (int side = 0; side < 2; ++side) {
            const double shift = side ? step : -step;
            const point moved = {p.x + (k == 0 ? shift : 0), p.y + (k == 1 ? shift : 0)};
            const look l = look_from(map, moved, a);
            seen[side] = falloff == MCV_FALLOFF_IMAGE_SIDE
                             ? l.behind
                             : (point){l.u.x - a.x / l.stretch, l.u.y - a.y / l.stretch};
        }
        by[k] = (point){(seen[1].x - seen[0].x) / (2 * step), (seen[1].y - seen[0].y) / (2 * step)};
    }
    const look l = look_from(map, p, a);
    const ref_vec behind = {l.behind.x, l.behind.y, 1},
                  counted = falloff == MCV_FALLOFF_IMAGE_SIDE ? behind : d;
    return etendue * fabs(by[0].x * by[1].y - by[0].y * by[1].x) / pow(ref_length(counted), 4);
}

static ref_sensor_ray pinhole(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                              double y) {
    const mcv_pinhole_params *p = &sensor->as.pinhole;
    point s = FILM_POINT(p, column + x, row + y);
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    if (mcv_lens_map_is_used(&map)) {
        const point over = {s.x / p->imageDistance, s.y / p->imageDistance};
        const look l = look_from(&map, over, (point){0, 0});
        s = (point){l.u.x * p->imageDistance, l.u.y * p->imageDistance};
    }
    return in_world(sensor, (point){0, 0},
                    (ref_vec){-s.x / p->imageDistance, -s.y / p->imageDistance, 1});
}

/* 1/f = 1/w + 1/(b e) at each place of the film. */
static ref_sensor_ray distorted_thin_lens(const mcv_sensor *sensor, const mcv_lens_map *map,
                                          point s, point o) {
    const mcv_thin_lens_params *p = &sensor->as.thin_lens;
    const double b = p->imageDistance;
    const point over = {s.x / b, s.y / b}, a = {o.x / b, o.y / b};
    const look l = look_from(map, over, a);
    const point at_b = {l.u.x * b * l.stretch, l.u.y * b * l.stretch};
    const ref_vec d = through_focus(at_b, o, p->focalLength, b * l.stretch);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight = distorted_throughput(
            map, p->falloff, M_PI * p->lensDiameter * p->lensDiameter / (4 * b * b), over, a, d);
    return sensor_ray;
}

static ref_sensor_ray thin_lens(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                double y, double u, double v) {
    const mcv_thin_lens_params *p = &sensor->as.thin_lens;
    const point s = FILM_POINT(p, column + x, row + y);
    const point o = on_disk(p->lensDiameter / 2, u, v);
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    if (mcv_lens_map_is_used(&map)) return distorted_thin_lens(sensor, &map, s, o);
    const ref_vec d = through_focus(s, o, p->focalLength, p->imageDistance);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight = throughput(p->falloff, M_PI * p->lensDiameter * p->lensDiameter / 4,
                                       p->imageDistance, d, s, o);
    return sensor_ray;
}

/* The line from the film's place at h e behind the stop, through a, to the lens. */
static ref_sensor_ray distorted_telecentric(const mcv_sensor *sensor, const mcv_lens_map *map,
                                            point s, point on_stop) {
    const mcv_telecentric_params *p = &sensor->as.telecentric;
    const double f = p->focalLength, h = p->imageDistance - f;
    const point over = {s.x / h, s.y / h}, a = {on_stop.x / h, on_stop.y / h};
    const look l = look_from(map, over, a);
    const double away = h * l.stretch;
    const point from = {l.u.x * away, l.u.y * away},
                o = {from.x + (on_stop.x - from.x) * (away + f) / away,
                     from.y + (on_stop.y - from.y) * (away + f) / away};
    const ref_vec d = through_focus(from, o, f, away + f);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight = distorted_throughput(
            map, p->falloff, M_PI * p->stopDiameter * p->stopDiameter / (4 * h * h), over, a, d);
    if (hypot(o.x, o.y) > p->lensDiameter / 2) sensor_ray.weight = 0;
    return sensor_ray;
}

static ref_sensor_ray telecentric(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                  double y, double u, double v) {
    const mcv_telecentric_params *p = &sensor->as.telecentric;
    const double f = p->focalLength, b = p->imageDistance;
    const point s = FILM_POINT(p, column + x, row + y);
    const point a = on_disk(p->stopDiameter / 2, u, v);
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    const double falls = mcv_curve_at(&p->relativeIllumination, hypot(s.x, s.y));
    if (mcv_lens_map_is_used(&map)) {
        ref_sensor_ray distorted = distorted_telecentric(sensor, &map, s, a);
        distorted.weight *= falls;
        return distorted;
    }
    const point o = {s.x + (a.x - s.x) * b / (b - f),
                     s.y + (a.y - s.y) * b / (b - f)}; /* the line s a at the lens */
    const ref_vec d = through_focus(s, o, f, b);
    ref_sensor_ray sensor_ray = in_world(sensor, o, d);
    if (p->radiometry == MCV_RADIOMETRY_IRRADIANCE)
        sensor_ray.weight =
            falls *
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

/* A beam on a parallel to the axis: place in the waist and slope are normal, by Box and Muller. */
static ref_sensor_ray flying_spot(const mcv_sensor *sensor, uint32_t column, uint32_t row,
                                  const double draw[4]) {
    const mcv_flying_spot_params *p = &sensor->as.flying_spot;
    const uint32_t whole[2] = {1, 1};
    const point axis = image_point(p->resolution, p->principalPoint, p->pixelSize,
                                   on_film(p->regionOfInterest, whole, 0, column + 0.5),
                                   on_film(p->regionOfInterest, whole, 1, row + 0.5));
    double place[2], slope[2];
    for (int i = 0; i < 2; ++i) {
        const double d = p->beamDiameter[i],
                     w0 = p->widthMeasure == 2 ? d / sqrt(2 * log(2)) : d / 2,
                     spread = p->M2[i] * p->wavelength / (M_PI * w0),
                     angle[2] = {2 * M_PI * draw[1], 2 * M_PI * draw[3]};
        place[i] = (i ? sin(angle[0]) : cos(angle[0])) * sqrt(-2 * log1p(-draw[0])) * w0 / 2;
        slope[i] = (i ? sin(angle[1]) : cos(angle[1])) * sqrt(-2 * log1p(-draw[2])) * spread / 2;
    }
    const double z = p->workingDistance;
    return in_world(sensor,
                    (point){place[0] - axis.x - z * slope[0], place[1] - axis.y - z * slope[1]},
                    (ref_vec){slope[0], slope[1], 1});
}

ref_sensor_ray ref_sensor_ray_sample(const mcv_sensor *sensor, uint32_t column, uint32_t row,
                                     double x, double y, double u, double v) {
    switch (sensor->type) {
    case MCV_SENSOR_THIN_LENS: {
        const mcv_thin_lens_params *p = &sensor->as.thin_lens;
        ref_sensor_ray ray = thin_lens(sensor, column, row, x, y, u, v);
        ray.weight *= aperture_weight(sensor, p->radiometry, on_disk(p->lensDiameter / 2, u, v),
                                      p->lensDiameter / 2);
        return ray;
    }
    case MCV_SENSOR_TELECENTRIC: {
        const mcv_telecentric_params *p = &sensor->as.telecentric;
        ref_sensor_ray ray = telecentric(sensor, column, row, x, y, u, v);
        ray.weight *= aperture_weight(sensor, p->radiometry, on_disk(p->stopDiameter / 2, u, v),
                                      p->stopDiameter / 2);
        return ray;
    }
    case MCV_SENSOR_FLYING_SPOT:
        return flying_spot(sensor, column, row, (const double[]){x, y, u, v});
    case MCV_SENSOR_LIGHT_FIELD:
        return light_field(sensor, column, row, x, y, u, v);
    default:
        return pinhole(sensor, column, row, x, y);
    }
}

/* --- time --- */

/* The error of the encoder at the line of a stage. */
static double line_error(const mcv_exposure *e, uint32_t row, double eta, double stage) {
    const uint32_t line = row + (uint32_t)(eta * e->stages);
    const double u = mcv_line_draw(e->seed, line, 0), v = mcv_line_draw(e->seed, line, 1);
    return e->jitter * sqrt(-2 * log(u)) * cos(2 * M_PI * v) +
           e->ripple * sin(2 * M_PI * (row + stage) * e->ripples_per_line);
}

ref_sensor_ray ref_sensor_ray_at(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                 double y, double u, double v, double xi, double eta) {
    const mcv_exposure e = mcv_sensor_exposure(sensor);
    const mcv_node_motion *m = &sensor->motion;
    const double stage = floor(eta * e.stages) - (e.stages - 1) / 2.0;
    double begin = 0, share = 1;
    uint32_t film_row = row;
    if (e.shutter != MCV_SHUTTER_GLOBAL) begin = (row + stage) * e.line_time;
    if (e.shutter == MCV_SHUTTER_LINE) {
        const mcv_readout readout = mcv_sensor_readout(sensor);
        film_row = 0;
        begin += line_error(&e, row, eta, stage);
        y = (readout.centre[1] - readout.first[1]) / readout.binning[1] + y - 0.5 - stage;
    }
    double end = begin + e.time;
    if (e.strobe_time > 0) {
        begin = fmax(begin, e.strobe_delay);
        end = fmin(end, e.strobe_delay + e.strobe_time);
        share = fmax(0, end - begin) / e.strobe_time;
    }
    const double time = begin + xi * (end - begin);
    ref_sensor_ray ray = ref_sensor_ray_sample(sensor, column, film_row, x, y, u, v);
    ray.origin = ref_moved_point(m, time, ray.origin);
    ray.direction = ref_moved_direction(m, time, ray.direction);
    ray.time = time;
    ray.weight *= share;
    return ray;
}

ref_sensor_ray ref_sensor_ray_draw(const mcv_scene *scene, const mcv_sensor *sensor,
                                   uint32_t column, uint32_t row, const double place[4],
                                   ref_random *random) {
    if (!mcv_needs_time(scene, sensor))
        return ref_sensor_ray_sample(sensor, column, row, place[0], place[1], place[2], place[3]);
    const double xi = ref_random_unit(random), eta = ref_random_unit(random);
    return ref_sensor_ray_at(sensor, column, row, place[0], place[1], place[2], place[3], xi, eta);
}
