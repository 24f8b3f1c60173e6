/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rendering one sensor of a scene into a film, by OpenCL (host/render/render.c) or by the reference
 * renderer (host/reference/reference.h): same options, same statistics.
 */
#ifndef MCVISI_HOST_RENDER_RENDER_H
#define MCVISI_HOST_RENDER_RENDER_H

#include "film/film.h"
#include "mcvisi/events.h"
#include "scene/scene.h"

enum { MCV_SAMPLER_SOBOL, MCV_SAMPLER_RANDOM };
enum { MCV_SCHEDULE_AUTO, MCV_SCHEDULE_TILE, MCV_SCHEDULE_STREAM };

/*
 * Single: all in float32. Mixed: smooth surfaces are found so, and where rays meet them and how
 * they go on is worked out in double; the device must have double precision. Double is the
 * reference renderer's (reference/reference.h).
 */
enum { MCV_PRECISION_SINGLE, MCV_PRECISION_MIXED, MCV_PRECISION_DOUBLE };

/*
 * Told after every pass; false stops the render, keeping the rounds that are whole. Told before the
 * kernels are compiled, too, which may take longer than the render: fraction is NaN then, and false
 * is heeded at the next pass only.
 */
typedef bool mcv_pass_told(void *user, double fraction, double seconds, double error);

typedef bool mcv_enough(void *user, const mcv_film *film);

typedef struct mcv_render_options {
    uint32_t sampler;    /* MCV_SAMPLER_… */
    uint32_t replicates; /* 1 … 64, default 4 */
    uint32_t seed;
    uint32_t depth;       /* surfaces a path may meet, default 32 */
    uint32_t schedule;    /* MCV_SCHEDULE_… */
    uint32_t precision;   /* MCV_PRECISION_SINGLE or MIXED */
    uint64_t first, last; /* sample range per replicate: [0, 2^k) or an aligned power of two; last =
                             0: until error or time */
    double error;         /* stop at this relative error; 0: never */
    double seconds;       /* stop after this time; 0: never */
    uint32_t threads;     /* of the reference; 0: all */
    bool no_light_paths;  /* leave all light to camera paths */
    bool no_split;        /* of what reflects and passes light, follow one by chance */
    bool adaptive;        /* more samples for pixels that need more, if it pays */
    uint32_t slice;       /* paths per slice of the tile schedule, a multiple of 64; 0: default */
    const char *device;   /* NULL: the first; see mcv_cl_open */
    mcv_pass_told *progress;
    mcv_enough *enough; /* asked after each round from the fourth sample of each replicate on: true
                           ends the render; may be NULL */
    void *user;
} mcv_render_options;

mcv_render_options mcv_render_defaults(void);

enum { MCV_MAX_STAGES = 16 };

typedef struct mcv_render_stats {
    char device[256];
    char driver[256];   /* its version; empty for the reference */
    char features[256]; /* names, separated by spaces */
    uint64_t paths;     /* begun */
    uint64_t rays, shadow_rays;
    uint64_t depth_cut; /* paths ended by the depth limit */
    double lost_energy; /* their throughput over that of all paths begun: the share of the light
                           that may be missing */
    uint64_t nonfinite; /* samples dropped because they were not finite */
    uint64_t unmatched; /* exits from a medium that the path had not entered */
    uint64_t saturated; /* light paths that a pixel's sum had no room for */
    double seconds_build, seconds_compile, seconds_first_sample, seconds_render;
    bool kept_structure, kept_program; /* of the render before (mcv_renderer) */
    uint32_t stage_count; /* the tile schedule has all its stages in one kernel; the reference has
                             none */
    struct {
        const char *name;
        double seconds; /* on the device */
    } stages[MCV_MAX_STAGES];
    bool interrupted;
} mcv_render_stats;

/*
 * Renders until options->last samples, the error, or the time is reached, whichever is first. The
 * film is made here (with the scene's channels); on failure it is empty.
 */
mcv_result mcv_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      mcv_film *film, mcv_render_stats *stats, mcv_error *error);

/*
 * The samples per replicate of the round after the first `done`, in a render that may take
 * `seconds` of which `elapsed` have passed (0: as long as it likes): a power of two that divides
 * `done`, at most as many as there are, and with a limit as many as are expected to end before it
 * at `per_sample` seconds each; `least` or more. 0: none fit, or too few to be worth it, when 0.8
 * of the time have passed.
 */
uint64_t mcv_next_round(uint64_t done, uint64_t least, double per_sample, double elapsed,
                        double seconds);

/* MCV_FAILED where more than one sample in a million was not finite: too much of the image would be
 * missing. */
mcv_result mcv_render_check_finite(const mcv_scene *scene, uint32_t sensor,
                                   const mcv_render_stats *stats, mcv_error *error);

/*
 * The same again and again: the device, its programs and what of the scene has not changed since
 * the render before (acceleration structure, vertices, textures) are kept. The bits are those of
 * mcv_render. NULL without memory.
 */
typedef struct mcv_renderer mcv_renderer;
mcv_renderer *mcv_renderer_new(void);
mcv_result mcv_renderer_render(mcv_renderer *renderer, const mcv_scene *scene, uint32_t sensor,
                               const mcv_render_options *options, mcv_film *film,
                               mcv_render_stats *stats, mcv_error *error);
void mcv_renderer_free(mcv_renderer *renderer);

/* One vertex of a traced path; see mcv_trace. */
typedef struct mcv_vertex {
    uint32_t ray, index; /* which given ray, which vertex along it (0: its start) */
    double position[3];  /* [m], world */
    double
        normal[3]; /* interpolated, on the side the ray came from; 0 at the start and on a miss */
    double direction[3];  /* unit, in which the path goes on; 0 where it ends */
    double distance;      /* from the vertex before [m]; infinite on a miss */
    uint32_t triangle;    /* global number, MCV_NONE at the start and on a miss */
    uint32_t event;       /* MCV_EVENT_… */
    double ior;           /* of the medium in which the path goes on */
    double transmittance; /* product of the interfaces' transmittances (reflectances after total
                             reflection) and absorption so far, first channel */
    double radiance;      /* L/n² that this vertex emits along the path, first channel */
} mcv_vertex;

typedef struct mcv_trace_ray {
    double origin[3], direction[3]; /* world; the direction need not be unit */
} mcv_trace_ray;

/*
 * Follows each ray through smooth surfaces, always refracted where it can be, else totally
 * reflected (mirrors reflect, sheets pass), until it ends or has met `depth` surfaces. The rays
 * start in the medium that surrounds their origin (by parity). *vertices is malloc'ed, in the order
 * of the rays; the caller frees it.
 */
mcv_result mcv_trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                     const mcv_render_options *options, mcv_vertex **vertices, size_t *vertex_count,
                     mcv_error *error);

/* Refuses options that make no sense, before any work. `device` adds the rules of the device
 * renderer. MCV_USAGE, or MCV_BAD_INPUT for a scene without a sensor. */
mcv_result mcv_render_check_options(const mcv_scene *scene, uint32_t sensor,
                                    const mcv_render_options *options, bool device,
                                    mcv_error *error);

#endif
