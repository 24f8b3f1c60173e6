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

#include "experiment/measure.h"
#include "experiment/plan.h"
#include "experiment/table.h"
#include "loader/load.h"
#include "render/render.h"

#include <jansson.h>

typedef struct mcv_sweep mcv_sweep;

/* Each may be NULL. */
typedef struct mcv_sweep_calls {
    /* A sentence about the scene, before the first render. */
    void (*warning)(void *user, const char *sentence);
    /* Each row as it is appended; message: why the set failed, or NULL. */
    void (*row)(void *user, const mcv_sweep *sweep, const double *row, const char *message);
    /* Asked during and after each render. Anything but MCV_OK stops, and is what the run returns;
     * the set at work leaves no row. */
    mcv_result (*interrupted)(void *user);
    void *user;
} mcv_sweep_calls;

/* mcv_reference_render, or what has its form. */
typedef mcv_result mcv_render_with(const mcv_scene *scene, uint32_t sensor,
                                   const mcv_render_options *options, mcv_film *film,
                                   mcv_render_stats *stats, mcv_error *error);

/* Nothing is owned, and all of it must outlive the sweep. */
typedef struct mcv_experiment {
    const char *rig;              /* the path of the scene */
    const mcv_document *document; /* the scene itself, in which the path is for messages only; NULL:
                                     it is read from there */
    mcv_overrides set;            /* of all sets; theirs come after these */
    const char *sensor;           /* by name or number; NULL: the only one */
    uint64_t resolution[2];       /* other pixels on the same field of view; 0: as it is */
    mcv_variation variation;
    mcv_measuring measuring;
    mcv_render_options render;    /* progress, enough and user are the sweep's own */
    mcv_render_with *render_with; /* NULL: OpenCL, keeping what sets have in common */
    const char *table;            /* F.csv; F.json and F.html stand beside it; NULL: no files */
    const char *images;           /* the folder that keeps each set's image, or NULL */
    bool resume;                  /* go on with a table that was begun */
    const char *file; /* the experiment was read from it, and F.json must not replace it; NULL */
    json_t *settings; /* what F.json tells beside the scene, and must be the same to resume: an
                         object, or NULL */
    mcv_sweep_calls calls;
    mcv_renderer *renderer;  /* what is used and kept for others; NULL: the sweep's own */
    mcv_asset_cache *assets; /* likewise */
} mcv_experiment;

/* It points into itself: it must not be copied. */
struct mcv_sweep {
    const mcv_experiment *experiment;
    mcv_plan plan;
    mcv_measurement measurement;
    mcv_table table;
    char fingerprint[32];   /* of the scene and the files that it names */
    bool *done;             /* sets that have a row */
    double stage_seconds;   /* of all renders, on the device */
    size_t built, compiled; /* acceleration structures and programs that no render before had
                               left */
    mcv_renderer *renderer;
    mcv_asset_cache *assets;
};

/* The scene with changes; used by the files beside this one. */
mcv_result mcv_experiment_load(const mcv_sweep *sweep, mcv_overrides set, mcv_scene **scene,
                               mcv_error *error);

/*
 * Reads all of the experiment, and the scene: what would be wrong in every set is told here. The
 * folder of the images is made; no other file is written. MCV_USAGE and MCV_BAD_INPUT with a
 * sentence. After failure, too, the sweep is freed by mcv_experiment_free.
 */
mcv_result mcv_experiment_plan(const mcv_experiment *experiment, mcv_sweep *sweep,
                               mcv_error *error);

/* Begins the table or, where it is to be resumed, reads its rows: MCV_BAD_INPUT where it cannot be
 * written, is there already or was begun with another experiment. */
mcv_result mcv_experiment_open_table(mcv_sweep *sweep, mcv_error *error);

/*
 * Renders and measures all sets that have no row. A set that fails is a row with its message, and
 * the sweep goes on. The page is written in the end, after an interruption as well. MCV_FAILED
 * where the table or the page cannot be written.
 */
mcv_result mcv_experiment_run(mcv_sweep *sweep, mcv_error *error);

void mcv_experiment_free(mcv_sweep *sweep);

#endif
