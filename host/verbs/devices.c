/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/devices.h"

#include <stdio.h>

void mcv_report_device(void *user, unsigned index, const mcv_cl *device) {
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
