/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: what a surface does to a path. Adds what it emits, then chooses how the path goes on. Each
 * path is continued or ended exactly once. reads ray, hit -> writes radiance, and ray, throughput,
 * media, density | ends
 */
#ifndef MCVISI_KERNELS_SHADE_HIT_H
#define MCVISI_KERNELS_SHADE_HIT_H

#include "light/emission.h"
#include "light/environment.h"
#include "path/identity.h"
#include "path/sensor_ray.h"
#include "light/light_path.h"
#include "geometry/interaction.h"
#include "light/selection.h"
#include "stage/roulette.h"
#include "bsdf/shading.h"
#include "geometry/precise.h"

/*
 * How much oftener than by its chance the less likely way on is followed. Nothing much comes by it
 * where all light is narrow; wide light may come from anywhere.
 */
#define MCV_SPLIT_EFFORT \
    (MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE || MCV_WITH_AREA || MCV_WITH_LIGHT_FIELD \
         ? 8.0f \
         : 1.0f)

#if MCV_WITH_LIGHT_TRACING
/* What light paths leave of what the emitter sends along this path. */
MCV_FUNCTION float mcv_camera_share(mcv_world world, mcv_slot slot, mcv_interaction interaction,
                                    uint emitter) {
#if MCV_WITH_EMISSION
    if (MCV_WORD(slot, path_class, 0) != MCV_PATH_CLASS_CARRIED ||
        !(world.emitters[emitter].light_flux > 0.0f))
        return 1.0f;
    const float etendue = mcv_light_etendue(world, interaction.surface, emitter,
                                            mcv_scale(interaction.direction, -1.0f));
    if (etendue > 0.0f) return 1.0f - mcv_light_share(world, etendue, MCV_LOAD(slot, footprint, 0));
#else
    (void)world, (void)slot, (void)interaction, (void)emitter;
#endif
    return 1.0f;
}

/* The path goes on from a point of a surface that spreads light, widely, sharply or neither, or
 * just lets it pass. */
MCV_LOOP_FUNCTION void mcv_update_path_class_at(mcv_world world, mcv_slot slot, mcv_vec3 point,
                                                int scatters, int connectable, int near_specular,
                                                int passes) {
    const uint before = MCV_WORD(slot, path_class, 0);
    const int straight = before == MCV_PATH_CLASS_STRAIGHT,
              carries = (before == MCV_PATH_CLASS_DIFFUSE) | (before == MCV_PATH_CLASS_CARRIED);
    const float footprint =
        mcv_sensor_footprint(world.sensor, mcv_point_to_optical(world.frame, point).z);
    const uint spread = connectable ? MCV_PATH_CLASS_DIFFUSE
                        : straight  ? MCV_PATH_CLASS_OTHER
                                    : MCV_PATH_CLASS_GLOSSY;
    const uint smooth = carries                ? MCV_PATH_CLASS_CARRIED
                        : (straight & !passes) ? MCV_PATH_CLASS_OTHER
                                               : before;
    MCV_STORE(slot, footprint, 0, straight ? footprint : MCV_LOAD(slot, footprint, 0));
    MCV_WORD(slot, path_class, 0) = before == MCV_PATH_CLASS_OTHER            ? before
                                    : (scatters & !(carries & near_specular)) ? spread
                                                                              : smooth;
}

MCV_LOOP_FUNCTION void mcv_update_path_class(mcv_world world, mcv_slot slot,
                                             const mcv_interaction *interaction,
                                             mcv_shading shading, mcv_scattering on) {
    const int passes = shading.kind == MCV_SHADING_ANY && on.event == MCV_EVENT_PASS &&
                       mcv_is_sheet(world, *interaction);
    mcv_update_path_class_at(world, slot, interaction->surface.point, on.density > 0.0f,
                             mcv_is_connectable(world, *interaction),
                             mcv_is_near_specular(world, *interaction), passes);
}
#endif

/*
 * The density of a ray's choice, as it is to be weighed against that of next-event estimation which
 * takes emitters by power alone: it has taken this one so much more often.
 */
MCV_LOOP_FUNCTION float mcv_density_against(mcv_world world, mcv_slot slot, uint emitter,
                                            float density) {
#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
    const mcv_light_selection selection = {MCV_LOAD(slot, selection, 0),
                                           MCV_LOAD(slot, selection, 1)};
    const float against = density / mcv_selection_ratio(world.emitters + emitter,
                                                        MCV_LOAD_3(slot, origin), selection);
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
    float other; /* the density with which next-event estimation would have chosen this direction
                    [1/sr] */
    float share; /* what light paths leave of it */
} mcv_emitter_hit;

/* Adds what the path has met, weighed against next-event estimation by the power heuristic. */
MCV_LOOP_FUNCTION void mcv_add_emission(mcv_world world, mcv_slot slot,
                                        const mcv_emitter_hit *met) {
    mcv_color throughput, radiance;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    MCV_LOAD_COLOR(slot, radiance, radiance);
    mcv_color emitted = mcv_basic_radiance(world, met->radiance, mcv_path_media(slot));
#if MCV_WITH_NEXT_EVENT
    float own = mcv_density_against(world, slot, met->emitter, mcv_path_density(slot));
#if MCV_WITH_LIGHT_TRACING
    /* Sharp surfaces have not looked for it (mcv_choose_emitter). */
    const int carried = (MCV_WORD(slot, path_class, 0) == MCV_PATH_CLASS_CARRIED) &
                        (world.emitters[met->emitter].light_flux > 0.0f);
    own = carried ? 0.0f : own;
#endif
    const float weight = mcv_power_heuristic(own, met->other);
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
static void mcv_leave_precisely(mcv_world world, mcv_slot slot, const mcv_interaction *interaction,
                                uint media, mcv_scattering *on) {
    const mcv_vec3 low = MCV_LOAD_3(slot, origin_low);
    const mcv_precise_ray ray =
        mcv_precise_ray_of(MCV_LOAD_3(slot, origin), low, MCV_LOAD_3(slot, direction),
                           MCV_LOAD_3(slot, direction_low));
    mcv_precise_interaction met;
    met.found = 0;
    if (on->event != MCV_EVENT_END)
        met = mcv_intersect_precisely(world, interaction, ray, low, MCV_LOAD(slot, hit, 0));
    const mcv_onward onward =
        mcv_go_on_precisely(world, interaction, &met, ray.direction, media, on);
    const mcv_vec3 origin = mcv_onward_origin(*interaction, on->direction);
    MCV_STORE_3(slot, origin, origin);
    MCV_STORE_3(slot, origin_low, mcv_onward_low(&onward, onward.ray.origin, origin));
    MCV_STORE_3(slot, direction_low, mcv_onward_low(&onward, onward.ray.direction, on->direction));
}
#endif

/* A ray that leaves the scene sees the environment. */
MCV_LOOP_FUNCTION void mcv_shade_miss(mcv_world world, mcv_slot slot) {
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
    const mcv_color met =
        mcv_environment_seen(world, MCV_LOAD_3(slot, direction), mcv_path_media(slot), density);
    MCV_EACH_CHANNEL(i) radiance.c[i] = mcv_fma(throughput.c[i], met.c[i], radiance.c[i]);
    MCV_STORE_COLOR(slot, radiance, radiance);
#else
    (void)world, (void)slot;
#endif
}

/*
 * The path continues from the surface. skipped: 1 leaves it as it is; known to the compiler where
 * that cannot be. Where origins are worked out for many paths at once, after all else, the old one
 * stays.
 */
MCV_LOOP_FUNCTION void mcv_continue_path(mcv_world world, mcv_slot slot,
                                         const mcv_interaction *interaction, mcv_shading shading,
                                         mcv_scattering on, mcv_color throughput, int skipped) {
#if MCV_WITH_MIXED
    mcv_leave_precisely(world, slot, interaction, mcv_path_media(slot), &on);
#elif !MCV_LEAVES_TOGETHER
    MCV_STORE_3(slot, origin, mcv_onward_origin(*interaction, on.direction));
#endif
    const mcv_vec3 direction = mcv_choose(skipped, interaction->direction, on.direction);
    MCV_STORE_3(slot, direction, direction);
#if MCV_WITH_SURFACES
    const uint origin_surface =
        shading.exact ? mcv_origin_surface_of(world, *interaction, on.direction) : MCV_NONE;
    MCV_WORD(slot, origin_surface, 0) =
        skipped ? MCV_WORD(slot, origin_surface, 0) : origin_surface;
#endif
    MCV_EACH_CHANNEL(i)
    MCV_STORE(slot, throughput, i, skipped ? MCV_LOAD(slot, throughput, i) : throughput.c[i]);
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = skipped ? MCV_WORD(slot, media, 0) : on.media;
#endif
#if MCV_WITH_NEXT_EVENT
    MCV_STORE(slot, density, 0, skipped ? MCV_LOAD(slot, density, 0) : on.density);
#endif
#if MCV_WITH_LIGHT_TRACING
    const uint path_class = MCV_WORD(slot, path_class, 0);
    mcv_update_path_class(world, slot, interaction, shading, on);
    MCV_WORD(slot, path_class, 0) = skipped ? path_class : MCV_WORD(slot, path_class, 0);
#endif
    (void)world, (void)shading;
}

#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
/* After what this surface emits, which the chances of the surface before are for, and before a
 * branch takes them over. */
MCV_LOOP_FUNCTION void mcv_keep_selection(mcv_slot slot) {
    MCV_WORD(slot, selection, 0) = MCV_WORD(slot, selection_here, 0);
    MCV_WORD(slot, selection, 1) = MCV_WORD(slot, selection_here, 1);
}
#endif

MCV_LOOP_FUNCTION int mcv_may_split(mcv_slot slot) {
#if MCV_WITH_SPLIT
    return MCV_WORD(slot, branch, 0) + 1u < MCV_BRANCHES;
#else
    (void)slot;
    return 0;
#endif
}

#if MCV_WITH_SPLIT
/* How a path splits. */
typedef struct mcv_split {
    mcv_scattering on, other; /* the path's and the branch's way, */
    mcv_color carried;        /* what that carries, */
    int splits, branches;     /* and whether there are both */
} mcv_split;

/*
 * The path takes the likelier one of two ways on instead of that which chance has chosen, and a
 * branch the other one, each weighed by its own chance: R + T. The branch has to survive roulette.
 * Where an environment shines from all sides both ways bring about the same: the path then stands
 * in for what roulette ends, so that both carry as much as before. xi: the number that has chosen,
 * or what is left of it, which has no other use any more.
 */
MCV_LOOP_FUNCTION mcv_split mcv_split_path(mcv_slot slot, float xi, mcv_color throughput,
                                           mcv_scattering on, mcv_scattering other) {
    mcv_split split;
    const int swaps = (other.chance > on.chance) |
                      ((other.chance == on.chance) & (other.event == MCV_EVENT_REFLECT));
    const mcv_scattering likelier = mcv_choose_scattering(swaps, other, on);
    split.other = mcv_choose_scattering(swaps, on, other);
    const float effort = MCV_SPLIT_EFFORT * mcv_average(throughput);
    const float wanted = split.other.chance * (effort > 1.0f ? effort : 1.0f);
    const float lives = wanted < 1.0f ? wanted : 1.0f;
    float weight = likelier.chance;
    split.splits = (other.chance > 0.0f) & mcv_may_split(slot);
#if MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE
    /* What roulette would soon play for is left to chance: light from all sides keeps being found
     * without noise. */
    const float branches = split.other.chance / lives,
                goes_on = lives < 1.0f ? 1.0f - branches : likelier.chance;
    const float least = mcv_brightest(throughput) * (goes_on < branches ? goes_on : branches);
    split.splits &= !(least < MCV_ROULETTE_WEIGHT * (1.0f - 8.0f * MCV_UNIT_ROUNDOFF));
    weight = lives < 1.0f ? xi < lives ? goes_on : 1.0f : weight;
#endif
    split.on = mcv_choose_scattering(split.splits, likelier, on);
    split.on.factor = mcv_dim(split.on.factor, split.splits ? weight : 1.0f);
    split.carried = mcv_dim(mcv_tint(throughput, split.other.factor), split.other.chance / lives);
    split.branches = split.splits & (xi < lives) & (mcv_brightest(split.carried) > 0.0f);
    return split;
}

#if MCV_TILE
/* What mcv_continue_branch asks for, in branch_state. */
MCV_LOOP_FUNCTION void mcv_store_split(mcv_slot slot, mcv_split split) {
    MCV_STORE_3(slot, branch_state, split.other.direction);
    MCV_WORD(slot, branch_state, 3) = split.other.media;
    MCV_STORE(slot, branch_state, 4, split.other.density);
    MCV_EACH_CHANNEL(c) MCV_STORE(slot, branch_state, 5 + c, split.carried.c[c]);
}

MCV_LOOP_FUNCTION mcv_split mcv_load_split(mcv_slot slot) {
    mcv_split split;
    split.other.direction = MCV_LOAD_3(slot, branch_state);
    split.other.media = MCV_WORD(slot, branch_state, 3);
    split.other.density = MCV_LOAD(slot, branch_state, 4);
    split.other.event = MCV_EVENT_END;
    MCV_EACH_CHANNEL(c) split.carried.c[c] = MCV_LOAD(slot, branch_state, 5 + c);
    return split;
}
#endif

/* A copy of a path becomes its branch: it has random numbers of its own, nothing found so far, and
 * goes the other way. */
MCV_LOOP_FUNCTION void mcv_continue_branch(mcv_world world, mcv_slot slot,
                                           const mcv_interaction *interaction, mcv_shading shading,
                                           mcv_split split) {
    const uint number = MCV_WORD(slot, branch, 0);
    MCV_WORD(slot, branch, 0) = MCV_BRANCHES + number;
    MCV_WORD(slot, stream, 0) = mcv_hash_2(MCV_WORD(slot, stream, 0), number);
    MCV_EACH_CHANNEL(i) MCV_STORE(slot, radiance, i, 0.0f);
    mcv_continue_path(world, slot, interaction, shading, split.other, split.carried, 0);
#if MCV_LEAVES_TOGETHER
    const mcv_vec3 origin = mcv_onward_origin(*interaction, split.other.direction);
    MCV_STORE_3(slot, origin, origin);
#endif
}

/* The branch begins in the slot beside; the path has not continued yet. */
static void mcv_start_branch(mcv_world world, mcv_slot slot, mcv_slot beside,
                             const mcv_interaction *interaction, mcv_split split) {
    for (uint word = 0; word < MCV_PATH_hit; ++word) {
        const uint row = word * MCV_CAPACITY(slot);
        beside.base[row + beside.index] = slot.base[row + slot.index];
    }
#if MCV_WITH_MIXED
    MCV_WORD(beside, hit, 0) = MCV_WORD(slot, hit, 0);
#endif
    mcv_continue_branch(world, beside, interaction, mcv_any_shading(), split);
}
#endif

/* How a path continues from a surface, and whether it does. */
typedef struct mcv_shaded {
    mcv_scattering on;
    mcv_color throughput;
#if MCV_WITH_SPLIT
    mcv_split split; /* where it splits */
#endif
    uint fate; /* MCV_CONTINUES | MCV_SPLITS, or MCV_UNSHADED: the class does not hold this surface,
                  mcv_shade_surface does */
} mcv_shaded;

/* Chooses how a path continues from the surface that it has met: scattering, splitting, Russian
 * roulette. */
MCV_LOOP_FUNCTION mcv_shaded mcv_shade_hit(mcv_world world, mcv_slot slot,
                                           const mcv_interaction *interaction, mcv_shading shading,
                                           uint depth, uint *unmatched) {
    mcv_shaded shaded;
    mcv_scattering other;
    int unshaded = 0;
    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_SCATTER),
                   choice = mcv_draw_choice(slot, depth);
    MCV_LOAD_COLOR(slot, throughput, shaded.throughput);
    shaded.fate = 0u;
    shaded.on = mcv_scatter_as(world, slot, interaction, shading, pair, choice.x,
                               mcv_may_split(slot), unmatched, &other, &unshaded);
#if MCV_WITH_SPLIT
    shaded.split.branches = 0;
    if (shading.kind == MCV_SHADING_ANY ? other.chance > 0.0f : shading.splits) {
        shaded.split =
            mcv_split_path(slot, shaded.on.event == MCV_EVENT_END ? shaded.on.remainder : pair.x,
                           shaded.throughput, shaded.on, other);
        shaded.on = shaded.split.on;
        MCV_WORD(slot, branch, 0) += (uint)shaded.split.splits;
        shaded.fate = shaded.split.branches ? MCV_SPLITS : 0u;
    }
#endif
    shaded.throughput = mcv_tint(shaded.throughput, shaded.on.factor);
    const mcv_roulette roulette =
        mcv_play_roulette(depth >= MCV_ROULETTE_DEPTH, mcv_brightest(shaded.throughput),
                          MCV_ROULETTE_WEIGHT, choice.y);
    shaded.throughput = mcv_after_roulette(roulette, shaded.throughput);
    shaded.fate |= roulette.survives ? MCV_CONTINUES : 0u;
    shaded.fate = unshaded ? MCV_UNSHADED : shaded.fate;
    return shaded;
}

#if MCV_WITH_EMISSION
/* Adds what a surface emits that the path has met. */
static void mcv_shade_emitter_hit(mcv_world world, mcv_slot slot, mcv_interaction interaction) {
    const uint emitter = world.instances[interaction.surface.instance].emitter;
    if (emitter == MCV_NONE) return;
    mcv_emitter_hit met;
    met.radiance =
        mcv_emitted(world, interaction.surface, emitter, mcv_scale(interaction.direction, -1.0f));
    met.emitter = emitter;
    met.other = 0.0f;
    met.share = 1.0f;
#if MCV_WITH_NEXT_EVENT
    const float distance = MCV_LOAD(slot, hit, 0);
    const mcv_vec3 receiver =
        mcv_along(interaction.surface.point, -distance, interaction.direction);
    met.other = mcv_emitter_density(world, receiver, interaction.surface, emitter,
                                    interaction.direction, distance);
#endif
#if MCV_WITH_LIGHT_TRACING
    met.share = mcv_camera_share(world, slot, interaction, emitter);
#endif
    mcv_add_emission(world, slot, &met);
}
#endif

/* MCV_CONTINUES: the path, which has met a surface, does; MCV_SPLITS: so does a branch, in the slot
 * beside. */
static uint mcv_shade_surface(mcv_world world, mcv_slot slot, mcv_slot beside, uint depth,
                              uint *unmatched) {
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
#if MCV_WITH_EMISSION
    mcv_shade_emitter_hit(world, slot, interaction);
#endif
#if MCV_WITH_REACH && MCV_WITH_NEXT_EVENT
    mcv_keep_selection(slot);
#endif
    const mcv_shaded shaded =
        mcv_shade_hit(world, slot, &interaction, mcv_any_shading(), depth, unmatched);
#if MCV_WITH_SPLIT
    if (shaded.fate & MCV_SPLITS) mcv_start_branch(world, slot, beside, &interaction, shaded.split);
#else
    (void)beside;
#endif
    if (shaded.fate & MCV_CONTINUES)
        mcv_continue_path(world, slot, &interaction, mcv_any_shading(), shaded.on,
                          shaded.throughput, 0);
    return shaded.fate;
}

/* What the path would still have carried, in units of 2^-11: a million paths fit the counter. */
static uint mcv_lost_energy(mcv_slot slot) {
    mcv_color throughput;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    return (uint)(mcv_brightest(throughput) * 2048.0f + 0.5f);
}

#endif
