/* SPDX-License-Identifier: Apache-2.0 */
/* STL files, binary or ASCII. */
#ifndef MCVISI_HOST_LOADER_LOAD_STL_H
#define MCVISI_HOST_LOADER_LOAD_STL_H

#include "core/input_file.h"
#include "core/json_path.h"
#include "scene/scene.h"

/* Adds the triangles of a file to the scene. `size` gets the size of their box, in the file's unit.
 * `place` is the file, for messages. */
mcv_result mcv_load_stl(mcv_scene *scene, mcv_bytes bytes, const char *name, uint32_t *mesh,
                        double size[3], const mcv_json_path *place, mcv_error *error);

#endif
