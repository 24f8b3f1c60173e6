/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_defects: a root array of defects, each on the surface of a node.
 *
 *     {"name": "nick", "type": "dent", "node": "part", "at": ["12mm", "3mm", 0],
 *      "size": "0.2mm", "depth": "10um"}
 *     {"name": "scar", "type": "scratch", "node": "part", "triangle": 17,
 *      "barycentric": [0.2, 0.3, 0.5], "direction": [1, 0, 0], "size": "50um", "length": "4mm",
 *      "profile": "V", "pileUp": 0.5}
 *
 * `node` is a node of the scene or of an asset, by name: its meshes and those of the nodes below
 * it. The place is a point `at` in metres along the node's axes, whatever its scale is, or a
 * `triangle` of these meshes, numbered in their order, with `barycentric` coordinates (its middle
 * by default). The nearest point of the surface is the defect's middle; it must lie within half of
 * the defect's size.
 *
 * A defect is a height h(u, v) over the tangent plane at its middle, along the normal there:
 *
 *     p' = p + h(u, v) n,    n' ~ n_b - grad h (n . n_b)
 *
 * with the normal n_b of the surface before. The map keeps areas across n, so that a closed mesh
 * changes its volume by exactly the integral of h. u runs along `direction`, as far as it is in the
 * tangent plane; by default it is the node's x axis.
 *
 *     dent, bump   gaussian: h = -+ d exp(-r²/(2 s²)), s = size/4: size is the diameter at 1/e²;
 *                  cosine: h = -+ d cos²(π r/size) up to r = size/2
 *     dig          h = -(sqrt(R² - r²) - R + d) up to r = size/2: a cap of the sphere of radius
 *                  R = (size²/4 + d²)/(2 d)
 *     burr         h = d cos²(π v/size) t(u), a ridge along an edge
 *     scratch      h = -d f(2 |v|/size) t(u): across it f is a V, 1 - x, or a U, 1 - x², whose
 *                  corners are rounded by a triangle of the half-width 1/4; t falls as cos² over
 *                  the last 3 sizes of its length. Beside it stand two ridges, cos² over one size
 *                  each, which together have the share pileUp of the groove's volume.
 *
 * Some change what lies within an outline, a sharp line on the surface. Triangles are cut there, by
 * their edges: both sides of an edge cut it in the same point.
 *
 *     dig          the circle r = size/2
 *     chip         a ball of the diameter `size` bites the part down to `depth` below the middle
 *     missingPart  all that lies above the plane `size` below the middle is cut off
 *     stain        another material within the circle r = size/2
 *     roughPatch   the same with another roughness of the material
 *
 * Chip and missing part move the surface along n down to the ball or plane. The part that goes must
 * be a height over these; n is the mean normal within size/2 of the middle, on an edge that between
 * its sides, or `direction`. A burr takes this normal, too.
 *
 * Bubbles, inclusions, striae and cracks lie inside of a body of a dielectric, mesh or exact. `at`
 * is then a point inside. They are exact surfaces: balls, and nested cylinders of the radii at
 * which indexStep exp(-r²/(2 s²)), s = size/4, is half a step off the next of its `tubes` levels. A
 * crack is a flat disc of gas across `direction`, as thick as its `opening`.
 *
 * With `count`, or with `density` per m² of surface, defects lie in places by chance, which `seed`
 * determines: surface defects evenly over the area, where they fit; others over the volume. They
 * are called NAME-1, NAME-2 and so on.
 *
 * Meshes get triangles so small that the interpolated normals err by at most 1 % of the largest
 * slope for gaussian, 3 % for cosine and scratches (9 % where high ridges begin): edges of size/32,
 * size/64 and size/24, along scratches 16 times that; size/64 for digs, burrs and chips.
 */
#ifndef MCVISI_DEFECTS_H
#define MCVISI_DEFECTS_H

#include "mcvisi/params.h"

/* X(name, "type", NAME) */
#define MCV_DEFECTS(X) \
    X(dent, "dent", DENT) \
    X(bump, "bump", BUMP) \
    X(scratch, "scratch", SCRATCH) \
    X(bubble, "bubble", BUBBLE) \
    X(inclusion, "inclusion", INCLUSION) \
    X(stria, "stria", STRIA) \
    X(dig, "dig", DIG) \
    X(burr, "burr", BURR) \
    X(chip, "chip", CHIP) \
    X(missing_part, "missingPart", MISSING_PART) \
    X(stain, "stain", STAIN) \
    X(rough_patch, "roughPatch", ROUGH_PATCH) \
    X(crack, "crack", CRACK)

enum {
#define MCV_X(name, key, NAME) MCV_DEFECT_##NAME,
    MCV_DEFECTS(MCV_X) MCV_DEFECT_COUNT
#undef MCV_X
};

enum { MCV_SHAPE_GAUSSIAN, MCV_SHAPE_COSINE };
enum { MCV_PROFILE_V, MCV_PROFILE_U };

#define MCV_DEFECT_DENT_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "diameter: gaussian, at 1/e² of the depth; cosine, of the rim [m]") \
    X(length, depth, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "depth in the middle; by default a tenth of the size [m]") \
    X(choice, shape, 0, 0, 1, "its law: gaussian or cosine")

#define MCV_DEFECT_BUMP_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "diameter: gaussian, at 1/e² of the height; cosine, of the rim [m]") \
    X(length, depth, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "height in the middle; by default a tenth of the size [m]") \
    X(choice, shape, 0, 0, 1, "its law: gaussian or cosine")

#define MCV_DEFECT_SCRATCH_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "width between the shoulders [m]") \
    X(length, depth, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "depth in the middle; by default a tenth of the size [m]") \
    X(length, length, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "length, the fading ends included; by default 20 times the size [m]") \
    X(choice, profile, 0, 0, 1, "its cross-section: V or U") \
    X(number, pileUp, 0, 0, 1, "share of the groove's volume that stands beside it")

#define MCV_DEFECT_BUBBLE_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter [m]") \
    X(number, ior, 1, 1, 10, "index of refraction of the gas")

#define MCV_DEFECT_INCLUSION_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter [m]")

#define MCV_DEFECT_STRIA_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "diameter at 1/e² of the step of the index [m]") \
    X(length, length, MCV_UNSET, MCV_POSITIVE, 1e3, "length; by default 20 times the size [m]") \
    X(number, indexStep, 1e-4, -0.5, 0.5, "how much larger the index is in the middle") \
    X(integer, tubes, 8, 1, 64, "number of nested tubes of constant index")

#define MCV_DEFECT_DIG_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter of the rim [m]") \
    X(length, depth, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "depth in the middle, below half of the size; by default a tenth of the size [m]")

#define MCV_DEFECT_BURR_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "width of its foot [m]") \
    X(length, depth, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "height in the middle; by default a tenth of the size [m]") \
    X(length, length, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "length, the fading ends included; by default 20 times the size [m]")

#define MCV_DEFECT_CHIP_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter of the ball [m]") \
    X(length, depth, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "how far below the middle the ball reaches; by default, and at most, half of the size [m]")

#define MCV_DEFECT_MISSING_PART_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "how far below the middle the plane lies [m]")

#define MCV_DEFECT_STAIN_PARAMS(X) X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter [m]")

#define MCV_DEFECT_ROUGH_PATCH_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter [m]") \
    X(number, roughness, MCV_REQUIRED, 0, 1, "roughness of the material within")

#define MCV_DEFECT_CRACK_PARAMS(X) \
    X(length, size, MCV_REQUIRED, MCV_POSITIVE, 1e3, "diameter [m]") \
    X(length, opening, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "distance of its faces; by default a hundredth of the size [m]") \
    X(number, ior, 1, 1, 10, "index of refraction of what fills it")

#endif
