/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: finds the first surface on a ray, and what absorption on the way leaves. */
#ifndef MCVISI_KERNELS_INTERSECT_CLOSEST_H
#define MCVISI_KERNELS_INTERSECT_CLOSEST_H

#include "path/camera_path.h"
#include "path/media.h"
#include "path/time.h"
#include "traverse/closest.h"

/* What the way to the hit leaves; of a ray that meets nothing t is infinite. */
MCV_LOOP_FUNCTION void mcv_absorb(mcv_world world, mcv_slot slot) {
    const mcv_color throughput =
        mcv_tint(mcv_path_throughput(slot),
                 mcv_medium_transmittance(world, mcv_path_media(slot), MCV_LOAD(slot, hit, 0)));
    MCV_STORE_COLOR(slot, throughput, throughput);
}

MCV_FUNCTION void mcv_intersect_closest(mcv_world world, mcv_slot slot) {
    const mcv_hit hit = mcv_closest(mcv_at_time(world, slot), MCV_LOAD_3(slot, origin),
                                    MCV_LOAD_3(slot, direction), mcv_path_origin_surface(slot));
    MCV_STORE(slot, hit, 0, hit.t);
    MCV_STORE(slot, hit, 1, hit.u);
    MCV_STORE(slot, hit, 2, hit.v);
    MCV_WORD(slot, hit, 3) = hit.primitive;
    if (MCV_WITH_ABSORPTION) mcv_absorb(world, slot);
}

#endif
