/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_assets: a root array of other files, which nodes place. The rig stands in one file and its
 * parts in others, so that a part can be exported again without touching the rig.
 *
 *     {"name": "cover", "uri": "cover.stl", "unit": "mm", "material": "glass",
 *      "creaseAngle": "30deg"}
 *     {"name": "vial", "uri": "vial.glb", "nodeMaterials": {"Cap": "rubber"},
 *      "materials": {"Glass.001": "glass", "Water": "water"}}
 *
 * `unit` is the unit of the file's lengths. It is required for .stl files, which do not state it;
 * for glTF its default is the metre. Of a glTF file only meshes and emissive materials are used.
 *
 * Materials of the scene, by name or index, may replace those of the file. `material` replaces all
 * of them, `materials` those with the given names, `nodeMaterials` those of the nodes with the
 * given names and of the nodes below them. The nearest node has precedence, then the material's
 * name, then `material`. A name that occurs several times means all of them. A nameless material or
 * node goes by its index. A replaced material does not emit.
 *
 * STL files contain flat triangles only, and so do glTF files without NORMAL. With a `creaseAngle`
 * (host/scene/normals.c) a part gets vertex normals that are continuous where faces of one mesh
 * primitive meet at this angle or less; they replace those of a glTF file. Curved lenses and curved
 * mirrors need them.
 */
#ifndef MCVISI_ASSET_H
#define MCVISI_ASSET_H

#include "mcvisi/params.h"

#define MCV_ASSET_PARAMS(X) \
    X(angle, creaseAngle, MCV_UNSET, 0, 3.141592653589793, \
      "faces that meet at this angle or less form one smooth surface, also in place of a glTF " \
      "file's normals; without it triangles of an .stl file are flat [rad]")

#endif
