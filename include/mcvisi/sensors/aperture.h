/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Apertures that are no full disc, of thin lens and telecentric cameras. Points of the pupil are in
 * its radii: x right, y up, as the camera looks.
 *
 *   ring     from apertureRatio on
 *   half     the side of the direction apertureRotation, from x towards y
 *   blades   a regular polygon of apertureBlades corners on the rim, the first at apertureRotation
 *   coded    a modified uniformly redundant array of the prime order p in the inscribed square:
 * cell (i, j) is open if j = 0 and i > 0, or if i and j are both quadratic residues mod p, or both
 * none (S. R. Gottesman and E. E. Fenimore, Appl. Opt. 28, 4344, 1989)
 *   mask     K x K cells of the square about the disc pass what apertureMask says
 *
 * Rays are sampled where the aperture is open. With "radiance" a pixel is the mean over the open
 * area; with "irradiance" the open area counts, so that a smaller one darkens the image. The
 * f-number is that of the full disc.
 */
#ifndef MCVISI_SENSORS_APERTURE_H
#define MCVISI_SENSORS_APERTURE_H

#include "mcvisi/sensors/sensor.h"

typedef struct mcv_aperture {
    uint shape;        /* MCV_APERTURE_… */
    uint count;        /* blades, or cells of a side */
    float inner;       /* ring: the square of its inner radius */
    float x, y, turns; /* rotation: its direction, and in turns */
    float extent;      /* cells: half the side of their square */
    float open;        /* share of the disc that is open */
    float weight; /* of a ray through an open place: 1, of irradiance the share; of a mask over the
                     share of its cells' light that lies in the disc */
    float share[MCV_MASK_SIDE * MCV_MASK_SIDE + 1]; /* cells: of the light that passes those before,
                                                       row by row from the upper left one */
} mcv_aperture;
MCV_ASSERT_SIZE(mcv_aperture, 4136);

#if !MCV_ON_DEVICE || MCV_WITH_APERTURE

MCV_FUNCTION mcv_pupil_sample mcv_sample_cells(MCV_CONSTANT const mcv_aperture *a, float xi,
                                               float eta) {
    mcv_pupil_sample to;
    uint low = 0u, high = a->count * a->count;
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (a->share[middle] <= xi)
            low = middle;
        else
            high = middle;
    }
    const float within = (xi - a->share[low]) / (a->share[high] - a->share[low]);
    const float cell = 2.0f * a->extent / (float)a->count;
    const uint column = low % a->count, row = low / a->count;
    to.x = mcv_fma(cell, (float)column + within, -a->extent);
    to.y = mcv_fma(-cell, (float)row + eta, a->extent);
    to.weight = mcv_fma(to.x, to.x, to.y * to.y) <= 1.0f ? a->weight : 0.0f;
    return to;
}

/* A place where the aperture is open. */
MCV_FUNCTION mcv_pupil_sample mcv_sample_aperture(MCV_CONSTANT const mcv_aperture *a, float xi,
                                                  float eta) {
    mcv_pupil_sample to;
    float cosine, sine;
    if (a->shape >= MCV_APERTURE_CODED) return mcv_sample_cells(a, xi, eta);
    if (a->shape == MCV_APERTURE_BLADES) {
        /* One of the triangles about the middle, and a place of it. */
        const uint blade = mcv_cell(xi, a->count);
        const float n = (float)a->count;
        const float r = mcv_sqrt(mcv_fma(xi, n, -(float)blade));
        float other_cosine, other_sine;
        mcv_sin_cos_turn(a->turns + (float)blade / n, &sine, &cosine);
        mcv_sin_cos_turn(a->turns + ((float)blade + 1.0f) / n, &other_sine, &other_cosine);
        to.x = r * mcv_fma(eta, other_cosine - cosine, cosine);
        to.y = r * mcv_fma(eta, other_sine - sine, sine);
    } else {
        float r = mcv_disk(xi, eta, &cosine, &sine);
        if (a->shape == MCV_APERTURE_RING) {
            const float wide = mcv_sqrt(mcv_fma(1.0f - a->inner, r * r, a->inner));
            r = r < 0.0f ? -wide : wide;
        }
        to.x = r * cosine;
        to.y = r * sine;
        if (a->shape == MCV_APERTURE_HALF && mcv_fma(to.x, a->x, to.y * a->y) < 0.0f) {
            to.x = -to.x;
            to.y = -to.y;
        }
    }
    to.weight = a->weight;
    return to;
}

/* The weight of a ray through a place of the disc, of places that are uniform on it. */
MCV_FUNCTION float mcv_aperture_weight(MCV_CONSTANT const mcv_aperture *a, float p_x, float p_y) {
    const float squared = mcv_fma(p_x, p_x, p_y * p_y);
    float passed = 1.0f;
    if (a->shape == MCV_APERTURE_RING) passed = squared >= a->inner ? 1.0f : 0.0f;
    if (a->shape == MCV_APERTURE_HALF)
        passed = mcv_fma(p_x, a->x, p_y * a->y) >= 0.0f ? 1.0f : 0.0f;
    if (a->shape == MCV_APERTURE_BLADES) {
        const float n = (float)a->count;
        float cosine, sine;
        mcv_sin_cos_turn(0.5f / n, &sine, &cosine);
        const float apothem = cosine;
        for (uint blade = 0u; blade < a->count; ++blade) {
            mcv_sin_cos_turn(a->turns + ((float)blade + 0.5f) / n, &sine, &cosine);
            if (mcv_fma(p_x, cosine, p_y * sine) > apothem) passed = 0.0f;
        }
    }
    if (a->shape >= MCV_APERTURE_CODED) {
        const float side = (float)a->count;
        const float column = mcv_fma(p_x / a->extent, 0.5f, 0.5f) * side;
        const float row = mcv_fma(-p_y / a->extent, 0.5f, 0.5f) * side;
        if (!(column >= 0.0f && column < side && row >= 0.0f && row < side)) return 0.0f;
        const uint cell = (uint)row * a->count + (uint)column;
        /* A cell's share of the light over its share of the disc. */
        passed = (a->share[cell + 1u] - a->share[cell]) * a->open * MCV_PI * side * side /
                 (4.0f * a->extent * a->extent);
    }
    return passed / a->open * a->weight;
}
#endif

#endif
