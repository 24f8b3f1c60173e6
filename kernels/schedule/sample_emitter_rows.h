/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's loops of next-event estimation, up to what the surfaces make of the light.
 * Paths that look for the same emitter are worked out together: what is known of it is read once.
 */
#ifndef MCVISI_KERNELS_SAMPLE_EMITTER_ROWS_H
#define MCVISI_KERNELS_SAMPLE_EMITTER_ROWS_H

#include "schedule/compact.h"
#include "schedule/ranges.h"
#include "stage/sample_emitters.h"

/* Of so many emitters each has some four paths of a slice that look for it; of more, too few to be
 * worked out together. */
#define MCV_MOST_SORTED (MCV_SLICE / 4u)

/* mcv_search_cdf for the chosen paths, by the numbers drawn for a pair. */
static inline __attribute__((noinline)) void mcv_search_cdf_rows(__global const uint *cdf,
                                                                 uint count, mcv_slot slot,
                                                                 uint pair, const uint *chosen,
                                                                 uint chosen_count, uint *found) {
    for (uint i = 0; i < chosen_count; ++i) found[i] = 0;
    for (uint digit = mcv_cdf_digit(count); digit > 0; digit /= 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < chosen_count; ++i) {
            slot.index = chosen[i];
            const mcv_pair drawn = mcv_draw(slot, 0, pair);
            found[i] = mcv_cdf_step(cdf, count, found[i], digit, mcv_cdf_bits(drawn.x, drawn.y));
        }
    }
}

#if MCV_WITH_PLAIN
#if MCV_WITH_REACH
/* mcv_select_emitter for the paths in the slots first … last - 1; both sides of the surfaces of
 * those from two_sided to two_sided_end spread light. */
static __attribute__((noinline)) void mcv_select_emitter_rows(mcv_world world, mcv_slot slot,
                                                              uint first, uint last, uint two_sided,
                                                              uint two_sided_end) {
    const uint count = min(world.frame->emitter_count, (uint)MCV_MOST_REACHING);
    float importances[MCV_MOST_REACHING][MCV_SLOTS], sums[MCV_SLOTS], numbers[MCV_SLOTS];
    for (uint i = first; i < last; ++i) sums[i] = numbers[i] = 0.0f;
    for (uint k = 0; k < count; ++k) {
        __global const mcv_device_emitter *e = world.emitters + k;
        float *of_emitter = importances[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            mcv_reaching all = {sums[i], numbers[i]};
            const int is_two_sided = (i >= two_sided) & (i < two_sided_end);
            of_emitter[i] =
                mcv_add_reaching(e, MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, face),
                                 MCV_LOAD_3(slot, normal), is_two_sided ? 2u : 1u, &all);
            sums[i] = all.sum;
            numbers[i] = all.count;
        }
    }
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_reaching all = {sums[i], numbers[i]};
        mcv_put_selection(slot, mcv_make_light_selection(all));
        MCV_WORD(slot, emitter, 0) = MCV_NONE;
        MCV_STORE_COLOR(slot, shadow_light, mcv_grey(0.0f));
        sums[i] = 0.0f; /* of the chances of those asked */
    }
    for (uint k = 0; k < count; ++k) {
        const float *of_emitter = importances[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            const mcv_emitter_choice so_far = {MCV_WORD(slot, emitter, 0), sums[i]};
            const mcv_emitter_choice choice =
                mcv_ask_emitter(so_far, k, of_emitter[i], mcv_selection_in(slot),
                                MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE));
            MCV_WORD(slot, emitter, 0) = choice.emitter;
            sums[i] = choice.chances;
        }
    }
}
#endif

/* mcv_pick_emitter for the paths on plain surfaces. What these leave to light paths is left out
 * where they make shadow rays (mcv_respond_as). */
static __attribute__((noinline)) void mcv_select_plain_emitters(mcv_world world, mcv_slot slot,
                                                                const uint *class_end, uint gloss) {
    const uint first = class_end[MCV_CLASS_SMOOTH_EXACT],
               last = class_end[MCV_CLASS_DIFFUSE_TRIANGLE];
    uint *emitters = slot.base + MCV_PATH_emitter * MCV_ROW;
    (void)gloss;
    if (world.frame->emitter_count == 1u) {
        for (uint i = first; i < last; ++i) emitters[i] = 0u;
        return;
    }
#if MCV_WITH_REACH
    const int two_sided = gloss != MCV_NONE && world.materials[gloss].scattering_sides == 2u;
    mcv_select_emitter_rows(world, slot, first, last, class_end[MCV_CLASS_DIFFUSE_EXACT],
                            two_sided ? class_end[MCV_CLASS_GLOSS_TRIANGLE]
                                      : class_end[MCV_CLASS_DIFFUSE_EXACT]);
#else
    uint chosen[MCV_SLOTS];
    for (uint i = first; i < last; ++i) chosen[i] = i;
    mcv_search_cdf_rows(world.emitter_cdf, world.frame->emitter_count, slot, MCV_PAIR_CHOICE,
                        chosen + first, last - first, emitters + first);
#endif
}
#endif

/* What comes to a path from the emitter that it has chosen. */
MCV_LOOP_FUNCTION void mcv_put_shadow(mcv_world world, mcv_slot slot, mcv_receiver at, uint emitter,
                                      mcv_shadow shadow) {
    shadow = mcv_apply_selection(world, slot, at.point, emitter, shadow);
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

static __attribute__((noinline)) void mcv_sample_emitter_alone(mcv_world world, mcv_slot slot) {
    const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
    const uint emitter = MCV_WORD(slot, emitter, 0);
    mcv_put_shadow(world, slot, at, emitter,
                   mcv_sample_towards(world, at, emitter, mcv_draw(slot, 0, MCV_PAIR_EMITTER)));
}

/* Whether chosen paths, in ascending order, lie side by side: these are then read as rows. */
MCV_FUNCTION int mcv_is_row(const uint *chosen, uint count) {
    return chosen[count - 1u] - chosen[0] == count - 1u;
}

/* The type of the emitter is known to the compiler, and whether the paths are a row. */
MCV_LOOP_FUNCTION void mcv_sample_direction_row(mcv_world world, mcv_slot slot, uint emitter,
                                                uint type, const uint *chosen, uint count,
                                                int row) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const uint first = chosen[0];
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = row ? first + i : chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        mcv_put_shadow(
            world, slot, at, emitter,
            mcv_sample_direction(world, at, e, type, mcv_draw(slot, 0, MCV_PAIR_EMITTER)));
    }
}

/* The chosen paths look for an emitter in a direction. */
static __attribute__((noinline)) void mcv_sample_directions(mcv_world world, mcv_slot slot,
                                                            uint emitter, const uint *chosen,
                                                            uint count) {
    const uint type = world.emitters[emitter].type;
    const int row = mcv_is_row(chosen, count);
#define MCV_X(TYPE, sample) \
    if (type == TYPE && row) \
        mcv_sample_direction_row(world, slot, emitter, TYPE, chosen, count, 1); \
    else if (type == TYPE) \
        mcv_sample_direction_row(world, slot, emitter, TYPE, chosen, count, 0);
    MCV_DIRECTION_SAMPLERS(MCV_X)
#undef MCV_X
    (void)slot, (void)type, (void)row;
}

#if MCV_WITH_EMISSION
/* `found` holds the triangles that the paths have chosen unless the emitter is a rectangle. Whether
 * it is, and whether the paths are a row, is known to the compiler. */
MCV_LOOP_FUNCTION void mcv_sample_point_row(mcv_world world, mcv_slot slot, uint emitter,
                                            int rectangle, const uint *found, const uint *chosen,
                                            uint count, int row) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const uint first = chosen[0];
    (void)rectangle, (void)found;
#if MCV_WITH_RECTANGLE
    mcv_facets two;
    if (rectangle) two = mcv_facets_of(world, e);
#endif
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        slot.index = row ? first + i : chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        const mcv_pair pair = mcv_draw(slot, 0, MCV_PAIR_EMITTER);
        mcv_emitter_point point;
        mcv_surface there;
#if MCV_WITH_RECTANGLE
        if (rectangle)
            point = mcv_point_on_rectangle(e, &two, at.point, pair);
        else
#endif
            point = mcv_point_on_mesh(world, e, found[i], pair);
        const mcv_shadow shadow = mcv_sample_point(at, e, point, &there);
        mcv_put_shadow(world, slot, at, emitter, shadow);
#if MCV_WITH_TEXTURE
        /* For mcv_light_points. */
        MCV_WORD(slot, place, 0) = there.triangle;
        MCV_STORE(slot, place, 1, there.u);
        MCV_STORE(slot, place, 2, there.v);
        MCV_STORE(slot, place, 3, shadow.density);
#endif
    }
}

#if MCV_WITH_TEXTURE
/* The light of the points of an emitter with an image. */
static __attribute__((noinline)) void mcv_light_points(mcv_world world, mcv_slot slot, uint emitter,
                                                       const uint *chosen, uint count) {
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        const mcv_surface there = mcv_surface_at(
            world, MCV_WORD(slot, place, 0), MCV_LOAD(slot, place, 1), MCV_LOAD(slot, place, 2));
        mcv_shadow shadow = mcv_shadow_in(slot);
        shadow.density = MCV_LOAD(slot, place, 3);
        shadow.light = mcv_light_by_image(world, at.point, there, emitter, shadow.density);
        mcv_put_shadow(world, slot, at, emitter, shadow);
    }
}
#endif

/* The chosen paths look for an emitter at points of its surface. */
static __attribute__((noinline)) void
mcv_sample_points(mcv_world world, mcv_slot slot, uint emitter, const uint *chosen, uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    uint found[MCV_SLOTS];
    if (mcv_is_rectangle(e) && mcv_is_row(chosen, count)) {
        mcv_sample_point_row(world, slot, emitter, 1, found, chosen, count, 1);
    } else if (mcv_is_rectangle(e)) {
        mcv_sample_point_row(world, slot, emitter, 1, found, chosen, count, 0);
    } else {
        mcv_search_cdf_rows(world.emitter_cdf + e->cdf, e->triangle_count, slot, MCV_PAIR_EMITTER,
                            chosen, count, found);
        mcv_sample_point_row(world, slot, emitter, 0, found, chosen, count, 0);
    }
#if MCV_WITH_TEXTURE
    if (mcv_has_image(e)) mcv_light_points(world, slot, emitter, chosen, count);
#endif
}
#endif

#if MCV_WITH_PARALLEL
/* The chosen paths look for a parallel emitter in a direction, or at points of its surface. */
static __attribute__((noinline)) void mcv_sample_parallel_rows(mcv_world world, mcv_slot slot,
                                                               uint emitter, const uint *chosen,
                                                               uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    uint by_direction[MCV_ROW], by_point[MCV_ROW], listed[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const int direction = mcv_samples_direction(e, MCV_LOAD_3(slot, point));
        by_direction[i] = (uint)direction;
        by_point[i] = (uint)!direction;
    }
    const uint directions = mcv_compact_row(by_direction, chosen, count, listed);
    if (directions > 0) mcv_sample_directions(world, slot, emitter, listed, directions);
    const uint points = mcv_compact_row(by_point, chosen, count, listed);
    if (points > 0) mcv_sample_points(world, slot, emitter, listed, points);
}
#endif

/* The chosen paths look for one emitter. */
static __attribute__((noinline)) void mcv_sample_emitter_row(mcv_world world, mcv_slot slot,
                                                             uint emitter, const uint *chosen,
                                                             uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
#if MCV_WITH_PARALLEL
    if (e->type == MCV_EMITTER_PARALLEL) {
        mcv_sample_parallel_rows(world, slot, emitter, chosen, count);
        return;
    }
#endif
    if (mcv_samples_direction(e, mcv_vec(0.0f, 0.0f, 0.0f)))
        mcv_sample_directions(world, slot, emitter, chosen, count);
#if MCV_WITH_EMISSION
    else
        mcv_sample_points(world, slot, emitter, chosen, count);
#endif
}

/* Sorts the paths in the slots first … last - 1 by the emitter that they look for, in ascending
 * order: those of emitter k begin at begins[k]. */
static __attribute__((noinline)) void mcv_sort_by_emitter(const uint *emitters, uint first,
                                                          uint last, uint count, uint *begins,
                                                          uint *sorted) {
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
static __attribute__((noinline)) void mcv_sample_emitter_rows(mcv_world world, mcv_slot slot,
                                                              uint first, uint last) {
    const uint *emitters = slot.base + MCV_PATH_emitter * MCV_ROW;
    const uint count = world.frame->emitter_count;
    uint begins[MCV_MOST_SORTED + 1], sorted[MCV_ROW];
    if (MCV_WITH_CONTACT || count > MCV_MOST_SORTED) {
        for (slot.index = first; slot.index < last; ++slot.index)
            if (emitters[slot.index] != MCV_NONE) mcv_sample_emitter_alone(world, slot);
        return;
    }
    mcv_sort_by_emitter(emitters, first, last, count, begins, sorted);
    for (uint k = 0; k < count; ++k)
        if (begins[k + 1u] > begins[k])
            mcv_sample_emitter_row(world, slot, k, sorted + begins[k], begins[k + 1u] - begins[k]);
}

#if MCV_WITH_PLAIN
/* Whether the paths in the slots first … last - 1, whose surfaces are of one kind, have a shadow
 * ray to follow. */
MCV_LOOP_FUNCTION void mcv_make_shadow_range(mcv_world world, mcv_slot slot, uint first, uint last,
                                             mcv_shading shading, uint *casts) {
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        casts[i] =
            (uint)mcv_make_shadow_ray(world, slot, &interaction, shading, mcv_shadow_in(slot));
    }
}

/* Lists those of the paths on plain surfaces that have a shadow ray to follow; returns how many. */
static __attribute__((noinline)) uint mcv_list_plain_shadows(mcv_world world, mcv_slot slot,
                                                             const uint *class_end, uint gloss,
                                                             uint *shadows) {
    uint casts[MCV_ROW];
    const uint begin = class_end[MCV_CLASS_SMOOTH_EXACT],
               end = class_end[MCV_CLASS_DIFFUSE_TRIANGLE];
    (void)gloss;
#define MCV_X(first, last, shading) mcv_make_shadow_range(world, slot, first, last, shading, casts);
    MCV_PLAIN_RANGES(MCV_X, world, class_end, gloss)
#undef MCV_X
    const uint listed = mcv_compact_indices(casts + begin, end - begin, shadows);
    for (uint i = 0; i < listed; ++i) shadows[i] += begin;
    return listed;
}
#endif

#endif
