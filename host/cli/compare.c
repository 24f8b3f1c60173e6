/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi compare: whether two renders of the same picture differ by more than their noise. */
#include "analysis/compare.h"
#include "cli/options.h"
#include "cli/picture.h"
#include "cli/report.h"
#include "output/exr.h"
#include "output/figure.h"
#include "output/file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One of the two files. */
typedef struct render {
    const char *path;
    mcv_exr exr;
    mcv_measured measured;
    mcv_film film; /* of the replicates' means, as of one sample each; empty where the file has none */
} render;

static const char *text_attribute(const mcv_exr *exr, const char *name) {
    const mcv_attribute *attribute = mcv_exr_attribute(exr, name);
    return attribute && attribute->text ? attribute->text : "unknown";
}

static double number_attribute(const mcv_exr *exr, const char *name) {
    const mcv_attribute *attribute = mcv_exr_attribute(exr, name);
    return attribute && !attribute->text && attribute->count == 1 ? attribute->numbers[0] : NAN;
}

static const mcv_image *find_part(const mcv_exr *exr, const char *name) {
    for (uint32_t p = 0; p < exr->part_count; ++p)
        if (strcmp(exr->parts[p].name, name) == 0) return &exr->parts[p].image;
    return NULL;
}

static bool is_finite(const mcv_image *image) {
    for (size_t i = 0; i < (size_t)image->width * image->height * image->channels; ++i)
        if (!isfinite(image->pixels[i])) return false;
    return true;
}

/* The film of the replicates, where the file holds them all. Ranks need numbers: images that are not finite stay without. */
static mcv_result gather_replicates(render *r, mcv_error *error) {
    const mcv_image *mean = r->measured.mean;
    const size_t count = (size_t)mean->width * mean->height * mean->channels;
    char name[32];
    for (uint32_t k = 0; k < r->measured.replicates; ++k) {
        snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, k);
        const mcv_image *image = find_part(&r->exr, name);
        const bool fits = image && image->width == mean->width && image->height == mean->height && image->channels == mean->channels;
        if (!fits || !is_finite(image)) return MCV_OK;
    }
    MCV_TRY(mcv_film_new(&r->film, mean->width, mean->height, mean->channels, r->measured.replicates, error));
    for (uint32_t k = 0; k < r->measured.replicates; ++k) {
        snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, k);
        const mcv_image *image = find_part(&r->exr, name);
        for (size_t i = 0; i < count; ++i) r->film.sums[k * count + i] = image->pixels[i];
    }
    r->film.samples = 1;
    return MCV_OK;
}

static mcv_result read_render(const char *path, render *r, mcv_error *error) {
    r->path = path;
    MCV_TRY(mcv_exr_read(path, &r->exr, error));
    const double replicates = number_attribute(&r->exr, "mcvisi:replicates");
    r->measured.mean = &r->exr.parts[0].image;
    r->measured.error = find_part(&r->exr, "error");
    if (!r->measured.error)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has no part `error`: must be written by `mcvisi render` with two or more --replicates",
                        path);
    if (!(replicates >= 2 && replicates <= MCV_MAX_REPLICATES && replicates == floor(replicates)))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: mcvisi:replicates in its header must be an integer from 2 to %d", path,
                        MCV_MAX_REPLICATES);
    r->measured.replicates = (uint32_t)replicates;
    return gather_replicates(r, error);
}

static void free_render(render *r) {
    mcv_film_free(&r->film);
    mcv_exr_free(&r->exr);
}

/* Equal seeds make equal sample points: the noise of both would be the same, and the tests too kind. */
static void warn_of_seeds(const render *a, const render *b) {
    static const char *const names[] = {"mcvisi:sampler", "mcvisi:device"};
    for (int i = 0; i < 2; ++i)
        if (strcmp(text_attribute(&a->exr, names[i]), text_attribute(&b->exr, names[i])) != 0) return;
    const double seed = number_attribute(&a->exr, "mcvisi:seed");
    if (seed != number_attribute(&b->exr, "mcvisi:seed")) return;
    fprintf(stderr,
            "mcvisi: warning: both images are of seed %.0f, so that their noise is alike and hides differences: render one with another "
            "--seed\n",
            seed);
}

static mcv_result report_comparison(const mcv_command *command, const render *a, const render *b, bool ranks, const mcv_comparison *c,
                                    mcv_error *error) {
    mcv_report report;
    mcv_report_begin(&report, command->json);
    mcv_report_flag(&report, "different", c->different);
    mcv_report_text(&report, "reason", c->reason);
    mcv_report_text(&report, "pixel_test", ranks ? "Mann-Whitney and Welch" : "Welch");
    mcv_report_numbers(&report, "replicates", "", ", ", (const double[]){a->measured.replicates, b->measured.replicates}, 2);
    mcv_report_numbers(&report, "means", text_attribute(&a->exr, "mcvisi:unit"), ", ", (const double[]){c->mean_x, c->mean_y}, 2);
    mcv_report_number(&report, "p_unit", "", c->p_unit);
    mcv_report_number(&report, "p_tiles", "", c->p_tiles);
    mcv_report_number(&report, "p_count", "", c->p_count);
    mcv_report_number(&report, "p_image", "", c->p_image);
    mcv_report_number(&report, "alpha", "", MCV_COMPARE_ALPHA);
    mcv_report_number(&report, "units", "", (double)c->units);
    mcv_report_number(&report, "tiles", "", (double)c->tiles);
    mcv_report_number(&report, "small_tiles", "", (double)c->small_tiles);
    mcv_report_number(&report, "detectable", "", c->detectable);
    mcv_report_number(&report, "detectable_tile", "", c->detectable_tile);
    mcv_report_open(&report, "worst");
    mcv_report_number(&report, "channel", "", c->worst.channel);
    mcv_report_number(&report, "column", "", c->worst.column);
    mcv_report_number(&report, "row", "", c->worst.row);
    mcv_report_numbers(&report, "size", "", " x ", (const double[]){c->worst.width, c->worst.height}, 2);
    mcv_report_close(&report);
    return mcv_report_end(&report, error);
}

static const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Beyond 5 standard errors all differences look alike. */
static mcv_result draw_difference(const char *path, const render *a, const render *b, bool different, mcv_error *error) {
    const mcv_color_scale scale = {.map = MCV_COLORMAP_DIVERGING, .low = -5, .high = 5};
    mcv_image difference;
    char title[256];
    MCV_TRY(mcv_compare_difference(&a->measured, &b->measured, &difference, error));
    snprintf(title, sizeof title, "%.100s - %.100s: %s", file_name(a->path), file_name(b->path),
             different ? "different" : "no difference beyond the noise");
    const mcv_result result = mcv_figure_write(path, &difference, title, "difference in standard errors", &scale, error);
    mcv_image_free(&difference);
    return result;
}

static mcv_result compare(const mcv_command *command, const render *a, const render *b, mcv_error *error) {
    const char *quantities[] = {text_attribute(&a->exr, "mcvisi:quantity"), text_attribute(&b->exr, "mcvisi:quantity")};
    if (strcmp(quantities[0], quantities[1]) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s is %s and %s is %s: both must be the same", a->path, quantities[0], b->path,
                        quantities[1]);
    mcv_comparison comparison;
    const bool ranks = a->film.samples > 0 && b->film.samples > 0;
    MCV_TRY(ranks ? mcv_compare_films(&a->film, &b->film, &comparison, error)
                  : mcv_compare_images(&a->measured, &b->measured, &comparison, error));
    if (command->difference) MCV_TRY(draw_difference(command->difference, a, b, comparison.different, error));
    warn_of_seeds(a, b);
    MCV_TRY(report_comparison(command, a, b, ranks, &comparison, error));
    return comparison.different ? MCV_FAILED : MCV_OK;
}

mcv_result mcv_verb_compare(const mcv_command *command, mcv_error *error) {
    render a = {0}, b = {0};
    if (command->difference) MCV_TRY(mcv_output_check(command->difference, error));
    mcv_result result = read_render(command->argument, &a, error);
    if (result == MCV_OK) result = read_render(command->second, &b, error);
    if (result == MCV_OK) result = compare(command, &a, &b, error);
    free_render(&a);
    free_render(&b);
    return result;
}
