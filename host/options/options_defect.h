/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi defect`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_DEFECT_H
#define MCVISI_HOST_OPTIONS_OPTIONS_DEFECT_H

#define MCV_DEFECT_OPTIONS(X) \
    X(text, marred, "output", 'o', "RIG.gltf", MCV_IN_DEFECT, NULL, 0, 0, \
      "the rig with the defect, in the folder of the rig; by default RIG-TYPE.gltf") \
    X(text, node, "node", 0, "N", MCV_IN_DEFECT, NULL, 0, 0, \
      "the node that gets the defect, by name; the meshes of the nodes below it are part of it") \
    X(text, at, "at", 0, "X,Y,Z", MCV_IN_DEFECT, NULL, 0, 0, \
      "a point of its surface, or inside, along the node's axes, lengths with units: 12mm,3mm,0") \
    X(text, triangle, "triangle", 0, "I[,A,B,C]", MCV_IN_DEFECT, NULL, 0, 0, \
      "in place of --at: a triangle of the node's meshes by its number, and barycentric " \
      "coordinates, by default those of its middle") \
    X(text, direction, "direction", 0, "X,Y,Z", MCV_IN_DEFECT, NULL, 0, 0, \
      "the direction of a scratch, a burr or a stria, in the node's axes, by default along its x " \
      "axis; what a chip turns up, or a crack lies across") \
    X(text, defect_size, "size", 0, "S", MCV_IN_DEFECT, NULL, 0, 0, \
      "diameter, or width of a scratch, such as 0.2mm; or as on drawings: 5/3x0.16 (ISO " \
      "10110-7), " \
      "1/1x0.25 (ISO 10110-3), 60-40 (scratch-dig)") \
    X(text, defect_depth, "depth", 0, "D", MCV_IN_DEFECT, NULL, 0, 0, \
      "depth or height, such as 10um; by default a tenth of the size, of a chip half of it") \
    X(text, length, "length", 0, "L", MCV_IN_DEFECT, NULL, 0, 0, \
      "length of a scratch, a burr or a stria; by default 20 times its size") \
    X(list, with, "with", 0, "KEY=VALUE", MCV_IN_DEFECT, NULL, 0, 0, \
      "another parameter of the defect, as in profile=U or material=iron; count=20 puts 20 into " \
      "places by chance, which seed=7 determines; may be repeated") \
    X(text, defect_name, "name", 0, "NAME", MCV_IN_DEFECT, NULL, 0, 0, \
      "the defect's name, for --set defects/NAME/size; by default its type and a number")

#endif
