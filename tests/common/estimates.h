/* SPDX-License-Identifier: Apache-2.0 */
/* Statistics of rendered images and of chosen directions against what they must be. */
#ifndef MCVISI_TESTS_ESTIMATES_H
#define MCVISI_TESTS_ESTIMATES_H

#include "scene_builder.h"

#include "analysis/compare.h"
#include "film/film.h"
#include "render/render.h"

enum { REPLICATES = 16 };

/* As mcv_render, with its bits; device and programs are kept. */
static inline mcv_result render_again(const mcv_scene *scene, uint32_t sensor,
                                      const mcv_render_options *options, mcv_film *film,
                                      mcv_render_stats *stats, mcv_error *error) {
    static mcv_renderer *renderer;
    if (!renderer) renderer = mcv_renderer_new();
    assert_non_null(renderer);
    return mcv_renderer_render(renderer, scene, sensor, options, film, stats, error);
}

/* Mean and variance of the mean over a film's replicates, of some of a replicate's values: pixels,
 * channel after channel. */
static inline mcv_estimate film_estimate(const mcv_film *film, size_t first, size_t count) {
    const size_t values = (size_t)film->width * film->height * film->channels;
    double means[MCV_MAX_REPLICATES];
    for (uint32_t r = 0; r < film->replicates; ++r) {
        means[r] = 0;
        for (size_t i = first; i < first + count; ++i) means[r] += film->sums[r * values + i];
        means[r] /= (double)film->samples * (double)count;
    }
    return mcv_estimate_replicates(means, film->replicates);
}

static inline mcv_estimate image_estimate(const mcv_film *film) {
    return film_estimate(film, 0, (size_t)film->width * film->height * film->channels);
}

/*
 * A mean over REPLICATES replicates must be `expected`, but for the share `bias` that roundings and
 * the closed form leave out. Student's t with 15 degrees of freedom: 6.1 standard errors happen
 * with probability 2e-5. The test is worth nothing where the standard error is large: the share
 * `largest_error` at most.
 */
static inline void expect_estimate(const char *what, mcv_estimate m, double expected,
                                   double largest_error, double bias) {
    const double error = sqrt(m.variance);
    print_message("%s: %.7g ± %.2g, expected %.7g\n", what, m.mean, error, expected);
    if (!(error <= largest_error * expected))
        fail_msg("%s: the standard error %g is above %g of %g", what, error, largest_error,
                 expected);
    if (!(fabs(m.mean - expected) <= 6.1 * error + bias * expected))
        fail_msg("%s: %.9g ± %.2g, expected %.9g", what, m.mean, error, expected);
}

/* Two pictures of one thing. */
static inline void expect_same_picture(const char *what, const mcv_film *x, const mcv_film *y) {
    mcv_comparison c;
    BUILD(mcv_compare_films(x, y, &c, &builder_error));
    print_message("%s: means %.6g and %.6g, %.2g %% would be seen; %s\n", what, c.mean_x, c.mean_y,
                  100 * c.detectable, c.reason);
    if (c.different) fail_msg("%s: %s", what, c.reason);
}

/* How many standard deviations of a normal distribution χ² of so many degrees of freedom is as rare
 * as (Wilson and Hilferty 1931). */
static inline double normal_of(double chi_squared, double freedom) {
    const double variance = 2 / (9 * freedom);
    return (cbrt(chi_squared / freedom) - (1 - variance)) / sqrt(variance);
}

/*
 * Pearson's χ² of choices counted in bins, against `scale` times the expected ones; bins in which
 * fewer than 25 are expected are joined with the next. 4.753 standard deviations happen with
 * probability 1e-6.
 */
static inline void expect_choices(const char *what, const char *who, const double *counted,
                                  const double *expected, double scale, int bins) {
    double chi_squared = 0, rest = 0, rest_expected = 0, freedom = -1;
    for (int bin = 0; bin < bins; ++bin) {
        rest += counted[bin];
        rest_expected += expected[bin] * scale;
        if (rest_expected < 25) continue;
        chi_squared += pow(rest - rest_expected, 2) / rest_expected;
        rest = rest_expected = 0;
        ++freedom;
    }
    print_message("%s, %s: χ² %.1f of %g degrees of freedom, %.2f standard deviations\n", what, who,
                  chi_squared, freedom, normal_of(chi_squared, freedom));
    if (!(normal_of(chi_squared, freedom) <= 4.753))
        fail_msg("%s, %s: χ² %.1f of %g degrees of freedom is too large", what, who, chi_squared,
                 freedom);
}

#endif
