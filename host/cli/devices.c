/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi devices: the devices for --device. */
#include "cl/cl.h"
#include "cli/command.h"
#include "cli/report.h"

#include <stdio.h>

static void report_device(void *user, unsigned index, const mcv_cl *device) {
    mcv_report *report = user;
    const char *type = device->cpu ? "cpu" : "gpu";
    if (!report->json) {
        printf("%u  %s  %s, %u compute units, %.1f GiB\n   %s\n", index, device->name, type,
               device->units, (double)device->memory / 0x1p30, device->version);
        return;
    }
    mcv_report_element(report, device->name, type);
    mcv_report_number(report, "number", "", index);
    mcv_report_number(report, "compute_units", "", device->units);
    mcv_report_number(report, "memory", "B", (double)device->memory);
    mcv_report_number(report, "largest_allocation", "B", (double)device->largest_allocation);
    mcv_report_text(report, "version", device->version);
    mcv_report_close(report);
}

mcv_result mcv_verb_devices(const mcv_command *command, mcv_error *error) {
    mcv_report report;
    mcv_report_begin(&report, command->json);
    if (!command->json) return mcv_cl_list(report_device, &report, error);
    mcv_report_list(&report, "devices");
    const mcv_result result = mcv_cl_list(report_device, &report, error);
    mcv_report_close(&report);
    mcv_error unreported = {""};
    const mcv_result reported = mcv_report_end(&report, &unreported);
    if (result != MCV_OK || reported == MCV_OK) return result;
    *error = unreported;
    return reported;
}
