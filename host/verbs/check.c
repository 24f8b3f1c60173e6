/* SPDX-License-Identifier: Apache-2.0 */
/* What was understood of a scene, and what rendering it takes. */
#include "verbs/check.h"

#include "check/setup_page.h"
#include "core/output_file.h"
#include "loader/load.h"
#include "render/render.h"
#include "scene/geometry.h"
#include "scene/memory.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"
#include "strict/strict.h"
#include "verbs/check_report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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

static void report_memory(mcv_report *report, const mcv_memory *memory) {
    mcv_report_open(report, "memory");
    mcv_report_number(report, "files", "B", (double)memory->files);
    mcv_report_number(report, "images", "B", (double)memory->images);
    mcv_report_number(report, "geometry", "B", (double)memory->geometry);
    mcv_report_number(report, "limit", "B", (double)memory->limit);
    mcv_report_close(report);
}

static mcv_result report_all(const mcv_scene *scene, const mcv_packed *packed,
                             const mcv_feature_causes *causes, const mcv_command *command,
                             mcv_findings *findings, mcv_report *report, mcv_error *error) {
    uint32_t only = MCV_NONE;
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, &only, error));
    mcv_report_text(report, "scene", scene->path);
    report_size(report, scene);
    mcv_report_list(report, "sensors");
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (only == MCV_NONE || only == i)
            MCV_TRY(mcv_check_report_sensor(report, scene, i, findings, error));
    mcv_report_close(report);
    mcv_report_list(report, "emitters");
    for (uint32_t i = 0; i < scene->emitter_count; ++i) mcv_check_report_emitter(report, scene, i);
    mcv_report_close(report);
    mcv_report_list(report, "materials");
    for (uint32_t i = 0; i < scene->material_count; ++i)
        mcv_check_report_material(report, scene, i);
    mcv_report_close(report);
    report_work(report, packed, causes);
    report_memory(report, &scene->memory);
    report_findings(report, findings);
    return MCV_OK;
}

mcv_result mcv_check_pack(const mcv_command *command, const mcv_scene *scene, mcv_checked *checked,
                          mcv_error *error) {
    checked->sensor = 0;
    if (scene->sensor_count == 0)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
            scene->path);
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, &checked->sensor, error));
    if (command->html) MCV_TRY(mcv_output_check(command->html, error));
    MCV_TRY(mcv_pack_for_features(scene, &checked->packed, error));
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (i == checked->sensor || (!command->sensor && !command->defines))
            checked->packed.features =
                mcv_decide_features(scene, &checked->packed, &scene->sensors[i],
                                    (mcv_feature_options){0}, &checked->causes);
    return MCV_OK;
}

mcv_result mcv_check_strict(const mcv_command *command, const mcv_document *document,
                            mcv_report *report, mcv_error *error) {
    mcv_strict_findings findings;
    const uint64_t most = command->memory > 0 ? (uint64_t)command->memory : mcv_memory_default();
    MCV_TRY(mcv_strict_check_document(document->path, document->root, document->binary, most,
                                      &findings, error));
    mcv_report_text(report, "scene", document->path);
    mcv_report_list(report, "strict");
    for (size_t i = 0; i < findings.count; ++i) {
        const mcv_strict_finding *finding = findings.items + i;
        mcv_report_open(report, finding->code);
        if (report->json) mcv_report_text(report, "code", finding->code);
        mcv_report_text(report, "path", finding->pointer);
        mcv_report_text(report, "text", finding->text);
        mcv_report_close(report);
    }
    mcv_report_close(report);
    mcv_strict_free(&findings);
    return MCV_OK;
}

mcv_result mcv_check(const mcv_command *command, const mcv_scene *scene, mcv_report *report,
                     mcv_error *error) {
    mcv_findings findings;
    mcv_checked checked = {0};
    MCV_TRY(mcv_check_pack(command, scene, &checked, error));
    mcv_result result = mcv_findings_of(scene, &findings, error);
    if (result == MCV_OK) {
        result =
            report_all(scene, &checked.packed, &checked.causes, command, &findings, report, error);
        if (result == MCV_OK && command->html)
            result = mcv_setup_page_write(command->html, scene, &findings, error);
        mcv_findings_free(&findings);
    }
    mcv_packed_free(&checked.packed);
    return result;
}
