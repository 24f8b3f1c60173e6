/* SPDX-License-Identifier: Apache-2.0 */
/* The report of mcvisi check about emitters and materials, and about the parameters of all
 * elements. */
#include "verbs/check_report.h"

#include "scene/emitters.h"
#include "scene/geometry.h"
#include "scene/laser.h"
#include "scene/materials.h"
#include "scene/mesh.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "scene/spectra.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void report_mask(mcv_report *report, const char *key, const mcv_mask *mask) {
    char cells[32];
    if (mask->side == 0) return;
    snprintf(cells, sizeof cells, "%u x %u", mask->side, mask->side);
    mcv_report_text(report, key, cells);
}

static void report_curve(mcv_report *report, const char *key, const mcv_curve *curve) {
    char ends[96];
    if (curve->count == 0) return;
    const uint32_t last = curve->count - 1;
    snprintf(ends, sizeof ends, "%u pairs, %g on the axis to %g at %g m", curve->count,
             curve->value[0], curve->value[last], curve->at[last]);
    mcv_report_text(report, key, ends);
}

void mcv_check_report_parameters(mcv_report *report, mcv_param_table table, const void *params) {
    for (size_t i = 0; i < table.count; ++i) {
        const mcv_param *p = table.params + i;
        const void *field = (const char *)params + p->offset;
        if (mcv_param_unset(p, params)) continue;
        switch (p->kind) {
        case MCV_PARAM_length:
            mcv_report_number(report, p->key, "m", *(const double *)field);
            break;
        case MCV_PARAM_angle:
            mcv_report_number(report, p->key, "rad", *(const double *)field);
            break;
        case MCV_PARAM_number:
            mcv_report_number(report, p->key, "", *(const double *)field);
            break;
        case MCV_PARAM_integer:
        case MCV_PARAM_int2:
        case MCV_PARAM_int4: {
            const uint32_t *values = field;
            double numbers[4];
            const size_t count = mcv_param_components(p->kind);
            for (size_t k = 0; k < count; ++k) numbers[k] = values[k];
            mcv_report_numbers(report, p->key, "", count == 2 ? " x " : ", ", numbers, count);
            break;
        }
        case MCV_PARAM_length2:
            mcv_report_numbers(report, p->key, "m", " x ", field, 2);
            break;
        case MCV_PARAM_number2:
            mcv_report_numbers(report, p->key, "", ", ", field, 2);
            break;
        case MCV_PARAM_spectrum:
            mcv_report_spectrum(report, p->key, "", field);
            break;
        case MCV_PARAM_flag:
        case MCV_PARAM_image:
        case MCV_PARAM_pattern: /* of emitters only, which report_emitter describes */
            break;
        case MCV_PARAM_mask:
            report_mask(report, p->key, field);
            break;
        case MCV_PARAM_curve:
            report_curve(report, p->key, field);
            break;
        case MCV_PARAM_text:
            mcv_report_text(report, p->key, field);
            break;
        case MCV_PARAM_choice:
            mcv_report_text(report, p->key, mcv_param_options(p->key)[*(const int *)field]);
            break;
        }
    }
}

void mcv_check_report_place(mcv_report *report, const mcv_transform *to_world) {
    const double *m = to_world->m;
    mcv_report_numbers(report, "position", "m", ", ", m + 9, 3);
    mcv_report_numbers(report, "faces", "", ", ", (const double[]){-m[2], -m[5], -m[8]}, 3);
}

static void report_radiometry(mcv_report *report, const char *key, const char *unit,
                              const mcv_emitter *emitter, double factor, const double mean[3]) {
    const double *l = emitter->radiance;
    mcv_report_spectrum(report, key, unit,
                        (const double[]){factor * mean[0] * l[0], factor * mean[1] * l[1],
                                         factor * mean[2] * l[2]});
}

/* A projector's lens, and the size of its picture in focus. */
static void report_lens(mcv_report *report, const mcv_scene *scene, const mcv_emitter *emitter) {
    const mcv_projector_params *p = &emitter->as.projector;
    const double scale = p->focusDistance / p->imageDistance;
    uint32_t pixels[2];
    mcv_picture_resolution(&p->pattern, scene->textures + emitter->texture, pixels);
    mcv_report_number(report, "focalLength", "m", p->focalLength);
    mcv_report_number(report, "imageDistance", "m", p->imageDistance);
    mcv_report_number(report, "focusDistance", "m", p->focusDistance);
    mcv_report_number(report, "lensDiameter", "m", p->lensDiameter);
    mcv_report_number(report, "fNumber", "", p->fNumber);
    mcv_report_numbers(
        report, "picture_in_focus", "m", " x ",
        (const double[]){scale * pixels[0] * p->pixelSize[0], scale * pixels[1] * p->pixelSize[1]},
        2);
}

/* A laser's beam: what its diameter or thickness says by 1/e², and how it spreads. */
static void report_laser(mcv_report *report, const mcv_emitter *emitter) {
    const mcv_laser_beam beam = mcv_laser_beam_of(&emitter->as.laser);
    const size_t first = beam.is_line, count = 2 - first;
    mcv_report_number(report, "wavelength", "m", emitter->as.laser.wavelength);
    mcv_report_numbers(report, "waist_radius", "m", " x ", beam.waist + first, count);
    mcv_report_numbers(report, "divergence", "rad", " x ", beam.divergence + first, count);
    mcv_report_numbers(report, "rayleigh_length", "m", " x ", beam.rayleigh + first, count);
    mcv_report_number(report, "workingDistance", "m", emitter->as.laser.workingDistance);
    if (beam.is_line) mcv_report_number(report, "fanAngle", "rad", emitter->as.laser.fanAngle);
}

void mcv_check_report_emitter(mcv_report *report, const mcv_scene *scene, uint32_t index) {
    const mcv_emitter *emitter = scene->emitters + index;
    const double half_angle = mcv_emitter_half_angle(emitter),
                 power = mcv_emitter_unit_power(scene, emitter);
    const char *unit, *key = mcv_emitter_brightness(emitter, &unit);
    const bool radiant = strcmp(key, "radiance") == 0;
    double mean[3];
    mcv_emitter own = *emitter;
    mcv_emitter_image_mean(scene, emitter, mean);
    mcv_report_element(report, emitter->name, mcv_emitter_types[emitter->type]);
    if (emitter->instance != MCV_NONE) {
        const mcv_instance *instance = scene->instances + emitter->instance;
        mcv_report_text(report, "node", instance->name);
        mcv_check_report_place(report, &instance->to_world);
    } else if (emitter->type != MCV_EMITTER_ENVIRONMENT || emitter->texture != MCV_NONE) {
        mcv_check_report_place(report, &emitter->to_world);
    }
    if (!isnan(half_angle)) mcv_report_number(report, "halfAngle", "rad", half_angle);
    mcv_report_number(report, "solid_angle", "sr", mcv_emitter_solid_angle(emitter));
    report_radiometry(report, key, unit, emitter, 1, (const double[]){1, 1, 1});
    if (emitter->type == MCV_EMITTER_PROJECTOR) report_lens(report, scene, emitter);
    if (emitter->type == MCV_EMITTER_LASER) report_laser(report, emitter);
    if (radiant)
        report_radiometry(report, "exitance", "W/m²", emitter,
                          mcv_emitter_projected_solid_angle(emitter), mean);
    if (emitter->instance != MCV_NONE) mcv_report_number(report, "area", "m²", emitter->area);
    if (!isnan(power) && strcmp(key, "power") != 0)
        report_radiometry(report, "power", "W", emitter, power, mean);
    if (mcv_emitter_image(&own) && emitter->texture != MCV_NONE) {
        const mcv_texture *image = scene->textures + emitter->texture;
        mcv_report_text(report, "image", image->name);
        mcv_report_numbers(report, "pixels", "", " x ",
                           (const double[]){image->width, image->height}, 2);
        mcv_report_spectrum(report, "mean_of_image", "", mean);
    } else if (emitter->texture != MCV_NONE) {
        mcv_report_text(report, "texture", "an image scales these values down");
    }
    mcv_report_close(report);
}

void mcv_check_report_material(mcv_report *report, const mcv_scene *scene, uint32_t index) {
    const mcv_material *material = scene->materials + index;
    double triangles = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == index)
            triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    mcv_report_element(report, material->name, mcv_material_types[material->type]);
    mcv_report_number(report, "triangles", "", triangles);
    mcv_check_report_parameters(report, mcv_material_table(material->type), &material->as);
    if (material->texture != MCV_NONE)
        mcv_report_text(report, "texture", scene->textures[material->texture].name);
    mcv_report_close(report);
}
