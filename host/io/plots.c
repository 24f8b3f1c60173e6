/* SPDX-License-Identifier: Apache-2.0 */
#include "io/plots.h"

#include "io/colormap.h"
#include "core/output_file.h"
#include "io/html.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of a plot [CSS pixels]. */
enum { WIDTH = 560, HEIGHT = 340, LEFT = 84, RIGHT = 16, TOP = 14, BOTTOM = 52, MOST_TICKS = 12 };
enum { LEGEND = 8 }; /* values of the second parameter that are told one by one */

/* --- axes --- */

/* From values to CSS pixels. */
typedef struct axis {
    double low, high; /* of what is shown; logarithms on a logarithmic axis */
    double from, to;  /* [CSS pixels] */
    bool logarithmic;
} axis;

static double place(const axis *a, double value) {
    const double v = a->logarithmic ? log10(value) : value;
    return a->from + (v - a->low) / (a->high - a->low) * (a->to - a->from);
}

static axis make_axis(double low, double high, bool logarithmic, double from, double to) {
    axis a = {logarithmic ? log10(low) : low, logarithmic ? log10(high) : high, from, to,
              logarithmic};
    if (!(a.high > a.low)) { /* one value, or none */
        const double middle = isfinite(a.low) ? a.low : 0,
                     half = middle != 0 ? 0.1 * fabs(middle) : 1;
        a.low = middle - half;
        a.high = middle + half;
    }
    const double room = 0.04 * (a.high - a.low);
    a.low -= room;
    a.high += room;
    return a;
}

/* 1, 2 or 5 times a power of ten, five to ten of them; powers of ten on a logarithmic axis, and 2
 * and 5 times them where there are few. */
static size_t make_ticks(const axis *a, double ticks[MOST_TICKS]) {
    size_t count = 0;
    if (a->logarithmic && a->high - a->low > 0.5) {
        static const double parts[] = {1, 2, 5};
        const int step = (int)ceil((a->high - a->low) / 6), minor = a->high - a->low < 3 ? 3 : 1;
        for (int decade = (int)floor(a->low); decade <= (int)ceil(a->high); decade += step)
            for (int i = 0; i < minor; ++i) {
                const double value = parts[i] * pow(10, decade);
                if (log10(value) >= a->low && log10(value) <= a->high && count < MOST_TICKS)
                    ticks[count++] = value;
            }
        return count;
    }
    const double low = a->logarithmic ? pow(10, a->low) : a->low,
                 high = a->logarithmic ? pow(10, a->high) : a->high;
    const double rough = (high - low) / 5, decade = pow(10, floor(log10(rough)));
    const double step = decade * (rough / decade >= 5 ? 5 : rough / decade >= 2 ? 2 : 1);
    for (double k = ceil(low / step); k * step <= high && count < MOST_TICKS; ++k)
        ticks[count++] = k * step + 0.0;
    return count;
}

static void put_axes(FILE *out, const axis *x, const axis *y, const char *x_name,
                     const char *y_name) {
    double ticks[MOST_TICKS];
    size_t count = make_ticks(x, ticks);
    fprintf(out, "<rect class=\"frame\" x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\"/>\n", LEFT,
            TOP, WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
    for (size_t i = 0; i < count; ++i)
        fprintf(out,
                "<path class=\"grid\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" "
                "text-anchor=\"middle\">%.4g</text>\n",
                place(x, ticks[i]), TOP, HEIGHT - BOTTOM, place(x, ticks[i]), HEIGHT - BOTTOM + 16,
                ticks[i]);
    count = make_ticks(y, ticks);
    for (size_t i = 0; i < count; ++i)
        fprintf(out,
                "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" "
                "text-anchor=\"end\">%.4g</text>\n",
                LEFT, place(y, ticks[i]), WIDTH - RIGHT, LEFT - 6, place(y, ticks[i]) + 4,
                ticks[i]);
    fprintf(out, "<text class=\"name\" x=\"%d\" y=\"%d\" text-anchor=\"middle\">",
            (LEFT + WIDTH - RIGHT) / 2, HEIGHT - 14);
    mcv_html_text(out, x_name);
    fprintf(out,
            "</text><text class=\"name\" transform=\"translate(14 %d) rotate(-90)\" "
            "text-anchor=\"middle\">",
            (TOP + HEIGHT - BOTTOM) / 2);
    mcv_html_text(out, y_name);
    fputs("</text>\n", out);
}

/* --- plots --- */

typedef struct plot {
    const mcv_plots *page;
    size_t x, second; /* parameters; second: the one that gives the colour; the number of
                         parameters: none */
    size_t metric;
} plot;

static const double *row_of(const mcv_plots *page, size_t row) {
    return page->values + row * (page->parameter_count + 2 * page->metric_count);
}
static double value_of(const plot *p, size_t row) {
    return row_of(p->page, row)[p->page->parameter_count + 2 * p->metric];
}
static double error_of(const plot *p, size_t row) {
    const double u = row_of(p->page, row)[p->page->parameter_count + 2 * p->metric + 1];
    return isfinite(u) ? u : 0;
}

static void extend(double range[2], double value) {
    if (!isfinite(value)) return;
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

static size_t distinct(const mcv_plots *page, size_t parameter, double *some, size_t most) {
    size_t count = 0;
    for (size_t row = 0; row < page->row_count; ++row) {
        const double value = row_of(page, row)[parameter];
        size_t i = 0;
        while (i < count && some[i] != value) ++i;
        if (i == count && count == most) return most + 1;
        if (i == count) some[count++] = value;
    }
    return count;
}

static uint32_t colour(const plot *p, const double range[2], double value) {
    if (p->second == p->page->parameter_count || !(range[1] > range[0])) return 0x2a6f97;
    const axis a = {range[0], range[1], 0, 0.9, false}; /* its yellow end is hard to see on white */
    return mcv_colormap_rgb(MCV_COLORMAP_VIRIDIS, place(&a, value));
}

/* Rows whose parameters but x are equal are one curve; they follow each other in x. */
static int in_order(const void *left, const void *right, void *user) {
    const plot *p = user;
    const double *a = row_of(p->page, *(const size_t *)left),
                 *b = row_of(p->page, *(const size_t *)right);
    for (size_t i = 0; i < p->page->parameter_count; ++i)
        if (i != p->x && a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return a[p->x] < b[p->x] ? -1 : a[p->x] > b[p->x];
}

static bool same_curve(const plot *p, size_t a, size_t b) {
    for (size_t i = 0; i < p->page->parameter_count; ++i)
        if (i != p->x && row_of(p->page, a)[i] != row_of(p->page, b)[i]) return false;
    return true;
}

static void put_legend(FILE *out, const plot *p, const double range[2]) {
    double values[LEGEND];
    const size_t count = distinct(p->page, p->second, values, LEGEND);
    if (count > LEGEND) {
        values[0] = range[0];
        values[1] = range[1];
    }
    fputs("<p class=\"legend\">", out);
    mcv_html_text(out, p->page->parameters[p->second].name);
    for (size_t i = 0; i < (count > LEGEND ? 2 : count); ++i)
        fprintf(out, "%s <span style=\"color:#%06x\">&#9679;</span> %.4g",
                i && count > LEGEND ? " to" : "", (unsigned)colour(p, range, values[i]), values[i]);
    fputs("</p>\n", out);
}

static void put_plot(FILE *out, const plot *p, size_t *order) {
    const mcv_plots *page = p->page;
    double x_range[2] = {INFINITY, -INFINITY}, y_range[2] = {INFINITY, -INFINITY},
           second[2] = {INFINITY, -INFINITY};
    for (size_t row = 0; row < page->row_count; ++row) {
        order[row] = row;
        extend(x_range, row_of(page, row)[p->x]);
        if (p->second < page->parameter_count) extend(second, row_of(page, row)[p->second]);
        extend(y_range, value_of(p, row) - error_of(p, row));
        extend(y_range, value_of(p, row) + error_of(p, row));
    }
    const axis x =
        make_axis(x_range[0], x_range[1], page->parameters[p->x].logarithmic, LEFT, WIDTH - RIGHT);
    const axis y = make_axis(y_range[0], y_range[1], false, HEIGHT - BOTTOM, TOP);
    qsort_r(order, page->row_count, sizeof *order, in_order, (void *)p);
    fprintf(out, "<figure><svg viewBox=\"0 0 %d %d\" width=\"%d\" height=\"%d\" role=\"img\">\n",
            WIDTH, HEIGHT, WIDTH, HEIGHT);
    put_axes(out, &x, &y, page->parameters[p->x].name, page->metrics[p->metric]);
    for (size_t i = 0; i < page->row_count; ++i) {
        const size_t row = order[i];
        const double value = value_of(p, row), u = error_of(p, row),
                     at = place(&x, row_of(page, row)[p->x]);
        if (!isfinite(value)) continue;
        const unsigned rgb =
            colour(p, second, p->second < page->parameter_count ? row_of(page, row)[p->second] : 0);
        fprintf(out, "<g stroke=\"#%06x\" fill=\"#%06x\">", rgb, rgb);
        if (i > 0 && isfinite(value_of(p, order[i - 1])) && same_curve(p, order[i - 1], row))
            fprintf(out, "<path class=\"curve\" d=\"M%.1f %.1fL%.1f %.1f\"/>",
                    place(&x, row_of(page, order[i - 1])[p->x]),
                    place(&y, value_of(p, order[i - 1])), at, place(&y, value));
        if (u > 0)
            fprintf(out, "<path d=\"M%.1f %.1fV%.1fm-3 0h6M%.1f %.1fh6\"/>", at,
                    place(&y, value - u), place(&y, value + u), at - 3, place(&y, value - u));
        fprintf(out,
                "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\"><title>%.6g: %.6g ± "
                "%.2g</title></circle></g>\n",
                at, place(&y, value), row_of(page, row)[p->x], value, u);
    }
    fputs("</svg>\n", out);
    if (p->second < page->parameter_count) put_legend(out, p, second);
    fputs("</figure>\n", out);
}

/* The first parameter besides x that has several values. */
static size_t find_second(const mcv_plots *page, size_t x) {
    double one[1];
    for (size_t i = 0; i < page->parameter_count; ++i)
        if (i != x && distinct(page, i, one, 1) > 1) return i;
    return page->parameter_count;
}

static void put_table(FILE *out, const mcv_plots *page) {
    fputs("<table><thead><tr>", out);
    for (size_t i = 0; i < page->parameter_count; ++i) {
        fputs("<th>", out);
        mcv_html_text(out, page->parameters[i].name);
    }
    for (size_t i = 0; i < page->metric_count; ++i) {
        fputs("<th>", out);
        mcv_html_text(out, page->metrics[i]);
    }
    fputs("</thead><tbody>\n", out);
    for (size_t row = 0; row < page->row_count; ++row) {
        const double *values = row_of(page, row);
        fputs("<tr>", out);
        for (size_t i = 0; i < page->parameter_count; ++i) fprintf(out, "<td>%.6g", values[i]);
        for (size_t i = 0; i < page->metric_count; ++i) {
            const double *metric = values + page->parameter_count + 2 * i;
            if (isnan(metric[0]))
                fputs("<td>", out);
            else
                fprintf(out, "<td>%.6g ± %.2g", metric[0], metric[1]);
        }
        if (page->messages[row]) {
            fputs("<td class=\"failed\">", out);
            mcv_html_text(out, page->messages[row]);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table>\n", out);
}

static void put_page(FILE *out, const mcv_plots *page, size_t *order) {
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>", out);
    mcv_html_text(out, page->title);
    fputs(
        "</title>\n<style>\nbody{font:15px/1.45 system-ui,sans-serif;color:#222;margin:2em "
        "auto;max-width:1180px;padding:0 1em}\n"
        "h1{font-size:1.4em}h2{font-size:1.1em;margin:1.6em 0 "
        ".4em}figure{display:inline-block;margin:0 1em 1em 0}\n"
        "svg text{font:11px system-ui,sans-serif;fill:#333}svg .name{font-size:12px}svg "
        "path{fill:none;stroke-width:1.2}\n"
        "svg .grid{stroke:#e4e4e4;stroke-width:1}svg .frame{fill:none;stroke:#999}svg "
        ".curve{stroke-width:1.2;opacity:.7}\n"
        ".legend{margin:0 0 0 84px;font-size:12px}table{border-collapse:collapse;font-size:13px}\n"
        "th,td{padding:2px 10px;text-align:right;border-bottom:1px solid "
        "#e4e4e4}.failed{color:#a22;text-align:left}\n"
        "</style></head><body>\n<h1>",
        out);
    mcv_html_text(out, page->title);
    fputs("</h1>\n<p>", out);
    mcv_html_text(out, page->text);
    fputs(" Error bars are one standard uncertainty to each side.</p>\n", out);
    for (size_t metric = 0; metric < page->metric_count; ++metric) {
        fputs("<h2>", out);
        mcv_html_text(out, page->metrics[metric]);
        fputs("</h2>\n", out);
        for (size_t x = 0; x < page->parameter_count; ++x)
            put_plot(out, &(plot){page, x, find_second(page, x), metric}, order);
    }
    fputs("<h2>All sets</h2>\n", out);
    put_table(out, page);
    fputs("</body></html>\n", out);
}

mcv_result mcv_plots_write(const char *path, const mcv_plots *page, mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    size_t *order = calloc(page->row_count + 1, sizeof *order);
    FILE *stream = order ? open_memstream(&text, &size) : NULL;
    if (stream) put_page(stream, page, order);
    free(order);
    if (!stream || fclose(stream) != 0) {
        free(text);
        return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    }
    const mcv_result result = mcv_output_whole(path, text, size, error);
    free(text);
    return result;
}
