/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi compare` does. */
#ifndef MCVISI_HOST_VERBS_COMPARE_H
#define MCVISI_HOST_VERBS_COMPARE_H

#include "analysis/compare.h"
#include "io/exr.h"
#include "verbs/report.h"

/* One of the two. */
typedef struct mcv_compared {
    const char *path; /* for messages */
    mcv_measured measured;
    mcv_film film; /* of a picture: the replicates' means, as of one sample each; empty where it has
                      none */
    char quantity[64], unit[64], sampler[64], sampling[64], device[256];
    double seed, light_paths; /* NaN: not told */
} mcv_compared;

/* Of a picture, which must outlive it; the film is freed by the caller, after failure, too. */
mcv_result mcv_compared_read(const mcv_exr *exr, const char *path, mcv_compared *r,
                             mcv_error *error);

/* Are all replicates of both known? Then rank tests are used. */
bool mcv_compared_by_ranks(const mcv_compared *a, const mcv_compared *b);

mcv_result mcv_compare(const mcv_compared *a, const mcv_compared *b, mcv_comparison *comparison,
                       mcv_error *error);

/* Draws A - B in units of its standard error. */
mcv_result mcv_compare_draw(const char *path, const mcv_compared *a, const mcv_compared *b,
                            bool different, mcv_error *error);

/* Warns where both have the same noise, tells where they are identical, and of the comparison. */
void mcv_compare_report(const mcv_compared *a, const mcv_compared *b,
                        const mcv_comparison *comparison, mcv_report *report);

#endif
