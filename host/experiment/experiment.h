/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An experiment: one render and a few measured figures for each of many sets of parameters of a
 * scene. Fill in an mcv_experiment, then
 *
 *     mcv_sweep sweep;
 *     result = mcv_experiment_plan(&experiment, &sweep, &error);
 *     if (result == MCV_OK) result = mcv_experiment_open_table(&sweep, &error);
 *     if (result == MCV_OK) result = mcv_experiment_run(&sweep, &error);
 *     …                       sweep.table holds the rows
 *     mcv_experiment_free(&sweep);
 *
 * Nothing is printed. Messages name what is wrong by the options of `mcvisi sweep`.
 */
#ifndef MCVISI_HOST_EXPERIMENT_EXPERIMENT_H
#define MCVISI_HOST_EXPERIMENT_EXPERIMENT_H

#include "analysis/metrics.h"
#include "experiment/judge.h"
#include "experiment/measure.h"
#include "experiment/plan.h"
#include "experiment/table.h"
#include "loader/load.h"
#include "render/render.h"

#include <jansson.h>

typedef struct mcv_sweep mcv_sweep;

/* Each may be NULL. */
typedef struct mcv_sweep_calls {
    /* A sentence about the scene, before the first render; or about a device, during one. */
    void (*warning)(void *user, const char *sentence);
    /* Each row as it is appended; message: why the set failed, or NULL. */
    void (*row)(void *user, const mcv_sweep *sweep, const double *row, const char *message);
    /* Called during and after each render. Any result but MCV_OK stops the run and is its result;
     * the current set has no row. */
    mcv_result (*interrupted)(void *user);
    void *user;
} mcv_sweep_calls;

/* The form of mcv_reference_render. */
typedef mcv_result mcv_render_with(const mcv_scene *scene, uint32_t sensor,
                                   const mcv_render_options *options, mcv_film *film,
                                   mcv_render_stats *stats, mcv_error *error);

struct mcv_page;

/* All pointers are borrowed and must outlive the sweep. */
typedef struct mcv_experiment {
    const char *rig;              /* the path of the scene */
    const mcv_document *document; /* the scene itself, in which the path is for messages only; NULL:
                                     it is read from there */
    mcv_overrides set;            /* overrides of all sets; those of each set follow */
    const char *sensor;           /* by name or number; NULL: the only one */
    uint64_t resolution[2];       /* other pixels on the same field of view; 0: unchanged */
    mcv_variation variation;
    bool own_noise; /* each scene has random numbers of its own */
    mcv_measuring measuring;
    mcv_render_options render;    /* the sweep sets progress, enough and user */
    mcv_render_with *render_with; /* NULL: OpenCL, with a renderer for all sets */
    const char *table;            /* F.csv; F.json and F.html stand beside it; NULL: no files */
    const char *images;           /* the folder that keeps each set's image, or NULL */
    bool resume;                  /* continue an existing table */
    bool force;                   /* begin it again */
    size_t share[2];              /* only sets whose number leaves the rest share[0] when divided by
                                     share[1]; 0: all */
    const char *file; /* the file of the experiment, which F.json must not replace; or NULL */
    const char *title, *note; /* of the page: its heading, and a sentence below it; or NULL */
    const char *verb;         /* "Sweep", "Uncertainty": what the page's heading begins with */
    /* What the page shows in place of a sweep's best set, plots and sets; or NULL. False without
     * memory. */
    bool (*put_results)(FILE *out, const struct mcv_page *page, void *user);
    void *results;    /* its user */
    json_t *settings; /* further contents of F.json, which must be equal to resume: an object, or
                         NULL */
    mcv_sweep_calls calls;
    mcv_renderer *renderer;  /* what is used and kept for others; NULL: the sweep's own */
    mcv_asset_cache *assets; /* likewise */
    uint64_t memory;         /* bytes that a scene may take; 0: the default */
} mcv_experiment;

/* It points into itself: it must not be copied. */
struct mcv_sweep {
    const mcv_experiment *experiment;
    mcv_plan plan;
    mcv_measurement measurement;
    mcv_table table;
    const char *unit;     /* of the values of the pictures that are measured; "" for ratios */
    char fingerprint[32]; /* of the scene and the files that it names */
    bool *done;           /* sets that have a row */
    size_t shown;         /* row + 1 of the set whose rig the page shows; 0: the best */
    double stage_seconds; /* of all renders, on the device */
    size_t renders;
    size_t built, compiled; /* acceleration structures and programs that could not be reused */
    mcv_renderer *renderer;
    mcv_asset_cache *assets;
    mcv_judge *judge; /* the programs that decide, or NULL */
};

/* The units of its metrics' figures. */
mcv_metric_units mcv_sweep_units(const mcv_sweep *sweep);

/* The scene with changes; used by the files beside this one. */
mcv_result mcv_experiment_load(const mcv_sweep *sweep, mcv_overrides set, mcv_scene **scene,
                               mcv_error *error);

/*
 * Reads the whole experiment and the scene, and reports errors that would occur in every set. Makes
 * the folder of the images; writes no other file. MCV_USAGE and MCV_BAD_INPUT with a sentence. The
 * sweep must be freed by mcv_experiment_free even after a failure.
 */
mcv_result mcv_experiment_plan(const mcv_experiment *experiment, mcv_sweep *sweep,
                               mcv_error *error);

/* Starts the table or, to resume, reads its rows. MCV_BAD_INPUT if it cannot be written, exists
 * already, or belongs to another experiment. */
mcv_result mcv_experiment_open_table(mcv_sweep *sweep, mcv_error *error);

/*
 * Renders and measures all sets without a row. A set that fails gives a row with its message, and
 * the sweep continues. The page is written at the end, also after an interruption. MCV_DEVICE where
 * the device cannot be opened: this would fail all sets, and the set has no row. MCV_FAILED if the
 * table or the page cannot be written.
 */
mcv_result mcv_experiment_run(mcv_sweep *sweep, mcv_error *error);

void mcv_experiment_free(mcv_sweep *sweep);

#endif
