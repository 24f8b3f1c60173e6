/* SPDX-License-Identifier: Apache-2.0 */
/* The grey values that a camera reads from an image of light, as a picture and as files. */
#include "verbs/grey_picture.h"

#include "analysis/read_speckle.h"
#include "analysis/render_error.h"
#include "core/basics.h"
#include "io/exr_make.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <stdlib.h>
#include <string.h>

mcv_camera_settings mcv_camera_settings_of(const mcv_command *command) {
    mcv_camera_settings settings = {.exposure_time = command->exposure_time,
                                    .expose_to = command->expose_to,
                                    .dark_current = command->dark_current,
                                    .lens_mtf = command->lens_mtf,
                                    .speckle = command->speckle,
                                    .speckle_polarization = command->speckle_polarization,
                                    .speckle_patterns = command->speckle_patterns,
                                    .speckle_roughness = command->speckle_roughness[0],
                                    .speckle_seed = (uint32_t)command->speckle_seed,
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

static mcv_attribute number_attribute(const char *name, double number) {
    return (mcv_attribute){.name = name, .numbers = {number}, .count = 1};
}

static mcv_attribute text_attribute(const char *name, const char *text) {
    return (mcv_attribute){.name = name, .text = text};
}

/* The image's camera model, with what the grey values are. The header of another program may have
 * none. */
static mcv_result describe(const char *path, const mcv_exr *exr, mcv_read_out *out,
                           mcv_error *error) {
    const mcv_camera *camera = &out->camera;
    mcv_exposure *exposure = &out->exposure;
    const mcv_attribute *text = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    mcv_camera_model model;
    bool is_one;
    MCV_TRY(mcv_camera_model_read(text ? text->text : NULL, path, &model, &is_one, error));
    if (!is_one) return MCV_OK;
    model.bits = camera->bits;
    model.black_level = camera->black_level;
    model.gain = camera->gain;
    exposure->grey.description = mcv_camera_model_write(&model);
    mcv_camera_model_free(&model);
    return exposure->grey.description
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
}

static mcv_result set_attributes(const mcv_camera_settings *settings, const mcv_read_out *out,
                                 mcv_exr *grey, mcv_error *error) {
    const mcv_camera *camera = &out->camera;
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
    const mcv_attribute speckle = number_attribute(MCV_SPECKLE_CONTRAST, out->speckle);
    const mcv_attribute exposed = number_attribute("expTime", settings->exposure_time);
    const mcv_attribute model =
        text_attribute(MCV_CAMERA_MODEL_KEY, out->exposure.grey.description);
    MCV_TRY(mcv_exr_set_attributes(grey, own, sizeof own / sizeof own[0], error));
    if (model.text) MCV_TRY(mcv_exr_set_attributes(grey, &model, 1, error));
    if (out->speckle > 0) MCV_TRY(mcv_exr_set_attributes(grey, &speckle, 1, error));
    return settings->exposure_time > 0 ? mcv_exr_set_attributes(grey, &exposed, 1, error) : MCV_OK;
}

/* The light's header stays, but for what the values are. */
static mcv_result keep_header(const mcv_exr *light, mcv_exr *grey, mcv_error *error) {
    for (uint32_t i = 0; i < light->attribute_count; ++i)
        if (!mcv_exr_attribute(grey, light->attributes[i].name))
            MCV_TRY(mcv_exr_set_attributes(grey, light->attributes + i, 1, error));
    return MCV_OK;
}

static mcv_result add_parts(const mcv_exr *light, mcv_read_out *out, mcv_exr *grey,
                            mcv_error *error) {
    mcv_exposure *exposure = &out->exposure;
    const char *const *names =
        out->camera.bayer == MCV_BAYER_NONE ? light->parts[0].channel_names : NULL;
    const char *const part_names[] = {light->parts[0].name, "error", MCV_EXR_RENDER_ERROR};
    mcv_image *const images[] = {&exposure->grey, &exposure->uncertainty, &exposure->render};
    for (int i = 0; i < (exposure->render.pixels ? 3 : 2); ++i) {
        const mcv_image image = *images[i];
        *images[i] = (mcv_image){0};
        MCV_TRY(mcv_exr_add_part(grey, part_names[i], image, names, error));
    }
    return MCV_OK;
}

mcv_result mcv_grey_make(const mcv_command *command, const char *path, mcv_exr *light,
                         mcv_read_out *out, mcv_exr *grey, mcv_error *error) {
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    return mcv_grey_expose(&settings, path, light, out, grey, error);
}

mcv_result mcv_grey_expose(const mcv_camera_settings *settings, const char *path, mcv_exr *light,
                           mcv_read_out *out, mcv_exr *grey, mcv_error *error) {
    *grey = (mcv_exr){0};
    MCV_TRY(mcv_camera_check_settings(settings, error));
    MCV_TRY(mcv_camera_read_out(settings, path, light, out, error));
    mcv_result result = describe(path, light, out, error);
    if (result == MCV_OK) result = set_attributes(settings, out, grey, error);
    if (result == MCV_OK) result = keep_header(light, grey, error);
    if (result == MCV_OK) result = add_parts(light, out, grey, error);
    mcv_exposure_free(&out->exposure);
    if (result != MCV_OK) mcv_exr_free(grey);
    return result;
}

/* --- files of values alone --- */

/* The model with the render's error, which has no other place in such a file; *text is NULL where
 * the picture has no model. */
static mcv_result describe_with_error(const char *path, const mcv_exr *grey, char **text,
                                      mcv_error *error) {
    const double *rho = mcv_exr_numbers(grey, MCV_EXR_CORRELATION, 4),
                 *freedom = mcv_exr_numbers(grey, "mcvisi:errorFreedom", 1);
    const mcv_image *render = mcv_exr_image(grey, MCV_EXR_RENDER_ERROR);
    const mcv_attribute *written = mcv_exr_attribute(grey, MCV_CAMERA_MODEL_KEY);
    mcv_camera_model model;
    bool is_one;
    *text = NULL;
    MCV_TRY(mcv_camera_model_read(written ? written->text : NULL, path, &model, &is_one, error));
    if (!is_one) return MCV_OK;
    mcv_result result = MCV_OK;
    if (render && rho) {
        const mcv_correlation correlation = {rho[0], rho[1], rho[2], rho[3]};
        result = mcv_render_error_of(&grey->parts[0].image, render, &correlation,
                                     mcv_exr_channel_correlation(grey), freedom ? *freedom : 0,
                                     &model.render_error, error);
    }
    if (result == MCV_OK && !(*text = mcv_camera_model_write(&model)))
        result = mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    mcv_camera_model_free(&model);
    return result;
}

mcv_result mcv_grey_write(const char *path, const mcv_exr *grey, mcv_error *error) {
    const double *bits = mcv_exr_numbers(grey, "mcvisi:bits", 1);
    mcv_image values = grey->parts[0].image; /* its description is replaced */
    MCV_TRY(describe_with_error(path, grey, &values.description, error));
    const mcv_result result = mcv_values_write(path, &values, bits && *bits <= 8 ? 8 : 16, error);
    free(values.description);
    return result;
}

bool mcv_grey_is(const mcv_exr *exr) {
    const mcv_attribute *quantity = mcv_exr_attribute(exr, "mcvisi:quantity");
    return quantity && quantity->text && strcmp(quantity->text, "grey value") == 0;
}
