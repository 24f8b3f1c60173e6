/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Follows given rays through smooth surfaces, always refracted where that is possible, and writes
 * every vertex: what `mcvisi trace` and the tests look at. One work-item per ray; `stride` vertices
 * each.
 */
#include "light/environment.h"
#include "stage/intersect_closest.h"
#include "path/camera_path.h"
#include "bsdf/bsdf.h"
#include "geometry/path_interaction.h"
#include "geometry/precise.h"

MCV_FUNCTION void mcv_write_vector(__global float *to, mcv_vec3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

/* The vertex at which a ray has arrived, and the ray that leaves it. `…_low`: what is left of
 * double precision, else 0. */
typedef struct mcv_traced {
    mcv_vec3 point, normal, point_low, normal_low;
    mcv_vec3 origin, origin_low, direction_low;
    mcv_scattering on; /* its direction, media, event */
    uint primitive, origin_surface;
    float distance, distance_low, transmittance, radiance;
} mcv_traced;

static mcv_traced mcv_start_trace(mcv_device_ray ray) {
    const mcv_vec3 nothing = mcv_vec(0.0f, 0.0f, 0.0f);
    mcv_traced at;
    at.point = at.origin = mcv_vec(ray.origin[0], ray.origin[1], ray.origin[2]);
    at.normal = at.point_low = at.normal_low = at.origin_low = at.direction_low = nothing;
#if MCV_WITH_MIXED
    at.point_low = at.origin_low = mcv_vec(ray.origin_low[0], ray.origin_low[1], ray.origin_low[2]);
    at.direction_low = mcv_vec(ray.direction_low[0], ray.direction_low[1], ray.direction_low[2]);
#endif
    at.on = mcv_scatter_into(mcv_vec(ray.direction[0], ray.direction[1], ray.direction[2]),
                             ray.media, MCV_EVENT_START);
    at.primitive = at.origin_surface = MCV_NONE;
    at.distance = at.distance_low = at.radiance = 0.0f;
    at.transmittance = 1.0f;
    return at;
}

static void mcv_write_vertex(__global mcv_device_vertex *vertex, const mcv_traced *at) {
    mcv_write_vector(vertex->position, at->point);
    mcv_write_vector(vertex->normal, at->normal);
    mcv_write_vector(vertex->direction, at->on.direction);
    vertex->distance = at->distance;
    vertex->primitive = at->primitive;
    vertex->event = at->on.event;
    vertex->medium = MCV_WITH_DIELECTRIC ? mcv_filling_medium(at->on.media) : 0u;
    vertex->transmittance = at->transmittance;
    vertex->radiance = at->radiance;
    vertex->distance_low = at->distance_low;
    mcv_write_vector(vertex->position_low, at->point_low);
    mcv_write_vector(vertex->normal_low, at->normal_low);
    mcv_write_vector(vertex->direction_low, at->direction_low);
}

/* Finds the next surface by the stage that intersects, whose path is in the slot. */
static mcv_hit mcv_trace_on(mcv_world world, mcv_slot slot, mcv_traced *at) {
    MCV_STORE_3(slot, origin, at->origin);
    MCV_STORE_3(slot, direction, at->on.direction);
    MCV_STORE_COLOR(slot, throughput, mcv_grey(at->transmittance));
    if (MCV_WITH_DIELECTRIC) MCV_WORD(slot, media, 0) = at->on.media;
    if (MCV_WITH_SURFACES) MCV_WORD(slot, origin_surface, 0) = at->origin_surface;
    mcv_intersect_closest(world, slot);
    const mcv_hit hit = mcv_load_hit(slot);
    at->primitive = hit.primitive;
    at->distance = hit.t;
    at->transmittance = MCV_LOAD(slot, throughput, 0);
    return hit;
}

/* The ray leaves the scene. */
static void mcv_end_trace(mcv_world world, mcv_traced *at) {
    at->radiance = mcv_environment_seen(world, at->on.direction, at->on.media, 0.0f).c[0];
    at->distance = INFINITY;
    at->distance_low = 0.0f;
    at->normal = at->on.direction = at->normal_low = at->direction_low = mcv_vec(0.0f, 0.0f, 0.0f);
    at->on.event = MCV_EVENT_MISS;
}

/* What the surface emits towards the ray. */
static float mcv_traced_radiance(mcv_world world, mcv_interaction interaction, uint media) {
#if MCV_HAS_EMISSION
    const uint emitter = world.instances[interaction.surface.instance].emitter;
    if (emitter != MCV_NONE) {
        const mcv_color emitted = mcv_emitted(world, interaction.surface, emitter,
                                              mcv_scale(interaction.direction, -1.0f));
        return mcv_basic_radiance(world, emitted, media).c[0];
    }
#endif
    (void)world, (void)interaction, (void)media;
    return 0.0f;
}

/* The ray arrives at the surface of a hit and goes on from there. */
static void mcv_pass_surface(mcv_world world, mcv_hit hit, mcv_traced *at) {
    const mcv_vec3 nothing = mcv_vec(0.0f, 0.0f, 0.0f);
    const mcv_interaction interaction =
        mcv_hit_interaction(world, at->origin, at->on.direction, hit);
    const uint media = at->on.media;
    uint unmatched = 0;
#if MCV_WITH_MIXED
    const mcv_vec3 low = at->origin_low;
    const mcv_precise_ray ray =
        mcv_precise_ray_of(at->origin, low, at->on.direction, at->direction_low);
#endif
    at->radiance = mcv_traced_radiance(world, interaction, media);
    at->on = mcv_scatter_through(world, interaction, media, &unmatched);
    at->point = interaction.surface.point;
    at->normal = interaction.ns;
    at->point_low = at->normal_low = at->direction_low = nothing;
    at->distance_low = 0.0f;
#if MCV_WITH_MIXED
    const mcv_precise_interaction met =
        mcv_intersect_precisely(world, &interaction, ray, low, hit.t);
    const mcv_onward onward =
        mcv_go_on_precisely(world, &interaction, &met, ray.direction, media, &at->on);
    if (met.found) {
        at->point_low = mcv_low_of(met.point, at->point);
        at->normal_low = mcv_low_of(met.ns, at->normal);
        at->distance_low = (float)(met.distance - (double)hit.t);
    }
    at->direction_low = mcv_onward_low(&onward, onward.ray.direction, at->on.direction);
#endif
    at->origin = mcv_onward_origin(interaction, at->on.direction);
#if MCV_WITH_MIXED
    at->origin_low = mcv_onward_low(&onward, onward.ray.origin, at->origin);
#endif
    at->origin_surface = mcv_origin_surface_of(world, interaction, at->on.direction);
    if (at->on.event == MCV_EVENT_NON_SPECULAR)
        at->on.direction = nothing;
    else
        at->transmittance *= at->on.chance * at->on.factor.c[0];
}

/* Writes at most `stride` vertices; returns how many. */
static uint mcv_trace_path(mcv_world world, mcv_slot slot, mcv_device_ray ray, uint stride,
                           __global mcv_device_vertex *vertices) {
    mcv_traced at = mcv_start_trace(ray);
#if MCV_WITH_MOVING
    MCV_STORE(slot, time, 0, 0.0f);
#endif
    for (uint count = 0;; ++count) {
        mcv_write_vertex(vertices + count, &at);
        if (at.on.event == MCV_EVENT_NON_SPECULAR || at.on.event == MCV_EVENT_MISS ||
            count + 1 == stride)
            return count + 1;
        const mcv_hit hit = mcv_trace_on(world, slot, &at);
        if (hit.primitive == MCV_NONE)
            mcv_end_trace(world, &at);
        else
            mcv_pass_surface(world, hit, &at);
    }
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
trace_paths(MCV_WORLD_PARAMETERS __global uint *paths, uint stride,
            __global const mcv_device_ray *rays, __global mcv_device_vertex *vertices,
            __global uint *vertex_counts) {
    MCV_MAKE_WORLD(world)
    const uint ray = get_global_id(0);
    mcv_slot slot;
    slot.base = paths;
    slot.capacity = get_global_size(0);
    slot.index = ray;
    vertex_counts[ray] =
        mcv_trace_path(world, slot, rays[ray], stride, vertices + (size_t)ray * stride);
}
