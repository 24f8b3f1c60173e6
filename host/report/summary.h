/* SPDX-License-Identifier: Apache-2.0 */
/* The report of a finished render: as text for people, as JSON for programs. */
#ifndef MCVISI_HOST_REPORT_SUMMARY_H
#define MCVISI_HOST_REPORT_SUMMARY_H

#include "io/png.h"
#include "render/render.h"

/* All pointers are borrowed. Names and paths that do not apply are NULL; unknown numbers are NaN
 * (null in JSON). */
typedef struct mcv_summary {
    const char *scene, *sensor;
    const char *image_path, *preview_path; /* what was written */
    const char *unit;                      /* of the mean, "W/(m^2 sr)" or "W/m^2" */
    uint32_t width, height, channels, replicates;
    uint64_t
        samples; /* per pixel, all replicates together; their mean where sampling was adaptive */
    bool adaptive;
    mcv_render_stats stats;
    double seconds_load, seconds_write;
    double seconds_first_picture; /* from the begin of the render to its first preview */
    double error, mean;           /* mcv_film_relative_error, mcv_film_mean */
    double error_of_rest;         /* mcv_film_error_of_rest */
    mcv_preview preview;
} mcv_summary;

/*
 * One JSON object on one line, without a newline at its end; *text is malloc'ed. Keys: scene,
 * sensor, image, preview, device, features[], width, height, channels, replicates, samples,
 * adaptive, rays{paths, path, shadow, depth_cut}, seconds{load, build, compile, first_sample,
 * first_picture, render, write}, stages{name: seconds}, error, mean, white, saturated, lost_energy,
 * nonfinite, unmatched, interrupted, error_of_rest, light_paths{per_sample, time_without}: the
 * time to an error without light paths over that with them, as a pilot has found (null: no pilot).
 */
mcv_result mcv_summary_json(const mcv_summary *summary, char **text, mcv_error *error);

/* The report for people, a few lines; *text is malloc'ed. Losses are reported only if there are
 * any. */
mcv_result mcv_summary_text(const mcv_summary *summary, char **text, mcv_error *error);

#endif
