/* SPDX-License-Identifier: Apache-2.0 */
/* A glossy surface at a place, and what its tables say: the albedos of microfacets, and what leaves
 * them after two and more meetings. Directions are as in bsdf/microfacet.h. */
#ifndef MCVISI_KERNELS_MICROFACET_TABLES_H
#define MCVISI_KERNELS_MICROFACET_TABLES_H

#include "mcvisi/materials/brushed.h"
#include "mcvisi/materials/microfacet.h"
#include "world.h"

/* A glossy surface at a place. */
typedef struct mcv_microfacets {
    uint type; /* MCV_MATERIAL_… */
    mcv_alpha alpha;
    mcv_color
        base; /* metallic-roughness: base colour; conductor: what multiple reflection leaves */
    float metallic;
    float layer;                  /* place among the table's roughnesses */
    uint table;                   /* in the albedos */
    uint inside;                  /* dielectric: 1: the ray is in the body */
    mcv_device_interface between; /* dielectric: from the ray's side to the other; conductor: eta is
                                     1/n of the medium before it */
} mcv_microfacets;

typedef struct mcv_albedo {
    float a, b;
} mcv_albedo;

/* Rows of azimuth and cosine for one roughness. */
MCV_LOOP_FUNCTION mcv_albedo mcv_albedo_row(__global const float *rows, uint azimuths, mcv_vec3 w) {
    const float x = mcv_sqrt(mcv_abs(w.z)) * (float)(MCV_ALBEDO_COSINES - 1);
    const uint column = min((uint)x, (uint)(MCV_ALBEDO_COSINES - 2));
    const float f = x - (float)column;
    const float sum = mcv_abs(w.x) + mcv_abs(w.y);
    const float y = (sum > 0.0f ? mcv_abs(w.x) / sum : 0.0f) * (float)(azimuths - 1);
    const uint row = min((uint)y, azimuths - 2); /* of the only one, 0 */
    const float g = y - (float)row;
    mcv_albedo albedo = {0.0f, 0.0f};
#pragma unroll
    for (uint k = 0; k < (MCV_WITH_ANISOTROPY ? 4u : 2u); ++k) {
        const float weight = (k & 1 ? f : 1.0f - f) * (k & 2 ? g : 1.0f - g);
        __global const float *entry =
            rows +
            2 * ((row + (azimuths > 1 ? k >> 1 : 0u)) * MCV_ALBEDO_COSINES + column + (k & 1));
        albedo.a = mcv_fma(weight, entry[0], albedo.a);
        albedo.b = mcv_fma(weight, entry[1], albedo.b);
    }
    return albedo;
}

/* The table's entries for a direction, or with `mean` their means over the hemisphere. */
MCV_LOOP_FUNCTION mcv_albedo mcv_albedo_at(const mcv_device_glossy *m,
                                           const mcv_microfacets *microfacets,
                                           __global const float *albedos, mcv_vec3 w, int mean) {
    const uint size = 2 + 2 * m->azimuths * MCV_ALBEDO_COSINES;
    const uint layer = m->roughnesses > 1 ? min((uint)microfacets->layer, m->roughnesses - 2) : 0;
    const float f = microfacets->layer - (float)layer;
    __global const float *at =
        albedos + (microfacets->table == MCV_NONE ? 0u : microfacets->table) + layer * size;
    mcv_albedo low, high;
    low.a = at[0];
    low.b = at[1];
    if (!mean) low = mcv_albedo_row(at + 2, m->azimuths, w);
    if (!MCV_WITH_TEXTURE) return low;
    const uint next = m->roughnesses > 1 ? size : 0u;
    high.a = at[next];
    high.b = at[next + 1];
    if (!mean) high = mcv_albedo_row(at + next + 2, m->azimuths, w);
    low.a = mcv_fma(f, high.a - low.a, low.a);
    low.b = mcv_fma(f, high.b - low.b, low.b);
    return low;
}

/* The row of a table of multiple scattering for a cosine, with how far it is to the next. */
MCV_LOOP_FUNCTION float mcv_multiple_row(float z, uint cosines) {
    const float c = mcv_abs(z) < 1.0f ? mcv_abs(z) : 1.0f;
    const float root = mcv_sqrt(c);
    return root / (root + mcv_sqrt(1.0f - c)) * (float)(cosines - 1);
}

/* Where a table of multiple scattering is read: entries of azimuths, and what each of three corners
 * counts. */
typedef struct mcv_multiple_place {
    uint first, edge,
        across; /* the near corner, words from it to the one beyond an edge and to the far one */
    float near, middle, far;
    float turn; /* to the next azimuth */
} mcv_multiple_place;

/*
 * In rows and columns by the triangles that the diagonal divides a cell into: light that comes and
 * leaves at like angles is special. Both directions are given as if they lay above. glass: the
 * table is an interface's.
 */
MCV_LOOP_FUNCTION mcv_multiple_place mcv_find_multiple(int glass, mcv_vec3 o, mcv_vec3 i) {
    const uint cosines = glass ? MCV_INTERFACE_COSINES : MCV_MULTIPLE_COSINES;
    const uint azimuths = glass ? MCV_INTERFACE_AZIMUTHS : MCV_MULTIPLE_AZIMUTHS;
    const float x = mcv_multiple_row(o.z, cosines);
    const float y = mcv_multiple_row(i.z, cosines);
    const float o_sine = mcv_sqrt(mcv_fma(o.x, o.x, o.y * o.y));
    const float i_sine = mcv_sqrt(mcv_fma(i.x, i.x, i.y * i.y));
    const float o_scale = o_sine > 0.0f ? 0.5f / o_sine : 0.0f;
    const float i_scale = i_sine > 0.0f ? 0.5f / i_sine : 0.0f;
    const float across = mcv_fma(o.x, o_scale, i.x * i_scale);
    const float up = mcv_fma(o.y, o_scale, i.y * i_scale);
    const float length = mcv_sqrt(mcv_fma(across, across, up * up)); /* |cos φ/2|, to a rounding */
    const float half_turn = length < 1.0f ? length : 1.0f;
    const float sum = o.z + i.z + MCV_MULTIPLE_LEAST;
    float turn = half_turn * (1.0f + sum) / (half_turn + sum);
    if (glass) {
        const float x_apart = mcv_fma(o.x, o_scale, -(i.x * i_scale));
        const float y_apart = mcv_fma(o.y, o_scale, -(i.y * i_scale));
        const float apart = mcv_sqrt(mcv_fma(x_apart, x_apart, y_apart * y_apart));
        turn = mcv_interface_turn(half_turn, apart < 1.0f ? apart : 1.0f, sum);
    }
    const float z = turn * (float)(azimuths - 1);
    const uint row = min((uint)x, cosines - 2);
    const uint column = min((uint)y, cosines - 2);
    const uint entry = min((uint)z, azimuths - 2);
    const float f = x - (float)row;
    const float g = y - (float)column;
    const float both = f < g ? f : g;
    const float either = f < g ? g : f;
    const uint step = MCV_MULTIPLE_WORDS * azimuths;
    mcv_multiple_place place;
    place.first = MCV_MULTIPLE_WORDS * ((row * cosines + column) * azimuths + entry);
    place.edge = step * (f > g ? cosines : 1u);
    place.across = step * (cosines + 1u);
    place.near = 1.0f - either;
    place.middle = either - both;
    place.far = both;
    place.turn = z - (float)entry;
    return place;
}

/* A word there. */
MCV_LOOP_FUNCTION float mcv_multiple_word(__global const float *table, mcv_multiple_place place) {
    __global const float *at = table + place.first;
    const float near = mcv_fma(place.turn, at[MCV_MULTIPLE_WORDS] - at[0], at[0]);
    at += place.edge;
    const float middle = mcv_fma(place.turn, at[MCV_MULTIPLE_WORDS] - at[0], at[0]);
    at += place.across - place.edge;
    const float far = mcv_fma(place.turn, at[MCV_MULTIPLE_WORDS] - at[0], at[0]);
    return mcv_fma(place.far, far, mcv_fma(place.middle, middle, place.near * near));
}

/* The table of the roughness below, and how far it is to the next. */
MCV_LOOP_FUNCTION uint mcv_multiple_layer(float layer, float *beyond) {
    const float at =
        layer * ((float)(MCV_MULTIPLE_ROUGHNESSES - 1) / (float)(MCV_ALBEDO_ROUGHNESSES - 1));
    const uint low = min((uint)at, (uint)(MCV_MULTIPLE_ROUGHNESSES - 2));
    *beyond = at - (float)low;
    return low;
}

/* A word of a metal at its roughness. */
MCV_LOOP_FUNCTION float mcv_metal_word(const mcv_device_glossy *m, float layer,
                                       __global const float *table, mcv_multiple_place place) {
    if (m->roughnesses == 1) return mcv_multiple_word(table, place);
    const uint size =
        MCV_MULTIPLE_WORDS * MCV_MULTIPLE_COSINES * MCV_MULTIPLE_COSINES * MCV_MULTIPLE_AZIMUTHS;
    float beyond;
    const uint low = mcv_multiple_layer(layer, &beyond);
    const float below = mcv_multiple_word(table + low * size, place);
    const float above = mcv_multiple_word(table + (low + 1) * size, place);
    return mcv_fma(beyond, above - below, below);
}

/* The words of a brushed metal at its roughness. */
MCV_LOOP_FUNCTION mcv_brushed_words mcv_brushed_metal(const mcv_device_glossy *m, float layer,
                                                      __global const float *table,
                                                      mcv_brushed_place place) {
    float beyond;
    const uint low = mcv_multiple_layer(layer, &beyond);
    if (!MCV_WITH_TEXTURE || m->roughnesses == 1) return mcv_brushed_at(table, place);
    return mcv_brushed_between(table, low, beyond, place);
}

/* What Schlick's words of an entry are together: of f², f and 1 in two reflections, and of further
 * ones. */
MCV_LOOP_FUNCTION mcv_color mcv_schlick_multiple(const mcv_microfacets *microfacets, mcv_color more,
                                                 float square, float linear, float least,
                                                 float rest) {
    mcv_color multiple;
    MCV_EACH_CHANNEL(c) {
        const float b = microfacets->base.c[c];
        multiple.c[c] = microfacets->metallic *
                        mcv_fma(more.c[c], rest, mcv_fma(b, mcv_fma(b, square, linear), least));
    }
    return multiple;
}

/*
 * What leaves towards i after two and more meetings with microfacets: on o's side over what white
 * ones send there by one, on the other (far) over 1/(o_z (1 + Λ(o)) (1 + Λ(i))). Both directions
 * are given as if they lay above. The table of an interface lies behind its albedos.
 */
MCV_LOOP_FUNCTION mcv_color mcv_microfacet_multiple(const mcv_device_glossy *m,
                                                    const mcv_microfacets *microfacets,
                                                    __global const float *tables, mcv_color more,
                                                    mcv_vec3 o, mcv_vec3 i, int far) {
    mcv_color multiple;
    (void)far;
#if MCV_WITH_ROUGH_GLASS
    if (microfacets->type == MCV_MATERIAL_DIELECTRIC) {
        const uint words = microfacets->inside + (far ? 2u : 0u) + 2u + 2u * MCV_ALBEDO_COSINES;
        const uint known =
            microfacets->table != MCV_NONE; /* else it is smooth, and what is read does not count */
        mcv_multiple_place place = mcv_find_multiple(1, o, i);
        place.first = known * (microfacets->table + words + place.first);
        place.edge *= known;
        place.across *= known;
        const float root = mcv_multiple_word(tables, place);
        return mcv_grey((root * root) * (root * root));
    }
#endif
    __global const float *table = tables + m->multiple;
    if (m->azimuths > 1) {
        const mcv_brushed_words at = mcv_brushed_metal(m, microfacets->layer, table,
                                                       mcv_find_brushed(microfacets->alpha, o, i));
        if (!MCV_WITH_METAL || microfacets->type != MCV_MATERIAL_CONDUCTOR)
            return mcv_schlick_multiple(microfacets, more, at.word[0], at.word[1], at.word[2],
                                        at.word[3]);
        MCV_EACH_CHANNEL(c) multiple.c[c] = at.word[c];
        return multiple;
    }
    const mcv_multiple_place place = mcv_find_multiple(0, o, i);
    if (MCV_WITH_METAL && microfacets->type == MCV_MATERIAL_CONDUCTOR) {
        /* No image changes its roughness. */
        MCV_EACH_CHANNEL(c) multiple.c[c] = mcv_multiple_word(table + c, place);
        return multiple;
    }
    const float square = mcv_metal_word(m, microfacets->layer, table, place);
    const float linear = mcv_metal_word(m, microfacets->layer, table + 1, place);
    const float least = mcv_metal_word(m, microfacets->layer, table + 2, place);
    const float rest = mcv_metal_word(m, microfacets->layer, table + 3, place);
    return mcv_schlick_multiple(microfacets, more, square, linear, least, rest);
}

/* Is there a table of multiple scattering? Rough conductors have one, as no image changes their
 * roughness, and glass without a direction. Known to the compiler where their loops are: a choice
 * of albedos that hangs on the material alone kept those of brushed metal from being vectorised. */
MCV_LOOP_FUNCTION int mcv_has_multiple(const mcv_device_glossy *m,
                                       const mcv_microfacets *microfacets) {
    if (microfacets->type == MCV_MATERIAL_CONDUCTOR) return 1;
    return microfacets->type == MCV_MATERIAL_METALLIC_ROUGHNESS ? m->multiple != MCV_NONE
                                                                : m->azimuths == 1;
}

#endif
