/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_assets: a root array of other files that nodes place, so that a rig is written by hand and
 * its parts are exported again and again.
 *
 *     {"name": "cover", "uri": "cover.stl", "unit": "mm", "material": "glass", "creaseAngle":
 * "30deg"}
 *     {"name": "vial", "uri": "vial.glb", "materials": {"Glass.001": "glass", "Water": "water"},
 * "nodeMaterials": {"Cap": "rubber"}}
 *
 * `unit` is that of the file's lengths; an .stl file does not tell it, so it must be given, for
 * glTF it is metres by default. Only meshes and emissive materials of a glTF file count.
 *
 * Materials of the scene, by name or index, may take the place of the file's: `material` all of
 * them, `materials` those of these names, `nodeMaterials` whatever hangs on the nodes of these
 * names or below them. The nearest node counts, then the material's name, then `material`. Several
 * of one name are meant all; what has no name goes by its index. What was replaced does not emit
 * light.
 *
 * STL files know flat triangles only. With a `creaseAngle` (host/scene/normals.c) they get vertex
 * normals, continuous where faces meet at this angle or less: bodies of glass and mirrors need them
 * where they are curved.
 */
#ifndef MCVISI_ASSET_H
#define MCVISI_ASSET_H

#include "mcvisi/params.h"

#define MCV_ASSET_PARAMS(X) \
    X(angle, creaseAngle, MCV_UNSET, 0, 3.141592653589793, \
      "of an .stl file: faces that meet at this angle or less are one smooth surface; flat " \
      "triangles without it [rad]")

#endif
