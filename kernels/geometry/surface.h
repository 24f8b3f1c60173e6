/* SPDX-License-Identifier: Apache-2.0 */
/* What lies at a hit: point with its error, normals, material, and what it emits. */
#ifndef MCVISI_KERNELS_SURFACE_H
#define MCVISI_KERNELS_SURFACE_H

#include "mcvisi/offset.h"
#include "world.h"
#if MCV_WITH_TEXTURE
#include "geometry/texture.h"
#endif

/* The three vertices of a triangle and its instance. No vector: the compiler vectorises loops of
 * scalars only. */
typedef struct mcv_corners {
    uint x, y, z, w;
} mcv_corners;

typedef struct mcv_surface {
    mcv_vec3 point, error; /* [m]; |error of a coordinate| */
    mcv_vec3 face;         /* unit normal of the triangle, on the front side */
    mcv_vec3 normal;       /* interpolated, unit, on the front side */
    float area;            /* of the triangle [m²] */
    uint triangle, instance;
    float u, v;
    mcv_corners corners;
} mcv_surface;

MCV_FUNCTION mcv_vec3 mcv_vertex_vector(__global const float *vectors, uint vertex) {
    return mcv_vec(vectors[3 * vertex], vectors[3 * vertex + 1], vectors[3 * vertex + 2]);
}

MCV_FUNCTION mcv_corners mcv_triangle_corners(mcv_world world, uint triangle) {
    __global const uint *words = (__global const uint *)(world.triangles + triangle);
    mcv_corners corners;
    corners.x = words[0];
    corners.y = words[1];
    corners.z = words[2];
    corners.w = words[3];
    return corners;
}

/* The instance that a hit is on. */
MCV_FUNCTION uint mcv_instance_of(mcv_world world, uint triangle) {
#if MCV_WITH_SURFACES
    if (triangle >= MCV_EXACT)
        return world.solids[mcv_solid_of(triangle)].instance[mcv_piece_of(triangle)];
#endif
    return world.triangles[triangle].w;
}

#if MCV_WITH_NORMALS
MCV_FUNCTION mcv_vec3 mcv_interpolate(mcv_vec3 a, mcv_vec3 b, mcv_vec3 c, float u, float v) {
    return mcv_along(mcv_along(mcv_scale(a, 1.0f - u - v), u, b), v, c);
}
#endif

/* What all places on a triangle share. */
typedef struct mcv_facet {
    mcv_vec3 a, b, c; /* its corners [m] */
    mcv_vec3 face;
    float area;
#if MCV_WITH_NORMALS
    mcv_vec3 normal_a, normal_b, normal_c; /* there */
#endif
    uint triangle;
    mcv_corners corners;
} mcv_facet;

MCV_LOOP_FUNCTION mcv_facet mcv_facet_of(mcv_world world, uint triangle) {
    mcv_facet facet;
    const mcv_corners corners = mcv_triangle_corners(world, triangle);
    facet.triangle = triangle;
    facet.corners = corners;
    facet.a = mcv_vertex_vector(world.positions, corners.x);
    facet.b = mcv_vertex_vector(world.positions, corners.y);
    facet.c = mcv_vertex_vector(world.positions, corners.z);
    const mcv_vec3 doubled = mcv_cross(mcv_sub(facet.b, facet.a), mcv_sub(facet.c, facet.a));
    facet.face = mcv_normalize(doubled);
    facet.area = 0.5f * mcv_sqrt(mcv_dot(doubled, doubled));
#if MCV_WITH_NORMALS
    facet.normal_a = mcv_vertex_vector(world.normals, corners.x);
    facet.normal_b = mcv_vertex_vector(world.normals, corners.y);
    facet.normal_c = mcv_vertex_vector(world.normals, corners.z);
#endif
    return facet;
}

/* The place (u, v) on it. */
MCV_LOOP_FUNCTION mcv_surface mcv_surface_on(mcv_facet facet, float u, float v) {
    mcv_surface surface;
    surface.triangle = facet.triangle;
    surface.instance = facet.corners.w;
    surface.corners = facet.corners;
    surface.u = u;
    surface.v = v;
    surface.point = mcv_hit_point(facet.a, facet.b, facet.c, u, v, &surface.error);
    surface.face = facet.face;
    surface.area = facet.area;
    surface.normal = surface.face;
#if MCV_WITH_NORMALS
    const mcv_vec3 n =
        mcv_normalize(mcv_interpolate(facet.normal_a, facet.normal_b, facet.normal_c, u, v));
    /* Opposite vertex normals may cancel, and those of a flat mesh are 0: the face's then. */
    surface.normal = mcv_choose(mcv_dot(n, n) > 0.5f, n, surface.face);
#endif
    return surface;
}

MCV_LOOP_FUNCTION mcv_surface mcv_surface_at(mcv_world world, uint triangle, float u, float v) {
    return mcv_surface_on(mcv_facet_of(world, triangle), u, v);
}

#if MCV_WITH_TEXTURE
/* Coordinate 0 or 1 of the place in the set of texture coordinates that begins with `first`. */
MCV_LOOP_FUNCTION float mcv_texcoord_of(mcv_world world, mcv_surface surface, uint first,
                                        uint axis) {
    const float w = 1.0f - surface.u - surface.v;
    __global const float *a = world.texcoords + 2 * (first + surface.corners.x);
    __global const float *b = world.texcoords + 2 * (first + surface.corners.y);
    __global const float *c = world.texcoords + 2 * (first + surface.corners.z);
    return mcv_fma(surface.v, c[axis], mcv_fma(surface.u, b[axis], w * a[axis]));
}

MCV_LOOP_FUNCTION float mcv_texcoord(mcv_world world, mcv_surface surface, uint axis) {
    return mcv_texcoord_of(world, surface, 0, axis);
}

/* How far across (0) or down (1) a texture's image the place lies. */
MCV_LOOP_FUNCTION float mcv_image_place(mcv_world world, mcv_surface surface, uint texture,
                                        uint axis) {
    __global const mcv_device_texture *t = world.textures + texture;
    __global const float *row = t->transform + 3 * axis;
    const float u = mcv_texcoord_of(world, surface, t->first_texcoord, 0);
    const float v = mcv_texcoord_of(world, surface, t->first_texcoord, 1);
    return mcv_fma(row[0], u, mcv_fma(row[1], v, row[2]));
}

MCV_LOOP_FUNCTION mcv_color mcv_texture_at(mcv_world world, mcv_surface surface, uint texture) {
    return mcv_texture_lookup(world, texture, mcv_image_place(world, surface, texture, 0),
                              mcv_image_place(world, surface, texture, 1));
}
#endif

#if MCV_WITH_GLOSS
/* The direction that lies at an angle, given by its cosine and sine, from the tangent; along the
 * surface only about. */
MCV_FUNCTION mcv_vec3 mcv_tangent(mcv_world world, mcv_surface surface, const float *angle) {
    const uint corners[3] = {surface.corners.x, surface.corners.y, surface.corners.z};
    const float weights[3] = {1.0f - surface.u - surface.v, surface.u, surface.v};
    mcv_vec3 tangent = mcv_vec(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < 3; ++i) {
        __global const float *t = world.tangents + 4 * corners[i];
        tangent = mcv_along(tangent, weights[i], mcv_vec(t[0], t[1], t[2]));
    }
    const float hand = world.tangents[4 * surface.corners.x + 3];
    const mcv_vec3 x =
        mcv_normalize(mcv_along(tangent, -mcv_dot(tangent, surface.normal), surface.normal));
    return mcv_along(mcv_scale(x, angle[0]), hand * angle[1], mcv_cross(surface.normal, x));
}
#endif

/* Reflectance or transmittance, texture included. */
MCV_LOOP_FUNCTION mcv_color mcv_material_value(mcv_world world, mcv_surface surface,
                                               uint material) {
    mcv_color value;
    MCV_EACH_CHANNEL(i) value.c[i] = world.materials[material].value[i];
    (void)surface;
#if MCV_WITH_TEXTURE
    if (world.materials[material].texture != MCV_NONE) {
        value = mcv_tint(value, mcv_texture_at(world, surface, world.materials[material].texture));
    }
#endif
    return value;
}

#if MCV_WITH_TRANSLUCENT
/* The transmittance of a translucent one, texture included. */
MCV_LOOP_FUNCTION mcv_color mcv_material_passed(mcv_world world, mcv_surface surface,
                                                uint material) {
    mcv_color passed;
    MCV_EACH_CHANNEL(i) passed.c[i] = world.materials[material].passed[i];
    (void)surface;
#if MCV_WITH_TEXTURE
    if (world.materials[material].texture != MCV_NONE)
        passed =
            mcv_tint(passed, mcv_texture_at(world, surface, world.materials[material].texture));
#endif
    return passed;
}
#endif

#if MCV_WITH_LIGHT_FIELD && MCV_WITH_TEXTURE
/* The image's value for a place on a light field emitter and a direction. */
MCV_FUNCTION mcv_color mcv_light_field_value(mcv_world world, mcv_surface surface,
                                             __global const mcv_device_emitter *e,
                                             mcv_vec3 direction) {
    uint column, row;
    const float s = mcv_texcoord(world, surface, 0);
    const float t = mcv_texcoord(world, surface, 1);
    if (!mcv_light_field_pixel(&e->light_field, s, t, direction, &column, &row))
        return mcv_grey(0.0f);
    return mcv_texel(world, world.textures[e->texture], (int)column, (int)row);
}
#endif

#if MCV_WITH_PROJECTOR && MCV_WITH_TEXTURE
/* The image's value for a place on a projector's lens and a direction. */
MCV_FUNCTION mcv_color mcv_projector_value(mcv_world world, mcv_surface surface,
                                           __global const mcv_device_emitter *e,
                                           mcv_vec3 direction) {
    const mcv_device_texture image = world.textures[e->texture];
    float across, down;
    const float s = mcv_texcoord(world, surface, 0);
    const float t = mcv_texcoord(world, surface, 1);
    if (!mcv_projector_place(&e->projector, s, t, direction, &across, &down)) return mcv_grey(0.0f);
    return mcv_texel(world, image, (int)mcv_cell(across, image.width),
                     (int)mcv_cell(down, image.height));
}
#endif

/* Does any surface emit what a ray can meet? */
#define MCV_WITH_EMISSION \
    (MCV_WITH_PARALLEL || MCV_WITH_LIGHT_FIELD || MCV_WITH_PROJECTOR || MCV_WITH_AREA)

#if MCV_WITH_EMISSION
/* Radiance of a place where the emitter shines into a direction. */
MCV_LOOP_FUNCTION mcv_color mcv_full_radiance(mcv_world world, mcv_surface surface, uint emitter) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    mcv_color radiance;
    MCV_EACH_CHANNEL(i) radiance.c[i] = e->radiance[i];
    (void)surface;
#if MCV_WITH_TEXTURE
    if (e->texture != MCV_NONE)
        radiance = mcv_tint(radiance, mcv_texture_at(world, surface, e->texture));
#endif
    return radiance;
}

/* Whether an emitter of a type that sends its full radiance or nothing shines in a direction (unit,
 * away from the surface). */
MCV_LOOP_FUNCTION int mcv_shines(__global const mcv_device_emitter *e, mcv_vec3 face,
                                 mcv_vec3 normal, mcv_vec3 direction) {
    float share = 0.0f;
    (void)e, (void)normal;
#if MCV_WITH_PARALLEL
    const float parallel = mcv_parallel_evaluate(&e->parallel, direction, normal);
    share = e->type == MCV_EMITTER_PARALLEL ? parallel : share;
#endif
#if MCV_WITH_AREA
    const float everywhere = mcv_area_evaluate(direction, normal);
    share = e->type == MCV_EMITTER_AREA ? everywhere : share;
#endif
    return (share > 0.0f) & (mcv_dot(direction, face) > 0.0f);
}

/* Radiance that an emitter's surface sends in a direction (unit, away from the surface), in its
 * medium. */
MCV_LOOP_FUNCTION mcv_color mcv_emitted(mcv_world world, mcv_surface surface, uint emitter,
                                        mcv_vec3 direction) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    if (!(mcv_dot(direction, surface.face) > 0.0f)) return mcv_grey(0.0f);
#if MCV_WITH_LIGHT_FIELD && MCV_WITH_TEXTURE
    if (e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) {
        mcv_color radiance = mcv_light_field_value(world, surface, e, direction);
        MCV_EACH_CHANNEL(i) radiance.c[i] *= e->radiance[i];
        return radiance;
    }
#endif
#if MCV_WITH_PROJECTOR && MCV_WITH_TEXTURE
    if (e->type == MCV_EMITTER_PROJECTOR) {
        mcv_color radiance = mcv_projector_value(world, surface, e, direction);
        MCV_EACH_CHANNEL(i) radiance.c[i] *= e->radiance[i];
        return radiance;
    }
#endif
    return mcv_shines(e, surface.face, surface.normal, direction)
               ? mcv_full_radiance(world, surface, emitter)
               : mcv_grey(0.0f);
}
#endif

#if MCV_WITH_NEXT_EVENT && MCV_WITH_EMISSION
#if MCV_WITH_PARALLEL
/*
 * Whether next-event estimation at a receiver samples the emitter's cone of directions, or its
 * area: whichever is the smaller solid angle. The receiver is known up to rounding here and there,
 * so the answer may differ where both are equal to 1e-6: there both are as good, and too few to
 * matter.
 */
MCV_LOOP_FUNCTION int mcv_samples_cone(__global const mcv_device_emitter *e, mcv_vec3 receiver) {
    const mcv_vec3 way = mcv_sub(mcv_vec(e->middle[0], e->middle[1], e->middle[2]), receiver);
    const int wide = e->area > e->parallel.solid_angle * mcv_dot(way, way);
    return (e->type == MCV_EMITTER_PARALLEL) & (e->parallel.from_receiver != 0u) & wide;
}
#endif

/* Of the choices on an emitter those of a triangle. */
MCV_LOOP_FUNCTION float mcv_triangle_share(mcv_world world, __global const mcv_device_emitter *e,
                                           uint triangle) {
    __global const uint *cdf =
        world.emitter_cdf + e->cdf + (triangle - world.instances[e->instance].first_triangle);
    return (float)(cdf[1] - cdf[0]) * 4.656612873077393e-10f; /* 2^-31 */
}

/* The density [1/sr] of directions to a place on an emitter at the given distance, chosen uniform
 * by area. */
MCV_LOOP_FUNCTION float mcv_area_density(__global const mcv_device_emitter *e, float share,
                                         mcv_surface surface, mcv_vec3 direction, float distance) {
    return e->probability * share * distance * distance /
           (surface.area * mcv_abs(mcv_dot(direction, surface.face)));
}

#if MCV_WITH_RECTANGLE
#define mcv_is_rectangle(e) ((e)->rectangle.width > 0.0f)

MCV_LOOP_FUNCTION mcv_rectangle_view mcv_view_emitter(__global const mcv_device_emitter *e,
                                                      mcv_vec3 receiver) {
    return mcv_view_rectangle(&e->rectangle, mcv_vec(e->facing[0], e->facing[1], e->facing[2]),
                              receiver);
}
#else
#define mcv_is_rectangle(e) 0
#endif

/* That with which next-event estimation at a receiver chooses the direction to such a place; of a
 * rectangle or not; share: its triangle's.
 */
MCV_LOOP_FUNCTION float mcv_density_towards(__global const mcv_device_emitter *e, int rectangle,
                                            float share, mcv_vec3 receiver, mcv_surface surface,
                                            mcv_vec3 direction, float distance) {
    float density = mcv_area_density(e, share, surface, direction, distance);
    (void)rectangle, (void)receiver;
#if MCV_WITH_RECTANGLE
    if (rectangle) {
        const mcv_rectangle_view view = mcv_view_emitter(e, receiver);
        density = mcv_samples_solid_angle(view) ? e->probability / view.solid_angle : density;
    }
#endif
#if MCV_WITH_PARALLEL
    const float cone = e->probability / e->parallel.solid_angle;
    density = mcv_samples_cone(e, receiver) ? cone : density;
#endif
    return density;
}

MCV_FUNCTION float mcv_emitter_density(mcv_world world, mcv_vec3 receiver, mcv_surface surface,
                                       uint emitter, mcv_vec3 direction, float distance) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const float share = mcv_triangle_share(world, e, surface.triangle);
    return mcv_density_towards(e, mcv_is_rectangle(e), share, receiver, surface, direction,
                               distance);
}
#endif

#if MCV_WITH_DIELECTRIC
/* The medium that fills a place inside all media of the set: the one of the highest priority. */
MCV_FUNCTION uint mcv_filling_medium(uint media) { return 32u - clz(media); }
#endif

/* Radiance L of light in a medium as paths carry it, L/n². */
MCV_LOOP_FUNCTION mcv_color mcv_basic_radiance(mcv_world world, mcv_color radiance, uint media) {
#if MCV_WITH_DIELECTRIC
    radiance = mcv_dim(radiance, world.media[mcv_filling_medium(media)].inverse_index_squared);
#else
    (void)world, (void)media;
#endif
    return radiance;
}

#if MCV_WITH_ABSORPTION
/* What the medium leaves of light over a distance. */
MCV_FUNCTION mcv_color mcv_medium_transmittance(mcv_world world, uint media, float distance) {
    __global const mcv_device_medium *medium = world.media + mcv_filling_medium(media);
    mcv_color transmittance;
    MCV_EACH_CHANNEL(i)
    transmittance.c[i] =
        medium->absorption[i] > 0.0f ? mcv_exp_minus(medium->absorption[i] * distance) : 1.0f;
    return transmittance;
}
#endif

#endif
