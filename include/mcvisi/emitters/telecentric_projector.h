/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Telecentric projector (type "telecentricProjector"; report 4.1.2): a rectangle of equal pixels.
 * Each emits its own radiance, L times the image's value, into the cone of half-angle β about the
 * rectangle's normal, as the parallel emitter does. A pixel is uniform, nothing is interpolated.
 *
 * In the node's frame (x right, y up, emitting along -z) row 0 of the image lies at +y and column 0
 * at -x. On a wall it reads right from behind the projector, and mirrored for an observer who looks
 * into it. "mirror": true flips the columns.
 *
 * `image` is the index or the name of one of the file's images (PNG or JPEG, decoded from sRGB to
 * linear values 0 to 1), or {"uri": "pattern.exr"} beside the scene (linear, any value from 0).
 * `pattern` with `index` replaces it (mcvisi/pattern.h). Power is that of the whole rectangle, per
 * channel: Φ = π L sin²β A times the image's mean.
 *
 *     {"type": "telecentricProjector", "image": "stripes", "size": ["32mm", "20mm"],
 *      "halfAngle": "0.5deg", "radiance": 1}
 *
 * On the device it is a parallel emitter with a texture on its rectangle.
 */
#ifndef MCVISI_EMITTERS_TELECENTRIC_PROJECTOR_H
#define MCVISI_EMITTERS_TELECENTRIC_PROJECTOR_H

#include "mcvisi/emitters/emitter.h"

#define MCV_TELECENTRIC_PROJECTOR_PARAMS(X) \
    X(angle, halfAngle, MCV_REQUIRED, MCV_POSITIVE, 1.5707963267948966, \
      "half-angle β of the emission cone [rad]") \
    MCV_PATTERN_PARAMS(X) \
    X(flag, mirror, 0, 0, 1, "column 0 at +x instead of -x")

#endif
