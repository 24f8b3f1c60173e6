/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi camera: the grey values that a camera reads from a rendered image. Beyond the camera
 * itself: the scale of light, the lens, files.
 */
#include "cli/camera.h"

#include "analysis/blur.h"
#include "analysis/camera.h"
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

bool mcv_camera_wanted(const mcv_command *command) {
    return command->exposure_time > 0 || command->electrons_per_unit[0] > 0 ||
           command->expose_to > 0;
}

mcv_result mcv_camera_check_options(const mcv_command *command, mcv_error *error) {
    const int scales = (command->electrons_per_unit[0] > 0) + (command->expose_to > 0);
    if (scales > 1 || (scales == 0 && command->exposure_time == 0))
        return mcv_fail(error, MCV_USAGE,
                        "the scale from light to electrons must be given once: by --exposure-time, "
                        "--electrons-per-unit or --expose-to");
    if (command->dark_current > 0 && command->exposure_time == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--dark-current needs the time that it flows: give --exposure-time");
    if (command->black_level >> command->bits)
        return mcv_fail(error, MCV_USAGE,
                        "--black-level %llu: must be below %u, the grey values of %llu bits",
                        (unsigned long long)command->black_level, 1u << command->bits,
                        (unsigned long long)command->bits);
    return MCV_OK;
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
    MCV_TRY(mcv_camera_check_options(command, error));
    MCV_TRY(mcv_output_check(grey, error));
    return mcv_camera_preview(command, grey, preview) ? mcv_output_check(preview, error) : MCV_OK;
}

/* Only light makes electrons. */
static mcv_result check_quantity(const mcv_command *command, const char *path, const mcv_exr *exr,
                                 const char **unit, mcv_error *error) {
    const mcv_attribute *quantity = mcv_exr_attribute(exr, "mcvisi:quantity");
    const char *name = quantity && quantity->text ? quantity->text : NULL;
    const bool irradiance = name && strcmp(name, "irradiance") == 0;
    if (!irradiance && !(name && strcmp(name, "radiance") == 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: mcvisi:quantity in its header is %s: must be irradiance or radiance, "
                        "as `mcvisi render` writes it",
                        path, name ? name : "missing");
    if (!irradiance && command->electrons_per_unit[0] == 0 && command->expose_to == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is radiance, which --exposure-time cannot turn into electrons: render "
                        "it with \"radiometry\": \"irradiance\", or give "
                        "--electrons-per-unit or --expose-to",
                        path);
    *unit = irradiance ? "W/m^2" : "W/(m^2 sr)";
    return MCV_OK;
}

/* --- the header
 * -------------------------------------------------------------------------------------------------
 */

/* Width and height of a pixel of the image [m]: of binned ones, all together. */
static bool pixel_size(const mcv_exr *exr, double size[2]) {
    const double *one = mcv_exr_numbers(exr, "mcvisi:pixelSize", 2),
                 *binning = mcv_exr_numbers(exr, "mcvisi:binning", 2);
    for (int i = 0; one && i < 2; ++i) size[i] = one[i] * (binning ? binning[i] : 1);
    return one;
}

/* What is known of the light that falls on the pixels. */
typedef struct illumination {
    const char *unit;
    char lens[128]; /* in words, "" for none */
    mcv_correlation correlation;
    double level; /* the uncertainty of the level that --expose-to takes, relative to it; NaN where
                     none is known */
} illumination;

/* --- light
 * ------------------------------------------------------------------------------------------------------
 */

static mcv_result scale_light(const mcv_command *command, const char *path, const mcv_exr *exr,
                              double per_unit[3], illumination *lit, mcv_error *error) {
    const mcv_image *light = &exr->parts[0].image;
    double size[2];
    lit->level = NAN;
    if (command->electrons_per_unit[0] > 0) {
        memcpy(per_unit, command->electrons_per_unit, 3 * sizeof *per_unit);
        return MCV_OK;
    }
    if (command->expose_to == 0) {
        if (!pixel_size(exr, size))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: mcvisi:pixelSize [m] is missing in its header: render the image "
                            "again, or give --electrons-per-unit",
                            path);
        for (int c = 0; c < 3; ++c)
            per_unit[c] = mcv_camera_electrons_per_irradiance(
                command->exposure_time, command->quantum_efficiency[c], command->wavelength[c],
                size[0] * size[1]);
        return MCV_OK;
    }
    /* Electrons for equal energy go as eta lambda. */
    for (int c = 0; c < 3; ++c)
        per_unit[c] = command->quantum_efficiency[c] * command->wavelength[c];
    const mcv_quantity level = mcv_camera_level(light, mcv_exr_error(exr), per_unit);
    if (!(level.value > 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is dark everywhere: --expose-to has nothing to scale by", path);
    for (int c = 0; c < 3; ++c)
        per_unit[c] *= command->expose_to * command->full_well / level.value;
    lit->level = level.uncertainty / level.value;
    return MCV_OK;
}

/* --- the lens
 * ---------------------------------------------------------------------------------------------------
 */

enum { WIDEST_DIFFRACTION = 100 };

/*
 * Says in words what was done, "" for nothing. A light field image is left alone: neighbouring
 * pixels see through different parts of the pupil. So is a stop whose diffraction would fill the
 * image: that of a glTF camera, which stands for none.
 */
static mcv_result blur(const mcv_command *command, const char *path, mcv_exr *exr, char words[128],
                       mcv_correlation *correlation, mcv_error *error) {
    const double *f_number = mcv_exr_numbers(exr, "mcvisi:fNumber", 1);
    const bool table = strcmp(command->lens_mtf, "diffraction") != 0;
    double size[2], widest = 0;
    mcv_lens_mtf mtf[3];
    mcv_mtf_row *rows = NULL;
    size_t row_count = 0;
    words[0] = '\0';
    *correlation = (mcv_correlation){1, 1, 1, 1};
    if (strcmp(command->lens_mtf, "none") == 0 ||
        mcv_exr_attribute(exr, "mcvisi:angularResolution"))
        return MCV_OK;
    if (!pixel_size(exr, size)) {
        if (!table) return MCV_OK;
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: mcvisi:pixelSize [m] is missing in its header, without which "
                        "--lens-mtf has no scale",
                        path);
    }
    if (!table && !f_number) return MCV_OK;
    for (int c = 0; c < 3; ++c) {
        mtf[c] = (mcv_lens_mtf){.f_number = f_number ? *f_number : 0,
                                .wavelength = command->wavelength[c]};
        widest = fmax(widest, mtf[c].f_number * mtf[c].wavelength / fmin(size[0], size[1]));
    }
    if (!table && widest > WIDEST_DIFFRACTION) return MCV_OK;
    if (table) MCV_TRY(mcv_mtf_read(command->lens_mtf, &rows, &row_count, error));
    for (int c = 0; c < 3; ++c) {
        mtf[c].rows = rows;
        mtf[c].row_count = row_count;
    }
    if (table)
        snprintf(words, 128, "table %.100s", command->lens_mtf);
    else
        snprintf(words, 128, "diffraction at f/%g", *f_number);
    const mcv_result result =
        mcv_blur(&exr->parts[0].image, mcv_exr_error(exr), mtf, size, correlation, error);
    free(rows);
    return result;
}

/* --- what comes out
 * --------------------------------------------------------------------------------------------- */

static mcv_attribute number_attribute(const char *name, double number) {
    return (mcv_attribute){.name = name, .numbers = {number}, .count = 1};
}

static mcv_attribute text_attribute(const char *name, const char *text) {
    return (mcv_attribute){.name = name, .text = text};
}

/* The image's camera model, with what the grey values are; `in_header` where the render's error has
 * no other place in the file. The header of another program may have none. */
static mcv_result describe(const char *path, const mcv_exr *exr, const mcv_camera *camera,
                           const mcv_correlation *correlation, bool in_header,
                           mcv_exposure *exposure, mcv_error *error) {
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
        result = mcv_render_error_of(&exposure->grey, &exposure->render, correlation,
                                     freedom ? *freedom : 0, &model.render_error, error);
    if (result == MCV_OK) {
        exposure->grey.description = mcv_camera_model_write(&model);
        if (!exposure->grey.description)
            result = mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    }
    mcv_camera_model_free(&model);
    return result;
}

/* The image's header, but what the values are, and the camera. */
static mcv_result write_exr(const mcv_command *command, const char *path, const mcv_exr *exr,
                            const mcv_camera *camera, const mcv_exposure *exposure,
                            const illumination *lit, mcv_error *error) {
    const mcv_correlation rho = lit->correlation;
    const mcv_attribute own[] = {
        {.name = MCV_EXR_CORRELATION,
         .numbers = {rho.sum, rho.squares, rho.stencil, rho.shares},
         .count = 4},
        text_attribute("mcvisi:quantity", "grey value"),
        text_attribute("mcvisi:unit", "DN"),
        text_attribute("mcvisi:lensMTF", lit->lens[0] ? lit->lens : "none"),
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
                                  const mcv_camera *camera, const mcv_exposure *exposure,
                                  const illumination *lit, mcv_error *error) {
    const mcv_image *grey = &exposure->grey;
    const size_t count = (size_t)grey->width * grey->height * grey->channels;
    char per_unit[64], preview[PATH_MAX];
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += (double)grey->pixels[i] / (double)count;
    snprintf(per_unit, sizeof per_unit, "e-/(%s)", lit->unit);
    const double *e = camera->electrons_per_unit;
    mcv_report report;
    mcv_report_begin(&report, command->json);
    mcv_report_text(&report, "image", path);
    if (mcv_camera_preview(command, path, preview)) mcv_report_text(&report, "preview", preview);
    mcv_report_numbers(&report, "size", "", " x ", (const double[]){grey->width, grey->height}, 2);
    mcv_report_number(&report, "channels", "", grey->channels);
    mcv_report_text(&report, "lens_mtf", lit->lens[0] ? lit->lens : "none");
    if (e[0] == e[1] && e[1] == e[2])
        mcv_report_number(&report, "electrons_per_unit", per_unit, e[0]);
    else
        mcv_report_spectrum(&report, "electrons_per_unit", per_unit, e);
    mcv_report_number(&report, "electrons", "e-", exposure->electrons);
    const double level = command->expose_to * command->full_well;
    if (isfinite(lit->level))
        mcv_report_quantity(&report, "level", "e-", level, level * lit->level);
    mcv_report_number(&report, "dark_electrons", "e-", camera->dark_electrons);
    mcv_report_number(&report, "brightest", "e-", exposure->brightest);
    mcv_report_number(&report, "full_well", "e-", camera->full_well);
    mcv_report_number(&report, "gain", "DN/e-", camera->gain);
    mcv_report_number(&report, "grey_value", "DN", mean);
    mcv_report_number(&report, "saturated", "", (double)exposure->saturated / (double)count);
    mcv_report_number(&report, "below_zero", "", (double)exposure->below_zero / (double)count);
    return mcv_report_end(&report, error);
}

static void warn(const char *path, const mcv_camera *camera, const mcv_exposure *exposure) {
    const double count =
        (double)exposure->grey.width * exposure->grey.height * exposure->grey.channels;
    if (exposure->saturated == 0) return;
    fprintf(stderr,
            "mcvisi: warning: %s: %llu of %.0f values (%.3g %%) are saturated; the brightest has "
            "%.4g of %.4g e- on average\n",
            path, (unsigned long long)exposure->saturated, count,
            100 * (double)exposure->saturated / count, exposure->brightest, camera->full_well);
}

/* --- the whole
 * --------------------------------------------------------------------------------------------------
 */

static mcv_camera camera_of(const mcv_command *command) {
    mcv_camera camera = {.dark_electrons = command->dark_current * command->exposure_time,
                         .full_well = command->full_well,
                         .gain = command->gain,
                         .read_noise = command->read_noise,
                         .dsnu = command->dsnu,
                         .prnu = command->prnu,
                         .bits = (uint32_t)command->bits,
                         .black_level = (uint32_t)command->black_level,
                         .bayer = (uint32_t)command->bayer,
                         .specimen = (uint32_t)command->camera_seed,
                         .seed = (uint32_t)command->seed,
                         .noise_free = command->noise_free};
    if (camera.gain == 0)
        camera.gain = ((1u << camera.bits) - 1 - camera.black_level) / camera.full_well;
    return camera;
}

static mcv_result read_out(const mcv_command *command, const char *path, mcv_exr *exr,
                           mcv_camera *camera, mcv_exposure *exposure, illumination *lit,
                           mcv_error *error) {
    mcv_image *light = &exr->parts[0].image;
    mcv_error detail = {""};
    MCV_TRY(check_quantity(command, path, exr, &lit->unit, error));
    mcv_result result = mcv_camera_check_light(light, &detail);
    if (result != MCV_OK) return mcv_fail(error, result, "%s: %s", path, detail.text);
    MCV_TRY(scale_light(command, path, exr, camera->electrons_per_unit, lit, error));
    MCV_TRY(blur(command, path, exr, lit->lens, &lit->correlation, error));
    result = mcv_camera_expose(camera, light, mcv_exr_error(exr), exposure, &detail);
    return result == MCV_OK ? MCV_OK : mcv_fail(error, result, "%s: %s", path, detail.text);
}

mcv_result mcv_camera_read_out(const mcv_command *command, const char *path, mcv_exr *exr,
                               mcv_exposure *exposure, mcv_correlation *correlation,
                               mcv_error *error) {
    illumination lit = {.lens = "", .level = NAN};
    mcv_camera camera = camera_of(command);
    const mcv_result result = read_out(command, path, exr, &camera, exposure, &lit, error);
    if (result == MCV_OK) *correlation = lit.correlation;
    return result;
}

/* Two files that are written at once. */
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

/* Grey values as they are, and a preview in which the largest is white: its values are no grey
 * values, and its header does not say so. */
static mcv_result write_values(const mcv_command *command, const mcv_exr *exr, const char *grey,
                               const mcv_camera *camera, const mcv_exposure *exposure,
                               mcv_error *error) {
    char preview[PATH_MAX];
    const bool wanted = mcv_camera_preview(command, grey, preview);
    const mcv_attribute *model = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    mcv_image shown = exposure->grey;
    if (shown.description) shown.description = (char *)model->text;
    values v = {.grey = grey,
                .preview = wanted ? preview : NULL,
                .image = &exposure->grey,
                .shown = &shown,
                .bits = (int)camera->bits};
    mcv_in_parallel(2, write_one, &v);
    const int failed = v.results[0] == MCV_OK;
    if (v.results[failed] != MCV_OK) *error = v.errors[failed];
    return v.results[failed];
}

static mcv_result expose(const mcv_command *command, const char *path, mcv_exr *exr,
                         const char *grey, bool told, mcv_error *error) {
    illumination lit = {.lens = "", .level = NAN};
    mcv_exposure exposure = {0};
    mcv_camera camera = camera_of(command);
    MCV_TRY(read_out(command, path, exr, &camera, &exposure, &lit, error));
    const bool is_exr = mcv_ends_in(grey, ".exr");
    mcv_result result = describe(path, exr, &camera, &lit.correlation, !is_exr, &exposure, error);
    if (result != MCV_OK) {
        mcv_exposure_free(&exposure);
        return result;
    }
    result = is_exr ? write_exr(command, grey, exr, &camera, &exposure, &lit, error)
                    : write_values(command, exr, grey, &camera, &exposure, error);
    if (result == MCV_OK) warn(grey, &camera, &exposure);
    if (result == MCV_OK && told)
        result = report_exposure(command, grey, &camera, &exposure, &lit, error);
    mcv_exposure_free(&exposure);
    return result;
}

mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *grey,
                            bool told, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_exr_read(image, &exr, error));
    const mcv_result result = expose(command, image, &exr, grey, told, error);
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
