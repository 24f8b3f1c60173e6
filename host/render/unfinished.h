/* SPDX-License-Identifier: Apache-2.0 */
/* A render that is not finished: what is needed to go on with it, to the same bits. */
#ifndef MCVISI_HOST_RENDER_UNFINISHED_H
#define MCVISI_HOST_RENDER_UNFINISHED_H

#include "film/film_file.h"
#include "render/render.h"

/* Nothing is owned. */
typedef struct mcv_unfinished {
    const mcv_film *film; /* of complete rounds */
    const mcv_round *round;
    uint32_t thinning; /* log2 of pixels for one light path, or MCV_NO_LIGHT_PATHS */
    bool decided;      /* about adaptive sampling */
    double seconds;    /* since the begin of the render, those before it was resumed included */
    const mcv_render_stats
        *stats; /* its counts, and the seconds of the first sample and of samples */
} mcv_unfinished;

/* Saves an unfinished render. `due` is asked after each launch, about ten times a second or less
 * often, and before an end that was asked for (`ending`). */
struct mcv_render_saving {
    bool (*due)(void *user, bool ending);
    void (*save)(void *user, const mcv_unfinished *unfinished);
};

/* Refuses to go on with a film of another size, and with a round that the options do not lead to.
 * MCV_BAD_INPUT. */
mcv_result mcv_unfinished_check(const mcv_unfinished *unfinished, const mcv_film *film,
                                const mcv_render_options *options, mcv_error *error);

/* Takes over the film of options->resume, and its counts. `film` has its size and its room for
 * light paths already. MCV_FAILED without memory. */
mcv_result mcv_unfinished_restore(const mcv_render_options *options, mcv_film *film,
                                  mcv_render_stats *stats, mcv_error *error);

#endif
