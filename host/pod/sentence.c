/* SPDX-License-Identifier: Apache-2.0 */
/* The words of a study (pod/study.h). */
#include "pod/study.h"

#include "core/basics.h"

#include <math.h>
#include <stdlib.h>

void mcv_pod_size_words(const mcv_pod_study *study, double size, char words[32]) {
    static const struct {
        double above, factor;
        const char *name;
    } units[] = {{1, 1, " m"}, {1e-3, 1e3, " mm"}, {0, 1e6, " µm"}};
    int i = 0;
    while (study->asked.metres && size < units[i].above) ++i;
    snprintf(words, 32, "%.3g%s", study->asked.metres ? size * units[i].factor : size,
             study->asked.metres ? units[i].name : "");
}

/* What is known without the confidence. */
static void put_estimate(FILE *out, const mcv_pod_study *s) {
    const mcv_pod_size *a = &s->pod.a90;
    char best[32], low[32];
    if (a->value_known != MCV_POD_FOUND) return;
    mcv_pod_size_words(s, a->value, best);
    fprintf(out, " The best estimate of that size is %s", best);
    if (a->low_known == MCV_POD_FOUND) {
        mcv_pod_size_words(s, a->low, low);
        fprintf(out, "; with the same confidence it is not below %s", low);
    }
    fputs(".", out);
}

static void put_too_few(FILE *out, const mcv_pod_study *s) {
    fprintf(out,
            "%zu of %zu defects were found: too few %s for a bound, and so there is none. It needs "
            "at least %d defects, of which %d are found and %d are missed.",
            s->hits, s->count,
            s->count < MCV_POD_LEAST_DEFECTS  ? "defects"
            : s->hits < MCV_POD_LEAST_OF_EACH ? "hits"
                                              : "misses",
            MCV_POD_LEAST_DEFECTS, MCV_POD_LEAST_OF_EACH, MCV_POD_LEAST_OF_EACH);
    if (s->hits > 0)
        fprintf(out,
                " Of all defects like these, of all tested sizes together, at least %.1f %% "
                "are found, with %g %% confidence.",
                100 * mcv_clopper_pearson_low(s->hits, s->count, s->asked.confidence),
                100 * s->asked.confidence);
}

static void put_sentence(FILE *out, const mcv_pod_study *s) {
    const mcv_pod_size *a = &s->pod.a90;
    const double percent = 100 * s->asked.confidence;
    char bound[32], largest[32];
    mcv_pod_size_words(s, a->high, bound);
    mcv_pod_size_words(s, s->pod.largest, largest);
    switch (a->high_known) {
    case MCV_POD_FOUND:
        fprintf(out, "A defect of %s is found in nine of ten cases, with %g %% confidence.", bound,
                percent);
        put_estimate(out, s);
        return;
    case MCV_POD_SMALLER:
        fprintf(out,
                "Defects of every tested size are found in nine of ten cases, with %g %% "
                "confidence: the smallest tested one is %s.",
                percent, bound);
        return;
    case MCV_POD_LARGER:
        fprintf(out,
                "No size up to %s, the largest that was tested, is found in nine of ten cases "
                "with %g %% confidence. Test larger defects, or more of them.",
                largest, percent);
        put_estimate(out, s);
        return;
    case MCV_POD_TOO_FEW:
        put_too_few(out, s);
        return;
    case MCV_POD_FALLING:
        fputs("Larger defects are not detected better than small ones: there is no size from which "
              "on they are found.",
              out);
        return;
    }
}

char *mcv_pod_sentence(const mcv_pod_study *study) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    put_sentence(out, study);
    (void)mcv_text_close(out, &text);
    return text;
}

double mcv_pod_coverage(size_t defects) { return defects < 60 ? 0.91 : defects < 240 ? 0.93 : NAN; }

void mcv_pod_put_doubts(FILE *out, const mcv_pod_study *s, const char *before, const char *after) {
    const mcv_response_checks *c = &s->pod.checks;
    const double coverage = s->asked.signals ? NAN : mcv_pod_coverage(s->count);
    const struct {
        double p;
        const char *words;
    } checks[] = {{c->linear, "The signals do not lie along a line"},
                  {c->even, "The scatter of the signals differs between sizes"},
                  {c->normal, "The scatter of the signals is not normal"}};
    for (size_t i = 0; i < 3 && s->asked.signals; ++i)
        if (checks[i].p < 0.05)
            fprintf(out,
                    "%s%s (p = %.2g): the bound may not hold. Try other scales, or hits and "
                    "misses.%s",
                    before, checks[i].words, checks[i].p, after);
    if (s->pod.a90.high_known == MCV_POD_FOUND && s->asked.confidence == 0.95 && coverage < 1)
        fprintf(out,
                "%sFrom %zu defects the bound, said to hold in 95 %%, holds in about %.0f %% of "
                "experiments. From 240 on it holds as said.%s",
                before, s->count, 100 * coverage, after);
    if (s->pod.fitted && !s->asked.signals && s->pod.hit_miss.penalised)
        fprintf(out,
                "%sOne size parts all hits from all misses: the curve is Firth's, and its "
                "steepness is a guess. Test more sizes near that one.%s",
                before, after);
}
