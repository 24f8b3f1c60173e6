/* SPDX-License-Identifier: Apache-2.0 */
#include "render/unfinished.h"

#include <stdlib.h>
#include <string.h>

/* A round is an aligned power of two of samples, behind those of the film; each level of adaptive
 * sampling has a whole number of them. */
static bool is_round(const mcv_unfinished *u, const mcv_render_options *o) {
    const mcv_round *round = u->round;
    const uint64_t most = (uint64_t)1 << 31, least = u->film->levels ? 8 : 1;
    return round->count >= least && (round->count & (round->count - 1)) == 0 &&
           round->first % round->count == 0 && round->first == o->first + u->film->samples &&
           round->first + round->count <= (o->last ? o->last : most);
}

mcv_result mcv_unfinished_check(const mcv_unfinished *u, const mcv_film *film,
                                const mcv_render_options *options, mcv_error *error) {
    const mcv_film *from = u->film;
    if (!is_round(u, options))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "a round of %llu samples from sample %llu on cannot be continued: these "
                        "options do not lead to it",
                        (unsigned long long)u->round->count, (unsigned long long)u->round->first);
    if (from->width == film->width && from->height == film->height &&
        from->channels == film->channels && from->replicates == film->replicates &&
        !from->splats == !film->splats)
        return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "a film of %u x %u pixels, %u channels and %u replicates%s cannot be continued "
                    "as one of %u x %u, %u and %u%s",
                    from->width, from->height, from->channels, from->replicates,
                    from->splats ? " with light paths" : "", film->width, film->height,
                    film->channels, film->replicates, film->splats ? " with light paths" : "");
}

static void restore_stats(const mcv_render_stats *from, mcv_render_stats *to) {
    to->paths = from->paths;
    to->rays = from->rays;
    to->shadow_rays = from->shadow_rays;
    to->depth_cut = from->depth_cut;
    to->lost_energy = from->lost_energy;
    to->nonfinite = from->nonfinite;
    to->unmatched = from->unmatched;
    to->saturated = from->saturated;
    to->seconds_first_sample = from->seconds_first_sample;
}

mcv_result mcv_unfinished_restore(const mcv_render_options *options, mcv_film *film,
                                  mcv_render_stats *stats, mcv_error *error) {
    const mcv_unfinished *u = options->resume;
    const mcv_film *from = u->film;
    const size_t bytes = 8 * mcv_film_values(film), pixels = (size_t)film->width * film->height;
    MCV_TRY(mcv_unfinished_check(u, film, options, error));
    film->samples = from->samples;
    memcpy(film->sums, from->sums, bytes);
    if (film->splats) {
        memcpy(film->camera_sums, from->camera_sums, bytes);
        memcpy(film->splats, from->splats, bytes);
        film->splat_value = from->splat_value;
    }
    if (from->levels) {
        film->levels = malloc(pixels);
        if (!film->levels)
            return mcv_fail(error, MCV_FAILED, "no memory for the levels of %zu pixels", pixels);
        memcpy(film->levels, from->levels, pixels);
    }
    restore_stats(u->stats, stats);
    return MCV_OK;
}
