/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi check: what was understood of a scene, and what rendering it takes. */
#include "check/findings.h"
#include "device/features.h"
#include "check/growth.h"
#include "cli/command.h"
#include "cli/report.h"
#include "scene/sensor_find.h"
#include "core/output_file.h"
#include "check/setup_page.h"
#include "reference/filling.h"
#include "device/pack.h"
#include "render/render.h"
#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "loader/load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    DEFINES_SLICE = 512
}; /* of the tile schedule, as the renderer chooses it where paths split */

/* --- scene
 * ------------------------------------------------------------------------------------------------------
 */

static void report_size(mcv_report *report, const mcv_scene *scene) {
    double lower[3] = {INFINITY, INFINITY, INFINITY};
    double upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        double low[3], high[3];
        mcv_scene_box(scene, i, low, high);
        for (int k = 0; k < 3; ++k) {
            lower[k] = fmin(lower[k], low[k]);
            upper[k] = fmax(upper[k], high[k]);
        }
    }
    mcv_report_number(report, "triangles", "", scene->triangle_count);
    if (scene->triangle_count == 0) return;
    mcv_report_numbers(
        report, "size", "m", " x ",
        (const double[]){upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]}, 3);
    mcv_report_numbers(report, "lower_corner", "m", ", ", lower, 3);
    mcv_report_numbers(report, "upper_corner", "m", ", ", upper, 3);
}

/* --- elements
 * ---------------------------------------------------------------------------------------------------
 */

/* All parameters of an element, as they are after everything that follows from others has been
 * derived. */
static void report_parameters(mcv_report *report, mcv_param_table table, const void *params) {
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
        case MCV_PARAM_choice:
            mcv_report_text(report, p->key, mcv_param_options(p->key)[*(const int *)field]);
            break;
        }
    }
}

static void report_place(mcv_report *report, const mcv_transform *to_world) {
    const double *m = to_world->m;
    mcv_report_numbers(report, "position", "m", ", ", m + 9, 3);
    mcv_report_numbers(report, "faces", "", ", ", (const double[]){-m[2], -m[5], -m[8]}, 3);
}

/* Less of a pupil, or of the directions, is likely not meant. */
static const double little = 0.5;

/* What the emitters of a cone before a sensor light of its pupil, or of its directions. */
static mcv_result report_fillings(mcv_report *report, const mcv_scene *scene, uint32_t index,
                                  mcv_findings *findings, mcv_error *error) {
    const mcv_sensor *sensor = scene->sensors + index;
    const bool directions = sensor->type == MCV_SENSOR_LIGHT_FIELD;
    ref_filling *fillings;
    uint32_t count;
    mcv_result result = ref_sensor_fillings(scene, index, &fillings, &count, error);
    if (result == MCV_OK && count > 0) mcv_report_list(report, "faces_emitters");
    for (uint32_t i = 0; i < count && result == MCV_OK; ++i) {
        const mcv_emitter *emitter = scene->emitters + fillings[i].emitter;
        mcv_report_element(report, emitter->name, mcv_emitter_types[emitter->type]);
        mcv_report_number(report, directions ? "share_of_directions_lit" : "share_of_pupil_lit", "",
                          fillings[i].share);
        mcv_report_close(report);
        if (fillings[i].share < little)
            result = mcv_findings_add(findings, MCV_SEVERITY_WARNING, "emitters", emitter->name,
                                      NULL, error,
                                      "emitter \"%s\" lights %.2g %% of the %s of sensor \"%s\", "
                                      "where that looks into it: its cone "
                                      "is narrower than what the sensor takes in",
                                      emitter->name, 100 * fillings[i].share,
                                      directions ? "J x K directions" : "pupil", sensor->name);
    }
    if (result == MCV_OK && count > 0) mcv_report_close(report);
    free(fillings);
    return result;
}

/* How edges before a backlight grow. */
static void report_growth(mcv_report *report, const mcv_scene *scene, const mcv_sensor *sensor) {
    mcv_growth growth;
    char sentence[512];
    if (!mcv_growth_of(scene, sensor, &growth)) return;
    mcv_growth_sentence(scene, &growth, sentence);
    mcv_report_open(report, "silhouettes");
    mcv_report_text(report, "backlight", scene->emitters[growth.emitter].name);
    mcv_report_text(report, "part", scene->instances[growth.instance].name);
    mcv_report_number(report, "thickness", "m", growth.thickness);
    mcv_report_number(report, "tangent_of_cone", "", growth.cone);
    mcv_report_quantity(report, "growth_of_edge", "m", growth.edge.value, growth.edge.uncertainty);
    if (report->json)
        mcv_report_text(report, "note", sentence); /* people read it among the findings */
    mcv_report_close(report);
}

static mcv_result report_sensor(mcv_report *report, const mcv_scene *scene, uint32_t index,
                                mcv_findings *findings, mcv_error *error) {
    const mcv_sensor *sensor = scene->sensors + index;
    const mcv_optics optics = mcv_sensor_optics(sensor);
    uint32_t width, height;
    char label[128];
    mcv_sensor_film_size(sensor, &width, &height);
    mcv_sensor_label(scene, index, label, sizeof label);
    mcv_report_element(report, label, mcv_sensor_types[sensor->type]);
    report_place(report, &sensor->to_world);
    mcv_report_numbers(report, "image", "", " x ", (const double[]){width, height}, 2);
    report_parameters(report, mcv_sensor_table(sensor->type), &sensor->as);
    mcv_report_open(report, "optics");
    mcv_report_number(report, "magnification", "", optics.magnification);
    mcv_report_number(report, "working_distance", "m", optics.focused_depth);
    mcv_report_numbers(report, "depth_of_field", "m", " to ", optics.depth_of_field, 2);
    mcv_report_numbers(report, "field_of_view", "m", " x ", optics.field, 2);
    mcv_report_numbers(report, "angle_of_view", "rad", " x ", optics.field_angle, 2);
    mcv_report_number(report, "f_number", "", optics.f_number);
    mcv_report_number(report, "numerical_aperture", "", optics.numerical_aperture);
    mcv_report_numbers(report, "macro_pixel_pitch", "m", " x ", optics.macro_pixel, 2);
    mcv_report_close(report);
    MCV_TRY(report_fillings(report, scene, index, findings, error));
    report_growth(report, scene, sensor);
    mcv_report_close(report);
    return MCV_OK;
}

static void report_radiometry(mcv_report *report, const char *key, const char *unit,
                              const mcv_emitter *emitter, double factor, const double mean[3]) {
    const double *l = emitter->radiance;
    mcv_report_spectrum(report, key, unit,
                        (const double[]){factor * mean[0] * l[0], factor * mean[1] * l[1],
                                         factor * mean[2] * l[2]});
}

/* A projector's lens, and the size of its picture where that is sharp. */
static void report_lens(mcv_report *report, const mcv_scene *scene, const mcv_emitter *emitter) {
    const mcv_projector_params *p = &emitter->as.projector;
    const double scale = p->focusDistance / p->imageDistance;
    uint32_t pixels[2];
    mcv_projector_resolution(p, scene->textures + emitter->texture, pixels);
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

static void report_emitter(mcv_report *report, const mcv_scene *scene, uint32_t index) {
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
        report_place(report, &instance->to_world);
    } else if (emitter->type != MCV_EMITTER_ENVIRONMENT || emitter->texture != MCV_NONE) {
        report_place(report, &emitter->to_world);
    }
    if (!isnan(half_angle)) mcv_report_number(report, "halfAngle", "rad", half_angle);
    mcv_report_number(report, "solid_angle", "sr", mcv_emitter_solid_angle(emitter));
    report_radiometry(report, key, unit, emitter, 1, (const double[]){1, 1, 1});
    if (emitter->type == MCV_EMITTER_PROJECTOR) report_lens(report, scene, emitter);
    if (radiant)
        report_radiometry(report, "exitance", "W/m²", emitter,
                          mcv_emitter_projected_solid_angle(emitter), mean);
    if (emitter->instance != MCV_NONE) mcv_report_number(report, "area", "m²", emitter->area);
    if (!isnan(power)) report_radiometry(report, "power", "W", emitter, power, mean);
    if (mcv_emitter_image(&own) && emitter->texture != MCV_NONE) {
        const mcv_texture *image = scene->textures + emitter->texture;
        mcv_report_text(report, "image", image->name);
        mcv_report_numbers(report, "pixels", "", " x ",
                           (const double[]){image->width, image->height}, 2);
        mcv_report_spectrum(report, "mean_of_image", "", mean);
    } else if (emitter->texture != MCV_NONE) {
        mcv_report_text(report, "texture", "an image lowers these values");
    }
    mcv_report_close(report);
}

static void report_material(mcv_report *report, const mcv_scene *scene, uint32_t index) {
    const mcv_material *material = scene->materials + index;
    double triangles = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == index)
            triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    mcv_report_element(report, material->name, mcv_material_types[material->type]);
    mcv_report_number(report, "triangles", "", triangles);
    report_parameters(report, mcv_material_table(material->type), &material->as);
    if (material->texture != MCV_NONE)
        mcv_report_text(report, "texture", scene->textures[material->texture].name);
    mcv_report_close(report);
}

/* --- what rendering takes
 * --------------------------------------------------------------------------------------- */

static void report_work(mcv_report *report, const mcv_packed *packed,
                        const mcv_feature_causes *causes) {
    char text[512];
    static const char *const words[] = {
#define MCV_X(NAME, word, why) word,
        MCV_FEATURES(MCV_X)
#undef MCV_X
    };
    static const char *const reasons[] = {
#define MCV_X(NAME, word, why) (why), /* a text of several pieces, no missing comma */
        MCV_FEATURES(MCV_X)
#undef MCV_X
    };
    MCV_FEATURE_VARIABLES(packed->features)
    mcv_report_open(report, "features");
    for (unsigned i = 0; i < MCV_FEATURE_COUNT; ++i)
        if (packed->features >> i & 1) {
            snprintf(text, sizeof text, "%s: %s", reasons[i], causes->of[i]);
            mcv_report_text(report, words[i], text);
        }
    mcv_report_close(report);
    mcv_report_open(report, "stages");
#define MCV_X(stage, runs) \
    mcv_report_text(report, #stage, \
                    strcmp(#runs, "1") == 0 ? "runs always" \
                    : (runs)                ? "runs" \
                                            : "left out");
    MCV_STAGES(MCV_X)
#undef MCV_X
    mcv_report_close(report);
    mcv_report_number(report, "channels", "", packed->channels);
    mcv_report_number(report, "bytes_per_path", "",
                      4.0 * mcv_path_words(packed->features, packed->channels));
}

static void report_findings(mcv_report *report, const mcv_findings *findings) {
    if (report->json) {
        mcv_report_list(report,
                        "warnings"); /* the sentences alone, as before there were severities */
        for (size_t i = 0; i < findings->count; ++i)
            if (findings->items[i].severity >= MCV_SEVERITY_WARNING)
                mcv_report_text(report, "-", findings->items[i].sentence);
        mcv_report_close(report);
    } else if (findings->count == 0) {
        return;
    }
    mcv_report_list(report, "findings");
    for (size_t i = 0; i < findings->count; ++i) {
        const mcv_finding *finding = findings->items + i;
        const char *severity = mcv_severities[finding->severity];
        if (!report->json) {
            mcv_report_text(report, severity, finding->sentence);
            continue;
        }
        mcv_report_open(report, "finding");
        mcv_report_text(report, "severity", severity);
        mcv_report_text(report, "path", finding->path);
        mcv_report_text(report, "text", finding->sentence);
        mcv_report_close(report);
    }
    mcv_report_close(report);
}

static mcv_result print_report(const mcv_scene *scene, const mcv_packed *packed,
                               const mcv_feature_causes *causes, const mcv_command *command,
                               mcv_findings *findings, mcv_error *error) {
    mcv_report report;
    uint32_t only = MCV_NONE;
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, &only, error));
    mcv_report_begin(&report, command->json);
    mcv_report_text(&report, "scene", scene->path);
    report_size(&report, scene);
    mcv_report_list(&report, "sensors");
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (only == MCV_NONE || only == i)
            MCV_TRY(report_sensor(&report, scene, i, findings, error));
    mcv_report_close(&report);
    mcv_report_list(&report, "emitters");
    for (uint32_t i = 0; i < scene->emitter_count; ++i) report_emitter(&report, scene, i);
    mcv_report_close(&report);
    mcv_report_list(&report, "materials");
    for (uint32_t i = 0; i < scene->material_count; ++i) report_material(&report, scene, i);
    mcv_report_close(&report);
    report_work(&report, packed, causes);
    report_findings(&report, findings);
    return mcv_report_end(&report, error);
}

static void print_defines(uint32_t features, uint32_t channels, uint32_t sensor_type) {
    char options[1024];
    mcv_feature_defines(features, channels, sensor_type, MCV_SAMPLER_SOBOL, DEFINES_SLICE, options,
                        sizeof options);
    puts(options);
}

static mcv_result report_scene(const mcv_scene *scene, const mcv_packed *packed,
                               const mcv_feature_causes *causes,
                               const mcv_command *command, mcv_error *error) {
    mcv_findings findings;
    MCV_TRY(mcv_findings_of(scene, &findings, error));
    mcv_result result = print_report(scene, packed, causes, command, &findings, error);
    if (result == MCV_OK && command->html)
        result = mcv_setup_page_write(command->html, scene, &findings, error);
    mcv_findings_free(&findings);
    return result;
}

static mcv_result check_scene(const mcv_command *command, const mcv_scene *scene,
                              mcv_error *error) {
    mcv_packed packed;
    mcv_feature_causes causes;
    uint32_t sensor = 0;
    if (scene->sensor_count == 0)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
            scene->path);
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, &sensor, error));
    if (command->html) MCV_TRY(mcv_output_check(command->html, error));
    MCV_TRY(mcv_pack(scene, NULL, &packed, error));
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (i == sensor || (!command->sensor && !command->defines))
            packed.features = mcv_decide_features(scene, &packed, &scene->sensors[i],
                                                  (mcv_feature_options){0}, &causes);
    mcv_result result = MCV_OK;
    if (command->defines)
        print_defines(packed.features, packed.channels, scene->sensors[sensor].type);
    else
        result = report_scene(scene, &packed, &causes, command, error);
    mcv_packed_free(&packed);
    return result;
}

mcv_result mcv_verb_check(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    if (!command->argument) {
        if (!command->defines)
            return mcv_fail(error, MCV_USAGE, "SCENE is missing: `mcvisi check SCENE`");
        for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type) {
            const bool disk = type == MCV_SENSOR_THIN_LENS ||
                              type == MCV_SENSOR_TELECENTRIC; /* only in a disk a pixel aims */
            const uint32_t all = (1u << MCV_FEATURE_COUNT) - 1;
            print_defines(disk ? all : all & ~(1u << MCV_FEATURE_AIM), 3, type);
        }
        return MCV_OK;
    }
    MCV_TRY(mcv_scene_load(command->argument,
                           (mcv_overrides){command->set.items, command->set.count}, &scene, error));
    const mcv_result result = check_scene(command, scene, error);
    mcv_scene_free(scene);
    return result;
}
