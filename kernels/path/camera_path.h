/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The state of a path between stages, a structure of arrays: word f of the path in slot i of a
 * slice lies at base[f capacity + i]. One list gives the layout on the device and, through
 * mcv_path_words, the allocation on the host. The fields from throughput to cell must be
 * contiguous: kernels/schedule/terminate_paths.h copies them as one range.
 *
 * The tile schedule (MCV_TILE) keeps a slice in private memory and moves living paths together.
 * What it computes for a whole slice at once has fields of its own.
 */
#ifndef MCVISI_KERNELS_CAMERA_PATH_H
#define MCVISI_KERNELS_CAMERA_PATH_H

#include "mcvisi/dialect.h"

#ifndef MCV_TILE
#define MCV_TILE 0
#endif

/* Whether the origins of new rays are computed for many paths at once, after all else. */
#define MCV_OFFSETS_TOGETHER (MCV_TILE && !MCV_WITH_MIXED)

/* A sample's path splits at the first surfaces of glass, sheets and beam splitters that it meets,
 * so that it has at most so many branches: a power of two. */
#define MCV_SPLIT_BRANCHES 4
#define MCV_BRANCHES (MCV_WITH_SPLIT ? MCV_SPLIT_BRANCHES : 1)

/* Whether a surface may scatter light into other media than those of the ray that meets it. */
#define MCV_CROSSES (MCV_WITH_DIELECTRIC && (MCV_WITH_GLOSSY || MCV_WITH_REFLECTOR))

/*
 * X(field, words): a field that a scene does not need has no words. Code that uses it stands behind
 * `if (MCV_WITH_…)`. Paths of either kind have a ray and a hit. Between these lie words that camera
 * paths and light paths use as they need: a slice holds paths of one kind. Fields before the hit
 * live on to the next surface.
 */
#define MCV_RAY_FIELDS(X) \
    X(origin_surface, MCV_WITH_SURFACES) /* the exact surface that the ray starts on \
                                            (mcvisi/surfaces/solid.h), or MCV_NONE */ \
    X(stream, 1)                         /* of random numbers: pixel, replicate, seed, branch */ \
    X(sample, 1) \
    X(time, MCV_WITH_MOVING)          /* [s] */ \
    X(origin_low, 3 * MCV_WITH_MIXED) /* what rounding leaves of the ray (geometry/precise.h) */ \
    X(direction_low, 3 * MCV_WITH_MIXED) \
    X(origin, 3)                /* of the current ray [m] */ \
    X(direction, 3)             /* unit */ \
    X(throughput, MCV_CHANNELS) /* product of reflectances, transmittances … since the start */ \
    X(media, MCV_WITH_DIELECTRIC) /* set of the media the ray is in */

#define MCV_CAMERA_FIELDS(X) \
    X(weight, 1)                     /* of the sensor's ray; 0: the path is not begun */ \
    X(radiance, MCV_CHANNELS)        /* found so far, L/n² */ \
    X(branch_number, MCV_WITH_SPLIT) /* 0 … MCV_BRANCHES - 1: how often the path has split; a \
                                 branch k: MCV_BRANCHES + k, splits no more */ \
    X(sample_place, MCV_TILE)        /* which sample of its slice the path belongs to */ \
    X(cell, MCV_WITH_RECORDS)        /* of the film (mcv_film_cell) */ \
    X(density, MCV_WITH_NEXT_EVENT)  /* with which the last surface chose the direction [1/sr]; 0: \
                                        it is smooth */ \
    /* Of the last surface that scattered light: light/selection.h; light/tree.h: its normal. */ \
    X(selection, (2 * MCV_WITH_REACH + 3 * MCV_WITH_LIGHT_TREE) * MCV_WITH_NEXT_EVENT) \
    X(path_class, MCV_WITH_LIGHT_TRACING) /* MCV_PATH_CLASS_… */ \
    X(footprint, MCV_WITH_LIGHT_TRACING)  /* of the pixel, at the first surface but plates [m²] */

#define MCV_HIT_FIELDS(X) \
    X(hit, 4)                              /* t, u, v, primitive */ \
    X(drawn, 6 * MCV_TILE)                 /* the surface's pairs of random numbers */ \
    X(reflectance, MCV_CHANNELS *MCV_TILE) /* of a diffuse surface; base colour of a glossy one */ \
    X(polish, 2 * MCV_TILE * MCV_WITH_GLOSSY * MCV_WITH_TEXTURE) /* roughness, metallic share */ \
    X(bounce, 4 * MCV_TILE) /* a diffuse reflection's direction and density */ \
    X(point, 3 * MCV_TILE)  /* of the surface, as in mcv_surface */ \
    X(error, 3 * MCV_TILE) \
    X(area, MCV_TILE) \
    X(instance, MCV_TILE) \
    X(front_ns, 3 * MCV_TILE * MCV_WITH_NORMALS) /* its ns; without normals that is ng */ \
    X(back_face, MCV_TILE) /* and how the ray sees it, as in mcv_interaction */ \
    X(ng, 3 * MCV_TILE) \
    X(ns, 3 * MCV_TILE) \
    X(contact, 3 * MCV_TILE * MCV_WITH_CONTACT) /* mcv_interaction: exited, entered, touched */ \
    X(beyond_point, 3 * MCV_TILE * MCV_WITH_CONTACT) \
    X(beyond_error, 3 * MCV_TILE * MCV_WITH_CONTACT) \
    X(touched_ng, 3 * MCV_TILE * MCV_WITH_CONTACT) \
    X(glossy_known, MCV_TILE *MCV_WITH_GLOSSY)

#define MCV_CAMERA_HIT_FIELDS(X) \
    X(branch_state, (5 + MCV_CHANNELS) * MCV_TILE * MCV_WITH_SPLIT) /* of a branch: direction, \
                                                         media, density, throughput */ \
    X(emitter, MCV_TILE *MCV_WITH_NEXT_EVENT) /* that the path samples, or MCV_NONE */ \
    X(place, 4 * MCV_TILE * MCV_WITH_NEXT_EVENT * MCV_WITH_TEXTURE) /* triangle, u, v, density */ \
    X(selection_here, ((2 + MCV_WITH_GLOSSY) * MCV_WITH_REACH + 4 * MCV_WITH_LIGHT_TREE) * \
                          MCV_WITH_NEXT_EVENT) /* as `selection`; last: how it was made */ \
    X(shadow_origin, 3 * MCV_WITH_NEXT_EVENT)  /* ray to the emitter */ \
    X(shadow_direction, 3 * MCV_WITH_NEXT_EVENT) \
    X(shadow_origin_surface, MCV_WITH_NEXT_EVENT *MCV_WITH_SURFACES) \
    X(shadow_density, MCV_TILE *MCV_WITH_NEXT_EVENT)   /* pdf of mcv_light_sample */ \
    X(shadow_media, MCV_WITH_NEXT_EVENT *MCV_CROSSES)  /* that it leaves the surface in */ \
    X(shadow_light, MCV_WITH_NEXT_EVENT *MCV_CHANNELS) /* what it brings; 0: no ray */ \
    X(shadow_emitter_element, MCV_WITH_NEXT_EVENT *MCV_WITH_RECORDS) /* from which */ \
    X(shadow_target, MCV_WITH_NEXT_EVENT) /* instance to be met first; MCV_NONE: nothing may be \
                                             met up to t = 1; MCV_SKY: nothing at all */

#define MCV_PATH_FIELDS(X) \
    MCV_RAY_FIELDS(X) MCV_CAMERA_FIELDS(X) MCV_HIT_FIELDS(X) MCV_CAMERA_HIT_FIELDS(X)

/* Of a light path: light_…. The stream schedule keeps these paths in registers. */
#define MCV_LIGHT_FIELDS(X) \
    X(light_flux, MCV_CHANNELS *MCV_LIGHT_ROWS) /* that has started [W] */ \
    X(light_etendue, MCV_LIGHT_ROWS)            /* one over the density of its start [m² sr] */ \
    X(light_emitter, MCV_LIGHT_ROWS)            /* where it has started */ \
    X(light_replicate, MCV_LIGHT_ROWS)          /* that it counts for */ \
    X(light_flags, MCV_LIGHT_ROWS)              /* MCV_LIGHT_FLAG_… */ \
    X(light_length, MCV_LIGHT_ROWS)             /* so far [m] */ \
    X(light_emitter_element, MCV_LIGHT_ROWS *MCV_WITH_RECORDS) /* that sends it */

/* Whether light paths lie in rows. Where beams come to the lens by themselves or colours part, they
 * are traced one by one. */
#define MCV_LIGHT_ROWS \
    (MCV_OFFSETS_TOGETHER && MCV_WITH_LIGHT_TRACING && MCV_WITH_NEXT_EVENT && !MCV_HAS_BEAMS && \
     !MCV_WITH_DISPERSION)

/*
 * The surfaces that a camera path has hit so far; "broad" is one with a `broad_lobe`. If the sensor
 * sees a broad surface first, directly or through a plate, light paths carry light by smooth and
 * `near_specular` surfaces to a broad one. A camera path that began so is weighted against
 * them (mcv_light_path_mis_weight) and finds it by chance only. If the sensor sees a glossy surface
 * first, camera paths find that light: the lens would seldom lie in the surface's highlights.
 */
enum {
    MCV_PATH_CLASS_STRAIGHT, /* nothing but what passes light straight on */
    MCV_PATH_CLASS_OTHER,    /* first of all another smooth surface, or a glossy one */
    MCV_PATH_CLASS_BROAD,    /* first a broad surface; the last one, too */
    MCV_PATH_CLASS_GLOSSY,   /* first a broad surface; the last scattering one is glossy */
    MCV_PATH_CLASS_CARRIED   /* the same as BROAD, but for smooth and near-specular surfaces
                                since */
};

#if MCV_ON_DEVICE
#include "world.h"

#define MCV_PATH_OFFSET(field, words) \
    MCV_PATH_##field, MCV_PATH_LAST_##field = MCV_PATH_##field + (words)-1,
#define MCV_LARGER(a, b) ((a) > (b) ? (a) : (b))
/* `LAST` is the last word of a field, or of several: the next one follows it. Fields of camera
 * paths and of light paths begin with the same word, MCV_PATH_OWN. */
enum {
    MCV_RAY_FIELDS(MCV_PATH_OFFSET) MCV_PATH_OWN,
    MCV_PATH_LAST_ray = MCV_PATH_OWN - 1,
    MCV_CAMERA_FIELDS(MCV_PATH_OFFSET) MCV_PATH_CAMERA_END,
    MCV_PATH_REWIND = MCV_PATH_OWN - 1,
    MCV_LIGHT_FIELDS(MCV_PATH_OFFSET) MCV_PATH_LIGHT_END,
    MCV_PATH_LAST_own = MCV_LARGER(MCV_PATH_CAMERA_END, MCV_PATH_LIGHT_END) - 1,
    MCV_HIT_FIELDS(MCV_PATH_OFFSET) MCV_CAMERA_HIT_FIELDS(MCV_PATH_OFFSET) MCV_PATH_WORDS
};

#if MCV_TILE
#define MCV_PATH_SPACE __private
#define MCV_SLOTS (MCV_SLICE * MCV_BRANCHES)
#define MCV_ROW \
    (MCV_SLOTS + 16) /* words: rows of powers of two would get into each other's way in the cache \
                      */
#define MCV_CAPACITY(slot) ((uint)MCV_ROW)
#else
#define MCV_PATH_SPACE __global
#define MCV_CAPACITY(slot) (slot).capacity
#endif

struct mcv_glossy_interaction;

/* A path's place: slot `index` of a slice of `capacity` paths. */
typedef struct mcv_slot {
    MCV_PATH_SPACE uint *base;
#if !MCV_TILE
    uint capacity;
#elif MCV_WITH_GLOSSY
    struct mcv_glossy_interaction *glossy_interactions; /* of each slot (bsdf/glossy.h) */
#endif
    uint index;
} mcv_slot;

#if MCV_TILE
/* For what does not ask for `glossy_interactions`. */
MCV_LOOP_FUNCTION mcv_slot mcv_slot_at(uint *paths, uint index) {
    mcv_slot slot;
    slot.base = paths;
    slot.index = index;
#if MCV_WITH_GLOSSY
    slot.glossy_interactions = 0;
#endif
    return slot;
}
#endif

#define MCV_WORD(slot, field, k) \
    (slot).base[((uint)MCV_PATH_##field + (uint)(k)) * MCV_CAPACITY(slot) + (slot).index]
#define MCV_LOAD(slot, field, k) as_float(MCV_WORD(slot, field, k))
#define MCV_STORE(slot, field, k, value) (MCV_WORD(slot, field, k) = as_uint(value))
#define MCV_LOAD_3(slot, field) \
    mcv_vec(MCV_LOAD(slot, field, 0), MCV_LOAD(slot, field, 1), MCV_LOAD(slot, field, 2))
#define MCV_STORE_3(slot, field, value) \
    do { \
        MCV_STORE(slot, field, 0, (value).x); \
        MCV_STORE(slot, field, 1, (value).y); \
        MCV_STORE(slot, field, 2, (value).z); \
    } while (0)
/* The same, but for a path that is `skipped`. Values are chosen among, not places in memory: with
 * these a loop over paths would not be vectorised. */
#define MCV_REPLACE_WORD(slot, field, k, skipped, value) \
    do { \
        const uint before = MCV_WORD(slot, field, k), after = (value); \
        MCV_WORD(slot, field, k) = (skipped) ? before : after; \
    } while (0)
#define MCV_REPLACE(slot, field, k, skipped, value) \
    do { \
        const float before = MCV_LOAD(slot, field, k), after = (value); \
        MCV_STORE(slot, field, k, (skipped) ? before : after); \
    } while (0)
#define MCV_LOAD_COLOR(slot, field, color) \
    MCV_EACH_CHANNEL(channel)(color).c[channel] = MCV_LOAD(slot, field, channel)
#define MCV_STORE_COLOR(slot, field, color) \
    MCV_EACH_CHANNEL(channel) MCV_STORE(slot, field, channel, (color).c[channel])

MCV_LOOP_FUNCTION mcv_color mcv_path_throughput(mcv_slot slot) {
    mcv_color throughput;
    MCV_LOAD_COLOR(slot, throughput, throughput);
    return throughput;
}

/* The set of the media that its ray is in. */
MCV_FUNCTION uint mcv_path_media(mcv_slot slot) {
    return MCV_WITH_DIELECTRIC ? MCV_WORD(slot, media, 0) : 0u;
}

/* The exact surface that its ray starts on. */
MCV_FUNCTION uint mcv_path_origin_surface(mcv_slot slot) {
    return MCV_WITH_SURFACES ? MCV_WORD(slot, origin_surface, 0) : MCV_NONE;
}

/* With which its last surface chose the direction, as far as anything is weighed against that. */
MCV_FUNCTION float mcv_path_density(mcv_slot slot) {
    return MCV_WITH_NEXT_EVENT ? MCV_LOAD(slot, density, 0) : 0.0f;
}

/* Which of its sample's branches a path is. */
MCV_FUNCTION uint mcv_branch_of(mcv_slot slot) {
    const uint branch = MCV_WITH_SPLIT ? MCV_WORD(slot, branch_number, 0) : 0u;
    return branch < MCV_BRANCHES ? 0u : branch - MCV_BRANCHES;
}

#endif

#endif
