/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/metrics.h"

#include "core/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- names --- */

static const char *const region_figures[] = {
#define MCV_X(member, name, unit) name,
    MCV_REGION_METRICS(MCV_X)
#undef MCV_X
};
static const char *const contrast_figures[] = {
#define MCV_X(member, name, unit) name,
    MCV_CONTRAST_METRICS(MCV_X)
#undef MCV_X
};
#define MCV_X(member, name, unit) name,
static const char *const edge_figures[] = {MCV_EDGE_METRICS(MCV_X) "mtf50", "mtf_at_nyquist",
                                           "width_10_90_length", "distance", "length"};
static const char *const line_figures[] = {MCV_LINE_METRICS(MCV_X) "straightness_length",
                                           "distance", "length"};
static const char *const caliper_figures[] = {MCV_CALIPER_METRICS(MCV_X) "width_length"};
static const char *const circle_figures[] = {MCV_CIRCLE_METRICS(MCV_X) "radius_length",
                                             "diameter_length",
                                             "roundness_length",
                                             "distance",
                                             "length",
                                             "line_distance",
                                             "line_length"};
#undef MCV_X

/* Of a region, too: how well its pixels tell a parameter. */
static const char bound_figure[] = "bound";

#define COUNT_OF(list) (sizeof(list) / sizeof((list)[0]))

typedef struct form_entry {
    const char *option, *what;
    const char *const *figures;
    size_t figure_count;
} form_entry;

static const form_entry forms[MCV_FORM_COUNT] = {
#define MCV_X(form, FORM, kind, what) {#form, what, kind##_figures, COUNT_OF(kind##_figures)},
    MCV_FORMS(MCV_X)
#undef MCV_X
};

static bool is_in(const char *word, const char *const *list, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (strcmp(word, list[i]) == 0) return true;
    return false;
}

/* Which region (form: MCV_FORM_COUNT) or box, and which figure. */
typedef struct choice {
    unsigned form;
    size_t index;
    char figure[64];
} choice;

/* The place in the list of the text that begins with NAME=, or without a name has that number. */
static bool find_named(mcv_texts list, const char *name, size_t length, size_t *index) {
    for (size_t i = 0; i < list.count; ++i) {
        char own[64];
        const char *rest;
        double numbers[4];
        mcv_roi_numbers(list.items[i], i + 1, own, &rest, numbers, 4);
        if (strlen(own) != length || strncmp(own, name, length) != 0) continue;
        *index = i;
        return true;
    }
    return false;
}

static mcv_result fail_figure(const char *name, const char *figure, mcv_error *error) {
    const char *words[128];
    size_t count = 0;
    char list[1024] = "";
    for (size_t i = 0; i < COUNT_OF(region_figures); ++i) words[count++] = region_figures[i];
    for (size_t i = 0; i < COUNT_OF(contrast_figures); ++i) words[count++] = contrast_figures[i];
    words[count++] = bound_figure;
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f)
        for (size_t i = 0; i < forms[f].figure_count; ++i)
            if (!is_in(forms[f].figures[i], words, count)) words[count++] = forms[f].figures[i];
    const char *nearest = mcv_nearest_word(figure, words, count);
    if (nearest)
        return mcv_fail(error, MCV_USAGE,
                        "metric %s: there is no figure \"%s\"; did you mean \"%s\"?", name, figure,
                        nearest);
    for (size_t i = 0; i < count; ++i)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", words[i]);
    return mcv_fail(error, MCV_USAGE, "metric %s: there is no figure \"%s\"; there are %s", name,
                    figure, list);
}

static bool is_distance(const char *figure) {
    return strcmp(figure, "distance") == 0 || strcmp(figure, "length") == 0;
}

static bool is_from_line(const char *figure) {
    return strcmp(figure, "line_distance") == 0 || strcmp(figure, "line_length") == 0;
}

/* The first of these two forms that was given: where distances to others of them begin.
 * MCV_FORM_COUNT without one. */
static unsigned first_of(const mcv_places *places, unsigned a, unsigned b) {
    return places->boxes[a].count ? a : places->boxes[b].count ? b : MCV_FORM_COUNT;
}

static unsigned first_straight(const mcv_places *places) {
    return first_of(places, MCV_FORM_EDGE, MCV_FORM_LINE);
}

/* The form that a distance to this one begins with. */
static unsigned first_like(const mcv_places *places, unsigned index) {
    return index == MCV_FORM_CIRCLE || index == MCV_FORM_ARC
               ? first_of(places, MCV_FORM_CIRCLE, MCV_FORM_ARC)
               : first_straight(places);
}

/* The box that has the figure: by its name, or else the first; of distances the first that is not
 * where they begin. */
static bool find_box(const mcv_places *places, const char *name, const char *dot, choice *out) {
    const bool distance = is_distance(out->figure);
    for (out->form = 0; out->form < MCV_FORM_COUNT; ++out->form) {
        const mcv_texts boxes = places->boxes[out->form];
        if (!is_in(out->figure, forms[out->form].figures, forms[out->form].figure_count)) continue;
        out->index = !dot && distance && first_like(places, out->form) == out->form;
        if (dot ? find_named(boxes, name, (size_t)(dot - name), &out->index)
                : out->index < boxes.count)
            return true;
    }
    return false;
}

/* Whose figure it is and what was not given: the options as "--edge or --line". */
static mcv_result fail_box(const mcv_places *places, const char *name, const char *dot,
                           const char *figure, mcv_error *error) {
    char options[128] = "";
    const char *what = NULL;
    size_t given = 0;
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f) {
        if (!is_in(figure, forms[f].figures, forms[f].figure_count)) continue;
        snprintf(options + strlen(options), sizeof options - strlen(options), "%s--%s",
                 what ? " or " : "", forms[f].option);
        given += places->boxes[f].count;
        if (!what) what = forms[f].what;
    }
    if (given == 0)
        return mcv_fail(error, MCV_USAGE, "metric %s: give %s, %s", name, options, what);
    if (dot)
        return mcv_fail(error, MCV_USAGE, "metric %s: there is no %s with the name \"%.*s\"", name,
                        options, (int)(dot - name), name);
    return mcv_fail(error, MCV_USAGE,
                    "metric %s: is a distance from the first %s: name the other one", name,
                    options);
}

static mcv_result choose(const mcv_places *places, const char *name, choice *out,
                         mcv_error *error) {
    const char *dot = strrchr(name, '.');
    *out = (choice){.form = MCV_FORM_COUNT};
    snprintf(out->figure, sizeof out->figure, "%s", dot ? dot + 1 : name);
    const bool contrast = is_in(out->figure, contrast_figures, COUNT_OF(contrast_figures));
    const bool bound = strcmp(out->figure, bound_figure) == 0;
    bool boxed = false;
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f)
        boxed = boxed || is_in(out->figure, forms[f].figures, forms[f].figure_count);
    if (!contrast && !bound && !boxed &&
        !is_in(out->figure, region_figures, COUNT_OF(region_figures)))
        return fail_figure(name, out->figure, error);
    if (contrast && !places->background)
        return mcv_fail(error, MCV_USAGE,
                        "metric %s: give --background, the region to compare with", name);
    if (bound && !places->bound)
        return mcv_fail(error, MCV_USAGE,
                        "metric %s: give --bound PATH=STEP, the parameter and a small step of it",
                        name);
    if (!boxed) {
        if (dot && !find_named(places->regions, name, (size_t)(dot - name), &out->index))
            return mcv_fail(error, MCV_USAGE,
                            "metric %s: there is no --region with the name \"%.*s\"", name,
                            (int)(dot - name), name);
        return MCV_OK;
    }
    if (!find_box(places, name, dot, out)) return fail_box(places, name, dot, out->figure, error);
    if (is_distance(out->figure) && out->form == first_like(places, out->form) && out->index == 0)
        return mcv_fail(error, MCV_USAGE,
                        "metric %s: is a distance from the first --%s: name the other one", name,
                        forms[out->form].option);
    if (is_from_line(out->figure) && first_straight(places) == MCV_FORM_COUNT)
        return mcv_fail(error, MCV_USAGE,
                        "metric %s: give the --edge or --line from which it is measured", name);
    return MCV_OK;
}

mcv_result mcv_metric_known(void *user, const char *name, mcv_quantity *quantity,
                            mcv_error *error) {
    choice chosen;
    *quantity = (mcv_quantity){1, 0};
    return choose(user, name, &chosen, error);
}

/* --- figures --- */

static void know_noise(mcv_metrics *m, mcv_roi *region) {
    mcv_know_noise(&m->readings, m->known, m->whole, region);
}

void mcv_samples_words(double samples, char words[160]) {
    snprintf(words, 160,
             "the render's own noise is larger than the deviation: render at least %.2g times as "
             "many samples, or add a camera's noise",
             samples);
}

/* The Cramér-Rao bound: the step over the deviations by which it is seen. */
static mcv_result measure_bound(const mcv_metrics *m, const mcv_roi *region, mcv_quantity *quantity,
                                mcv_error *error) {
    mcv_pairs pairs = m->pairs->pairs;
    mcv_detection found;
    pairs.inside = region->inside;
    MCV_TRY(mcv_detect(&pairs, &m->pairs->camera, 0, NULL, &found, error));
    if (!(found.low > 0))
        return mcv_fail(error, MCV_FAILED,
                        "metric %s: the render's noise hides the step of --bound: render more "
                        "samples, or take a larger step",
                        bound_figure);
    quantity->value = m->step / found.detectability;
    quantity->uncertainty = quantity->value * found.squared.uncertainty / (2 * found.squared.value);
    return MCV_OK;
}

static mcv_result measure_region(mcv_metrics *m, const choice *chosen, mcv_quantity *quantity,
                                 mcv_error *error) {
    const mcv_places *places = m->places;
    const mcv_image *image = &m->readings.values;
    mcv_roi region, background = {0};
    char all[64];
    snprintf(all, sizeof all, "image=0,0,%u,%u", image->width, image->height);
    const char *text = places->regions.count ? places->regions.items[chosen->index] : all;
    MCV_TRY(mcv_roi_parse(text, chosen->index + 1, image, &region, error));
    if (strcmp(chosen->figure, bound_figure) == 0) {
        const mcv_result result = measure_bound(m, &region, quantity, error);
        mcv_roi_free(&region);
        return result;
    }
    if (places->background) {
        const mcv_result result = mcv_roi_parse(places->background, 0, image, &background, error);
        if (result != MCV_OK) mcv_roi_free(&region);
        MCV_TRY(result);
        know_noise(m, &background);
    }
    know_noise(m, &region);
    const mcv_roi_figures figures = mcv_roi_measure(&m->readings, &region);
    double samples = figures.samples;
#define MCV_X(member, name, unit) \
    if (strcmp(chosen->figure, name) == 0) *quantity = figures.member;
    MCV_REGION_METRICS(MCV_X)
#undef MCV_X
    if (places->background) {
        const mcv_contrast_figures contrast = mcv_roi_contrast(&m->readings, &region, &background);
        if (strcmp(chosen->figure, "contrast_to_noise") == 0) samples = contrast.samples;
#define MCV_X(member, name, unit) \
    if (strcmp(chosen->figure, name) == 0) *quantity = contrast.member;
        MCV_CONTRAST_METRICS(MCV_X)
#undef MCV_X
    }
    mcv_roi_free(&background);
    mcv_roi_free(&region);
    if (!isnan(quantity->value) || samples == 0) return MCV_OK;
    char words[160];
    mcv_samples_words(samples, words);
    return mcv_fail(error, MCV_FAILED, "metric %s: %s", chosen->figure, words);
}

static mcv_result find_box_of(mcv_metrics *m, unsigned index, size_t number, mcv_found *found,
                              mcv_error *error) {
    return mcv_locate(&m->readings, m->known, m->whole, index,
                      m->places->boxes[index].items[number], number + 1, found, error);
}

/* Whether the figure is of this name, or is the length (at this scale) of one that is. */
static bool is_figure(const char *figure, const char *name, mcv_quantity q, double scale,
                      mcv_quantity *quantity) {
    const size_t length = strlen(name);
    if (strncmp(figure, name, length) != 0) return false;
    const bool same = figure[length] == '\0', as_length = strcmp(figure + length, "_length") == 0;
    if (same) *quantity = q;
    if (as_length) *quantity = (mcv_quantity){q.value * scale, q.uncertainty * scale};
    return same || as_length;
}

static mcv_result measure_mtf(const mcv_metrics *m, const mcv_edge *edge, const char *figure,
                              mcv_quantity *quantity, mcv_error *error) {
    mcv_edge_mtf mtf;
    MCV_TRY(mcv_edge_spread(&m->readings, edge, &mtf, error));
    *quantity = strcmp(figure, "mtf50") == 0 ? mtf.mtf50 : mtf.nyquist;
    mcv_edge_mtf_free(&mtf);
    return MCV_OK;
}

static void take_figure(const mcv_found *found, const double pixel[2], const char *figure,
                        mcv_quantity *quantity) {
    const mcv_edge *straight = mcv_found_straight(found);
    const double across = mcv_scale_along(pixel, straight ? straight->normal : NULL);
#define MCV_X(member, name, unit) \
    if (is_figure(figure, name, of->member, scale, quantity)) return;
    if (found->form == MCV_FORM_EDGE) {
        const mcv_edge *of = &found->as.edge;
        const double scale = across;
        MCV_EDGE_METRICS(MCV_X)
    } else if (found->form == MCV_FORM_LINE) {
        const mcv_line *of = &found->as.line;
        const double scale = across;
        MCV_LINE_METRICS(MCV_X)
    } else if (found->form == MCV_FORM_CALIPER) {
        const mcv_caliper *of = &found->as.caliper;
        const double scale = mcv_scale_along(pixel, of->edges[0].normal);
        MCV_CALIPER_METRICS(MCV_X)
    } else {
        const mcv_circle *of = &found->as.circle;
        const double scale = across;
        MCV_CIRCLE_METRICS(MCV_X)
    }
#undef MCV_X
}

static mcv_result measure_box(mcv_metrics *m, const choice *chosen, mcv_quantity *quantity,
                              mcv_error *error) {
    const char *figure = chosen->figure;
    const bool from_line = is_from_line(figure);
    mcv_found found, first;
    double direction[2];
    MCV_TRY(find_box_of(m, chosen->form, chosen->index, &found, error));
    if (strncmp(figure, "mtf", 3) == 0)
        return measure_mtf(m, &found.as.edge, figure, quantity, error);
    if (!from_line && !is_distance(figure)) {
        take_figure(&found, m->pixel, figure, quantity);
        return MCV_OK;
    }
    MCV_TRY(find_box_of(m,
                        from_line ? first_straight(m->places) : first_like(m->places, chosen->form),
                        0, &first, error));
    *quantity = mcv_found_distance(&first, &found, direction);
    if (isnan(quantity->value))
        return mcv_fail(error, MCV_FAILED, "%s to %s: %s", mcv_found_name(&first),
                        mcv_found_name(&found), MCV_NOT_PARALLEL);
    const double scale = mcv_scale_along(m->pixel, direction);
    if (strstr(figure, "length"))
        *quantity = (mcv_quantity){quantity->value * scale, quantity->uncertainty * scale};
    return MCV_OK;
}

mcv_result mcv_metric_look_up(void *user, const char *name, mcv_quantity *quantity,
                              mcv_error *error) {
    mcv_metrics *m = user;
    choice chosen;
    *quantity = (mcv_quantity){NAN, NAN};
    MCV_TRY(choose(m->places, name, &chosen, error));
    MCV_TRY(chosen.form < MCV_FORM_COUNT ? measure_box(m, &chosen, quantity, error)
                                         : measure_region(m, &chosen, quantity, error));
    if (isnan(quantity->value))
        return mcv_fail(error, MCV_FAILED, "metric %s: this figure cannot be measured in the image",
                        name);
    return MCV_OK;
}
