/* SPDX-License-Identifier: Apache-2.0 */
/* The paths that bring light to one pixel, by the reference renderer. */
#ifndef MCVISI_HOST_REFERENCE_EXPLAIN_H
#define MCVISI_HOST_REFERENCE_EXPLAIN_H

#include "render/render.h"

/* X(WAY, "word"): what a surface has done to the path. */
#define MCV_WAYS(X) \
    X(SCATTERS, "scatters") \
    X(REFLECTS, "reflects") \
    X(REFRACTS, "refracts") \
    X(PASSES, "passes")
enum {
#define MCV_X(WAY, word) MCV_WAY_##WAY,
    MCV_WAYS(MCV_X)
#undef MCV_X
};

/* So many surfaces of a path are kept, from the sensor on. */
enum { MCV_PATH_SURFACES = 24 };

/* Light that one path brings, as it is found. */
typedef struct mcv_contribution {
    uint32_t replicate;
    uint32_t surface_count; /* may be above MCV_PATH_SURFACES */
    struct {
        double position[3]; /* [m], world */
        uint32_t instance;
        uint32_t way; /* MCV_WAY_… */
    } surfaces[MCV_PATH_SURFACES];
    double sensor[3]; /* where the path meets the lens */
    uint32_t emitter; /* index in the scene */
    double from[3];   /* where it sends the light; of a far one, the direction to it */
    bool is_far;
    bool has_pixel;    /* whether a pixel of the emitter's image sends the light: */
    uint32_t pixel[2]; /* column, row */
    double value[3];   /* that the pixel gets */
} mcv_contribution;

typedef void mcv_contribution_told(void *user, const mcv_contribution *contribution);

/*
 * Traces the paths of one pixel, `samples` of each of the options' replicates, and tells of all
 * light that they bring: the sum over all, divided by samples and replicates, is the pixel's value.
 * As in mcv_reference_render, there are no light paths: caustics of lights without extent are
 * missing.
 */
mcv_result mcv_reference_explain(const mcv_scene *scene, uint32_t sensor,
                                 const mcv_render_options *options, const uint32_t pixel[2],
                                 uint64_t samples, mcv_contribution_told *told, void *user,
                                 mcv_error *error);

#endif
