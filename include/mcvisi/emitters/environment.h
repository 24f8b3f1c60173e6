/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Constant environment (type "environment"): the same radiance from everywhere behind the scene, met by rays that leave it.
 * At most one per scene; its node's place has no meaning.
 *
 *     {"type": "environment", "radiance": 0.1}
 */
#ifndef MCVISI_EMITTERS_ENVIRONMENT_H
#define MCVISI_EMITTERS_ENVIRONMENT_H

#include "mcvisi/emitters/emitter.h"

#define MCV_ENVIRONMENT_PARAMS(X) X(spectrum, radiance, 1, 0, 1e30, "radiance L [W/(m² sr)]")

#endif
