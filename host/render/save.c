/* SPDX-License-Identifier: Apache-2.0 */
/* Saving an unfinished render, and going on with it. */
#include "render/renderer.h"

#include <stdlib.h>

#include "core/basics.h"

/* Splats of whole rounds are in the film; those of the round so far are on the device. */
static mcv_result read_splats(mcv_renderer *r) {
    const size_t bytes = 8 * mcv_film_values(r->film);
    if (!r->film->splats || !r->part.sums) return MCV_OK;
    r->part.splats = malloc(bytes);
    if (!r->part.splats) return mcv_fail(r->error, MCV_FAILED, "no memory to save light paths");
    return mcv_cl_read(&r->cl, r->scene.splats, 0, bytes, r->part.splats, r->error);
}

bool mcv_save_is_due(const mcv_renderer *r, bool ending) {
    const struct mcv_render_saving *saving = r->options->saving;
    return saving && !r->options->records && saving->due(r->options->user, ending);
}

mcv_result mcv_save_unfinished(mcv_renderer *r) {
    const double now = mcv_seconds();
    r->stats->seconds_render = now - r->sampling_begun;
    const mcv_result result = read_splats(r);
    const mcv_unfinished unfinished = {.film = r->film,
                                       .round = &r->part,
                                       .thinning = r->frame.log2_thinning,
                                       .decided = r->decided,
                                       .seconds = now - r->begun,
                                       .stats = r->stats};
    if (result == MCV_OK) r->options->saving->save(r->options->user, &unfinished);
    free(r->part.splats);
    r->part.splats = NULL;
    return result;
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
        const uint64_t *splats = u->round->splats ? u->round->splats : r->film->splats;
        mcv_frame_thin_light(&r->frame, u->thinning);
        MCV_TRY(mcv_cl_write(&r->cl, r->scene.splats, 0, 8 * values, splats, r->error));
    }
    return r->film->levels ? mcv_begin_levels(r) : MCV_OK;
}
