/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Arithmetic with names, as users type it: + - * / ^ ( ), comparisons (< <= > >= == !=, 1 or 0), &&
 * and ||; the functions abs sqrt exp log sin cos tan asin acos atan, min and max of two values;
 * u(NAME), the standard uncertainty of a name; the number pi. A number may have a unit: 2mm,
 * 0.5deg. Names consist of letters, digits, _ and points, and begin with a letter or _.
 */
#ifndef MCVISI_HOST_EXPERIMENT_EXPRESSION_H
#define MCVISI_HOST_EXPERIMENT_EXPRESSION_H

#include "analysis/region.h"

/* Looks up the quantity of a name. If it fails, the sentence says why. */
typedef mcv_result mcv_lookup(void *user, const char *name, mcv_quantity *quantity,
                              mcv_error *error);

enum { MCV_EXPRESSION_NAMES = 16, MCV_EXPRESSION_DEPTH = 64 };

/*
 * The value, with the names' uncertainties propagated to first order. The contributions of several
 * names are added linearly: an upper bound for any correlation, because names are often figures of
 * one image. MCV_USAGE says what is wrong in the text, and where.
 */
mcv_result mcv_expression_evaluate(const char *text, mcv_lookup *lookup, void *user,
                                   mcv_quantity *value, mcv_error *error);

#endif
