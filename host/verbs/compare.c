/* SPDX-License-Identifier: Apache-2.0 */
/* Whether two renders of the same picture differ by more than their noise. */
#include "verbs/compare.h"

#include "io/figure.h"
#include "verbs/render_picture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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

/* Makes the film of the replicates if the file has all of them. Rank tests need finite numbers:
 * other images have no film. */
static mcv_result gather_replicates(const mcv_exr *exr, mcv_compared *r, mcv_error *error) {
    const mcv_image *mean = r->measured.mean;
    const size_t count = (size_t)mean->width * mean->height * mean->channels;
    char name[32];
    for (uint32_t k = 0; k < r->measured.replicates; ++k) {
        snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, k);
        const mcv_image *image = find_part(exr, name);
        const bool fits = image && image->width == mean->width && image->height == mean->height &&
                          image->channels == mean->channels;
        if (!fits || !is_finite(image)) return MCV_OK;
    }
    MCV_TRY(mcv_film_new(&r->film, mean->width, mean->height, mean->channels,
                         r->measured.replicates, error));
    for (uint32_t k = 0; k < r->measured.replicates; ++k) {
        snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, k);
        const mcv_image *image = find_part(exr, name);
        for (size_t i = 0; i < count; ++i) r->film.sums[k * count + i] = image->pixels[i];
    }
    r->film.samples = 1;
    return MCV_OK;
}

mcv_result mcv_compared_read(const mcv_exr *exr, const char *path, mcv_compared *r,
                             mcv_error *error) {
    *r = (mcv_compared){.path = path};
    const double replicates = number_attribute(exr, "mcvisi:replicates");
    r->measured.mean = &exr->parts[0].image;
    r->measured.error = find_part(exr, "error");
    if (!r->measured.error)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no part `error`: must be written by `mcvisi render` with two or "
                        "more --replicates",
                        path);
    if (!(replicates >= 2 && replicates <= MCV_MAX_REPLICATES && replicates == floor(replicates)))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: mcvisi:replicates in its header must be an integer from 2 to %d", path,
                        MCV_MAX_REPLICATES);
    r->measured.replicates = (uint32_t)replicates;
    snprintf(r->quantity, sizeof r->quantity, "%s", text_attribute(exr, "mcvisi:quantity"));
    snprintf(r->unit, sizeof r->unit, "%s", text_attribute(exr, "mcvisi:unit"));
    snprintf(r->sampler, sizeof r->sampler, "%s", text_attribute(exr, "mcvisi:sampler"));
    snprintf(r->sampling, sizeof r->sampling, "%s", text_attribute(exr, "mcvisi:sampling"));
    snprintf(r->device, sizeof r->device, "%s", text_attribute(exr, "mcvisi:device"));
    r->seed = number_attribute(exr, "mcvisi:seed");
    r->light_paths = number_attribute(exr, "mcvisi:lightPaths");
    return gather_replicates(exr, r, error);
}

/* Equal seeds have equal sample points: the noise is correlated, and the tests find fewer
 * differences. */
static void warn_of_seeds(const mcv_compared *a, const mcv_compared *b, mcv_report *report) {
    char text[256];
    if (a->seed != b->seed || strcmp(a->sampler, b->sampler) != 0 ||
        strcmp(a->device, b->device) != 0)
        return;
    snprintf(text, sizeof text,
             "both images have seed %.0f: their noise is correlated and hides differences; render "
             "one with another --seed",
             a->seed);
    mcv_report_tell(report, "warning", text);
}

static bool is_same(const mcv_image *a, const mcv_image *b) {
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           memcmp(a->pixels, b->pixels,
                  (size_t)a->width * a->height * a->channels * sizeof *a->pixels) == 0;
}

static void tell_identical(const mcv_compared *a, const mcv_compared *b, mcv_report *report) {
    if (is_same(a->measured.mean, b->measured.mean) &&
        is_same(a->measured.error, b->measured.error))
        mcv_report_tell(report, "note",
                        "both images are identical: all values and their errors have the same "
                        "bits");
}

static void report_comparison(const mcv_compared *a, const mcv_compared *b, bool ranks,
                              const mcv_comparison *c, mcv_report *report) {
    double histogram[MCV_COMPARE_BINS];
    for (int i = 0; i < MCV_COMPARE_BINS; ++i) histogram[i] = (double)c->histogram[i];
    mcv_report_flag(report, "different", c->different);
    mcv_report_text(report, "reason", c->reason);
    mcv_report_text(report, "pixel_test", ranks ? "Mann-Whitney and Welch" : "Welch");
    mcv_report_numbers(report, "replicates", "", ", ",
                       (const double[]){a->measured.replicates, b->measured.replicates}, 2);
    mcv_report_numbers(report, "means", a->unit, ", ", (const double[]){c->mean_x, c->mean_y}, 2);
    mcv_report_number(report, "p_unit", "", c->p_unit);
    mcv_report_number(report, "p_tiles", "", c->p_tiles);
    mcv_report_number(report, "p_count", "", c->p_count);
    mcv_report_number(report, "p_image", "", c->p_image);
    mcv_report_number(report, "alpha", "", MCV_COMPARE_ALPHA);
    mcv_report_number(report, "units", "", (double)c->units);
    mcv_report_number(report, "tiles", "", (double)c->tiles);
    mcv_report_number(report, "small_tiles", "", (double)c->small_tiles);
    mcv_report_numbers(report, "tiles_by_p", "", " ", histogram, MCV_COMPARE_BINS);
    mcv_report_number(report, "detectable", "", c->detectable);
    mcv_report_number(report, "detectable_tile", "", c->detectable_tile);
    mcv_report_open(report, "worst");
    mcv_report_number(report, "channel", "", c->worst.channel);
    mcv_report_number(report, "column", "", c->worst.column);
    mcv_report_number(report, "row", "", c->worst.row);
    mcv_report_numbers(report, "size", "", " x ", (const double[]){c->worst.width, c->worst.height},
                       2);
    mcv_report_close(report);
}

mcv_result mcv_compare(const mcv_compared *a, const mcv_compared *b, mcv_comparison *comparison,
                       mcv_error *error) {
    if (strcmp(a->quantity, b->quantity) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s is %s and %s is %s: both must be the same",
                        a->path, a->quantity, b->path, b->quantity);
    return mcv_compared_by_ranks(a, b)
               ? mcv_compare_films(&a->film, &b->film, comparison, error)
               : mcv_compare_images(&a->measured, &b->measured, comparison, error);
}

bool mcv_compared_by_ranks(const mcv_compared *a, const mcv_compared *b) {
    return a->film.samples > 0 && b->film.samples > 0;
}

void mcv_compare_report(const mcv_compared *a, const mcv_compared *b,
                        const mcv_comparison *comparison, mcv_report *report) {
    warn_of_seeds(a, b, report);
    tell_identical(a, b, report);
    report_comparison(a, b, mcv_compared_by_ranks(a, b), comparison, report);
}

/* --- the picture --- */

static const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Differences beyond 5 standard errors have the same colour. */
mcv_result mcv_compare_draw(const char *path, const mcv_compared *a, const mcv_compared *b,
                            bool different, mcv_error *error) {
    const mcv_color_scale scale = {.map = MCV_COLORMAP_DIVERGING, .low = -5, .high = 5};
    mcv_image difference;
    char title[256];
    MCV_TRY(mcv_compare_difference(&a->measured, &b->measured, &difference, error));
    snprintf(title, sizeof title, "%.100s - %.100s: %s", file_name(a->path), file_name(b->path),
             different ? "different" : "no difference beyond the noise");
    const mcv_result result =
        mcv_figure_write(path, &difference, title, "difference in standard errors", &scale, error);
    mcv_image_free(&difference);
    return result;
}
