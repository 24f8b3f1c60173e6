/* SPDX-License-Identifier: Apache-2.0 */
/* --set PATH=VALUE on the JSON tree of a document. */
#ifndef MCVISI_HOST_LOADER_OVERRIDES_H
#define MCVISI_HOST_LOADER_OVERRIDES_H

#include "core/json.h"
#include "scene/scene.h"
#include "loader/load.h"

/*
 * PATH begins with an array of the document (sensors, emitters, materials, nodes, cameras …), then
 * names an element, by name or index, then its member; members of arrays are x y z w, r g b a or an
 * index. VALUE is JSON, or else a string; for what is not inside an MCVISI_ object a quantity with
 * a unit becomes its number in SI.
 *
 *     sensors/cam/focalLength=25mm   materials/glass/ior=1.52   nodes/Camera.001/translation/z=0.3
 */
mcv_result mcv_overrides_apply(mcv_overrides overrides, json_t *root, const mcv_json_path *file,
                               mcv_error *error);

#endif
