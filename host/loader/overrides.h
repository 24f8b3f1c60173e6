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

/*
 * What stands at such a path, or at the begin of one: borrowed from the tree. The search may add
 * empty objects and defaults to it. MCV_BAD_INPUT where there is nothing.
 */
mcv_result mcv_overrides_find(const char *path, json_t *root, const mcv_json_path *file,
                              const json_t **found, mcv_error *error);

/* The number, in SI, that stands at such a path of a document with these overrides. MCV_BAD_INPUT
 * where none does. */
mcv_result mcv_overrides_number(const char *path, mcv_overrides overrides,
                                const mcv_document *document, double *number, mcv_error *error);

/* The short form of a path below an element: "distance" for "extensions/MCVISI_pose/distance". */
const char *mcv_overrides_shorten(const char *collection, const char *path);

/* override_paths.c: all paths of values that the document has, in its order; NULL without memory.
 */
json_t *mcv_overrides_paths(const json_t *root);

#endif
