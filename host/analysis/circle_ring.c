/* SPDX-License-Identifier: Apache-2.0 */
/* The pixels beside a circle: the levels of both sides, the spread between them, and their noise.
 */
#include "analysis/circle_finder.h"

#include <math.h>
#include <stdlib.h>

/* From the window's end outwards and inwards. */
static double plateau_width(const mcv_circle_finder *f) { return fmax(6, f->window); }

void mcv_circle_visit_ring(mcv_circle_finder *f, mcv_circle_visit *call, void *user) {
    const mcv_image *image = &f->readings->values;
    const mcv_pixel_box *box = &f->circle->box;
    const double reach = f->window + 0.75 + plateau_width(f);
    for (uint32_t y = box->y; y < box->y + box->height; ++y)
        for (uint32_t x = box->x; x < box->x + box->width; ++x) {
            const size_t i = (size_t)y * image->width + x;
            const double dx = x + 0.5 - f->at.centre[0], dy = y + 0.5 - f->at.centre[1],
                         d = mcv_length2(dx, dy) - f->at.radius;
            if (!(fabs(d) <= reach) || isnan(image->pixels[i]) ||
                !f->seen[mcv_circle_sector(f, dx, dy)])
                continue;
            call(f, i, d, user);
        }
}

static void add_level(mcv_circle_finder *f, size_t i, double d, void *user) {
    mcv_ring_sums *r = user;
    if (!mcv_circle_on_plateau(f, d)) return;
    ++r->count[d < 0];
    r->sum[d < 0] += f->readings->values.pixels[i];
}

/*
 * σ² = ∫ 2|x| |E(x) - step(x)| dx of the spread function E, and its mean deviation ∫ |E(x) -
 * step(x)| dx; a pixel at the radius r stands for 1/r of the circumference.
 */
static void add_moments(mcv_circle_finder *f, size_t i, double d, void *user) {
    mcv_ring_sums *r = user;
    if (fabs(d) > f->window) return;
    const double share =
                     (f->readings->values.pixels[i] - f->level[0]) / (f->level[1] - f->level[0]),
                 wrong = d < 0 ? 1 - share : share;
    r->density += 1 / (f->at.radius + d);
    r->deviation += wrong / (f->at.radius + d);
    r->moment += 2 * fabs(d) * wrong / (f->at.radius + d);
}

bool mcv_circle_find_levels(mcv_circle_finder *f, mcv_ring_sums *r) {
    *r = (mcv_ring_sums){0};
    mcv_circle_visit_ring(f, add_level, r);
    for (int i = 0; i < 2; ++i) f->level[i] = r->sum[i] / r->count[i];
    return fmin(r->count[0], r->count[1]) >= 8 && f->level[0] != f->level[1];
}

bool mcv_circle_find_spread(mcv_circle_finder *f, mcv_ring_sums *r) {
    r->density = r->deviation = r->moment = 0;
    mcv_circle_visit_ring(f, add_moments, r);
    f->spread2 = 2 * f->window * r->moment / r->density;
    return isfinite(f->spread2);
}

/* --- noise that is not known --- */

typedef struct sides {
    mcv_roi region[2];
} sides;

static void add_side(mcv_circle_finder *f, size_t i, double d, void *user) {
    mcv_roi *side = ((sides *)user)->region + (d < 0);
    if (!mcv_circle_on_plateau(f, d)) return;
    side->inside[i] = 1;
    ++side->count;
}

typedef struct mixture {
    mcv_readings *readings;
    double variance[2];
} mixture;

/* Between the plateaus the variance goes with the grey value, as that of light does. */
static void set_noise(mcv_circle_finder *f, size_t i, double d, void *user) {
    const mixture *m = user;
    const double share = fmin(
        1, fmax(0, (f->readings->values.pixels[i] - f->level[0]) / (f->level[1] - f->level[0])));
    const double used = mcv_circle_on_plateau(f, d) ? d < 0 : share;
    m->readings->deviation.pixels[i] =
        (float)sqrt((1 - used) * m->variance[0] + used * m->variance[1] +
                    mcv_readings_render_variance(m->readings, i));
}

mcv_result mcv_circle_estimate_noise(mcv_circle_finder *f, mcv_readings *readings, double least,
                                     double *freedom, mcv_error *error) {
    const mcv_image *image = &readings->values;
    const size_t plane = (size_t)image->width * image->height;
    uint8_t *inside = calloc(2 * plane, 1); /* of both sides */
    mixture m = {.readings = readings};
    sides s = {0};
    if (!inside) return mcv_circle_fail(f->circle, error, "no memory for its sides");
    for (int i = 0; i < 2; ++i)
        s.region[i] =
            (mcv_roi){.width = image->width, .height = image->height, .inside = inside + i * plane};
    mcv_circle_visit_ring(f, add_side, &s);
    for (int i = 0; i < 2; ++i)
        m.variance[i] =
            s.region[i].count ? pow(mcv_roi_estimate_noise(readings, s.region + i, least), 2) : NAN;
    free(inside);
    const uint64_t count[2] = {s.region[0].estimated, s.region[1].estimated};
    if (!(m.variance[0] >= 0 && m.variance[1] >= 0) || count[0] < 4 || count[1] < 4)
        return mcv_circle_fail(
            f->circle, error,
            "the box shows too little beside it to estimate the image's noise: give a larger "
            "box, or --noise");
    mcv_circle_visit_ring(f, set_noise, &m);
    *freedom = mcv_noise_freedom(m.variance, count);
    return MCV_OK;
}
