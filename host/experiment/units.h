/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers for people: in the units in which the user has given them. Files hold SI units. */
#ifndef MCVISI_HOST_EXPERIMENT_UNITS_H
#define MCVISI_HOST_EXPERIMENT_UNITS_H

#include "analysis/metrics.h"
#include "experiment/plan.h"

typedef struct mcv_shown_unit {
    char name[24]; /* "mm", "°"; "" for a plain number */
    double per_si; /* what a number in SI units is multiplied with */
} mcv_shown_unit;

/* The first unit in the values of a parameter's "PATH=VALUES". A tie, and values without a unit:
 * SI, without a name. */
mcv_shown_unit mcv_unit_of_parameter(const mcv_parameter *parameter);

/*
 * The unit of a metric (mcv_metric_unit of analysis/metrics.h): lengths as m, mm or µm by
 * `largest`, the largest number [SI] to be shown; angles in degrees.
 */
mcv_shown_unit mcv_unit_of_metric(const char *expression, mcv_metric_units units, double largest);

/* A name with its unit: "diameter [mm]". */
void mcv_name_with_unit(const char *name, const mcv_shown_unit *unit, char words[], size_t size);

/*
 * A value with the standard uncertainty of its last two digits, as JCGM 100:2008 7.2.2 writes it:
 * "12.3456(21)". "12 ± 40" where the uncertainty is larger than the value, "12.35" without one,
 * "" for NaN.
 */
void mcv_value_words(double value, double uncertainty, char words[48]);

/* The shortest number that strtod reads as the same one. */
void mcv_exact_words(double value, char words[32]);

#endif
