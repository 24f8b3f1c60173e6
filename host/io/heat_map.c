/* SPDX-License-Identifier: Apache-2.0 */
#include "io/plots.h"

#include "io/axis.h"
#include "io/html.h"

#include <math.h>

/* Values of one parameter that cells are drawn for; steps of the bar of colours; the least width of
 * a cell that shows its number [CSS pixels]. */
enum { CELLS = 64, STEPS = 12, ROOMY = 44 };

static const int right = MCV_PLOT_WIDTH - MCV_PLOT_RIGHT,
                 bottom = MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM;

static double share(const double range[2], double value) {
    return range[1] > range[0] ? (value - range[0]) / (range[1] - range[0]) : 0.5;
}

static bool is_marked(const mcv_plots *p, size_t metric, size_t row) {
    return row == p->best && metric == p->best_metric;
}

/* The middle of a cell, or where it begins (middle 0). */
static double cell_x(size_t column, size_t columns, double middle) {
    return MCV_PLOT_LEFT + ((double)column + middle) * (right - MCV_PLOT_LEFT) / (double)columns;
}
static double cell_y(size_t line, size_t lines, double middle) {
    return bottom - ((double)line + middle) * (bottom - MCV_PLOT_TOP) / (double)lines;
}

static size_t index_of(const double *values, size_t count, double value) {
    size_t i = 0;
    while (i + 1 < count && values[i] != value) ++i;
    return i;
}

static void put_cell_numbers(FILE *out, const double *x, size_t columns, const double *y,
                             size_t lines) {
    const size_t step[2] = {1 + (columns - 1) / 10, 1 + (lines - 1) / 12};
    for (size_t i = 0; i < columns; i += step[0])
        fprintf(out, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.4g</text>\n",
                cell_x(i, columns, 0.5), bottom + 16, x[i]);
    for (size_t i = 0; i < lines; i += step[1])
        fprintf(out, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.4g</text>\n",
                MCV_PLOT_LEFT - 6, cell_y(i, lines, 0.5) + 4, y[i]);
}

/* So many that the range is told apart in steps of a hundredth. */
static int digits_of(const double range[2]) {
    const double largest = fmax(fabs(range[0]), fabs(range[1]));
    if (!(range[1] > range[0])) return 3;
    return (int)fmin(6, 3 + fmax(0, floor(log10(largest / (range[1] - range[0])))));
}

static void put_cells(FILE *out, const mcv_plots *p, size_t metric, const double range[2],
                      const double *x, size_t columns, const double *y, size_t lines) {
    const double width = cell_x(1, columns, 0) - cell_x(0, columns, 0),
                 height = cell_y(0, lines, 0) - cell_y(1, lines, 0);
    const int digits = digits_of(range);
    put_cell_numbers(out, x, columns, y, lines);
    for (int marked = 0; marked < 2; ++marked) /* the mark lies above all cells */
        for (size_t row = 0; row < p->row_count; ++row) {
            const double value = mcv_plots_value(p, metric, row), at = share(range, value);
            const size_t column = index_of(x, columns, mcv_plots_row(p, row)[0]),
                         line = index_of(y, lines, mcv_plots_row(p, row)[1]);
            if (!isfinite(value) || is_marked(p, metric, row) != (marked == 1)) continue;
            fprintf(out,
                    "<a href=\"#s%zu\"><rect%s x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" "
                    "height=\"%.1f\" fill=\"#%06x\"/>",
                    p->sets[row], marked ? " class=\"best\"" : "", cell_x(column, columns, 0),
                    cell_y(line, lines, 1), width, height, (unsigned)mcv_plots_colour(at));
            if (width >= ROOMY && height >= 14)
                fprintf(out,
                        "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\">"
                        "%.*g</text>",
                        at < 0.6 ? "on-dark" : "on-light", cell_x(column, columns, 0.5),
                        cell_y(line, lines, 0.5) + 4, digits, value);
            fputs("</a>\n", out);
        }
}

static void put_points(FILE *out, const mcv_plots *p, size_t metric, const double range[2],
                       const mcv_axis axes[2]) {
    for (size_t row = 0; row < p->row_count; ++row) {
        const double value = mcv_plots_value(p, metric, row);
        const double left = mcv_axis_place(axes, mcv_plots_row(p, row)[0]),
                     top = mcv_axis_place(axes + 1, mcv_plots_row(p, row)[1]);
        if (!isfinite(value)) continue;
        if (is_marked(p, metric, row))
            fprintf(out, "<circle class=\"best\" cx=\"%.1f\" cy=\"%.1f\" r=\"10\"/>", left, top);
        fprintf(out,
                "<a href=\"#s%zu\"><circle cx=\"%.1f\" cy=\"%.1f\" r=\"6\" fill=\"#%06x\"/></a>\n",
                p->sets[row], left, top, (unsigned)mcv_plots_colour(share(range, value)));
    }
}

static void put_bar(FILE *out, const char *name, const double range[2]) {
    fputs("<p class=\"legend\">", out);
    mcv_html_text(out, name);
    fprintf(out, " %.4g <svg class=\"bar\" viewBox=\"0 0 %d 1\" preserveAspectRatio=\"none\">",
            range[0], STEPS);
    for (int i = 0; i < STEPS; ++i)
        fprintf(out, "<path fill=\"#%06x\" d=\"M%d 0h1.1v1h-1.1z\"/>",
                (unsigned)mcv_plots_colour((i + 0.5) / STEPS), i);
    fprintf(out, "</svg> %.4g</p>\n", range[1]);
}

void mcv_plots_put_map(FILE *out, const mcv_plots *p, size_t metric) {
    double x[CELLS], y[CELLS], range[2] = {INFINITY, -INFINITY};
    for (size_t row = 0; row < p->row_count; ++row)
        mcv_axis_extend(range, mcv_plots_value(p, metric, row));
    if (!(range[0] <= range[1])) return;
    const size_t columns = mcv_plots_distinct(p, 0, x, CELLS),
                 lines = mcv_plots_distinct(p, 1, y, CELLS);
    fputs("<figure>", out);
    /* At least half of a grid's cells have a set; of Latin hypercubes one in each column has. */
    if (columns <= CELLS && lines <= CELLS && columns * lines <= 2 * p->row_count) {
        mcv_axes_put_names(out, p->parameters[0].name, p->parameters[1].name);
        put_cells(out, p, metric, range, x, columns, y, lines);
    } else {
        mcv_axis axes[2];
        for (size_t k = 0; k < 2; ++k) {
            double ends[2] = {INFINITY, -INFINITY};
            for (size_t row = 0; row < p->row_count; ++row)
                mcv_axis_extend(ends, mcv_plots_row(p, row)[k]);
            axes[k] = mcv_axis_over(ends[0], ends[1], p->parameters[k].logarithmic,
                                    k ? bottom : MCV_PLOT_LEFT, k ? MCV_PLOT_TOP : right);
        }
        mcv_axes_put(out, axes, axes + 1, p->parameters[0].name, p->parameters[1].name);
        put_points(out, p, metric, range, axes);
    }
    fputs("</svg>\n", out);
    put_bar(out, p->metrics[metric], range);
    fputs("</figure>\n", out);
}
