/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi devices: what --device can name. */
#include "cli/verbs.h"
#include "cli/tell.h"
#include "verbs/devices.h"

mcv_result mcv_verb_devices(const mcv_command *command, mcv_error *error) {
    mcv_report report;
    mcv_report_begin(&report, command->json, mcv_tell);
    if (!command->json) return mcv_cl_list(mcv_report_device, &report, error);
    mcv_report_list(&report, "devices");
    const mcv_result result = mcv_cl_list(mcv_report_device, &report, error);
    mcv_report_close(&report);
    mcv_error unreported = {""};
    const mcv_result reported = mcv_report_end(&report, &unreported);
    if (result != MCV_OK || reported == MCV_OK) return result;
    *error = unreported;
    return reported;
}
