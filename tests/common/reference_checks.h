/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of the reference renderer share: scenes beyond scene_builder.h, checks that print
 * error and bound, statistics. */
#ifndef MCVISI_TESTS_REFERENCE_CHECKS_H
#define MCVISI_TESTS_REFERENCE_CHECKS_H

#include "estimates.h"
#include "truths.h"

#include "reference/interface.h"
#include "reference/path.h"
#include "reference/reference.h"

/* Half the spacing of the floats below 1: what storing a coordinate or a normal in float32 may
 * change. */
#define FLOAT_ROUNDING 0x1p-25

/* Which renderer the checks below are about: "device" in tests of the device. */
static const char *checked = "reference";

/* Prints |value - expected| beside its bound and fails above it. */
static inline void check(const char *what, double value, double expected, double bound) {
    const double error = fabs(value - expected);
    print_message("  %-58s %.9g, error %.2g, bound %.2g\n", what, value, error, bound);
    note_truth(what, checked, error, bound);
    if (!(error <= bound))
        fail_msg("%s: %.17g instead of %.17g, off by %.3g > %.3g", what, value, expected, error,
                 bound);
}

/* The larger of two errors; NaN is the largest. */
static inline double worse(double a, double b) { return b > a || isnan(b) ? b : a; }

/* P(|T| >= t) of Student's distribution with a whole number of degrees of freedom (Abramowitz and
 * Stegun 26.7.3, 26.7.4). */
static inline double student_two_sided(double t, int freedom) {
    const double angle = atan(fabs(t) / sqrt(freedom));
    const double cosine = cos(angle);
    double term = freedom % 2 ? cosine : 1;
    double sum = freedom > 1 ? term : 0;
    for (int k = freedom % 2 ? 3 : 2; k < freedom; k += 2) {
        term *= cosine * cosine * (k - 1) / k;
        sum += term;
    }
    return 1 - (freedom % 2 ? 2 / M_PI * (angle + sin(angle) * sum) : sin(angle) * sum);
}

/* The t that is exceeded with probability p, to a thousandth of it. */
static inline double student_two_sided_quantile(double p, int freedom) {
    double t = 1;
    while (student_two_sided(t, freedom) > p) t *= 1.001;
    return t;
}

/* Rendered with fixed seeds, each check has one outcome; a right renderer would miss this for one
 * seed of a thousand. */
#define LEVEL 1e-3

/* Tests a mean of REPLICATES replicates against the truth, which is itself known within `slack`. */
static inline void check_mean(const char *what, mcv_estimate estimate, double truth, double slack) {
    const double error = sqrt(estimate.variance);
    const double distance = fmax(fabs(estimate.mean - truth) - slack, 0);
    const double p = student_two_sided(distance / error, (int)estimate.freedom);
    print_message("  %-58s %.7g, truth %.7g, off %.2g of it, SE %.2g of it, p %.3f\n", what,
                  estimate.mean, truth, fabs(estimate.mean / truth - 1), error / truth, p);
    note_truth(what, checked, fabs(estimate.mean - truth),
               slack + student_two_sided_quantile(LEVEL, (int)estimate.freedom) * error);
    if (!(p >= LEVEL))
        fail_msg("%s: %.9g instead of %.9g, standard error %.3g, p = %.2g", what, estimate.mean,
                 truth, error, p);
}

static inline mcv_render_options options_of(uint32_t samples, uint32_t depth) {
    return (mcv_render_options){
        .replicates = REPLICATES, .seed = 1, .depth = depth, .last = samples};
}

static inline mcv_film render_with(const mcv_scene *scene, const mcv_render_options *options,
                                   bool sample_emitters, mcv_render_stats *stats) {
    mcv_film film;
    if (ref_render(scene, 0, options, sample_emitters, &film, stats, &builder_error) != MCV_OK)
        fail_msg("%s", builder_error.text);
    assert_int_equal(stats->nonfinite, 0);
    return film;
}

/* The image mean. */
static inline mcv_estimate render_mean(const mcv_scene *scene, uint32_t samples, uint32_t depth,
                                       bool sample_emitters, mcv_render_stats *stats) {
    const mcv_render_options options = options_of(samples, depth);
    mcv_film film = render_with(scene, &options, sample_emitters, stats);
    const mcv_estimate estimate = film_estimate(&film, 0, (size_t)film.width * film.height);
    mcv_film_free(&film);
    return estimate;
}

/* The image mean on the device. */
static inline mcv_estimate device_mean(const mcv_scene *scene, uint32_t samples, uint32_t depth,
                                       mcv_render_stats *stats) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = samples;
    options.depth = depth;
    options.seed = 1;
    BUILD(mcv_render(scene, 0, &options, &film, stats, &builder_error));
    assert_int_equal(stats->nonfinite, 0);
    const mcv_estimate estimate = film_estimate(&film, 0, (size_t)film.width * film.height);
    mcv_film_free(&film);
    return estimate;
}

/* check_mean of the device. Each path's value rounds a few times in float32. */
static inline void check_device_mean(const char *what, const mcv_scene *scene, uint32_t samples,
                                     uint32_t depth, double truth, double slack) {
    mcv_render_stats stats;
    const char *before = checked;
    checked = "device";
    check_mean(what, device_mean(scene, samples, depth, &stats), truth, slack + 0x1p-20 * truth);
    checked = before;
}

/* A mesh of the scene turned inside out, without normals (so flat), as a new instance. */
static inline uint32_t add_inside_out(mcv_scene *scene, const mcv_mesh *mesh, uint32_t material) {
    mcv_mesh turned = *mesh;
    turned.normals = NULL;
    turned.indices = malloc(12 * (size_t)mesh->triangle_count);
    assert_non_null(turned.indices);
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (uint32_t k = 0; k < 3; ++k) turned.indices[3 * t + k] = mesh->indices[3 * t + 2 - k];
    const uint32_t instance = add_instance(scene, &turned, material, mcv_transform_identity());
    free(turned.indices);
    return instance;
}

/* A pinhole camera of one pixel of half-angle `spread` at `at`, looking at `to`. */
static inline void add_spot_camera(mcv_scene *scene, const double at[3], const double to[3],
                                   double spread) {
    const ref_vec forward = ref_unit(ref_sub(ref_from(to), ref_from(at)));
    ref_vec right, up;
    ref_frame(forward, &right, &up);
    add_pinhole(scene, 1, 2 * spread,
                looking(at, (const double[3]){forward.x, forward.y, forward.z},
                        (const double[3]){up.x, up.y, up.z}));
}

/* Vertices of a few rays; the caller frees them. */
static inline mcv_vertex *trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                                uint32_t depth, size_t *count) {
    const mcv_render_options options = {.depth = depth};
    mcv_vertex *vertices;
    if (mcv_reference_trace(scene, rays, ray_count, &options, &vertices, count, &builder_error) !=
        MCV_OK)
        fail_msg("%s", builder_error.text);
    return vertices;
}

#endif
