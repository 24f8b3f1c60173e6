/* SPDX-License-Identifier: Apache-2.0 */
#include "pod/common_noise.h"

#include "core/json.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

/* "NAME:=exec(…)" or "NAME:=worker(…)" of this name. */
static bool is_program(const json_t *metric, const char *name) {
    const char *text = json_string_value(metric);
    const size_t length = strlen(name);
    if (!text || strncmp(text, name, length) != 0 || strncmp(text + length, ":=", 2) != 0)
        return false;
    return strncmp(text + length + 2, "exec(", 5) == 0 ||
           strncmp(text + length + 2, "worker(", 7) == 0;
}

static bool is_common(const json_t *experiment, const char *name) {
    const char *noise = json_string_value(json_object_get(experiment, "noise"));
    const json_t *metrics = json_object_get(experiment, "metric"), *metric;
    size_t i;
    if (!json_object_get(experiment, "vary") || (noise && strcmp(noise, "own") == 0)) return false;
    if (is_program(metrics, name)) return false;
    json_array_foreach((json_t *)metrics, i, metric) {
        if (is_program(metric, name)) return false;
    }
    return true;
}

bool mcv_pod_common_noise(const char *table, const char *value_name) {
    char path[PATH_MAX];
    const char *dot = strrchr(table, '.');
    if (!dot || snprintf(path, sizeof path, "%.*s.json", (int)(dot - table), table) >= PATH_MAX)
        return false;
    json_t *experiment;
    mcv_error ignored;
    if (mcv_json_file_read(path, &experiment, &ignored) != MCV_OK) return false;
    const bool common = is_common(experiment, value_name);
    json_decref(experiment);
    return common;
}
