/* SPDX-License-Identifier: Apache-2.0 */
/* The wavelengths of channels, and what materials are there. */
#include "scene/materials.h"
#include "scene/spectra.h"

#include "scene/params.h"

#include <math.h>

/* Red, green and blue; and what stands for all light: the d line of helium, at which catalogues
 * give refractive indices. */
static const double default_wavelengths[3] = {611.4e-9, 549.1e-9, 464.2e-9};
static const double grey_wavelength = 587.6e-9;

void mcv_material_settle_spectra(const mcv_scene *scene, mcv_material *material, bool coloured) {
    mcv_conductor_params *metal = material->type == MCV_MATERIAL_CONDUCTOR && material->by_name
                                      ? &material->as.conductor
                                      : NULL;
    mcv_medium_params *glass =
        mcv_material_has_medium(material->type) ? &material->as.medium : NULL;
    for (int k = 0; k < 3; ++k) {
        const double own =
            scene->wavelengths[k] > 0 ? scene->wavelengths[k] : default_wavelengths[k];
        const double wavelength = coloured ? own : grey_wavelength;
        if (metal) mcv_metal_index(metal->metal, wavelength, metal->n + k, metal->k + k);
        if (glass && glass->glass > 0) glass->ior[k] = mcv_glass_index(glass->glass, wavelength);
        if (glass && glass->abbeNumber > 0)
            glass->ior[k] = mcv_cauchy_index(material->ior_d, glass->abbeNumber, wavelength);
    }
}

double mcv_scene_wavelength(const mcv_scene *scene, int channel) {
    if (scene->wavelengths[channel] > 0) return scene->wavelengths[channel];
    return mcv_scene_channels(scene) == 1 ? grey_wavelength : default_wavelengths[channel];
}

void mcv_scene_settle_spectra(mcv_scene *scene) {
    bool coloured = scene->wavelengths[0] > 0;
    for (uint32_t i = 0; i < scene->material_count; ++i)
        if (mcv_material_has_medium(scene->materials[i].type) &&
            scene->materials[i].as.medium.abbeNumber > 0)
            coloured = true;
    /* Grey first: if the scene is, it stays so. */
    for (int pass = coloured; pass < 2; ++pass) {
        for (uint32_t i = 0; i < scene->material_count; ++i)
            mcv_material_settle_spectra(scene, scene->materials + i, pass);
        if (mcv_scene_channels(scene) == 1) return;
    }
}

/* --- channels --- */

bool mcv_is_grey(const double spectrum[3]) {
    return spectrum[0] == spectrum[1] && spectrum[1] == spectrum[2];
}

static bool grey_parameters(mcv_param_table table, const void *params) {
    for (size_t i = 0; i < table.count; ++i)
        if (table.params[i].kind == MCV_PARAM_spectrum &&
            !mcv_param_unset(table.params + i, params) &&
            !mcv_is_grey(
                (const double *)(const void *)((const char *)params + table.params[i].offset)))
            return false;
    return true;
}

uint32_t mcv_scene_channels(const mcv_scene *scene) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        if (!mcv_is_grey(scene->emitters[i].radiance)) return 3;
    for (uint32_t i = 0; i < scene->material_count; ++i)
        if (!grey_parameters(mcv_material_table(scene->materials[i].type), &scene->materials[i].as))
            return 3;
    for (uint32_t i = 0; i < scene->texture_count; ++i) {
        const mcv_texture *texture = scene->textures + i;
        if (texture->is_data) continue;
        const size_t pixels = (size_t)texture->width * texture->height;
        for (const uint8_t *p = texture->rgba; p && p < texture->rgba + 4 * pixels; p += 4)
            if (p[0] != p[1] || p[1] != p[2]) return 3;
        for (const float *p = texture->linear; p && p < texture->linear + 3 * pixels; p += 3)
            if (p[0] != p[1] || p[1] != p[2]) return 3;
    }
    return 1;
}
