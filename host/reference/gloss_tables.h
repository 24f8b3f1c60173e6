/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups in the tables of reference/gloss.h. */
#ifndef MCVISI_HOST_REFERENCE_GLOSS_TABLES_H
#define MCVISI_HOST_REFERENCE_GLOSS_TABLES_H

#include <stdbool.h>

#include "device/multiple.h"
#include "mcvisi/materials/microfacet.h"
#include "reference/gloss.h"

/* The pair for a direction, interpolated; `roughness` is a share of the material's. */
void ref_albedos_at(const ref_albedos *albedos, ref_vec w, double roughness, double pair[2]);

/* The pair's mean over all directions. */
void ref_albedos_mean(const ref_albedos *albedos, double roughness, double pair[2]);

/* The words of a brushed metal's table for two directions; `roughness` as in ref_orders_at. */
void ref_brushed_at(const float *orders, const double alpha[2], double roughness, ref_vec o,
                    ref_vec i, double words[MCV_MULTIPLE_WORDS]);

/* The words of the entry for two directions, of a metal or of glass; `roughness` is the index of
 * the table, which may lie between two. */
void ref_orders_at(const float *orders, bool glass, double roughness, ref_vec o, ref_vec i,
                   double words[MCV_MULTIPLE_WORDS]);

#endif
