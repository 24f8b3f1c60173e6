/* SPDX-License-Identifier: Apache-2.0 */
/* Requirements: what is believed of their margins. */
#include "optimize/search_parts.h"

#include <math.h>
#include <stdlib.h>

/* The evaluations of the polish share their noise, as in mcv_search_believe. */
static mcv_result believe_margin(mcv_searching *s, size_t k, bool lengths, mcv_error *error) {
    mcv_surrogate *limit = s->limits + k;
    limit->count = 0;
    for (size_t i = 0; i < s->result->count; ++i) {
        const mcv_evaluation *e = s->result->all + i;
        if (e->stage == MCV_STAGE_POLISH || isnan(e->results[0])) continue;
        const double u = isnan(e->margin_errors[k]) ? 0 : e->margin_errors[k];
        MCV_TRY(mcv_surrogate_add(limit, e->unit, e->margins[k], u * u, error));
    }
    return mcv_surrogate_fit(limit, lengths, error);
}

mcv_result mcv_search_believe_margins(mcv_searching *s, bool lengths, mcv_error *error) {
    for (size_t k = 0; k < s->search->requirements; ++k)
        MCV_TRY(believe_margin(s, k, lengths, error));
    return MCV_OK;
}

/* The margins are taken as independent. */
mcv_result mcv_search_chances(const mcv_searching *s, const double *points, size_t count,
                              double *chances, mcv_error *error) {
    for (size_t i = 0; i < count; ++i) chances[i] = 1;
    if (s->search->requirements == 0 || count == 0) return MCV_OK;
    double *means = malloc(2 * count * sizeof *means);
    if (!means) return mcv_fail(error, MCV_FAILED, "no memory for a search");
    double *deviations = means + count;
    mcv_result result = MCV_OK;
    for (size_t k = 0; k < s->search->requirements && result == MCV_OK; ++k) {
        result = mcv_surrogate_predict(s->limits + k, points, count, means, deviations, error);
        for (size_t i = 0; i < count && result == MCV_OK; ++i)
            chances[i] *= deviations[i] > 0 ? 0.5 * erfc(means[i] / deviations[i] * M_SQRT1_2)
                                            : (double)(means[i] <= 0);
    }
    free(means);
    return result;
}
