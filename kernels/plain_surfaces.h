/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's order of the paths that have met something, and what it does with those on plain surfaces: of all surfaces they are
 * the most common ones, and all that happens there is worked out without branches, for many paths at once. Each function does what the
 * stages do for one path (sample_emitters.cl, shade_surfaces.cl), to the last bit.
 *
 * A plain surface reflects diffusely, or is made of microfacets that have no direction; it has no texture and does not emit. Of glossy
 * materials only one in a slice is plain: its table is read once.
 */
#ifndef MCVISI_KERNELS_PLAIN_SURFACES_H
#define MCVISI_KERNELS_PLAIN_SURFACES_H

#define MCV_WITH_PLAIN (MCV_WITH_DIFFUSE && MCV_LEAVES_TOGETHER && !MCV_WITH_TRANSLUCENT && !MCV_WITH_DISPERSION)
#define MCV_WITH_SMOOTH (MCV_WITH_DIELECTRIC && MCV_LEAVES_TOGETHER && !MCV_WITH_DISPERSION)

/* What paths have met. The paths of a kind lie side by side in this order; ends[kind] is where the next kind begins. */
enum {
    MCV_MET_SMOOTH_TRIANGLE,
    MCV_MET_SMOOTH_EXACT,
    MCV_MET_DIFFUSE_EXACT,
    MCV_MET_GLOSS_EXACT,
    MCV_MET_GLOSS_TRIANGLE,
    MCV_MET_DIFFUSE_TRIANGLE, /* the last plain one */
    MCV_MET_TRIANGLE,
    MCV_MET_EXACT,
    MCV_MET_NOTHING,
    MCV_MET_COUNT,
    /* What absorbs all light; if it is the lamp of an emitter, the emitter's number and 1 more. Such paths end before the others are put in
     * order (kernels/end_paths.h). */
    MCV_MET_BLACK = MCV_MET_COUNT
};

/* Instead of MCV_GOES_ON …: the path is left to mcv_shade_surface. */
enum { MCV_IS_LEFT = 4 };

/* Where a ray has met nothing or the other sort of surface, the first one is read instead; `triangles` may be read there. */
MCV_LOOP_FUNCTION uint mcv_kind_met(mcv_world world, __global const uint *triangles, uint met) {
    const int nothing = met == MCV_NONE;
    int exact = 0;
#if MCV_WITH_SURFACES
    exact = !nothing & (met >= MCV_EXACT);
#endif
    __global const uint *met_at = triangles + 4u * (nothing | exact ? 0u : met) + 3u;
#if MCV_WITH_SURFACES
    met_at = exact ? world.solids[(met & ~MCV_EXACT) >> 2].instance + (met & 3u) : met_at;
#endif
    const uint instance = *met_at, shading = world.instances[nothing ? 0u : instance].shading;
    uint kind = exact ? MCV_MET_EXACT : MCV_MET_TRIANGLE;
    kind = shading >= MCV_SHADED_BLACK ? MCV_MET_BLACK + (shading - MCV_SHADED_BLACK) : kind;
#if MCV_WITH_SMOOTH
    kind = shading == MCV_SHADED_SMOOTH ? (exact ? MCV_MET_SMOOTH_EXACT : MCV_MET_SMOOTH_TRIANGLE) : kind;
#endif
#if MCV_WITH_PLAIN
    kind = shading == MCV_SHADED_DIFFUSE ? (exact ? MCV_MET_DIFFUSE_EXACT : MCV_MET_DIFFUSE_TRIANGLE) : kind;
#if MCV_WITH_GLOSS
    kind = shading == MCV_SHADED_GLOSSY ? (exact ? MCV_MET_GLOSS_EXACT : MCV_MET_GLOSS_TRIANGLE) : kind;
#endif
#endif
    return nothing ? MCV_MET_NOTHING : kind;
}

#if MCV_FEW
/* The same where there are few triangles and exact surfaces. */
static __attribute__((noinline)) void mcv_look_up_kinds(mcv_world world, __global const uint *triangles, const uint *met, uint count,
                                                        uint *kinds) {
    uint of_each[MCV_FEW];
    MCV_PARALLEL
    for (uint i = 0; i < MCV_FEW; ++i) of_each[i] = mcv_kind_met(world, triangles, i < world.frame->triangle_count ? i : MCV_NONE);
    mcv_look_up(of_each, met, count, kinds);
#if MCV_WITH_SURFACES
    uint exacts[MCV_ROW];
    MCV_PARALLEL
    for (uint i = 0; i < MCV_FEW; ++i) {
        const int is_piece = (i >> 2 < world.frame->solid_count) & ((i & 3u) < MCV_PIECE_COUNT);
        of_each[i] = mcv_kind_met(world, triangles, is_piece ? MCV_EXACT | i : MCV_NONE);
    }
    mcv_look_up(of_each, met, count, exacts);
    MCV_PARALLEL
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) kinds[i] = met[i] >= MCV_EXACT ? exacts[i] : kinds[i];
#endif
    MCV_PARALLEL
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) kinds[i] = ((i < count) & (met[i] != MCV_NONE)) ? kinds[i] : MCV_MET_NOTHING;
}
#endif

/* What the paths have met. */
static __attribute__((noinline)) void mcv_find_kinds(mcv_world world, const uint *paths, uint count, uint *kinds, uint *gloss) {
    const uint *met = paths + (MCV_PATH_hit + 3) * MCV_ROW;
    __global const uint *triangles = (__global const uint *)world.triangles;
#if MCV_WITH_SURFACES
    if (!triangles) triangles = (__global const uint *)world.solids;
#endif
    *gloss = MCV_NONE;
    if (!triangles) {
        for (uint i = 0; i < count; ++i) kinds[i] = MCV_MET_NOTHING;
        return;
    }
#if MCV_FEW
    if (world.frame->triangle_count <= MCV_FEW && 4u * world.frame->solid_count <= MCV_FEW && count >= 2 * MCV_FEW)
        mcv_look_up_kinds(world, triangles, met, count, kinds);
    else
#endif
    {
        MCV_PARALLEL
        for (uint i = 0; i < mcv_fill_lanes(count); ++i) kinds[i] = mcv_kind_met(world, triangles, i < count ? met[i] : MCV_NONE);
    }
#if MCV_WITH_PLAIN && MCV_WITH_GLOSS
    for (uint i = 0; i < count; ++i) {
        if (kinds[i] != MCV_MET_GLOSS_TRIANGLE && kinds[i] != MCV_MET_GLOSS_EXACT) continue;
        const uint material = world.instances[mcv_instance_of(world, met[i])].material;
        if (*gloss == MCV_NONE) *gloss = material;
        if (*gloss != material) kinds[i] = kinds[i] == MCV_MET_GLOSS_EXACT ? MCV_MET_EXACT : MCV_MET_TRIANGLE;
    }
#endif
}

/*
 * Which paths move where, one after the other, until they lie in the order of what they have met; returns how many moves. Those that have
 * met nothing, the last kind, are no longer needed: others take their slots. A path that makes room for a ring of others waits in the slot
 * MCV_SLOTS.
 */
static __attribute__((noinline)) uint mcv_plan_moves(uint *kinds, uint count, uint *ends, uint *from, uint *to) {
    uint homes[MCV_ROW];                                      /* kinds whose slots they are */
    uint strays[MCV_ROW], astray[MCV_SLOTS], next[MCV_SLOTS]; /* who is not where it belongs, in a list, and the next such of its kind */
    uint leaves[MCV_ROW], holes[MCV_SLOTS];                   /* whose slots others take */
    uint first[MCV_MET_COUNT], last[MCV_MET_NOTHING] = {0};
    uint moves = 0;
    MCV_PARALLEL
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const uint kind = i < count ? kinds[i] : MCV_MET_NOTHING;
#pragma unroll
        for (uint k = 0; k < MCV_MET_NOTHING; ++k) last[k] += kind <= k;
    }
    for (uint kind = 0; kind < MCV_MET_COUNT; ++kind) {
        ends[kind] = kind == MCV_MET_NOTHING ? count : last[kind];
        first[kind] = MCV_NONE;
    }
    MCV_PARALLEL
    for (size_t i = 0; i < mcv_fill_lanes(count); ++i) {
        uint home = 0;
#pragma unroll
        for (uint k = 0; k < MCV_MET_NOTHING; ++k) home += (uint)i >= last[k];
        const int moves_on = kinds[i] != home, nothing = kinds[i] == MCV_MET_NOTHING;
        homes[i] = home;
        strays[i] = (uint)(moves_on & !nothing);
        leaves[i] = (uint)(moves_on & nothing);
    }
    const uint stray_count = mcv_list(strays, count, astray), hole_count = mcv_list(leaves, count, holes);
    for (uint k = 0; k < stray_count; ++k) {
        const uint i = astray[k];
        next[i] = first[kinds[i]];
        first[kinds[i]] = i;
    }
    for (uint k = 0; k < hole_count; ++k) {
        for (uint hole = holes[k]; homes[hole] != MCV_MET_NOTHING; ++moves) {
            const uint home = homes[hole], path = first[home];
            first[home] = next[path];
            from[moves] = path;
            to[moves] = hole;
            kinds[hole] = home;
            hole = path;
        }
    }
    for (uint k = 0; k < stray_count; ++k) {
        const uint begin = astray[k];
        if (homes[begin] == kinds[begin] || homes[begin] == MCV_MET_NOTHING) continue;
        uint hole = begin;
        from[moves] = begin;
        to[moves++] = MCV_SLOTS;
        do {
            const uint home = homes[hole], path = first[home];
            first[home] = next[path];
            from[moves] = path == begin ? MCV_SLOTS : path;
            to[moves++] = hole;
            kinds[hole] = home;
            hole = path;
        } while (hole != begin);
    }
    return moves;
}

/* Puts the paths in the order of what they have met, in place; those that have met nothing are lost. */
static __attribute__((noinline)) void mcv_order_paths(uint *paths, uint *kinds, uint count, uint *ends) {
    uint from[2 * MCV_SLOTS], to[2 * MCV_SLOTS];
    const uint moves = mcv_plan_moves(kinds, count, ends, from, to);
    for (uint word = 0; moves > 0 && word < MCV_PATH_hit + 4; ++word) {
        uint *row = paths + word * MCV_ROW;
        for (uint i = 0; i < moves; ++i) row[to[i]] = row[from[i]];
    }
}

#if MCV_WITH_PLAIN || MCV_WITH_SMOOTH
/* mcv_leave_meeting */
MCV_LOOP_FUNCTION uint mcv_leave_plain(mcv_world world, mcv_slot slot, mcv_vec3 direction, int exact) {
#if MCV_WITH_SURFACES
    if (exact && MCV_WORD(slot, hit, 3) >= MCV_EXACT) {
        const uint met = MCV_WORD(slot, hit, 3), number = (met & ~MCV_EXACT) >> 2, piece = met & 3u;
        const mcv_vec3 face = mcv_scale(MCV_LOAD_3(slot, face), MCV_WORD(slot, inside, 0) != 0u ? -1.0f : 1.0f);
        const uint outwards = mcv_dot(direction, face) > 0.0f;
        return mcv_surface_of_piece(world.solids + number, number, piece) << 1 | (piece == MCV_PIECE_FIRST_CAP ? 1u - outwards : outwards);
    }
#endif
    (void)world, (void)slot, (void)direction, (void)exact;
    return MCV_NONE;
}
#endif

#if MCV_WITH_PLAIN
MCV_LOOP_FUNCTION mcv_color mcv_reflectance_of(mcv_world world, uint instance) {
    mcv_color reflectance;
    MCV_EACH_CHANNEL(c) reflectance.c[c] = world.materials[world.instances[instance].material].value[c];
    return reflectance;
}

/* What the diffuse surfaces reflect that the paths in the slots first … last - 1 have met. What follows in the row is of no account then.
 */
static __attribute__((noinline)) void mcv_find_reflectances(mcv_world world, uint *paths, uint first, uint last) {
    const uint *instances = paths + MCV_PATH_instance * MCV_ROW;
    uint *rows = paths + MCV_PATH_reflectance * MCV_ROW;
#if MCV_FEW
    const uint count = world.frame->instance_count;
    if (count - 1u < MCV_FEW && last - first >= 2 * MCV_FEW) {
        uint of_each[MCV_CHANNELS][MCV_FEW];
        MCV_PARALLEL
        for (uint i = 0; i < MCV_FEW; ++i) {
            const mcv_color reflectance = mcv_reflectance_of(world, i < count ? i : 0u);
            MCV_EACH_CHANNEL(c) of_each[c][i] = as_uint(reflectance.c[c]);
        }
        for (uint c = 0; c < MCV_CHANNELS; ++c) mcv_look_up(of_each[c], instances + first, last - first, rows + c * MCV_ROW + first);
        return;
    }
#endif
    MCV_PARALLEL_MASKED
    for (uint i = first; i < last; ++i) {
        const mcv_color reflectance = mcv_reflectance_of(world, instances[i]);
        MCV_EACH_CHANNEL(c) rows[c * MCV_ROW + i] = as_uint(reflectance.c[c]);
    }
}

#if MCV_WITH_GLOSS
/* What is known of a plain glossy material beforehand. */
static mcv_device_gloss mcv_plain_gloss(mcv_world world, uint material) {
    mcv_device_gloss from = world.gloss[material];
    from.azimuths = from.roughnesses = 1u;
    from.anisotropy = 0.0f;
    return from;
}

MCV_LOOP_FUNCTION mcv_gloss_meeting mcv_meet_plain_gloss(mcv_world world, const mcv_meeting *meeting, const mcv_device_gloss *from,
                                                         uint material, uint type, uint media) {
    mcv_color base;
    MCV_EACH_CHANNEL(c) base.c[c] = world.materials[material].value[c];
    return mcv_meet_gloss_of(world, meeting, from, type, base, 1.0f, 1.0f, media);
}
#endif

#if MCV_WITH_NEXT_EVENT
/* mcv_cast_shadow: whether there is a shadow ray to follow. `type` is known to the compiler; `gloss`: the glossy material. */
MCV_LOOP_FUNCTION void mcv_cast_plain_shadows(mcv_world world, uint *paths, uint first, uint last, int exact, uint type, uint gloss,
                                              uint *casts) {
    mcv_slot slot;
    slot.base = paths;
    (void)world, (void)exact, (void)gloss;
#if MCV_WITH_GLOSS
    mcv_device_gloss from;
    if (type != MCV_MATERIAL_DIFFUSE) from = mcv_plain_gloss(world, gloss);
#endif
    MCV_PARALLEL_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_vec3 way = MCV_LOAD_3(slot, shadow_direction), direction = mcv_normalize(way);
        const float density = MCV_LOAD(slot, shadow_density, 0);
        int lit = 1;
        mcv_response response;
        response.media = mcv_path_media(slot);
        if (type == MCV_MATERIAL_DIFFUSE) {
            const float cosine = mcv_dot(direction, MCV_LOAD_3(slot, normal));
            lit &= (cosine > 0.0f) & (mcv_dot(direction, MCV_LOAD_3(slot, face)) > 0.0f);
            response.density = mcv_diffuse_density(cosine);
            MCV_EACH_CHANNEL(c) response.value.c[c] = MCV_LOAD(slot, reflectance, c) * response.density;
        } else {
#if MCV_WITH_GLOSS
            const mcv_meeting meeting = mcv_meet_surface(world, slot);
            const mcv_gloss_meeting m = mcv_meet_plain_gloss(world, &meeting, &from, gloss, type, response.media);
            response = mcv_respond_gloss_of(world, &meeting, &from, &m, direction);
            lit &= m.gloss.table != MCV_NONE;
            const uint emitter = MCV_WORD(slot, emitter, 0);
            lit &= !mcv_leaves_to_light_paths(world, slot, emitter == MCV_NONE ? 0u : emitter, (int)world.materials[gloss].sharp);
#endif
        }
        const float weight = density > 0.0f ? mcv_choice_weight(density, response.density) : 1.0f;
        float most_sent = 0.0f, most_reflected = 0.0f;
        mcv_color sent, light;
        MCV_LOAD_COLOR(slot, throughput, light);
        MCV_LOAD_COLOR(slot, shadow_light, sent);
        MCV_EACH_CHANNEL(c) {
            most_sent = sent.c[c] > most_sent ? sent.c[c] : most_sent;
            most_reflected = response.value.c[c] > most_reflected ? response.value.c[c] : most_reflected;
            light.c[c] = light.c[c] * response.value.c[c] * sent.c[c] * weight;
        }
#if MCV_WITH_DIELECTRIC
        light = mcv_dim(light, world.media[mcv_filling_medium(response.media)].inverse_index_squared);
#if MCV_WITH_GLOSS
        MCV_WORD(slot, shadow_media, 0) = response.media;
#endif
#endif
#if MCV_WITH_SURFACES
        MCV_WORD(slot, shadow_left, 0) = mcv_leave_plain(world, slot, way, exact);
#endif
        MCV_STORE_COLOR(slot, shadow_light, light);
        casts[i] = (uint)(lit & (most_sent > 0.0f) & (most_reflected > 0.0f));
    }
}

/* Lists those of the plain paths that have a shadow ray to follow; returns how many. */
static __attribute__((noinline)) uint mcv_list_plain_shadows(mcv_world world, uint *paths, const uint *ends, uint gloss, uint *shadows) {
    uint casts[MCV_ROW];
    const uint first = ends[MCV_MET_DIFFUSE_EXACT], last = ends[MCV_MET_GLOSS_TRIANGLE];
    (void)gloss, (void)first;
    mcv_cast_plain_shadows(world, paths, last, ends[MCV_MET_DIFFUSE_TRIANGLE], 0, MCV_MATERIAL_DIFFUSE, MCV_NONE, casts);
#if MCV_WITH_SURFACES
    mcv_cast_plain_shadows(world, paths, ends[MCV_MET_SMOOTH_EXACT], first, 1, MCV_MATERIAL_DIFFUSE, MCV_NONE, casts);
#endif
#if MCV_WITH_GLOSS
    const uint type = gloss == MCV_NONE ? MCV_NONE : world.materials[gloss].type;
    if (type == MCV_MATERIAL_CONDUCTOR)
        mcv_cast_plain_shadows(world, paths, first, last, MCV_WITH_SURFACES, MCV_MATERIAL_CONDUCTOR, gloss, casts);
    if (type == MCV_MATERIAL_METALLIC_ROUGHNESS)
        mcv_cast_plain_shadows(world, paths, first, last, MCV_WITH_SURFACES, MCV_MATERIAL_METALLIC_ROUGHNESS, gloss, casts);
#if MCV_WITH_DIELECTRIC
    if (type == MCV_MATERIAL_DIELECTRIC)
        mcv_cast_plain_shadows(world, paths, first, last, MCV_WITH_SURFACES, MCV_MATERIAL_DIELECTRIC, gloss, casts);
#endif
#endif
    const uint begin = ends[MCV_MET_SMOOTH_EXACT];
    const uint listed = mcv_list(casts + begin, ends[MCV_MET_DIFFUSE_TRIANGLE] - begin, shadows);
    for (uint i = 0; i < listed; ++i) shadows[i] += begin;
    return listed;
}
#endif

/* mcv_shade_surface; into `parted` how branches go on. `type`, and whether it is glass whose paths may part, are known to the compiler;
 * `gloss`: the glossy material. */
MCV_LOOP_FUNCTION void mcv_shade_plain(mcv_world world, uint *paths, uint first, uint last, uint depth, int exact, uint type, int parts,
                                       uint gloss, uint *ways, uint *unmatched) {
    const int roulette = depth >= MCV_ROULETTE_DEPTH;
    (void)world, (void)exact, (void)parts, (void)gloss, (void)unmatched;
    mcv_slot slot;
    slot.base = paths;
#if MCV_WITH_GLOSS
    mcv_device_gloss from;
    if (type != MCV_MATERIAL_DIFFUSE) from = mcv_plain_gloss(world, gloss);
#endif
    MCV_PARALLEL_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        mcv_vec3 direction;
        mcv_color factor;
        float density = 0.0f;
        uint media = mcv_path_media(slot), branches = 0u;
        int reflects, smooth = 0;
        (void)media;
        mcv_color before, throughput;
        MCV_LOAD_COLOR(slot, throughput, before);
        factor = mcv_grey(0.0f);
        if (type == MCV_MATERIAL_DIFFUSE) {
            direction = MCV_LOAD_3(slot, bounce);
            density = MCV_LOAD(slot, bounce, 3);
            reflects = mcv_dot(direction, MCV_LOAD_3(slot, face)) > 0.0f;
            MCV_LOAD_COLOR(slot, reflectance, factor);
        } else {
#if MCV_WITH_GLOSS
            const mcv_meeting meeting = mcv_meet_surface(world, slot);
            const mcv_gloss_meeting m = mcv_meet_plain_gloss(world, &meeting, &from, gloss, type, media);
            mcv_pair pair;
            pair.x = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER);
            pair.y = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER + 1);
            const float chosen = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE);
            mcv_scattering on;
            smooth = m.gloss.table == MCV_NONE;
#if MCV_WITH_SPLIT && MCV_WITH_SMOOTH
            if (parts) {
                mcv_scattering other;
                on = mcv_part_by_gloss(world, &meeting, &from, &m, pair, chosen, &other);
                other.chance = smooth ? 0.0f : other.chance;
                const mcv_parting parting = mcv_part(slot, on.rest, before, on, other);
                on = parting.on;
                branches = mcv_keep_parting(slot, parting);
            } else
#endif
                on = mcv_turn_by_gloss(world, &meeting, &from, &m, mcv_choose_gloss_of(&from, &m, pair, chosen));
            unmatched[i] = (uint)(!smooth & (m.near_media != media));
            density = on.density;
            reflects = density > 0.0f;
            factor = on.factor;
            direction = mcv_choose(smooth, MCV_LOAD_3(slot, direction), on.direction);
            media = smooth ? media : on.media;
#endif
        }
        throughput = mcv_tint(before, factor);
        const float brightest = mcv_brightest(throughput);
        const int plays = roulette & (brightest < MCV_ROULETTE_WEIGHT);
        const float lives = brightest / MCV_ROULETTE_WEIGHT;
        const float choice = roulette ? MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE + 1) : 0.0f;
        const float more = 1.0f / lives;
        MCV_EACH_CHANNEL(c) {
            throughput.c[c] = plays ? throughput.c[c] * more : throughput.c[c];
            throughput.c[c] = smooth ? before.c[c] : throughput.c[c];
        }
        MCV_STORE_COLOR(slot, throughput, throughput);
        MCV_STORE_3(slot, direction, direction);
#if MCV_WITH_SURFACES
        MCV_WORD(slot, left, 0) = smooth ? MCV_WORD(slot, left, 0) : mcv_leave_plain(world, slot, direction, exact);
#endif
#if MCV_WITH_DIELECTRIC
        MCV_WORD(slot, media, 0) = media;
#endif
#if MCV_WITH_NEXT_EVENT
        MCV_STORE(slot, density, 0, smooth ? MCV_LOAD(slot, density, 0) : density);
#if MCV_WITH_REACH
        MCV_WORD(slot, reach, 0) = MCV_WORD(slot, reach_here, 0);
        MCV_WORD(slot, reach, 1) = MCV_WORD(slot, reach_here, 1);
#endif
#endif
#if MCV_WITH_LIGHT_TRACING
        __global const mcv_device_material *material = world.materials + world.instances[MCV_WORD(slot, instance, 0)].material;
        const uint trail = MCV_WORD(slot, trail, 0);
        mcv_leave_trail_at(world, slot, MCV_LOAD_3(slot, point), 1, (int)material->wide, (int)material->sharp, 0);
        MCV_WORD(slot, trail, 0) = smooth ? trail : MCV_WORD(slot, trail, 0);
#endif
        const int on = reflects & (brightest > 0.0f) & !(plays & (choice >= lives));
        ways[i] = smooth ? MCV_IS_LEFT : branches | (on ? MCV_GOES_ON : 0u);
    }
}

/* All plain surfaces of a slice: whether their paths go on. */
static __attribute__((noinline)) void mcv_shade_plain_surfaces(mcv_world world, uint *paths, const uint *ends, uint gloss, uint depth,
                                                               uint *ways, uint *unmatched) {
    const uint first = ends[MCV_MET_DIFFUSE_EXACT], last = ends[MCV_MET_GLOSS_TRIANGLE];
    uint differs[MCV_SLOTS];
    mcv_shade_plain(world, paths, last, ends[MCV_MET_DIFFUSE_TRIANGLE], depth, 0, MCV_MATERIAL_DIFFUSE, 0, MCV_NONE, ways, differs);
#if MCV_WITH_SURFACES
    mcv_shade_plain(world, paths, ends[MCV_MET_SMOOTH_EXACT], first, depth, 1, MCV_MATERIAL_DIFFUSE, 0, MCV_NONE, ways, differs);
#endif
#if MCV_WITH_GLOSS
    const uint type = gloss == MCV_NONE ? MCV_NONE : world.materials[gloss].type;
    if (type == MCV_MATERIAL_CONDUCTOR)
        mcv_shade_plain(world, paths, first, last, depth, MCV_WITH_SURFACES, MCV_MATERIAL_CONDUCTOR, 0, gloss, ways, differs);
    if (type == MCV_MATERIAL_METALLIC_ROUGHNESS)
        mcv_shade_plain(world, paths, first, last, depth, MCV_WITH_SURFACES, MCV_MATERIAL_METALLIC_ROUGHNESS, 0, gloss, ways, differs);
#if MCV_WITH_DIELECTRIC
    if (type == MCV_MATERIAL_DIELECTRIC)
        mcv_shade_plain(world, paths, first, last, depth, MCV_WITH_SURFACES, MCV_MATERIAL_DIELECTRIC, MCV_WITH_SPLIT, gloss, ways, differs);
#endif
    for (uint i = first; i < last; ++i) *unmatched += differs[i];
#endif
    (void)gloss, (void)first, (void)unmatched;
}
#endif

#endif
