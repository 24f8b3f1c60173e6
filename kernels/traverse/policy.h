/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which way the rays go through the hierarchy in the tile schedule, chosen once for the renderer
 * and for what measures it: in bundles, where those that are left alone take turns if the scene is
 * large.
 */
#ifndef MCVISI_KERNELS_POLICY_H
#define MCVISI_KERNELS_POLICY_H

#include "traverse/trace_packet.h"

#if MCV_WITH_INTERLEAVE
#define MCV_TRACE_CLOSEST mcv_intersect_closest_interleaved
#define MCV_TRACE_ANY mcv_intersect_any_interleaved
#else
#define MCV_TRACE_CLOSEST mcv_intersect_closest_packets
#define MCV_TRACE_ANY mcv_intersect_any_packets
#endif

#endif
