/* SPDX-License-Identifier: Apache-2.0 */
/* The page of an experiment: plots of all metrics over the parameters that vary, and the rows
 * (io/plots.h). */
#ifndef MCVISI_HOST_EXPERIMENT_PAGE_H
#define MCVISI_HOST_EXPERIMENT_PAGE_H

#include "experiment/table.h"

/* Writes the page of the current rows to table->page. rig, the scene, is in its title. */
mcv_result mcv_experiment_page(const char *rig, const mcv_table *table, mcv_error *error);

#endif
