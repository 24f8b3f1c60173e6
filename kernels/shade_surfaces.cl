/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: what a surface does to a path. Adds what it emits, then chooses how the path goes on. Each path is continued or ended
 * exactly once. reads ray, hit -> writes radiance, and ray, throughput, media, density | ends
 */
#include "environment.h"
#include "identity.h"
#if MCV_WITH_LIGHT_TRACING
#include "light.h"
#endif
#include "meet_surface.h"
#include "reach.h"
#include "roulette.h"
#include "shading.h"
#if MCV_WITH_MIXED
#include "precise.h"
#endif

/*
 * How much oftener than by its chance the less likely way on is followed. Nothing much comes by it where all light is narrow; wide light
 * may come from anywhere.
 */
#define MCV_SPLIT_EFFORT (MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE || MCV_WITH_AREA || MCV_WITH_LIGHT_FIELD ? 8.0f : 1.0f)

#if MCV_WITH_LIGHT_TRACING
/* What light paths leave of what the emitter sends along this path. */
MCV_FUNCTION float mcv_camera_share(mcv_world world, mcv_slot slot, mcv_meeting meeting, uint emitter) {
#if MCV_WITH_EMISSION
    if (MCV_WORD(slot, trail, 0) != MCV_TRAIL_CARRIED || !(world.emitters[emitter].light_flux > 0.0f)) return 1.0f;
    const float etendue = mcv_light_etendue(world, meeting.surface, emitter, mcv_scale(meeting.direction, -1.0f));
    if (etendue > 0.0f) return 1.0f - mcv_light_share(world, etendue, MCV_LOAD(slot, footprint, 0));
#else
    (void)world, (void)slot, (void)meeting, (void)emitter;
#endif
    return 1.0f;
}

/* The path goes on from a point of a surface that spreads light, widely, sharply or neither, or just lets it pass. */
MCV_LOOP_FUNCTION void mcv_leave_trail_at(mcv_world world, mcv_slot slot, mcv_vec3 point, int spreads, int wide, int sharp, int passes) {
    const uint before = MCV_WORD(slot, trail, 0);
    const int straight = before == MCV_TRAIL_STRAIGHT, carries = (before == MCV_TRAIL_DIFFUSE) | (before == MCV_TRAIL_CARRIED);
    const float footprint = mcv_sensor_footprint(world.sensor, mcv_point_to_optical(world.frame, point).z);
    const uint spread = wide ? MCV_TRAIL_DIFFUSE : straight ? MCV_TRAIL_OTHER : MCV_TRAIL_GLOSSY;
    const uint smooth = carries ? MCV_TRAIL_CARRIED : (straight & !passes) ? MCV_TRAIL_OTHER : before;
    MCV_STORE(slot, footprint, 0, straight ? footprint : MCV_LOAD(slot, footprint, 0));
    MCV_WORD(slot, trail, 0) = before == MCV_TRAIL_OTHER ? before : (spreads & !(carries & sharp)) ? spread : smooth;
}

MCV_LOOP_FUNCTION void mcv_leave_trail(mcv_world world, mcv_slot slot, const mcv_meeting *meeting, mcv_shading shading, mcv_scattering on) {
    const int passes = shading.kind == MCV_SHADING_ANY && on.event == MCV_EVENT_PASS && mcv_is_plate(world, *meeting);
    mcv_leave_trail_at(world, slot, meeting->surface.point, on.density > 0.0f, mcv_is_wide(world, *meeting), mcv_is_sharp(world, *meeting),
                       passes);
}
#endif

/*
 * The density of a ray's choice, as it is to be weighed against that of next-event estimation which takes emitters by power alone: it has
 * taken this one so much more often.
 */
MCV_LOOP_FUNCTION float mcv_density_against(mcv_world world, mcv_slot slot, uint emitter, float density) {
#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
    const mcv_reach reach = {MCV_LOAD(slot, reach, 0), MCV_LOAD(slot, reach, 1)};
    const float against = density / mcv_preference(world.emitters + emitter, MCV_LOAD_3(slot, origin), reach);
    density = density > 0.0f ? against : density;
#else
    (void)world, (void)slot, (void)emitter;
#endif
    return density;
}

#if MCV_WITH_EMISSION
/* What a path has met of an emitter's surface. */
typedef struct mcv_emitter_hit {
    mcv_color radiance; /* that the surface sends along the path */
    uint emitter;
    float other; /* the density with which next-event estimation would have chosen this direction [1/sr] */
    float share; /* what light paths leave of it */
} mcv_emitter_hit;

/* Adds what the path has met, weighed against next-event estimation by the power heuristic. */
MCV_LOOP_FUNCTION void mcv_add_emission(mcv_world world, mcv_slot slot, const mcv_emitter_hit *met) {
    mcv_color throughput, radiance;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    MCV_LOAD_COLOR(slot, radiance, radiance);
    mcv_color emitted = mcv_basic_radiance(world, met->radiance, mcv_path_media(slot));
#if MCV_WITH_NEXT_EVENT
    float own = mcv_density_against(world, slot, met->emitter, mcv_path_density(slot));
#if MCV_WITH_LIGHT_TRACING
    /* Sharp surfaces have not looked for it (mcv_choose_emitter). */
    const int carried = (MCV_WORD(slot, trail, 0) == MCV_TRAIL_CARRIED) & (world.emitters[met->emitter].light_flux > 0.0f);
    own = carried ? 0.0f : own;
#endif
    const float weight = mcv_choice_weight(own, met->other);
    const int chosen = own > 0.0f, shines = mcv_brightest(emitted) > 0.0f;
    emitted = mcv_dim(emitted, (chosen & shines) ? weight : 1.0f);
#endif
    emitted = mcv_dim(emitted, met->share);
    MCV_EACH_CHANNEL(i) radiance.c[i] = mcv_fma(throughput.c[i], emitted.c[i], radiance.c[i]);
    MCV_STORE_COLOR(slot, radiance, radiance);
}
#endif

#if MCV_WITH_MIXED
/* Where the path goes on, and with it how: *on gets the direction. */
static void mcv_leave_precisely(mcv_world world, mcv_slot slot, const mcv_meeting *meeting, uint media, mcv_scattering *on) {
    const mcv_vec3 rest = MCV_LOAD_3(slot, origin_rest);
    const mcv_precise_ray ray =
        mcv_precise_ray_of(MCV_LOAD_3(slot, origin), rest, MCV_LOAD_3(slot, direction), MCV_LOAD_3(slot, direction_rest));
    mcv_precise_meeting met;
    met.found = 0;
    if (on->event != MCV_EVENT_END) met = mcv_meet_precisely(world, meeting, ray, rest, MCV_LOAD(slot, hit, 0));
    const mcv_onward onward = mcv_go_on_precisely(world, meeting, &met, ray.direction, media, on);
    const mcv_vec3 origin = mcv_onward_origin(*meeting, on->direction);
    MCV_STORE_3(slot, origin, origin);
    MCV_STORE_3(slot, origin_rest, mcv_onward_rest(&onward, onward.ray.origin, origin));
    MCV_STORE_3(slot, direction_rest, mcv_onward_rest(&onward, onward.ray.direction, on->direction));
}
#endif

/* A ray that leaves the scene sees the environment. */
MCV_LOOP_FUNCTION void mcv_leave_scene(mcv_world world, mcv_slot slot) {
#if MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE
    float density = mcv_path_density(slot);
    mcv_color throughput;
    mcv_color radiance;
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    MCV_LOAD_COLOR(slot, throughput, throughput);
    MCV_LOAD_COLOR(slot, radiance, radiance);
#if MCV_WITH_ENVIRONMENT_IMAGE
    density = mcv_density_against(world, slot, world.frame->environment_emitter, density);
#endif
    const mcv_color met = mcv_environment_met(world, MCV_LOAD_3(slot, direction), mcv_path_media(slot), density);
    MCV_EACH_CHANNEL(i) radiance.c[i] = mcv_fma(throughput.c[i], met.c[i], radiance.c[i]);
    MCV_STORE_COLOR(slot, radiance, radiance);
#else
    (void)world, (void)slot;
#endif
}

/*
 * The path continues from the surface. skipped: 1 leaves it as it is; known to the compiler where that cannot be. Where origins are worked
 * out for many paths at once, after all else, the old one stays.
 */
MCV_LOOP_FUNCTION void mcv_continue_path(mcv_world world, mcv_slot slot, const mcv_meeting *meeting, mcv_shading shading, mcv_scattering on,
                                         mcv_color throughput, int skipped) {
#if MCV_WITH_MIXED
    mcv_leave_precisely(world, slot, meeting, mcv_path_media(slot), &on);
#elif !MCV_LEAVES_TOGETHER
    MCV_STORE_3(slot, origin, mcv_onward_origin(*meeting, on.direction));
#endif
    const mcv_vec3 direction = mcv_choose(skipped, meeting->direction, on.direction);
    MCV_STORE_3(slot, direction, direction);
    /* Values are chosen among, not places in memory: of these a loop over paths would not be vectorised. */
#if MCV_WITH_SURFACES
    const uint left = shading.exact ? mcv_leave_meeting(world, *meeting, on.direction) : MCV_NONE;
    const uint left_before = MCV_WORD(slot, left, 0);
    MCV_WORD(slot, left, 0) = skipped ? left_before : left;
#endif
    MCV_EACH_CHANNEL(i) {
        const float before = MCV_LOAD(slot, throughput, i);
        const float carried = throughput.c[i];
        MCV_STORE(slot, throughput, i, skipped ? before : carried);
    }
#if MCV_WITH_DIELECTRIC
    const uint media_before = MCV_WORD(slot, media, 0);
    const uint media = on.media;
    MCV_WORD(slot, media, 0) = skipped ? media_before : media;
#endif
#if MCV_WITH_NEXT_EVENT
    const float density_before = MCV_LOAD(slot, density, 0);
    const float density = on.density;
    MCV_STORE(slot, density, 0, skipped ? density_before : density);
#endif
#if MCV_WITH_LIGHT_TRACING
    const uint trail = MCV_WORD(slot, trail, 0);
    mcv_leave_trail(world, slot, meeting, shading, on);
    MCV_WORD(slot, trail, 0) = skipped ? trail : MCV_WORD(slot, trail, 0);
#endif
    (void)world, (void)shading;
}

#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
/* After what this surface emits, which the chances of the surface before are for, and before a branch takes them over. */
MCV_LOOP_FUNCTION void mcv_keep_reach(mcv_slot slot) {
    MCV_WORD(slot, reach, 0) = MCV_WORD(slot, reach_here, 0);
    MCV_WORD(slot, reach, 1) = MCV_WORD(slot, reach_here, 1);
}
#endif

MCV_LOOP_FUNCTION int mcv_may_part(mcv_slot slot) {
#if MCV_WITH_SPLIT
    return MCV_WORD(slot, branch, 0) + 1u < MCV_BRANCHES;
#else
    (void)slot;
    return 0;
#endif
}

#if MCV_WITH_SPLIT
/* How a path splits. */
typedef struct mcv_parting {
    mcv_scattering on, other; /* the path's and the branch's way, */
    mcv_color carried;        /* what that carries, */
    int splits, branches;     /* and whether there are both */
} mcv_parting;

/*
 * The path takes the likelier one of two ways on instead of that which chance has chosen, and a branch the other one, each weighed by its
 * own chance: R + T. The branch has to survive roulette. Where an environment shines from all sides both ways bring about the same: the
 * path then stands in for what roulette ends, so that both carry as much as before. xi: the number that has chosen, or what is left of it,
 * which has no other use any more.
 */
MCV_LOOP_FUNCTION mcv_parting mcv_part(mcv_slot slot, float xi, mcv_color throughput, mcv_scattering on, mcv_scattering other) {
    mcv_parting parting;
    const int swaps = (other.chance > on.chance) | ((other.chance == on.chance) & (other.event == MCV_EVENT_REFLECT));
    const mcv_scattering likelier = mcv_choose_scattering(swaps, other, on);
    parting.other = mcv_choose_scattering(swaps, on, other);
    const float effort = MCV_SPLIT_EFFORT * mcv_average(throughput);
    const float wanted = parting.other.chance * (effort > 1.0f ? effort : 1.0f);
    const float lives = wanted < 1.0f ? wanted : 1.0f;
    float weight = likelier.chance;
    parting.splits = (other.chance > 0.0f) & mcv_may_part(slot);
#if MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE
    /* What roulette would soon play for is left to chance: light from all sides keeps being found without noise. */
    const float branches = parting.other.chance / lives, goes_on = lives < 1.0f ? 1.0f - branches : likelier.chance;
    const float least = mcv_brightest(throughput) * (goes_on < branches ? goes_on : branches);
    parting.splits &= !(least < MCV_ROULETTE_WEIGHT * (1.0f - 8.0f * MCV_UNIT_ROUNDOFF));
    weight = lives < 1.0f ? xi < lives ? goes_on : 1.0f : weight;
#endif
    parting.on = mcv_choose_scattering(parting.splits, likelier, on);
    parting.on.factor = mcv_dim(parting.on.factor, parting.splits ? weight : 1.0f);
    parting.carried = mcv_dim(mcv_tint(throughput, parting.other.factor), parting.other.chance / lives);
    parting.branches = parting.splits & (xi < lives) & (mcv_brightest(parting.carried) > 0.0f);
    return parting;
}

#if MCV_TILE
/* Puts into `parted` how a branch continues. */
MCV_LOOP_FUNCTION void mcv_keep_parting(mcv_slot slot, mcv_parting parting) {
    MCV_STORE_3(slot, parted, parting.other.direction);
    MCV_WORD(slot, parted, 3) = parting.other.media;
    MCV_STORE(slot, parted, 4, parting.other.density);
    MCV_EACH_CHANNEL(c) MCV_STORE(slot, parted, 5 + c, parting.carried.c[c]);
}
#endif

/* A path's branch begins in the slot beside, with random numbers of its own, as a copy of what the path is before it goes on. */
MCV_LOOP_FUNCTION void mcv_name_branch(mcv_slot slot, mcv_slot beside) {
    const uint number = MCV_WORD(slot, branch, 0);
    MCV_WORD(beside, branch, 0) = MCV_BRANCHES + number;
    MCV_WORD(beside, stream, 0) = mcv_hash_2(MCV_WORD(slot, stream, 0), number);
    MCV_EACH_CHANNEL(i) MCV_STORE(beside, radiance, i, 0.0f);
}

static void mcv_branch_off(mcv_world world, mcv_slot slot, mcv_slot beside, const mcv_meeting *meeting, mcv_parting parting) {
    for (uint word = 0; word < MCV_PATH_hit; ++word) {
        const uint row = word * MCV_CAPACITY(slot);
        beside.base[row + beside.index] = slot.base[row + slot.index];
    }
#if MCV_WITH_MIXED
    MCV_WORD(beside, hit, 0) = MCV_WORD(slot, hit, 0);
#endif
    mcv_name_branch(slot, beside);
    mcv_continue_path(world, beside, meeting, mcv_any_shading(), parting.other, parting.carried, 0);
#if MCV_LEAVES_TOGETHER
    const mcv_vec3 origin = mcv_onward_origin(*meeting, parting.other.direction);
    MCV_STORE_3(beside, origin, origin);
#endif
}
#endif

/* How a path continues from a surface, and whether it does. */
typedef struct mcv_shaded {
    mcv_scattering on;
    mcv_color throughput;
#if MCV_WITH_SPLIT
    mcv_parting parting; /* where it splits */
#endif
    uint ways; /* MCV_GOES_ON | MCV_BRANCHES_OFF, or MCV_IS_LEFT: the class does not hold this surface, mcv_shade_surface does */
} mcv_shaded;

/* Chooses how a path continues from the surface that it has met: scattering, splitting, Russian roulette. */
MCV_LOOP_FUNCTION mcv_shaded mcv_shade_hit(mcv_world world, mcv_slot slot, const mcv_meeting *meeting, mcv_shading shading, uint depth,
                                           uint *unmatched) {
    mcv_shaded shaded;
    mcv_scattering other;
    int left = 0;
    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_SCATTER), choice = mcv_draw_choice(slot, depth);
    MCV_LOAD_COLOR(slot, throughput, shaded.throughput);
    shaded.ways = 0u;
    shaded.on = mcv_scatter_as(world, slot, meeting, shading, pair, choice.x, mcv_may_part(slot), unmatched, &other, &left);
#if MCV_WITH_SPLIT
    shaded.parting.branches = 0;
    if (shading.kind == MCV_SHADING_ANY ? other.chance > 0.0f : shading.splits) {
        shaded.parting = mcv_part(slot, shaded.on.event == MCV_EVENT_END ? shaded.on.rest : pair.x, shaded.throughput, shaded.on, other);
        shaded.on = shaded.parting.on;
        MCV_WORD(slot, branch, 0) += (uint)shaded.parting.splits;
        shaded.ways = shaded.parting.branches ? MCV_BRANCHES_OFF : 0u;
    }
#endif
    shaded.throughput = mcv_tint(shaded.throughput, shaded.on.factor);
    const mcv_roulette roulette =
        mcv_play_roulette(depth >= MCV_ROULETTE_DEPTH, mcv_brightest(shaded.throughput), MCV_ROULETTE_WEIGHT, choice.y);
    shaded.throughput = mcv_after_roulette(roulette, shaded.throughput);
    shaded.ways |= roulette.survives ? MCV_GOES_ON : 0u;
    shaded.ways = left ? MCV_IS_LEFT : shaded.ways;
    return shaded;
}

#if MCV_WITH_EMISSION
/* Adds what a surface emits that the path has met. */
static void mcv_meet_emitter(mcv_world world, mcv_slot slot, mcv_meeting meeting) {
    const uint emitter = world.instances[meeting.surface.instance].emitter;
    if (emitter == MCV_NONE) return;
    mcv_emitter_hit met;
    met.radiance = mcv_emitted(world, meeting.surface, emitter, mcv_scale(meeting.direction, -1.0f));
    met.emitter = emitter;
    met.other = 0.0f;
    met.share = 1.0f;
#if MCV_WITH_NEXT_EVENT
    const float distance = MCV_LOAD(slot, hit, 0);
    const mcv_vec3 receiver = mcv_along(meeting.surface.point, -distance, meeting.direction);
    met.other = mcv_emitter_density(world, receiver, meeting.surface, emitter, meeting.direction, distance);
#endif
#if MCV_WITH_LIGHT_TRACING
    met.share = mcv_camera_share(world, slot, meeting, emitter);
#endif
    mcv_add_emission(world, slot, &met);
}
#endif

/* MCV_GOES_ON: the path, which has met a surface, does; MCV_BRANCHES_OFF: so does a branch, in the slot beside. */
static uint mcv_shade_surface(mcv_world world, mcv_slot slot, mcv_slot beside, uint depth, uint *unmatched) {
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    const mcv_meeting meeting = mcv_meet_surface(world, slot);
#if MCV_WITH_EMISSION
    mcv_meet_emitter(world, slot, meeting);
#endif
#if MCV_WITH_REACH && MCV_WITH_NEXT_EVENT
    mcv_keep_reach(slot);
#endif
    const mcv_shaded shaded = mcv_shade_hit(world, slot, &meeting, mcv_any_shading(), depth, unmatched);
#if MCV_WITH_SPLIT
    if (shaded.ways & MCV_BRANCHES_OFF) mcv_branch_off(world, slot, beside, &meeting, shaded.parting);
#else
    (void)beside;
#endif
    if (shaded.ways & MCV_GOES_ON) mcv_continue_path(world, slot, &meeting, mcv_any_shading(), shaded.on, shaded.throughput, 0);
    return shaded.ways;
}

/* What the path would still have carried, in units of 2^-11: a million paths fit the counter. */
static uint mcv_lost_energy(mcv_slot slot) {
    mcv_color throughput;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    return (uint)(mcv_brightest(throughput) * 2048.0f + 0.5f);
}
