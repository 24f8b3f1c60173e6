/* SPDX-License-Identifier: Apache-2.0 */
/* The acceleration structure of a packed scene: of what stands still and, behind it, of what
 * moves. */
#ifndef MCVISI_HOST_DEVICE_HIERARCHY_H
#define MCVISI_HOST_DEVICE_HIERARCHY_H

#include "accel/bvh.h"
#include "device/pack.h"

/* begins[2]: the node and the leaf with which the second hierarchy begins; its children count from
 * there. 0, 0 where nothing moves. As mcv_bvh_build otherwise. */
mcv_result mcv_build_hierarchy(const mcv_packed *packed, uint32_t threads, mcv_bvh *bvh,
                               uint32_t begins[2], mcv_error *error);

#endif
