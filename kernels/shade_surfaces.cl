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
#if MCV_WITH_MIXED
#include "precise.h"
#endif

enum { MCV_GOES_ON = 1, MCV_BRANCHES_OFF = 2 };

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

MCV_FUNCTION void mcv_leave_trail(mcv_world world, mcv_slot slot, mcv_meeting meeting, mcv_scattering on) {
    const int passes = on.event == MCV_EVENT_PASS && mcv_is_plate(world, meeting);
    mcv_leave_trail_at(world, slot, meeting.surface.point, on.density > 0.0f, mcv_is_wide(world, meeting), mcv_is_sharp(world, meeting),
                       passes);
}
#endif

/*
 * The density of a ray's choice, as it is to be weighed against that of next-event estimation which takes emitters by power alone: it has
 * taken this one so much more often.
 */
MCV_FUNCTION float mcv_density_against(mcv_world world, mcv_slot slot, uint emitter, float density) {
#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
    const mcv_reach reach = {MCV_LOAD(slot, reach, 0), MCV_LOAD(slot, reach, 1)};
    if (density > 0.0f) density /= mcv_preference(world.emitters + emitter, MCV_LOAD_3(slot, origin), reach);
#else
    (void)world, (void)slot, (void)emitter;
#endif
    return density;
}

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

/* The path goes on from the surface. */
MCV_FUNCTION void mcv_send_on(mcv_world world, mcv_slot slot, mcv_meeting meeting, uint media, mcv_scattering on, mcv_color throughput) {
#if MCV_WITH_MIXED
    mcv_leave_precisely(world, slot, &meeting, media, &on);
#elif !MCV_LEAVES_TOGETHER
    MCV_STORE_3(slot, origin, mcv_onward_origin(meeting, on.direction));
#endif
    MCV_STORE_3(slot, direction, on.direction);
#if MCV_WITH_SURFACES
    MCV_WORD(slot, left, 0) = mcv_leave_meeting(world, meeting, on.direction);
#endif
    MCV_STORE_COLOR(slot, throughput, throughput);
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = on.media;
#endif
#if MCV_WITH_NEXT_EVENT
    MCV_STORE(slot, density, 0, on.density);
#endif
#if MCV_WITH_LIGHT_TRACING
    mcv_leave_trail(world, slot, meeting, on);
#endif
    (void)world, (void)meeting, (void)media;
}

#if MCV_WITH_SPLIT
MCV_LOOP_FUNCTION int mcv_may_part(mcv_slot slot) { return MCV_WORD(slot, branch, 0) + 1u < MCV_BRANCHES; }

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
/* Puts into `parted` how a branch goes on; whether there is one. */
MCV_LOOP_FUNCTION uint mcv_keep_parting(mcv_slot slot, mcv_parting parting) {
    MCV_WORD(slot, branch, 0) += (uint)parting.splits;
    MCV_STORE_3(slot, parted, parting.other.direction);
    MCV_WORD(slot, parted, 3) = parting.other.media;
    MCV_STORE(slot, parted, 4, parting.other.density);
    MCV_EACH_CHANNEL(c) MCV_STORE(slot, parted, 5 + c, parting.carried.c[c]);
    return parting.branches ? MCV_BRANCHES_OFF : 0u;
}
#endif

/* A path's branch begins in the slot beside, with random numbers of its own, as a copy of what the path is before it goes on. */
MCV_LOOP_FUNCTION void mcv_name_branch(mcv_slot slot, mcv_slot beside) {
    const uint number = MCV_WORD(slot, branch, 0);
    MCV_WORD(beside, branch, 0) = MCV_BRANCHES + number;
    MCV_WORD(beside, stream, 0) = mcv_hash_2(MCV_WORD(slot, stream, 0), number);
    MCV_EACH_CHANNEL(i) MCV_STORE(beside, radiance, i, 0.0f);
}

static void mcv_branch_off(mcv_world world, mcv_slot slot, mcv_slot beside, mcv_meeting meeting, uint media, mcv_parting parting) {
    for (uint word = 0; word < MCV_PATH_hit; ++word) {
        const uint row = word * MCV_CAPACITY(slot);
        beside.base[row + beside.index] = slot.base[row + slot.index];
    }
#if MCV_WITH_MIXED
    MCV_WORD(beside, hit, 0) = MCV_WORD(slot, hit, 0);
#endif
    mcv_name_branch(slot, beside);
    mcv_send_on(world, beside, meeting, media, parting.other, parting.carried);
#if MCV_LEAVES_TOGETHER
    const mcv_vec3 origin = mcv_onward_origin(meeting, parting.other.direction);
    MCV_STORE_3(beside, origin, origin);
#endif
}
#endif

/* MCV_GOES_ON: the path, which has met a surface, does; MCV_BRANCHES_OFF: so does a branch, in the slot beside. */
static uint mcv_shade_surface(mcv_world world, mcv_slot slot, mcv_slot beside, uint depth, uint *unmatched) {
    uint ways = 0;
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    const uint media = mcv_path_media(slot);
    mcv_color throughput;
    mcv_color radiance;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    MCV_LOAD_COLOR(slot, radiance, radiance);

    const mcv_meeting meeting = mcv_meet_surface(world, slot);
    const uint emitter = world.instances[meeting.surface.instance].emitter;
    if (emitter != MCV_NONE) {
        float own = mcv_density_against(world, slot, emitter, mcv_path_density(slot));
#if MCV_WITH_LIGHT_TRACING
        /* Sharp surfaces have not looked for it (mcv_choose_emitter). */
        if (MCV_WORD(slot, trail, 0) == MCV_TRAIL_CARRIED && world.emitters[emitter].light_flux > 0.0f) own = 0.0f;
#endif
        mcv_color met = mcv_emission_met(world, meeting, emitter, media, own, MCV_LOAD(slot, hit, 0));
#if MCV_WITH_LIGHT_TRACING
        met = mcv_dim(met, mcv_camera_share(world, slot, meeting, emitter));
#endif
        MCV_EACH_CHANNEL(i) radiance.c[i] = mcv_fma(throughput.c[i], met.c[i], radiance.c[i]);
        MCV_STORE_COLOR(slot, radiance, radiance);
    }

#if MCV_WITH_REACH && MCV_WITH_NEXT_EVENT
    /* After what this surface emits, which those of the surface before are for, and before a branch takes them over. */
    for (uint i = 0; i < 2; ++i) MCV_WORD(slot, reach, i) = MCV_WORD(slot, reach_here, i);
#endif

    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_SCATTER);
    float chosen = 0.0f;
#if MCV_WITH_GLOSS || MCV_WITH_RETROREFLECTOR || MCV_WITH_TRANSLUCENT
    /* The other number of this pair plays roulette; this one has chosen an emitter, which is another estimate. */
    chosen = mcv_draw(slot, depth, MCV_PAIR_CHOICE).x;
#endif
    int parts = 0;
#if MCV_WITH_SPLIT
    parts = mcv_may_part(slot);
#endif
    mcv_scattering other;
    mcv_scattering on = mcv_scatter(world, meeting, media, pair, chosen, parts, unmatched, &other);
#if MCV_WITH_SPLIT
    if (other.chance > 0.0f) {
        const mcv_parting parting = mcv_part(slot, on.event == MCV_EVENT_END ? on.rest : pair.x, throughput, on, other);
        on = parting.on;
        MCV_WORD(slot, branch, 0) += (uint)parting.splits;
        if (parting.branches) {
            mcv_branch_off(world, slot, beside, meeting, media, parting);
            ways = MCV_BRANCHES_OFF;
        }
    }
#else
    (void)beside;
#endif
    throughput = mcv_tint(throughput, on.factor);
    const float brightest = mcv_brightest(throughput);
    if (!(brightest > 0.0f)) return ways;

    /* Russian roulette, on the throughput alone. */
    if (depth >= MCV_ROULETTE_DEPTH && brightest < MCV_ROULETTE_WEIGHT) {
        const float lives = brightest / MCV_ROULETTE_WEIGHT;
        const mcv_pair choice = mcv_draw(slot, depth, MCV_PAIR_CHOICE);
        if (choice.y >= lives) return ways;
        throughput = mcv_dim(throughput, 1.0f / lives);
    }

    mcv_send_on(world, slot, meeting, media, on, throughput);
    return ways | MCV_GOES_ON;
}

/* What the path would still have carried, in units of 2^-11: a million paths fit the counter. */
static uint mcv_lost_energy(mcv_slot slot) {
    mcv_color throughput;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    return (uint)(mcv_brightest(throughput) * 2048.0f + 0.5f);
}
