/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/pod.h"

#include "core/basics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* NaN where the option is not given. */
static mcv_result read_number(const char *option, const char *text, double *number,
                              mcv_error *error) {
    char *end;
    *number = NAN;
    if (!text) return MCV_OK;
    *number = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*number)
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE, "--%s %s: must be a number", option, text);
}

mcv_result mcv_pod_asked_of(const mcv_command *c, bool hits, mcv_pod_asked *asked,
                            mcv_error *error) {
    *asked = (mcv_pod_asked){.signals = !hits,
                             .size_scale = (int)c->size_scale,
                             .signal_scale = (int)c->signal_scale,
                             .confidence = c->confidence,
                             .metres = c->size_unit == 0};
    MCV_TRY(read_number("threshold", c->threshold, &asked->threshold, error));
    MCV_TRY(read_number("false-calls", c->false_calls, &asked->false_calls, error));
    MCV_TRY(read_number("lost-below", c->lost_below, &asked->low, error));
    MCV_TRY(read_number("saturated-above", c->saturated_above, &asked->high, error));
    if (c->threshold && c->false_calls)
        return mcv_fail(error, MCV_USAGE, "--threshold and --false-calls exclude each other");
    if (hits && (c->threshold || c->false_calls || c->lost_below || c->saturated_above))
        return mcv_fail(error, MCV_USAGE,
                        "--threshold, --false-calls, --lost-below and --saturated-above are for "
                        "signals, not for hits");
    if (!hits && !c->threshold && !c->false_calls)
        return mcv_fail(error, MCV_USAGE,
                        "--threshold is missing: from which signal on is a defect detected? Or "
                        "give --false-calls and rows of flawless parts, of size 0");
    if (c->false_calls && !(asked->false_calls > 0 && asked->false_calls < 1))
        return mcv_fail(error, MCV_USAGE, "--false-calls %s: must be above 0 and below 1",
                        c->false_calls);
    if (asked->low >= asked->high)
        return mcv_fail(error, MCV_USAGE, "--lost-below must be below --saturated-above");
    return MCV_OK;
}

mcv_result mcv_pod_names_of(const mcv_command *c, mcv_column_names *names, bool *hits,
                            mcv_error *error) {
    if (!c->signal_column == !c->hit_column)
        return mcv_fail(error, MCV_USAGE,
                        "give --signal or --hit: the column of the signals, or that of the hits "
                        "and misses");
    *hits = c->hit_column != NULL;
    *names = (mcv_column_names){.size = c->size_column,
                                .value = *hits ? c->hit_column : c->signal_column,
                                .defect = c->defect_column};
    return MCV_OK;
}

/* --- what is told --- */

static const char *unit_of(const mcv_pod_study *s) { return s->asked.metres ? "m" : ""; }

static void report_size(const mcv_pod_study *s, const char *key, const mcv_pod_size *a,
                        mcv_report *r) {
    mcv_report_open(r, key);
    mcv_report_number(r, "value", unit_of(s), a->value);
    mcv_report_number(r, "low", unit_of(s), a->low);
    mcv_report_number(r, "high", unit_of(s), a->high);
    mcv_report_close(r);
}

static void report_fit(const mcv_pod_study *s, mcv_report *r) {
    const mcv_pod *p = &s->pod;
    mcv_report_open(r, "fit");
    mcv_report_text(r, "size_scale", p->log_size ? "log" : "linear");
    if (s->asked.signals) {
        mcv_report_text(r, "signal_scale", p->log_signal ? "log" : "linear");
        mcv_report_number(r, "intercept", "", p->response.intercept);
        mcv_report_number(r, "slope", "", p->response.slope);
        mcv_report_number(r, "scatter", "", p->response.scatter);
        mcv_report_number(r, "lost", "", (double)p->response.lost);
        mcv_report_number(r, "saturated", "", (double)p->response.saturated);
        mcv_report_number(r, "p_linear", "", p->checks.linear);
        mcv_report_number(r, "p_even_scatter", "", p->checks.even);
        mcv_report_number(r, "p_normal", "", p->checks.normal);
    } else {
        mcv_report_number(r, "intercept", "", p->hit_miss.intercept);
        mcv_report_number(r, "slope", "", p->hit_miss.slope);
        mcv_report_flag(r, "penalised", p->hit_miss.penalised);
    }
    mcv_report_close(r);
}

static void report_false_calls(const mcv_pod_study *s, mcv_report *r) {
    const double rate = (double)s->false_calls / (double)s->flawless_count;
    mcv_report_open(r, "false_calls");
    mcv_report_number(r, "flawless", "", (double)s->flawless_count);
    mcv_report_number(r, "calls", "", (double)s->false_calls);
    mcv_report_number(r, "rate", "", rate);
    mcv_report_number(r, "low", "", s->false_call_rate.low);
    mcv_report_number(r, "high", "", s->false_call_rate.high);
    mcv_report_number(r, "expected_rate", "", s->expected_false_calls);
    mcv_report_close(r);
}

/* JSON alone: size, probability, lower and upper bound. */
static json_t *curve_json(const mcv_pod_study *s) {
    enum { POINTS = 41 };
    const double from = s->pod.smallest, to = s->pod.largest;
    json_t *curve = json_array();
    for (int i = 0; i < POINTS; ++i) {
        const double share = (double)i / (POINTS - 1);
        const double size =
            s->pod.log_size ? from * pow(to / from, share) : from + share * (to - from);
        const mcv_pod_point p = mcv_pod_at(&s->pod, size);
        json_t *row = json_array();
        json_array_append_new(row, json_real(size));
        json_array_append_new(row, json_real(p.value));
        json_array_append_new(row, isnan(p.low) ? json_null() : json_real(p.low));
        json_array_append_new(row, isnan(p.high) ? json_null() : json_real(p.high));
        json_array_append_new(curve, row);
    }
    return curve;
}

/* JSON has null for a number that is not known. */
static void report_bound(const mcv_pod_study *s, mcv_report *r) {
    const double bound = s->pod.a90.high;
    if (r->json && isnan(bound)) {
        mcv_report_value(r, "a90_bound", json_null());
    } else {
        mcv_report_number(r, "a90_bound", unit_of(s), bound);
    }
}

static mcv_result tell_doubts(const mcv_pod_study *s, mcv_report *r, mcv_error *error) {
    char *text = NULL, *next = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (out) mcv_pod_put_doubts(out, s, "", "\n");
    if (!mcv_text_close(out, &text)) return mcv_fail(error, MCV_FAILED, "no memory for the report");
    for (char *line = strtok_r(text, "\n", &next); line; line = strtok_r(NULL, "\n", &next))
        mcv_report_tell(r, "warning", line);
    free(text);
    return MCV_OK;
}

mcv_result mcv_pod_report(const mcv_pod_study *s, mcv_report *r, mcv_error *error) {
    char *sentence = mcv_pod_sentence(s);
    if (!sentence) return mcv_fail(error, MCV_FAILED, "no memory for the report");
    mcv_report_text(r, "answer", sentence);
    free(sentence);
    report_bound(s, r);
    mcv_report_number(r, "confidence", "", s->asked.confidence);
    if (s->pod.a90.high_known != MCV_POD_TOO_FEW) {
        report_size(s, "a50", &s->pod.a50, r);
        report_size(s, "a90", &s->pod.a90, r);
    }
    mcv_report_number(r, "defects", "", (double)s->count);
    mcv_report_number(r, "hits", "", (double)s->hits);
    mcv_report_number(r, "smallest", unit_of(s), s->pod.smallest);
    mcv_report_number(r, "largest", unit_of(s), s->pod.largest);
    if (s->left_out) mcv_report_number(r, "left_out", "", (double)s->left_out);
    if (s->repeated) mcv_report_number(r, "repeated", "", (double)s->repeated);
    mcv_report_number(r, "threshold", "", s->threshold);
    if (s->flawless_count) report_false_calls(s, r);
    if (s->pod.fitted) report_fit(s, r);
    if (s->pod.fitted && r->json) mcv_report_value(r, "curve", curve_json(s));
    return tell_doubts(s, r, error);
}
