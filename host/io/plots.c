/* SPDX-License-Identifier: Apache-2.0 */
#include "io/plots.h"

#include "io/axis.h"
#include "io/colormap.h"
#include "io/html.h"

#include <math.h>
#include <stdlib.h>

enum { LEGEND = 8 }; /* values of the second parameter that have a curve each */

double mcv_plots_uncertainty(const mcv_plots *p, size_t metric, size_t row) {
    const double u = mcv_plots_row(p, row)[p->parameter_count + 2 * metric + 1];
    return isfinite(u) ? u : 0;
}

size_t mcv_plots_distinct(const mcv_plots *p, size_t parameter, double *values, size_t most) {
    size_t count = 0;
    for (size_t row = 0; row < p->row_count; ++row) {
        const double value = mcv_plots_row(p, row)[parameter];
        size_t i = 0;
        while (i < count && values[i] < value) ++i;
        if (i < count && values[i] == value) continue;
        if (count == most) return most + 1;
        for (size_t k = count++; k > i; --k) values[k] = values[k - 1];
        values[i] = value;
    }
    return count;
}

/* Both ends of viridis are hard to see, on black and on white. */
uint32_t mcv_plots_colour(double position) {
    return mcv_colormap_rgb(MCV_COLORMAP_VIRIDIS, 0.12 + 0.76 * position);
}

typedef struct plot {
    const mcv_plots *p;
    size_t x, second; /* parameters; second: the one that gives the colour; parameter_count: none */
    size_t metric;
    double seconds[2]; /* its range */
} plot;

static uint32_t colour(const plot *c, size_t row) {
    if (!(c->seconds[1] > c->seconds[0])) return mcv_plots_colour(0.3);
    const double value = mcv_plots_row(c->p, row)[c->second];
    return mcv_plots_colour((value - c->seconds[0]) / (c->seconds[1] - c->seconds[0]));
}

/* Rows whose parameters but x are equal are one curve; they follow each other in x. */
static int in_order(const void *left, const void *right, void *user) {
    const plot *c = user;
    const double *a = mcv_plots_row(c->p, *(const size_t *)left),
                 *b = mcv_plots_row(c->p, *(const size_t *)right);
    for (size_t i = 0; i < c->p->parameter_count; ++i)
        if (i != c->x && a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return a[c->x] < b[c->x] ? -1 : a[c->x] > b[c->x];
}

static bool same_curve(const plot *c, size_t a, size_t b) {
    for (size_t i = 0; i < c->p->parameter_count; ++i)
        if (i != c->x && mcv_plots_row(c->p, a)[i] != mcv_plots_row(c->p, b)[i]) return false;
    return true;
}

static void put_legend(FILE *out, const plot *c) {
    double values[LEGEND];
    const size_t count = mcv_plots_distinct(c->p, c->second, values, LEGEND);
    if (count > LEGEND) {
        values[0] = c->seconds[0];
        values[1] = c->seconds[1];
    }
    fputs("<p class=\"legend\">", out);
    mcv_html_text(out, c->p->parameters[c->second].name);
    for (size_t i = 0; i < (count > LEGEND ? 2 : count); ++i)
        fprintf(out,
                "%s <svg class=\"dot\" viewBox=\"0 0 8 8\"><circle cx=\"4\" cy=\"4\" r=\"4\" "
                "fill=\"#%06x\"/></svg> %.4g",
                i && count > LEGEND ? " to" : "",
                (unsigned)mcv_plots_colour((values[i] - c->seconds[0]) /
                                           (c->seconds[1] - c->seconds[0])),
                values[i]);
    fputs("</p>\n", out);
}

/* One curve: the line, all error bars, and the points. */
static void put_curve(FILE *out, const plot *c, const size_t *rows, size_t count, const mcv_axis *x,
                      const mcv_axis *y) {
    const char *pen = "M";
    const unsigned rgb = colour(c, rows[0]);
    fprintf(out, "<g stroke=\"#%06x\" fill=\"#%06x\"><path class=\"curve\" d=\"", rgb, rgb);
    for (size_t i = 0; i < count; ++i) {
        const double value = mcv_plots_value(c->p, c->metric, rows[i]);
        if (isfinite(value))
            fprintf(out, "%s%.1f %.1f", pen, mcv_axis_place(x, mcv_plots_row(c->p, rows[i])[c->x]),
                    mcv_axis_place(y, value));
        pen = isfinite(value) ? "L" : "M";
    }
    fputs("\"/><path d=\"", out);
    for (size_t i = 0; i < count; ++i) {
        const double value = mcv_plots_value(c->p, c->metric, rows[i]),
                     u = mcv_plots_uncertainty(c->p, c->metric, rows[i]),
                     at = mcv_axis_place(x, mcv_plots_row(c->p, rows[i])[c->x]);
        if (isfinite(value) && u > 0)
            fprintf(out, "M%.1f %.1fV%.1f", at, mcv_axis_place(y, value - u),
                    mcv_axis_place(y, value + u));
    }
    fputs("\"/>\n", out);
    for (size_t i = 0; i < count; ++i) {
        const double value = mcv_plots_value(c->p, c->metric, rows[i]);
        const bool best = rows[i] == c->p->best && c->metric == c->p->best_metric;
        if (!isfinite(value)) continue;
        const double left = mcv_axis_place(x, mcv_plots_row(c->p, rows[i])[c->x]),
                     top = mcv_axis_place(y, value);
        if (best)
            fprintf(out, "<circle class=\"best\" cx=\"%.1f\" cy=\"%.1f\" r=\"8\"/>", left, top);
        fprintf(out, "<a href=\"#s%zu\"><circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\"/></a>\n",
                c->p->sets[rows[i]], left, top);
    }
    fputs("</g>\n", out);
}

/* The first parameter besides x that has several values. */
static size_t find_second(const mcv_plots *p, size_t x) {
    double one[1];
    for (size_t i = 0; i < p->parameter_count; ++i)
        if (i != x && mcv_plots_distinct(p, i, one, 1) > 1) return i;
    return p->parameter_count;
}

bool mcv_plots_put_curves(FILE *out, const mcv_plots *p, size_t metric, size_t parameter) {
    plot c = {p, parameter, find_second(p, parameter), metric, {INFINITY, -INFINITY}};
    double x_range[2] = {INFINITY, -INFINITY}, y_range[2] = {INFINITY, -INFINITY};
    size_t *order = calloc(p->row_count + 1, sizeof *order);
    if (!order) return false;
    for (size_t row = 0; row < p->row_count; ++row) {
        const double value = mcv_plots_value(p, metric, row),
                     u = mcv_plots_uncertainty(p, metric, row);
        order[row] = row;
        mcv_axis_extend(x_range, mcv_plots_row(p, row)[parameter]);
        if (c.second < p->parameter_count)
            mcv_axis_extend(c.seconds, mcv_plots_row(p, row)[c.second]);
        mcv_axis_extend(y_range, value - u);
        mcv_axis_extend(y_range, value + u);
    }
    const mcv_axis x = mcv_axis_over(x_range[0], x_range[1], p->parameters[parameter].logarithmic,
                                     MCV_PLOT_LEFT, MCV_PLOT_WIDTH - MCV_PLOT_RIGHT);
    const mcv_axis y = mcv_axis_over(y_range[0], y_range[1], false,
                                     MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM, MCV_PLOT_TOP);
    qsort_r(order, p->row_count, sizeof *order, in_order, &c);
    fputs("<figure>", out);
    mcv_axes_put(out, &x, &y, p->parameters[parameter].name, p->metrics[metric]);
    for (size_t begin = 0, end; begin < p->row_count; begin = end) {
        for (end = begin + 1; end < p->row_count && same_curve(&c, order[begin], order[end]);)
            ++end;
        put_curve(out, &c, order + begin, end - begin, &x, &y);
    }
    fputs("</svg>\n", out);
    if (c.second < p->parameter_count) put_legend(out, &c);
    fputs("</figure>\n", out);
    free(order);
    return true;
}
