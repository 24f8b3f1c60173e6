/* SPDX-License-Identifier: Apache-2.0 */
/* What the surfaces of emitters send, and the density with which next-event estimation chooses
 * them. */
#ifndef MCVISI_KERNELS_EMISSION_H
#define MCVISI_KERNELS_EMISSION_H

#include "geometry/surface.h"
#include "light/discrete.h"

/* Has the emitter an image of directions? */
#define MCV_SENDS_BY_PIXEL(e) \
    ((MCV_WITH_LIGHT_FIELD && (e)->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) || \
     (MCV_WITH_PROJECTOR && (e)->type == MCV_EMITTER_PROJECTOR))

/* With RECORDS each pixel of an emitter's image may be a column of the light transport matrix: its
 * image is then replaced by 1 (host/transport/white.h). */
MCV_LOOP_FUNCTION int mcv_is_recorded_by_pixel(__global const mcv_device_emitter *e) {
    return MCV_WITH_RECORDS ? e->emitter_element_width > 0u : 0;
}

#if MCV_WITH_TEXTURE
/* The pixel of an image of directions that sends light from a place in a direction (unit, away from
 * the surface); returns 0, and some pixel, if none does. */
MCV_LOOP_FUNCTION int mcv_find_pixel(mcv_world world, mcv_surface surface,
                                     __global const mcv_device_emitter *e, mcv_vec3 direction,
                                     mcv_pixel *pixel) {
    const float s = mcv_texcoord(world, surface, 0), t = mcv_texcoord(world, surface, 1);
    (void)e, (void)s, (void)t, (void)direction, (void)pixel;
#if MCV_WITH_LIGHT_FIELD
    if (e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER)
        return mcv_light_field_pixel(&e->light_field, s, t, direction, &pixel->column, &pixel->row);
#endif
#if MCV_WITH_PROJECTOR
    __global const mcv_device_texture *image = world.textures + e->texture;
    float across, down;
    const int lit = mcv_projector_place(&e->projector, s, t, direction, &across, &down);
    pixel->column = mcv_cell(lit ? across : 0.0f, image->width);
    pixel->row = mcv_cell(lit ? down : 0.0f, image->height);
    return lit;
#else
    return 0;
#endif
}

/* What an emitter sends through a pixel of its image. */
MCV_LOOP_FUNCTION mcv_color mcv_pixel_radiance(mcv_world world,
                                               __global const mcv_device_emitter *e,
                                               mcv_pixel pixel) {
    return mcv_tint(mcv_texel(world, e->texture, pixel.column, pixel.row),
                    mcv_color_at(e->radiance));
}
#endif

/* Does any surface emit what a ray can meet? */
#define MCV_HAS_EMISSION \
    (MCV_WITH_PARALLEL || MCV_WITH_LIGHT_FIELD || MCV_WITH_PROJECTOR || MCV_WITH_AREA)

#if MCV_HAS_EMISSION
/* The radiance of a point in the directions into which the emitter emits in full. */
MCV_LOOP_FUNCTION mcv_color mcv_full_radiance(mcv_world world, mcv_surface surface, uint emitter) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    mcv_color radiance = mcv_color_at(e->radiance);
    (void)surface;
#if MCV_WITH_TEXTURE
    if ((e->texture != MCV_NONE) & !mcv_is_recorded_by_pixel(e))
        radiance = mcv_tint(radiance, mcv_texture_at(world, surface, e->texture));
#endif
#if MCV_WITH_SCREEN
    const int screen =
        (e->type == MCV_EMITTER_AREA) & (e->surface_light.distribution == MCV_EMITTER_SCREEN);
    const float lit = mcv_screen_lit(&e->surface_light.as.screen, mcv_texcoord(world, surface, 0),
                                     mcv_texcoord(world, surface, 1));
    radiance = mcv_dim(radiance, screen ? lit : 1.0f);
#endif
    return radiance;
}

/* The radiance in a direction (unit, away from the surface) over the full radiance, of an emitter
 * without an image of directions. */
MCV_LOOP_FUNCTION float mcv_angular_profile(__global const mcv_device_emitter *e, mcv_vec3 ng,
                                            mcv_vec3 ns, mcv_vec3 direction) {
    float profile = 0.0f;
    (void)e, (void)ns;
#if MCV_WITH_PARALLEL
    const float parallel = mcv_parallel_evaluate(&e->parallel, direction, ns);
    profile = e->type == MCV_EMITTER_PARALLEL ? parallel : profile;
#endif
#if MCV_WITH_AREA
    const float area = mcv_surface_light_profile(&e->surface_light, mcv_dot(direction, ns));
    profile = e->type == MCV_EMITTER_AREA ? area : profile;
#endif
    return mcv_dot(direction, ng) > 0.0f ? profile : 0.0f;
}

/* Radiance that an emitter's surface sends in a direction (unit, away from the surface), in its
 * medium. Loops know whether the emitter sends by pixel. */
MCV_LOOP_FUNCTION mcv_color mcv_emitted_by(mcv_world world, mcv_surface surface, uint emitter,
                                           mcv_vec3 direction, int by_pixel) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    (void)by_pixel;
#if MCV_WITH_TEXTURE
    if (by_pixel) {
        mcv_pixel pixel;
        const int lit = mcv_find_pixel(world, surface, e, direction, &pixel) &
                        (mcv_dot(direction, surface.ng) > 0.0f);
        mcv_color radiance = mcv_pixel_radiance(world, e, pixel);
        MCV_EACH_CHANNEL(i) radiance.c[i] = lit ? radiance.c[i] : 0.0f;
        return radiance;
    }
#endif
    return mcv_dim(mcv_full_radiance(world, surface, emitter),
                   mcv_angular_profile(e, surface.ng, surface.ns, direction));
}

MCV_LOOP_FUNCTION mcv_color mcv_emitted(mcv_world world, mcv_surface surface, uint emitter,
                                        mcv_vec3 direction) {
    return mcv_emitted_by(world, surface, emitter, direction,
                          MCV_SENDS_BY_PIXEL(world.emitters + emitter));
}
#endif

#if MCV_WITH_NEXT_EVENT && MCV_HAS_EMISSION
#if MCV_WITH_PARALLEL
/*
 * Whether next-event estimation at a receiver samples the emitter's cone of directions, or its
 * area: whichever is the smaller solid angle. The receiver is known up to rounding here and there,
 * so the answer may differ where both are equal to 1e-6: there both are as good, and too few to
 * matter.
 */
MCV_LOOP_FUNCTION int mcv_samples_cone(__global const mcv_device_emitter *e, mcv_vec3 receiver) {
    const mcv_vec3 way = mcv_sub(mcv_vec_at(e->middle), receiver);
    const int wide = e->area > e->parallel.solid_angle * mcv_dot(way, way);
    return (e->type == MCV_EMITTER_PARALLEL) & (e->parallel.from_receiver != 0u) & wide;
}
#endif

/* The probability of a triangle in a choice on an emitter by area. */
MCV_LOOP_FUNCTION float mcv_triangle_pmf(mcv_world world, __global const mcv_device_emitter *e,
                                         uint triangle) {
    return mcv_cdf_pmf(world.emitter_cdf + e->cdf,
                       triangle - world.instances[e->instance].first_triangle);
}

/* The pdf [1/sr] of a direction of an emitter that is sampled uniform in a solid angle: a rectangle
 * close by, a parallel emitter's cone. */
MCV_LOOP_FUNCTION float mcv_uniform_pdf(__global const mcv_device_emitter *e, float solid_angle) {
    return e->probability / solid_angle;
}

/* The density [1/sr] of directions to a place on an emitter at the given distance, chosen uniform
 * by area. */
MCV_LOOP_FUNCTION float mcv_area_density(__global const mcv_device_emitter *e, float pmf,
                                         mcv_surface surface, mcv_vec3 direction, float distance) {
    return e->probability * pmf * distance * distance /
           (surface.area * mcv_abs(mcv_dot(direction, surface.ng)));
}

#if MCV_WITH_RECTANGLE
#define mcv_is_rectangle(e) ((e)->rectangle.width > 0.0f)

MCV_LOOP_FUNCTION mcv_rectangle_view mcv_view_emitter(__global const mcv_device_emitter *e,
                                                      mcv_vec3 receiver) {
    return mcv_view_rectangle(&e->rectangle, mcv_vec_at(e->facing), receiver);
}
#else
#define mcv_is_rectangle(e) 0
#endif

/* That with which next-event estimation at a receiver chooses the direction to such a place; of a
 * rectangle or not; pmf: its triangle's.
 */
MCV_LOOP_FUNCTION float mcv_density_towards(__global const mcv_device_emitter *e, int rectangle,
                                            float pmf, mcv_vec3 receiver, mcv_surface surface,
                                            mcv_vec3 direction, float distance) {
    float density = mcv_area_density(e, pmf, surface, direction, distance);
    (void)rectangle, (void)receiver;
#if MCV_WITH_RECTANGLE
    if (rectangle) {
        const mcv_rectangle_view view = mcv_view_emitter(e, receiver);
        density = mcv_samples_solid_angle(view) ? mcv_uniform_pdf(e, view.solid_angle) : density;
    }
#endif
#if MCV_WITH_PARALLEL
    const float cone = mcv_uniform_pdf(e, e->parallel.solid_angle);
    density = mcv_samples_cone(e, receiver) ? cone : density;
#endif
    return density;
}
#endif

#endif
