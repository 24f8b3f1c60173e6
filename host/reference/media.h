/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The media around a point: the dielectric instances that surround it. The one with the largest
 * priority fills the space; among equal priorities the later material, then the later instance. The
 * filling depends on the point alone, not on the path to it.
 */
#ifndef MCVISI_HOST_REFERENCE_MEDIA_H
#define MCVISI_HOST_REFERENCE_MEDIA_H

#include "reference/geometry.h"

enum { REF_MEDIA_DEPTH = 64 };

typedef struct ref_media {
    uint32_t count;
    uint32_t instances[REF_MEDIA_DEPTH];
} ref_media;

/* The media at a point, by the windings along a ray from it. `winding` has one int per instance.
 * Fails if there are too many media. */
mcv_result ref_media_at(const ref_geometry *geometry, ref_vec point, int *winding, ref_media *media,
                        mcv_error *error);

/*
 * The media on the two sides of coincident surfaces, which a path in *near crosses together: of
 * `count` instances, each hit from its front or back. False: *near contradicts a side (a body that
 * was not entered is left, or one is entered twice). The surface is then right, and *near is
 * corrected.
 */
bool ref_media_cross_all(ref_media *near, ref_media *far, uint32_t count, const uint32_t *instances,
                         const bool *fronts);

/* The material that fills the space, or NULL for vacuum (n = 1, clear). */
const mcv_medium_params *ref_media_filling(const ref_media *media, const mcv_scene *scene);

static inline double ref_media_ior(const mcv_medium_params *filling, int channel) {
    return filling ? filling->ior[channel] : 1;
}

#endif
