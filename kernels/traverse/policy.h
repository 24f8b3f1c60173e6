/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which way the rays go through the hierarchy in the tile schedule, chosen once for the renderer and for what measures it:
 * in bundles, where those that are left alone take turns if the scene is large.
 */
#ifndef MCVISI_WAYS_H
#define MCVISI_WAYS_H

#include "traverse/packet.h"

#if MCV_WITH_INTERLEAVE
#define MCV_CLOSEST_MANY mcv_intersect_closest_turns
#define MCV_ANY_MANY mcv_intersect_any_turns
#else
#define MCV_CLOSEST_MANY mcv_intersect_closest_bundles
#define MCV_ANY_MANY mcv_intersect_any_bundles
#endif

#endif
