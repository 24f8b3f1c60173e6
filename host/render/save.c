/* SPDX-License-Identifier: Apache-2.0 */
/* Saving an unfinished render, and going on with it. */
#include "render/renderer.h"

#include <string.h>

#include "core/basics.h"

bool mcv_save_is_due(const mcv_renderer *r, bool ending) {
    const struct mcv_render_saving *saving = r->options->saving;
    return saving && !r->options->records && saving->due(r->options->user, ending);
}

void mcv_save_unfinished(mcv_renderer *r) {
    const double now = mcv_seconds();
    r->stats->seconds_render = now - r->sampling_begun;
    /* Splats of whole rounds are in the film. */
    if (r->part.sums) r->part.splats = r->splats;
    const mcv_unfinished unfinished = {.film = r->film,
                                       .round = &r->part,
                                       .thinning = r->frame.log2_thinning,
                                       .decided = r->decided,
                                       .seconds = now - r->begun,
                                       .stats = r->stats};
    r->options->saving->save(r->options->user, &unfinished);
    r->part.splats = NULL;
}

mcv_result mcv_resume(mcv_renderer *r) {
    const mcv_unfinished *u = r->options->resume;
    const size_t values = mcv_film_values(r->film);
    if (r->options->records)
        return mcv_fail(r->error, MCV_USAGE, "a render that records cannot be resumed");
    MCV_TRY(mcv_unfinished_restore(r->options, r->film, r->stats, r->error));
    r->decided = u->decided;
    r->begun -= u->seconds;
    r->sampling_begun -= u->stats->seconds_render;
    r->part = *u->round;
    r->part.splats = NULL;
    r->part.sums = NULL;
    if (u->round->sums) {
        for (size_t i = 0; i < values; ++i) r->round[i] = u->round->sums[i];
        r->part.sums = r->round;
    }
    if (r->film->splats) {
        memcpy(r->splats, u->round->splats ? u->round->splats : r->film->splats, 8 * values);
        mcv_frame_thin_light(&r->frame, u->thinning);
        mcv_count_light_paths(r);
    }
    return r->film->levels ? mcv_begin_levels(r) : MCV_OK;
}
