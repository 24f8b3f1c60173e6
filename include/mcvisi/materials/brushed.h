/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A brushed metal's table of multiple scattering: what leaves it after two and more reflections,
 * over one reflection of white microfacets, for pairs of directions (host/device/multiple_brushed.c
 * fills it).
 *
 * A direction w has the places p_x = w_x/(w_z + √(w_x² + w_z²)) and p_y = w_y/(1 + √(w_x² + w_z²)),
 * tangents of half its angles along the brushing and across; its mirror image has their opposites.
 * Of a pair the axes are the middles m = |p(o) - p(i)|/2, at equal steps of √(1 - m), then the
 * halves d = (p(o) + p(i))/2, from the mirror's 0 to ±(1 - m): d_x >= 0, d_y with the sign that
 * remains. With v = |d|/(1 - m), steps of d are equal in the mean of v (1 + k)/(v + k) and 1 - √(1
 * - v). The first follows the lobe of width α: k = WIDTH α (w_z of the mirror image at m)/(1 - m).
 */
#ifndef MCVISI_MATERIALS_BRUSHED_H
#define MCVISI_MATERIALS_BRUSHED_H

#include "mcvisi/materials/microfacet.h"

#define MCV_BRUSHED_MIDDLES 9
#define MCV_BRUSHED_HALVES 9 /* of d_x, and of d_y on either side */
#define MCV_BRUSHED_ENTRIES \
    (MCV_BRUSHED_MIDDLES * MCV_BRUSHED_MIDDLES * MCV_BRUSHED_HALVES * (2 * MCV_BRUSHED_HALVES - 1))
#define MCV_BRUSHED_WIDTH 1.0f
#define MCV_BRUSHED_LEAST 1e-3f /* added to w_z there */

/* Where the table is read: the first of 16 corners, and what is beyond it by axis. */
typedef struct mcv_brushed_place {
    uint first;
    float beyond[4];
} mcv_brushed_place;

/* The tangents of half a direction's angles, along the brushing and across. */
MCV_LOOP_FUNCTION float mcv_brushed_along(mcv_vec3 w) {
    const float sum = w.z + mcv_sqrt(mcv_fma(w.x, w.x, w.z * w.z));
    return sum > 0.0f ? w.x / sum : 0.0f;
}

MCV_LOOP_FUNCTION float mcv_brushed_across(mcv_vec3 w) {
    return w.y / (1.0f + mcv_sqrt(mcv_fma(w.x, w.x, w.z * w.z)));
}

/* The place of d on its axis, counted from the mirror image, where it is at most so much; width = k
 * times that. */
MCV_LOOP_FUNCTION float mcv_brushed_half(float d, float most, float width) {
    const float size = mcv_abs(d) < most ? mcv_abs(d) : most;
    const float v = most > 0.0f ? size / most : 1.0f;
    return 0.5f * (float)(MCV_BRUSHED_HALVES - 1) *
           (v * ((most + width) / (size + width)) + 1.0f - mcv_sqrt(1.0f - v));
}

/* w_z of the mirror image at m: the product of the cosines of twice the angles of these tangents.
 */
MCV_LOOP_FUNCTION float mcv_brushed_upright(float m_x, float m_y) {
    const float x = m_x * m_x;
    const float y = m_y * m_y;
    return (1.0f - x) * (1.0f - y) / ((1.0f + x) * (1.0f + y)) + MCV_BRUSHED_LEAST;
}

/* The corner below a place on an axis of so many entries, added to those of the axes before. */
MCV_LOOP_FUNCTION uint mcv_brushed_corner(uint before, float at, uint entries, float *beyond) {
    const uint corner = (uint)at < entries - 2u ? (uint)at : entries - 2u;
    *beyond = at - (float)corner;
    return before * entries + corner;
}

/* Both directions are given as if they lay above. */
MCV_LOOP_FUNCTION mcv_brushed_place mcv_find_brushed(mcv_alpha alpha, mcv_vec3 o, mcv_vec3 i) {
    const float o_x = mcv_brushed_along(o);
    const float o_y = mcv_brushed_across(o);
    const float i_x = mcv_brushed_along(i);
    const float i_y = mcv_brushed_across(i);
    const float m_x = 0.5f * mcv_abs(o_x - i_x);
    const float m_y = 0.5f * mcv_abs(o_y - i_y);
    const float d_x = 0.5f * (o_x + i_x);
    const float d_y = 0.5f * (o_y + i_y);
    const int turned = (o_x < i_x) ^ (o_y < i_y) ^ (d_x < 0.0f) ^ (d_y < 0.0f);
    const float width = MCV_BRUSHED_WIDTH * mcv_brushed_upright(m_x, m_y);
    const float left_x = m_x < 1.0f ? 1.0f - m_x : 0.0f;
    const float left_y = m_y < 1.0f ? 1.0f - m_y : 0.0f;
    const float middles = (float)(MCV_BRUSHED_MIDDLES - 1);
    const float half_x = mcv_brushed_half(d_x, left_x, alpha.x * width);
    const float half_y = mcv_brushed_half(d_y, left_y, alpha.y * width);
    mcv_brushed_place place;
    uint at = mcv_brushed_corner(0u, middles * (1.0f - mcv_sqrt(left_x)), MCV_BRUSHED_MIDDLES,
                                 &place.beyond[0]);
    at = mcv_brushed_corner(at, middles * (1.0f - mcv_sqrt(left_y)), MCV_BRUSHED_MIDDLES,
                            &place.beyond[1]);
    at = mcv_brushed_corner(at, half_x, MCV_BRUSHED_HALVES, &place.beyond[2]);
    at = mcv_brushed_corner(at, (float)(MCV_BRUSHED_HALVES - 1) + (turned ? -half_y : half_y),
                            2u * MCV_BRUSHED_HALVES - 1u, &place.beyond[3]);
    place.first = MCV_MULTIPLE_WORDS * at;
    return place;
}

typedef struct mcv_brushed_words {
    float word[MCV_MULTIPLE_WORDS];
} mcv_brushed_words;

/* The words there. */
MCV_LOOP_FUNCTION mcv_brushed_words mcv_brushed_at(MCV_GLOBAL const float *table,
                                                   mcv_brushed_place place) {
    const uint along = MCV_MULTIPLE_WORDS * (2u * MCV_BRUSHED_HALVES - 1u);
    const uint middle = along * MCV_BRUSHED_HALVES;
    mcv_brushed_words sum = {{0.0f, 0.0f, 0.0f, 0.0f}};
#if MCV_ON_DEVICE /* else the loop over paths is not vectorised */
#pragma unroll
#endif
    for (uint corner = 0; corner < 8; ++corner) {
        MCV_GLOBAL const float *at = table + place.first + (corner & 1 ? along : 0u) +
                                     (corner & 2 ? middle : 0u) +
                                     (corner & 4 ? middle * MCV_BRUSHED_MIDDLES : 0u);
        const float weight = (corner & 1 ? place.beyond[2] : 1.0f - place.beyond[2]) *
                             (corner & 2 ? place.beyond[1] : 1.0f - place.beyond[1]) *
                             (corner & 4 ? place.beyond[0] : 1.0f - place.beyond[0]);
        const float second = weight * place.beyond[3];
        const float first = weight - second;
#if MCV_ON_DEVICE
#pragma unroll
#endif
        for (uint k = 0; k < MCV_MULTIPLE_WORDS; ++k)
            sum.word[k] =
                mcv_fma(first, at[k], mcv_fma(second, at[MCV_MULTIPLE_WORDS + k], sum.word[k]));
    }
    return sum;
}

/* The words there of two tables of many. */
MCV_LOOP_FUNCTION mcv_brushed_words mcv_brushed_between(MCV_GLOBAL const float *tables, uint first,
                                                        float beyond, mcv_brushed_place place) {
    MCV_GLOBAL const float *table = tables + first * MCV_MULTIPLE_WORDS * MCV_BRUSHED_ENTRIES;
    mcv_brushed_words sum = mcv_brushed_at(table, place);
    const mcv_brushed_words next =
        mcv_brushed_at(table + MCV_MULTIPLE_WORDS * MCV_BRUSHED_ENTRIES, place);
    for (uint k = 0; k < MCV_MULTIPLE_WORDS; ++k)
        sum.word[k] = mcv_fma(beyond, next.word[k] - sum.word[k], sum.word[k]);
    return sum;
}

#endif
