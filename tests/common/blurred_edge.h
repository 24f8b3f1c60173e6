/* SPDX-License-Identifier: Apache-2.0 */
/* An edge out of focus, and how well its blur tells its depth, in closed form. */
#ifndef MCVISI_TESTS_BLURRED_EDGE_H
#define MCVISI_TESTS_BLURRED_EDGE_H

#include <math.h>
#include <stdbool.h>

/* A black half plane before the sky, out of the focus of a thin lens: b = 20 mm, w = 180 mm, a
 * radius of 4 mm. */
#define EDGE \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}]," \
    "\"extensionsUsed\":[\"MCVISI_materials\",\"MCVISI_emitters\",\"MCVISI_sensors\"]," \
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"thinLens\"," \
    "\"focalLength\":0.018,\"imageDistance\":0.02,\"lensDiameter\":0.008," \
    "\"resolution\":[48,16],\"pixelSize\":2e-5}]},\"MCVISI_emitters\":{\"emitters\":[{" \
    "\"name\":\"sky\",\"type\":\"environment\",\"radiance\":1}]}}," \
    "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64," \
    "CtejvArXo7wAAAAACtejPArXo7wAAAAACtejPArXozwAAAAACtejvArXozwAAAAAAAABAAIAAAACAAMA\"}]," \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48," \
    "\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126," \
    "\"count\":4,\"type\":\"VEC3\",\"min\":[-0.02,-0.02,0],\"max\":[0.02,0.02,0]}," \
    "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}]," \
    "\"materials\":[{\"extensions\":{\"MCVISI_materials\":{\"type\":\"absorber\"}}}]," \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1," \
    "\"material\":0}]}]," \
    "\"nodes\":[{\"name\":\"plate\",\"mesh\":0,\"translation\":[0.02,0,-0.12]}," \
    "{\"name\":\"cam\",\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{\"name\":\"sky\"," \
    "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}"

/*
 * The Cramér-Rao bound of the edge's depth [m] for a radius of the lens [m] and noise relative to
 * the sky's light. An edge is blurred by the marginal f(x/s)/s of the aperture, s = b r (1/z -
 * 1/w)/p pixels wide: its derivative by s has the square (I²/s) ∫ f² u² du, which is 16/π² 2/15 for
 * a half disc and half of that for a disc. 16 rows see it.
 */
static inline double edge_bound(double radius, bool half, double noise) {
    const double per = radius * 0.02 / 2e-5, slope = per / (0.12 * 0.12),
                 s = per * (1 / 0.12 - 1 / 0.18), c = 16 / (M_PI * M_PI) * 2 / 15 / (half ? 1 : 2);
    return noise / slope * sqrt(s / (16 * c));
}

#endif
