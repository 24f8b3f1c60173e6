/* SPDX-License-Identifier: Apache-2.0 */
/* The acceleration structure of the scene rendered before, as far as it serves the next one. */
#ifndef MCVISI_HOST_DEVICE_KEEP_HIERARCHY_H
#define MCVISI_HOST_DEVICE_KEEP_HIERARCHY_H

#include "device/device_scene.h"

/*
 * Computes the digests of the device scene's positions and indices. Takes the structure of `kept`,
 * refitted if triangles have moved: device->kept_structure is then true. Where some of the
 * triangles are new, *changed becomes a structure in which only these are built anew. Otherwise
 * neither is so: `kept` is NULL, most triangles are new, or some are in motion. A structure that
 * would cost rays more than 1.2 times as much as when it was built is not kept.
 */
mcv_result mcv_keep_hierarchy(mcv_cl *cl, mcv_device_scene *kept, uint32_t threads,
                              mcv_device_scene *device, mcv_bvh *changed, mcv_error *error);

#endif
