/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The page of an experiment, for those who are to act on it: the best set, plots of all metrics
 * over the parameters that vary, the rig from the side, each set with its picture and the command
 * that renders it, and what was assumed. One HTML file that needs nothing else. Numbers have the
 * units in which they were given (experiment/units.h). What its script adds, links do without it.
 */
#ifndef MCVISI_HOST_EXPERIMENT_PAGE_H
#define MCVISI_HOST_EXPERIMENT_PAGE_H

#include "experiment/experiment.h"

/*
 * Writes the page of the current rows to table.page. Pictures are those that the experiment keeps
 * (images). The date is today's, or that of the environment's SOURCE_DATE_EPOCH, so that equal
 * tables give equal pages. After an interruption the page is written without the pictures that it
 * would render, and the interruption is the result.
 */
mcv_result mcv_experiment_page(const mcv_sweep *sweep, mcv_error *error);

#endif
