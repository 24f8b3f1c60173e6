/* SPDX-License-Identifier: Apache-2.0 */
/* What the tile schedule does with paths on smooth bodies, many at once: what mcv_shade_surface does for one, to the last bit. */
#ifndef MCVISI_KERNELS_SMOOTH_SURFACES_H
#define MCVISI_KERNELS_SMOOTH_SURFACES_H

#if MCV_WITH_SMOOTH
/* How the paths go on, and into `parted` how their branches do. */
MCV_LOOP_FUNCTION void mcv_shade_smooth(mcv_world world, uint *paths, uint first, uint last, uint depth, int exact, uint *ways,
                                        uint *unmatched) {
    const int roulette = depth >= MCV_ROULETTE_DEPTH;
    mcv_slot slot;
    slot.base = paths;
    MCV_PARALLEL_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_meeting meeting = mcv_meet_surface(world, slot);
        const float xi = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER);
        uint differs = 0u, branches = 0u;
        mcv_color throughput;
        mcv_scattering other;
        mcv_scattering on = mcv_scatter_dielectric(world, meeting, MCV_WORD(slot, media, 0), xi, &differs, &other);
        unmatched[i] = differs;
        MCV_LOAD_COLOR(slot, throughput, throughput);
#if MCV_WITH_SPLIT
        const mcv_parting parting = mcv_part(slot, xi, throughput, on, other);
        branches = mcv_keep_parting(slot, parting);
        on = parting.on;
#endif
        throughput = mcv_tint(throughput, on.factor);
        const float brightest = mcv_brightest(throughput);
        const int plays = roulette & (brightest < MCV_ROULETTE_WEIGHT);
        const float lives = brightest / MCV_ROULETTE_WEIGHT;
        const float choice = roulette ? MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE + 1) : 0.0f;
        const float more = 1.0f / lives;
        MCV_EACH_CHANNEL(c) MCV_STORE(slot, throughput, c, plays ? throughput.c[c] * more : throughput.c[c]);
        MCV_STORE_3(slot, direction, on.direction);
#if MCV_WITH_SURFACES
        MCV_WORD(slot, left, 0) = mcv_leave_plain(world, slot, on.direction, exact);
#endif
        MCV_WORD(slot, media, 0) = on.media;
#if MCV_WITH_NEXT_EVENT
        MCV_STORE(slot, density, 0, 0.0f);
#endif
#if MCV_WITH_LIGHT_TRACING
        mcv_leave_trail_at(world, slot, MCV_LOAD_3(slot, point), 0, 0, 0, 0);
#endif
        const int lives_on = (brightest > 0.0f) & !(plays & (choice >= lives));
        ways[i] = branches | (lives_on ? MCV_GOES_ON : 0u);
    }
    (void)exact;
}

#if MCV_WITH_SPLIT
/* The branches of the first `last` paths, which have gone on, in the slots from the given one: the same but for where they go. Returns
 * where they end. */
static __attribute__((noinline)) uint mcv_branch_off_together(mcv_world world, uint *paths, const uint *ways, uint last, uint begin) {
    uint branches[MCV_SLOTS], count = 0;
    mcv_slot slot;
    slot.base = paths;
    (void)world;
    MCV_PARALLEL
    for (uint i = 0; i < last; ++i) {
        branches[i] = (ways[i] & MCV_BRANCHES_OFF) != 0u;
        count += branches[i];
    }
    if (count == 0) return begin;
    const uint rows[3][2] = {
        {MCV_PATH_stream, MCV_PATH_sample + 1}, {MCV_PATH_weight, MCV_PATH_hit + 4}, {MCV_PATH_point, MCV_PATH_AFTER_parted + 1}};
    for (uint i = 0; i < 3; ++i) {
        uint *from = paths + rows[i][0] * MCV_ROW;
        mcv_pack_rows(branches, from, rows[i][1] - rows[i][0], MCV_ROW, last, from + begin);
    }
    MCV_PARALLEL
    for (uint i = begin; i < begin + count; ++i) {
        slot.index = i;
        const mcv_vec3 direction = MCV_LOAD_3(slot, parted);
        mcv_name_branch(slot, slot);
        MCV_STORE_3(slot, direction, direction);
        const mcv_vec3 origin = mcv_offset_origin(MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, error), MCV_LOAD_3(slot, face), direction);
        MCV_STORE_3(slot, origin, origin);
        MCV_WORD(slot, media, 0) = MCV_WORD(slot, parted, 3);
        MCV_EACH_CHANNEL(c) MCV_WORD(slot, throughput, c) = MCV_WORD(slot, parted, 5 + c);
#if MCV_WITH_NEXT_EVENT
        MCV_WORD(slot, density, 0) = MCV_WORD(slot, parted, 4);
#endif
#if MCV_WITH_SURFACES
        MCV_WORD(slot, left, 0) = mcv_leave_plain(world, slot, direction, 1);
#endif
    }
    return begin + count;
}
#endif

/* All smooth surfaces of a slice: how their paths go on. */
static __attribute__((noinline)) void mcv_shade_smooth_surfaces(mcv_world world, uint *paths, const uint *ends, uint depth, uint *ways,
                                                                uint *unmatched) {
    uint differs[MCV_SLOTS];
    mcv_shade_smooth(world, paths, 0, ends[MCV_MET_SMOOTH_TRIANGLE], depth, 0, ways, differs);
#if MCV_WITH_SURFACES
    mcv_shade_smooth(world, paths, ends[MCV_MET_SMOOTH_TRIANGLE], ends[MCV_MET_SMOOTH_EXACT], depth, 1, ways, differs);
#endif
    for (uint i = 0; i < ends[MCV_MET_SMOOTH_EXACT]; ++i) *unmatched += differs[i];
}
#endif

#endif
