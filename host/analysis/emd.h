/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The Earth Mover's Distance of two histograms of J x K bins: the least cost of moving one onto the
 * other, exactly. Moving a unit of mass by (Δj, Δk) bins costs c = √((Δj/J)² + (Δk/K)²), a fraction
 * of the pupil. There are two forms for histograms of different masses:
 *
 *     normalized  Each histogram has mass 1. Two empty ones have the distance 0, one empty one
 *                 max(c). It shows the distribution of light, not its amount.
 *     mass        The smaller mass is moved at the least cost; the rest costs ½ max(c) per unit.
 *                 It shows absorption too.
 *
 * Y. Rubner, C. Tomasi, L. J. Guibas, The Earth Mover's Distance as a Metric for Image Retrieval,
 * IJCV 40 (2000); the penalty: O. Pele, M. Werman, A Linear Time Histogram Metric for Improved SIFT
 * Matching, ECCV 2008.
 *
 * First min(P, Q) is subtracted from both histograms: with a metric this mass never has to move.
 * The network simplex method solves the rest. Amounts are 52-bit integers, so no mass is lost and
 * degenerate pivots cannot cycle.
 */
#ifndef MCVISI_HOST_ANALYSIS_EMD_H
#define MCVISI_HOST_ANALYSIS_EMD_H

#include "core/error.h"

/* Largest J K: with more, a single pair would take seconds. */
enum { MCV_EMD_MAX_BINS = 1024 };

typedef enum mcv_emd_form { MCV_EMD_NORMALIZED, MCV_EMD_MASS } mcv_emd_form;

/* Memory for pairs of J x K histograms; one for each thread. */
typedef struct mcv_emd mcv_emd;

/* MCV_BAD_INPUT for a J or K of 0 or too many bins. */
mcv_result mcv_emd_new(mcv_emd **emd, uint32_t columns, uint32_t rows, mcv_error *error);
void mcv_emd_free(mcv_emd *emd);

/* The largest cost: that of a diagonal. */
double mcv_emd_max_cost(const mcv_emd *emd);

/*
 * The distance of p and q, both [row][column], finite and not below 0.
 *
 * potential (J K values, or NULL) gets a proof that no plan is cheaper (Kantorovich's dual). It
 * changes by at most c between any two bins, and Σ f (Q - P) - (ΣQ - ΣP) (max f if ΣQ > ΣP, else
 * min f) is the cost of moving. No such f gives more than the least cost; this one gives the cost
 * of the plan, up to rounding: 1e-9 of the distance, asserted in debug builds.
 */
double mcv_emd_distance(mcv_emd *emd, const double *p, const double *q, mcv_emd_form form,
                        double *potential);

#endif
