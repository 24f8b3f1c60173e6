/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Emitters that next-event estimation samples at a point of their surface: uniform by area, or
 * uniform in solid angle on a rectangle that subtends a large angle.
 */
#ifndef MCVISI_KERNELS_EMITTER_POINT_H
#define MCVISI_KERNELS_EMITTER_POINT_H

#include "geometry/surface.h"
#include "light/discrete.h"
#include "light/emitter_element.h"
#include "light/emission.h"
#include "light/light_sample.h"

#if MCV_HAS_EMISSION || MCV_WITH_BEAM
/* A point on a triangle of an emitter. */
typedef struct mcv_emitter_point {
    mcv_facet facet;
    float u, v;
    float pmf;     /* of the facet, in a choice by area */
    float density; /* with which it is chosen [1/sr]; 0: by area */
} mcv_emitter_point;

/* The two triangles of a rectangle, and their probabilities. */
typedef struct mcv_facets {
    mcv_facet first, second;
    float first_pmf, second_pmf;
} mcv_facets;

/* The triangle that a pair chooses, counted from the emitter's first. */
MCV_FUNCTION uint mcv_choose_triangle(mcv_world world, __global const mcv_device_emitter *e,
                                      mcv_pair pair) {
    return mcv_search_cdf(world.emitter_cdf + e->cdf, e->triangle_count,
                          mcv_cdf_bits(pair.x, pair.y));
}

/* The pair's point on the triangle that it has chosen, uniform by area. */
MCV_LOOP_FUNCTION mcv_emitter_point mcv_point_on_mesh(mcv_world world,
                                                      __global const mcv_device_emitter *e,
                                                      uint triangle, mcv_pair pair) {
    mcv_emitter_point point;
    __global const uint *cdf = world.emitter_cdf + e->cdf;
    const float root = mcv_sqrt(mcv_cdf_remainder(cdf, triangle, mcv_cdf_bits(pair.x, pair.y)));
    point.facet = mcv_facet_of(world, world.instances[e->instance].first_triangle + triangle);
    point.u = root * (1.0f - pair.y);
    point.v = root * pair.y;
    point.pmf = mcv_cdf_pmf(cdf, triangle);
    point.density = 0.0f;
    return point;
}
#endif

#if MCV_HAS_EMISSION && MCV_WITH_NEXT_EVENT
/*
 * Bound of the error with which a ray from the receiver meets the triangle of a place that has an
 * error itself, per coordinate. The traversal works on the corners relative to the ray's origin, of
 * which R is the largest coordinate: shearing them rounds by γ(6) R, the depth by 12 u R
 * (mcv_intersect_leaf), the ray's end and t itself by 4 u R. Close to the world's origin this is
 * more than the error of the point.
 */
MCV_LOOP_FUNCTION mcv_vec3 mcv_interaction_error(mcv_vec3 receiver, mcv_facet facet,
                                                 mcv_vec3 error) {
    float largest = 0.0f;
    const mcv_vec3 corners[3] = {facet.a, facet.b, facet.c};
#pragma unroll
    for (int i = 0; i < 3; ++i) {
        const mcv_vec3 way = mcv_sub(corners[i], receiver);
        const float flat = mcv_abs(way.x) > mcv_abs(way.y) ? mcv_abs(way.x) : mcv_abs(way.y);
        const float far = mcv_abs(way.z) > flat ? mcv_abs(way.z) : flat;
        largest = far > largest ? far : largest;
    }
    const float more = MCV_GAMMA(16) * largest;
    return mcv_vec(error.x + more, error.y + more, error.z + more);
}

#if MCV_WITH_RECTANGLE
MCV_LOOP_FUNCTION mcv_facets mcv_facets_of(mcv_world world, __global const mcv_device_emitter *e) {
    mcv_facets two;
    const uint first = world.instances[e->instance].first_triangle;
    two.first = mcv_facet_of(world, first);
    two.second = mcv_facet_of(world, first + 1u);
    two.first_pmf = mcv_triangle_pmf(world, e, first);
    two.second_pmf = mcv_triangle_pmf(world, e, first + 1u);
    return two;
}

MCV_LOOP_FUNCTION mcv_facet mcv_either_facet(int first, const mcv_facets *of) {
    mcv_facet facet;
    facet.a = mcv_either(first, of->first.a, of->second.a);
    facet.b = mcv_either(first, of->first.b, of->second.b);
    facet.c = mcv_either(first, of->first.c, of->second.c);
    facet.ng = mcv_either(first, of->first.ng, of->second.ng);
    facet.area = first ? of->first.area : of->second.area;
#if MCV_WITH_NORMALS
    facet.normal_a = mcv_either(first, of->first.normal_a, of->second.normal_a);
    facet.normal_b = mcv_either(first, of->first.normal_b, of->second.normal_b);
    facet.normal_c = mcv_either(first, of->first.normal_c, of->second.normal_c);
#endif
    facet.triangle = first ? of->first.triangle : of->second.triangle;
    facet.corners.x = first ? of->first.corners.x : of->second.corners.x;
    facet.corners.y = first ? of->first.corners.y : of->second.corners.y;
    facet.corners.z = first ? of->first.corners.z : of->second.corners.z;
    facet.corners.w = of->first.corners.w;
    return facet;
}

MCV_LOOP_FUNCTION float mcv_on_triangle(__global const float *map, float s, float t) {
    return mcv_fma(map[1], s, mcv_fma(map[2], t, map[0]));
}

/* A point on a rectangle that the receiver sees: uniform in solid angle, from afar by area. */
MCV_LOOP_FUNCTION mcv_emitter_point mcv_point_on_rectangle(__global const mcv_device_emitter *e,
                                                           const mcv_facets *of, mcv_vec3 receiver,
                                                           mcv_pair pair) {
    __global const mcv_rectangle *r = &e->rectangle;
    mcv_emitter_point point;
    const mcv_rectangle_view view = mcv_view_emitter(e, receiver);
    const int close = mcv_samples_solid_angle(view);
    float s, t;
    mcv_sample_rectangle(r, view, pair.x, pair.y, &s, &t);
    s = close ? s : pair.x;
    t = close ? t : pair.y;
    const float u = mcv_on_triangle(r->to_triangle[0], s, t),
                v = mcv_on_triangle(r->to_triangle[0] + 3, s, t);
    const float least = u < v ? u : v, other = 1.0f - u - v;
    const int first = (least < other ? least : other) >= 0.0f;
    const float second_u = mcv_on_triangle(r->to_triangle[1], s, t),
                second_v = mcv_on_triangle(r->to_triangle[1] + 3, s, t);
    point.facet = mcv_either_facet(first, of);
    point.u = first ? u : second_u;
    point.v = first ? v : second_v;
    point.pmf = first ? of->first_pmf : of->second_pmf;
    point.density = close ? mcv_uniform_pdf(e, view.solid_angle) : 0.0f;
    return point;
}
#endif

/* What comes from a point; of an emitter with an image as without. *there: the point as a surface.
 */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_point(mcv_receiver at,
                                                    __global const mcv_device_emitter *e,
                                                    mcv_emitter_point point, mcv_surface *there) {
    *there = mcv_surface_on(point.facet, point.u, point.v);
    const mcv_vec3 way = mcv_sub(there->point, at.point), towards = mcv_normalize(way),
                   back = mcv_scale(towards, -1.0f),
                   error = mcv_interaction_error(at.point, point.facet, there->error);
    const float by_area =
        mcv_area_density(e, point.pmf, *there, towards, mcv_sqrt(mcv_dot(way, way)));
    mcv_light_sample sample = mcv_light_sample_along(
        at, towards, MCV_NONE, point.density > 0.0f ? point.density : by_area);
    sample.direction =
        mcv_sub(mcv_offset_origin(there->point, error, there->ng, back), sample.origin);
    /* Only a face seen exactly edge-on has no finite density. */
    const float profile = mcv_angular_profile(e, there->ng, there->ns, back);
    const int lit = (sample.pdf > 0.0f) & (sample.pdf < INFINITY) & (profile > 0.0f);
    sample.radiance_over_pdf = mcv_radiance_over_pdf(e, lit, profile / sample.pdf, 1.0f);
    return sample;
}

#if MCV_WITH_TEXTURE
/* Whether what an emitter sends varies over its surface, or in more ways than by the angle. */
MCV_FUNCTION int mcv_has_image(__global const mcv_device_emitter *e) {
    return e->texture != MCV_NONE;
}

/* The sample of mcv_sample_point with what comes from there, by the emitter's image. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_light_sample_by_image(mcv_world world, mcv_vec3 receiver,
                                                             mcv_surface there, uint emitter,
                                                             mcv_light_sample sample,
                                                             int by_pixel) {
    const mcv_vec3 back = mcv_scale(mcv_normalize(mcv_sub(there.point, receiver)), -1.0f);
    const int lit = (sample.pdf > 0.0f) & (sample.pdf < INFINITY);
    const mcv_color light =
        mcv_dim(mcv_emitted_by(world, there, emitter, back, by_pixel), 1.0f / sample.pdf);
    MCV_EACH_CHANNEL(i) sample.radiance_over_pdf.c[i] = lit ? light.c[i] : 0.0f;
    if (MCV_WITH_RECORDS)
        sample.emitter_element = mcv_emitter_element_by(world, emitter, there, back, by_pixel);
    return sample;
}
#endif
#endif

#endif
