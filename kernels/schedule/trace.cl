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
#include "geometry/precise.h"

MCV_FUNCTION void mcv_write_vector(__global float *to, mcv_vec3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

/* Writes at most `stride` vertices; returns how many. The slot holds the ray for the stage that
 * intersects. */
static uint mcv_trace_path(mcv_world world, mcv_slot slot, mcv_device_ray ray, uint stride,
                           __global mcv_device_vertex *vertices) {
    const mcv_pair always_refract = {1.0f, 0.0f};
    mcv_vec3 origin = mcv_vec(ray.origin[0], ray.origin[1], ray.origin[2]);
    mcv_vec3 point = origin;
    mcv_vec3 normal = mcv_vec(0.0f, 0.0f, 0.0f);
    mcv_scattering on;
    on.direction = mcv_vec(ray.direction[0], ray.direction[1], ray.direction[2]);
    on.media = ray.media;
    on.event = MCV_EVENT_START;
    uint triangle = MCV_NONE;
    uint origin_surface = MCV_NONE;
    uint unmatched = 0;
    const mcv_vec3 nothing = mcv_vec(0.0f, 0.0f, 0.0f);
    mcv_vec3 point_low = nothing, normal_low = nothing, direction_low = nothing;
    float distance_low = 0.0f;
#if MCV_WITH_MIXED
    mcv_vec3 origin_low = mcv_vec(ray.origin_low[0], ray.origin_low[1], ray.origin_low[2]);
    point_low = origin_low;
    direction_low = mcv_vec(ray.direction_low[0], ray.direction_low[1], ray.direction_low[2]);
#endif
    float distance = 0.0f;
#if MCV_WITH_MOVING
    MCV_STORE(slot, time, 0, 0.0f);
#endif
    float transmittance = 1.0f;
    float radiance = 0.0f;
    for (uint count = 0;; ++count) {
        /* Write the vertex. */
        __global mcv_device_vertex *vertex = vertices + count;
        mcv_write_vector(vertex->position, point);
        mcv_write_vector(vertex->normal, normal);
        mcv_write_vector(vertex->direction, on.direction);
        vertex->distance = distance;
        vertex->triangle = triangle;
        vertex->event = on.event;
        vertex->medium = MCV_WITH_DIELECTRIC ? mcv_filling_medium(on.media) : 0u;
        vertex->transmittance = transmittance;
        vertex->radiance = radiance;
        vertex->distance_low = distance_low;
        mcv_write_vector(vertex->position_low, point_low);
        mcv_write_vector(vertex->normal_low, normal_low);
        mcv_write_vector(vertex->direction_low, direction_low);
        if (on.event == MCV_EVENT_END || on.event == MCV_EVENT_MISS || count + 1 == stride)
            return count + 1;

        /* Find the next surface. */
        const mcv_vec3 direction = on.direction;
        MCV_STORE_3(slot, origin, origin);
        MCV_STORE_3(slot, direction, direction);
        MCV_STORE_COLOR(slot, throughput, mcv_grey(transmittance));
        if (MCV_WITH_DIELECTRIC) MCV_WORD(slot, media, 0) = on.media;
        if (MCV_WITH_SURFACES) MCV_WORD(slot, origin_surface, 0) = origin_surface;
        mcv_intersect_closest(world, slot);
        triangle = MCV_WORD(slot, hit, 3);
        distance = MCV_LOAD(slot, hit, 0);
        transmittance = MCV_LOAD(slot, throughput, 0);
#if MCV_WITH_MIXED
        const mcv_precise_ray precise =
            mcv_precise_ray_of(origin, origin_low, direction, direction_low);
#endif
        distance_low = 0.0f;
        normal_low = direction_low = nothing;
        if (triangle == MCV_NONE) {
            normal = nothing;
            on.direction = normal;
            on.event = MCV_EVENT_MISS;
            distance = INFINITY;
            radiance = mcv_environment_seen(world, direction, on.media, 0.0f).c[0];
            continue;
        }

        /* Go through it. */
        const mcv_hit hit = {distance, MCV_LOAD(slot, hit, 1), MCV_LOAD(slot, hit, 2), triangle};
        const mcv_interaction interaction = mcv_meet(world, origin, direction, hit);
        radiance = 0.0f;
#if MCV_WITH_EMISSION
        const uint emitter = world.instances[interaction.surface.instance].emitter;
        if (emitter != MCV_NONE) {
            const mcv_color emitted = mcv_emitted(world, interaction.surface, emitter,
                                                  mcv_scale(interaction.direction, -1.0f));
            radiance = mcv_basic_radiance(world, emitted, on.media).c[0];
        }
#endif
        const uint before = on.media;
        mcv_scattering other;
        on = mcv_scatter(world, interaction, before, always_refract, 1.0f, 0, &unmatched, &other);
        point = interaction.surface.point;
        normal = interaction.normal;
        point_low = nothing;
#if MCV_WITH_MIXED
        const mcv_precise_interaction met =
            mcv_intersect_precisely(world, &interaction, precise, origin_low, distance);
        const mcv_onward onward =
            mcv_go_on_precisely(world, &interaction, &met, precise.direction, before, &on);
        if (met.found) {
            point_low = mcv_low_of(met.point, point);
            normal_low = mcv_low_of(met.normal, normal);
            distance_low = (float)(met.distance - (double)distance);
        }
        direction_low = mcv_onward_low(&onward, onward.ray.direction, on.direction);
#endif
        origin = mcv_onward_origin(interaction, on.direction);
#if MCV_WITH_MIXED
        origin_low = mcv_onward_low(&onward, onward.ray.origin, origin);
#endif
        origin_surface = mcv_origin_surface_of(world, interaction, on.direction);
        if (on.event == MCV_EVENT_END)
            on.direction = mcv_vec(0.0f, 0.0f, 0.0f);
        else
            transmittance *= on.chance * on.factor.c[0];
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
