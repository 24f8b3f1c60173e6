/* SPDX-License-Identifier: Apache-2.0 */
#include "io/axis.h"

#include "io/html.h"

#include <math.h>

enum {
    MOST_TICKS = 12,
    DIGIT = 8 /* width of one [CSS pixels]: 0.64 of 12 in the widest usual fonts */
};

double mcv_axis_place(const mcv_axis *a, double value) {
    const double v = a->logarithmic ? log10(value) : value;
    return a->from + (v - a->low) / (a->high - a->low) * (a->to - a->from);
}

mcv_axis mcv_axis_over(double low, double high, bool logarithmic, double from, double to) {
    mcv_axis a = {logarithmic ? log10(low) : low, logarithmic ? log10(high) : high, from, to,
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

void mcv_axis_extend(double range[2], double value) {
    if (!isfinite(value)) return;
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* 1, 2 or 5 times a power of ten, five to ten of them; powers of ten on a logarithmic axis, and 2
 * and 5 times them where there are few. */
static size_t make_ticks(const mcv_axis *a, double ticks[MOST_TICKS]) {
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

void mcv_axes_put_names(FILE *out, const char *x_name, const char *y_name) {
    fprintf(out, "<svg class=\"plot\" viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"",
            MCV_PLOT_WIDTH, MCV_PLOT_HEIGHT);
    mcv_html_text(out, y_name);
    fputs(" over ", out);
    mcv_html_text(out, x_name);
    fprintf(out, "\">\n<text class=\"name\" x=\"%d\" y=\"%d\" text-anchor=\"middle\">",
            (MCV_PLOT_LEFT + MCV_PLOT_WIDTH - MCV_PLOT_RIGHT) / 2, MCV_PLOT_HEIGHT - 14);
    mcv_html_text(out, x_name);
    fprintf(out,
            "</text><text class=\"name\" transform=\"translate(14 %d) rotate(-90)\" "
            "text-anchor=\"middle\">",
            (MCV_PLOT_TOP + MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM) / 2);
    mcv_html_text(out, y_name);
    fputs("</text>\n", out);
}

/* The numbers of a horizontal axis, without those that would run into the one before. */
static void put_numbers_of_x(FILE *out, const mcv_axis *x, int y, const double *ticks,
                             size_t count) {
    double written = -INFINITY; /* to here */
    for (size_t i = 0; i < count; ++i) {
        char words[32];
        const double half = snprintf(words, sizeof words, "%.4g", ticks[i]) * DIGIT / 2.0,
                     at = mcv_axis_place(x, ticks[i]);
        if (at - half < written) continue;
        written = at + half + DIGIT;
        fprintf(out, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n", at, y, words);
    }
}

void mcv_axes_put(FILE *out, const mcv_axis *x, const mcv_axis *y, const char *x_name,
                  const char *y_name) {
    const int right = MCV_PLOT_WIDTH - MCV_PLOT_RIGHT, bottom = MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM;
    double ticks[MOST_TICKS];
    mcv_axes_put_names(out, x_name, y_name);
    size_t count = make_ticks(x, ticks);
    fprintf(out, "<rect class=\"frame\" x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\"/>\n",
            MCV_PLOT_LEFT, MCV_PLOT_TOP, right - MCV_PLOT_LEFT, bottom - MCV_PLOT_TOP);
    for (size_t i = 0; i < count; ++i)
        fprintf(out, "<path class=\"grid\" d=\"M%.1f %dV%d\"/>", mcv_axis_place(x, ticks[i]),
                MCV_PLOT_TOP, bottom);
    put_numbers_of_x(out, x, bottom + 16, ticks, count);
    count = make_ticks(y, ticks);
    for (size_t i = 0; i < count; ++i)
        fprintf(out,
                "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" "
                "text-anchor=\"end\">%.4g</text>\n",
                MCV_PLOT_LEFT, mcv_axis_place(y, ticks[i]), right, MCV_PLOT_LEFT - 6,
                mcv_axis_place(y, ticks[i]) + 4, ticks[i]);
}
