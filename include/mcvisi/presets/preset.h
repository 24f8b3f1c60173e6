/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all presets share: lights as a catalogue sells them. A preset is a type of emitter that the
 * loader makes of geometry and an area emitter, or with `halfAngle` a parallel one;
 * host/loader/load_presets.c builds it, and kernels know nothing of it. It stands on a node without
 * a mesh and shines along the node's -z; its size does not scale with the node. What does not emit
 * of it absorbs.
 *
 * `radiance` is that of the emitting surface, `power` all that leaves it, per channel, counted
 * before any of it falls back on the light.
 *
 * A preset is one header with MCV_<NAME>_PARAMS(X), a line in MCV_PRESETS (mcvisi/elements.h) and
 * its builder.
 */
#ifndef MCVISI_PRESETS_PRESET_H
#define MCVISI_PRESETS_PRESET_H

#include "mcvisi/params.h"

#define MCV_PRESET_PARAMS(X) \
    X(spectrum, radiance, MCV_UNSET, 0, 1e30, "radiance L of what shines [W/(m² sr)]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power of all that shines, in place of radiance [W]")

/* For those that may be directed. */
#define MCV_DIRECTED_PRESET_PARAMS(X) \
    X(angle, halfAngle, MCV_UNSET, MCV_POSITIVE, 1.5707963267948966, \
      "half-angle β of the cone into which every point emits; a diffuse light without it [rad]") \
    MCV_PRESET_PARAMS(X)

#endif
