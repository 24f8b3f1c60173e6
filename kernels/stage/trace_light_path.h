/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: light tracing, one light path for every 2^k camera paths. A path starts at an emitter that
 * is chosen by flux and follows smooth and near-specular surfaces. Once it has met one of these,
 * each later vertex on a scattering surface is connected to a point of the sensor's lens, straight
 * or through plates, unless it is left to camera paths (mcv_is_left_to_camera). A path that meets
 * another scattering surface first ends there: next-event estimation covers it. A beam that reaches
 * the lens by itself counts.
 *
 * Light that camera paths find too is weighted by the balance heuristic
 * (mcv_light_path_mis_weight). Where a camera path on a near-specular surface would need next-event
 * estimation, light paths alone bring that light.
 */
#ifndef MCVISI_KERNELS_TRACE_LIGHT_PATH_H
#define MCVISI_KERNELS_TRACE_LIGHT_PATH_H

#include "bsdf/shading.h"
#include "path/dispersion.h"
#include "light/leave_emitter.h"
#include "stage/connect_light_path.h"
#include "stage/roulette.h"
#include "stage/splat_film.h"
#include "traverse/closest.h"

#if MCV_WITH_LIGHT_TRACING
#if MCV_HAS_BEAMS
/* A beam reaches the plane of the lens before t, from smooth surfaces or straight from its emitter.
 */
static void mcv_enter_lens(mcv_world world, mcv_light_path path, float t, __global uint *splats,
                           uint replicate, float xi, uint counts[MCV_COUNTER_COUNT]) {
    mcv_sensor_ray sensor_ray;
    mcv_film_point place;
    const mcv_vec3 from = mcv_point_to_optical(world.frame, path.origin);
    const mcv_vec3 along = mcv_to_optical(world.frame, path.direction);
    if (!(from.z > 0.0f && along.z < 0.0f)) return;
    const float way = from.z / -along.z;
    if (!(way < t)) return;
    sensor_ray.origin = mcv_vec(mcv_fma(way, along.x, from.x), mcv_fma(way, along.y, from.y), 0.0f);
    sensor_ray.direction = mcv_vec(along.x / along.z, along.y / along.z, 1.0f);
    const float squared = mcv_dot(sensor_ray.direction, sensor_ray.direction);
    const float importance =
        mcv_sensor_invert(world.sensor, sensor_ray, &place) * squared * squared;
    if (!(importance > 0.0f)) return;
    mcv_color contribution = mcv_dim(mcv_tint(path.flux, path.throughput), importance);
    contribution = mcv_tint(contribution, mcv_medium_transmittance(world, path.media, way));
    mcv_splat(world, splats, replicate, place, contribution, path.emitter_element, xi, counts);
}
#endif

/*
 * A light path continues from a surface that has scattered it so: all but its origin. Returns
 * whether it does. Roulette plays for what it carries of its start. The surface sets (+) and clears
 * (-) flags; conditions are about the flags before it:
 *
 *     surface                      CARRIED  OPEN  SPREAD  FOUND               the path ends
 *     smooth                          +                                       never
 *     near-specular, while OPEN       +              +    + if not CARRIED    never
 *     scattering, all others                 -       +                        if not CARRIED, (1)
 *                                                                             or OPEN, FOUND and
 *                                                                             no broad lobe (2)
 *
 * FOUND is also set at the start (mcv_leave_point). At a first near-specular surface a camera path
 * finds the emitter by next-event estimation. (1) Next-event estimation covers light straight from
 * the emitter. (2) Camera paths cover light on a glossy surface.
 */
MCV_LOOP_FUNCTION int mcv_continue_light_path(mcv_world world, const mcv_interaction *interaction,
                                              mcv_shading shading, mcv_scattering on, uint depth,
                                              float xi, mcv_light_path *path) {
    const uint before = path->light_flags;
    const int carried = !mcv_is_left_to_next_event(before),
              open = (before & MCV_LIGHT_FLAG_OPEN) != 0u;
    const int scatters = on.density > 0.0f,
              parts = scatters & !(open & mcv_is_near_specular(world, *interaction));
    const int first = scatters & ((before & MCV_LIGHT_FLAG_SPREAD) == 0u);
    const int ends =
        parts & (!carried | (open & mcv_is_left_to_camera(world, *interaction, before)));
    const uint after =
        before | MCV_LIGHT_FLAG_CARRIED | ((scatters & !carried) ? (uint)MCV_LIGHT_FLAG_FOUND : 0u);
    mcv_color throughput = mcv_tint(path->throughput, on.factor);
    const mcv_roulette roulette =
        mcv_play_roulette(depth >= MCV_LIGHT_ROULETTE_DEPTH, mcv_brightest(throughput), 1.0f, xi);
    const float correction = mcv_flux_correction(*interaction, on.direction);
    const float within = mcv_within_range(world.emitters + path->emitter, path->length);
    throughput = mcv_dim(mcv_dim(throughput, parts ? correction : 1.0f), first ? within : 1.0f);
    path->throughput = mcv_after_roulette(roulette, throughput);
    path->light_flags = (parts ? before & ~(uint)MCV_LIGHT_FLAG_OPEN : after) |
                        (scatters ? (uint)MCV_LIGHT_FLAG_SPREAD : 0u);
    path->direction = on.direction;
    path->media = on.media;
    path->origin_surface =
        shading.exact ? mcv_origin_surface_of(world, *interaction, on.direction) : MCV_NONE;
    return roulette.survives & !ends;
}

/* Whether the path continues from the surface, and how. */
MCV_FUNCTION int mcv_shade_any_light_hit(mcv_world world, mcv_interaction interaction,
                                         mcv_pair pair, mcv_pair choice, uint depth,
                                         uint *unmatched, mcv_light_path *path) {
    mcv_scattering other;
    /* It would end there: mcv_continue_light_path. */
    if (mcv_is_left_to_next_event(path->light_flags) && mcv_has_broad_lobe(world, interaction))
        return 0;
    const mcv_scattering on =
        mcv_scatter(world, interaction, path->media, pair, choice.x, 0, unmatched, &other);
    path->origin = mcv_onward_origin(interaction, on.direction);
    return mcv_continue_light_path(world, &interaction, mcv_any_shading(), on, depth, choice.y,
                                   path);
}

/* What the depth limit cuts of the path: at most all that it began with. */
MCV_FUNCTION uint mcv_cut_light(mcv_color throughput) {
    return mcv_lost_energy(fmin(mcv_brightest(throughput), 1.0f));
}

MCV_FUNCTION mcv_pair mcv_light_pair(mcv_light_identity id, uint depth, uint use) {
    return mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(depth, use));
}

/* Traces the light path of a number. With the camera path of that number it shares nothing else;
 * some numbers have none (mcv_identify_light). */
MCV_FUNCTION void mcv_trace_light_path(mcv_world world, uint index, __global uint *splats,
                                       uint counts[MCV_COUNTER_COUNT]) {
    mcv_light_identity id;
    if (!mcv_identify_light(world.frame, index, &id)) return;
    mcv_light_path path = mcv_begin_light_path(world, mcv_light_pair(id, 0, MCV_PAIR_LIGHT_EMITTER),
                                               mcv_light_pair(id, 0, MCV_PAIR_LIGHT_PLACE),
                                               mcv_light_pair(id, 0, MCV_PAIR_LIGHT_DIRECTION));
    if (!(mcv_brightest(path.flux) > 0.0f)) return;

    for (uint depth = 1; depth < world.frame->depth; ++depth) {
        const mcv_pair choice = mcv_light_pair(id, depth, MCV_PAIR_CHOICE);
        const mcv_hit hit = mcv_closest(world, path.origin, path.direction, path.origin_surface);
        ++counts[MCV_COUNTER_rays];
#if MCV_HAS_BEAMS
        const uint type = world.emitters[path.emitter].type;
        if ((type == MCV_EMITTER_COLLIMATED_BEAM || type == MCV_EMITTER_LASER) &&
            !(path.light_flags & MCV_LIGHT_FLAG_SPREAD))
            mcv_enter_lens(world, path, hit.t, splats, id.replicate, choice.x, counts);
#endif
        if (hit.primitive == MCV_NONE) return;
        path.length += hit.t;
        path.throughput =
            mcv_tint(path.throughput, mcv_medium_transmittance(world, path.media, hit.t));
        const mcv_interaction interaction =
            mcv_hit_interaction(world, path.origin, path.direction, hit);
#if MCV_WITH_DISPERSION
        const mcv_world seen =
            mcv_disperse_at(world, interaction.surface.instance, id.stream, id.sample,
                            mcv_tint(path.flux, path.throughput), &path.throughput);
#else
        const mcv_world seen = world;
#endif
#if MCV_WITH_NEXT_EVENT
        mcv_splat_light_path(seen, interaction, path, id.replicate, depth,
                             mcv_light_pair(id, depth, MCV_PAIR_LIGHT_LENS), choice.x, splats,
                             counts);
#endif
        const mcv_pair pair = mcv_light_pair(id, depth, MCV_PAIR_SCATTER);
        if (!mcv_shade_any_light_hit(seen, interaction, pair, choice, depth,
                                     &counts[MCV_COUNTER_unmatched], &path))
            return;
    }
    ++counts[MCV_COUNTER_depth_cut];
    counts[MCV_COUNTER_lost] += mcv_cut_light(path.throughput);
}
#endif

#endif
