/* SPDX-License-Identifier: Apache-2.0 */
#include "pod/page.h"

#include "core/json.h"
#include "io/html.h"
#include "pod/page_plots.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void put_head(FILE *out, const mcv_pod_study *s, const mcv_pod_page *page) {
    mcv_html_begin(out, page->title ? page->title : "Probability of detection", true,
                   "; img-src data:");
    fputs("<p class=\"file\">", out);
    mcv_html_date(out);
    fprintf(out, " · mcvisi " MCV_VERSION " · %zu defects, %zu flawless parts</p>\n", s->count,
            s->flawless_count);
    if (!page->note) return;
    fputs("<p>", out);
    mcv_html_text(out, page->note);
    fputs("</p>\n", out);
}

static bool put_answer(FILE *out, const mcv_pod_study *s) {
    char *sentence = mcv_pod_sentence(s);
    if (!sentence) return false;
    fputs("<p class=\"answer\"><strong>", out);
    mcv_html_text(out, sentence);
    fputs("</strong></p>\n<ul>\n", out);
    free(sentence);
    mcv_pod_put_doubts(out, s, "<li class=\"warning\"><b>doubt</b>", "\n");
    fputs("</ul>\n", out);
    return true;
}

/* Nothing is extrapolated: beyond the tested sizes only that it lies there is known. */
static void put_size(FILE *out, const mcv_pod_study *s, const char *name, const mcv_pod_size *a) {
    const double values[3] = {a->value, a->low, a->high};
    const mcv_pod_known known[3] = {a->value_known, a->low_known, a->high_known};
    char words[32];
    fprintf(out, "<tr><th>%s", name);
    for (int i = 0; i < 3; ++i) {
        mcv_pod_size_words(s, known[i] == MCV_POD_LARGER ? s->pod.largest : values[i], words);
        fprintf(out, "<td>%s%s", known[i] == MCV_POD_LARGER ? "above " : "", words);
        if (known[i] == MCV_POD_SMALLER) fputs(" or less", out);
    }
    fputs("\n", out);
}

static void put_sizes(FILE *out, const mcv_pod_study *s) {
    if (s->pod.a90.high_known == MCV_POD_TOO_FEW || s->pod.a90.high_known == MCV_POD_FALLING)
        return;
    fprintf(out,
            "<h2>Sizes</h2>\n<table class=\"told\">\n<tr><th>found in<th>best estimate<th>lower "
            "bound<th>upper bound, each with %g %% confidence\n",
            100 * s->asked.confidence);
    put_size(out, s, "one of two cases (a50)", &s->pod.a50);
    put_size(out, s, "nine of ten cases (a90)", &s->pod.a90);
    fputs("</table>\n", out);
}

static void put_false_calls(FILE *out, const mcv_pod_study *s) {
    fputs("<h2>False calls</h2>\n<p>", out);
    if (s->flawless_count == 0) {
        fputs("No flawless part was tested: how often one is called defective is not known. A "
              "detector that calls everything a defect finds every defect.</p>\n",
              out);
        return;
    }
    fprintf(out,
            "%zu of %zu flawless parts were called defective: %.3g %%, between %.3g %% and %.3g %% "
            "with 95 %% confidence (Wilson).",
            s->false_calls, s->flawless_count,
            100 * (double)s->false_calls / (double)s->flawless_count, 100 * s->false_call_rate.low,
            100 * s->false_call_rate.high);
    if (isfinite(s->expected_false_calls))
        fprintf(out, " Normal noise of their mean and deviation would give %.3g %%.",
                100 * s->expected_false_calls);
    fputs("</p>\n", out);
}

static void put_basis(FILE *out, const mcv_pod_study *s) {
    const mcv_pod *p = &s->pod;
    fputs("<h2>How it was found</h2>\n<table class=\"told\">\n", out);
    fprintf(out, "<tr><th>method<td>%s\n",
            s->asked.signals ? "MIL-HDBK-1823A, signal against size; bounds by the noncentral t "
                               "distribution, or by a parametric bootstrap of censored signals"
                             : "MIL-HDBK-1823A, hit and miss; logistic curve, bounds by the "
                               "profile likelihood");
    if (p->fitted)
        fprintf(out, "<tr><th>scale of the size<td>%s\n", p->log_size ? "log" : "linear");
    if (s->asked.signals) {
        fprintf(out, "<tr><th>scale of the signal<td>%s\n", p->log_signal ? "log" : "linear");
        fprintf(out, "<tr><th>threshold<td>%.6g\n", s->threshold);
        fprintf(out, "<tr><th>lost, saturated<td>%zu, %zu of %zu\n", p->response.lost,
                p->response.saturated, s->count);
        fprintf(out, "<tr><th>is it a line?<td>p = %.2g\n", p->checks.linear);
        fprintf(out, "<tr><th>is the scatter the same everywhere?<td>p = %.2g\n", p->checks.even);
        fprintf(out, "<tr><th>is the scatter normal?<td>p = %.2g\n", p->checks.normal);
    }
    fprintf(out, "<tr><th>found, missed<td>%zu, %zu\n", s->hits, s->count - s->hits);
    if (s->left_out) fprintf(out, "<tr><th>rows without a number<td>%zu\n", s->left_out);
    if (s->repeated) fprintf(out, "<tr><th>further rows of a defect<td>%zu\n", s->repeated);
    fputs("</table>\n", out);
}

/* A line for each value of an option. */
static void put_setting(FILE *out, const char *name, const json_t *value) {
    const json_t *item;
    size_t i;
    if (json_is_array(value)) {
        json_array_foreach((json_t *)value, i, item) { put_setting(out, i ? "" : name, item); }
        return;
    }
    char *text = json_is_string(value) ? NULL : json_dumps(value, JSON_ENCODE_ANY);
    fputs("<tr><th>", out);
    mcv_html_text(out, name);
    fputs("<td>", out);
    mcv_html_text(out, text ? text : json_is_string(value) ? json_string_value(value) : "");
    fputs("\n", out);
    free(text);
}

/* F.json beside F.csv is the experiment that was rendered; nothing where it is not there. */
static void put_simulated(FILE *out, const char *table) {
    char path[PATH_MAX];
    const char *dot = strrchr(table, '.'), *name;
    json_t *value;
    if (!dot || snprintf(path, sizeof path, "%.*s.json", (int)(dot - table), table) >= PATH_MAX)
        return;
    json_t *experiment;
    mcv_error ignored;
    if (mcv_json_file_read(path, &experiment, &ignored) != MCV_OK) return;
    if (!json_is_object(experiment)) {
        json_decref(experiment);
        return;
    }
    fputs("<h2>What was simulated</h2>\n<table class=\"told\">\n", out);
    json_object_foreach(experiment, name, value) { put_setting(out, name, value); }
    fputs("</table>\n", out);
    json_decref(experiment);
}

static void put_limits(FILE *out, const mcv_pod_study *s, const mcv_pod_page *page) {
    char smallest[32], largest[32];
    mcv_pod_size_words(s, s->pod.smallest, smallest);
    mcv_pod_size_words(s, s->pod.largest, largest);
    fputs("<h2>What it holds, and what not</h2>\n<ul>\n", out);
    fprintf(out,
            "<li>It holds for sizes from %s to %s. Nothing is extrapolated.\n"
            "<li>It holds for defects of the shapes, places, poses and noise that the rows have, "
            "in the shares that they have there. What does not vary in the rows is not in the "
            "bounds.\n"
            "<li>How well the model describes the real part, its light and its camera is not in "
            "the bounds. Only real defects tell that.\n"
            "<li>Each row counts as another defect, independent of the others.\n",
            smallest, largest);
    if (s->asked.signals) fputs("<li>The threshold counts as known exactly.\n", out);
    fputs("</ul>\n", out);
    if (!page->table) return;
    fputs("<footer><p>Table ", out);
    mcv_html_text(out, page->table);
    fputs("</p></footer>\n", out);
}

struct written {
    const mcv_pod_study *study;
    const mcv_pod_page *page;
};

static bool put_page(FILE *out, void *user) {
    const struct written *w = user;
    const mcv_pod_study *s = w->study;
    const mcv_pod_page *page = w->page;
    const char *size = page->size_name ? page->size_name : "size";
    put_head(out, s, page);
    if (!put_answer(out, s)) return false;
    fputs("<div class=\"plots\">", out);
    mcv_pod_put_curve(out, s, size);
    if (s->asked.signals)
        mcv_pod_put_signals(out, s, size, page->value_name ? page->value_name : "signal");
    fputs("</div>\n", out);
    if (page->pictures) fputs(page->pictures, out);
    put_sizes(out, s);
    put_false_calls(out, s);
    put_basis(out, s);
    if (page->table) put_simulated(out, page->table);
    put_limits(out, s, page);
    fputs("</body></html>\n", out);
    return true;
}

mcv_result mcv_pod_page_write(const char *path, const mcv_pod_study *study,
                              const mcv_pod_page *page, mcv_error *error) {
    struct written w = {study, page};
    return mcv_html_write(path, put_page, &w, error);
}
