/* SPDX-License-Identifier: Apache-2.0 */
/* The maximum of a censored response's likelihood (statistics/response.h). */
#ifndef MCVISI_HOST_STATISTICS_RESPONSE_CENSORED_H
#define MCVISI_HOST_STATISTICS_RESPONSE_CENSORED_H

#include "statistics/response.h"

#include <stdbool.h>

/* parameters: intercept, slope and scatter, the last by maximum likelihood; first guesses before.
 * False where the steps do not end. */
bool mcv_response_censored_fit(const mcv_response_data *data, double parameters[3],
                               double *log_likelihood);

#endif
