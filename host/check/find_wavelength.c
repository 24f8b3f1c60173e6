/* SPDX-License-Identifier: Apache-2.0 */
/* Materials whose indices are taken at another wavelength than that of the light. */
#include "check/find.h"

#include "scene/materials.h"
#include "scene/spectra.h"

#include <float.h>
#include <math.h>

static bool depends_on_wavelength(const mcv_material *m) {
    if (m->type == MCV_MATERIAL_CONDUCTOR) return m->by_name;
    return mcv_material_has_medium(m->type) &&
           (m->as.medium.glass > 0 || m->as.medium.abbeNumber > 0);
}

/* Beyond the rounding of "0.66um" and "660nm". */
static bool differs(double a, double b) { return fabs(a - b) > 4 * DBL_EPSILON * b; }

mcv_result mcv_find_wavelength(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    const mcv_material *material = NULL;
    for (uint32_t i = 0; i < scene->material_count && !material; ++i)
        if (depends_on_wavelength(scene->materials + i)) material = scene->materials + i;
    for (uint32_t i = 0; i < scene->sensor_count && material; ++i) {
        const mcv_sensor *s = scene->sensors + i;
        const double taken = mcv_scene_wavelength(scene, 0), own = s->as.flying_spot.wavelength;
        if (s->type != MCV_SENSOR_FLYING_SPOT || !differs(taken, own)) continue;
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "sensors", s->name, "wavelength", error,
            "the beam has %.6g nm, but material \"%s\" has the index at %.6g nm: give the scene "
            "the beam's wavelength, as by --set spectrum/wavelengths=%.6gnm",
            own * 1e9, material->name, taken * 1e9, own * 1e9));
    }
    return MCV_OK;
}
