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
 * Single: all in float32. Mixed: smooth surfaces are found in float32; hits on them and the
 * directions behind them are computed in double, which the device must support. Double: the
 * reference renderer (reference/reference.h).
 */
enum { MCV_PRECISION_SINGLE, MCV_PRECISION_MIXED, MCV_PRECISION_DOUBLE };

/*
 * Called after every launch, or every pass of a render that is saved. Returning false stops the
 * render; it keeps its complete rounds, of which one with records has none. It is also called
 * before the kernels are compiled, which may take longer than the render: fraction is then NaN, and
 * false takes effect at the next call.
 */
typedef bool mcv_pass_told(void *user, double fraction, double seconds, double error);

/* Takes a coarse picture of radiances for the eye: one pixel for stride x stride of the film. */
typedef void mcv_picture_told(void *user, const mcv_image *picture, uint32_t stride);

/* Called where the kernels came from a cache, before they run. */
typedef void mcv_kernels_cached(void *user);

typedef bool mcv_enough(void *user, const mcv_film *film);

/* Takes a sentence for the user, about what the render goes on without. */
typedef void mcv_warned(void *user, const char *sentence);

/* When noisier pixels get more samples: if that takes fewer of them by a tenth for an error; or
 * only if it takes fewer by a quarter, and so less time even where those of noisy pixels take
 * longer. */
enum { MCV_ADAPTIVE_OFF, MCV_ADAPTIVE_ON, MCV_ADAPTIVE_AUTO };

/*
 * Takes the records of a launch (kernels/stage/record_light.h), MCV_RECORD_WORDS of the channels
 * each, in any order. Another result than MCV_OK ends the render with it.
 */
typedef mcv_result mcv_records_told(void *user, const uint32_t *records, size_t count,
                                    mcv_error *error);

typedef struct mcv_record_sink {
    mcv_records_told *take;
    void *user;
    size_t bytes; /* room for the records of a launch; 0: default. A launch that makes more is
                     repeated in parts. */
} mcv_record_sink;

typedef struct mcv_render_options {
    uint32_t sampler;    /* MCV_SAMPLER_… */
    uint32_t replicates; /* 1 … 64, default 4 */
    uint32_t seed;
    uint32_t depth;       /* largest number of surfaces on a path, default 32 */
    uint32_t schedule;    /* MCV_SCHEDULE_… */
    uint32_t precision;   /* MCV_PRECISION_SINGLE or MIXED */
    uint64_t first, last; /* sample range per replicate: [0, 2^k) or an aligned power of two; last =
                             0: until error or time */
    double error;         /* stop at this relative error; 0: never */
    double seconds;       /* stop after this time; 0: never */
    uint32_t threads;     /* threads of the reference renderer; 0: all */
    bool no_light_paths;  /* no light tracing */
    bool light_pilot;     /* trace as many light paths as a pilot finds worth their time, or none */
    bool no_split;        /* follow reflection or transmission at random, not both */
    uint32_t adaptive;    /* MCV_ADAPTIVE_…: more samples for noisier pixels, if it pays */
    uint32_t slice;       /* paths per slice of the tile schedule, a multiple of 64; 0: default */
    const char *device;   /* NULL: the first; see mcv_cl_open; or several, "A,B" */
    mcv_warned *warned;   /* may be NULL */
    mcv_pass_told *progress;
    mcv_kernels_cached *cached; /* may be NULL */
    mcv_picture_told *picture;  /* called once, before the first round of a render that will not be
                                   done in a moment; may be NULL */
    mcv_enough *enough; /* called after each round from the fourth sample of each replicate on: true
                           ends the render; may be NULL */
    const struct mcv_render_saving *saving; /* saves the unfinished render (render/unfinished.h); or
                                               NULL */
    const struct mcv_unfinished *resume;    /* go on with it; NULL: from the beginning */
    void *user;
    const mcv_record_sink *records; /* or NULL; with it the film lacks light paths, whose light is
                                       in the records alone */
} mcv_render_options;

mcv_render_options mcv_render_defaults(void);

enum { MCV_MAX_STAGES = 16 };

typedef struct mcv_render_stats {
    char device[256];   /* with several, their names joined by " + " */
    char driver[256];   /* its version; empty for the reference; of the first device */
    char features[512]; /* names, separated by spaces */
    uint64_t paths;     /* begun */
    uint64_t rays, shadow_rays;
    uint64_t depth_cut; /* paths ended by the depth limit */
    double lost_energy; /* their throughput over that of all paths: the share of the light that may
                           be missing */
    double throughput;  /* of all paths; of the reference renderer, else 0 */
    uint64_t nonfinite; /* samples dropped because they were not finite */
    uint64_t unmatched; /* exits from a medium that the path had not entered */
    uint64_t saturated; /* light paths that would exceed the range of a pixel's sum */
    double seconds_build, seconds_compile, seconds_first_sample, seconds_render;
    double light_paths; /* for each sample, on average */
    double light_ratio; /* a pilot's: time to an error without light paths, over that with the best
                           number of them; 0: not known */
    bool kept_structure, kept_program; /* reused from the previous render (mcv_renderer) */
    uint32_t stage_count; /* the tile schedule has all its stages in one kernel; the reference has
                             none */
    struct {
        const char *name;
        double seconds; /* on the device */
    } stages[MCV_MAX_STAGES];
    bool interrupted;
} mcv_render_stats;

/*
 * Renders until options->last samples, the error, or the time is reached, whichever is first. Makes
 * the film with the scene's channels; on failure the film is empty.
 */
mcv_result mcv_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      mcv_film *film, mcv_render_stats *stats, mcv_error *error);

/*
 * The samples per replicate of the round after the first `done`. It is a power of two that divides
 * `done`, at most `done`. The render may take `seconds`, of which `elapsed` have passed (0: no
 * limit). With a limit the round is short enough to end in time, at `per_sample` seconds each, but
 * has at least `least` samples. Returns 0 if no round fits, or if the rest of the time, after 0.8
 * of it, is too short to be worth a round.
 */
uint64_t mcv_next_round(uint64_t done, uint64_t least, double per_sample, double elapsed,
                        double seconds);

/* MCV_FAILED if more than one sample in a million was not finite: too much of the image would be
 * missing. */
mcv_result mcv_render_check_finite(const mcv_scene *scene, uint32_t sensor,
                                   const mcv_render_stats *stats, mcv_error *error);

/*
 * A renderer for many renders. It keeps the device, its programs and what has not changed in the
 * scene since the previous render (acceleration structure, vertices, textures). The bits are those
 * of mcv_render. mcv_renderer_new returns NULL without memory.
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
    double direction[3];  /* unit; direction of the path behind the vertex, 0 at its end */
    double distance;      /* from the previous vertex [m]; infinite on a miss */
    uint32_t primitive;   /* global number, MCV_NONE at the start and on a miss */
    uint32_t event;       /* MCV_EVENT_… */
    double ior;           /* of the medium behind the vertex */
    double transmittance; /* product of transmittances of interfaces (reflectances after total
                             reflection) and of absorption so far, first channel */
    double radiance;      /* L/n² that this vertex emits along the path, first channel */
} mcv_vertex;

typedef struct mcv_trace_ray {
    double origin[3], direction[3]; /* world; the direction need not be unit */
} mcv_trace_ray;

/*
 * Traces each ray through smooth surfaces. It is refracted if possible, else totally reflected;
 * mirrors reflect, sheets transmit. A path ends at another surface or after `depth` surfaces. Rays
 * start in the medium that surrounds their origin (by parity). *vertices is malloc'ed, in the order
 * of the rays; the caller frees it.
 */
mcv_result mcv_trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                     const mcv_render_options *options, mcv_vertex **vertices, size_t *vertex_count,
                     mcv_error *error);

/* Refuses inconsistent options before any work. `device` adds the rules of the device renderer.
 * MCV_USAGE, or MCV_BAD_INPUT for a scene without a sensor. */
mcv_result mcv_render_check_options(const mcv_scene *scene, uint32_t sensor,
                                    const mcv_render_options *options, bool device,
                                    mcv_error *error);

#endif
