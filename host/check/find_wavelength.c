/* SPDX-License-Identifier: Apache-2.0 */
/* Materials whose indices are taken at another wavelength than that of the light. */
#include "check/find.h"

#include "scene/laser.h"
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

/* The light of a sensor's or an emitter's `wavelength`, and where the material has its index. */
typedef struct mismatch {
    const char *kind, *name, *light;
    double own, taken; /* [m] */
    const char *material;
} mismatch;

static mcv_result tell(const mismatch *m, mcv_findings *findings, mcv_error *error) {
    return mcv_findings_add(
        findings, MCV_SEVERITY_WARNING, m->kind, m->name, "wavelength", error,
        "the %s has %.6g nm, but material \"%s\" has the index at %.6g nm: give the scene the %s's "
        "wavelength, as by --set spectrum/wavelengths=%.6gnm",
        m->light, m->own * 1e9, m->material, m->taken * 1e9, m->light, m->own * 1e9);
}

/* Lasers of several wavelengths, or beside other lamps, have no wavelength that the scene could
 * take for all. */
static mcv_result find_lasers(const mcv_scene *scene, const mcv_material *material,
                              mcv_findings *findings, mcv_error *error) {
    double own, linewidth;
    if (!mcv_scene_is_laser_lit(scene, &own, &linewidth)) return MCV_OK;
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        for (int c = 0; c < 3; ++c) {
            const mcv_emitter *e = scene->emitters + i;
            if (!(e->radiance[c] > 0)) continue;
            const mismatch m = {
                "emitters", e->name, "laser", own, mcv_scene_wavelength(scene, c), material->name};
            if (differs(m.taken, own)) return tell(&m, findings, error);
        }
    return MCV_OK;
}

mcv_result mcv_find_wavelength(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    const mcv_material *material = NULL;
    for (uint32_t i = 0; i < scene->material_count && !material; ++i)
        if (depends_on_wavelength(scene->materials + i)) material = scene->materials + i;
    if (!material) return MCV_OK;
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_sensor *s = scene->sensors + i;
        const mismatch m = {"sensors",
                            s->name,
                            "beam",
                            s->as.flying_spot.wavelength,
                            mcv_scene_wavelength(scene, 0),
                            material->name};
        if (s->type == MCV_SENSOR_FLYING_SPOT && differs(m.taken, m.own))
            MCV_TRY(tell(&m, findings, error));
    }
    return find_lasers(scene, material, findings, error);
}
