/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/rate.h"

#include "analysis/statistics.h"
#include "statistics/distributions.h"

#include <math.h>

mcv_interval mcv_wilson(double successes, double trials, double confidence) {
    if (!(trials > 0)) return (mcv_interval){0, 1};
    const double z = mcv_normal_quantile(0.5 + 0.5 * confidence);
    const double n = trials, p = successes / n, more = z * z / n;
    const double middle = (p + 0.5 * more) / (1 + more);
    const double half = z / (1 + more) * sqrt(p * (1 - p) / n + 0.25 * more / n);
    /* Exact at the ends, where rounding would leave a little. */
    return (mcv_interval){successes == 0 ? 0 : middle - half,
                          successes == trials ? 1 : middle + half};
}

double mcv_clopper_pearson_low(uint64_t successes, uint64_t trials, double confidence) {
    double low = 0, high = 1;
    if (successes == 0) return 0;
    for (int i = 0; i < 60; ++i) { /* down to the last bit */
        const double middle = 0.5 * (low + high);
        if (mcv_binomial_upper(successes, trials, middle) < 1 - confidence) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
