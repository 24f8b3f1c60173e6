/* SPDX-License-Identifier: Apache-2.0 */
#include "device/light.h"
#include "device/pack_steps.h"

#include <math.h>
#include <stdlib.h>

#include "mcvisi/light_cone.h"
#include "scene/emitters.h"
#include "scene/sensors.h"
#include "scene/solid.h"

double mcv_write_cdf(uint32_t *cdf, uint32_t count, const double *values) {
    double total = 0;
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) total += values[i];
    for (uint32_t i = 0; i < count; ++i) {
        cdf[i] = total > 0 ? (uint32_t)(sum / total * 0x1p31) : 0;
        sum += values[i];
    }
    cdf[count] = 0x80000000u;
    return total;
}

/* The solid angle of the cones in which light paths leave a point towards the balls. */
static double aimed_angle(const mcv_packed *packed, mcv_vec3 from, mcv_cone emission) {
    double sum = 0;
    for (uint32_t i = 0; i < packed->ball_count; ++i)
        sum += (double)mcv_cone_to(packed->balls[i], from, emission).squared;
    return 4 * M_PI * sum;
}

/* The same for a point of a surface, with a typical cosine: an estimate of the étendue per area of
 * the light that falls on the balls. */
static double aimed_projection(const mcv_packed *packed, mcv_vec3 from, mcv_cone emission) {
    double sum = 0;
    for (uint32_t i = 0; i < packed->ball_count; ++i) {
        const mcv_cone cone = mcv_cone_to(packed->balls[i], from, emission);
        sum += (double)cone.squared *
               fmax((double)mcv_dot(cone.axis, emission.axis) * (1 - (double)cone.squared),
                    sqrt((double)cone.squared) / 4);
    }
    return 4 * M_PI * sum;
}

/* The area of a projector's image, seen from its lens, in tangents. */
static double image_tangents(const mcv_device_emitter *e) {
    double squared[2] = {0, 0};
    for (int k = 0; k < 3; ++k) {
        squared[0] += (double)e->projector.x[k] * e->projector.x[k];
        squared[1] += (double)e->projector.y[k] * e->projector.y[k];
    }
    return 1 / sqrt(squared[0] * squared[1]);
}

/* Sample points on an emitter's surface, one in each of as many equal parts of its area. */
enum { PLACES = 16 };

typedef struct emitter_place {
    mcv_vec3 point, normal; /* re-centred; of the triangle */
} emitter_place;

static emitter_place place_on(const mcv_packed *packed, const mcv_device_emitter *e,
                              uint32_t number) {
    const uint32_t *cdf = packed->emitter_cdf + e->cdf;
    const double at = (number + 0.5) / PLACES * 0x1p31;
    uint32_t triangle = 0;
    while (triangle + 1 < e->triangle_count && cdf[triangle + 1] <= at) ++triangle;
    const uint32_t *corners =
        packed->triangles + 4 * ((size_t)packed->instances[e->instance].first_triangle + triangle);
    mcv_vec3 v[3];
    for (int i = 0; i < 3; ++i) {
        const float *p = packed->positions + 3 * (size_t)corners[i];
        v[i] = mcv_vec(p[0], p[1], p[2]);
    }
    /* The point lies on a line through the triangle's middle, at the position of the number in its
     * share. */
    const double share = (double)(cdf[triangle + 1] - cdf[triangle]);
    const float u = (float)sqrt((at - cdf[triangle]) / share);
    const mcv_vec3 ab = mcv_sub(v[1], v[0]), ac = mcv_sub(v[2], v[0]);
    return (emitter_place){mcv_along(mcv_along(v[0], 0.5f * u, ab), 0.5f * u, ac),
                           mcv_normalize(mcv_cross(ab, ac))};
}

static mcv_cone emission_cone(const mcv_device_emitter *e, mcv_vec3 normal) {
    const bool parallel = e->type == MCV_EMITTER_PARALLEL;
    return (mcv_cone){.axis = normal,
                      .squared = parallel ? e->parallel.sin_half * e->parallel.sin_half : 0.5f,
                      .is_emission_cone = 1};
}

/* Does the emitter emit nearly parallel rays? Most of them may miss the balls, and few sample
 * points would see a ball. */
static bool is_narrow(const mcv_device_emitter *e) {
    return e->type == MCV_EMITTER_PARALLEL && e->parallel.from_receiver;
}

/* An estimate of the étendue of the light that goes to the balls [m² sr]. */
static double aimed_etendue(const mcv_packed *packed, const mcv_emitter *from,
                            const mcv_device_emitter *e) {
    double sum = 0;
    if (is_narrow(e)) return mcv_emitter_projected_solid_angle(from) * from->area;
    for (uint32_t i = 0; i < PLACES; ++i) {
        const emitter_place at = place_on(packed, e, i);
        sum += aimed_projection(packed, at.point, emission_cone(e, at.normal)) / PLACES;
    }
    return (double)e->area * sum;
}

static bool is_aimed(uint32_t type) {
    return type == MCV_EMITTER_PARALLEL || type == MCV_EMITTER_AREA ||
           type == MCV_EMITTER_LIGHT_FIELD_EMITTER;
}

/* The area of the disks onto which the balls project. */
static double disks(const mcv_packed *packed) {
    double sum = 0;
    for (uint32_t i = 0; i < packed->ball_count; ++i)
        sum += M_PI * (double)packed->balls[i].radius * (double)packed->balls[i].radius;
    return sum;
}

/*
 * Does an emitter that emits in all directions fill, seen from the balls, so little of the
 * hemisphere's π sr that camera paths seldom hit it? With solid angle Ω the contribution of a hit
 * is π/Ω times the mean, and its variance as many times the square of the mean. Measured with a
 * ball of glass or satin metal under a lamp: light paths pay up to a quarter of the hemisphere.
 */
static bool is_small(const mcv_packed *packed, const mcv_device_emitter *e, double etendue) {
    return !is_aimed(e->type) || is_narrow(e) || 4 * etendue <= M_PI * disks(packed);
}

/* The flux of all light paths of an emitter, over its radiance (irradiance, intensity). *unit gets
 * this flux without the factor of the kernels' choice of directions: light_inverse_pdf without the
 * choice among emitters. */
static double unit_flux(const mcv_packed *packed, const mcv_emitter *from, mcv_device_emitter *e,
                        double *unit) {
    *unit = 1;
    switch (e->type) {
    case MCV_EMITTER_PARALLEL:
    case MCV_EMITTER_AREA:
    case MCV_EMITTER_LIGHT_FIELD_EMITTER:
        *unit = (double)e->area;
        return aimed_etendue(packed, from, e);
    case MCV_EMITTER_COLLIMATED_BEAM:
        return *unit = from->area;
    case MCV_EMITTER_PROJECTOR:
        return *unit = from->area * image_tangents(e);
    case MCV_EMITTER_LASER: /* its radiance is its power */
        return 1;
    case MCV_EMITTER_POINT: {
        const float *p = e->light.position, *a = e->light.axis;
        return aimed_angle(packed, mcv_vec(p[0], p[1], p[2]),
                           (mcv_cone){.axis = mcv_vec(a[0], a[1], a[2]),
                                      .squared = e->light.edge,
                                      .is_emission_cone = 1});
    }
    case MCV_EMITTER_DIRECTIONAL:
        e->directional.reach = (float)(2 * mcv_packed_size(packed));
        return disks(packed);
    default:
        return 0;
    }
}

/* The media around a point in the device's coordinates. */
static uint32_t media_at(const mcv_scene *scene, const mcv_packed *packed, mcv_vec3 p) {
    const double point[3] = {(double)p.x + packed->centre[0], (double)p.y + packed->centre[1],
                             (double)p.z + packed->centre[2]};
    return mcv_media_around(scene, packed, point);
}

/* Finds the media around the emitter; false if they are not the same everywhere. */
static bool find_media(const mcv_scene *scene, const mcv_packed *packed, mcv_device_emitter *e) {
    const float *at = e->type == MCV_EMITTER_POINT ? e->light.position : e->middle;
    e->media = e->type == MCV_EMITTER_DIRECTIONAL
                   ? 0
                   : media_at(scene, packed, mcv_vec(at[0], at[1], at[2]));
    if (!is_aimed(e->type)) return true;
    /* A point before the surface, by more than the rounding of coordinates. */
    const float before = (float)(mcv_packed_size(packed) * 0x1p-20);
    for (uint32_t i = 0; i < PLACES; ++i) {
        const emitter_place from = place_on(packed, e, i);
        const uint32_t media = media_at(scene, packed, mcv_along(from.point, before, from.normal));
        if (i > 0 && media != e->media) return false;
        e->media = media;
    }
    return packed->instances[e->instance].medium == 0;
}

mcv_result mcv_pack_light(const mcv_scene *scene, mcv_packed *packed, uint32_t *cdf,
                          mcv_error *error) {
    mcv_find_balls(scene, packed);
    const bool caustics = packed->ball_count > 0 && packed->features >> MCV_FEATURE_NEXT_EVENT & 1;
    uint32_t count = 0;
    bool wide = false;
    for (uint32_t i = 0; i < packed->instance_count; ++i)
        wide = wide || packed->materials[packed->instances[i].material].broad_lobe;
    double *powers = calloc(packed->emitter_count + 1, sizeof *powers);
    if (!powers) return mcv_fail(error, MCV_FAILED, "%s: no memory for the emitters", scene->path);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *from = &scene->emitters[i];
        double mean[3], unit;
        if (!mcv_is_sampled(from)) continue;
        mcv_device_emitter *e = &packed->emitters[count++];
        const bool is_beam = e->type == MCV_EMITTER_COLLIMATED_BEAM || e->type == MCV_EMITTER_LASER;
        if (!caustics && !is_beam) continue;
        /* Reflection at glossy surfaces hits emitters that have an extent. */
        if (mcv_emitter_has_surface(from->type) && !is_beam && !wide) continue;
        const double flux = unit_flux(packed, from, e, &unit);
        if (!(flux > 0) || !is_small(packed, e, flux) || !find_media(scene, packed, e)) continue;
        mcv_emitter_image_mean(scene, from, mean);
        powers[count - 1] = flux * (from->radiance[0] * mean[0] + from->radiance[1] * mean[1] +
                                    from->radiance[2] * mean[2]);
        e->light_inverse_pdf = (float)unit;
        e->light_aim = (float)(flux / unit);
    }
    mcv_write_cdf(cdf, count, powers);
    for (uint32_t i = 0; i < count; ++i) {
        const double chance = (cdf[i + 1] - cdf[i]) * 0x1p-31;
        const bool chosen = powers[i] > 0 && chance > 0;
        packed->emitters[i].light_inverse_pdf =
            chosen ? (float)(packed->emitters[i].light_inverse_pdf / chance) : 0;
    }
    free(powers);
    return MCV_OK;
}

/* An estimate of the flux of one light path, over the radiance (irradiance, intensity). */
static double typical_flux(const mcv_device_emitter *e) {
    return (double)e->light_inverse_pdf * (double)e->light_aim;
}

/*
 * How a sensor sees a point on its axis at the depth z: its brightness, W |d|/z² over the density
 * of o, and the footprint of a pixel there [m²]. False: light paths cannot reach this type of
 * sensor.
 */
static bool look_at_point(const mcv_sensor *sensor, float z, double *brightness,
                          double *footprint) {
    mcv_sensor_ray sight;
    mcv_film_point place;
    const mcv_vec3 point = mcv_vec(0, 0, z);
    switch (sensor->type) {
#define REACH(name, NAME) \
    case MCV_SENSOR_##NAME: { \
        mcv_##name device; \
        mcv_##name##_prepare(&sensor->as.name, &device); \
        const double area = mcv_##name##_connect(&device, point, 0.5f, 0.5f, &sight); \
        *brightness = area * mcv_##name##_invert(&device, sight, &place) / ((double)z * z); \
        *footprint = mcv_##name##_footprint(&device, z); \
        return *brightness > 0; \
    }
        REACH(pinhole, PINHOLE)
        REACH(thin_lens, THIN_LENS)
        REACH(telecentric, TELECENTRIC)
        REACH(light_field, LIGHT_FIELD)
#undef REACH
    default:
        return false;
    }
}

/* The largest depth of a surface before the sensor. */
static double greatest_depth(const mcv_packed *packed, const mcv_sensor *sensor) {
    const double *m = sensor->to_world.m;
    double depth = 0;
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        double z = 0;
        for (int k = 0; k < 3; ++k) {
            const double axis = -m[3 * k + 2];
            z +=
                axis * ((axis > 0 ? packed->boxes[i].upper : packed->boxes[i].lower)[k] - m[9 + k]);
        }
        if (isfinite(z)) depth = fmax(depth, z);
    }
    return depth;
}

/* The area of the balls' disks in pixels. */
static double covered_pixels(const mcv_packed *packed, const mcv_sensor *sensor) {
    const double *m = sensor->to_world.m;
    double sum = 0, brightness, footprint;
    for (uint32_t i = 0; i < packed->ball_count; ++i) {
        const mcv_ball *b = packed->balls + i;
        double z = 0;
        for (int k = 0; k < 3; ++k)
            z -= m[3 * k + 2] * ((double)b->centre[k] + packed->centre[k] - m[9 + k]);
        if (!(z > (double)b->radius) || !look_at_point(sensor, (float)z, &brightness, &footprint))
            return INFINITY;
        sum += M_PI * (double)b->radius * (double)b->radius / footprint;
    }
    return sum;
}

uint32_t mcv_light_thinning(const mcv_packed *packed, const mcv_sensor *sensor) {
    uint32_t width, height, thinning = 0;
    double density = 0.25;
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        const mcv_device_emitter *e = &packed->emitters[i];
        const bool punctual = e->type == MCV_EMITTER_POINT || e->type == MCV_EMITTER_DIRECTIONAL;
        if (!(e->light_inverse_pdf > 0)) continue;
        /* Emitters without a choice of directions towards the balls lose some paths that miss the
         * balls. */
        if (!punctual && (!is_aimed(e->type) || is_narrow(e))) return 0;
        /* The fewer of this light camera paths find, the more light paths pay: see is_small. */
        density =
            fmax(density, punctual ? 4 : fmin(4, M_PI * disks(packed) / (64 * typical_flux(e))));
    }
    const double wanted = density * covered_pixels(packed, sensor);
    mcv_sensor_film_size(sensor, &width, &height);
    const double pixels = (double)mcv_tiled_pixels(width, height);
    while (thinning < MCV_MOST_THINNING && pixels * exp2(-(double)thinning - 1) >= wanted)
        ++thinning;
    return thinning;
}

bool mcv_camera_finds_light(const mcv_packed *packed) {
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        const mcv_device_emitter *e = &packed->emitters[i];
        if (e->light_inverse_pdf > 0 && !is_aimed(e->type) && e->type != MCV_EMITTER_PROJECTOR)
            return false;
    }
    return true;
}

bool mcv_traces_light(const mcv_packed *packed, const mcv_sensor *sensor) {
    const double *m = sensor->to_world.m;
    const double depth = greatest_depth(packed, sensor);
    double brightness, footprint;
    uint32_t width, height;
    if (!(depth > 0) || !look_at_point(sensor, (float)depth, &brightness, &footprint)) return false;
    mcv_sensor_film_size(sensor, &width, &height);
    const uint32_t thinning = mcv_light_thinning(packed, sensor);
    const double paths = exp2(-(double)thinning) * (double)mcv_tiled_pixels(width, height);
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        const mcv_device_emitter *e = &packed->emitters[i];
        if (!(e->light_inverse_pdf > 0)) continue;
        if (is_aimed(e->type) || e->type == MCV_EMITTER_PROJECTOR) {
            /*
             * Camera paths find this light too (mcv_light_path_mis_weight in
             * kernels/light/mis.h). One light path per pixel costs at least as much as the
             * camera paths. They pay if one of them contributes twice as much as a camera path;
             * fewer light paths pay if they contribute half of the light. They do not pay if the
             * area that the film sees is small against the emitter's area times sin²β.
             */
            if (M_PI * paths * footprint >= (thinning > 0 ? 1 : 2) * typical_flux(e)) return true;
            continue;
        }
        const bool is_laser = e->type == MCV_EMITTER_LASER;
        if (e->type != MCV_EMITTER_COLLIMATED_BEAM && !is_laser) return true;
        /* The beam's axis and the node's z both point in the direction of the light; a fan of
         * tangent T holds light as far as its sine, T/√(1 + T²), the other way. */
        const float *axis = is_laser ? e->laser.forward : e->beam.axis;
        const double towards = axis[0] * m[2] + axis[1] * m[5] + axis[2] * m[8];
        const double aside = is_laser ? sin(atan((double)e->laser.edge)) : 0;
        if (packed->ball_count > 0 || (towards > -aside && sensor->type != MCV_SENSOR_PINHOLE))
            return true;
    }
    return false;
}

double mcv_splat_unit(const mcv_packed *packed, const mcv_sensor *sensor, const mcv_frame *frame) {
    const float *t = frame->to_world + 9;
    double flux = 0;
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        for (int k = 0; k < 3; ++k)
            flux = fmax(flux, (double)packed->emitters[i].radiance[k] *
                                  typical_flux(packed->emitters + i));
    }
    const double distance =
        fmax(sqrt((double)t[0] * t[0] + (double)t[1] * t[1] + (double)t[2] * t[2]),
             mcv_packed_size(packed) / 16);
    double brightness = 0, footprint;
    look_at_point(sensor, (float)distance, &brightness, &footprint);
    const double typical = flux / M_PI * brightness;
    const double exponent = isfinite(typical) && typical > 0 ? floor(log2(typical)) - 16 : 0;
    return exp2(fmin(fmax(exponent, -100), 100));
}
