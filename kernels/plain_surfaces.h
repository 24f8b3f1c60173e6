/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's order of the paths that have met something, and what it does with those on plain surfaces: of all surfaces they are
 * the most common ones, and all that happens there is worked out without branches, for many paths at once. Each function does what the
 * stages do for one path (sample_emitters.cl, shade_surfaces.cl), to the last bit.
 *
 * A plain surface reflects diffusely, without texture, and does not emit.
 */
#ifndef MCVISI_KERNELS_PLAIN_SURFACES_H
#define MCVISI_KERNELS_PLAIN_SURFACES_H

#define MCV_WITH_PLAIN (MCV_WITH_DIFFUSE && MCV_LEAVES_TOGETHER && !MCV_WITH_TRANSLUCENT && !MCV_WITH_DISPERSION && !MCV_WITH_LIGHT_TRACING)

/* What paths have met. The paths of a kind lie side by side in this order; ends[kind] is where the next kind begins. */
enum { MCV_MET_PLAIN_TRIANGLE, MCV_MET_PLAIN_EXACT, MCV_MET_EXACT, MCV_MET_TRIANGLE, MCV_MET_NOTHING, MCV_MET_COUNT };

MCV_LOOP_FUNCTION uint mcv_kind_met(mcv_world world, uint met) {
    uint exact = 0;
    if (met == MCV_NONE) return MCV_MET_NOTHING;
#if MCV_WITH_SURFACES
    exact = met >= MCV_EXACT;
#endif
#if MCV_WITH_PLAIN
    __global const mcv_device_instance *instance = world.instances + mcv_instance_of(world, met);
    __global const mcv_device_material *material = world.materials + instance->material;
    if (material->type == MCV_MATERIAL_DIFFUSE && material->texture == MCV_NONE && instance->emitter == MCV_NONE)
        return exact ? MCV_MET_PLAIN_EXACT : MCV_MET_PLAIN_TRIANGLE;
#else
    (void)world;
#endif
    return exact ? MCV_MET_EXACT : MCV_MET_TRIANGLE;
}

/* Puts the paths in the order of what they have met, in place: whoever is not among its own kind changes places with one who belongs there.
 */
static __attribute__((noinline)) void mcv_order_paths(mcv_world world, uint *paths, uint count, uint *ends) {
    uint kinds[MCV_SLICE], one[MCV_SLICE], other[MCV_SLICE];
    uint next[MCV_MET_COUNT];
    uint swaps = 0;
    MCV_PARALLEL
    for (uint i = 0; i < count; ++i) kinds[i] = mcv_kind_met(world, paths[(MCV_PATH_hit + 3) * MCV_SLICE + i]);
    for (uint kind = 0, end = 0; kind < MCV_MET_COUNT; ++kind) {
        next[kind] = end;
        for (uint i = 0; i < count; ++i) end += kinds[i] == kind;
        ends[kind] = end;
    }
    for (uint kind = 0; kind < MCV_MET_COUNT; ++kind) {
        for (uint i = next[kind]; i < ends[kind]; ++i) {
            while (kinds[i] != kind) {
                const uint theirs = kinds[i];
                while (kinds[next[theirs]] == theirs) ++next[theirs];
                one[swaps] = i;
                other[swaps++] = next[theirs];
                kinds[i] = kinds[next[theirs]];
                kinds[next[theirs]++] = theirs;
            }
        }
    }
    for (uint word = 0; swaps > 0 && word < MCV_PATH_hit + 4; ++word) {
        uint *row = paths + word * MCV_SLICE;
        for (uint i = 0; i < swaps; ++i) {
            const uint kept = row[one[i]];
            row[one[i]] = row[other[i]];
            row[other[i]] = kept;
        }
    }
}

#if MCV_WITH_PLAIN
/* mcv_leave_meeting */
MCV_LOOP_FUNCTION uint mcv_leave_plain(mcv_world world, mcv_slot slot, mcv_vec3 direction, int exact) {
#if MCV_WITH_SURFACES
    if (exact) {
        const uint met = MCV_WORD(slot, hit, 3), number = (met & ~MCV_EXACT) >> 2, piece = met & 3u;
        const mcv_vec3 face = mcv_scale(MCV_LOAD_3(slot, face), MCV_WORD(slot, inside, 0) != 0u ? -1.0f : 1.0f);
        const uint outwards = mcv_dot(direction, face) > 0.0f;
        return mcv_surface_of_piece(world.solids + number, number, piece) << 1 | (piece == MCV_PIECE_FIRST_CAP ? 1u - outwards : outwards);
    }
#endif
    (void)world, (void)slot, (void)direction, (void)exact;
    return MCV_NONE;
}

#if MCV_WITH_NEXT_EVENT && MCV_WITH_AREA
/* Whether all paths look for one rectangle or triangle that emits alike in all directions, everywhere. */
MCV_FUNCTION int mcv_has_plain_emitter(mcv_world world) {
    __global const mcv_device_emitter *e = world.emitters;
    return world.frame->emitter_count == 1u && e->type == MCV_EMITTER_AREA && e->instance != MCV_NONE && e->triangle_count <= 2u &&
           e->texture == MCV_NONE;
}

/* mcv_choose_emitter, mcv_choose_place */
static __attribute__((noinline)) void mcv_choose_plain_places(mcv_world world, uint *paths, uint count) {
    __global const mcv_device_emitter *e = world.emitters;
    __global const uint *cdf = world.emitter_cdf + e->cdf;
    const uint triangle = world.instances[e->instance].first_triangle;
    const uint between = e->triangle_count > 1u ? cdf[1] : 0x80000000u, end = cdf[e->triangle_count];
    const float width[2] = {(float)(cdf[1] - cdf[0]), (float)(end - between)};
    const uint begin = cdf[0];
    mcv_slot slot;
    slot.base = paths;
    MCV_PARALLEL
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const float x = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_EMITTER), y = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_EMITTER + 1);
        const uint bits = mcv_cdf_bits(x, y);
        const int second = between <= bits;
        const float root = mcv_sqrt(mcv_cdf_rest(bits - (second ? between : begin), second ? width[1] : width[0]));
        MCV_WORD(slot, emitter, 0) = 0u;
        MCV_WORD(slot, place, 0) = triangle + (uint)second;
        MCV_STORE(slot, place, 1, root * (1.0f - y));
        MCV_STORE(slot, place, 2, root * y);
    }
}

/* mcv_shadow_along, mcv_cast_shadow: whether there is a shadow ray to follow. */
static __attribute__((noinline)) void mcv_cast_plain_shadows(mcv_world world, uint *paths, uint first, uint last, int exact, uint *casts) {
    __global const mcv_device_emitter *e = world.emitters;
    mcv_slot slot;
    slot.base = paths;
    MCV_PARALLEL
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_vec3 way = MCV_LOAD_3(slot, shadow_direction), back = mcv_scale(MCV_LOAD_3(slot, way), -1.0f);
        const float density = MCV_LOAD(slot, way_density, 0);
        int lit = (density > 0.0f) & (density < INFINITY) & (mcv_dot(back, MCV_LOAD_3(slot, way_face)) > 0.0f);
#if MCV_WITH_NORMALS
        lit &= mcv_dot(back, MCV_LOAD_3(slot, way_normal)) > 0.0f;
#endif
        const mcv_vec3 direction = mcv_normalize(way);
        const float cosine = mcv_dot(direction, MCV_LOAD_3(slot, normal));
        lit &= (cosine > 0.0f) & (mcv_dot(direction, MCV_LOAD_3(slot, face)) > 0.0f);
        const float response = mcv_diffuse_density(cosine);
        const float weight = mcv_choice_weight(density, response);
        __global const mcv_device_material *material = world.materials + world.instances[MCV_WORD(slot, instance, 0)].material;
        float most_sent = 0.0f, most_reflected = 0.0f;
        mcv_color light;
        MCV_LOAD_COLOR(slot, throughput, light);
        MCV_EACH_CHANNEL(c) {
            const float sent = e->radiance[c] * (1.0f / density), reflected = material->value[c] * response;
            most_sent = sent > most_sent ? sent : most_sent;
            most_reflected = reflected > most_reflected ? reflected : most_reflected;
            light.c[c] = light.c[c] * reflected * sent * weight;
        }
#if MCV_WITH_DIELECTRIC
        light = mcv_dim(light, world.media[mcv_filling_medium(MCV_WORD(slot, media, 0))].inverse_index_squared);
#if MCV_WITH_GLOSS
        MCV_WORD(slot, shadow_media, 0) = MCV_WORD(slot, media, 0);
#endif
#endif
#if MCV_WITH_SURFACES
        MCV_WORD(slot, shadow_left, 0) = mcv_leave_plain(world, slot, way, exact);
#endif
        MCV_WORD(slot, shadow_target, 0) = MCV_NONE;
        MCV_STORE_COLOR(slot, shadow_light, light);
        casts[i] = (uint)(lit & (most_sent > 0.0f) & (most_reflected > 0.0f));
    }
}
#endif

/* mcv_shade_surface: whether the paths go on. */
static __attribute__((noinline)) void mcv_shade_plain(mcv_world world, uint *paths, uint first, uint last, uint depth, int exact,
                                                      uint *goes_on) {
    const int roulette = depth >= MCV_ROULETTE_DEPTH;
    mcv_slot slot;
    slot.base = paths;
    MCV_PARALLEL
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_vec3 bounce = MCV_LOAD_3(slot, bounce);
        const int reflects = mcv_dot(bounce, MCV_LOAD_3(slot, face)) > 0.0f;
        __global const mcv_device_material *material = world.materials + world.instances[MCV_WORD(slot, instance, 0)].material;
        mcv_color throughput;
        MCV_LOAD_COLOR(slot, throughput, throughput);
        MCV_EACH_CHANNEL(c) throughput.c[c] *= material->value[c];
        const float brightest = mcv_brightest(throughput);
        const int plays = roulette & (brightest < 1.0f);
        const float choice = roulette ? MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE + 1) : 0.0f;
        const float more = 1.0f / brightest;
        MCV_EACH_CHANNEL(c) throughput.c[c] = plays ? throughput.c[c] * more : throughput.c[c];
        MCV_STORE_3(slot, direction, bounce);
#if MCV_WITH_SURFACES
        MCV_WORD(slot, left, 0) = mcv_leave_plain(world, slot, bounce, exact);
#endif
        MCV_STORE_COLOR(slot, throughput, throughput);
#if MCV_WITH_NEXT_EVENT
        MCV_STORE(slot, density, 0, MCV_LOAD(slot, bounce, 3));
#if MCV_WITH_REACH
        MCV_WORD(slot, reach, 0) = MCV_WORD(slot, reach_here, 0);
        MCV_WORD(slot, reach, 1) = MCV_WORD(slot, reach_here, 1);
#endif
#endif
        goes_on[i] = (uint)(reflects & (brightest > 0.0f) & !(plays & (choice >= brightest)));
    }
}
#endif

#endif
