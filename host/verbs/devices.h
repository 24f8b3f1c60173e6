/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_VERBS_DEVICES_H
#define MCVISI_HOST_VERBS_DEVICES_H

#include "cl/cl.h"
#include "verbs/report.h"

/* Tells of a device, for mcv_cl_list: user is the mcv_report, in which a list is open. */
void mcv_report_device(void *user, unsigned index, const mcv_cl *device);

#endif
