/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi devices: what --device can name. */
#include "cl/cl.h"
#include "cli/options.h"
#include "cli/report.h"

#include <stdio.h>

static void report_device(void *user, unsigned index, const mcv_cl *device) {
    mcv_report *report = user;
    char title[300];
    snprintf(title, sizeof title, "%u: %s", index, device->name);
    mcv_report_open(report, NULL, title);
    mcv_report_number(report, "number", "", index);
    mcv_report_text(report, "name", device->name);
    mcv_report_text(report, "type", device->cpu ? "cpu" : "gpu");
    mcv_report_number(report, "compute_units", "", device->units);
    mcv_report_number(report, "memory", "bytes", (double)device->memory);
    mcv_report_number(report, "largest_allocation", "bytes", (double)device->largest_allocation);
    mcv_report_text(report, "version", device->version);
    mcv_report_close(report);
}

mcv_result mcv_verb_devices(const mcv_command *command, mcv_error *error) {
    mcv_report report;
    mcv_report_begin(&report, command->json);
    mcv_report_list(&report, "devices");
    const mcv_result listed = mcv_cl_list(report_device, &report, error);
    mcv_report_close(&report);
    const mcv_error kept = *error;
    const mcv_result printed = mcv_report_end(&report, error);
    if (listed == MCV_OK) return printed;
    *error = kept;
    return listed;
}
