/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/detect.h"

#include "io/exr_make.h"
#include "io/values.h"
#include "scene/params.h"
#include "verbs/compare.h"
#include "verbs/grey_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The camera that exposes the picture without the defect: --expose-to takes its level from it. */
static mcv_result choose_camera(const mcv_camera_settings *settings, const char *path,
                                const mcv_exr *exr, mcv_read_out *out, mcv_error *error) {
    mcv_exr light;
    MCV_TRY(mcv_camera_check_settings(settings, error));
    MCV_TRY(mcv_exr_copy(exr, &light, error)); /* it is blurred in place */
    const mcv_result result = mcv_camera_read_out(settings, path, &light, out, error);
    if (result == MCV_OK) mcv_exposure_free(&out->exposure);
    mcv_exr_free(&light);
    return result;
}

/* Replicate r as the electrons that the lens lets through. */
static mcv_result read_replicate(const mcv_camera_settings *settings, const mcv_compared *from,
                                 const mcv_exr *exr, const mcv_read_out *out, uint32_t r,
                                 double *electrons, mcv_error *error) {
    const mcv_image *like = from->measured.mean;
    const size_t plane = (size_t)like->width * like->height, count = plane * like->channels;
    mcv_exr_part part = exr->parts[0];
    mcv_exr one = *exr; /* the header, for the lens */
    mcv_correlation unused;
    char words[128];
    MCV_TRY(mcv_image_new(&part.image, like->width, like->height, like->channels, error));
    one.parts = &part;
    one.part_count = 1;
    for (size_t i = 0; i < count; ++i)
        part.image.pixels[i] = (float)fmax(0, from->film.sums[r * count + i]);
    const mcv_result result = mcv_camera_blur(settings, from->path, &one, words, &unused, error);
    for (size_t i = 0; i < count; ++i) {
        const size_t channel = i / plane;
        electrons[r * count + i] = out->camera.electrons_per_unit[channel < 3 ? channel : 2] *
                                   (double)part.image.pixels[i];
    }
    mcv_image_free(&part.image);
    return result;
}

static mcv_result check_pair(const mcv_compared *a, const mcv_compared *b, mcv_error *error) {
    const mcv_compared *const both[] = {a, b};
    const mcv_image *x = a->measured.mean, *y = b->measured.mean;
    if (x->width != y->width || x->height != y->height || x->channels != y->channels)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s has %u x %u pixels of %u channels and %s has %u x %u of %u: both must "
                        "be of one scene",
                        a->path, x->width, x->height, x->channels, b->path, y->width, y->height,
                        y->channels);
    if (strcmp(a->quantity, b->quantity) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s is %s and %s is %s: both must be the same",
                        a->path, a->quantity, b->path, b->quantity);
    for (int i = 0; i < 2; ++i)
        if (both[i]->film.samples == 0)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: has no replicates, which tell the render's noise from the "
                            "defect: render it with --parts replicates",
                            both[i]->path);
    if (a->film.replicates != b->film.replicates)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s has %u replicates and %s has %u: both must have as many", a->path,
                        a->film.replicates, b->path, b->film.replicates);
    return MCV_OK;
}

static mcv_result read_step(const char *text, double *step, mcv_error *error) {
    *step = 0;
    if (!text || (mcv_parse_quantity(text, MCV_PARAM_choice, step) && *step > 0)) return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "--step %s: must be above 0, a number or with a unit as in 1mm or 0.5deg",
                    text);
}

/* What a detection works on. */
typedef struct work {
    const mcv_exr *exr[2];
    mcv_compared pictures[2]; /* with, without */
    double *electrons[2];
    mcv_roi region;
} work;

static mcv_result gather(const mcv_command *command, work *w, mcv_detected *d, mcv_pairs *pairs,
                         mcv_error *error) {
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    const mcv_image *mean = w->pictures[0].measured.mean;
    const uint32_t replicates = w->pictures[0].film.replicates;
    const size_t count = (size_t)mean->width * mean->height * mean->channels;
    mcv_read_out out;
    MCV_TRY(choose_camera(&settings, w->pictures[1].path, w->exr[1], &out, error));
    for (int i = 0; i < 2; ++i) {
        w->electrons[i] = malloc(count * replicates * sizeof(double));
        if (!w->electrons[i])
            return mcv_fail(error, MCV_FAILED, "no memory for %u replicates", replicates);
        for (uint32_t r = 0; r < replicates; ++r)
            MCV_TRY(read_replicate(&settings, w->pictures + i, w->exr[i], &out, r, w->electrons[i],
                                   error));
    }
    if (command->within) MCV_TRY(mcv_roi_parse(command->within, 1, mean, &w->region, error));
    *pairs = (mcv_pairs){.width = mean->width,
                         .height = mean->height,
                         .channels = mean->channels,
                         .replicates = replicates,
                         .with = w->electrons[0],
                         .without = w->electrons[1],
                         .inside = w->region.inside,
                         .correlation = out.correlation};
    d->camera = out.camera;
    memcpy(d->lens, out.lens, sizeof d->lens);
    d->same_seed = w->pictures[0].seed == w->pictures[1].seed;
    return MCV_OK;
}

mcv_result mcv_detect_pictures(const mcv_command *command, const mcv_exr *with,
                               const char *with_path, const mcv_exr *without,
                               const char *without_path, mcv_detected *detected, mcv_error *error) {
    work w = {.exr = {with, without}};
    mcv_pairs pairs;
    *detected = (mcv_detected){.same_seed = false};
    mcv_result result = read_step(command->step, &detected->step, error);
    if (result == MCV_OK) result = mcv_compared_read(with, with_path, w.pictures, error);
    if (result == MCV_OK) result = mcv_compared_read(without, without_path, w.pictures + 1, error);
    if (result == MCV_OK) result = check_pair(w.pictures, w.pictures + 1, error);
    if (result == MCV_OK) result = gather(command, &w, detected, &pairs, error);
    if (result == MCV_OK)
        result = mcv_detect(&pairs, &detected->camera, command->visible, &detected->sigmas,
                            &detected->detection, error);
    for (int i = 0; i < 2; ++i) {
        mcv_film_free(&w.pictures[i].film);
        free(w.electrons[i]);
    }
    mcv_roi_free(&w.region);
    return result;
}

void mcv_detected_free(mcv_detected *detected) {
    mcv_image_free(&detected->sigmas);
    mcv_image_free(&detected->truth);
    free(detected->setup);
}

mcv_result mcv_detect_save(const mcv_command *command, const mcv_detected *detected,
                           mcv_error *error) {
    const mcv_image *sigmas = &detected->sigmas;
    mcv_image mask;
    if (!mcv_values_named(command->mask))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in " MCV_VALUES_ENDINGS,
                        command->mask);
    MCV_TRY(mcv_image_new(&mask, sigmas->width, sigmas->height, 1, error));
    for (size_t i = 0; i < (size_t)mask.width * mask.height; ++i)
        mask.pixels[i] = (double)sigmas->pixels[i] >= command->visible ? 255 : 0;
    const mcv_result result = mcv_values_write(command->mask, &mask, 8, error);
    mcv_image_free(&mask);
    return result;
}

/* --- the report --- */

/* Shares of false calls for which the share of found defects is told, and their normal quantiles.
 */
static const struct {
    const char *key;
    double quantile;
} calls[] = {{"found_at_1_percent_false_calls", 2.3263478740408408},
             {"found_at_1_in_10000_false_calls", 3.7190164854556804}};

static void tell_detectability(const mcv_detection *d, mcv_report *report) {
    mcv_report_open(report, "detectability");
    mcv_report_number(report, "value", "", d->detectability);
    mcv_report_number(report, "low", "", d->low);
    mcv_report_number(report, "high", "", d->high);
    mcv_report_close(report);
    mcv_report_number(report, "area_under_roc", "", mcv_normal_below(d->detectability * M_SQRT1_2));
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; ++i)
        mcv_report_number(report, calls[i].key, "",
                          mcv_normal_below(d->detectability - calls[i].quantile));
}

/* The Cramér-Rao bound of what differs by a step: an end that nothing bounds is left out. */
static void tell_bound(const mcv_detected *detected, mcv_report *report) {
    const mcv_detection *d = &detected->detection;
    if (detected->step == 0) return;
    mcv_report_open(report, "bound");
    if (d->detectability > 0)
        mcv_report_number(report, "value", "", detected->step / d->detectability);
    if (d->high > 0) mcv_report_number(report, "low", "", detected->step / d->high);
    if (d->low > 0) mcv_report_number(report, "high", "", detected->step / d->low);
    mcv_report_close(report);
}

void mcv_detect_report(const mcv_command *command, const mcv_detected *detected,
                       mcv_report *report) {
    const mcv_detection *d = &detected->detection;
    if (!detected->same_seed)
        mcv_report_tell(report, "note",
                        "the pictures have different seeds: with the same --seed most of the "
                        "render's noise would be in both, and cancel");
    if (d->low == 0 && d->high > 0)
        mcv_report_tell(report, "warning",
                        "the render's noise hides the defect: more samples narrow the interval");
    tell_detectability(d, report);
    tell_bound(detected, report);
    mcv_report_quantity(report, "contrast", "", d->contrast.value, d->contrast.uncertainty);
    mcv_report_quantity(report, "rms_contrast", "", d->rms_contrast.value,
                        d->rms_contrast.uncertainty);
    mcv_report_quantity(report, "difference", "e-", d->difference.value, d->difference.uncertainty);
    mcv_report_number(report, "mean", "e-", d->mean);
    mcv_report_number(report, "noise", "e-", sqrt(mcv_detect_variance(&detected->camera, d->mean)));
    mcv_report_number(report, "values", "", (double)d->values);
    mcv_report_number(report, "visible", "", (double)d->visible);
    mcv_report_number(report, "visible_from", "", command->visible);
    mcv_detect_report_truth(command, detected, report);
    if (command->detected) mcv_report_text(report, "page", command->detected);
    mcv_report_number(report, "electrons_per_unit", "", detected->camera.electrons_per_unit[0]);
    mcv_report_text(report, "lens_mtf", detected->lens[0] ? detected->lens : "none");
}
