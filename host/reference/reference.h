/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The reference renderer: double precision, plain C, simple and slow, written from the report's
 * formulas. It shares no mathematics, sampler or acceleration structure with the kernels, and reads
 * the scene before re-centring and packing. Its contracts are those of mcv_render and mcv_trace
 * (host/render/render.h).
 *
 * Samples are independent and random, whatever options->sampler says; schedule, slice and device
 * have no effect. Rounds have 1, 1, 2, 4 … samples per replicate. The error is used from 16 samples
 * on. A round that would exceed options->seconds is not started. Coincident surfaces of bodies, up
 * to the rounding of float32 vertices, are hit together.
 */
#ifndef MCVISI_HOST_REFERENCE_REFERENCE_H
#define MCVISI_HOST_REFERENCE_REFERENCE_H

#include "render/render.h"

mcv_result mcv_reference_render(const mcv_scene *scene, uint32_t sensor,
                                const mcv_render_options *options, mcv_film *film,
                                mcv_render_stats *stats, mcv_error *error);

/*
 * A picture for the eye, soon: one pixel of the film stands for stride x stride (1 or more) of the
 * sensor, of which each sample takes one at random. Rough materials scatter by coarse tables
 * (reference/gloss.h). All the rest is as in mcv_reference_render, values that are not finite
 * excepted: they count as 0.
 */
mcv_result mcv_reference_draft(const mcv_scene *scene, uint32_t sensor,
                               const mcv_render_options *options, uint32_t stride, mcv_film *film,
                               mcv_error *error);

mcv_result mcv_reference_trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                               const mcv_render_options *options, mcv_vertex **vertices,
                               size_t *vertex_count, mcv_error *error);

#endif
