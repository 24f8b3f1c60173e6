/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's next-event estimation up to what the surfaces make of the light: what
 * stage/sample_emitters.h does for one path, to the last bit, for many at once. Paths that look for
 * the same emitter are worked out together: what is known of it is read once.
 */
#ifndef MCVISI_KERNELS_LOOK_FOR_EMITTERS_H
#define MCVISI_KERNELS_LOOK_FOR_EMITTERS_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "schedule/ranges.h"
#include "schedule/surface_rows.h"
#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
/* Of so many emitters each has some four paths of a slice that look for it; of more, too few to be
 * worked out together. */
#define MCV_MOST_SORTED (MCV_SLICE / 4u)

/*
 * The i of mcv_search_cdf for many paths: the last one with cdf[i] <= bits, found from its highest
 * binary digit down. The numbers are those drawn for a pair; the paths the chosen ones.
 */
static inline __attribute__((noinline)) void mcv_search_cdf_rows(__global const uint *cdf,
                                                                 uint count, const uint *paths,
                                                                 uint pair, const uint *chosen,
                                                                 uint chosen_count, uint *found) {
    const uint *x = paths + (MCV_PATH_drawn + 2u * pair) * MCV_ROW, *y = x + MCV_ROW;
    uint step = 1;
    while (2 * step < count) step *= 2;
    for (uint i = 0; i < chosen_count; ++i) found[i] = 0;
    for (; step > 0; step /= 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < chosen_count; ++i) {
            const uint bits = mcv_cdf_bits(as_float(x[chosen[i]]), as_float(y[chosen[i]])),
                       next = found[i] + step;
            const int is_there = next < count;
            const int takes = is_there & (cdf[is_there ? next : 0u] <= bits);
            found[i] = takes ? next : found[i];
        }
    }
}

#if MCV_WITH_PLAIN
#if MCV_WITH_REACH
/* mcv_select_emitter for the paths in the slots first … last - 1; both sides of the surfaces of
 * those from two_sided to two_sided_end spread light. */
MCV_BATCH void mcv_select_emitter_rows(mcv_world world, uint *paths, uint first, uint last,
                                       uint two_sided, uint two_sided_end) {
    const uint count = min(world.frame->emitter_count, (uint)MCV_MOST_REACHING);
    float promises[MCV_MOST_REACHING][MCV_SLOTS], sums[MCV_SLOTS], numbers[MCV_SLOTS];
    mcv_slot slot;
    slot.base = paths;
    for (uint i = first; i < last; ++i) sums[i] = numbers[i] = 0.0f;
    for (uint k = 0; k < count; ++k) {
        __global const mcv_device_emitter *e = world.emitters + k;
        float *of_emitter = promises[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            const mcv_vec3 point = MCV_LOAD_3(slot, point);
            const int is_two_sided = (i >= two_sided) & (i < two_sided_end);
            const uint sides = is_two_sided ? 2u : 1u;
            const int reaches = mcv_emitter_reaches(e, point, MCV_LOAD_3(slot, face),
                                                    MCV_LOAD_3(slot, normal), sides);
            const float promise = mcv_emitter_importance(e, point);
            of_emitter[i] = reaches ? promise : -1.0f;
            sums[i] += reaches ? promise : 0.0f;
            numbers[i] += reaches ? 1.0f : 0.0f;
        }
    }
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_light_selection selection = mcv_make_light_selection(sums[i], numbers[i]);
        MCV_STORE(slot, selection_here, 0, selection.scale);
        MCV_STORE(slot, selection_here, 1, selection.least);
        MCV_WORD(slot, emitter, 0) = MCV_NONE;
        MCV_STORE_COLOR(slot, shadow_light, mcv_grey(0.0f));
        sums[i] = 0.0f; /* of the chances of those before */
    }
    for (uint k = 0; k < count; ++k) {
        const float *of_emitter = promises[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            const uint chosen = MCV_WORD(slot, emitter, 0);
            const int open =
                (chosen == MCV_NONE) | (sums[i] <= MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE));
            const int takes = open & (of_emitter[i] >= 0.0f);
            const float chance = mcv_fma(of_emitter[i], MCV_LOAD(slot, selection_here, 0),
                                         MCV_LOAD(slot, selection_here, 1));
            sums[i] += takes ? chance : 0.0f;
            MCV_WORD(slot, emitter, 0) = takes ? k : chosen;
        }
    }
}
#endif

/* mcv_choose_emitter for the paths on plain surfaces, but that whoever leaves its light to light
 * paths (mcv_cast_plain_shadows) chooses. */
MCV_BATCH void mcv_select_plain_emitters(mcv_world world, uint *paths, const uint *class_end,
                                         uint gloss) {
    const uint first = class_end[MCV_CLASS_SMOOTH_EXACT],
               last = class_end[MCV_CLASS_DIFFUSE_TRIANGLE];
    uint *emitters = paths + MCV_PATH_emitter * MCV_ROW;
    (void)gloss;
    if (world.frame->emitter_count == 1u) {
        for (uint i = first; i < last; ++i) emitters[i] = 0u;
        return;
    }
#if MCV_WITH_REACH
    const int two_sided = gloss != MCV_NONE && world.materials[gloss].scattering_sides == 2u;
    mcv_select_emitter_rows(world, paths, first, last, class_end[MCV_CLASS_DIFFUSE_EXACT],
                            two_sided ? class_end[MCV_CLASS_GLOSS_TRIANGLE]
                                      : class_end[MCV_CLASS_DIFFUSE_EXACT]);
#else
    uint chosen[MCV_SLOTS];
    for (uint i = first; i < last; ++i) chosen[i] = i;
    mcv_search_cdf_rows(world.emitter_cdf, world.frame->emitter_count, paths, MCV_PAIR_CHOICE,
                        chosen + first, last - first, emitters + first);
#endif
}
#endif

MCV_LOOP_FUNCTION mcv_receiver mcv_receiver_in(mcv_slot slot) {
    const mcv_receiver at = {MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, error),
                             MCV_LOAD_3(slot, face)};
    return at;
}

MCV_LOOP_FUNCTION void mcv_put_shadow(mcv_slot slot, mcv_shadow shadow) {
    MCV_STORE_3(slot, shadow_origin, shadow.origin);
    MCV_STORE_3(slot, shadow_direction, shadow.direction);
    MCV_WORD(slot, shadow_target, 0) = shadow.target;
    MCV_STORE_COLOR(slot, shadow_light, shadow.light);
    MCV_STORE(slot, shadow_density, 0, shadow.density);
}

MCV_LOOP_FUNCTION mcv_shadow mcv_shadow_in(mcv_slot slot) {
    mcv_shadow shadow;
    shadow.origin = MCV_LOAD_3(slot, shadow_origin);
    shadow.direction = MCV_LOAD_3(slot, shadow_direction);
    shadow.target = MCV_WORD(slot, shadow_target, 0);
    MCV_LOAD_COLOR(slot, shadow_light, shadow.light);
    shadow.density = MCV_LOAD(slot, shadow_density, 0);
    return shadow;
}

MCV_LOOP_FUNCTION mcv_pair mcv_drawn_in(mcv_slot slot) {
    const mcv_pair pair = {MCV_LOAD(slot, drawn, 2 * MCV_PAIR_EMITTER),
                           MCV_LOAD(slot, drawn, 2 * MCV_PAIR_EMITTER + 1)};
    return pair;
}

/* One path. */
MCV_BATCH void mcv_sample_emitter_alone(mcv_world world, uint *paths, uint index) {
    mcv_slot slot;
    slot.base = paths;
    slot.index = index;
#if MCV_WITH_CONTACT
    const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
#else
    const mcv_receiver at = mcv_receiver_in(slot);
#endif
    const uint emitter = MCV_WORD(slot, emitter, 0);
    mcv_put_shadow(slot,
                   mcv_apply_selection(world, slot, at.point, emitter,
                                       mcv_sample_towards(world, at, emitter, mcv_drawn_in(slot))));
}

/* Whether chosen paths, in ascending order, lie side by side: these are then read as rows. */
MCV_FUNCTION int mcv_is_row(const uint *chosen, uint count) {
    return chosen[count - 1u] - chosen[0] == count - 1u;
}

/* Towards an emitter that is looked for without a choice of places; its `type` is known to the
 * compiler. */
MCV_LOOP_FUNCTION mcv_shadow mcv_sample_direction_of(mcv_receiver at,
                                                     __global const mcv_device_emitter *e,
                                                     uint type, mcv_pair pair) {
    mcv_shadow none;
    none.light = mcv_grey(0.0f);
    (void)at, (void)e, (void)type, (void)pair;
#if MCV_WITH_PARALLEL
    if (type == MCV_EMITTER_PARALLEL) return mcv_sample_cone_of(at, e, pair);
#endif
#if MCV_WITH_BEAM
    if (type == MCV_EMITTER_COLLIMATED_BEAM) return mcv_sample_beam_of(at, e);
#endif
#if MCV_WITH_PUNCTUAL
    if (type == MCV_EMITTER_SPOT) return mcv_sample_spot_of(at, e);
    if (type == MCV_EMITTER_DIRECTIONAL) return mcv_sample_directional_of(at, e);
#endif
    return none;
}

/* `row`, known to the compiler: whether the paths are one. */
MCV_LOOP_FUNCTION void mcv_sample_direction_row(mcv_world world, uint *paths, uint emitter,
                                                uint type, const uint *chosen, uint count,
                                                int row) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const uint first = chosen[0];
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = row ? first + i : chosen[i];
        const mcv_receiver at = mcv_receiver_in(slot);
        mcv_put_shadow(
            slot, mcv_apply_selection(world, slot, at.point, emitter,
                                      mcv_sample_direction_of(at, e, type, mcv_drawn_in(slot))));
    }
}

MCV_LOOP_FUNCTION void mcv_sample_directions(mcv_world world, uint *paths, uint emitter, uint type,
                                             const uint *chosen, uint count) {
    if (mcv_is_row(chosen, count))
        mcv_sample_direction_row(world, paths, emitter, type, chosen, count, 1);
    else
        mcv_sample_direction_row(world, paths, emitter, type, chosen, count, 0);
}

#if MCV_WITH_PARALLEL
MCV_BATCH void mcv_sample_cones(mcv_world world, uint *paths, uint emitter, const uint *chosen,
                                uint count) {
    mcv_sample_directions(world, paths, emitter, MCV_EMITTER_PARALLEL, chosen, count);
}

/* Those that choose a direction in the emitter's cone; returns how many, and leaves the others as
 * chosen ones. */
MCV_BATCH uint mcv_list_cones(mcv_world world, const uint *paths, uint emitter, uint *chosen,
                              uint *count, uint *cones) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const uint *x = paths + MCV_PATH_point * MCV_ROW, *y = x + MCV_ROW, *z = y + MCV_ROW;
    uint by_cone[MCV_ROW], by_area[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = 0; i < *count; ++i) {
        const uint k = chosen[i];
        const int is_cone =
            mcv_samples_cone(e, mcv_vec(as_float(x[k]), as_float(y[k]), as_float(z[k])));
        by_cone[i] = (uint)is_cone;
        by_area[i] = (uint)!is_cone;
    }
    const uint listed = mcv_compact_row(by_cone, chosen, *count, cones);
    *count = mcv_compact_row(by_area, chosen, *count, chosen);
    return listed;
}
#endif

#if MCV_WITH_EMISSION
/* The path looks for a place. */
MCV_LOOP_FUNCTION void mcv_store_emitter_point(mcv_world world, mcv_slot slot, mcv_receiver at,
                                               uint emitter, mcv_emitter_point place) {
    mcv_surface there;
    mcv_vec3 back;
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const mcv_shadow shadow = mcv_sample_point_of(at, e, place, &there, &back);
    mcv_shadow preferred = mcv_apply_selection(world, slot, at.point, emitter, shadow);
#if MCV_WITH_TEXTURE
    MCV_WORD(slot, place, 0) = place.facet.triangle;
    MCV_STORE(slot, place, 1, place.u);
    MCV_STORE(slot, place, 2, place.v);
    preferred.density =
        e->texture != MCV_NONE ? shadow.density : preferred.density; /* mcv_light_points */
#endif
    mcv_put_shadow(slot, preferred);
}

#if MCV_WITH_TEXTURE
/* The light of places on an emitter with an image. */
MCV_BATCH void mcv_light_points(mcv_world world, uint *paths, uint emitter, const uint *chosen,
                                uint count) {
    mcv_slot slot;
    slot.base = paths;
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const mcv_vec3 point = MCV_LOAD_3(slot, point);
        const mcv_surface there = mcv_surface_at(
            world, MCV_WORD(slot, place, 0), MCV_LOAD(slot, place, 1), MCV_LOAD(slot, place, 2));
        mcv_shadow shadow = mcv_shadow_in(slot);
        mcv_light_by_image(world, there, emitter,
                           mcv_scale(mcv_normalize(mcv_sub(there.point, point)), -1.0f), &shadow);
        mcv_put_shadow(slot, mcv_apply_selection(world, slot, point, emitter, shadow));
    }
}
#endif

#if MCV_WITH_RECTANGLE
MCV_LOOP_FUNCTION void mcv_sample_rectangle_row(mcv_world world, uint *paths, uint emitter,
                                                const uint *chosen, uint count, int row) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const mcv_facets two = mcv_facets_of(world, e);
    const uint first = chosen[0];
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        slot.index = row ? first + i : chosen[i];
        const mcv_receiver at = mcv_receiver_in(slot);
        mcv_store_emitter_point(world, slot, at, emitter,
                                mcv_choose_on_rectangle(e, &two, at.point, mcv_drawn_in(slot)));
    }
}

MCV_BATCH void mcv_sample_rectangles(mcv_world world, uint *paths, uint emitter, const uint *chosen,
                                     uint count) {
    if (mcv_is_row(chosen, count))
        mcv_sample_rectangle_row(world, paths, emitter, chosen, count, 1);
    else
        mcv_sample_rectangle_row(world, paths, emitter, chosen, count, 0);
}
#endif

/* mcv_choose_emitter_point and what comes from there. */
MCV_BATCH void mcv_sample_mesh(mcv_world world, uint *paths, uint emitter, const uint *chosen,
                               uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    __global const uint *cdf = world.emitter_cdf + e->cdf;
    const uint first = world.instances[e->instance].first_triangle;
    uint found[MCV_SLOTS];
    mcv_slot slot;
    slot.base = paths;
    mcv_search_cdf_rows(cdf, e->triangle_count, paths, MCV_PAIR_EMITTER, chosen, count, found);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const mcv_pair pair = mcv_drawn_in(slot);
        const uint low = cdf[found[i]], width = cdf[found[i] + 1u] - low;
        const float xi = mcv_cdf_remainder(mcv_cdf_bits(pair.x, pair.y) - low, (float)width);
        const uint triangle = first + found[i];
        mcv_store_emitter_point(world, slot, mcv_receiver_in(slot), emitter,
                                mcv_emitter_point_on(mcv_facet_of(world, triangle),
                                                     mcv_triangle_share(world, e, triangle), xi,
                                                     pair.y));
    }
}
#endif

/* The chosen paths look for one emitter; *chosen is of no account afterwards. */
MCV_BATCH void mcv_sample_emitter_row(mcv_world world, uint *paths, uint emitter, uint *chosen,
                                      uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
#if MCV_WITH_BEAM
    if (e->type == MCV_EMITTER_COLLIMATED_BEAM) {
        mcv_sample_directions(world, paths, emitter, MCV_EMITTER_COLLIMATED_BEAM, chosen, count);
        return;
    }
#endif
#if MCV_WITH_PUNCTUAL
    if (e->type == MCV_EMITTER_SPOT) {
        mcv_sample_directions(world, paths, emitter, MCV_EMITTER_SPOT, chosen, count);
        return;
    }
    if (e->type == MCV_EMITTER_DIRECTIONAL) {
        mcv_sample_directions(world, paths, emitter, MCV_EMITTER_DIRECTIONAL, chosen, count);
        return;
    }
#endif
    if (e->instance == MCV_NONE) {
        for (uint i = 0; i < count; ++i) mcv_sample_emitter_alone(world, paths, chosen[i]);
        return;
    }
#if MCV_WITH_PARALLEL
    if (e->type == MCV_EMITTER_PARALLEL && e->parallel.from_receiver) {
        uint cones[MCV_ROW];
        const uint listed = mcv_list_cones(world, paths, emitter, chosen, &count, cones);
        if (listed > 0) mcv_sample_cones(world, paths, emitter, cones, listed);
    }
#endif
#if MCV_WITH_EMISSION
    if (count == 0) return;
#if MCV_WITH_RECTANGLE
    if (mcv_is_rectangle(e))
        mcv_sample_rectangles(world, paths, emitter, chosen, count);
    else
#endif
        mcv_sample_mesh(world, paths, emitter, chosen, count);
#if MCV_WITH_TEXTURE
    if (mcv_has_image(e)) mcv_light_points(world, paths, emitter, chosen, count);
#endif
#endif
}

/* Lists the paths in the slots first … last - 1 that look for an emitter; returns how many. */
MCV_BATCH uint mcv_list_sampling(const uint *emitters, uint first, uint last, uint emitter,
                                 uint *listed) {
    uint looks[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) looks[i - first] = emitters[i] == emitter;
    const uint count = mcv_compact_indices(looks, last - first, listed);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) listed[i] += first;
    return count;
}

/* The same of many emitters: those that look for emitter k begin at begins[k] in `sorted`. */
MCV_BATCH void mcv_sort_by_emitter(const uint *emitters, uint first, uint last, uint count,
                                   uint *begins, uint *sorted) {
    uint next[MCV_MOST_SORTED];
    for (uint k = 0; k <= count; ++k) begins[k] = 0;
    for (uint i = first; i < last; ++i)
        if (emitters[i] != MCV_NONE) ++begins[emitters[i] + 1u];
    for (uint k = 0; k < count; ++k) {
        next[k] = begins[k];
        begins[k + 1u] += begins[k];
    }
    for (uint i = first; i < last; ++i)
        if (emitters[i] != MCV_NONE) sorted[next[emitters[i]]++] = i;
}

/* What comes to the paths in the slots first … last - 1 from the emitters that they look for:
 * together, unless these are so many that few paths look for the same one, or surfaces in the same
 * place move where shadow rays begin. */
MCV_BATCH void mcv_sample_emitter_rows(mcv_world world, uint *paths, uint first, uint last) {
    const uint *emitters = paths + MCV_PATH_emitter * MCV_ROW;
    const uint count = world.frame->emitter_count;
    uint begins[MCV_MOST_SORTED + 1], sorted[MCV_SLOTS], chosen[MCV_ROW];
    if (MCV_WITH_CONTACT || count > MCV_MOST_SORTED) {
        for (uint i = first; i < last; ++i)
            if (emitters[i] != MCV_NONE) mcv_sample_emitter_alone(world, paths, i);
        return;
    }
    const int sorts = count > MCV_MOST_REACHING;
    if (sorts) mcv_sort_by_emitter(emitters, first, last, count, begins, sorted);
    for (uint emitter = 0; first < last && emitter < count; ++emitter) {
        const uint listed = sorts ? begins[emitter + 1u] - begins[emitter]
                                  : mcv_list_sampling(emitters, first, last, emitter, chosen);
        for (uint i = 0; sorts && i < listed; ++i) chosen[i] = sorted[begins[emitter] + i];
        if (listed > 0) mcv_sample_emitter_row(world, paths, emitter, chosen, listed);
    }
}

#if MCV_WITH_PLAIN
/* Whether the paths in the slots first … last - 1, whose surfaces are of one kind, have a shadow
 * ray to follow. */
MCV_LOOP_FUNCTION void mcv_make_shadow_range(mcv_world world, uint *paths, uint first, uint last,
                                             mcv_shading shading, uint *casts) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        casts[i] =
            (uint)mcv_make_shadow_ray(world, slot, &interaction, shading, mcv_shadow_in(slot));
    }
}

/* Lists those of the paths on plain surfaces that have a shadow ray to follow; returns how many. */
MCV_BATCH uint mcv_list_plain_shadows(mcv_world world, uint *paths, const uint *class_end,
                                      uint gloss, uint *shadows) {
    uint casts[MCV_ROW];
    const uint begin = class_end[MCV_CLASS_SMOOTH_EXACT],
               end = class_end[MCV_CLASS_DIFFUSE_TRIANGLE];
    (void)gloss;
#define MCV_MAKE_SHADOWS(bsdf, first, last, shading) \
    if (bsdf != MCV_SHADING_SMOOTH) \
        mcv_make_shadow_range(world, paths, first, last, shading, casts);
    MCV_EACH_RANGE(MCV_MAKE_SHADOWS)
#undef MCV_MAKE_SHADOWS
    const uint listed = mcv_compact_indices(casts + begin, end - begin, shadows);
    for (uint i = 0; i < listed; ++i) shadows[i] += begin;
    return listed;
}
#endif

/* Samples an emitter for each path; lists those that have a shadow ray to follow and returns how
 * many. */
MCV_BATCH uint mcv_sample_emitters(mcv_world world, mcv_slot slot, const uint *class_end,
                                   uint gloss, uint depth, uint *shadows) {
    const uint alive = class_end[MCV_CLASS_EXACT], smooth_end = class_end[MCV_CLASS_SMOOTH_EXACT],
               known_end = class_end[MCV_CLASS_DIFFUSE_TRIANGLE];
    uint shadow_count = 0;
    (void)gloss;
    mcv_draw_pairs(slot.base, smooth_end, alive, depth, MCV_PAIR_EMITTER);
#if MCV_WITH_PLAIN
    mcv_select_plain_emitters(world, slot.base, class_end, gloss);
    mcv_sample_emitter_rows(world, slot.base, smooth_end, known_end);
    shadow_count = mcv_list_plain_shadows(world, slot.base, class_end, gloss, shadows);
#endif
    for (slot.index = known_end; slot.index < alive; ++slot.index)
        MCV_WORD(slot, emitter, 0) = mcv_choose_emitter(world, slot, depth);
    mcv_sample_emitter_rows(world, slot.base, known_end, alive);
    for (slot.index = known_end; slot.index < alive; ++slot.index) {
        if (MCV_WORD(slot, emitter, 0) == MCV_NONE) continue;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        if (mcv_make_shadow_ray(world, slot, &interaction, mcv_any_shading(), mcv_shadow_in(slot)))
            shadows[shadow_count++] = slot.index;
    }
    return shadow_count;
}
#endif

#endif
