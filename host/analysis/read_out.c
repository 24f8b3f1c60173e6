/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/read_out.h"

#include "analysis/blur.h"
#include "analysis/read_speckle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool mcv_camera_wanted(const mcv_camera_settings *settings) {
    return settings->exposure_time > 0 || settings->electrons_per_unit[0] > 0 ||
           settings->expose_to > 0;
}

mcv_result mcv_camera_check_settings(const mcv_camera_settings *settings, mcv_error *error) {
    const int scales = (settings->electrons_per_unit[0] > 0) + (settings->expose_to > 0);
    if (scales > 1 || (scales == 0 && settings->exposure_time == 0))
        return mcv_fail(error, MCV_USAGE,
                        "the conversion from light to electrons must be given exactly once: by "
                        "--exposure-time, --electrons-per-unit or --expose-to");
    if (scales == 1 && settings->exposure_time > 0 && !(settings->dark_current > 0))
        return mcv_fail(
            error, MCV_USAGE,
            "with %s, --exposure-time only scales the dark current: leave one of them out, or "
            "give --dark-current",
            settings->expose_to > 0 ? "--expose-to" : "--electrons-per-unit");
    if (settings->dark_current > 0 && settings->exposure_time == 0)
        return mcv_fail(error, MCV_USAGE, "--dark-current needs a time: give --exposure-time");
    if (settings->speckle && !(settings->speckle_patterns >= 1))
        return mcv_fail(error, MCV_USAGE, "--speckle-patterns %g: must be at least 1",
                        settings->speckle_patterns);
    if (settings->speckle && !(settings->speckle_polarization >= 0))
        return mcv_fail(error, MCV_USAGE, "--speckle-polarization %g: must be 0 to 1",
                        settings->speckle_polarization);
    const mcv_camera *camera = &settings->camera;
    if (camera->black_level >> camera->bits)
        return mcv_fail(error, MCV_USAGE,
                        "--black-level %u: must be below %u, the grey values of %u bits",
                        camera->black_level, 1u << camera->bits, camera->bits);
    return MCV_OK;
}

/* Only light makes electrons. */
static mcv_result check_quantity(const mcv_camera_settings *settings, const char *path,
                                 const mcv_exr *exr, const char **unit, mcv_error *error) {
    const mcv_attribute *quantity = mcv_exr_attribute(exr, "mcvisi:quantity");
    const char *name = quantity && quantity->text ? quantity->text : NULL;
    const bool irradiance = name && strcmp(name, "irradiance") == 0;
    if (!irradiance && !(name && strcmp(name, "radiance") == 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: mcvisi:quantity in its header is %s: must be irradiance or radiance, "
                        "as `mcvisi render` writes it",
                        path, name ? name : "missing");
    if (!irradiance && settings->electrons_per_unit[0] == 0 && settings->expose_to == 0)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: is radiance, which --exposure-time cannot convert to electrons: render it with "
            "\"radiometry\": \"irradiance\", or give --electrons-per-unit or --expose-to",
            path);
    *unit = irradiance ? "W/m^2" : "W/(m^2 sr)";
    return MCV_OK;
}

bool mcv_camera_pixel_size(const mcv_exr *exr, double size[2]) {
    const double *one = mcv_exr_numbers(exr, "mcvisi:pixelSize", 2),
                 *binning = mcv_exr_numbers(exr, "mcvisi:binning", 2);
    for (int i = 0; one && i < 2; ++i) size[i] = one[i] * (binning ? binning[i] : 1);
    return one;
}

static mcv_result scale_light(const mcv_camera_settings *settings, const char *path,
                              const mcv_exr *exr, mcv_read_out *out, mcv_error *error) {
    const mcv_image *light = &exr->parts[0].image;
    double *per_unit = out->camera.electrons_per_unit, size[2];
    if (settings->electrons_per_unit[0] > 0) {
        memcpy(per_unit, settings->electrons_per_unit, sizeof settings->electrons_per_unit);
        return MCV_OK;
    }
    if (settings->expose_to == 0) {
        if (!mcv_camera_pixel_size(exr, size))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: mcvisi:pixelSize [m] is missing in its header: render the image "
                            "again, or give --electrons-per-unit",
                            path);
        for (int c = 0; c < 3; ++c)
            per_unit[c] = mcv_camera_electrons_per_irradiance(
                settings->exposure_time, settings->quantum_efficiency[c], settings->wavelength[c],
                size[0] * size[1]);
        return MCV_OK;
    }
    /* Electrons for equal energy go as eta lambda. */
    for (int c = 0; c < 3; ++c)
        per_unit[c] = settings->quantum_efficiency[c] * settings->wavelength[c];
    const mcv_quantity level =
        mcv_camera_level(light, mcv_exr_error(exr), mcv_exr_channel_correlation(exr), per_unit);
    if (!(level.value > 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is dark everywhere, so --expose-to cannot scale it", path);
    for (int c = 0; c < 3; ++c)
        per_unit[c] *= settings->expose_to * settings->camera.full_well / level.value;
    out->level = level.uncertainty / level.value;
    return MCV_OK;
}

enum { WIDEST_DIFFRACTION = 100 };

mcv_result mcv_camera_blur(const mcv_camera_settings *settings, const char *path, mcv_exr *exr,
                           char words[128], mcv_correlation *correlation, mcv_error *error) {
    const double *f_number = mcv_exr_numbers(exr, "mcvisi:fNumber", 1);
    const bool table = strcmp(settings->lens_mtf, "diffraction") != 0;
    double size[2], widest = 0;
    mcv_lens_mtf mtf[3];
    mcv_mtf_row *rows = NULL;
    size_t row_count = 0;
    words[0] = '\0';
    *correlation = (mcv_correlation){1, 1, 1, 1};
    if (strcmp(settings->lens_mtf, "none") == 0 ||
        mcv_exr_attribute(exr, "mcvisi:angularResolution"))
        return MCV_OK;
    if (!mcv_camera_pixel_size(exr, size)) {
        if (!table) return MCV_OK;
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: mcvisi:pixelSize [m] is missing in its header, which --lens-mtf needs as its "
            "scale",
            path);
    }
    if (!table && !f_number) return MCV_OK;
    for (int c = 0; c < 3; ++c) {
        mtf[c] = (mcv_lens_mtf){.f_number = f_number ? *f_number : 0,
                                .wavelength = settings->wavelength[c]};
        widest = fmax(widest, mtf[c].f_number * mtf[c].wavelength / fmin(size[0], size[1]));
    }
    if (!table && widest > WIDEST_DIFFRACTION) return MCV_OK;
    if (table) MCV_TRY(mcv_mtf_read(settings->lens_mtf, &rows, &row_count, error));
    for (int c = 0; c < 3; ++c) {
        mtf[c].rows = rows;
        mtf[c].row_count = row_count;
    }
    if (table)
        snprintf(words, 128, "table %.100s", settings->lens_mtf);
    else
        snprintf(words, 128, "diffraction at f/%g", *f_number);
    const mcv_result result =
        mcv_blur(&exr->parts[0].image, mcv_exr_error(exr), mtf, size, correlation, error);
    free(rows);
    return result;
}

static mcv_camera camera_of(const mcv_camera_settings *settings) {
    mcv_camera camera = settings->camera;
    camera.dark_electrons = settings->dark_current * settings->exposure_time;
    if (camera.gain == 0)
        camera.gain = ((1u << camera.bits) - 1 - camera.black_level) / camera.full_well;
    return camera;
}

mcv_result mcv_camera_read_out(const mcv_camera_settings *settings, const char *path, mcv_exr *exr,
                               mcv_read_out *out, mcv_error *error) {
    mcv_image *light = &exr->parts[0].image;
    mcv_error detail = {""};
    *out = (mcv_read_out){.camera = camera_of(settings), .level = NAN};
    MCV_TRY(check_quantity(settings, path, exr, &out->unit, error));
    mcv_result result = mcv_camera_check_light(light, &detail);
    if (result != MCV_OK) return mcv_fail(error, result, "%s: %s", path, detail.text);
    MCV_TRY(scale_light(settings, path, exr, out, error));
    MCV_TRY(mcv_camera_blur(settings, path, exr, out->lens, &out->correlation, error));
    MCV_TRY(mcv_camera_add_speckle(settings, path, exr, &out->speckle, error));
    result = mcv_camera_expose(&out->camera, light, mcv_exr_error(exr), &out->exposure, &detail);
    return result == MCV_OK ? MCV_OK : mcv_fail(error, result, "%s: %s", path, detail.text);
}
