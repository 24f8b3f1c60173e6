/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all presets share. Presets are lights as catalogues offer them. A preset is a type of
 * emitter that host/loader/load_presets.c builds from geometry and an area emitter, or with
 * `halfAngle` a parallel one; kernels do not know it. It stands on a node without a mesh and emits
 * along the node's -z. Its size does not scale with the node. Its other surfaces absorb.
 *
 * `radiance` is that of the emitting surface. `power` is all that leaves this surface, per channel,
 * including what falls back on the light.
 *
 * A preset is one header with MCV_<NAME>_PARAMS(X), a line in MCV_PRESETS (mcvisi/elements.h) and
 * its builder.
 */
#ifndef MCVISI_PRESETS_PRESET_H
#define MCVISI_PRESETS_PRESET_H

#include "mcvisi/params.h"

#define MCV_PRESET_PARAMS(X) \
    X(spectrum, radiance, MCV_UNSET, 0, 1e30, "radiance L of the emitting surface [W/(m² sr)]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, \
      "power of the emitting surface, in place of radiance [W]")

/* For presets that may be directed. */
#define MCV_DIRECTED_PRESET_PARAMS(X) \
    X(angle, halfAngle, MCV_UNSET, MCV_POSITIVE, 1.5707963267948966, \
      "half-angle β of the cone into which every point emits; without it the light is diffuse " \
      "[rad]") \
    MCV_PRESET_PARAMS(X)

#endif
