/* SPDX-License-Identifier: Apache-2.0 */
/* The rounds of a render of the reference renderer. */
#ifndef MCVISI_HOST_REFERENCE_ROUNDS_H
#define MCVISI_HOST_REFERENCE_ROUNDS_H

#include <pthread.h>
#include <stdatomic.h>

#include "reference/path.h"
#include "render/unfinished.h"

/* A pass: the samples [first, first + count) of every replicate of every pixel. Threads take whole
 * rows. */
typedef struct ref_pass {
    const ref_world *world;
    const mcv_sensor *sensor;
    const mcv_render_options *options;
    const mcv_film *film; /* only its sizes are used */
    uint32_t stride;      /* a pixel of the film is as many of the sensor, in each direction */
    uint32_t size[2];     /* the sensor's pixels */
    double *sums;         /* laid out as the film's */
    ref_tally *rows;
    atomic_bool *done; /* of each row */
    mcv_round part;    /* its samples, and how many rows of it are done before it begins */
    ref_tally total;   /* of the rounds before, and of those rows */
    double start;      /* when the render began, earlier by what it took before it was resumed */
    double begun;      /* when its samples began, likewise */
    atomic_uint next;
    atomic_bool stopped;
} ref_pass;

/* Threads for so many rows. */
uint32_t ref_thread_count(const mcv_render_options *options, uint32_t rows);

/* Renders into the film, which has its size, and fills in the statistics. `r` holds the world,
 * sensor, options, film, stride, size and start. */
mcv_result ref_render_rounds(ref_pass *r, mcv_film *film, mcv_render_stats *stats,
                             mcv_error *error);

#endif
