/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/devices.h"

void mcv_report_device(void *user, unsigned index, const mcv_cl *device) {
    mcv_report *report = user;
    const char *type = device->cpu ? "cpu" : "gpu";
    mcv_report_element(report, device->name, type);
    mcv_report_number(report, "number", "", index);
    mcv_report_number(report, "compute_units", "", device->units);
    mcv_report_number(report, "memory", "B", (double)device->memory);
    mcv_report_number(report, "largest_allocation", "B", (double)device->largest_allocation);
    mcv_report_text(report, "version", device->version);
    mcv_report_close(report);
}
