/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shading classes, and the tile schedule's loops over them. The class of a path is what is
 * known of its surface while the program is compiled: of which geometry it is, and its BSDF. A loop
 * over the paths of a class calls the functions that the stages call for one path
 * (stage/shade_hit.h), with the class as a constant: they hold no conditional jumps then, and the
 * loop is vectorised.
 *
 * The order of the list is the order of the slots after mcv_sort_paths: the paths of class c have
 * the slots mcv_class_begin(class_end, c) … class_end[c] - 1. Neighbours are one range wherever
 * that serves: MCV_LAST_… names the ends of what the loops ask for.
 */
#ifndef MCVISI_KERNELS_RANGES_H
#define MCVISI_KERNELS_RANGES_H

#include "schedule/tile.h"

#include "bsdf/shading.h"

/*
 * X(name, exact, bsdf, joined, A). exact: 1 if the surface is a solid's, not a triangle. bsdf:
 * MCV_SHADING_…, as the host has found it. joined: how many classes, this one the last of them, one
 * loop shades; 0: another class's loop does, or none. A: for X to use.
 *
 * The glossy classes hold one material of a slice, so that its table is read once; glossy paths on
 * other materials are of the classes TRIANGLE and EXACT.
 */
#define MCV_SHADING_CLASSES(X, A) \
    X(SMOOTH_TRIANGLE, 0, SMOOTH, 1, A) \
    X(SMOOTH_EXACT, 1, SMOOTH, 1, A) \
    X(DIFFUSE_EXACT, 1, DIFFUSE, 1, A) \
    X(GLOSSY_EXACT, 1, GLOSSY, 0, A) \
    X(GLOSSY_TRIANGLE, 0, GLOSSY, 2, A) \
    X(DIFFUSE_TRIANGLE, 0, DIFFUSE, 1, A) \
    X(TRIANGLE, 0, ANY, 0, A) \
    X(EXACT, 1, ANY, 0, A)

#define MCV_NAME_CLASS(name, exact, bsdf, joined, A) MCV_CLASS_##name,
enum {
    MCV_SHADING_CLASSES(MCV_NAME_CLASS, )
    /* Not sorted: these paths end first (schedule/terminate_paths.h). */
    MCV_CLASS_MISS,
    MCV_CLASS_COUNT,
    MCV_CLASS_BLACK = MCV_CLASS_COUNT /* an absorber; plus 1 + emitter: that emitter's lamp */
};

/* What follows from the order: class_end of these is where the slots end of … */
enum {
    MCV_LAST_SMOOTH_TRIANGLE = MCV_CLASS_SMOOTH_TRIANGLE, /* smooth triangles, */
    MCV_LAST_SMOOTH = MCV_CLASS_SMOOTH_EXACT, /* and all smooth bodies: they sample no emitter and
                                                 draw no direction, the others may */
    MCV_LAST_DIFFUSE_EXACT = MCV_CLASS_DIFFUSE_EXACT, /* diffuse exact surfaces; then all glossy */
    MCV_LAST_KNOWN_EXACT = MCV_CLASS_GLOSSY_EXACT,    /* exact surfaces but those of EXACT */
    MCV_LAST_GLOSSY = MCV_CLASS_GLOSSY_TRIANGLE,      /* glossy surfaces; none after these splits */
    MCV_LAST_KNOWN = MCV_CLASS_DIFFUSE_TRIANGLE, /* what has a known BSDF; the others are shaded
                                                    one by one */
    MCV_LAST_TRIANGLE = MCV_CLASS_TRIANGLE,      /* triangles */
    MCV_LAST_CLASS = MCV_CLASS_EXACT             /* all paths that are still under way */
};

MCV_LOOP_FUNCTION uint mcv_class_begin(const uint *class_end, uint class) {
    return class > 0u ? class_end[class - 1u] : 0u;
}

/* Which BSDFs the program has loops for. In a scene without, their paths are of the classes
 * TRIANGLE and EXACT. */
#define MCV_KNOWS_SMOOTH MCV_HAS_SMOOTH
#define MCV_KNOWS_DIFFUSE (MCV_HAS_PLAIN && MCV_WITH_DIFFUSE)
#define MCV_KNOWS_GLOSSY (MCV_HAS_PLAIN && MCV_WITH_GLOSSY)
#define MCV_KNOWS_ANY 0

/*
 * MCV_EACH_RANGE(RANGE) is RANGE(bsdf, first, last, shading) for each loop of the list, bsdf and
 * shading known to the compiler. It uses the caller's world, class_end and glossy_material: the
 * material of the glossy classes, or MCV_NONE.
 */
#define MCV_EACH_RANGE(RANGE) MCV_SHADING_CLASSES(MCV_RANGE, RANGE)
#define MCV_RANGE(name, exact, bsdf, joined, RANGE) \
    if (MCV_KNOWS_##bsdf && joined > 0 && (MCV_WITH_SURFACES || !exact)) \
    MCV_RANGE_##bsdf(mcv_class_begin(class_end, MCV_CLASS_##name + 1u - joined), \
                     class_end[MCV_CLASS_##name], exact, RANGE)
#define MCV_RANGE_ANY(first, last, exact, RANGE) \
    {}
#define MCV_RANGE_SMOOTH(first, last, exact, RANGE) \
    RANGE(MCV_SHADING_SMOOTH, first, last, \
          mcv_shading_of(MCV_SHADING_SMOOTH, exact, MCV_WITH_SPLIT))
#define MCV_RANGE_DIFFUSE(first, last, exact, RANGE) \
    RANGE(MCV_SHADING_DIFFUSE, first, last, mcv_shading_of(MCV_SHADING_DIFFUSE, exact, 0))
#if MCV_KNOWS_GLOSSY
#define MCV_RANGE_GLOSSY(first, last, exact, RANGE) \
    if (glossy_material != MCV_NONE) { \
        const int turns = MCV_WITH_ANISOTROPY && world.glossy[glossy_material].azimuths > 1u; \
        if (!turns) MCV_RANGE_OF_TURN(0, first, last, RANGE) \
        if (turns) MCV_RANGE_OF_TURN(1, first, last, RANGE) \
    }
/* turns: whether the material has a direction. */
#define MCV_RANGE_OF_TURN(turns, first, last, RANGE) \
    { \
        const mcv_device_glossy from = mcv_plain_glossy(world, glossy_material, turns); \
        const mcv_shading glossy = mcv_glossy_shading(world, glossy_material, &from); \
        if (MCV_WITH_METAL) MCV_RANGE_OF_TYPE(MCV_MATERIAL_CONDUCTOR, first, last, RANGE) \
        if (MCV_WITH_METALLIC) \
            MCV_RANGE_OF_TYPE(MCV_MATERIAL_METALLIC_ROUGHNESS, first, last, RANGE) \
        if (MCV_WITH_ROUGH_GLASS) MCV_RANGE_OF_TYPE(MCV_MATERIAL_DIELECTRIC, first, last, RANGE) \
    }
#define MCV_RANGE_OF_TYPE(TYPE, first, last, RANGE) \
    if (glossy.type == TYPE) RANGE(MCV_SHADING_GLOSSY, first, last, mcv_shading_as(glossy, TYPE))
#else
#define MCV_RANGE_GLOSSY(first, last, exact, RANGE) \
    {}
#endif

#endif
