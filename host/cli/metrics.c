/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/metrics.h"

#include "scene/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image, bool deviations, mcv_image *out,
                              mcv_error *error) {
    if (chosen > image->channels && chosen > 1)
        return mcv_fail(error, MCV_USAGE, "%s has %u channel%s: leave out --channel", path, image->channels,
                        image->channels > 1 ? "s" : "");
    MCV_TRY(mcv_image_new(out, image->width, image->height, 1, error));
    const size_t plane = (size_t)image->width * image->height;
    for (size_t i = 0; i < plane; ++i) {
        double sum = 0;
        for (uint32_t c = 0; c < image->channels; ++c) {
            const double value = image->pixels[c * plane + i];
            if (chosen == 0 || chosen - 1 == c) sum += deviations ? value * value : value;
        }
        const double count = chosen == 0 ? image->channels : 1;
        out->pixels[i] = (float)((deviations ? sqrt(sum) : sum) / count);
    }
    return MCV_OK;
}

/* --- names ------------------------------------------------------------------------------------------------------ */

static const char *const region_figures[] = {
#define MCV_X(member, name) name,
    MCV_REGION_METRICS(MCV_X)
#undef MCV_X
};
static const char *const contrast_figures[] = {
#define MCV_X(member, name) name,
    MCV_CONTRAST_METRICS(MCV_X)
#undef MCV_X
};
static const char *const edge_figures[] = {
#define MCV_X(member, name) name,
    MCV_EDGE_METRICS(MCV_X)
#undef MCV_X
        "mtf50",
    "mtf_at_nyquist", "width_10_90_length", "distance", "length"};

#define COUNT_OF(list) (sizeof(list) / sizeof((list)[0]))

static bool is_in(const char *word, const char *const *list, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (strcmp(word, list[i]) == 0) return true;
    return false;
}

/* Which region or edge, and which figure. */
typedef struct choice {
    bool edge;
    size_t index;
    char figure[64];
} choice;

/* The place in the list of the text that begins with NAME=, or without a name has that number. */
static bool find_named(const mcv_list *list, const char *name, size_t length, size_t *index) {
    for (size_t i = 0; i < list->count; ++i) {
        char own[64];
        const char *rest;
        double numbers[4];
        mcv_roi_numbers(list->items[i], i + 1, own, &rest, numbers, 4);
        if (strlen(own) != length || strncmp(own, name, length) != 0) continue;
        *index = i;
        return true;
    }
    return false;
}

static mcv_result fail_figure(const char *name, const char *figure, mcv_error *error) {
    const char *words[64];
    size_t count = 0;
    char list[512] = "";
    for (size_t i = 0; i < COUNT_OF(region_figures); ++i) words[count++] = region_figures[i];
    for (size_t i = 0; i < COUNT_OF(contrast_figures); ++i) words[count++] = contrast_figures[i];
    for (size_t i = 0; i < COUNT_OF(edge_figures); ++i) words[count++] = edge_figures[i];
    const char *nearest = mcv_nearest_word(figure, words, count);
    if (nearest) return mcv_fail(error, MCV_USAGE, "metric %s: there is no figure \"%s\"; did you mean \"%s\"?", name, figure, nearest);
    for (size_t i = 0; i < count; ++i) snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", words[i]);
    return mcv_fail(error, MCV_USAGE, "metric %s: there is no figure \"%s\"; there are %s", name, figure, list);
}

static mcv_result choose(const mcv_command *c, const char *name, choice *out, mcv_error *error) {
    const char *dot = strrchr(name, '.');
    *out = (choice){0};
    snprintf(out->figure, sizeof out->figure, "%s", dot ? dot + 1 : name);
    const bool contrast = is_in(out->figure, contrast_figures, COUNT_OF(contrast_figures));
    const bool region = contrast || is_in(out->figure, region_figures, COUNT_OF(region_figures));
    const bool edge = is_in(out->figure, edge_figures, COUNT_OF(edge_figures));
    if (!region && !edge) return fail_figure(name, out->figure, error);
    out->edge = edge;
    if (contrast && !c->background)
        return mcv_fail(error, MCV_USAGE, "metric %s: give --background, the region that it stands out of", name);
    if (edge && c->edge.count == 0) return mcv_fail(error, MCV_USAGE, "metric %s: give --edge, a rectangle with an edge in it", name);
    const bool distance = strcmp(out->figure, "distance") == 0 || strcmp(out->figure, "length") == 0;
    if (dot && !find_named(edge ? &c->edge : &c->region, name, (size_t)(dot - name), &out->index))
        return mcv_fail(error, MCV_USAGE, "metric %s: there is no --%s of the name \"%.*s\"", name, edge ? "edge" : "region",
                        (int)(dot - name), name);
    if (!dot && distance) out->index = 1;
    if (distance && (out->index == 0 || out->index >= c->edge.count))
        return mcv_fail(error, MCV_USAGE, "metric %s: is from the first --edge to another: name the other", name);
    return MCV_OK;
}

mcv_result mcv_metric_known(void *user, const char *name, mcv_quantity *quantity, mcv_error *error) {
    choice chosen;
    *quantity = (mcv_quantity){1, 0};
    return choose(user, name, &chosen, error);
}

/* --- figures ---------------------------------------------------------------------------------------------------- */

void mcv_know_noise(mcv_readings *readings, bool known, bool whole, mcv_roi *region) {
    if (!known) mcv_roi_estimate_noise(readings, region, whole ? sqrt(1.0 / 12) : 0);
}

static void know_noise(mcv_metrics *m, mcv_roi *region) { mcv_know_noise(&m->readings, m->known, m->whole, region); }

static mcv_result measure_region(mcv_metrics *m, const choice *chosen, mcv_quantity *quantity, mcv_error *error) {
    const mcv_command *c = m->command;
    const mcv_image *image = &m->readings.values;
    mcv_roi region, background = {0};
    char all[64];
    snprintf(all, sizeof all, "image=0,0,%u,%u", image->width, image->height);
    const char *text = c->region.count ? c->region.items[chosen->index] : all;
    MCV_TRY(mcv_roi_parse(text, chosen->index + 1, image, &region, error));
    if (c->background) {
        const mcv_result result = mcv_roi_parse(c->background, 0, image, &background, error);
        if (result != MCV_OK) mcv_roi_free(&region);
        MCV_TRY(result);
        know_noise(m, &background);
    }
    know_noise(m, &region);
    const mcv_roi_figures figures = mcv_roi_measure(&m->readings, &region);
#define MCV_X(member, name) \
    if (strcmp(chosen->figure, name) == 0) *quantity = figures.member;
    MCV_REGION_METRICS(MCV_X)
#undef MCV_X
    if (c->background) {
        const mcv_contrast_figures contrast = mcv_roi_contrast(&m->readings, &region, &background);
#define MCV_X(member, name) \
    if (strcmp(chosen->figure, name) == 0) *quantity = contrast.member;
        MCV_CONTRAST_METRICS(MCV_X)
#undef MCV_X
    }
    mcv_roi_free(&background);
    mcv_roi_free(&region);
    return MCV_OK;
}

mcv_result mcv_locate_edge(mcv_readings *readings, bool known, bool whole, const char *text, size_t number, mcv_edge *edge,
                           mcv_error *error) {
    char box[128];
    mcv_roi region;
    MCV_TRY(mcv_edge_parse(text, number, &readings->values, edge, error));
    if (!known) {
        snprintf(box, sizeof box, "%u,%u,%u,%u", edge->box.x, edge->box.y, edge->box.width, edge->box.height);
        MCV_TRY(mcv_roi_parse(box, number, &readings->values, &region, error));
        mcv_know_noise(readings, known, whole, &region);
        mcv_roi_free(&region);
    }
    return mcv_edge_find(readings, edge, error);
}

static mcv_result find_edge(mcv_metrics *m, size_t index, mcv_edge *edge, mcv_error *error) {
    return mcv_locate_edge(&m->readings, m->known, m->whole, m->command->edge.items[index], index + 1, edge, error);
}

static mcv_quantity scaled(mcv_quantity q, double factor) { return (mcv_quantity){q.value * factor, q.uncertainty * factor}; }

static mcv_result measure_edge(mcv_metrics *m, const choice *chosen, mcv_quantity *quantity, mcv_error *error) {
    const char *figure = chosen->figure;
    mcv_edge edge, first;
    mcv_edge_mtf mtf;
    MCV_TRY(find_edge(m, chosen->index, &edge, error));
    double along = m->pixel[0] > 0 ? hypot(edge.normal[0] * m->pixel[0], edge.normal[1] * m->pixel[1]) : NAN;
#define MCV_X(member, name) \
    if (strcmp(figure, name) == 0) *quantity = edge.member;
    MCV_EDGE_METRICS(MCV_X)
#undef MCV_X
    if (strcmp(figure, "width_10_90_length") == 0) *quantity = scaled(edge.width_10_90, along);
    if (strncmp(figure, "mtf", 3) == 0) {
        MCV_TRY(mcv_edge_spread(&m->readings, &edge, &mtf, error));
        *quantity = strcmp(figure, "mtf50") == 0 ? mtf.mtf50 : mtf.nyquist;
        mcv_edge_mtf_free(&mtf);
    }
    if (strcmp(figure, "distance") != 0 && strcmp(figure, "length") != 0) return MCV_OK;
    MCV_TRY(find_edge(m, 0, &first, error));
    *quantity = mcv_edge_distance(&first, &edge);
    quantity->value = fabs(quantity->value);
    along = m->pixel[0] > 0 ? hypot(first.normal[0] * m->pixel[0], first.normal[1] * m->pixel[1]) : NAN;
    if (strcmp(figure, "length") == 0) *quantity = scaled(*quantity, along);
    return MCV_OK;
}

mcv_result mcv_metric_look_up(void *user, const char *name, mcv_quantity *quantity, mcv_error *error) {
    mcv_metrics *m = user;
    choice chosen;
    *quantity = (mcv_quantity){NAN, NAN};
    MCV_TRY(choose(m->command, name, &chosen, error));
    MCV_TRY(chosen.edge ? measure_edge(m, &chosen, quantity, error) : measure_region(m, &chosen, quantity, error));
    if (isnan(quantity->value)) return mcv_fail(error, MCV_FAILED, "metric %s: the image gives no such figure", name);
    return MCV_OK;
}
