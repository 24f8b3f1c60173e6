/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Follows given rays through smooth surfaces, always refracted where that is possible, and writes every vertex: what
 * `mcvisi trace` and the tests look at. One work-item per ray; `stride` vertices each.
 */
#include "environment.h"
#include "intersect_closest.cl"
#include "path.h"
#include "scatter.h"

MCV_FUNCTION void mcv_write_vector(__global float *to, mcv_vec3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

/* Writes at most `stride` vertices; returns how many. The slot holds the ray for the stage that intersects. */
static uint mcv_trace_path(mcv_world world, mcv_slot slot, mcv_device_ray ray, uint stride, __global mcv_device_vertex *vertices) {
    const mcv_pair always_refract = {1.0f, 0.0f};
    mcv_vec3 origin = mcv_vec(ray.origin[0], ray.origin[1], ray.origin[2]);
    mcv_vec3 point = origin;
    mcv_vec3 normal = mcv_vec(0.0f, 0.0f, 0.0f);
    mcv_scattering on;
    on.direction = mcv_vec(ray.direction[0], ray.direction[1], ray.direction[2]);
    on.media = ray.media;
    on.event = MCV_EVENT_START;
    uint triangle = MCV_NONE;
#if MCV_WITH_SURFACES
    uint left = MCV_NONE;
#endif
    uint unmatched = 0;
    float distance = 0.0f;
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
        vertex->medium = 0;
#if MCV_WITH_DIELECTRIC
        vertex->medium = mcv_filling_medium(on.media);
#endif
        vertex->transmittance = transmittance;
        vertex->radiance = radiance;
        vertex->padding = 0;
        if (on.event == MCV_EVENT_END || on.event == MCV_EVENT_MISS || count + 1 == stride) return count + 1;

        /* Find the next surface. */
        const mcv_vec3 direction = on.direction;
        MCV_STORE_3(slot, origin, origin);
        MCV_STORE_3(slot, direction, direction);
        MCV_STORE_COLOR(slot, throughput, mcv_grey(transmittance));
#if MCV_WITH_DIELECTRIC
        MCV_WORD(slot, media, 0) = on.media;
#endif
#if MCV_WITH_SURFACES
        MCV_WORD(slot, left, 0) = left;
#endif
        mcv_intersect_closest(world, slot);
        triangle = MCV_WORD(slot, hit, 3);
        distance = MCV_LOAD(slot, hit, 0);
        transmittance = MCV_LOAD(slot, throughput, 0);
        if (triangle == MCV_NONE) {
            normal = mcv_vec(0.0f, 0.0f, 0.0f);
            on.direction = normal;
            on.event = MCV_EVENT_MISS;
            distance = INFINITY;
            radiance = mcv_environment_met(world, direction, on.media, 0.0f).c[0];
            continue;
        }

        /* Go through it. */
        const mcv_hit hit = {distance, MCV_LOAD(slot, hit, 1), MCV_LOAD(slot, hit, 2), triangle};
        const mcv_meeting meeting = mcv_meet(world, origin, direction, hit);
        const uint emitter = world.instances[meeting.surface.instance].emitter;
        radiance = emitter == MCV_NONE ? 0.0f : mcv_emission_met(world, meeting, emitter, on.media, 0.0f, 0.0f).c[0];
        on = mcv_scatter(world, meeting, on.media, always_refract, 1.0f, &unmatched);
        point = meeting.surface.point;
        normal = meeting.normal;
        origin = mcv_onward_origin(meeting, on.direction);
#if MCV_WITH_SURFACES
        left = mcv_leave_meeting(world, meeting, on.direction);
#endif
        if (on.event == MCV_EVENT_END)
            on.direction = mcv_vec(0.0f, 0.0f, 0.0f);
        else
            transmittance *= on.chance * on.factor.c[0];
    }
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void trace_paths(MCV_WORLD_PARAMETERS __global uint *paths, uint stride,
                                                                         __global const mcv_device_ray *rays,
                                                                         __global mcv_device_vertex *vertices,
                                                                         __global uint *vertex_counts) {
    MCV_MAKE_WORLD(world)
    const uint ray = get_global_id(0);
    mcv_slot slot;
    slot.base = paths;
    slot.capacity = get_global_size(0);
    slot.index = ray;
    vertex_counts[ray] = mcv_trace_path(world, slot, rays[ray], stride, vertices + (size_t)ray * stride);
}
