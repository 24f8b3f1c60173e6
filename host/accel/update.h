/* SPDX-License-Identifier: Apache-2.0 */
/* The acceleration structure of a scene of which only a part is new. */
#ifndef MCVISI_HOST_ACCEL_UPDATE_H
#define MCVISI_HOST_ACCEL_UPDATE_H

#include "accel/bvh.h"

/* A structure from which those of other scenes are made. Free it with mcv_bvh_base_free. */
typedef struct mcv_bvh_base {
    mcv_bvh bvh;
    float *corners; /* [triangle][corner][axis] */
    uint32_t triangle_count;
} mcv_bvh_base;

/* Of a scene with so many triangles. The structure changes owners, even after a failure, which is
 * for lack of memory. */
mcv_result mcv_bvh_base_make(mcv_bvh *bvh, uint32_t triangle_count, mcv_bvh_base *base,
                             mcv_error *error);
void mcv_bvh_base_free(mcv_bvh_base *base);

/*
 * The structure of other triangles, most of which the base has, too, with the same corners to the
 * bit in the same order; their numbers may differ. These stay in their leaves. The others get a
 * hierarchy of their own, whose parts are put where boxes grow least. Rays find the same hits as in
 * a new structure. The arguments and the errors are those of mcv_bvh_build. Where less than half of
 * the triangles of either is in both, or where the structure would be too deep, *bvh stays empty:
 * build a new one then.
 */
mcv_result mcv_bvh_update(const mcv_bvh_base *base, const float *positions, const uint32_t *indices,
                          uint32_t triangle_count, uint32_t threads, mcv_bvh *bvh,
                          mcv_error *error);

/* match.c */

/* Which triangles are which. */
typedef struct mcv_matches {
    uint32_t *numbers; /* of the base's triangles in the new scene; MCV_NONE: they are not there */
    bool *found;       /* per new triangle: the base has it */
    uint32_t found_count;
} mcv_matches;

/* False without memory. Free it with mcv_matches_free in any case. */
bool mcv_match_triangles(const mcv_bvh_base *base, const float *positions, const uint32_t *indices,
                         uint32_t triangle_count, mcv_matches *matches);
void mcv_matches_free(mcv_matches *matches);

#endif
