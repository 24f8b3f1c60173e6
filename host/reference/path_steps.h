/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a path of the reference renderer, and its steps (reference/path.c); only they use
 * it. */
#ifndef MCVISI_HOST_REFERENCE_PATH_STEPS_H
#define MCVISI_HOST_REFERENCE_PATH_STEPS_H

#include "reference/interface.h"
#include "reference/path.h"

typedef struct ref_path {
    ref_vec origin, direction;
    ref_skip skip; /* the surfaces it starts on */
    ref_media media;
    double throughput[3];
    double density;   /* density of its direction if emitters were sampled too [1/sr]; else 0:
                         emission has full weight */
    ref_trail *trail; /* or NULL */
} ref_path;

static inline void ref_multiply(double a[3], const double b[3]) {
    for (int channel = 0; channel < 3; ++channel) a[channel] *= b[channel];
}

static inline double ref_largest(const double a[3]) { return fmax(a[0], fmax(a[1], a[2])); }

/* The channel of a path that carries only one. */
static inline int ref_kept_channel(const ref_path *p) {
    return p->throughput[1] > 0 ? 1 : p->throughput[2] > 0 ? 2 : 0;
}

/* The weight of a direction that was sampled with one density and could have been sampled with the
 * other: the power heuristic of exponent 2. */
static inline double ref_weight_against(double own, double other) {
    const double ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

typedef struct ref_scatterer ref_scatterer;

/* f cosθ of a surface for light that arrives from i, as a share of L/n²; returns the density with
 * which the surface chooses i [1/sr]. The frame is the surface's, z its normal on the side of o. */
typedef double ref_evaluate(const ref_scatterer *s, ref_vec i, double value[3]);
typedef ref_vec ref_sample(const ref_scatterer *s, ref_random *random);

/* A scattering surface at a hit. */
struct ref_scatterer {
    const mcv_material *material;
    ref_interaction interaction;
    double share[3];        /* diffuse: its reflectance there … */
    double passed[3];       /* … and its transmittance */
    const ref_media *near;  /* media around light on the path's side … */
    ref_media far;          /* … and on the other */
    double from, to;        /* of an interface: the indices there, of the channel that goes on */
    ref_evaluate *evaluate; /* what describes the material, or NULL … */
    ref_sample *sample;     /* … and chooses directions by it; NULL: by the cosine */
    ref_gloss gloss;        /* of microfacets, in this frame, seen from o: */
    ref_vec x, y, o;
};

const ref_emitter *ref_sampled_emitter(const ref_world *world, uint32_t instance);

/* path_scatter.c */

/* The frame of a surface of microfacets: its first axis is the rougher direction. */
void ref_find_frame(const ref_surface *surface, ref_scatterer *s);

/* Samples emitters, then continues the path or ends it (false). */

bool ref_scatter(const ref_world *world, ref_path *p, const ref_surface *surface,
                 const ref_scatterer *s, bool last, ref_random *random, ref_tally *tally,
                 double radiance[3]);

/* path_surface.c: continues the path at a surface or ends it (false). */

bool ref_meet_surface(const ref_world *world, ref_path *p, const ref_surface *surface,
                      const ref_hits *hits, bool last, ref_random *random, ref_tally *tally,
                      double radiance[3]);

#endif
