/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi camera: the grey values that a camera reads from a rendered image. */
#include "analysis/camera.h"
#include "cli/options.h"
#include "cli/report.h"
#include "output/exr.h"
#include "output/file.h"
#include "output/png.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool ends_with(const char *path, const char *ending) {
    const size_t length = strlen(path);
    return length > strlen(ending) && strcmp(path + length - strlen(ending), ending) == 0;
}

static mcv_result check_command(const mcv_command *command, mcv_error *error) {
    if (!command->grey) return mcv_fail(error, MCV_USAGE, "--output is missing: give the file of the grey values, as in -o grey.png");
    if (!ends_with(command->grey, ".png") && !ends_with(command->grey, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--output %s: its name must end in .png or .exr", command->grey);
    if (mcv_same_file(command->grey, command->argument))
        return mcv_fail(error, MCV_USAGE, "%s is the image: give the grey values another name", command->grey);
    if ((command->exposure_time > 0) + (command->electrons_per_unit > 0) + (command->expose_to > 0) != 1)
        return mcv_fail(error, MCV_USAGE,
                        "the scale from light to electrons must be given once: by --exposure-time, --electrons-per-unit or --expose-to");
    if (command->black_level >> command->bits)
        return mcv_fail(error, MCV_USAGE, "--black-level %llu: must be below %u, the grey values of %llu bits",
                        (unsigned long long)command->black_level, 1u << command->bits, (unsigned long long)command->bits);
    return mcv_output_check(command->grey, error);
}

/* Only light makes electrons. */
static mcv_result check_quantity(const mcv_command *command, const mcv_exr *exr, const char **unit, mcv_error *error) {
    const mcv_attribute *quantity = mcv_exr_attribute(exr, "mcvisi:quantity");
    const char *name = quantity && quantity->text ? quantity->text : NULL;
    const bool irradiance = name && strcmp(name, "irradiance") == 0;
    if (!irradiance && !(name && strcmp(name, "radiance") == 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: mcvisi:quantity in its header is %s: must be irradiance or radiance, as `mcvisi render` writes it",
                        command->argument, name ? name : "missing");
    if (command->exposure_time > 0 && !irradiance)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: is radiance, which --exposure-time cannot turn into electrons: render it with \"radiometry\": \"irradiance\", or give "
            "--electrons-per-unit or --expose-to",
            command->argument);
    *unit = irradiance ? "W/m^2" : "W/(m^2 sr)";
    return MCV_OK;
}

static mcv_result scale_light(const mcv_command *command, const mcv_exr *exr, double *electrons_per_unit, mcv_error *error) {
    const mcv_image *light = &exr->parts[0].image;
    if (command->exposure_time > 0) {
        const mcv_attribute *size = mcv_exr_attribute(exr, "mcvisi:pixelSize");
        if (!size || size->text || size->count != 2)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: mcvisi:pixelSize [m] is missing in its header: render the image again, or give --electrons-per-unit",
                            command->argument);
        const mcv_attribute *binning = mcv_exr_attribute(exr, "mcvisi:binning");
        const double binned = binning && !binning->text && binning->count == 2 ? binning->numbers[0] * binning->numbers[1] : 1;
        *electrons_per_unit = mcv_camera_electrons_per_irradiance(command->exposure_time, command->quantum_efficiency, command->wavelength,
                                                                  size->numbers[0] * size->numbers[1] * binned);
    } else if (command->electrons_per_unit > 0) {
        *electrons_per_unit = command->electrons_per_unit;
    } else {
        float brightest = 0;
        for (size_t i = 0; i < (size_t)light->width * light->height * light->channels; ++i) brightest = fmaxf(brightest, light->pixels[i]);
        if (!(brightest > 0))
            return mcv_fail(error, MCV_BAD_INPUT, "%s: is dark everywhere: --expose-to has nothing to scale by", command->argument);
        *electrons_per_unit = command->expose_to * command->full_well / (double)brightest;
    }
    return MCV_OK;
}

static mcv_attribute number_attribute(const char *name, double number) {
    return (mcv_attribute){.name = name, .numbers = {number}, .count = 1};
}

/* The image's header, but what the values are, and the camera. */
static mcv_result write_exr(const mcv_command *command, const mcv_exr *exr, const mcv_camera *camera, const mcv_exposure *exposure,
                            mcv_error *error) {
    const mcv_attribute own[] = {
        {.name = "mcvisi:quantity", .text = "grey value"},
        {.name = "mcvisi:unit", .text = "DN"},
        number_attribute("mcvisi:electronsPerUnit", camera->electrons_per_unit),
        number_attribute("mcvisi:fullWell", camera->full_well),
        number_attribute("mcvisi:gain", camera->gain),
        number_attribute("mcvisi:readNoise", camera->noise_free ? 0 : camera->read_noise),
        number_attribute("mcvisi:noiseFree", camera->noise_free),
        number_attribute("mcvisi:bits", camera->bits),
        number_attribute("mcvisi:blackLevel", camera->black_level),
        number_attribute("mcvisi:cameraSeed", camera->seed),
        number_attribute("expTime", command->exposure_time),
    };
    /* expTime, the last, is known in seconds only where it was given. */
    const uint32_t own_count = sizeof own / sizeof own[0] - (command->exposure_time == 0);
    mcv_attribute *attributes = malloc((exr->attribute_count + own_count) * sizeof *attributes);
    if (!attributes) return mcv_fail(error, MCV_FAILED, "%s: no memory for its header", command->grey);
    uint32_t count = own_count;
    memcpy(attributes, own, own_count * sizeof *own);
    for (uint32_t i = 0; i < exr->attribute_count; ++i) {
        bool replaced = false;
        for (uint32_t k = 0; k < own_count; ++k) replaced = replaced || strcmp(exr->attributes[i].name, own[k].name) == 0;
        if (!replaced) attributes[count++] = exr->attributes[i];
    }
    const mcv_exr_part part = {.name = exr->parts[0].name, .image = exposure->grey, .channel_names = exr->parts[0].channel_names};
    const mcv_result result = mcv_exr_write(command->grey, &part, 1, attributes, count, error);
    free(attributes);
    return result;
}

static mcv_result report_exposure(const mcv_command *command, const mcv_camera *camera, const mcv_exposure *exposure, const char *unit,
                                  mcv_error *error) {
    const mcv_image *grey = &exposure->grey;
    const size_t count = (size_t)grey->width * grey->height * grey->channels;
    char per_unit[64];
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += (double)grey->pixels[i] / (double)count;
    snprintf(per_unit, sizeof per_unit, "e-/(%s)", unit);
    mcv_report report;
    mcv_report_begin(&report, command->json);
    mcv_report_text(&report, "image", command->grey);
    mcv_report_numbers(&report, "size", "", " x ", (const double[]){grey->width, grey->height}, 2);
    mcv_report_number(&report, "channels", "", grey->channels);
    mcv_report_number(&report, "electrons_per_unit", per_unit, camera->electrons_per_unit);
    mcv_report_number(&report, "electrons", "e-", exposure->electrons);
    mcv_report_number(&report, "brightest", "e-", exposure->brightest);
    mcv_report_number(&report, "full_well", "e-", camera->full_well);
    mcv_report_number(&report, "gain", "DN/e-", camera->gain);
    mcv_report_number(&report, "grey_value", "DN", mean);
    mcv_report_number(&report, "saturated", "", (double)exposure->saturated / (double)count);
    mcv_report_number(&report, "below_zero", "", (double)exposure->below_zero / (double)count);
    return mcv_report_end(&report, error);
}

static void warn(const mcv_command *command, const mcv_exposure *exposure) {
    const double count = (double)exposure->grey.width * exposure->grey.height * exposure->grey.channels;
    if (exposure->saturated == 0) return;
    fprintf(stderr, "mcvisi: warning: %s: %llu of %.0f values (%.2g %%) are saturated; the brightest has %.4g of %.4g e- on average\n",
            command->grey, (unsigned long long)exposure->saturated, count, 100 * (double)exposure->saturated / count, exposure->brightest,
            command->full_well);
}

static mcv_result expose(const mcv_command *command, const mcv_exr *exr, mcv_error *error) {
    const char *unit = NULL;
    mcv_exposure exposure;
    mcv_camera camera = {.full_well = command->full_well,
                         .gain = command->gain,
                         .read_noise = command->read_noise,
                         .bits = (uint32_t)command->bits,
                         .black_level = (uint32_t)command->black_level,
                         .seed = (uint32_t)command->seed,
                         .noise_free = command->noise_free};
    if (camera.gain == 0) camera.gain = ((1u << camera.bits) - 1 - camera.black_level) / camera.full_well;
    MCV_TRY(check_quantity(command, exr, &unit, error));
    MCV_TRY(scale_light(command, exr, &camera.electrons_per_unit, error));
    mcv_error detail = {""};
    mcv_result result = mcv_camera_expose(&camera, &exr->parts[0].image, &exposure, &detail);
    if (result != MCV_OK) return mcv_fail(error, result, "%s: %s", command->argument, detail.text);
    if (ends_with(command->grey, ".png"))
        result = mcv_png_write_values(command->grey, &exposure.grey, camera.bits > 8 ? 16 : 8, error);
    else
        result = write_exr(command, exr, &camera, &exposure, error);
    if (result == MCV_OK) {
        warn(command, &exposure);
        result = report_exposure(command, &camera, &exposure, unit, error);
    }
    mcv_image_free(&exposure.grey);
    return result;
}

mcv_result mcv_verb_camera(const mcv_command *command, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(check_command(command, error));
    MCV_TRY(mcv_exr_read(command->argument, &exr, error));
    const mcv_result result = expose(command, &exr, error);
    mcv_exr_free(&exr);
    return result;
}
