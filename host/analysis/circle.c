/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/circle_finder.h"

#include <math.h>
#include <stdlib.h>

mcv_result mcv_circle_parse(const char *text, size_t number, const mcv_image *image, bool whole,
                            mcv_circle *circle, mcv_error *error) {
    size_t count;
    *circle = (mcv_circle){.whole = whole};
    return mcv_boxes_parse(whole ? "circle" : "arc", text, number, image, 1, circle->name,
                           &circle->box, &count, error);
}

mcv_result mcv_circle_fail(const mcv_circle *circle, mcv_error *error, const char *why) {
    return mcv_fail(error, MCV_FAILED, "%s %s: %s", circle->whole ? "circle" : "arc", circle->name,
                    why);
}

double mcv_circle_widest_window(double radius) { return (1 - M_SQRT1_2) * radius; }

/* Plateaus, spread and window, scans and their circle, in turns. */
static mcv_result refine(mcv_circle_finder *f, int rounds, mcv_ring_sums *ring, double *sizes,
                         mcv_error *error) {
    const mcv_circle *c = f->circle;
    for (int round = 0; round < rounds; ++round) {
        const double widest = mcv_circle_widest_window(f->at.radius);
        if (!mcv_circle_find_levels(f, ring) || !mcv_circle_find_spread(f, ring))
            return mcv_circle_fail(c, error,
                                   "the box holds too little of one side: make it larger");
        /* 3 σ and a pixel. Noise moves the mean deviation less than σ²: a window that goes with the
         * noise would go with the radius. */
        const double deviation = 2 * f->window * ring->deviation / ring->density;
        f->window = fmin(0.5 * ceil(2 * (3 * sqrt(M_PI / 2) * fmax(deviation, 0.25) + 1)), widest);
        if (2 * sqrt(mcv_circle_spread2(f)) + 1 > widest)
            return mcv_fail(error, MCV_FAILED,
                            "%s %s: its radius of %.1f pixels is too small for an edge that is "
                            "blurred by %.1f pixels: %.0f are needed",
                            c->whole ? "circle" : "arc", c->name, f->at.radius,
                            sqrt(mcv_circle_spread2(f)),
                            (2 * sqrt(mcv_circle_spread2(f)) + 1) / mcv_circle_widest_window(1));
        if (!mcv_circle_find_levels(f, ring) || !mcv_circle_find_spread(f, ring))
            return mcv_circle_fail(c, error,
                                   "the box holds too little of one side: make it larger");
        mcv_circle_make_scans(f);
        if (!mcv_circle_judge_scans(f, sizes) || !mcv_circle_solve(f, true))
            return mcv_circle_fail(
                c, error,
                c->whole ? "the box shows too little of a circle and of both its sides: give a box "
                           "around it"
                         : "the box shows too little of an arc and of both its sides");
    }
    return MCV_OK;
}

static mcv_result finish(mcv_circle_finder *f, const mcv_ring_sums *ring, double freedom,
                         mcv_error *error) {
    mcv_circle *c = f->circle;
    if (!mcv_circle_solve(f, false) || !mcv_circle_find_covariance(f, ring, c->covariance))
        return mcv_circle_fail(c, error, "no memory for its uncertainty");
    const mcv_scatter scatter = mcv_circle_scatter(f);
    const double clearly = scatter.noise + 3 * sqrt(scatter.variance);
    const double wide = mcv_widening(freedom) *
                        (scatter.squares > clearly ? sqrt(scatter.squares / scatter.noise) : 1);
    double used = 0;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) c->covariance[j][k] *= wide * wide;
    for (size_t i = 0; i < f->scan_count; ++i) used += f->scans[i].used;
    c->bright = f->level[1] > f->level[0];
    c->column = (mcv_quantity){f->at.centre[0], sqrt(c->covariance[0][0])};
    c->row = (mcv_quantity){f->at.centre[1], sqrt(c->covariance[1][1])};
    c->radius = (mcv_quantity){f->at.radius, sqrt(c->covariance[2][2])};
    c->diameter = (mcv_quantity){2 * c->radius.value, 2 * c->radius.uncertainty};
    c->roundness = mcv_form_deviation(&scatter, freedom);
    c->seen = fmin(1, scatter.count / (2 * M_PI * f->at.radius));
    c->rejected = 1 - used / (double)f->scan_count;
    c->spread = sqrt(mcv_circle_spread2(f));
    if (c->whole && c->seen < 0.5)
        return mcv_fail(
            error, MCV_FAILED,
            "circle %s: the box shows both sides of only %.0f %% of it: give a larger box around "
            "it, or measure a part by --arc",
            c->name, 100 * c->seen);
    if (!(c->radius.uncertainty <= 0.1 * c->radius.value))
        return mcv_fail(
            error, MCV_FAILED,
            "%s %s is too short to determine its radius, %.3g ± %.2g pixels: give a box with "
            "more of it, or measure it by --edge",
            c->whole ? "circle" : "arc", c->name, c->radius.value, c->radius.uncertainty);
    return MCV_OK;
}

static mcv_result locate(mcv_circle_finder *f, mcv_readings *readings, double least,
                         mcv_error *error) {
    enum { ROUNDS = 6 };
    const mcv_pixel_box *box = &f->circle->box;
    double bright = 0, freedom = INFINITY,
           *sizes = malloc(4 * ((size_t)box->width + box->height) * sizeof *sizes);
    mcv_ring_sums ring = {0};
    f->scans = malloc(4 * ((size_t)box->width + box->height) * sizeof *f->scans);
    mcv_result result = MCV_FAILED;
    if (!sizes || !f->scans)
        (void)mcv_circle_fail(f->circle, error, "no memory for it");
    else
        result = mcv_circle_find_guess(&readings->values, f->circle, &f->at, &bright, error);
    if (result == MCV_OK) {
        const double sectors = 0.5 * f->at.radius; /* each of them of 9 to 18 pixels */
        f->sectors = sectors < 8                    ? 8
                     : sectors > MCV_CIRCLE_SECTORS ? MCV_CIRCLE_SECTORS
                                                    : (int)sectors;
        f->window = fmin(5, mcv_circle_widest_window(f->at.radius));
        for (int k = 0; k < f->sectors; ++k) f->seen[k] = true;
        result = refine(f, ROUNDS, &ring, sizes, error);
    }
    if (result == MCV_OK && !isnan(least))
        result = mcv_circle_estimate_noise(f, readings, least, &freedom, error);
    if (result == MCV_OK && !isnan(least)) result = refine(f, 2, &ring, sizes, error);
    if (result == MCV_OK) result = finish(f, &ring, freedom, error);
    free(sizes);
    free(f->scans);
    return result;
}

mcv_result mcv_circle_locate(mcv_readings *readings, double least, mcv_circle *circle,
                             mcv_error *error) {
    mcv_circle_finder f = {.circle = circle, .readings = readings};
    return locate(&f, readings, least, error);
}

/* --- distances --- */

/* nᵀ C n of the centre. */
static double centre_variance(const mcv_circle *c, double x, double y) {
    return x * x * c->covariance[0][0] + 2 * x * y * c->covariance[0][1] +
           y * y * c->covariance[1][1];
}

mcv_quantity mcv_circle_distance(const mcv_circle *a, const mcv_circle *b) {
    const double dx = b->column.value - a->column.value, dy = b->row.value - a->row.value,
                 d = hypot(dx, dy), x = dx / d, y = dy / d;
    const double along = centre_variance(a, x, y) + centre_variance(b, x, y),
                 across = centre_variance(a, -y, x) + centre_variance(b, -y, x);
    if (d == 0)
        return (mcv_quantity){0, sqrt(a->covariance[0][0] + b->covariance[0][0] +
                                      a->covariance[1][1] + b->covariance[1][1])};
    /* Noise at right angles lengthens it; what that leaves uncertain is second order, as for the
     * modulation of an edge. */
    return (mcv_quantity){fmax(0, d - across / (2 * d)), sqrt(along + 2 * across / d * across / d)};
}

mcv_quantity mcv_edge_to_circle(const mcv_edge *line, const mcv_circle *circle) {
    const double *n = line->normal, x = circle->column.value - line->point[0],
                 y = circle->row.value - line->point[1];
    const double along = y * n[0] - x * n[1],
                 place = line->position.uncertainty * cos(line->tilt.value);
    return (mcv_quantity){x * n[0] + y * n[1],
                          sqrt(place * place + pow(along * line->tilt.uncertainty, 2) +
                               centre_variance(circle, n[0], n[1]))};
}
