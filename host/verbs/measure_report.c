/* SPDX-License-Identifier: Apache-2.0 */
/* The report of `mcvisi measure`. */
#include "analysis/metrics.h"
#include "verbs/measure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void put(mcv_report *report, const char *key, const char *unit, mcv_quantity q) {
    mcv_report_quantity(report, key, unit, q.value, q.uncertainty);
}

static void know_noise(mcv_subject *s, mcv_roi *region) {
    mcv_know_noise(&s->readings, s->noise, s->whole, region);
}

/* Why the ratio is missing. */
static void explain(mcv_report *report, const char *key, double samples) {
    char words[160];
    mcv_samples_words(samples, words);
    if (samples > 0) mcv_report_text(report, key, words);
}

static void report_region(mcv_subject *s, mcv_report *report, mcv_roi *region,
                          mcv_roi *background) {
    uint64_t saturated = 0;
    for (size_t i = 0; i < (size_t)region->width * region->height; ++i)
        saturated += region->inside[i] && (double)s->readings.values.pixels[i] >= s->largest;
    if (background) know_noise(s, background);
    know_noise(s, region);
    const mcv_roi_figures f = mcv_roi_measure(&s->readings, region);
    mcv_report_element(report, region->name, "region");
    mcv_report_number(report, "pixels", "", (double)f.count);
    put(report, "mean", s->unit, f.mean);
    put(report, "deviation", s->unit, f.deviation);
    mcv_report_number(report, "noise", s->unit, f.noise);
    if (s->readings.render.pixels)
        mcv_report_number(report, "render_noise", s->unit, f.render_noise);
    mcv_report_number(report, "smallest", s->unit, f.smallest);
    mcv_report_number(report, "largest", s->unit, f.largest);
    if (isfinite(s->largest))
        mcv_report_number(report, "saturated", "", (double)saturated / (double)f.count);
    put(report, "snr", "", f.snr);
    explain(report, "no_snr", f.samples);
    put(report, "rms_contrast", "", f.rms_contrast);
    put(report, "uniformity", "", f.uniformity);
    if (background) {
        const mcv_contrast_figures c = mcv_roi_contrast(&s->readings, region, background);
        put(report, "difference", s->unit, c.difference);
        put(report, "weber_contrast", "", c.weber);
        put(report, "michelson_contrast", "", c.michelson);
        put(report, "contrast_to_noise", "", c.contrast_to_noise);
        explain(report, "no_contrast_to_noise", c.samples);
    }
    mcv_report_close(report);
}

static void report_regions(mcv_subject *s, mcv_report *report) {
    if (s->region_count == 0) return;
    mcv_report_list(report, "regions");
    for (size_t i = 0; i < s->region_count; ++i)
        report_region(s, report, s->regions + i, s->background.inside ? &s->background : NULL);
    mcv_report_close(report);
}

static void report_values(mcv_report *report, const char *key, const mcv_quantity *q, size_t count,
                          bool uncertainties) {
    double *values = malloc(count * sizeof *values);
    for (size_t i = 0; values && i < count; ++i)
        values[i] = uncertainties ? q[i].uncertainty : q[i].value;
    if (values) mcv_report_numbers(report, key, "", "", values, count);
    free(values);
}

/* The curves are in the JSON only. */
static void report_spread(const mcv_subject *s, mcv_report *report, const mcv_edge *edge) {
    mcv_edge_mtf m;
    mcv_error why = {""};
    if (mcv_edge_spread(&s->readings, edge, &m, &why) != MCV_OK) {
        mcv_report_text(report, "no_mtf", why.text);
        return;
    }
    put(report, "mtf50", "cycles/pixel", m.mtf50);
    put(report, "mtf_at_nyquist", "", m.nyquist);
    if (report->json) {
        mcv_report_numbers(report, "frequency", "", "", m.frequency, MCV_MTF_COUNT);
        report_values(report, "mtf", m.modulation, MCV_MTF_COUNT, false);
        report_values(report, "mtf_uncertainty", m.modulation, MCV_MTF_COUNT, true);
        mcv_report_numbers(report, "place", "", "", m.place, m.count);
        report_values(report, "esf", m.esf, m.count, false);
        report_values(report, "esf_uncertainty", m.esf, m.count, true);
        mcv_report_numbers(report, "lsf", "", "", m.lsf, m.count);
    }
    mcv_edge_mtf_free(&m);
}

static void put_length(mcv_report *report, const char *key, mcv_quantity pixels, double scale) {
    mcv_report_quantity(report, key, "m", pixels.value * scale, pixels.uncertainty * scale);
}

static void report_edge(const mcv_subject *s, mcv_report *report, const mcv_edge *edge) {
    mcv_report_element(report, edge->name, "edge");
    mcv_report_numbers(report, "point", "pixels", ", ", edge->point, 2);
    put(report, edge->across_rows ? "column" : "row", "pixels", edge->position);
    put(report, "tilt", "rad", edge->tilt);
    put(report, "dark", s->unit, edge->dark);
    put(report, "bright", s->unit, edge->bright);
    put(report, "width_10_90", "pixels", edge->width_10_90);
    put_length(report, "width_10_90_length", edge->width_10_90,
               mcv_scale_along(s->pixel, edge->normal));
    put(report, "sagitta", "pixels", edge->sagitta);
    report_spread(s, report, edge);
    mcv_report_close(report);
}

static void report_line(const mcv_subject *s, mcv_report *report, const mcv_line *line) {
    const mcv_edge *edge = &line->edge;
    mcv_report_element(report, edge->name, "line");
    mcv_report_numbers(report, "point", "pixels", ", ", edge->point, 2);
    put(report, edge->across_rows ? "column" : "row", "pixels", edge->position);
    put(report, "tilt", "rad", edge->tilt);
    put(report, "straightness", "pixels", line->straightness);
    put_length(report, "straightness_length", line->straightness,
               mcv_scale_along(s->pixel, edge->normal));
    mcv_report_close(report);
}

static void report_caliper(const mcv_subject *s, mcv_report *report, const mcv_caliper *caliper) {
    const mcv_edge *first = caliper->edges, *second = first + 1;
    mcv_report_element(report, caliper->name, "caliper");
    put(report, "width", "pixels", caliper->width);
    put_length(report, "width_length", caliper->width, mcv_scale_along(s->pixel, first->normal));
    put(report, "angle", "rad", caliper->angle);
    put(report, first->across_rows ? "first_column" : "first_row", "pixels", first->position);
    put(report, first->across_rows ? "second_column" : "second_row", "pixels", second->position);
    mcv_report_close(report);
}

static void report_circle(const mcv_subject *s, mcv_report *report, const mcv_circle *circle) {
    const double scale = mcv_scale_along(s->pixel, NULL);
    mcv_report_element(report, circle->name, circle->whole ? "circle" : "arc");
    put(report, "column", "pixels", circle->column);
    put(report, "row", "pixels", circle->row);
    put(report, "radius", "pixels", circle->radius);
    put_length(report, "radius_length", circle->radius, scale);
    put(report, "diameter", "pixels", circle->diameter);
    put_length(report, "diameter_length", circle->diameter, scale);
    put(report, "roundness", "pixels", circle->roundness);
    put_length(report, "roundness_length", circle->roundness, scale);
    mcv_report_number(report, "seen", "", circle->seen);
    mcv_report_number(report, "rejected", "", circle->rejected);
    mcv_report_text(report, "inside", circle->bright ? "bright" : "dark");
    mcv_report_close(report);
}

static void report_found(const mcv_subject *s, mcv_report *report, const mcv_found *found) {
    switch (found->form) {
    case MCV_FORM_EDGE:
        report_edge(s, report, &found->as.edge);
        break;
    case MCV_FORM_LINE:
        report_line(s, report, &found->as.line);
        break;
    case MCV_FORM_CALIPER:
        report_caliper(s, report, &found->as.caliper);
        break;
    default:
        report_circle(s, report, &found->as.circle);
    }
}

static void report_distance(const mcv_subject *s, mcv_report *report, const mcv_found *a,
                            const mcv_found *b) {
    const bool from_line = mcv_found_straight(a) && mcv_found_is_round(b);
    double direction[2];
    const mcv_quantity d = mcv_found_distance(a, b, direction);
    char name[136];
    snprintf(name, sizeof name, "%s to %s", mcv_found_name(a), mcv_found_name(b));
    mcv_report_element(report, name, "distance");
    if (isnan(d.value)) mcv_report_text(report, "no_distance", MCV_NOT_PARALLEL);
    put(report, from_line ? "line_distance" : "distance", "pixels", d);
    put_length(report, from_line ? "line_length" : "length", d,
               mcv_scale_along(s->pixel, direction));
    mcv_report_close(report);
}

/* From the first edge or line to all others and to all circles, and from the first circle to the
 * others. */
static void report_distances(const mcv_subject *s, mcv_report *report) {
    const mcv_found *line = NULL, *circle = NULL, *end = s->found + s->found_count;
    bool open = false;
    for (const mcv_found *f = s->found; f < end; ++f) {
        const bool straight = mcv_found_straight(f), round = mcv_found_is_round(f);
        if (!open && ((straight && line) || (round && (line || circle)))) {
            mcv_report_list(report, "distances");
            open = true;
        }
        if (line && (straight || round)) report_distance(s, report, line, f);
        if (circle && round) report_distance(s, report, circle, f);
        if (straight && !line) line = f;
        if (round && !circle) circle = f;
    }
    if (open) mcv_report_close(report);
}

static void report_boxes(const mcv_subject *s, mcv_report *report) {
    static const char *const lists[] = {
#define MCV_X(form, FORM, figures, what) #form "s",
        MCV_FORMS(MCV_X)
#undef MCV_X
    };
    for (size_t i = 0; i < s->found_count; ++i) {
        const mcv_found *f = s->found + i;
        if (i == 0 || f->form != f[-1].form) mcv_report_list(report, lists[f->form]);
        report_found(s, report, f);
        if (i + 1 == s->found_count || f->form != f[1].form) mcv_report_close(report);
    }
    report_distances(s, report);
}

void mcv_subject_report(mcv_subject *s, mcv_report *report) {
    const mcv_image *image = &s->readings.values;
    mcv_report_text(report, "image", s->picture->path);
    if (s->minus) mcv_report_text(report, "minus", s->minus->path);
    mcv_report_numbers(report, "size", "", " x ", (const double[]){image->width, image->height}, 2);
    if (s->pixel[0] > 0) mcv_report_numbers(report, "object_pixel", "m", " x ", s->pixel, 2);
    mcv_report_text(report, "noise_from", s->noise ? s->noise : "the differences of neighbours");
    mcv_report_text(report, "render_error",
                    s->readings.render.pixels ? "taken out"
                                              : "not stated by the image: it is part of the noise");
    report_regions(s, report);
    report_boxes(s, report);
}
