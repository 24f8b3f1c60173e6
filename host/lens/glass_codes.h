/* SPDX-License-Identifier: Apache-2.0 */
/* Glasses by n_d and V_d, for lens files whose glass has no dispersion formula in the renderer's
 * catalogue. */
#ifndef MCVISI_HOST_LENS_GLASS_CODES_H
#define MCVISI_HOST_LENS_GLASS_CODES_H

#include <stddef.h>

typedef struct mcv_glass_code {
    const char *name;
    double index, abbe; /* n_d, V_d */
} mcv_glass_code;

/* Ends with a NULL name. */
extern const mcv_glass_code mcv_glass_codes[];

#endif
