/* SPDX-License-Identifier: Apache-2.0 */
/* Defects that are smaller than what their model describes. */
#include "check/find.h"

#include "scene/defect_params.h"
#include "scene/spectra.h"

#include <math.h>

/* Below this many wavelengths a ray is no model of what light does. */
static const double least_wavelengths = 2;
/* Below this share of a pixel's width a defect cannot be told from the noise of any camera. */
static const double least_pixels = 0.01;

/* Light tunnels through a crack that is open by less than a wavelength, and interferes in it. */
static mcv_result find_closed_crack(const mcv_defect *defect, double least, mcv_findings *findings,
                                    mcv_error *error) {
    char opening[32], wavelength[32];
    if (defect->type != MCV_DEFECT_CRACK || defect->depth >= least) return MCV_OK;
    return mcv_findings_add(
        findings, MCV_SEVERITY_WARNING, "defects", defect->name, "opening", error,
        "a crack that is open by %s, less than two wavelengths, %s: light interferes in it and "
        "tunnels through it, which rays do not",
        mcv_length_in_words(defect->depth, opening), mcv_length_in_words(least, wavelength));
}

static mcv_result find_diffracting(const mcv_scene *scene, const mcv_defect *defect,
                                   mcv_findings *findings, mcv_error *error) {
    double longest = 0;
    char size[32], wavelength[32];
    for (int channel = 0; channel < 3; ++channel)
        longest = fmax(longest, mcv_scene_wavelength(scene, channel));
    MCV_TRY(find_closed_crack(defect, least_wavelengths * longest, findings, error));
    if (defect->size >= least_wavelengths * longest) return MCV_OK;
    return mcv_findings_add(
        findings, MCV_SEVERITY_WARNING, "defects", defect->name, "size", error,
        "a %s of %s is smaller than two wavelengths, %s: such a size diffracts light, which rays "
        "do not",
        mcv_defect_types[defect->type], mcv_length_in_words(defect->size, size),
        mcv_length_in_words(least_wavelengths * longest, wavelength));
}

/* The smallest width that a pixel of any sensor has at the defect; infinite where none sees it. */
static double finest_pixel(const mcv_scene *scene, const mcv_defect *defect,
                           const mcv_sensor **sensor) {
    double finest = INFINITY;
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_view view = mcv_view_of(scene->sensors + i);
        double local[3], film[2];
        mcv_view_point(&view, defect->centre, local);
        if (!mcv_view_project(&view, defect->centre, film)) continue;
        bool seen = true;
        for (int k = 0; k < 2; ++k)
            seen = seen && film[k] > view.film[k][0] && film[k] < view.film[k][1];
        const double pixel = mcv_view_pixel(&view, local[2]);
        if (!seen || !(pixel < finest)) continue;
        finest = pixel;
        *sensor = view.sensor;
    }
    return finest;
}

mcv_result mcv_find_small_defect(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->defect_count; ++i) {
        const mcv_defect *defect = scene->defects + i;
        const mcv_sensor *sensor = NULL;
        const double pixel = finest_pixel(scene, defect, &sensor);
        char size[32], width[32];
        MCV_TRY(find_diffracting(scene, defect, findings, error));
        if (!sensor || defect->size >= least_pixels * pixel) continue;
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "defects", defect->name, "size", error,
            "a %s of %s covers less than a hundredth of the %s that a pixel of sensor \"%s\" sees: "
            "no camera's noise lets it be seen",
            mcv_defect_types[defect->type], mcv_length_in_words(defect->size, size),
            mcv_length_in_words(pixel, width), sensor->name));
    }
    return MCV_OK;
}
