/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi check: how a scene was understood, and what rendering it takes. */
#include "check/findings.h"
#include "check/setup_page.h"
#include "cli/check_report.h"
#include "cli/command.h"
#include "core/output_file.h"
#include "device/features.h"
#include "device/pack.h"
#include "loader/load.h"
#include "render/render.h"
#include "scene/geometry.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"

#include <stdio.h>
#include <string.h>

enum {
    DEFINES_SLICE = 512
}; /* of the tile schedule, with the renderer's choice for paths that split */

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

static void report_work(mcv_report *report, const mcv_packed *packed,
                        const mcv_feature_causes *causes) {
    char text[512];
    static const char *const words[] = {
#define MCV_X(NAME, word, why) word,
        MCV_FEATURES(MCV_X)
#undef MCV_X
    };
    static const char *const reasons[] = {
#define MCV_X(NAME, word, why) \
    (why), /* parentheses: a text of several literals, not a missing comma */
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
        mcv_report_list(report, "warnings"); /* the sentences alone, a key older than severities */
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
            MCV_TRY(mcv_check_report_sensor(&report, scene, i, findings, error));
    mcv_report_close(&report);
    mcv_report_list(&report, "emitters");
    for (uint32_t i = 0; i < scene->emitter_count; ++i) mcv_check_report_emitter(&report, scene, i);
    mcv_report_close(&report);
    mcv_report_list(&report, "materials");
    for (uint32_t i = 0; i < scene->material_count; ++i)
        mcv_check_report_material(&report, scene, i);
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
                               const mcv_feature_causes *causes, const mcv_command *command,
                               mcv_error *error) {
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
            const bool disk =
                type == MCV_SENSOR_THIN_LENS ||
                type == MCV_SENSOR_TELECENTRIC; /* pupil guiding needs a round pupil */
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
