/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Single elements over arrays of cases, one work-item per case: how the tests see the very
 * functions that the stages call (tests/kernels/test_elements.c compares them with the reference).
 */
#include "path/sampler.h"
#include "world.h"
#include "mcvisi/elementary.h"
#include "mcvisi/emitters/environment.h"
#include "mcvisi/emitters/light_field.h"
#include "mcvisi/emitters/parallel.h"
#include "mcvisi/emitters/projector.h"
#include "mcvisi/materials/dielectric.h"
#if MCV_WITH_GLOSSY
#include "bsdf/microfacet.h"
#endif
#if MCV_WITH_REFLECTOR
#include "bsdf/retroreflector.h"
#endif

/* cases: column, row, x, y, ξ, η as words (integers first); sights: origin, direction, weight. */
__kernel void sample_sensor(__constant const mcv_sensor *sensor, __global const uint *cases,
                            __global float *sights) {
    const uint i = get_global_id(0);
    __global const uint *in = cases + 6 * i;
    mcv_film_sample film;
    film.column = in[0];
    film.row = in[1];
    film.x = as_float(in[2]);
    film.y = as_float(in[3]);
    const mcv_sensor_ray sensor_ray =
        mcv_sensor_sample(sensor, film, as_float(in[4]), as_float(in[5]));
    __global float *out = sights + 7 * i;
    out[0] = sensor_ray.origin.x;
    out[1] = sensor_ray.origin.y;
    out[2] = sensor_ray.origin.z;
    out[3] = sensor_ray.direction.x;
    out[4] = sensor_ray.direction.y;
    out[5] = sensor_ray.direction.z;
    out[6] = sensor_ray.weight;
}

#if MCV_WITH_LIGHT_TRACING
/* cases: as above, then a depth; results: the place on the film that is found again, W, and there
 * the lens's area and the footprint. */
__kernel void invert_sensor(__constant const mcv_sensor *sensor, __global const uint *cases,
                            __global float *results) {
    const uint i = get_global_id(0);
    __global const uint *in = cases + 7 * i;
    mcv_film_sample film;
    mcv_film_point place;
    mcv_sensor_ray back;
    film.column = in[0];
    film.row = in[1];
    film.x = as_float(in[2]);
    film.y = as_float(in[3]);
    const float depth = as_float(in[6]);
    const mcv_sensor_ray sensor_ray =
        mcv_sensor_sample(sensor, film, as_float(in[4]), as_float(in[5]));
    __global float *out = results + 6 * i;
    out[2] = mcv_sensor_invert(sensor, sensor_ray, &place);
    out[0] = place.column;
    out[1] = place.row;
    out[3] = mcv_sensor_connect(sensor, mcv_along(sensor_ray.origin, depth, sensor_ray.direction),
                                as_float(in[4]), as_float(in[5]), &back);
    out[4] = mcv_sensor_footprint(sensor, depth);
    out[5] = sensor_ray.weight;
}
#endif

/* cases: stream, sample, depth, use: 0 … 2 as MCV_PAIR_SCATTER …, else the sensor's; results: the
 * pair's number, then the pair. */
__kernel void draw_pairs(__global const uint *cases, __global uint *results) {
    const uint i = get_global_id(0);
    __global const uint *in = cases + 4 * i;
    const uint number = in[3] < (uint)MCV_PAIR_STRIDE ? MCV_SURFACE_PAIR(in[2], in[3])
                        : in[2]                       ? (uint)MCV_PAIR_APERTURE
                                                      : (uint)MCV_PAIR_PIXEL;
    const mcv_pair pair = mcv_sample_pair(in[0], in[1], number);
    results[3 * i] = number;
    results[3 * i + 1] = as_uint(pair.x);
    results[3 * i + 2] = as_uint(pair.y);
}

/* cases: direction, normal; shares: of the radiance that leaves in that direction. */
__kernel void evaluate_parallel(__global const mcv_parallel *emitter, __global const float *cases,
                                __global float *shares) {
    const uint i = get_global_id(0);
    __global const float *in = cases + 6 * i;
    shares[i] =
        mcv_parallel_evaluate(emitter, mcv_vec(in[0], in[1], in[2]), mcv_vec(in[3], in[4], in[5]));
}

/* cases: place on the emitter, direction; pixels: column and row, MCV_NONE where it is dark. */
__kernel void find_light_field_pixels(__global const mcv_light_field_emitter *emitter,
                                      __global const float *cases, __global uint *pixels) {
    const uint i = get_global_id(0);
    __global const float *in = cases + 5 * i;
    uint column, row;
    const int lit =
        mcv_light_field_pixel(emitter, in[0], in[1], mcv_vec(in[2], in[3], in[4]), &column, &row);
    pixels[2 * i] = lit ? column : MCV_NONE;
    pixels[2 * i + 1] = lit ? row : MCV_NONE;
}

/* cases: place on the lens, direction; places on the image, -1 where it is dark. */
__kernel void find_projector_places(__global const mcv_projector *emitter,
                                    __global const float *cases, __global float *places) {
    const uint i = get_global_id(0);
    __global const float *in = cases + 5 * i;
    float across, down;
    const int lit =
        mcv_projector_place(emitter, in[0], in[1], mcv_vec(in[2], in[3], in[4]), &across, &down);
    places[2 * i] = lit ? across : -1.0f;
    places[2 * i + 1] = lit ? down : -1.0f;
}

/* cases: column and row as words, ξ, η; results: direction, its column and row, a pixel's solid
 * angle. */
__kernel void sample_environment(__global const mcv_environment *sky, __global const uint *cases,
                                 __global float *results) {
    const uint i = get_global_id(0);
    __global const uint *in = cases + 4 * i;
    __global float *out = results + 6 * i;
    uint column, row;
    const mcv_vec3 d = mcv_environment_sample(sky, in[0], in[1], as_float(in[2]), as_float(in[3]));
    mcv_environment_pixel(sky, d, &column, &row);
    out[0] = d.x;
    out[1] = d.y;
    out[2] = d.z;
    out[3] = (float)column;
    out[4] = (float)row;
    out[5] = mcv_environment_solid_angle(sky, in[1]);
}

/* cases: η, δ, incident direction, normal on its side; results: reflectance, c2, refracted
 * direction (0 under total reflection). */
__kernel void refract_directions(__global const float *cases, __global float *results) {
    const uint i = get_global_id(0);
    __global const float *in = cases + 8 * i;
    __global float *out = results + 5 * i;
    const mcv_vec3 d = mcv_vec(in[2], in[3], in[4]);
    const mcv_vec3 n = mcv_vec(in[5], in[6], in[7]);
    mcv_device_interface between;
    between.eta = in[0];
    between.delta = in[1];
    const float c1 = min(-mcv_dot(d, n), 1.0f);
    const float c2 = mcv_refracted_cosine(between, c1);
    const mcv_vec3 t = c2 > 0.0f ? mcv_refract(between, d, n, c1, c2) : mcv_vec(0.0f, 0.0f, 0.0f);
    out[0] = mcv_fresnel(between, c1, c2);
    out[1] = c2;
    out[2] = t.x;
    out[3] = t.y;
    out[4] = t.z;
}

/* cases: ξ, η, sin(β/2); directions about +z. */
__kernel void sample_cones(__global const float *cases, __global float *directions) {
    const uint i = get_global_id(0);
    const mcv_vec3 d = mcv_sample_cone(cases[3 * i + 2], cases[3 * i], cases[3 * i + 1]);
    directions[3 * i] = d.x;
    directions[3 * i + 1] = d.y;
    directions[3 * i + 2] = d.z;
}

#if MCV_WITH_GLOSSY
/* A glossy surface, before its albedos. */
typedef struct mcv_glossy_case {
    mcv_device_glossy material;
    mcv_microfacets microfacets;
    uint padding[4];
} mcv_glossy_case;

/* cases: o, i; results: f cosθ of the first channel, density. */
__kernel void evaluate_gloss(__global const mcv_glossy_case *surface, __global const float *cases,
                             __global float *results) {
    const uint k = get_global_id(0);
    __global const float *in = cases + 6 * k;
    __global const float *albedos = (__global const float *)(surface + 1);
    const mcv_vec3 o = mcv_vec(in[0], in[1], in[2]);
    const mcv_microfacets microfacets = surface->microfacets;
    const mcv_device_glossy material = surface->material;
    const mcv_lobes lobes = mcv_microfacet_lobes(&material, &microfacets, albedos, o);
    const mcv_response response = mcv_microfacet_respond(&material, &microfacets, albedos, &lobes,
                                                         o, mcv_vec(in[3], in[4], in[5]));
    results[2 * k] = response.f_cos.c[0];
    results[2 * k + 1] = response.density;
}

/* cases: o, ξ, η, choice; directions. */
__kernel void sample_gloss(__global const mcv_glossy_case *surface, __global const float *cases,
                           __global float *directions) {
    const uint k = get_global_id(0);
    __global const float *in = cases + 6 * k;
    __global const float *albedos = (__global const float *)(surface + 1);
    const mcv_vec3 o = mcv_vec(in[0], in[1], in[2]);
    const mcv_microfacets microfacets = surface->microfacets;
    const mcv_device_glossy material = surface->material;
    const mcv_lobes lobes = mcv_microfacet_lobes(&material, &microfacets, albedos, o);
    const mcv_vec3 i =
        mcv_microfacet_sample(&material, &microfacets, &lobes, o, in[3], in[4], in[5]);
    directions[3 * k] = i.x;
    directions[3 * k + 1] = i.y;
    directions[3 * k + 2] = i.z;
}
#endif

#if MCV_WITH_REFLECTOR
/* About the normal (0, 0, 1); cases: o, i; results: f cosθ of the first channel, density,
 * efficiency and chance of returning. */
__kernel void evaluate_retroreflector(__global const mcv_device_material *material,
                                      __global const float *cases, __global float *results) {
    const uint k = get_global_id(0);
    __global const float *in = cases + 6 * k;
    const mcv_vec3 n = mcv_vec(0.0f, 0.0f, 1.0f);
    const mcv_vec3 o = mcv_vec(in[0], in[1], in[2]);
    const mcv_response response =
        mcv_retroreflector_respond(material, n, o, mcv_vec(in[3], in[4], in[5]));
    const mcv_retroreflection back = mcv_retroreflection_at(material, n, o);
    results[4 * k] = response.f_cos.c[0];
    results[4 * k + 1] = response.density;
    results[4 * k + 2] = back.efficiency;
    results[4 * k + 3] = back.chance;
}

/* cases: o, ξ, η, choice; directions, o itself where light returns exactly. */
__kernel void sample_retroreflector(__global const mcv_device_material *material,
                                    __global const float *cases, __global float *directions) {
    const uint k = get_global_id(0);
    __global const float *in = cases + 6 * k;
    const mcv_vec3 n = mcv_vec(0.0f, 0.0f, 1.0f);
    const mcv_vec3 o = mcv_vec(in[0], in[1], in[2]);
    const mcv_retroreflection back = mcv_retroreflection_at(material, n, o);
    const mcv_vec3 i =
        mcv_retroreflector_choose(material, n, o, in[3], in[4], in[5] >= 1.0f - back.chance);
    directions[3 * k] = i.x;
    directions[3 * k + 1] = i.y;
    directions[3 * k + 2] = i.z;
}
#endif

/* exp(-x) */
__kernel void attenuate(__global const float *x, __global float *y) {
    const uint i = get_global_id(0);
    y[i] = mcv_exp_minus(x[i]);
}
