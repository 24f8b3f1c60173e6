/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces of microfacets on the device, with the reference renderer's tables of them. */
#ifndef MCVISI_TESTS_GLOSS_BENCH_H
#define MCVISI_TESTS_GLOSS_BENCH_H

#include "elements.h"
#include "estimates.h"

#include "mcvisi/materials/microfacet.h"
#include "reference/gloss.h"
#include "device/pack_glossy.h"

enum { CASES = 1 << 16 };

/* mcv_glossy_case of kernels/test/elements.cl with one channel. */
typedef struct element {
    mcv_device_glossy material;
    uint32_t type;
    float alpha[2], base, metallic, layer;
    uint32_t table, inside;
    float eta, delta, scale, offset;
    uint32_t padding[4];
} element;

typedef struct subject {
    const char *name;
    uint32_t type;
    mcv_material material;
    double scale;  /* of the roughness, as from a texture; 0: without one */
    bool inside;   /* dielectric: the ray is in the body */
    bool lossless; /* all light leaves it */
} subject;

#define GREY(x) \
    { (x), (x), (x) }
#define METAL(n, k, ...) \
    .type = MCV_MATERIAL_CONDUCTOR, .material.as.conductor = {GREY(n), GREY(k), __VA_ARGS__}
#define LAYER(...) \
    .type = MCV_MATERIAL_METALLIC_ROUGHNESS, .material.as.metallic_roughness = {__VA_ARGS__}
#define GLASS(ior, ...) \
    .type = MCV_MATERIAL_DIELECTRIC, \
    .material.as.dielectric = {GREY(ior), GREY(0), 0, 0, 0, __VA_ARGS__}

static const subject subjects[] = {
    {"perfect metal, roughness 0.2", METAL(0, 3, 0.2), .lossless = true},
    {"perfect metal, roughness 0.6", METAL(0, 3, 0.6), .lossless = true},
    {"perfect metal, roughness 1", METAL(0, 3, 1), .lossless = true},
    {"perfect metal, brushed", METAL(0, 3, 0.4, 0.7), .lossless = true},
    {"copper, roughness 0.5", METAL(0.27, 3.41, 0.5)},
    {"copper, roughness 0.22", METAL(0.27, 3.61, 0.2236068)}, /* α = 0.05, the peers' */
    {"copper, roughness 0.8", METAL(0.27, 3.61, 0.8)},
    {"copper, brushed", METAL(0.27, 3.41, 0.45, 0.9)},
    {"steel, finely brushed", METAL(2.5, 3.4, 0.2236068, 0.5)},
    {"plastic, white", LAYER(GREY(1), 0, 1.5, 0, 0, 0.45), .lossless = true},
    {"plastic, grey, textured", LAYER(GREY(0.4), 0, 1.5, 0, 0, 0.9), .scale = 0.63},
    {"white metal of glTF", LAYER(GREY(1), 1, 1.5, 0, 0, 0.7), .lossless = true},
#ifdef MCV_BRUSHED_TEXTURE /* the reference renderer's albedos of it take 10 s */
    {"brushed metal of glTF, textured", LAYER(GREY(1), 1, 1.5, 0, 0, 0.6, 0.7), .scale = 0.7,
     .lossless = true},
#endif
    {"half a metal", LAYER(GREY(0.6), 0.5, 1.4, 0, 0, 0.5)},
    {"frosted pane", LAYER(GREY(1), 0, 1.5, 1, 0, 0.5), .lossless = true},
    {"opal, half clear", LAYER(GREY(1), 0, 1.5, 0.5, 0.6, 0.6, 0.5), .lossless = true},
    {"glass, roughness 0.3, from outside", GLASS(1.5, 0.3), .lossless = true},
    {"glass, roughness 0.3, from inside", GLASS(1.5, 0.3), .inside = true, .lossless = true},
    {"glass, roughness 0.9, from outside", GLASS(1.5, 0.9), .lossless = true},
    {"glass, roughness 0.9, from inside", GLASS(1.5, 0.9), .inside = true, .lossless = true},
    {"coated glass, from outside", GLASS(1.5, 0.4, 0, 0, 0.005), .lossless = true},
    {"coated glass, from inside", GLASS(1.5, 0.4, 0, 0, 0.005), .inside = true, .lossless = true},
    {"glass, brushed, from inside", GLASS(1.8, 0.4, 0.6), .inside = true, .lossless = true},
};
enum { SUBJECTS = sizeof subjects / sizeof subjects[0] };

/* A subject on device and reference. */
typedef struct bench {
    mcv_scene *scene;
    element *element;
    size_t bytes;
    ref_gloss_tables tables;
    ref_gloss gloss;
    double alpha, alphas[2]; /* the least; along x and y */
} bench;

/* Albedos take a while: what has been made of a subject is kept. */
static struct {
    mcv_scene *scene;
    mcv_packed packed;
    ref_gloss_tables tables;
} made[SUBJECTS];

static bench open_bench(const subject *s, bool inside, bool with_reference) {
    /* From inside it is the same body as the subject before, from outside. */
    const bool again =
        s->inside && memcmp(&s->material.as, &s[-1].material.as, sizeof s->material.as) == 0;
    const size_t number = (size_t)(s - subjects) - again;
    mcv_material material = s->material;
    float linear[3] = {1, 1, 1};
    material.name = (char *)"gloss";
    material.type = s->type;
    material.texture = material.surface_texture = MCV_NONE;
    if (!made[number].scene) {
        mcv_scene *scene = made[number].scene = mcv_scene_new("gloss");
        if (s->scale > 0) {
            const mcv_texture texture = {.name = (char *)"roughness",
                                         .width = 1,
                                         .height = 1,
                                         .linear = linear,
                                         .is_data = true};
            BUILD(mcv_scene_add_texture(scene, &texture, &builder_error));
            material.surface_texture = 0;
        }
        BUILD(mcv_scene_add_material(scene, &material, &builder_error));
        add_box(scene, (const double[]){1, 1, 1}, 0, mcv_transform_identity());
        BUILD(mcv_pack(scene, NULL, &made[number].packed, &builder_error));
    }
    if (with_reference && made[number].tables.count == 0)
        BUILD(
            ref_gloss_tables_new(made[number].scene, false, &made[number].tables, &builder_error));
    bench b = {.scene = made[number].scene, .tables = made[number].tables};
    const mcv_packed packed = made[number].packed;
    const double scale = s->scale > 0 ? s->scale : 1,
                 ior = s->type == MCV_MATERIAL_DIELECTRIC ? material.as.dielectric.ior[0] : 1;
    const mcv_device_glossy *gloss = &packed.glossy[0];
    const double alpha = fmax(pow(gloss->roughness * scale, 2), 1e-3);
    b.bytes = sizeof *b.element + sizeof(float) * packed.albedo_count;
    b.element = calloc(1, b.bytes);
    assert_non_null(b.element);
    *b.element =
        (element){.material = *gloss,
                  .type = s->type,
                  .alpha = {(float)(alpha + (1 - alpha) * gloss->anisotropy), (float)alpha},
                  .base = packed.materials[0].color[0],
                  .metallic = gloss->metallic,
                  .layer = s->scale > 0 ? (float)(scale * (gloss->roughnesses - 1)) : 0,
                  .inside = inside,
                  .eta = 1};
    b.element->table =
        s->type == MCV_MATERIAL_DIELECTRIC ? packed.interface_albedos[1] : gloss->table;
    if (s->type == MCV_MATERIAL_DIELECTRIC) {
        const mcv_device_interface between = packed.interfaces[0][inside ? MCV_MAX_MEDIA + 1 : 1];
        b.element->eta = between.eta;
        b.element->delta = between.delta;
        b.element->scale = between.scale;
        b.element->offset = between.offset;
    }
    memcpy(b.element + 1, packed.albedos, sizeof(float) * packed.albedo_count);
    b.alpha = b.alphas[1] = alpha;
    b.alphas[0] = alpha + (1 - alpha) * gloss->anisotropy;
    b.gloss = (ref_gloss){
        .material = &b.scene->materials[0],
        .table = ref_gloss_find(&b.tables, b.scene, 0, s->type == MCV_MATERIAL_DIELECTRIC ? 1 : 0),
        .roughness = scale,
        .from = inside ? ior : 1,
        .to = inside ? 1 : ior,
        .inside = inside};
    if (s->type == MCV_MATERIAL_METALLIC_ROUGHNESS) {
        b.gloss.metallic = material.as.metallic_roughness.metallic;
        for (int k = 0; k < 3; ++k) b.gloss.base[k] = material.as.metallic_roughness.baseColor[k];
    }
    assert_true(!with_reference || b.gloss.table);
    return b;
}

static void close_bench(bench *b) { free(b->element); }

static void on_device(const bench *b, const char *kernel, const float *cases, size_t outputs,
                      float *results) {
    run_elements(kernel, MCV_SENSOR_PINHOLE, b->element, b->bytes, CASES, cases,
                 6 * sizeof(float) * CASES, results, outputs * sizeof(float) * CASES);
}

/* The mean of f cosθ/density over a path's choices from a direction: 65536 stratified ones, of
 * weights of the order of 1. */
static double albedo_of(const bench *b, double z, double phi, ref_random *random, float *cases,
                        float *results) {
    const double sine = sqrt(1 - z * z);
    float *directions = floats(3 * CASES);
    double sum = 0;
    for (size_t n = 0; n < CASES; ++n) {
        put(cases + 6 * n, (ref_vec){sine * cos(phi), sine * sin(phi), z});
        cases[6 * n + 3] = (float)(((double)(n % 256) + ref_random_unit(random) * 0.999) / 256);
        cases[6 * n + 4] =
            (float)(((double)(n / 256) + ref_random_unit(random) * 0.999) / (CASES / 256));
        cases[6 * n + 5] = (float)(ref_random_unit(random) * 0.9999999);
    }
    on_device(b, "sample_gloss", cases, 3, directions);
    for (size_t n = 0; n < CASES; ++n)
        memcpy(cases + 6 * n + 3, directions + 3 * n, 3 * sizeof(float));
    on_device(b, "evaluate_gloss", cases, 2, results);
    for (size_t n = 0; n < CASES; ++n)
        if (results[2 * n + 1] > 0) sum += results[2 * n] / results[2 * n + 1] / CASES;
    free(directions);
    return sum;
}

static const double cosines[] = {0.02, 0.1, 0.3, 0.7, 1};
enum { ANGLES = 5 };

static int close_gloss(void **state) {
    for (int k = 0; k < SUBJECTS; ++k) {
        mcv_packed_free(&made[k].packed);
        ref_gloss_tables_free(&made[k].tables);
        mcv_scene_free(made[k].scene);
    }
    return close_device(state);
}

static int open_gloss(void **state) {
    element_features = MCV_FEATURE_BIT(GLOSSY) | MCV_FEATURE_BIT(ANISOTROPY) |
                       MCV_FEATURE_BIT(METAL) | MCV_FEATURE_BIT(METALLIC) |
                       MCV_FEATURE_BIT(ROUGH_GLASS) | MCV_FEATURE_BIT(TEXTURE) |
                       MCV_FEATURE_BIT(DIELECTRIC) | MCV_FEATURE_BIT(COATING);
    return open_device(state);
}

#endif
