/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light.h"

#include <math.h>
#include <stdlib.h>

#include "scene/emitters.h"
#include "scene/sensors.h"

static const double pi = 3.14159265358979323846;

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

/* A ball around all smooth surfaces, re-centred; radius 0: there is none. */
typedef struct ball {
    double centre[3], radius;
} ball;

static bool is_smooth(const mcv_device_material *material) { return !material->spreads && material->type != MCV_MATERIAL_ABSORBER; }

static ball smooth_ball(const mcv_packed *packed) {
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    ball b = {{0, 0, 0}, 0};
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        if (!is_smooth(&packed->materials[packed->instances[i].material])) continue;
        for (int k = 0; k < 3; ++k) {
            lower[k] = fmin(lower[k], packed->boxes[i].lower[k]);
            upper[k] = fmax(upper[k], packed->boxes[i].upper[k]);
        }
    }
    if (!(lower[0] <= upper[0])) return b;
    for (int k = 0; k < 3; ++k) {
        b.centre[k] = 0.5 * (lower[k] + upper[k]) - packed->centre[k];
        b.radius += 0.25 * (upper[k] - lower[k]) * (upper[k] - lower[k]);
    }
    b.radius = sqrt(b.radius);
    return b;
}

/* The smaller of the light's own cone and the one around the ball. Returns its solid angle. */
static double aim_spot(const ball *smooth, mcv_device_emitter *e) {
    double way[3], distance = 0;
    for (int k = 0; k < 3; ++k) {
        way[k] = smooth->centre[k] - (double)e->spot.position[k];
        distance += way[k] * way[k];
    }
    distance = sqrt(distance);
    double half_sine_squared = fmin(e->spot.edge, 1);
    memcpy(e->spot.aim, e->spot.axis, sizeof e->spot.aim);
    /* A millionth more: the cone holds the ball whatever float32 makes of both. */
    const double around = distance > smooth->radius ? pow(sin(asin(smooth->radius / distance) / 2), 2) * (1 + 1e-6) : 1;
    if (around < half_sine_squared) {
        half_sine_squared = around;
        for (int k = 0; k < 3; ++k) e->spot.aim[k] = (float)(way[k] / distance);
    }
    e->light_sine = (float)sqrt(half_sine_squared);
    return 4 * pi * half_sine_squared;
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

/* The flux of all light paths of an emitter, over its radiance (irradiance, intensity). */
static double unit_flux(const mcv_packed *packed, const ball *smooth, const mcv_emitter *from, mcv_device_emitter *e) {
    switch (e->type) {
    case MCV_EMITTER_PARALLEL:
        return e->parallel.from_receiver ? mcv_emitter_projected_solid_angle(from) * from->area : 0;
    case MCV_EMITTER_COLLIMATED_BEAM:
        return from->area;
    case MCV_EMITTER_PROJECTOR:
        return from->area * image_tangents(e);
    case MCV_EMITTER_SPOT:
        return aim_spot(smooth, e);
    case MCV_EMITTER_DIRECTIONAL:
        e->light_sine = (float)(smooth->radius * (1 + 1e-6));
        e->directional.reach = (float)(2 * mcv_packed_size(packed));
        for (int k = 0; k < 3; ++k) e->middle[k] = (float)smooth->centre[k];
        return pi * (double)e->light_sine * (double)e->light_sine;
    default:
        return 0;
    }
}

/* The media around the place where the emitter is. */
static uint32_t media_at(const mcv_scene *scene, const mcv_packed *packed, const mcv_device_emitter *e) {
    double point[3];
    if (e->type == MCV_EMITTER_DIRECTIONAL) return 0;
    const float *at = e->type == MCV_EMITTER_SPOT ? e->spot.position : e->middle;
    for (int k = 0; k < 3; ++k) point[k] = (double)at[k] + packed->centre[k];
    return mcv_media_around(scene, packed, point);
}

mcv_result mcv_pack_light(const mcv_scene *scene, mcv_packed *packed, uint32_t *cdf, mcv_error *error) {
    const ball smooth = smooth_ball(packed);
    const bool caustics = smooth.radius > 0 && packed->features >> MCV_FEATURE_NEXT_EVENT & 1;
    uint32_t count = 0;
    bool wide = false;
    for (uint32_t i = 0; i < packed->instance_count; ++i) wide = wide || packed->materials[packed->instances[i].material].wide;
    double *powers = calloc(packed->emitter_count + 1, sizeof *powers);
    if (!powers) return mcv_fail(error, MCV_FAILED, "%s: no memory for the emitters", scene->path);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *from = &scene->emitters[i];
        double mean[3];
        if (!mcv_is_looked_for(from)) continue;
        mcv_device_emitter *e = &packed->emitters[count++];
        if (!caustics && e->type != MCV_EMITTER_COLLIMATED_BEAM) continue;
        /* Glossy surfaces find what has an extent. */
        if (mcv_emitter_has_surface(from->type) && e->type != MCV_EMITTER_COLLIMATED_BEAM && !wide) continue;
        const double flux = unit_flux(packed, &smooth, from, e);
        if (!(flux > 0)) continue;
        mcv_emitter_image_mean(scene, from, mean);
        powers[count - 1] = flux * (from->radiance[0] * mean[0] + from->radiance[1] * mean[1] + from->radiance[2] * mean[2]);
        e->light_flux = (float)flux;
        e->media = media_at(scene, packed, e);
    }
    mcv_write_cdf(cdf, count, powers);
    for (uint32_t i = 0; i < count; ++i) {
        const double chance = (cdf[i + 1] - cdf[i]) * 0x1p-31;
        const bool chosen = powers[i] > 0 && chance > 0;
        packed->emitters[i].light_flux = chosen ? (float)(packed->emitters[i].light_flux / chance) : 0;
    }
    free(powers);
    return MCV_OK;
}

/*
 * What a sensor makes of a point on its axis at the depth z: its brightness, W |d|/z² over the density with which o is chosen; and a
 * pixel's footprint there [m²]. False: light paths cannot reach this type of sensor.
 */
static bool look_at_point(const mcv_sensor *sensor, float z, double *brightness, double *footprint) {
    mcv_sight sight;
    mcv_film_place place;
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

/* No surface lies deeper before the sensor. */
static double greatest_depth(const mcv_packed *packed, const mcv_sensor *sensor) {
    const double *m = sensor->to_world.m;
    double depth = 0;
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        double z = 0;
        for (int k = 0; k < 3; ++k) {
            const double axis = -m[3 * k + 2];
            z += axis * ((axis > 0 ? packed->boxes[i].upper : packed->boxes[i].lower)[k] - m[9 + k]);
        }
        if (isfinite(z)) depth = fmax(depth, z);
    }
    return depth;
}

double mcv_light_density(uint32_t width, uint32_t height) { return pi * (double)mcv_tiled_pixels(width, height); }

bool mcv_traces_light(const mcv_packed *packed, const mcv_sensor *sensor) {
    const bool smooth = smooth_ball(packed).radius > 0;
    const double *m = sensor->to_world.m;
    const double depth = greatest_depth(packed, sensor);
    double brightness, footprint;
    uint32_t width, height;
    if (!(depth > 0) || !look_at_point(sensor, (float)depth, &brightness, &footprint)) return false;
    mcv_sensor_film_size(sensor, &width, &height);
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        const mcv_device_emitter *e = &packed->emitters[i];
        if (!(e->light_flux > 0)) continue;
        if (e->type == MCV_EMITTER_PARALLEL || e->type == MCV_EMITTER_PROJECTOR) {
            /*
             * Camera paths find it, too (mcv_light_share in kernels/sight.h). Light paths cost as much again: they are worth it where one
             * of them brings twice what a camera path does. They do not where what the film sees is small against the emitter's area times
             * sin²β.
             */
            if (mcv_light_density(width, height) * footprint >= 2 * (double)e->light_flux) return true;
            continue;
        }
        if (e->type != MCV_EMITTER_COLLIMATED_BEAM) return true;
        /* Both the beam's axis and the node's z point to where the light goes. */
        const double towards = e->beam.axis[0] * m[2] + e->beam.axis[1] * m[5] + e->beam.axis[2] * m[8];
        if (smooth || (towards > 0 && sensor->type != MCV_SENSOR_PINHOLE)) return true;
    }
    return false;
}

double mcv_splat_unit(const mcv_packed *packed, const mcv_sensor *sensor, const mcv_frame *frame) {
    const float *t = frame->to_world + 9;
    double flux = 0;
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        for (int k = 0; k < 3; ++k) flux = fmax(flux, (double)packed->emitters[i].radiance[k] * packed->emitters[i].light_flux);
    }
    const double distance = fmax(sqrt((double)t[0] * t[0] + (double)t[1] * t[1] + (double)t[2] * t[2]), mcv_packed_size(packed) / 16);
    double brightness = 0, footprint;
    look_at_point(sensor, (float)distance, &brightness, &footprint);
    const double typical = flux / pi * brightness;
    const double exponent = isfinite(typical) && typical > 0 ? floor(log2(typical)) - 16 : 0;
    return exp2(fmin(fmax(exponent, -100), 100));
}
