/* SPDX-License-Identifier: Apache-2.0 */
/* What the page of an optimisation shows: the winner, the search's own optimism, rivals or the
 * front, how far parameters may go, and all that was evaluated. */
#include "optimize/study.h"

#include "experiment/page_parts.h"
#include "io/axis.h"
#include "io/html.h"

#include <math.h>
#include <string.h>

/* An objective of the page in the unit that is shown. */
typedef struct shown {
    const mcv_optimization *o;
    const mcv_page *page;
    size_t objective, metric;
    double per_si;
    const char *unit;
} shown;

static shown show(const mcv_optimization *o, const mcv_page *page, size_t objective) {
    const size_t metric = o->objectives[objective].metric;
    return (shown){
        o, page, objective, metric, page->metrics[metric].per_si, page->metrics[metric].name};
}

static void put_value(FILE *out, const shown *s, double result, double error) {
    char words[48];
    mcv_value_words(mcv_optimization_value(s->o, s->objective, result) * s->per_si,
                    error * s->per_si, words);
    fprintf(out, "%s%s%s", words, s->unit[0] ? " " : "", s->unit);
}

static void put_number(FILE *out, const shown *s, double result) {
    fprintf(out, "%.5g%s%s", mcv_optimization_value(s->o, s->objective, result) * s->per_si,
            s->unit[0] ? " " : "", s->unit);
}

/* "distance 15 mm, fNumber 8" */
static void put_parameters(FILE *out, const mcv_page *page, const double *values) {
    const mcv_plan *plan = &page->sweep->plan;
    mcv_value_text value;
    for (size_t i = 0; i < plan->varied; ++i) {
        fputs(i ? ", " : "", out);
        mcv_html_text(out, plan->parameters[i].name);
        fprintf(out, " %s%s%s",
                mcv_parameter_text(plan->parameters + i, values[i] * page->parameters[i].per_si, 6,
                                   value),
                page->parameters[i].name[0] ? " " : "", page->parameters[i].name);
    }
}

/* --- the answer --- */

static void put_unfinished(FILE *out, const mcv_optimization *o) {
    fprintf(out,
            "<div class=\"answer\"><p><strong>The search has not ended.</strong> %zu of at most "
            "%zu sets are rendered; --resume goes on with them.</p></div>\n",
            o->sweep.table.row_count, o->search.budget);
}

static void put_winner(FILE *out, const mcv_optimization *o, const mcv_page *page) {
    const shown s = show(o, page, 0);
    const mcv_confirmed *w = &o->found.winner;
    const bool largest = o->objectives[0].largest;
    fputs("<div class=\"answer\"><p><strong>The best set-up is ", out);
    put_parameters(out, page, w->point.values);
    fputs("</strong></p>\n<p>There ", out);
    mcv_html_text(out, page->names[s.metric]);
    fputs(" is ", out);
    put_value(out, &s, w->point.results[0], w->point.errors[0]);
    fputs("; 95 %: ", out);
    put_number(out, &s, largest ? o->found.high : o->found.low);
    fputs(" to ", out);
    put_number(out, &s, largest ? o->found.low : o->found.high);
    fprintf(out,
            ", from %zu renders with random numbers that have chosen nothing. The search itself "
            "had seen ",
            w->count);
    put_number(out, &s, w->in_search);
    fputs(" there: the best of many noisy values looks better than it is.</p>\n<p>The search took ",
          out);
    fprintf(out, "%zu evaluations, because ", o->found.count);
    mcv_html_text(out, o->found.ended);
    fputs(".</p></div>\n", out);
}

/* --- tables --- */

static void put_points(FILE *out, const mcv_optimization *o, const mcv_page *page) {
    mcv_value_text value;
    const mcv_plan *plan = &o->sweep.plan;
    fprintf(out, "<h2>%s</h2>\n<div class=\"wide\"><table class=\"told\"><tr>",
            o->search.objectives > 1 ? "The front: none of these is better in all"
                                     : "The winner and its rivals");
    for (size_t i = 0; i < plan->varied; ++i) {
        fputs("<th>", out);
        mcv_html_text(out, page->parameter_names[i].words);
    }
    for (size_t k = 0; k < o->search.objectives; ++k) {
        fputs("<th>", out);
        mcv_html_text(out, page->names[o->objectives[k].metric]);
    }
    fputs(o->search.objectives > 1 ? "<th>fresh renders\n" : "<th>in the search<th>fresh renders\n",
          out);
    for (size_t i = 0; i < o->found.point_count; ++i) {
        const mcv_confirmed *c = o->found.points + i;
        fputs("<tr>", out);
        for (size_t k = 0; k < plan->varied; ++k)
            fprintf(out, "<td>%s",
                    mcv_parameter_text(plan->parameters + k,
                                       c->point.values[k] * page->parameters[k].per_si, 6, value));
        for (size_t k = 0; k < o->search.objectives; ++k) {
            const shown s = show(o, page, k);
            fputs("<td>", out);
            /* One point without rivals needs no choice, and so has no renders for it. */
            const mcv_confirmed *told = c->count || o->search.objectives > 1 ? c : &o->found.winner;
            put_value(out, &s, told->point.results[k], told->point.errors[k]);
        }
        if (o->search.objectives == 1) {
            const shown s = show(o, page, 0);
            fputs("<td>", out);
            put_number(out, &s, c->in_search);
        }
        fprintf(out, "<td>%zu\n", c->count);
    }
    fputs("</table></div>\n", out);
}

static void put_near(FILE *out, const mcv_optimization *o, const mcv_page *page) {
    const mcv_plan *plan = &o->sweep.plan;
    fputs("<h2>How far each parameter may go</h2>\n<p>While the others stay, the model of the "
          "search says that nothing that matters is lost within:</p>\n<table class=\"told\">\n",
          out);
    for (size_t i = 0; i < plan->varied; ++i) {
        const double per_si = page->parameters[i].per_si;
        if (o->levels[i].named) continue; /* words have no order */
        fputs("<tr><th>", out);
        mcv_html_text(out, page->parameter_names[i].words);
        fprintf(out, "<td>%.5g to %.5g\n", o->found.near[i][0] * per_si,
                o->found.near[i][1] * per_si);
    }
    fputs("</table>\n", out);
}

/* --- plots --- */

/* One point of a plot; its colour tells the stage. */
static void put_point(FILE *out, const mcv_optimization *o, size_t evaluation, double x, double y) {
    fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"#%06x\"/>", x, y,
            (unsigned)mcv_plots_colour(o->found.all[evaluation].stage / 3.0));
}

static void put_stages(FILE *out) {
    fputs("</svg><figcaption class=\"legend\">", out);
    for (int i = 0; i < 4; ++i)
        fprintf(out,
                "<svg class=\"dot\" viewBox=\"0 0 8 8\"><circle cx=\"4\" cy=\"4\" r=\"4\" "
                "fill=\"#%06x\"/></svg> %s ",
                (unsigned)mcv_plots_colour(i / 3.0), mcv_search_stages[i]);
    fputs("</figcaption></figure>\n", out);
}

static double plotted(const shown *s, size_t evaluation) {
    return mcv_optimization_value(s->o, s->objective,
                                  s->o->found.all[evaluation].results[s->objective]) *
           s->per_si;
}

/* An objective over a parameter, or over the evaluations in their order (parameter = varied). */
static void put_plot(FILE *out, const shown *s, size_t parameter) {
    const mcv_search_result *f = &s->o->found;
    const bool order = parameter == s->o->sweep.plan.varied;
    const double per_si = order ? 1 : s->page->parameters[parameter].per_si;
    double xs[2] = {INFINITY, -INFINITY}, ys[2] = {INFINITY, -INFINITY};
    for (size_t i = 0; i < f->count; ++i) {
        mcv_axis_extend(xs, order ? (double)i : f->all[i].values[parameter] * per_si);
        mcv_axis_extend(ys, plotted(s, i));
    }
    const mcv_axis x = mcv_axis_over(xs[0], xs[1],
                                     !order && s->o->levels[parameter].logarithmic &&
                                         !s->o->levels[parameter].list,
                                     MCV_PLOT_LEFT, MCV_PLOT_WIDTH - MCV_PLOT_RIGHT),
                   y = mcv_axis_over(ys[0], ys[1], false, MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM,
                                     MCV_PLOT_TOP);
    fputs("<figure>", out);
    mcv_axes_put(out, &x, &y, order ? "render" : s->page->parameter_names[parameter].words,
                 s->page->names[s->metric]);
    for (size_t i = 0; i < f->count; ++i)
        if (!isnan(f->all[i].results[s->objective]))
            put_point(out, s->o, i,
                      mcv_axis_place(&x, order ? (double)i : f->all[i].values[parameter] * per_si),
                      mcv_axis_place(&y, plotted(s, i)));
    put_stages(out);
}

static void put_trade(FILE *out, const shown *a, const shown *b) {
    const mcv_search_result *f = &a->o->found;
    double xs[2] = {INFINITY, -INFINITY}, ys[2] = {INFINITY, -INFINITY};
    for (size_t i = 0; i < f->count; ++i) {
        mcv_axis_extend(xs, plotted(a, i));
        mcv_axis_extend(ys, plotted(b, i));
    }
    const mcv_axis x = mcv_axis_over(xs[0], xs[1], false, MCV_PLOT_LEFT,
                                     MCV_PLOT_WIDTH - MCV_PLOT_RIGHT),
                   y = mcv_axis_over(ys[0], ys[1], false, MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM,
                                     MCV_PLOT_TOP);
    fputs("<figure>", out);
    mcv_axes_put(out, &x, &y, a->page->names[a->metric], b->page->names[b->metric]);
    for (size_t i = 0; i < f->count; ++i)
        if (!isnan(plotted(a, i) + plotted(b, i)))
            put_point(out, a->o, i, mcv_axis_place(&x, plotted(a, i)),
                      mcv_axis_place(&y, plotted(b, i)));
    put_stages(out);
}

static void put_plots(FILE *out, const mcv_optimization *o, const mcv_page *page) {
    fputs("<h2>What was evaluated</h2>\n<div class=\"plots\">", out);
    for (size_t k = 0; k < o->search.objectives; ++k) {
        const shown s = show(o, page, k);
        for (size_t i = 0; i < k; ++i) {
            const shown other = show(o, page, i);
            put_trade(out, &other, &s);
        }
        for (size_t i = 0; i <= o->sweep.plan.varied; ++i) put_plot(out, &s, i);
    }
    fputs("</div>\n", out);
}

bool mcv_optimization_put_results(FILE *out, const struct mcv_page *page, void *user) {
    const mcv_optimization *o = user;
    const bool ended =
        o->search.objectives > 1 ? o->found.point_count > 0 : o->found.winner.count > 0;
    if (!ended)
        put_unfinished(out, o);
    else if (o->search.objectives == 1)
        put_winner(out, o, page);
    if (ended) put_points(out, o, page);
    if (ended && o->search.objectives == 1) put_near(out, o, page);
    if (o->found.count > 0) put_plots(out, o, page);
    return true;
}
