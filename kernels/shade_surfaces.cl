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
    if (MCV_WORD(slot, trail, 0) != MCV_TRAIL_SMOOTH_SINCE || !(world.emitters[emitter].light_flux > 0.0f)) return 1.0f;
    const float etendue = mcv_light_etendue(world, meeting.surface, emitter, mcv_scale(meeting.direction, -1.0f));
    if (etendue > 0.0f) return 1.0f - mcv_light_share(world, etendue, MCV_LOAD(slot, footprint, 0));
#else
    (void)world, (void)slot, (void)meeting, (void)emitter;
#endif
    return 1.0f;
}

MCV_FUNCTION void mcv_leave_trail(mcv_world world, mcv_slot slot, mcv_meeting meeting, mcv_scattering on) {
    const uint before = MCV_WORD(slot, trail, 0);
    uint after = before;
    if (before == MCV_TRAIL_OTHER) return;
    if (before == MCV_TRAIL_STRAIGHT)
        MCV_STORE(slot, footprint, 0, mcv_sensor_footprint(world.sensor, mcv_point_to_optical(world.frame, meeting.surface.point).z));
    if (on.density > 0.0f)
        after = mcv_is_wide(world, meeting) ? MCV_TRAIL_DIFFUSE : before == MCV_TRAIL_STRAIGHT ? MCV_TRAIL_OTHER : MCV_TRAIL_GLOSSY;
    else if (before == MCV_TRAIL_DIFFUSE)
        after = MCV_TRAIL_SMOOTH_SINCE;
    else if (before == MCV_TRAIL_STRAIGHT && (on.event != MCV_EVENT_PASS || !mcv_is_plate(world, meeting)))
        after = MCV_TRAIL_OTHER;
    MCV_WORD(slot, trail, 0) = after;
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
    uint media = 0;
    float density = 0.0f;
    mcv_color throughput;
    mcv_color radiance;
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    MCV_LOAD_COLOR(slot, throughput, throughput);
    MCV_LOAD_COLOR(slot, radiance, radiance);
#if MCV_WITH_DIELECTRIC
    media = MCV_WORD(slot, media, 0);
#endif
#if MCV_WITH_NEXT_EVENT
    density = MCV_LOAD(slot, density, 0);
#endif
#if MCV_WITH_ENVIRONMENT_IMAGE
    density = mcv_density_against(world, slot, world.frame->environment_emitter, density);
#endif
    const mcv_color met = mcv_environment_met(world, MCV_LOAD_3(slot, direction), media, density);
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
/*
 * The path takes the likelier one of two ways on instead of that which chance has chosen, and a branch the other one, each weighed by its
 * own chance: R + T. The branch has to survive roulette. Where an environment shines from all sides both ways bring about the same: the
 * path then stands in for what roulette ends, so that both carry as much as before. xi: the number that has chosen, which has no other use
 * any more. A branch has random numbers of its own. 1: there is one, in the slot beside.
 */
static int mcv_split_path(mcv_world world, mcv_slot slot, mcv_slot beside, mcv_meeting meeting, uint media, float xi, mcv_color throughput,
                          mcv_scattering *on, mcv_scattering other) {
    const uint number = MCV_WORD(slot, branch, 0) + 1u;
    mcv_scattering likelier = *on;
    if (other.chance > on->chance || (other.chance == on->chance && other.event == MCV_EVENT_REFLECT)) {
        likelier = other;
        other = *on;
    }
    const float effort = MCV_SPLIT_EFFORT * mcv_average(throughput);
    const float wanted = other.chance * (effort > 1.0f ? effort : 1.0f);
    const float lives = wanted < 1.0f ? wanted : 1.0f;
    float weight = likelier.chance;
#if MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE
    /* What roulette would soon play for is left to chance: light from all sides keeps being found without noise. */
    const float branches = other.chance / lives, goes_on = lives < 1.0f ? 1.0f - branches : likelier.chance;
    const float least = mcv_brightest(throughput) * (goes_on < branches ? goes_on : branches);
    if (least < MCV_ROULETTE_WEIGHT * (1.0f - 8.0f * MCV_UNIT_ROUNDOFF)) return 0;
    if (lives < 1.0f) weight = xi < lives ? goes_on : 1.0f;
#endif
    *on = likelier;
    on->factor = mcv_dim(on->factor, weight);
    MCV_WORD(slot, branch, 0) = number;
    throughput = mcv_dim(mcv_tint(throughput, other.factor), other.chance / lives);
    if (!(xi < lives) || !(mcv_brightest(throughput) > 0.0f)) return 0;

    for (uint word = 0; word < MCV_PATH_hit; ++word) {
        const uint row = word * MCV_CAPACITY(slot);
        beside.base[row + beside.index] = slot.base[row + slot.index];
    }
#if MCV_WITH_MIXED
    MCV_WORD(beside, hit, 0) = MCV_WORD(slot, hit, 0);
#endif
    MCV_WORD(beside, branch, 0) = MCV_BRANCHES + number;
    MCV_WORD(beside, stream, 0) = mcv_hash_2(MCV_WORD(slot, stream, 0), number);
    MCV_EACH_CHANNEL(i) MCV_STORE(beside, radiance, i, 0.0f);
    mcv_send_on(world, beside, meeting, media, other, throughput);
#if MCV_LEAVES_TOGETHER
    const mcv_vec3 origin = mcv_onward_origin(meeting, other.direction);
    MCV_STORE_3(beside, origin, origin);
#endif
    return 1;
}
#endif

/* MCV_GOES_ON: the path, which has met a surface, does; MCV_BRANCHES_OFF: so does a branch, in the slot beside. */
static uint mcv_shade_surface(mcv_world world, mcv_slot slot, mcv_slot beside, uint depth, uint *unmatched) {
    uint ways = 0;
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    mcv_color throughput;
    mcv_color radiance;
    uint media = 0;
    float density = 0.0f;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    MCV_LOAD_COLOR(slot, radiance, radiance);
#if MCV_WITH_DIELECTRIC
    media = MCV_WORD(slot, media, 0);
#endif
#if MCV_WITH_NEXT_EVENT
    density = MCV_LOAD(slot, density, 0);
#endif

    const mcv_meeting meeting = mcv_meet_surface(world, slot);
    const uint emitter = world.instances[meeting.surface.instance].emitter;
    if (emitter != MCV_NONE) {
        const float own = mcv_density_against(world, slot, emitter, density);
        mcv_color met = mcv_emission_met(world, meeting, emitter, media, own, MCV_LOAD(slot, hit, 0));
#if MCV_WITH_LIGHT_TRACING
        met = mcv_dim(met, mcv_camera_share(world, slot, meeting, emitter));
#endif
        MCV_EACH_CHANNEL(i) radiance.c[i] = mcv_fma(throughput.c[i], met.c[i], radiance.c[i]);
        MCV_STORE_COLOR(slot, radiance, radiance);
    }

    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_SCATTER);
    float chosen = 0.0f;
#if MCV_WITH_GLOSS || MCV_WITH_RETROREFLECTOR || MCV_WITH_TRANSLUCENT
    /* The other number of this pair plays roulette; this one has chosen an emitter, which is another estimate. */
    chosen = mcv_draw(slot, depth, MCV_PAIR_CHOICE).x;
#endif
    mcv_scattering other;
    mcv_scattering on = mcv_scatter(world, meeting, media, pair, chosen, unmatched, &other);
#if MCV_WITH_SPLIT
    if (other.chance > 0.0f && MCV_WORD(slot, branch, 0) + 1u < MCV_BRANCHES &&
        mcv_split_path(world, slot, beside, meeting, media, pair.x, throughput, &on, other))
        ways = MCV_BRANCHES_OFF;
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

#if MCV_WITH_REACH && MCV_WITH_NEXT_EVENT
    for (uint i = 0; i < 2; ++i) MCV_WORD(slot, reach, i) = MCV_WORD(slot, reach_here, i);
#endif
    mcv_send_on(world, slot, meeting, media, on, throughput);
    return ways | MCV_GOES_ON;
}

/* What the path would still have carried, in units of 2^-11: a million paths fit the counter. */
static uint mcv_lost_energy(mcv_slot slot) {
    mcv_color throughput;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    return (uint)(mcv_brightest(throughput) * 2048.0f + 0.5f);
}
