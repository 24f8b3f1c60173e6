/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi devices: what --device can name. A client of the public header. */
#include "cli/verbs.h"
#include "core/error.h"

#include <stdio.h>

static double number_of(const json_t *device, const char *key) {
    return json_number_value(json_object_get(device, key));
}

static const char *text_of(const json_t *device, const char *key) {
    const char *text = json_string_value(json_object_get(device, key));
    return text ? text : "";
}

static void print_devices(const json_t *devices) {
    size_t i;
    const json_t *d;
    json_array_foreach((json_t *)devices, i, d) {
        printf("%.0f  %s  %s, %.0f compute units, %.1f GiB\n   %s\n", number_of(d, "number"),
               text_of(d, "name"), text_of(d, "type"), number_of(d, "compute_units"),
               number_of(d, "memory") / 0x1p30, text_of(d, "version"));
    }
}

mcv_result mcv_verb_devices(const mcv_command *command, mcv_error *error) {
    char *report;
    MCV_TRY(mcv_devices(&report, error));
    json_t *document = json_loads(report, 0, NULL);
    const char *message = json_string_value(json_object_get(document, "message"));
    const mcv_result result =
        message ? mcv_fail(error, MCV_DEVICE, "%s", message) : MCV_OK; /* there is none */
    mcv_text_free(report);
    json_object_del(document, "message");
    if (command->json) {
        json_dumpf(document, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
        putchar('\n');
    } else {
        print_devices(json_object_get(document, "devices"));
    }
    json_decref(document);
    return result;
}
