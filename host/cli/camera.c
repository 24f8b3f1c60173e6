/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi camera: the grey values that a camera reads from a rendered image, and their files. */
#include "cli/camera.h"

#include "analysis/render_error.h"
#include "cli/report.h"
#include "core/basics.h"
#include "core/parallel.h"
#include "io/exr.h"
#include "core/output_file.h"
#include "io/png.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_camera_settings mcv_camera_settings_of(const mcv_command *command) {
    mcv_camera_settings settings = {.exposure_time = command->exposure_time,
                                    .expose_to = command->expose_to,
                                    .dark_current = command->dark_current,
                                    .lens_mtf = command->lens_mtf,
                                    .camera = {.full_well = command->full_well,
                                               .gain = command->gain,
                                               .read_noise = command->read_noise,
                                               .dsnu = command->dsnu,
                                               .prnu = command->prnu,
                                               .bits = (uint32_t)command->bits,
                                               .black_level = (uint32_t)command->black_level,
                                               .bayer = (uint32_t)command->bayer,
                                               .specimen = (uint32_t)command->camera_seed,
                                               .seed = (uint32_t)command->seed,
                                               .noise_free = command->noise_free}};
    for (int c = 0; c < 3; ++c) {
        settings.quantum_efficiency[c] = command->quantum_efficiency[c];
        settings.wavelength[c] = command->wavelength[c];
        settings.electrons_per_unit[c] = command->electrons_per_unit[c];
    }
    return settings;
}

bool mcv_camera_preview(const mcv_command *command, const char *grey, char preview[PATH_MAX]) {
    const char *dot = strrchr(grey, '.');
    if (!dot || mcv_ends_in(grey, ".exr") || (command->bits <= 8 && !mcv_ends_in(grey, ".npy")))
        return false;
    return snprintf(preview, PATH_MAX, "%.*s-preview.png", (int)(dot - grey), grey) < PATH_MAX;
}

mcv_result mcv_camera_check(const mcv_command *command, const char *grey, mcv_error *error) {
    if (!mcv_values_named(grey) && !mcv_ends_in(grey, ".exr"))
        return mcv_fail(error, MCV_USAGE,
                        "%s: the name of grey values must end in .exr, " MCV_VALUES_ENDINGS, grey);
    char preview[PATH_MAX];
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    MCV_TRY(mcv_camera_check_settings(&settings, error));
    MCV_TRY(mcv_output_check(grey, error));
    return mcv_camera_preview(command, grey, preview) ? mcv_output_check(preview, error) : MCV_OK;
}

/* --- what comes out --- */

static mcv_attribute number_attribute(const char *name, double number) {
    return (mcv_attribute){.name = name, .numbers = {number}, .count = 1};
}

static mcv_attribute text_attribute(const char *name, const char *text) {
    return (mcv_attribute){.name = name, .text = text};
}

/* The text beside the grey values: the image's camera model, with what the grey values are.
 * `in_header`: with the render's error, which the file has no other place for. Files of other
 * programs may have no model. */
static mcv_result describe(const char *path, const mcv_exr *exr, bool in_header, mcv_read_out *out,
                           mcv_error *error) {
    const mcv_camera *camera = &out->camera;
    mcv_exposure *exposure = &out->exposure;
    const mcv_attribute *text = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    const double *freedom = mcv_exr_numbers(exr, "mcvisi:errorFreedom", 1);
    mcv_camera_model model;
    bool is_one;
    MCV_TRY(mcv_camera_model_read(text ? text->text : NULL, path, &model, &is_one, error));
    if (!is_one) return MCV_OK;
    model.bits = camera->bits;
    model.black_level = camera->black_level;
    model.gain = camera->gain;
    mcv_result result = MCV_OK;
    if (in_header && exposure->render.pixels)
        result = mcv_render_error_of(&exposure->grey, &exposure->render, &out->correlation,
                                     freedom ? *freedom : 0, &model.render_error, error);
    if (result == MCV_OK) {
        exposure->grey.description = mcv_camera_model_write(&model);
        if (!exposure->grey.description)
            result = mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    }
    mcv_camera_model_free(&model);
    return result;
}

/* Writes the image's header, except what the values are, and the camera. */
static mcv_result write_exr(const mcv_command *command, const char *path, const mcv_exr *exr,
                            const mcv_read_out *out, mcv_error *error) {
    const mcv_camera *camera = &out->camera;
    const mcv_exposure *exposure = &out->exposure;
    const mcv_correlation rho = out->correlation;
    const mcv_attribute own[] = {
        {.name = MCV_EXR_CORRELATION,
         .numbers = {rho.sum, rho.squares, rho.stencil, rho.shares},
         .count = 4},
        text_attribute("mcvisi:quantity", "grey value"),
        text_attribute("mcvisi:unit", "DN"),
        text_attribute("mcvisi:lensMTF", out->lens[0] ? out->lens : "none"),
        text_attribute("mcvisi:bayer", mcv_bayer_patterns[camera->bayer]),
        number_attribute("mcvisi:electronsPerUnit", camera->electrons_per_unit[0]),
        number_attribute("mcvisi:electronsPerUnitGreen", camera->electrons_per_unit[1]),
        number_attribute("mcvisi:electronsPerUnitBlue", camera->electrons_per_unit[2]),
        number_attribute("mcvisi:fullWell", camera->full_well),
        number_attribute("mcvisi:gain", camera->gain),
        number_attribute("mcvisi:readNoise", camera->noise_free ? 0 : camera->read_noise),
        number_attribute("mcvisi:darkElectrons", camera->dark_electrons),
        number_attribute("mcvisi:DSNU1288", camera->dsnu),
        number_attribute("mcvisi:PRNU1288", camera->prnu),
        number_attribute("mcvisi:noiseFree", camera->noise_free),
        number_attribute("mcvisi:bits", camera->bits),
        number_attribute("mcvisi:blackLevel", camera->black_level),
        number_attribute("mcvisi:exposureSeed", camera->seed),
        number_attribute("mcvisi:cameraSeed", camera->specimen),
    };
    enum { OWN = sizeof own / sizeof own[0] };
    mcv_attribute *attributes = malloc((exr->attribute_count + OWN + 2) * sizeof *attributes);
    if (!attributes) return mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    uint32_t own_count = OWN;
    memcpy(attributes, own, sizeof own);
    if (exposure->grey.description)
        attributes[own_count++] = text_attribute(MCV_CAMERA_MODEL_KEY, exposure->grey.description);
    if (command->exposure_time > 0)
        attributes[own_count++] = number_attribute("expTime", command->exposure_time);
    uint32_t count = own_count;
    for (uint32_t i = 0; i < exr->attribute_count; ++i) {
        bool replaced = false;
        for (uint32_t k = 0; k < own_count; ++k)
            replaced = replaced || strcmp(exr->attributes[i].name, attributes[k].name) == 0;
        if (!replaced) attributes[count++] = exr->attributes[i];
    }
    const char **names = camera->bayer == MCV_BAYER_NONE ? exr->parts[0].channel_names : NULL;
    const mcv_exr_part parts[] = {
        {.name = exr->parts[0].name, .image = exposure->grey, .channel_names = names},
        {.name = "error", .image = exposure->uncertainty, .channel_names = names},
        {.name = MCV_EXR_RENDER_ERROR, .image = exposure->render, .channel_names = names}};
    const mcv_result result =
        mcv_exr_write(path, parts, exposure->render.pixels ? 3 : 2, attributes, count, error);
    free(attributes);
    return result;
}

static mcv_result report_exposure(const mcv_command *command, const char *path,
                                  const mcv_read_out *out, mcv_error *error) {
    const mcv_camera *camera = &out->camera;
    const mcv_exposure *exposure = &out->exposure;
    const mcv_image *grey = &exposure->grey;
    const size_t count = (size_t)grey->width * grey->height * grey->channels;
    char per_unit[64], preview[PATH_MAX];
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += (double)grey->pixels[i] / (double)count;
    snprintf(per_unit, sizeof per_unit, "e-/(%s)", out->unit);
    const double *e = camera->electrons_per_unit;
    mcv_report report;
    mcv_report_begin(&report, command->json);
    mcv_report_text(&report, "image", path);
    if (mcv_camera_preview(command, path, preview)) mcv_report_text(&report, "preview", preview);
    mcv_report_numbers(&report, "size", "", " x ", (const double[]){grey->width, grey->height}, 2);
    mcv_report_number(&report, "channels", "", grey->channels);
    mcv_report_text(&report, "lens_mtf", out->lens[0] ? out->lens : "none");
    if (e[0] == e[1] && e[1] == e[2])
        mcv_report_number(&report, "electrons_per_unit", per_unit, e[0]);
    else
        mcv_report_spectrum(&report, "electrons_per_unit", per_unit, e);
    mcv_report_number(&report, "electrons", "e-", exposure->electrons);
    const double level = command->expose_to * command->full_well;
    if (isfinite(out->level))
        mcv_report_quantity(&report, "level", "e-", level, level * out->level);
    mcv_report_number(&report, "dark_electrons", "e-", camera->dark_electrons);
    mcv_report_number(&report, "brightest", "e-", exposure->brightest);
    mcv_report_number(&report, "full_well", "e-", camera->full_well);
    mcv_report_number(&report, "gain", "DN/e-", camera->gain);
    mcv_report_number(&report, "grey_value", "DN", mean);
    mcv_report_number(&report, "saturated", "", (double)exposure->saturated / (double)count);
    mcv_report_number(&report, "below_zero", "", (double)exposure->below_zero / (double)count);
    return mcv_report_end(&report, error);
}

static void warn(const char *path, const mcv_read_out *out) {
    const mcv_exposure *exposure = &out->exposure;
    const double count =
        (double)exposure->grey.width * exposure->grey.height * exposure->grey.channels;
    if (exposure->saturated == 0) return;
    fprintf(stderr,
            "mcvisi: warning: %s: %llu of %.0f values (%.3g %%) are saturated; the brightest has "
            "%.4g of %.4g e- on average\n",
            path, (unsigned long long)exposure->saturated, count,
            100 * (double)exposure->saturated / count, exposure->brightest, out->camera.full_well);
}

/* --- the whole --- */

/* Two files that are written in parallel. */
typedef struct values {
    const char *grey, *preview; /* NULL: none */
    const mcv_image *image, *shown;
    int bits;
    mcv_result results[2];
    mcv_error errors[2];
} values;

static void write_one(void *user, size_t i) {
    values *v = user;
    mcv_preview shown = {.white = (double)((1u << v->bits) - 1)};
    if (i == 0)
        v->results[0] = mcv_values_write(v->grey, v->image, v->bits > 8 ? 16 : 8, v->errors);
    if (i == 1 && v->preview)
        v->results[1] = mcv_png_write_preview(v->preview, v->shown, "DN", &shown, v->errors + 1);
}

/* Writes grey values unscaled, and a preview whose largest value is white. The preview's values are
 * not grey values, so its header does not describe them. */
static mcv_result write_values(const mcv_command *command, const mcv_exr *exr, const char *grey,
                               const mcv_read_out *out, mcv_error *error) {
    const mcv_exposure *exposure = &out->exposure;
    char preview[PATH_MAX];
    const bool wanted = mcv_camera_preview(command, grey, preview);
    const mcv_attribute *model = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    mcv_image shown = exposure->grey;
    if (shown.description) shown.description = (char *)model->text;
    values v = {.grey = grey,
                .preview = wanted ? preview : NULL,
                .image = &exposure->grey,
                .shown = &shown,
                .bits = (int)out->camera.bits};
    mcv_in_parallel(2, write_one, &v);
    const int failed = v.results[0] == MCV_OK;
    if (v.results[failed] != MCV_OK) *error = v.errors[failed];
    return v.results[failed];
}

static mcv_result write_grey(const mcv_command *command, const mcv_exr *exr, const char *grey,
                             bool told, const char *path, mcv_read_out *out, mcv_error *error) {
    const bool is_exr = mcv_ends_in(grey, ".exr");
    MCV_TRY(describe(path, exr, !is_exr, out, error));
    MCV_TRY(is_exr ? write_exr(command, grey, exr, out, error)
                   : write_values(command, exr, grey, out, error));
    warn(grey, out);
    return told ? report_exposure(command, grey, out, error) : MCV_OK;
}

mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *grey,
                            bool told, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_exr_read(image, &exr, error));
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    mcv_read_out out;
    mcv_result result = mcv_camera_read_out(&settings, image, &exr, &out, error);
    if (result == MCV_OK) {
        result = write_grey(command, &exr, grey, told, image, &out, error);
        mcv_exposure_free(&out.exposure);
    }
    mcv_exr_free(&exr);
    return result;
}

mcv_result mcv_verb_camera(const mcv_command *command, mcv_error *error) {
    if (!command->grey)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give the file of the grey values, as in -o grey.png");
    if (mcv_same_file(command->grey, command->argument))
        return mcv_fail(error, MCV_USAGE, "%s is the image: give the grey values another name",
                        command->grey);
    MCV_TRY(mcv_camera_check(command, command->grey, error));
    return mcv_camera_write(command, command->argument, command->grey, true, error);
}
