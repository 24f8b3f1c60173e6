/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Surfaces of microfacets: metals, the layered core material of glTF, rough dielectrics. Normals
 * have the GGX distribution, masking is Smith's height-correlated function (Walter et al. 2007,
 * Heitz 2014), sampling is that of Heitz (2018).
 *
 * Light lost between microfacets is compensated as Kulla and Conty (2017) propose. This needs
 * albedos, which are integrals over all microfacet normals and are tabulated here. Isotropic
 * metals, and reflection at isotropic glass, use the device's table of multiple scattering instead;
 * test_gloss.c and test_rough_glass.c compare it with random walks.
 *
 * Directions are given in the frame (tangent, bitangent, normal) of the surface; o.z > 0.
 */
#ifndef MCVISI_HOST_REFERENCE_GLOSS_H
#define MCVISI_HOST_REFERENCE_GLOSS_H

#include "reference/random.h"
#include "reference/vector.h"
#include "scene/scene.h"

/* Two functions of the direction, over cosines, azimuths and roughnesses; for a dielectric, from
 * outside and from inside. */
typedef struct ref_albedos {
    uint32_t azimuths, roughnesses;
    double *pairs, *means;
} ref_albedos;

/* The albedos of a material and, for a dielectric, of its interface with another index. */
typedef struct ref_gloss_table {
    uint32_t material;
    double outside; /* index outside; 0 except for dielectrics */
    ref_albedos albedos;
    double multiple[3]; /* conductor: light after several reflections between microfacets */
    float *orders; /* isotropic metals and glass: two and more meetings (device/multiple.h), per
                      roughness; or NULL */
} ref_gloss_table;

typedef struct ref_gloss_tables {
    uint32_t count;
    ref_gloss_table *items;
} ref_gloss_tables;

/*
 * For the materials of all instances. Fails only without memory. A draft takes a sixteenth of the
 * time or less: its integrals have fewer steps, and Kulla and Conty's compensation stands for the
 * tables of multiple scattering.
 */
mcv_result ref_gloss_tables_new(const mcv_scene *scene, bool draft, ref_gloss_tables *tables,
                                mcv_error *error);
void ref_gloss_tables_free(ref_gloss_tables *tables);

/* The material at a point. */
typedef struct ref_gloss {
    const mcv_material *material;
    const ref_gloss_table *table;
    double roughness; /* as a share of the material's */
    double metallic, base[3];
    double from, to; /* indices on the ray's side and, of a dielectric, on the other */
    bool inside;     /* dielectric: the ray's side is the body */
} ref_gloss;

/* NULL if the material has no microfacets, or if the interface between the two indices is
 * practically smooth. */
const ref_gloss_table *ref_gloss_find(const ref_gloss_tables *tables, const mcv_scene *scene,
                                      uint32_t material, double outside);

/* f cosθ, as a share of L/n², for light that arrives from i; returns the density with which
 * ref_gloss_sample chooses i [1/sr]. */
double ref_gloss_evaluate(const ref_gloss *gloss, ref_vec o, ref_vec i, double value[3]);

/* A direction, or the zero vector: the path ends. */
ref_vec ref_gloss_sample(const ref_gloss *gloss, ref_vec o, ref_random *random);

/* Unpolarised reflectance of a metal of index n - ik, relative to the medium before it. */
double ref_conductor_reflectance(double n, double k, double cosine);

#endif
