/* SPDX-License-Identifier: Apache-2.0 */
/* Normal numbers from uniform ones. */
#ifndef MCVISI_NORMAL_H
#define MCVISI_NORMAL_H

#include "mcvisi/elementary.h"
#include "mcvisi/sampling.h"

/* Two independent normal numbers (Box and Muller 1958). */
MCV_LOOP_FUNCTION void mcv_normal_pair(float xi, float eta, float normal[2]) {
    float sine, cosine;
    const float radius = mcv_sqrt(2.0f * mcv_log_1_plus(xi / (1.0f - xi)));
    mcv_sin_cos_turn(eta, &sine, &cosine);
    normal[0] = radius * cosine;
    normal[1] = radius * sine;
}

#endif
