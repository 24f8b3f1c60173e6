/* SPDX-License-Identifier: Apache-2.0 */
#include "pod/page_plots.h"

#include "io/axis.h"

#include <math.h>

enum { POINTS = 81 }; /* of a curve */

/* Sizes are shown in the unit that suits the largest one. */
static double shown_unit(const mcv_pod_study *s, const char **name) {
    *name = "";
    if (!s->asked.metres) return 1;
    *name = s->pod.largest < 1e-3 ? " [µm]" : s->pod.largest < 1 ? " [mm]" : " [m]";
    return s->pod.largest < 1e-3 ? 1e6 : s->pod.largest < 1 ? 1e3 : 1;
}

typedef struct plot {
    const mcv_pod_study *study;
    mcv_axis x, y;
    double per_unit;
} plot;

static plot open_plot(FILE *out, const mcv_pod_study *s, const char *size_name, double low,
                      double high, const char *y_name) {
    const char *unit;
    char name[320];
    plot p = {.study = s, .per_unit = shown_unit(s, &unit)};
    snprintf(name, sizeof name, "%s%s", size_name, unit);
    p.x = mcv_axis_over(s->pod.smallest * p.per_unit, s->pod.largest * p.per_unit, s->pod.log_size,
                        MCV_PLOT_LEFT, MCV_PLOT_WIDTH - MCV_PLOT_RIGHT);
    p.y = mcv_axis_over(low, high, false, MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM, MCV_PLOT_TOP);
    fputs("<figure>", out);
    mcv_axes_put(out, &p.x, &p.y, name, y_name);
    return p;
}

static void close_plot(FILE *out, const char *caption) {
    fprintf(out, "</svg><figcaption>%s</figcaption></figure>\n", caption);
}

static double left(const plot *p, double size) { return mcv_axis_place(&p->x, size * p->per_unit); }

static double size_at(const mcv_pod_study *s, int i) {
    const double share = (double)i / (POINTS - 1), from = s->pod.smallest, to = s->pod.largest;
    return s->pod.log_size ? from * pow(to / from, share) : from + share * (to - from);
}

static void put_line(FILE *out, const plot *p, double from, double to, double y) {
    fprintf(out, "<path class=\"dimension\" d=\"M%.1f %.1fH%.1f\"/>\n", left(p, from),
            mcv_axis_place(&p->y, y), left(p, to));
}

/* A size on the curve, with a word. */
static void put_mark(FILE *out, const plot *p, double size, const char *word, bool before) {
    const double x = left(p, size), y = mcv_axis_place(&p->y, 0.9);
    if (isnan(size)) return;
    fprintf(out,
            "<path class=\"dimension\" d=\"M%.1f %.1fV%.1f\"/><circle class=\"best\" cx=\"%.1f\" "
            "cy=\"%.1f\" r=\"5\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%s</text>\n",
            x, y, mcv_axis_place(&p->y, 0), x, y, before ? x - 6 : x + 6,
            mcv_axis_place(&p->y, 0.04), before ? "end" : "start", word);
}

static void put_band(FILE *out, const plot *p) {
    const mcv_pod_study *s = p->study;
    mcv_pod_point points[POINTS];
    for (int i = 0; i < POINTS; ++i) points[i] = mcv_pod_at(&s->pod, size_at(s, i));
    if (!isnan(points[0].low)) {
        fputs("<polygon fill=\"#0072b2\" fill-opacity=\".2\" stroke=\"none\" points=\"", out);
        for (int i = 0; i < POINTS; ++i)
            fprintf(out, "%.1f,%.1f ", left(p, size_at(s, i)),
                    mcv_axis_place(&p->y, points[i].low));
        for (int i = POINTS; i-- > 0;)
            fprintf(out, "%.1f,%.1f ", left(p, size_at(s, i)),
                    mcv_axis_place(&p->y, points[i].high));
        fputs("\"/>\n", out);
    }
    fputs("<g stroke=\"#0072b2\"><path d=\"", out);
    for (int i = 0; i < POINTS; ++i)
        fprintf(out, "%s%.1f %.1f", i ? "L" : "M", left(p, size_at(s, i)),
                mcv_axis_place(&p->y, points[i].value));
    fputs("\"/></g>\n", out);
}

static void put_points(FILE *out, const plot *p, bool as_hits) {
    const mcv_pod_study *s = p->study;
    fputs("<g fill=\"#b0418f\" fill-opacity=\".55\">", out);
    for (size_t i = 0; i < s->count; ++i) {
        const double value = !as_hits           ? s->values[i]
                             : s->asked.signals ? s->values[i] >= s->threshold
                                                : s->values[i];
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.5\"/>", left(p, s->sizes[i]),
                mcv_axis_place(&p->y, value));
    }
    fputs("</g>\n", out);
}

void mcv_pod_put_curve(FILE *out, const mcv_pod_study *s, const char *size_name) {
    char caption[256], words[64];
    const plot p = open_plot(out, s, size_name, 0, 1, "probability of detection");
    snprintf(words, sizeof words, "a90/%g", 100 * s->asked.confidence);
    put_points(out, &p, true);
    if (s->pod.fitted) {
        put_band(out, &p);
        put_line(out, &p, s->pod.smallest, s->pod.largest, 0.9);
        if (s->pod.a90.high_known == MCV_POD_FOUND)
            put_mark(out, &p, s->pod.a90.high, words, false);
        if (s->pod.a90.value_known == MCV_POD_FOUND)
            put_mark(out, &p, s->pod.a90.value, "a90", true);
    }
    snprintf(caption, sizeof caption, "%s A dot is a defect: above, found; below, missed.",
             !s->pod.fitted ? "There is no curve."
             : s->pod.a90.high_known == MCV_POD_TOO_FEW
                 ? "The curve has no band: there are too few hits or misses."
                 : "The curve and its band. Each edge of the band holds with the confidence by "
                   "itself.");
    close_plot(out, caption);
}

static double signal_of(const mcv_pod_study *s, double y) { return s->pod.log_signal ? exp(y) : y; }

/* The line's signal at a size; side: -1 and 1 are its dashed lines. */
static double fitted(const mcv_pod_study *s, double size, int side) {
    const mcv_response *r = &s->pod.response;
    const double x = s->pod.log_size ? log(size) : size;
    return signal_of(s, r->intercept + r->slope * x + 1.6449 * side * r->scatter);
}

/* The line and, about it, where nine of ten signals of a size lie. */
static void put_fit(FILE *out, const plot *p) {
    const mcv_pod_study *s = p->study;
    for (int k = -1; k <= 1; ++k) {
        fprintf(out, "<g stroke=\"#0072b2\"%s><path d=\"",
                k ? " stroke-dasharray=\"4 4\" opacity=\".6\"" : "");
        for (int i = 0; i < POINTS; ++i) {
            const double size = size_at(s, i);
            fprintf(out, "%s%.1f %.1f", i ? "L" : "M", left(p, size),
                    mcv_axis_place(&p->y, fitted(s, size, k)));
        }
        fputs("\"/></g>\n", out);
    }
}

void mcv_pod_put_signals(FILE *out, const mcv_pod_study *s, const char *size_name,
                         const char *signal_name) {
    double range[2] = {INFINITY, -INFINITY};
    for (size_t i = 0; i < s->count; ++i) mcv_axis_extend(range, s->values[i]);
    mcv_axis_extend(range, s->threshold);
    for (int k = 0; k < 4; ++k) /* the ends of the dashed lines */
        mcv_axis_extend(range, fitted(s, k / 2 ? s->pod.largest : s->pod.smallest, k % 2 ? 1 : -1));
    const plot p = open_plot(out, s, size_name, range[0], range[1], signal_name);
    put_points(out, &p, false);
    put_fit(out, &p);
    put_line(out, &p, s->pod.smallest, s->pod.largest, s->threshold);
    close_plot(out, "The signal of each defect, the fitted line, and within the dashed lines nine "
                    "of ten signals. The level line is the threshold.");
}
