/* SPDX-License-Identifier: Apache-2.0 */
#include "pod/study.h"

#include "statistics/distributions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct numbered {
    uint64_t defect;
    size_t row;
} numbered;

static int compare_numbered(const void *a, const void *b) {
    const numbered *x = a, *y = b;
    if (x->defect != y->defect) return x->defect < y->defect ? -1 : 1;
    return (x->row > y->row) - (x->row < y->row);
}

/* again[row]: an earlier row has its defect. */
static bool find_repeated(const mcv_columns *c, bool *again) {
    numbered *list = malloc(c->count * sizeof *list);
    if (!list) return false;
    for (size_t i = 0; i < c->count; ++i) list[i] = (numbered){c->defects[i], i};
    qsort(list, c->count, sizeof *list, compare_numbered);
    for (size_t i = 1; i < c->count; ++i) again[list[i].row] = list[i].defect == list[i - 1].defect;
    free(list);
    return true;
}

static mcv_result sort_rows(mcv_pod_study *s, const mcv_columns *c, const bool *again,
                            mcv_error *error) {
    for (size_t i = 0; i < c->count; ++i) {
        const double size = c->sizes[i], value = c->values[i];
        if (size < 0)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "row %zu: the size is %g: must be above 0, or 0 for a flawless part",
                            i + 1, size);
        if (!isfinite(size) || !isfinite(value)) {
            ++s->left_out;
        } else if (again[i]) {
            ++s->repeated;
        } else if (!s->asked.signals && value != 0 && value != 1) {
            return mcv_fail(error, MCV_BAD_INPUT, "row %zu: the hit is %g: must be 0 or 1", i + 1,
                            value);
        } else if (size == 0) {
            s->flawless[s->flawless_count++] = value;
        } else {
            s->sizes[s->count] = size;
            s->values[s->count++] = value;
        }
    }
    return MCV_OK;
}

static mcv_result take_rows(mcv_pod_study *s, const mcv_columns *c, mcv_error *error) {
    bool *again = calloc(c->count + 1, sizeof *again);
    s->sizes = calloc(c->count + 1, sizeof *s->sizes);
    s->values = calloc(c->count + 1, sizeof *s->values);
    s->flawless = calloc(c->count + 1, sizeof *s->flawless);
    const bool found = again && (!c->defects || c->count == 0 || find_repeated(c, again));
    const mcv_result result =
        found && s->sizes && s->values && s->flawless
            ? sort_rows(s, c, again, error)
            : mcv_fail(error, MCV_FAILED, "no memory for %zu defects", c->count);
    free(again);
    return result;
}

/* Mean and deviation of flawless signals, and the threshold that goes with false calls. */
static mcv_result find_threshold(mcv_pod_study *s, mcv_error *error) {
    const size_t n = s->flawless_count;
    double mean = 0, squares = 0;
    for (size_t i = 0; i < n; ++i) mean += s->flawless[i] / (double)n;
    for (size_t i = 0; i < n; ++i) squares += (s->flawless[i] - mean) * (s->flawless[i] - mean);
    if (n >= MCV_POD_LEAST_FLAWLESS && squares > 0) {
        s->noise_mean = mean;
        s->noise_deviation = sqrt(squares / ((double)n - 1));
    }
    s->threshold = s->asked.threshold;
    if (!isnan(s->threshold)) return MCV_OK;
    if (isnan(s->noise_mean))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "--false-calls needs signals of at least %d flawless parts that differ: "
                        "rows of size 0. There are %zu; or give --threshold",
                        MCV_POD_LEAST_FLAWLESS, n);
    s->threshold =
        s->noise_mean + s->noise_deviation * mcv_normal_quantile(1 - s->asked.false_calls);
    return MCV_OK;
}

static void count_calls(mcv_pod_study *s) {
    const double from = s->asked.signals ? s->threshold : 1;
    for (size_t i = 0; i < s->count; ++i) s->hits += s->values[i] >= from;
    for (size_t i = 0; i < s->flawless_count; ++i) s->false_calls += s->flawless[i] >= from;
    s->false_call_rate = mcv_wilson((double)s->false_calls, (double)s->flawless_count, 0.95);
    if (s->asked.signals)
        s->expected_false_calls =
            mcv_normal_cdf((s->noise_mean - s->threshold) / s->noise_deviation);
}

mcv_result mcv_pod_study_make(const mcv_pod_asked *asked, const mcv_columns *c, mcv_pod_study *s,
                              mcv_error *error) {
    *s = (mcv_pod_study){.asked = *asked,
                         .noise_mean = NAN,
                         .noise_deviation = NAN,
                         .threshold = NAN,
                         .expected_false_calls = NAN};
    MCV_TRY(take_rows(s, c, error));
    if (asked->signals) MCV_TRY(find_threshold(s, error));
    count_calls(s);
    const mcv_pod_data data = {.sizes = s->sizes,
                               .signals = asked->signals ? s->values : NULL,
                               .hits = s->values,
                               .count = s->count,
                               .threshold = s->threshold,
                               .low = asked->low,
                               .high = asked->high,
                               .size_scale = asked->size_scale,
                               .signal_scale = asked->signal_scale,
                               .confidence = asked->confidence,
                               .seed = asked->seed};
    return mcv_pod_fit(&data, &s->pod, error);
}

void mcv_pod_study_free(mcv_pod_study *study) {
    mcv_pod_free(&study->pod);
    free(study->sizes);
    free(study->values);
    free(study->flawless);
    study->sizes = study->values = study->flawless = NULL;
}
