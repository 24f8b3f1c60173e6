/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/page_parts.h"

#include "io/html.h"

#include <math.h>

enum { MOST_TOLD = 12 }; /* sets that are listed by number */

size_t mcv_page_extreme(const mcv_sweep *s, size_t metric, bool largest) {
    const mcv_table *table = &s->table;
    const double *extremes[2];
    mcv_table_extremes(table, metric, extremes);
    return extremes[0] ? (size_t)(extremes[largest] - table->rows) / table->columns
                       : table->row_count;
}

static void put_link(FILE *out, const mcv_plots *p, size_t row) {
    fprintf(out, "<a href=\"#s%zu\">%zu</a>", p->sets[row], p->sets[row]);
}

static void put_value(FILE *out, const mcv_page *page, size_t metric, size_t row) {
    char words[48];
    mcv_value_words(mcv_plots_value(&page->plots, metric, row),
                    mcv_plots_uncertainty(&page->plots, metric, row), words);
    fprintf(out, "%s%s%s", words, page->metrics[metric].name[0] ? " " : "",
            page->metrics[metric].name);
}

/* "halfAngle 0.5 °, fNumber 8" */
static void put_parameters(FILE *out, const mcv_page *page, size_t row) {
    const mcv_plan *plan = &page->sweep->plan;
    mcv_value_text value;
    for (size_t i = 0; i < plan->varied; ++i) {
        fputs(i ? ", " : "", out);
        mcv_html_text(out, plan->parameters[i].name);
        fprintf(
            out, " %s%s%s",
            mcv_parameter_text(plan->parameters + i, mcv_plots_row(&page->plots, row)[i], 6, value),
            page->parameters[i].name[0] ? " " : "", page->parameters[i].name);
    }
}

/* Whether a set differs from the best by less than two standard uncertainties of the difference.
 * All sets have the same random numbers, so the difference's own is rather smaller than this. */
static bool is_as_good(const mcv_plots *p, size_t row) {
    const double u = hypot(mcv_plots_uncertainty(p, p->best_metric, row),
                           mcv_plots_uncertainty(p, p->best_metric, p->best)),
                 difference = mcv_plots_value(p, p->best_metric, row) -
                              mcv_plots_value(p, p->best_metric, p->best);
    return row != p->best && fabs(difference) <= 2 * u;
}

static void put_as_good(FILE *out, const mcv_page *page) {
    const mcv_plots *p = &page->plots;
    size_t count = 0;
    for (size_t row = 0; row < p->row_count; ++row) count += is_as_good(p, row);
    if (!(mcv_plots_uncertainty(p, p->best_metric, p->best) > 0)) {
        fputs("The uncertainty of this metric is not known.", out);
    } else if (count == 0) {
        fputs("No other set is as good within two standard uncertainties of the difference.", out);
    } else {
        fprintf(out, "As good within two standard uncertainties of the difference %s ",
                count == 1 ? "is set" : "are sets");
        size_t told = 0;
        for (size_t row = 0; row < p->row_count && told < MOST_TOLD; ++row) {
            if (!is_as_good(p, row)) continue;
            fputs(told++ ? ", " : "", out);
            put_link(out, p, row);
        }
        if (count > told) fprintf(out, " and %zu more", count - told);
        fputs(".", out);
    }
}

void mcv_page_put_best(FILE *out, const mcv_page *page) {
    const mcv_plots *p = &page->plots;
    const mcv_measurement *m = &page->sweep->measurement;
    if (p->best == p->row_count) return;
    fputs("<div class=\"answer\"><p><strong>The best set is ", out);
    put_link(out, p, p->best);
    fputs(": ", out);
    put_parameters(out, page, p->best);
    fputs("</strong></p>\n<p>Its ", out);
    mcv_html_text(out, m->metrics[m->best].name);
    fputs(" is ", out);
    put_value(out, page, m->best, p->best);
    fprintf(out, ", the %s of %zu sets.\n", m->best_largest ? "largest" : "smallest", p->row_count);
    put_as_good(out, page);
    fputs("</p>\n", out);
    mcv_page_put_set(out, page, p->best);
    fputs("</div>\n", out);
}

void mcv_page_put_extremes(FILE *out, const mcv_page *page) {
    const mcv_plots *p = &page->plots;
    const mcv_measurement *m = &page->sweep->measurement;
    fputs("<table class=\"told\"><tr><th>metric<th>smallest<th>in set<th>largest<th>in set\n", out);
    for (size_t i = 0; i < m->count; ++i) {
        fputs("<tr><td>", out);
        mcv_html_text(out, m->metrics[i].name);
        for (int largest = 0; largest < 2; ++largest) {
            const size_t row = mcv_page_extreme(page->sweep, i, largest);
            fputs("<td>", out);
            if (row < p->row_count) put_value(out, page, i, row);
            fputs("<td>", out);
            if (row < p->row_count) put_link(out, p, row);
        }
        fputs("\n", out);
    }
    fputs("</table>\n", out);
}
