/* SPDX-License-Identifier: Apache-2.0 */
/* What a study looks like: pictures of a few sizes with and without the defect, and the set-up from
 * the side, for its page. */
#ifndef MCVISI_HOST_POD_PICTURES_H
#define MCVISI_HOST_POD_PICTURES_H

#include "experiment/experiment.h"

/*
 * *text becomes HTML, which the caller frees. Renders the sets of the smallest, the middle and the
 * largest defect, by its size, each with and without the rig's defects; rigs without MCVISI_defects
 * have the set-up alone. After failure nothing is owned.
 */
mcv_result mcv_pod_pictures(mcv_sweep *sweep, char **text, mcv_error *error);

#endif
