/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/detect.h"

#include "analysis/light_pairs.h"
#include "io/values.h"
#include "scene/params.h"
#include "verbs/compare.h"
#include "verbs/grey_picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    mcv_compared pictures[2]; /* with, without */
    mcv_light_pairs read;
    mcv_roi region;
} work;

static mcv_result gather(const mcv_command *command, const mcv_exr *const exr[2], work *w,
                         mcv_detected *d, mcv_error *error) {
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    mcv_light_picture pictures[2];
    for (int i = 0; i < 2; ++i)
        pictures[i] = (mcv_light_picture){w->pictures[i].path, exr[i], &w->pictures[i].film};
    MCV_TRY(mcv_light_pairs_read(&settings, pictures, &w->read, error));
    if (command->within)
        MCV_TRY(mcv_roi_parse(command->within, 1, w->pictures[0].measured.mean, &w->region, error));
    w->read.pairs.inside = w->region.inside;
    d->camera = w->read.camera;
    memcpy(d->lens, w->read.lens, sizeof d->lens);
    d->same_seed = w->pictures[0].seed == w->pictures[1].seed;
    d->same_sampling = strcmp(w->pictures[0].sampling, w->pictures[1].sampling) == 0;
    for (int i = 0; i < 2; ++i) d->light_paths[i] = w->pictures[i].light_paths;
    return MCV_OK;
}

mcv_result mcv_detect_pictures(const mcv_command *command, const mcv_exr *with,
                               const char *with_path, const mcv_exr *without,
                               const char *without_path, mcv_detected *detected, mcv_error *error) {
    const mcv_exr *const exr[2] = {with, without};
    work w = {.read = {.lens = ""}};
    *detected = (mcv_detected){.same_seed = false};
    mcv_result result = read_step(command->step, &detected->step, error);
    if (result == MCV_OK) result = mcv_compared_read(with, with_path, w.pictures, error);
    if (result == MCV_OK) result = mcv_compared_read(without, without_path, w.pictures + 1, error);
    if (result == MCV_OK) result = check_pair(w.pictures, w.pictures + 1, error);
    if (result == MCV_OK) result = gather(command, exr, &w, detected, error);
    if (result == MCV_OK)
        result = mcv_detect(&w.read.pairs, &detected->camera, command->visible, &detected->sigmas,
                            &detected->detection, error);
    for (int i = 0; i < 2; ++i) mcv_film_free(&w.pictures[i].film);
    mcv_light_pairs_free(&w.read);
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

bool mcv_detect_lights_differ(const mcv_detected *detected) {
    return fabs(detected->light_paths[0] - detected->light_paths[1]) > 0;
}

/* Where the noise of the render does not cancel. */
static void tell_of_pair(const mcv_detected *detected, mcv_report *report) {
    char text[256];
    if (!detected->same_seed) {
        mcv_report_tell(report, "note",
                        "the pictures have different seeds: with the same --seed most of the "
                        "render's noise would be in both, and cancel");
        return;
    }
    if (!detected->same_sampling)
        mcv_report_tell(report, "note",
                        "one of the pictures alone has adaptive sampling: with --adaptive off for "
                        "both, most of the render's noise would be in both, and cancel");
    if (!mcv_detect_lights_differ(detected)) return;
    snprintf(text, sizeof text,
             "the pictures have %.3g and %.3g light paths a sample, so the noise of these does not "
             "cancel: --light-paths on helps where a pilot has decided",
             detected->light_paths[0], detected->light_paths[1]);
    mcv_report_tell(report, "note", text);
}

void mcv_detect_report(const mcv_command *command, const mcv_detected *detected,
                       mcv_report *report) {
    const mcv_detection *d = &detected->detection;
    tell_of_pair(detected, report);
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
