/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's light paths, a slice of them at once in the stages of camera paths: what
 * mcv_trace_light_path does for one, to the last bit. In the fields of a slot: radiance, the flux
 * that started; weight, the start's etendue; footprint, the length; trail, MCV_LIGHT_…; value, the
 * emitter; density, the replicate; shadow_light, what a connection brings.
 */
#ifndef MCVISI_KERNELS_LIGHT_SLICES_H
#define MCVISI_KERNELS_LIGHT_SLICES_H

/* Where beams come to the lens by themselves, colours part or surfaces touch, light paths go one by
 * one. */
#define MCV_LIGHT_TOGETHER \
    (MCV_LEAVES_TOGETHER && MCV_WITH_NEXT_EVENT && !MCV_WITH_BEAM && !MCV_WITH_DISPERSION)

#if MCV_LIGHT_TOGETHER
MCV_LOOP_FUNCTION mcv_light_path mcv_load_light_path(mcv_slot slot) {
    mcv_light_path path;
    path.origin = MCV_LOAD_3(slot, origin);
    path.direction = MCV_LOAD_3(slot, direction);
    MCV_LOAD_COLOR(slot, radiance, path.flux);
    MCV_LOAD_COLOR(slot, throughput, path.throughput);
    path.etendue = MCV_LOAD(slot, weight, 0);
    path.origin_surface = MCV_NONE;
#if MCV_WITH_SURFACES
    path.origin_surface = MCV_WORD(slot, origin_surface, 0);
#endif
    path.media = mcv_path_media(slot);
    path.emitter = MCV_WORD(slot, value, 0);
    path.path_class = MCV_WORD(slot, path_class, 0);
    path.length = MCV_LOAD(slot, footprint, 0);
    return path;
}

MCV_FUNCTION void mcv_store_light_path(mcv_slot slot, mcv_light_path path) {
    MCV_STORE_3(slot, origin, path.origin);
    MCV_STORE_3(slot, direction, path.direction);
    MCV_STORE_COLOR(slot, radiance, path.flux);
    MCV_STORE_COLOR(slot, throughput, path.throughput);
    MCV_STORE(slot, weight, 0, path.etendue);
#if MCV_WITH_SURFACES
    MCV_WORD(slot, origin_surface, 0) = path.origin_surface;
#endif
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = path.media;
#endif
    MCV_WORD(slot, value, 0) = path.emitter;
    MCV_WORD(slot, path_class, 0) = path.path_class;
    MCV_STORE(slot, footprint, 0, path.length);
}

/* What mcv_continue_light_path has changed, if it is not to be skipped. */
MCV_LOOP_FUNCTION void mcv_store_light_step(mcv_slot slot, int skipped, mcv_light_path path) {
    const mcv_vec3 direction = mcv_choose(skipped, MCV_LOAD_3(slot, direction), path.direction);
    MCV_STORE_3(slot, direction, direction);
    MCV_EACH_CHANNEL(c)
    MCV_STORE(slot, throughput, c, skipped ? MCV_LOAD(slot, throughput, c) : path.throughput.c[c]);
#if MCV_WITH_SURFACES
    MCV_WORD(slot, origin_surface, 0) =
        skipped ? MCV_WORD(slot, origin_surface, 0) : path.origin_surface;
#endif
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = skipped ? MCV_WORD(slot, media, 0) : path.media;
#endif
    MCV_WORD(slot, path_class, 0) = skipped ? MCV_WORD(slot, path_class, 0) : path.path_class;
}

/* Whether all emitters that light paths start at are areas that shine alike everywhere. */
#define MCV_WITH_LAMPS \
    (MCV_WITH_AREA && !MCV_WITH_TEXTURE && !MCV_WITH_PARALLEL && !MCV_WITH_LIGHT_FIELD && \
     !MCV_WITH_PROJECTOR && !MCV_WITH_PUNCTUAL)

#if MCV_WITH_LAMPS
/* mcv_aim_anywhere, from the places on their lamps that are stored as surfaces: angle and within as
 * in mcv_aiming. */
static __attribute__((noinline)) void mcv_aim_together(mcv_world world, uint *paths, uint count,
                                                       float *angle, uint *within) {
    float remainder[MCV_SLOTS], remainder_of[MCV_SLOTS], squared[MCV_SLOTS];
    const uint balls = world.frame->ball_count;
    mcv_slot slot;
    slot.base = paths;
    for (uint i = 0; i < count; ++i) {
        angle[i] = remainder_of[i] = squared[i] = 0.0f;
        within[i] = 0u;
    }
    for (uint ball = 0; ball < balls; ++ball) {
        const mcv_ball at = world.frame->balls[ball];
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = i;
            const mcv_vec3 point = MCV_LOAD_3(slot, point), normal = MCV_LOAD_3(slot, normal);
            angle[i] += mcv_cone_to(at, point, mcv_own_cone(world.emitters, normal)).squared;
        }
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const mcv_vec3 normal = MCV_LOAD_3(slot, normal);
        remainder[i] = angle[i] * MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER);
        MCV_STORE_3(slot, bounce, normal);
    }
    for (uint ball = 0; ball < balls; ++ball) {
        const mcv_ball at = world.frame->balls[ball];
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = i;
            const mcv_vec3 point = MCV_LOAD_3(slot, point), normal = MCV_LOAD_3(slot, normal),
                           before = MCV_LOAD_3(slot, bounce);
            const mcv_cone cone = mcv_cone_to(at, point, mcv_own_cone(world.emitters, normal));
            const int takes = (remainder[i] >= 0.0f) & (cone.squared > 0.0f);
            const mcv_vec3 axis = mcv_choose(takes, cone.axis, before);
            const float part = remainder[i] / cone.squared;
            MCV_STORE_3(slot, bounce, axis);
            squared[i] = takes ? cone.squared : squared[i];
            remainder_of[i] = takes ? part : remainder_of[i];
            remainder[i] -= takes ? cone.squared : 0.0f;
        }
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const float xi = remainder_of[i] < 0.99999994f ? remainder_of[i] : 0.99999994f,
                    eta = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER + 1);
        const mcv_vec3 direction = mcv_from_frame(mcv_sample_cone(mcv_sqrt(squared[i]), xi, eta),
                                                  MCV_LOAD_3(slot, bounce));
        MCV_STORE_3(slot, direction, direction);
        angle[i] *= 4.0f * MCV_PI;
    }
    for (uint ball = 0; ball < balls; ++ball) {
        const mcv_ball at = world.frame->balls[ball];
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = i;
            const mcv_vec3 point = MCV_LOAD_3(slot, point), normal = MCV_LOAD_3(slot, normal),
                           direction = MCV_LOAD_3(slot, direction);
            within[i] += (uint)mcv_is_in_cone(
                mcv_cone_to(at, point, mcv_own_cone(world.emitters, normal)), direction);
        }
    }
}

/* mcv_begin_light_path; returns how many paths carry anything. */
static __attribute__((noinline)) uint mcv_begin_light_paths(mcv_world world, uint *paths,
                                                            uint count) {
    float angle[MCV_SLOTS];
    uint within[MCV_SLOTS], begun[MCV_SLOTS];
    mcv_slot slot;
    slot.base = paths;
    for (slot.index = 0; slot.index < count; ++slot.index) {
        const mcv_pair which = mcv_draw(slot, 0, MCV_PAIR_CHOICE),
                       place = mcv_draw(slot, 0, MCV_PAIR_EMITTER);
        __global const uint *cdf = world.emitter_cdf;
        const uint emitter =
            mcv_search_cdf(cdf + world.frame->light_cdf, world.frame->emitter_count,
                           mcv_cdf_bits(which.x, which.y));
        __global const mcv_device_emitter *e = world.emitters + emitter;
        const uint triangle = mcv_choose_triangle(world, e, place);
        const float xi =
            mcv_cdf_remainder(cdf + e->cdf, triangle, mcv_cdf_bits(place.x, place.y));
        MCV_WORD(slot, value, 0) = emitter;
        MCV_WORD(slot, hit, 3) = world.instances[e->instance].first_triangle + triangle;
        MCV_STORE(slot, hit, 1, xi);
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const float root = mcv_sqrt(MCV_LOAD(slot, hit, 1)),
                    share = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_EMITTER + 1);
        const mcv_surface surface =
            mcv_surface_at(world, MCV_WORD(slot, hit, 3), root * (1.0f - share), root * share);
        MCV_STORE_3(slot, point, surface.point);
        MCV_STORE_3(slot, error, surface.error);
        MCV_STORE_3(slot, face, surface.face);
        MCV_STORE_3(slot, normal, surface.normal);
    }
    mcv_aim_together(world, paths, count, angle, within);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        __global const mcv_device_emitter *e = world.emitters + MCV_WORD(slot, value, 0);
        const mcv_aiming aimed = {angle[i], within[i]};
        const mcv_vec3 direction = MCV_LOAD_3(slot, direction), face = MCV_LOAD_3(slot, face);
        const float etendue = mcv_etendue_of(e, aimed, face, direction);
        const int sends = etendue > 0.0f, before_face = mcv_dot(direction, face) > 0.0f;
        const int shines = mcv_area_evaluate(direction, MCV_LOAD_3(slot, normal)) > 0.0f;
        const int leaves = sends & before_face & shines;
        float most = 0.0f;
        MCV_EACH_CHANNEL(c) {
            const float flux = leaves ? e->radiance[c] * etendue : 0.0f;
            MCV_STORE(slot, radiance, c, flux);
            MCV_STORE(slot, throughput, c, 1.0f);
            most = flux > most ? flux : most;
        }
        const mcv_vec3 origin =
            mcv_offset_origin(MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, error), face, direction);
        MCV_STORE_3(slot, origin, origin);
        MCV_STORE(slot, weight, 0, etendue);
#if MCV_WITH_SURFACES
        MCV_WORD(slot, origin_surface, 0) = MCV_NONE;
#endif
#if MCV_WITH_DIELECTRIC
        MCV_WORD(slot, media, 0) = e->media;
#endif
        MCV_WORD(slot, path_class, 0) = MCV_LIGHT_OPEN | MCV_LIGHT_FOUND;
        MCV_STORE(slot, footprint, 0, 0.0f);
        within[i] = (uint)(most > 0.0f);
    }
    const uint next = mcv_compact_indices(within, count, begun);
    if (next < count) mcv_move_paths(paths, begun, next);
    return next;
}
#else
static __attribute__((noinline)) uint mcv_begin_light_paths(mcv_world world, uint *paths,
                                                            uint count) {
    uint begun[MCV_SLOTS];
    uint next = 0;
    mcv_slot slot;
    slot.base = paths;
    for (slot.index = 0; slot.index < count; ++slot.index) {
        const mcv_light_path path = mcv_begin_light_path(world, mcv_draw(slot, 0, MCV_PAIR_CHOICE),
                                                         mcv_draw(slot, 0, MCV_PAIR_EMITTER),
                                                         mcv_draw(slot, 0, MCV_PAIR_SCATTER));
        mcv_store_light_path(slot, path);
        begun[next] = slot.index;
        next += mcv_brightest(path.flux) > 0.0f;
    }
    if (next < count) mcv_move_paths(paths, begun, next);
    return next;
}
#endif

/* Begins the next light paths of the launch's paths *next … last - 1, as many as there is room for;
 * returns how many. */
static __attribute__((noinline)) uint mcv_fill_light_slice(mcv_world world, uint *paths, uint *next,
                                                           uint last) {
    const uint samples = 1u << world.frame->log2_samples;
    mcv_slot slot;
    uint count = 0;
    slot.base = paths;
    while (*next < last && count < MCV_SLICE) {
        mcv_light_identity id;
        if (!mcv_identify_light(world.frame, *next, &id)) {
            *next = (*next | (samples - 1u)) + 1u;
            continue;
        }
        slot.index = count++;
        MCV_WORD(slot, stream, 0) = id.stream;
        MCV_WORD(slot, sample, 0) = id.sample;
        MCV_WORD(slot, density, 0) = id.replicate;
        ++*next;
    }
    mcv_draw_pairs(paths, 0, count, 0, MCV_PAIR_CHOICE);
    mcv_draw_pairs(paths, 0, count, 0, MCV_PAIR_EMITTER);
    mcv_draw_pairs(paths, 0, count, 0, MCV_PAIR_SCATTER);
    return mcv_begin_light_paths(world, paths, count);
}

/* The paths end that have met nothing or what absorbs all, or come straight from the emitter to a
 * diffuse surface; the others lie in the order of what they have met. */
static __attribute__((noinline)) void
mcv_classify_light_hits(mcv_world world, uint *paths, uint count, uint *class_end, uint *gloss) {
    uint classes[MCV_ROW];
    mcv_slot slot;
    slot.base = paths;
    mcv_classify_hits(world, paths, count, classes, gloss);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const uint kind = classes[i];
        const int diffuse =
            (kind == MCV_CLASS_DIFFUSE_TRIANGLE) | (kind == MCV_CLASS_DIFFUSE_EXACT);
        const int carried = (MCV_WORD(slot, path_class, 0) & MCV_LIGHT_CARRIED) != 0u;
        classes[i] =
            ((diffuse & !carried) | (kind >= MCV_CLASS_BLACK)) ? (uint)MCV_CLASS_MISS : kind;
        MCV_STORE(slot, footprint, 0, MCV_LOAD(slot, footprint, 0) + MCV_LOAD(slot, hit, 0));
    }
    mcv_sort_paths(paths, classes, count, class_end);
    mcv_find_surfaces(world, paths, class_end);
#if MCV_WITH_PLAIN
    mcv_find_reflectances(world, paths, class_end[MCV_CLASS_SMOOTH_EXACT],
                          class_end[MCV_CLASS_DIFFUSE_EXACT]);
    mcv_find_reflectances(world, paths, class_end[MCV_CLASS_GLOSS_TRIANGLE],
                          class_end[MCV_CLASS_DIFFUSE_TRIANGLE]);
#endif
}

/* Lists the paths that have a connection to the lens, and their shadow rays; returns how many. */
static __attribute__((noinline)) uint mcv_list_connections(mcv_world world, mcv_slot slot,
                                                           uint first, uint last, uint depth,
                                                           uint *connected) {
    uint count = 0;
    for (slot.index = first; slot.index < last; ++slot.index) {
        mcv_connection connection;
        if (!mcv_connect_light(world, mcv_make_interaction(world, slot), mcv_load_light_path(slot),
                               mcv_draw(slot, depth, MCV_PAIR_EMITTER), &connection))
            continue;
        MCV_STORE_3(slot, shadow_origin, connection.origin);
        MCV_STORE_3(slot, shadow_direction, mcv_sub(connection.end, connection.origin));
#if MCV_WITH_SHEET
        MCV_STORE(slot, sensor_ray, 2, connection.end.x);
        MCV_STORE(slot, sensor_ray, 3, connection.end.y);
        MCV_STORE(slot, sensor_ray, 4, connection.end.z);
        MCV_WORD(slot, emitter, 0) = connection.media;
#endif
#if MCV_WITH_SURFACES
        MCV_WORD(slot, shadow_origin_surface, 0) = connection.begun;
#endif
        MCV_STORE_COLOR(slot, shadow_light, connection.value);
        MCV_STORE(slot, sensor_ray, 0, connection.place.column);
        MCV_STORE(slot, sensor_ray, 1, connection.place.row);
        connected[count++] = slot.index;
    }
    return count;
}

/* Adds what comes to the lens by connections that nothing blocks. */
static __attribute__((noinline)) void mcv_trace_connections(mcv_world world, mcv_slot slot,
                                                            const uint *connected, uint count,
                                                            uint depth, __global uint *splats,
                                                            uint counts[MCV_COUNTER_COUNT]) {
#if !MCV_WITH_SHEET
    const mcv_rows origins = MCV_ROWS(slot, shadow_origin),
                   directions = MCV_ROWS(slot, shadow_direction);
    uint rows[4 * MCV_ROW];
    const mcv_hits hits = mcv_hits_in(rows, MCV_ROW);
    const uint first = count > 0u ? connected[0] : 0u,
               last = count > 0u ? connected[count - 1u] + 1u : 0u;
    mcv_begin_shadows(hits, first, last);
    for (uint i = 0; i < count; ++i) hits.t[connected[i]] = as_uint(1.0f);
    MCV_TRACE_ANY(world.nodes, world.leaves, origins, directions, connected, count, hits);
#if MCV_WITH_SURFACES
    mcv_shadows_past_solids(world, slot.base, first, last, 1, hits);
#endif
    counts[MCV_COUNTER_shadow_rays] += count;
#endif
    for (uint i = 0; i < count; ++i) {
        slot.index = connected[i];
        const mcv_film_point place = {MCV_LOAD(slot, sensor_ray, 0), MCV_LOAD(slot, sensor_ray, 1)};
        mcv_color value;
        MCV_LOAD_COLOR(slot, shadow_light, value);
#if MCV_WITH_SHEET
        uint begun = MCV_NONE;
#if MCV_WITH_SURFACES
        begun = MCV_WORD(slot, shadow_origin_surface, 0);
#endif
        const mcv_color transmittance = mcv_sheet_transmittance(
            world, MCV_LOAD_3(slot, shadow_origin), begun,
            mcv_vec(MCV_LOAD(slot, sensor_ray, 2), MCV_LOAD(slot, sensor_ray, 3),
                    MCV_LOAD(slot, sensor_ray, 4)),
            MCV_WORD(slot, emitter, 0), world.frame->depth - 1u - depth, counts);
        if (!(mcv_brightest(transmittance) > 0.0f)) continue;
        value = mcv_tint(value, transmittance);
#else
        if (hits.triangle[slot.index] != MCV_NONE) continue;
#endif
        mcv_splat(world, splats, MCV_WORD(slot, density, 0), place, value,
                  mcv_draw(slot, depth, MCV_PAIR_CHOICE).x, counts);
    }
}

#if MCV_WITH_PLAIN || MCV_WITH_SMOOTH
/* Sends a path on from a surface of a kind that is known: how the path continues, and in *ways
 * whether it does. */
MCV_LOOP_FUNCTION mcv_light_path mcv_shade_light_hit(mcv_world world, mcv_slot slot,
                                                     const mcv_interaction *interaction,
                                                     mcv_shading shading, uint depth, uint *fate,
                                                     uint *unmatched) {
    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_SCATTER),
                   choice = mcv_draw(slot, depth, MCV_PAIR_CHOICE);
    mcv_light_path path = mcv_load_light_path(slot);
    mcv_scattering other;
    int unshaded = 0;
    shading.splits = 0;
    const mcv_scattering on = mcv_scatter_as(world, slot, interaction, shading, pair, choice.x, 0,
                                             unmatched, &other, &unshaded);
    const int goes_on =
        mcv_continue_light_path(world, interaction, shading, on, depth, choice.y, &path);
    *fate = unshaded ? (uint)MCV_UNSHADED : (uint)goes_on;
    return path;
}

/* The same for the paths in the slots first … last - 1. */
MCV_LOOP_FUNCTION void mcv_shade_light_range(mcv_world world, uint *paths, uint first, uint last,
                                             mcv_shading shading, uint depth, uint *fate,
                                             uint *unmatched) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        uint differs = 0u, what;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        const mcv_light_path path =
            mcv_shade_light_hit(world, slot, &interaction, shading, depth, &what, &differs);
        mcv_store_light_step(slot, shading.kind == MCV_SHADING_GLOSS ? what == MCV_UNSHADED : 0,
                             path);
        unmatched[i] = differs;
        fate[i] = what;
    }
}
#endif

/* Sends the paths on from the surfaces that they have met; returns how many go on. */
static __attribute__((noinline)) uint mcv_shade_light_hits(mcv_world world, mcv_slot slot,
                                                           const uint *class_end, uint gloss,
                                                           uint depth, uint *unmatched) {
    const uint alive = class_end[MCV_CLASS_EXACT], smooth = class_end[MCV_CLASS_SMOOTH_EXACT];
    uint fate[MCV_SLOTS], chosen[MCV_SLOTS], differs[MCV_SLOTS];
    /* Where those begin that are sent on one by one. */
    const uint alone = MCV_WITH_PLAIN ? class_end[MCV_CLASS_DIFFUSE_TRIANGLE] : smooth;
    (void)gloss;
#define MCV_X(first, last, shading) \
    mcv_shade_light_range(world, slot.base, first, last, shading, depth, fate, differs);
    MCV_SMOOTH_RANGES(MCV_X, class_end)
    MCV_PLAIN_RANGES(MCV_X, world, class_end, gloss)
#undef MCV_X
    for (uint i = 0; i < alone; ++i) *unmatched += differs[i];
    for (uint i = alone; i < alive; ++i) fate[i] = MCV_UNSHADED;
    for (slot.index = smooth; slot.index < alive; ++slot.index) {
        if (fate[slot.index] != MCV_UNSHADED) continue;
        mcv_light_path path = mcv_load_light_path(slot);
        fate[slot.index] = (uint)mcv_shade_any_light_hit(
            world, mcv_make_interaction(world, slot), mcv_draw(slot, depth, MCV_PAIR_SCATTER),
            mcv_draw(slot, depth, MCV_PAIR_CHOICE), depth, unmatched, &path);
        mcv_store_light_path(slot, path);
    }
    mcv_offset_origins(slot.base, alive);
    const uint next = mcv_compact_indices(fate, alive, chosen);
    if (next < alive) mcv_move_paths(slot.base, chosen, next);
    return next;
}

/* The light paths of the launch's paths first … last - 1. */
static __attribute__((noinline)) void mcv_trace_light_slices(mcv_world world, uint first, uint last,
                                                             __global uint *splats,
                                                             uint counts[MCV_COUNTER_COUNT]) {
    uint paths[MCV_PATH_WORDS * MCV_ROW];
    uint class_end[MCV_CLASS_COUNT], connected[MCV_SLOTS], gloss;
    mcv_slot slot;
    slot.base = paths;
#if MCV_WITH_GLOSS
    mcv_gloss_interaction glosses[MCV_SLOTS];
    slot.glosses = glosses;
#endif
    while (first < last) {
        uint alive = mcv_fill_light_slice(world, paths, &first, last);
        for (uint depth = 1; depth < world.frame->depth && alive > 0; ++depth) {
            counts[MCV_COUNTER_rays] += alive;
            mcv_intersect_paths(world, slot, alive);
            mcv_classify_light_hits(world, paths, alive, class_end, &gloss);
            alive = class_end[MCV_CLASS_EXACT];
            mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_CHOICE);
            mcv_draw_pairs(paths, class_end[MCV_CLASS_SMOOTH_EXACT], alive, depth,
                           MCV_PAIR_EMITTER);
            const uint count = mcv_list_connections(world, slot, class_end[MCV_CLASS_SMOOTH_EXACT],
                                                    alive, depth, connected);
            mcv_trace_connections(world, slot, connected, count, depth, splats, counts);
            mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_SCATTER);
#if MCV_WITH_DIFFUSE
            mcv_sample_diffuse_directions(paths, class_end[MCV_CLASS_SMOOTH_EXACT], alive);
#endif
            alive = mcv_shade_light_hits(world, slot, class_end, gloss, depth,
                                         &counts[MCV_COUNTER_unmatched]);
        }
        counts[MCV_COUNTER_depth_cut] += alive;
        for (slot.index = 0; slot.index < alive; ++slot.index) {
            mcv_color throughput;
            MCV_LOAD_COLOR(slot, throughput, throughput);
            counts[MCV_COUNTER_lost] += mcv_lost_light(throughput);
        }
    }
}
#else
static __attribute__((noinline)) void mcv_trace_light_slices(mcv_world world, uint first, uint last,
                                                             __global uint *splats,
                                                             uint counts[MCV_COUNTER_COUNT]) {
    for (; first < last; ++first) mcv_trace_light_path(world, first, splats, counts);
}
#endif

#endif
