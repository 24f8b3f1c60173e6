/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Path tracing from the sensor. A path carries L/n², so that smooth interfaces multiply it by their
 * transmittances only; its value is n_sensor² Σ throughput · L_e/n_emitter². At an interface the
 * branch is chosen with Fresnel's probability. At scattering surfaces area and parallel emitters
 * are sampled too; the power heuristic weighs both estimates (Veach 1997).
 */
#ifndef MCVISI_HOST_REFERENCE_PATH_H
#define MCVISI_HOST_REFERENCE_PATH_H

#include "reference/emission.h"
#include "reference/gloss.h"
#include "reference/media.h"
#include "reference/sensor_ray.h"
#include "render/render.h"

typedef struct ref_world {
    const mcv_scene *scene;
    ref_geometry geometry;
    ref_emitters emitters;
    ref_gloss_tables gloss;
    ref_media media; /* around the sensor */
    uint32_t depth;  /* largest number of surfaces on a path; no ray is traced after the last one */
    bool sample_emitters;
} ref_world;

/* Statistics of paths. */
typedef struct ref_tally {
    uint64_t paths, rays, shadow_rays, depth_cut, nonfinite, unmatched;
    double begun, cut; /* throughput of the paths begun and of those that the depth limit ended,
                          largest channel, times the sensor's weight */
} ref_tally;

/* Coincident surfaces that a path hits together. */
typedef struct ref_hits {
    uint32_t count, instances[REF_SKIPS];
    bool fronts[REF_SKIPS];
    ref_skip numbers;
} ref_hits;
ref_hits ref_hits_at(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                     const ref_skip *skip, const ref_hit *hit);

/* Who is told of the light that a path finds (reference/trail.h). */
typedef struct ref_trail ref_trail;

/* Traces one camera ray: its contribution to the pixel, the incident radiance times its weight.
 * trail: NULL, or what is told of it. */
void ref_path_value(const ref_world *world, const ref_sensor_ray *sensor_ray, ref_random *random,
                    ref_tally *tally, ref_trail *trail, double value[3]);

/* mcv_reference_render (reference.h). Without sample_emitters, emission is found by hits only: the
 * same image with more noise. */
mcv_result ref_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      bool sample_emitters, mcv_film *film, mcv_render_stats *stats,
                      mcv_error *error);

#endif
