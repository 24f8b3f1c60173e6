/* SPDX-License-Identifier: Apache-2.0 */
/* What lies at a hit: point with its error, normals, instance. */
#ifndef MCVISI_KERNELS_SURFACE_H
#define MCVISI_KERNELS_SURFACE_H

#include "mcvisi/offset.h"
#include "world.h"
#include "geometry/texture.h"

/* The three vertices of a triangle and its instance. No vector: the compiler vectorises loops of
 * scalars only. */
typedef struct mcv_corners {
    uint x, y, z, w;
} mcv_corners;

typedef struct mcv_surface {
    mcv_vec3 point, error; /* [m]; |error of a coordinate| */
    mcv_vec3 ng;           /* geometric normal: of the triangle, unit, on the front side */
    mcv_vec3 ns;           /* shading normal: interpolated, unit, on the front side */
    float area;            /* of the triangle [m²] */
    uint primitive, instance;
    float u, v; /* place on the triangle; of an exact surface u is for mcv_touching_solid */
    mcv_corners corners;
} mcv_surface;

/* Of an exact surface 1 + the number of the solid in contact there, 0 without one
 * (mcv_take_exact_hit); of a triangle 0. */
MCV_LOOP_FUNCTION uint mcv_touching_solid(const mcv_surface *surface) {
    return mcv_is_exact(surface->primitive) ? (uint)surface->u : 0u;
}

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
MCV_FUNCTION uint mcv_instance_of(mcv_world world, uint primitive) {
    if (mcv_is_exact(primitive))
        return world.solids[mcv_solid_of(primitive)].instance[mcv_piece_of(primitive)];
    return world.triangles[primitive].w;
}

MCV_FUNCTION mcv_vec3 mcv_interpolate(mcv_vec3 a, mcv_vec3 b, mcv_vec3 c, float u, float v) {
    return mcv_along(mcv_along(mcv_scale(a, 1.0f - u - v), u, b), v, c);
}

/* What all places on a triangle share. */
typedef struct mcv_facet {
    mcv_vec3 a, b, c; /* its corners [m] */
    mcv_vec3 ng;
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
    facet.ng = mcv_normalize(doubled);
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
    surface.primitive = facet.triangle;
    surface.instance = facet.corners.w;
    surface.corners = facet.corners;
    surface.u = u;
    surface.v = v;
    surface.point = mcv_hit_point(facet.a, facet.b, facet.c, u, v, &surface.error);
    surface.ng = facet.ng;
    surface.area = facet.area;
    surface.ns = surface.ng;
#if MCV_WITH_NORMALS
    const mcv_vec3 n =
        mcv_normalize(mcv_interpolate(facet.normal_a, facet.normal_b, facet.normal_c, u, v));
    /* Opposite vertex normals may cancel, and those of a flat mesh are 0: ng then. */
    surface.ns = mcv_either(mcv_dot(n, n) > 0.5f, n, surface.ng);
#endif
    return surface;
}

MCV_LOOP_FUNCTION mcv_surface mcv_surface_at(mcv_world world, uint triangle, float u, float v) {
    mcv_surface surface = mcv_surface_on(mcv_facet_of(world, triangle), u, v);
#if MCV_WITH_MOVING
    MCV_CONSTANT const mcv_rigid_motion *motion = &world.frame->part_motion;
    const int moves = world.instances[surface.instance].moves != 0u;
    const mcv_vec3 point = mcv_moved_point(motion, world.pose, surface.point),
                   ng = mcv_moved_direction(motion, world.pose, surface.ng),
                   ns = mcv_moved_direction(motion, world.pose, surface.ns);
    const float error = moves ? mcv_moving_error(motion, world.pose, point) : 0.0f;
    surface.point = mcv_either(moves, point, surface.point);
    surface.ng = mcv_either(moves, ng, surface.ng);
    surface.ns = mcv_either(moves, ns, surface.ns);
    surface.error = mcv_add(surface.error, mcv_vec(error, error, error));
#endif
    return surface;
}

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

/* The texel of an image without interpolation there. */
MCV_LOOP_FUNCTION mcv_pixel mcv_texel_at(mcv_world world, mcv_surface surface, uint texture) {
    __global const mcv_device_texture *t = world.textures + texture;
    const mcv_texture_place place = mcv_find_texel(t, mcv_image_place(world, surface, texture, 0),
                                                   mcv_image_place(world, surface, texture, 1));
    mcv_pixel pixel;
    pixel.column = mcv_wrap(place.i, t->width, t->wrap_s);
    pixel.row = mcv_wrap(place.j, t->height, t->wrap_t);
    return pixel;
}

/* A value times the texture's there, where a material has one. */
MCV_LOOP_FUNCTION mcv_color mcv_textured(mcv_world world, mcv_surface surface, uint texture,
                                         mcv_color value) {
    if (!MCV_WITH_TEXTURE || texture == MCV_NONE) return value;
    return mcv_tint(value, mcv_texture_at(world, surface, texture));
}

/* The direction that lies at an angle, given by its cosine and sine, from the tangent; along the
 * surface only about. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_tangent(mcv_world world, mcv_surface surface, const float *angle) {
    __global const float *a = world.tangents + 4 * surface.corners.x,
                         *b = world.tangents + 4 * surface.corners.y,
                         *c = world.tangents + 4 * surface.corners.z;
    mcv_vec3 tangent = mcv_vec(0.0f, 0.0f, 0.0f);
    tangent = mcv_along(tangent, 1.0f - surface.u - surface.v, mcv_vec(a[0], a[1], a[2]));
    tangent = mcv_along(tangent, surface.u, mcv_vec(b[0], b[1], b[2]));
    tangent = mcv_along(tangent, surface.v, mcv_vec(c[0], c[1], c[2]));
    const float hand = a[3];
    const mcv_vec3 x = mcv_normalize(mcv_along(tangent, -mcv_dot(tangent, surface.ns), surface.ns));
    return mcv_along(mcv_scale(x, angle[0]), hand * angle[1], mcv_cross(surface.ns, x));
}

/* Reflectance or transmittance, texture included. */
MCV_LOOP_FUNCTION mcv_color mcv_material_color(mcv_world world, mcv_surface surface,
                                               uint material) {
    mcv_color color;
    MCV_EACH_CHANNEL(i) color.c[i] = world.materials[material].color[i];
    return mcv_textured(world, surface, world.materials[material].texture, color);
}

/* The transmittance of a translucent one, texture included. */
MCV_LOOP_FUNCTION mcv_color mcv_material_passed(mcv_world world, mcv_surface surface,
                                                uint material) {
    mcv_color passed;
    MCV_EACH_CHANNEL(i) passed.c[i] = world.materials[material].passed[i];
    return mcv_textured(world, surface, world.materials[material].texture, passed);
}

#endif
