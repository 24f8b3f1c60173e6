/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The reference renderer: double precision, plain C, simple and slow, written from the report's
 * formulas. It shares nothing of the kernels' mathematics, samplers or acceleration structure; it
 * reads the scene before re-centring and packing. Same contracts as mcv_render and mcv_trace
 * (host/render/render.h).
 *
 * Samples are independent and random, whatever options->sampler says; schedule, slice and device
 * have no meaning here. Rounds hold 1, 1, 2, 4 … samples per replicate; an error is believed from
 * 16 samples on; a round that would not end within options->seconds is not begun. Bodies' surfaces
 * in the same place, to the rounding of float32 vertices, are met together.
 */
#ifndef MCVISI_HOST_REFERENCE_REFERENCE_H
#define MCVISI_HOST_REFERENCE_REFERENCE_H

#include "render/render.h"

mcv_result mcv_reference_render(const mcv_scene *scene, uint32_t sensor,
                                const mcv_render_options *options, mcv_film *film,
                                mcv_render_stats *stats, mcv_error *error);
mcv_result mcv_reference_trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                               const mcv_render_options *options, mcv_vertex **vertices,
                               size_t *vertex_count, mcv_error *error);

#endif
