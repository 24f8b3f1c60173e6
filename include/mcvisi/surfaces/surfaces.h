/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact surfaces. MCVISI_surfaces is a root array of bodies {"type": …, parameters}; a node places
 * one by its index {"surface": i}. Rays hit them where their formula says, with its normal, at any
 * scale; a lens takes a few hundred bytes. Lengths are in metres and do not scale with the node.
 * `material` names the body's material (index or name in the file's `materials`).
 *
 * "lens": optical surfaces in a row along the node's +z, the first vertex in its origin.
 *
 *     {"type": "lens", "surfaces": [
 *         {"radius": "50mm", "semiDiameter": "12.5mm", "thickness": "5mm", "material": "glass"},
 *         {"radius": "-50mm", "semiDiameter": "12.5mm"}]}
 *
 * The sag of a surface is z(r) = c r²/(1 + √(1 - (1 + k) c² r²)) + Σ A_i r^i with r² = x² + y², or
 * r² = y² for a cylindrical one. c = 1/radius is 0 without a radius, and positive if the centre
 * lies towards +z. k is the conic constant (0 sphere, -1 paraboloid). `asphere` holds A_4, A_6 …
 * A_18 [m^(1-i)].
 *
 * `thickness` is the distance to the next vertex. `material` fills the space up to the next
 * surface; without it this space is a gap. A surface between two materials is their contact: light
 * passes from one into the other, as in a cemented doublet. Each body's edge is a cylinder whose
 * radius is the larger semi-diameter of its two surfaces; the other surface is continued up to it.
 * The edge absorbs, as if blackened. `rim` names another material: a diffuse one for ground glass,
 * the glass's own for a polished edge; other transparent materials are errors.
 *
 * "surface" is one such surface by itself, with a hole of radius `holeRadius`: for mirrors, stops
 * and screens. "disc" is a plane one. Their front faces -z. "box", "cylinder" (along z) and
 * "sphere" are centred in the node's origin.
 *
 * Bodies of glass, exact ones or meshes, may touch. Surfaces that coincide, up to the rounding of
 * coordinates, are hit together.
 */
#ifndef MCVISI_SURFACES_H
#define MCVISI_SURFACES_H

#include "mcvisi/params.h"

/* Terms r^4 … r^18 of an asphere. */
#define MCV_ASPHERE_TERMS 8

/* X(name, "name in the scene file", NAME), as for elements. */
#define MCV_BODIES(X) \
    X(lens, "lens", LENS) \
    X(open_surface, "surface", OPEN_SURFACE) \
    X(disc, "disc", DISC) \
    X(box, "box", BOX) \
    X(cylinder, "cylinder", CYLINDER) \
    X(sphere, "sphere", SPHERE)

#define MCV_OPTICAL_SURFACE_PARAMS(X) \
    X(length, radius, MCV_UNSET, -1e15, 1e15, \
      "radius of curvature at the vertex, positive if the centre lies towards +z [m]") \
    X(number, curvature, MCV_UNSET, -1e9, 1e9, \
      "inverse of the radius; a plane where neither is given [1/m]") \
    X(number, conic, 0, -1e9, 1e9, "conic constant k") \
    X(flag, cylindrical, 0, 0, 1, "curved along y only") \
    X(length, semiDiameter, MCV_REQUIRED, MCV_POSITIVE, 1e6, "radius of the surface's edge [m]")

/* For a surface in a lens. */
#define MCV_LENS_SURFACE_PARAMS(X) \
    MCV_OPTICAL_SURFACE_PARAMS(X) \
    X(length, thickness, 0, 0, 1e6, "distance from this vertex to the next one [m]")

#define MCV_BODY_LENS_PARAMS(X)
#define MCV_BODY_OPEN_SURFACE_PARAMS(X) \
    MCV_OPTICAL_SURFACE_PARAMS(X) \
    X(length, holeRadius, 0, 0, 1e6, "radius of the hole in its middle [m]")
#define MCV_BODY_DISC_PARAMS(X) \
    X(length, radius, MCV_REQUIRED, MCV_POSITIVE, 1e6, "radius [m]") \
    X(length, holeRadius, 0, 0, 1e6, "radius of the hole in its middle [m]")
#define MCV_BODY_BOX_PARAMS(X) \
    X(length, width, MCV_REQUIRED, MCV_POSITIVE, 1e6, "size along x [m]") \
    X(length, height, MCV_REQUIRED, MCV_POSITIVE, 1e6, "size along y [m]") \
    X(length, depth, MCV_REQUIRED, MCV_POSITIVE, 1e6, "size along z [m]")
#define MCV_BODY_CYLINDER_PARAMS(X) \
    X(length, radius, MCV_REQUIRED, MCV_POSITIVE, 1e6, "radius [m]") \
    X(length, length, MCV_REQUIRED, MCV_POSITIVE, 1e6, "length along z [m]")
#define MCV_BODY_SPHERE_PARAMS(X) X(length, radius, MCV_REQUIRED, MCV_POSITIVE, 1e9, "radius [m]")

#define MCV_BODY_ENUM(name, key, NAME) MCV_BODY_##NAME,
enum { MCV_BODIES(MCV_BODY_ENUM) MCV_BODY_COUNT };

#endif
