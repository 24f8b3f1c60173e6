/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: connects a light path at a scattering surface to a point of the lens, straight or through
 * plates. */
#ifndef MCVISI_KERNELS_CONNECT_LIGHT_PATH_H
#define MCVISI_KERNELS_CONNECT_LIGHT_PATH_H

#include "bsdf/bsdf.h"
#include "geometry/solids.h"
#include "light/leave_emitter.h"
#include "light/mis.h"
#include "path/sensor_ray.h"
#include "stage/splat_film.h"
#include "traverse/closest.h"

#if MCV_WITH_LIGHT_TRACING
/*
 * The flux that leaves a surface about a normal n_s other than its triangle's n_g, over what the
 * path carries. About n_g, radiance on camera paths and flux on light paths are transported alike.
 * About n_s, flux from i to o has the factor |i·n_s||o·n_g|/(|i·n_g||o·n_s|) (Veach 1997, 5.3);
 * without it facets would show. Smooth and near-specular surfaces pass on all flux, as the curved
 * body does that the mesh stands for. There the factor is 1 on average over a facet, up to the
 * square of its angle, and has no bound at grazing incidence.
 */
MCV_LOOP_FUNCTION float mcv_flux_correction(mcv_interaction interaction, mcv_vec3 out) {
#if MCV_WITH_NORMALS
    const float in_ng = mcv_dot(interaction.direction, interaction.ng);
    const float out_ns = mcv_dot(out, interaction.ns);
    const float factor = mcv_dot(interaction.direction, interaction.ns) *
                         mcv_dot(out, interaction.ng) / (in_ng * out_ns);
    return factor > 0.0f && factor < INFINITY ? factor : 0.0f;
#else
    (void)interaction, (void)out;
    return 1.0f;
#endif
}

/* What the `range` of a point or spot light leaves, by the distance to the first scattering
 * surface. */
MCV_LOOP_FUNCTION float mcv_within_range(__global const mcv_device_emitter *e, float length) {
#if MCV_WITH_PUNCTUAL
    if (e->type == MCV_EMITTER_POINT)
        return mcv_point_light_attenuation(&e->light, length * length) * length * length;
#endif
    (void)e, (void)length;
    return 1.0f;
}

/* Has the path met no smooth or near-specular surface yet? Next-event estimation covers light
 * straight from the emitter: the path ends at the first other surface that scatters. */
MCV_LOOP_FUNCTION int mcv_is_left_to_next_event(uint light_flags) {
    return (light_flags & MCV_LIGHT_FLAG_CARRIED) == 0u;
}

/* Do camera paths alone bring the light of this surface? */
MCV_LOOP_FUNCTION int mcv_is_left_to_camera(mcv_world world, mcv_interaction interaction,
                                            uint light_flags) {
    return ((light_flags & MCV_LIGHT_FLAG_FOUND) != 0u) & !mcv_has_broad_lobe(world, interaction);
}

#if MCV_WITH_NEXT_EVENT
/* A connection to a point of the lens. */
typedef struct mcv_connection {
    mcv_vec3 origin, end;
    uint origin_surface; /* on which it starts (mcv_mark_origin_surface), */
    uint media;          /* and what the light is in */
    mcv_film_point place;
    mcv_color contribution; /* what it contributes, if nothing blocks it */
} mcv_connection;

/* Connects what arrives at a scattering surface to a point of the lens. 0: it does not reach it. */
MCV_FUNCTION int mcv_connect_light_path(mcv_world world, mcv_interaction interaction,
                                        mcv_light_path path, mcv_pair pair,
                                        mcv_connection *connection) {
    mcv_sensor_ray sensor_ray;
    if (mcv_is_left_to_next_event(path.light_flags) ||
        mcv_is_left_to_camera(world, interaction, path.light_flags) ||
        !world.materials[world.instances[interaction.surface.instance].material].scattering_sides)
        return 0;
    const mcv_vec3 point = mcv_point_to_optical(world.frame, interaction.surface.point);
    if (!(point.z > 0.0f)) return 0;
    const float area = mcv_sensor_connect(world.sensor, point, pair.x, pair.y, &sensor_ray);
    const float importance = mcv_sensor_invert(world.sensor, sensor_ray, &connection->place) * area;
    if (!(importance > 0.0f) || !mcv_is_on_film(world.frame, connection->place)) return 0;
    const mcv_ray seen = mcv_place_sensor_ray(world.frame, sensor_ray);
    const mcv_vec3 out = mcv_scale(seen.direction, -1.0f);
    const mcv_response response = mcv_respond(world, interaction, path.media, out);
    const float d = mcv_sqrt(mcv_dot(sensor_ray.direction, sensor_ray.direction)),
                within_range = path.light_flags & MCV_LIGHT_FLAG_SPREAD
                                   ? 1.0f
                                   : mcv_within_range(world.emitters + path.emitter, path.length);
    const mcv_color flux = mcv_dim(mcv_tint(path.flux, path.throughput), within_range);
    mcv_color contribution =
        mcv_dim(mcv_tint(flux, response.f_cos),
                mcv_flux_correction(interaction, out) * importance * d / (point.z * point.z));
    if (path.etendue > 0.0f)
        contribution = mcv_dim(
            contribution, mcv_light_path_mis_weight(world, path.etendue,
                                                    mcv_sensor_footprint(world.sensor, point.z)));
    contribution =
        mcv_tint(contribution, mcv_medium_transmittance(world, response.media, point.z * d));
    connection->origin = mcv_offset_origin(interaction.surface.point, interaction.surface.error,
                                           interaction.ng, out);
    connection->end = seen.origin;
    connection->origin_surface = mcv_origin_surface_of(world, interaction, out);
    connection->media = response.media;
    connection->contribution = contribution;
    return mcv_brightest(response.f_cos) > 0.0f;
}

/* The transmittance of a connection through at most so many plates; 0 where anything else blocks
 * it. */
MCV_FUNCTION mcv_color mcv_connection_transmittance(mcv_world world, mcv_connection connection,
                                                    uint plates, uint counts[MCV_COUNTER_COUNT]) {
    mcv_color transmittance = mcv_grey(1.0f);
#if MCV_WITH_SHEET
    for (;; --plates) {
        const mcv_vec3 way = mcv_sub(connection.end, connection.origin);
        const mcv_hit hit =
            mcv_closest_within(world, connection.origin, way, connection.origin_surface);
        ++counts[MCV_COUNTER_shadow_rays];
        if (hit.primitive == MCV_NONE) return transmittance;
        const mcv_interaction interaction = mcv_surface_interaction(
            mcv_hit_surface(world, connection.origin, way, hit), mcv_normalize(way));
        if (plates == 0 || !mcv_is_plate(world, interaction)) return mcv_grey(0.0f);
        const mcv_scattering on = mcv_scatter_through(world, interaction, connection.media,
                                                      &counts[MCV_COUNTER_unmatched]);
        if (on.event != MCV_EVENT_PASS) return mcv_grey(0.0f);
        transmittance = mcv_dim(mcv_tint(transmittance, on.factor), on.chance);
        if (!(mcv_brightest(transmittance) > 0.0f)) return transmittance;
        connection.origin = mcv_offset_origin(interaction.surface.point, interaction.surface.error,
                                              interaction.ng, way);
        connection.origin_surface = mcv_mark_origin_surface(world, interaction.surface, way);
    }
#else
    ++counts[MCV_COUNTER_shadow_rays];
    const mcv_vec3 way = mcv_sub(connection.end, connection.origin);
    int blocked = mcv_intersect_any_ray(world.nodes, world.leaves, connection.origin, way, 1.0f);
    if (MCV_WITH_SURFACES)
        blocked = blocked || mcv_intersect_solids_along(world, connection.origin, way,
                                                        connection.origin_surface, mcv_miss(1.0f))
                                     .primitive != MCV_NONE;
    (void)plates;
    return blocked ? mcv_grey(0.0f) : transmittance;
#endif
}

/* Adds to the film what a light path sends to the lens from the surface that it has met, the
 * depth-th one. */
MCV_FUNCTION void mcv_splat_light_path(mcv_world world, mcv_interaction interaction,
                                       mcv_light_path path, uint replicate, uint depth,
                                       mcv_pair pupil, float xi, __global uint *splats,
                                       uint counts[MCV_COUNTER_COUNT]) {
    mcv_connection connection;
    if (!mcv_connect_light_path(world, interaction, path, pupil, &connection)) return;
    const mcv_color transmittance =
        mcv_connection_transmittance(world, connection, world.frame->depth - 1u - depth, counts);
    if (mcv_brightest(transmittance) > 0.0f)
        mcv_splat(world, splats, replicate, connection.place,
                  mcv_tint(connection.contribution, transmittance), path.emitter_element, xi,
                  counts);
}
#endif
#endif

#endif
