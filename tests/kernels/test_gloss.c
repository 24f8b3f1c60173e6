/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/*
 * Surfaces of microfacets on the device: against the reference renderer's, against themselves with
 * the directions exchanged, and their energy and choice of directions against what they say of it.
 */
#include "elements.h"
#include "estimates.h"

#include "mcvisi/materials/microfacet.h"
#include "reference/gloss.h"
#include "device/gloss.h"
#include "truths.h"

enum { CASES = 1 << 16 };

/* mcv_gloss_element of kernels/test/elements.cl with one channel. */
typedef struct element {
    mcv_device_gloss material;
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
    const mcv_device_gloss *gloss = &packed.gloss[0];
    const double alpha = fmax(pow(gloss->roughness * scale, 2), 1e-3);
    b.bytes = sizeof *b.element + sizeof(float) * packed.albedo_count;
    b.element = calloc(1, b.bytes);
    assert_non_null(b.element);
    *b.element =
        (element){.material = *gloss,
                  .type = s->type,
                  .alpha = {(float)(alpha + (1 - alpha) * gloss->anisotropy), (float)alpha},
                  .base = packed.materials[0].value[0],
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

/*
 * Bound of the relative error of the microfacet lobe in float32, u = 2^-24. The sum of o and i, of
 * length s, is off by 4 u, the unit normal h by e = 4 u/s + 4 u; D goes with the slope of h over α,
 * at most 4 e/α; the cosine o·h with e/(o·h); refraction divides by s² again and takes a root that
 * vanishes at total reflection, where its square c₂² is off by 4 u; 40 u for the other operations.
 */
static double lobe_error(const bench *b, ref_vec o, ref_vec i) {
    const double u = 0x1p-24;
    const bool bends = i.z < 0 && b->gloss.material->type == MCV_MATERIAL_DIELECTRIC;
    const double eta = b->element->eta;
    const ref_vec sum =
        bends ? ref_add(ref_scale(eta, o), i) : ref_add(o, (ref_vec){i.x, i.y, fabs(i.z)});
    const double s = ref_length(sum), e = 4 * u / s + 4 * u, c = fabs(ref_dot(o, sum)) / s,
                 behind = fabs(ref_dot(i, sum)) / s;
    const double c2 =
        b->gloss.material->type == MCV_MATERIAL_DIELECTRIC ? 1 - eta * eta * (1 - c * c) : 1;
    const double root = c2 > 0 ? 8 * u / c2 + 4 * e * c / c2 : 0;
    return 4 * e / b->alpha + 2 * e / c + (bends ? 4 * e / s + 2 * e / behind : 0) + root + 40 * u;
}

/* The largest entry of the device's table about a direction, and the least mean. */
static double largest_near(const bench *b, ref_vec w) {
    const mcv_device_gloss *m = &b->element->material;
    const float *rows = (const float *)(const void *)(b->element + 1) + b->element->table;
    const uint32_t size = 2 + 2 * m->azimuths * MCV_ALBEDO_COSINES;
    const uint32_t column = (uint32_t)(sqrt(fabs(w.z)) * (MCV_ALBEDO_COSINES - 1));
    double most = 0;
    for (uint32_t row = 0; row < m->azimuths * m->roughnesses; ++row)
        for (uint32_t k = 0; k < 2; ++k)
            most = fmax(most, rows[row / m->azimuths * size + 2 +
                                   2 * (row % m->azimuths * MCV_ALBEDO_COSINES + column) +
                                   k * (b->gloss.material->type == MCV_MATERIAL_DIELECTRIC)]);
    return most;
}

static double least_mean(const bench *b) {
    const float *means = (const float *)(const void *)(b->element + 1) + b->element->table;
    const uint32_t size = 2 + 2 * b->element->material.azimuths * MCV_ALBEDO_COSINES;
    if (b->gloss.material->type == MCV_MATERIAL_DIELECTRIC)
        return fmin((double)means[0], (double)means[1]);
    return means[(uint32_t)b->element->layer * size];
}

/*
 * f cosθ and density, device against reference, over uniform directions and over such as light
 * takes. The albedos of both are integrals by different quadratures, interpolated over different
 * grids; an entry is off by ε = 2e-3, most at grazing, or 4e-3 where it is interpolated between 17
 * azimuths too or has a kink at the critical angle. The cosine lobe m(o) m(i)/M is then off by ε
 * (m(o) + m(i))/M, and its chance by ε; that of glass's microfacets, (1 - m) (1 - w m) with w <= 1,
 * by 2 ε.
 */
static void test_reference(void **state) {
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, true);
        ref_random random = {(uint64_t)k};
        for (size_t n = 0; n < CASES; ++n) {
            const ref_vec o = put(cases + 6 * n, direction(&random, 1e-3, 1));
            ref_vec i = direction(&random, -1, 1);
            if (n % 2) i = ref_gloss_sample(&b.gloss, o, &random);
            put(cases + 6 * n + 3, i.z == 0 ? direction(&random, -1, 1) : i);
        }
        on_device(&b, "evaluate_gloss", cases, 2, results);
        double worst = 0;
        for (size_t n = 0; n < CASES; ++n) {
            const float *c = cases + 6 * n;
            const ref_vec o = {c[0], c[1], c[2]}, i = {c[3], c[4], c[5]};
            double value[3];
            const double density = ref_gloss_evaluate(&b.gloss, o, i, value),
                         expected[2] = {value[0], density};
            const double error = lobe_error(&b, o, i),
                         share = (largest_near(&b, o) + largest_near(&b, i)) / least_mean(&b);
            const bool glass = s->type == MCV_MATERIAL_DIELECTRIC;
            const double entry = glass || b.element->material.azimuths > 1 ? 4e-3 : 2e-3;
            const double spread = entry * fabs(i.z) / M_PI * (2 + share);
            for (int what = 0; what < 2; ++what) {
                const double off = fabs(results[2 * n + (size_t)what] - expected[what]);
                const double bound = error * expected[what] + spread +
                                     (glass ? 4 : 2) * entry * expected[what] * what;
                worst = fmax(worst, off / bound);
                if (!(off <= bound) && error < 0.1)
                    fail_msg(
                        "%s, %s of o (%g %g %g), i (%g %g %g): %.8g, expected %.8g within %.2g",
                        s->name, what ? "density" : "value", o.x, o.y, o.z, i.x, i.y, i.z,
                        results[2 * n + (size_t)what], expected[what], bound);
            }
        }
        print_message("%s: at most %.2f of the bound\n", s->name, worst);
        close_bench(&b);
    }
    free(cases);
    free(results);
}

/* f(o, i)/n_i² = f(i, o)/n_o²; of the L/n² that the device carries f cosθ_i/cosθ_i is the same both
 * ways, times n_i² of where light comes from: f(o, i) n_o² = f(i, o) n_i². */
static void test_reciprocity(void **state) {
    float *cases = floats(6 * CASES), *there = floats(2 * CASES), *back = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, false);
        const bool glass = s->type == MCV_MATERIAL_DIELECTRIC;
        ref_random random = {(uint64_t)k + 100};
        double worst = 0;
        for (int far = 0; far < 2; ++far) {
            bench reverse = open_bench(s, glass && far ? !s->inside : s->inside, false);
            for (size_t n = 0; n < CASES; ++n) {
                put(cases + 6 * n, direction(&random, 0.01, 1));
                ref_vec i = direction(&random, 0.01, 1);
                if (far) i.z = -i.z;
                put(cases + 6 * n + 3, i);
            }
            on_device(&b, "evaluate_gloss", cases, 2, there);
            for (size_t n = 0; n < CASES; ++n) {
                float *c = cases + 6 * n;
                for (int axis = 0; axis < 3;
                     ++axis) { /* turned about so that the light's side is +z */
                    const float swap = c[axis];
                    c[axis] = far && axis == 2 ? -c[3 + axis] : c[3 + axis];
                    c[3 + axis] = far && axis == 2 ? -swap : swap;
                }
            }
            on_device(&reverse, "evaluate_gloss", cases, 2, back);
            const double ratio = glass && far ? b.element->eta * b.element->eta : 1; /* n_o²/n_i² */
            for (size_t n = 0; n < CASES; ++n) {
                const float *c = cases + 6 * n;
                const ref_vec i = {c[0], c[1], far ? -c[2] : c[2]},
                              o = {c[3], c[4], far ? -c[5] : c[5]};
                const double forth = there[2 * n] / fabs(i.z) * ratio,
                             other = back[2 * n] / fabs(o.z),
                             error = lobe_error(&b, o, i) + lobe_error(&reverse,
                                                                       (ref_vec){c[0], c[1], c[2]},
                                                                       (ref_vec){c[3], c[4], c[5]});
                if (error > 0.1) continue;
                worst = fmax(worst, fabs(forth - other) / (error * forth + 1e-6));
                if (!(fabs(forth - other) <= error * forth + 1e-6))
                    fail_msg("%s: f of o (%g %g %g), i (%g %g %g): %.8g there, %.8g back", s->name,
                             o.x, o.y, o.z, i.x, i.y, i.z, forth, other);
            }
            close_bench(&reverse);
        }
        print_message("%s: at most %.2f of the bound\n", s->name, worst);
        close_bench(&b);
    }
    free(cases);
    free(there);
    free(back);
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

/* The surface's albedo, 1 where nothing is lost: within 1 %, the goal (standard error
 * below 3.5e-3). */
static void test_furnace(void **state) {
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, false);
        ref_random random = {(uint64_t)k + 200};
        for (int angle = 0; angle < ANGLES; ++angle) {
            const double z = cosines[angle],
                         sum = albedo_of(&b, z, 0.7 * angle, &random, cases, results);
            print_message("%s, cosine %g: albedo %.5f\n", s->name, z, sum);
            if (s->lossless ? !(fabs(sum - 1) <= 0.01) : !(sum <= 1 && sum > 0.1))
                fail_msg("%s, cosine %g: albedo %.5f", s->name, z, sum);
        }
        close_bench(&b);
    }
    free(cases);
    free(results);
}

/* Smith's Λ of GGX; of a direction that goes down it is -1 - Λ of its opposite. */
static double smith(const double alpha[2], ref_vec w) {
    const double slope = hypot(alpha[0] * w.x, alpha[1] * w.y) / fabs(w.z),
                 up = (sqrt(1 + slope * slope) - 1) / 2;
    return w.z > 0 ? up : -1 - up;
}

/* A normal as GGX's microfacets show them to w, which may come from below: stretched to a
 * hemisphere, of which reflections fill a cap evenly (Dupuy and Benyoub 2023). */
static ref_vec visible_normal(const double alpha[2], ref_vec w, ref_random *random) {
    const ref_vec on = ref_unit((ref_vec){alpha[0] * w.x, alpha[1] * w.y, w.z});
    const double phi = 2 * M_PI * ref_random_unit(random),
                 z = (1 - ref_random_unit(random)) * (1 + on.z) - on.z,
                 sine = sqrt(fmax(1 - z * z, 0));
    const ref_vec h = {sine * cos(phi) + on.x, sine * sin(phi) + on.y, z + on.z};
    return ref_unit((ref_vec){alpha[0] * h.x, alpha[1] * h.y, fmax(h.z, 0)});
}

/*
 * Light that walks from microfacet to microfacet of the surface that Smith's masking describes
 * until it leaves it (Heitz, Hanika, d'Eon and Dachsbacher 2016): the share that leaves after the
 * first reflection, and that after any. `below` is the share of the surface below the light; U of
 * an exponential free path. At each reflection a metal takes its part.
 */
static void walk(const double alpha[2], double n, double k, ref_vec from, ref_random *random,
                 double shares[2]) {
    ref_vec w = ref_scale(-1, from);
    double below = 1, weight = 1;
    shares[0] = shares[1] = 0;
    for (int reflections = 0; reflections < 1000; ++reflections) {
        const double up = smith(alpha, w),
                     left = pow(ref_random_unit(random),
                                1 / up); /* to the power of -1/(1 + Λ) downwards */
        if (w.z > 0 && below >= left) {
            shares[0] = reflections == 1 ? weight : 0;
            shares[1] = weight;
            return;
        }
        below /= left;
        const ref_vec back = ref_scale(-1, w), h = visible_normal(alpha, back, random);
        const double c = ref_dot(back, h);
        weight *= ref_conductor_reflectance(n, k, fmin(fmax(c, 0), 1));
        w = ref_sub(ref_scale(2 * c, h), back);
    }
}

/*
 * The BRDF that such walks have, by order: what leaves towards `to` after one reflection and after
 * more, each facet asked for what it sends there. A walk finds a path of reflections from one end
 * or from the other; which of both by the balance heuristic. `sums` gets the means, of one
 * reflection and of more, of f cosθ, and the variance of the latter. A path from the one end has
 * the density of reaching its last facet; from the other it is that times u_k^Λ(to) D_k σ(w_1)/to_z
 * over u_1^Λ(from) D_1 σ(-w_k)/from_z, with σ the area that is seen.
 */
static double seen_area(const double alpha[2], ref_vec w) {
    return w.z > 0 ? w.z * (1 + smith(alpha, w)) : -w.z * smith(alpha, ref_scale(-1, w));
}

static double facet_density(const double alpha[2], ref_vec a, ref_vec b) {
    const ref_vec h = ref_unit(ref_add(a, b));
    const double s = pow(h.x / alpha[0], 2) + pow(h.y / alpha[1], 2) + h.z * h.z;
    return h.z > 0 ? 1 / (M_PI * alpha[0] * alpha[1] * s * s) : 0;
}

static void walk_to(const double alpha[2], double n, double k, ref_vec from, ref_vec to, int walks,
                    ref_random *random, double sums[3]) {
    double squares = 0;
    sums[0] = sums[1] = 0;
    for (int i = 0; i < walks; ++i) {
        double more = 0;
        for (int end = 0; end < 2; ++end) {
            const ref_vec start = end ? to : from, goal = end ? from : to;
            ref_vec w = ref_scale(-1, start), first = start;
            double below = 1, weight = 1, first_below = 1, first_density = 0;
            for (int reflections = 1; reflections < 100; ++reflections) {
                const double up = smith(alpha, w), left = pow(ref_random_unit(random), 1 / up);
                if (w.z > 0 && below >= left) break;
                below /= left;
                const ref_vec back = ref_scale(-1, w), h = visible_normal(alpha, back, random);
                const double last = facet_density(alpha, back, goal),
                             half = fmin(fmax(ref_dot(back, ref_unit(ref_add(back, goal))), 0), 1);
                const double out =
                    last / (4 * seen_area(alpha, back)) * pow(below, smith(alpha, goal));
                const double sent = weight * ref_conductor_reflectance(n, k, half) * out;
                if (reflections == 1) {
                    if (!end) sums[0] += sent / walks;
                    first_below = below;
                } else if (last > 0) {
                    const double there = pow(first_below, smith(alpha, start)) * first_density *
                                         seen_area(alpha, back) / start.z;
                    const double other =
                        pow(below, smith(alpha, goal)) * last * seen_area(alpha, first) / goal.z;
                    more += (end ? to.z / from.z : 1) * sent * there / (there + other);
                }
                const double c = ref_dot(back, h);
                weight *= ref_conductor_reflectance(n, k, fmin(fmax(c, 0), 1));
                w = ref_sub(ref_scale(2 * c, h), back);
                if (reflections == 1) {
                    first = w;
                    first_density = facet_density(alpha, back, w);
                }
            }
        }
        sums[1] += more / walks;
        squares += more * more / walks;
    }
    sums[2] = (squares - sums[1] * sums[1]) / walks;
}

/*
 * Metals send light where such walks do, for α from 0.04 to 0.64. A ring of light at 8 to 20° above
 * the surface, seen from above, and from 45°: within 1 %, the goal. The pairs of 10, 30, 50, 65, 75
 * and 85° at five azimuths: the root of the mean square of the relative errors, less the walks'
 * own, within 1 % where walks know the BRDF to 1 % (not where they meet a second facet once in 200
 * times only); none beyond 3 % and four standard errors of the walks.
 */
static void test_directions(void **state) {
    static const double angles[] = {10, 30, 50, 65, 75, 85};
    enum { PAIRS = 21 * 5, RING = 12, PLACES = 4, WALKS = 6000, RING_WALKS = 24000 };
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int s = 0; s < SUBJECTS; ++s) {
        const mcv_material *metal = &subjects[s].material;
        const bool conductor = subjects[s].type == MCV_MATERIAL_CONDUCTOR,
                   white = strcmp(subjects[s].name, "white metal of glTF") == 0;
        if (!white && !(conductor && metal->as.conductor.anisotropy == 0 &&
                        metal->as.conductor.roughness < 0.9))
            continue;
        const double n = white ? 0 : metal->as.conductor.n[0],
                     k = white ? 3 : metal->as.conductor.k[0];
        bench b = open_bench(&subjects[s], false, false);
        ref_random random = {(uint64_t)s + 500};
        ref_vec pairs[PAIRS + RING * (PLACES + 1)][2];
        int count = 0;
        for (int x = 0; x < 6; ++x)
            for (int y = x; y < 6; ++y)
                for (int turn = 0; turn < 5; ++turn, ++count)
                    for (int end = 0; end < 2; ++end) {
                        const double angle = (end ? angles[y] : angles[x]) * M_PI / 180,
                                     phi = end ? turn * M_PI / 4 : 0;
                        pairs[count][end] =
                            (ref_vec){sin(angle) * cos(phi), sin(angle) * sin(phi), cos(angle)};
                    }
        for (int view = 0; view < 2; ++view)
            for (int ring = 0; ring < RING * (view ? PLACES : 1);
                 ++ring, ++count) { /* seen from above the azimuth is all one */
                const double up = (8 + (ring % RING + 0.5)) * M_PI / 180,
                             phi = M_PI * (ring / RING + 0.5) / PLACES;
                pairs[count][0] = view ? (ref_vec){sqrt(0.5), 0, sqrt(0.5)} : (ref_vec){0, 0, 1};
                pairs[count][1] = (ref_vec){cos(up) * cos(phi), cos(up) * sin(phi), sin(up)};
            }
        for (size_t c = 0; c < CASES; ++c)
            for (int end = 0; end < 2; ++end)
                put(cases + 6 * c + 3 * end, pairs[c % (size_t)count][end]);
        on_device(&b, "evaluate_gloss", cases, 2, results);
        double squares = 0, most = 0, known = 0, ours[2] = {0}, theirs[2] = {0}, variance[2] = {0};
        for (int c = 0; c < count; ++c) {
            double sums[3];
            const int ring = c < PAIRS ? -1 : c >= PAIRS + RING, walks = ring < 0 ? WALKS
                                                                         : ring
                                                                             ? RING_WALKS / PLACES
                                                                             : RING_WALKS;
            walk_to(b.alphas, n, k, pairs[c][0], pairs[c][1], walks, &random, sums);
            const ref_vec o = pairs[c][0], i = pairs[c][1];
            const double c_half = sqrt(fmax(0.5 + 0.5 * ref_dot(o, i), 0));
            const double once = ref_conductor_reflectance(n, k, c_half) *
                                facet_density(b.alphas, o, i) /
                                (4 * o.z * (1 + smith(b.alphas, o) + smith(b.alphas, i)));
            const double truth = once + sums[1], off = results[2 * c] / truth - 1,
                         error = sqrt(sums[2]) / truth;
            if (ring >= 0) {
                ours[ring] += results[2 * c];
                theirs[ring] += truth;
                variance[ring] += sums[2];
                continue;
            }
            if (error <= 0.01 && fmax(smith(b.alphas, o), smith(b.alphas, i)) >= 5e-3) {
                squares += off * off - error * error;
                most = fmax(most, fabs(off) - 4 * error);
                ++known;
            }
            if (fabs(off) > 0.03 + 4 * error)
                print_message("o %.3g %.3g %.3g i %.3g %.3g %.3g: %.5g, by walks %.5g, off by "
                              "%.4f, standard error %.4f\n",
                              o.x, o.y, o.z, i.x, i.y, i.z, results[2 * c], truth, off, error);
        }
        const double rms = sqrt(fmax(squares, 0) / known);
        print_message("%s, α %.4f: %g pairs, rms %.4f, at most %.4f;", subjects[s].name, b.alpha,
                      known, rms, most);
        for (int view = 0; view < 2; ++view)
            print_message(" ring from %s: %.4f ± %.4f of the walks%s", view ? "45°" : "above",
                          ours[view] / theirs[view], sqrt(variance[view]) / theirs[view],
                          view ? "\n" : ",");
        note_truth("T15 rough metals: BRDF by walks, pairs of directions", "device", rms, 0.01);
        for (int view = 0; view < 2; ++view)
            note_truth("T15 rough metals: BRDF by walks, low ring", "device",
                       fabs(ours[view] / theirs[view] - 1), 0.01);
        for (int view = 0; view < 2; ++view)
            if (!(fabs(ours[view] / theirs[view] - 1) <= 0.01))
                fail_msg("the ring is %.4f of the walks' from view %d", ours[view] / theirs[view],
                         view);
        if (!(known >= (b.alpha > 0.2 ? PAIRS / 2 : 1) && rms <= 0.01 && most <= 0.03))
            fail_msg("pairs are off by %.4f rms, %.4f at most", rms, most);
        close_bench(&b);
    }
    free(cases);
    free(results);
}

/*
 * Brushed metals, along which light spreads more than across. Pairs of 10 to 85° at azimuths along
 * the brushing, across and between; low rings at 8 to 20° seen from above. The share of the light
 * that goes elsewhere than walks send it, less the walks' own error, and the ring's light: within 1
 * %, the goal. The root of the mean square of the relative errors, less the walks' own, in which
 * pairs count by their light, so that what next to no light takes does not count: 2 %, twice the
 * mean error that the goal allows. Once: the closed form is the walks', to 1 %, 2000 walks of each
 * of 864 pairs.
 */
enum { BRUSHED_TURNS = 8, BRUSHED_PAIRS = 6 * 3 * 6 * BRUSHED_TURNS, BRUSHED_RING = 48 };

static void put_brushed(size_t c, float *to) {
    static const double angles[] = {10, 30, 50, 65, 75, 85};
    for (size_t end = 0; end < 2; ++end) {
        double angle = angles[end ? c / 18 % 6 : c % 6] * M_PI / 180,
               phi = end ? (double)(c / 108) * 2 * M_PI / BRUSHED_TURNS + 0.1
                         : (double)(c / 6 % 3) * M_PI / 4;
        if (c >= BRUSHED_PAIRS) {
            const double ring = (double)(c - BRUSHED_PAIRS) + 0.5;
            angle = end ? (70 + fmod(ring, 12)) * M_PI / 180 : 0;
            phi = floor(ring / 12) * M_PI / 8 + M_PI / 16;
        }
        put(to + 3 * end, (ref_vec){sin(angle) * cos(phi), sin(angle) * sin(phi), cos(angle)});
    }
}

static void check_brushed(const subject *s, float *cases, float *results) {
    const double n = s->material.as.conductor.n[0], k = s->material.as.conductor.k[0];
    bench b = open_bench(s, false, false);
    ref_random random = {(uint64_t)(s - subjects) + 600};
    double total = 0, moved = 0, squares = 0, first[2] = {0}, ring[3] = {0};
    for (size_t c = 0; c < CASES; ++c)
        put_brushed(c % (BRUSHED_PAIRS + BRUSHED_RING), cases + 6 * c);
    on_device(&b, "evaluate_gloss", cases, 2, results);
    for (size_t c = 0; c < BRUSHED_PAIRS + BRUSHED_RING; ++c) {
        const float *w = cases + 6 * c;
        const ref_vec o = {w[0], w[1], w[2]}, i = {w[3], w[4], w[5]};
        double sums[3];
        walk_to(b.alphas, n, k, o, i, c < BRUSHED_PAIRS ? 2000 : 9000, &random, sums);
        const double half = sqrt(fmax(0.5 + 0.5 * ref_dot(o, i), 0)),
                     once = ref_conductor_reflectance(n, k, half) * facet_density(b.alphas, o, i) /
                            (4 * o.z * (1 + smith(b.alphas, o) + smith(b.alphas, i))),
                     truth = once + sums[1];
        if (c >= BRUSHED_PAIRS) {
            ring[0] += results[2 * c];
            ring[1] += truth;
            ring[2] += sums[2];
            continue;
        }
        /* Both solid angles, and what is seen of the surface. */
        const double weight = sqrt(1 - o.z * o.z) * o.z * sqrt(1 - i.z * i.z);
        first[0] += weight * sums[0];
        first[1] += weight * once;
        total += weight * truth;
        moved += weight * fmax(fabs(results[2 * c] - truth) - sqrt(sums[2]), 0);
        squares +=
            weight * truth * (pow(results[2 * c] / truth - 1, 2) - sums[2] / (truth * truth));
    }
    const double rms = sqrt(fmax(squares, 0) / total), off = fabs(ring[0] / ring[1] - 1);
    print_message("%s, α %.3f and %.3f: %.4f of the light goes elsewhere; pairs off by "
                  "%.4f rms; low ring %.4f ± %.4f of the walks'; once %.4f\n",
                  s->name, b.alphas[0], b.alphas[1], moved / total, rms, ring[0] / ring[1],
                  sqrt(ring[2]) / ring[1], first[0] / first[1]);
    note_truth("T15 brushed metals: light that goes elsewhere than walks", "device", moved / total,
               0.01);
    note_truth("T15 brushed metals: BRDF by walks, pairs of directions", "device", rms, 0.02);
    note_truth("T15 brushed metals: BRDF by walks, low ring", "device", off, 0.01);
    if (!(moved / total <= 0.01 && rms <= 0.02 && off <= 0.01 &&
          fabs(first[0] / first[1] - 1) <= 0.01))
        fail_msg("%s: not where walks send it", s->name);
    close_bench(&b);
}

static void test_brushed(void **state) {
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int s = 0; s < SUBJECTS; ++s)
        if (subjects[s].type == MCV_MATERIAL_CONDUCTOR &&
            subjects[s].material.as.conductor.anisotropy > 0)
            check_brushed(&subjects[s], cases, results);
    free(cases);
    free(results);
}

/*
 * Metals send out what such walks do: within 1 %, the goal, at every angle, and nearer to it than
 * what leaves after one reflection, which lacks 0.4 % upright and 8 % at a flat angle where α =
 * 0.05. The walks themselves: after one reflection the device's table, of another integral, within
 * its ε (above) and four standard errors.
 */
static void test_walk(void **state) {
    enum { WALKS = 1 << 18 };
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        if (s->type != MCV_MATERIAL_CONDUCTOR) continue;
        const int turns = s->material.as.conductor.anisotropy > 0 ? 2 : 1; /* along, across */
        bench b = open_bench(s, s->inside, false);
        ref_random random = {(uint64_t)k + 400};
        for (int place = 0; place < turns * ANGLES; ++place) {
            const double z = cosines[place % ANGLES], phi = place / ANGLES * M_PI / 2,
                         sine = sqrt(1 - z * z),
                         ours = albedo_of(&b, z, phi, &random, cases, results);
            double once = 0, squares = 0, all = 0, shares[2];
            for (int i = 0; i < WALKS; ++i) {
                walk(b.alphas, s->material.as.conductor.n[0], s->material.as.conductor.k[0],
                     (ref_vec){sine * cos(phi), sine * sin(phi), z}, &random, shares);
                once += shares[0] / WALKS;
                squares += shares[0] * shares[0] / WALKS;
                all += shares[1] / WALKS;
            }
            print_message("%s, cosine %g, azimuth %g: albedo %.5f, by walks %.5f, after one "
                          "reflection %.5f\n",
                          s->name, z, phi, ours, all, once);
            const double most = 0.01;
            note_truth(turns > 1
                           ? "T15 brushed metals: albedo by walks"
                           : "T15 rough metals: albedo by walks from microfacet to microfacet",
                       "device", fabs(ours - all), most);
            if (!(fabs(ours - all) <= fmin(most, (all - once) / 2)))
                fail_msg("%s, cosine %g: albedo %.5f, by walks %.5f, after one reflection %.5f",
                         s->name, z, ours, all, once);
            const double lost = (double)((
                const float *)(const void *)(b.element +
                                             1))[b.element->table + 2 * MCV_ALBEDO_COSINES];
            if (s->lossless && turns == 1 && z == 1 &&
                !(fabs(1 - once - lost) <= 2e-3 + 4 * sqrt((squares - once * once) / WALKS)))
                fail_msg("%s: after one reflection %.5f of the walks leave, by the table %.5f",
                         s->name, once, 1 - lost);
        }
        close_bench(&b);
    }
    free(cases);
    free(results);
}

enum { ROWS = 16, COLUMNS = 32, BINS = ROWS * COLUMNS + 1 };

/* By cosine and azimuth; the last for a path that ends. */
static int bin_of(ref_vec d) {
    const int row = (int)fmin(floor((d.z + 1) / 2 * ROWS), ROWS - 1);
    const int column =
        (int)fmin(floor((atan2(d.y, d.x) / (2 * M_PI) + 0.5) * COLUMNS), COLUMNS - 1);
    return d.x == 0 && d.y == 0 && d.z == 0 ? BINS - 1 : row * COLUMNS + column;
}

/*
 * Pearson's χ² of 10^6 choices of the device and 65536 of the reference in 16 x 32 bins of cosine
 * and azimuth over the sphere, and one for paths that end, against the density that goes with them,
 * integrated by 32 x 32 points a bin.
 */
static void test_choices(void **state) {
    enum { POINTS = 32, ROUNDS = 16, BATCH = CASES / (POINTS * POINTS) };
    float *cases = floats(6 * CASES), *directions = floats(3 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, true);
        ref_random random = {(uint64_t)k + 300};
        double counted[2][BINS] = {{0}}, expected[BINS] = {0}, all = 0;
        float rounded[3];
        const ref_vec o = put(rounded, (ref_vec){0.6, 0.48, 0.64});
        for (int round = 0; round < ROUNDS; ++round) {
            for (size_t n = 0; n < CASES; ++n) {
                put(cases + 6 * n, o);
                for (int j = 3; j < 6; ++j)
                    cases[6 * n + (size_t)j] = (float)(ref_random_bits(&random) >> 40) * 0x1p-24F;
            }
            on_device(&b, "sample_gloss", cases, 3, directions);
            for (size_t n = 0; n < CASES; ++n) {
                const float *d = directions + 3 * n;
                ++counted[0][bin_of((ref_vec){d[0], d[1], d[2]})];
            }
        }
        for (size_t n = 0; n < CASES; ++n)
            ++counted[1][bin_of(ref_gloss_sample(&b.gloss, o, &random))];
        for (int first = 0; first < BINS - 1; first += BATCH) {
            for (size_t n = 0; n < CASES; ++n) {
                const int bin = first + (int)(n / (POINTS * POINTS)),
                          p = (int)(n % (POINTS * POINTS));
                const double z = 2 * (bin / COLUMNS + (p / POINTS + 0.5) / POINTS) / ROWS - 1,
                             sine = sqrt(1 - z * z);
                const double phi =
                    2 * M_PI * ((bin % COLUMNS + (p % POINTS + 0.5) / POINTS) / COLUMNS - 0.5);
                put(cases + 6 * n, o);
                put(cases + 6 * n + 3, (ref_vec){sine * cos(phi), sine * sin(phi), z});
            }
            on_device(&b, "evaluate_gloss", cases, 2, directions);
            for (size_t n = 0; n < CASES; ++n)
                expected[first + (int)(n / (POINTS * POINTS))] +=
                    directions[2 * n + 1] * 4 * M_PI / (ROWS * COLUMNS * POINTS * POINTS) * ROUNDS *
                    CASES;
        }
        for (int bin = 0; bin < BINS - 1; ++bin) all += expected[bin];
        expected[BINS - 1] = fmax((double)ROUNDS * CASES - all, 0);
        expect_choices(s->name, "device", counted[0], expected, 1, BINS);
        expect_choices(s->name, "reference", counted[1], expected, 1.0 / ROUNDS, BINS);
        close_bench(&b);
    }
    free(cases);
    free(directions);
}

static int close_gloss(void **state) {
    for (int k = 0; k < SUBJECTS; ++k) {
        mcv_packed_free(&made[k].packed);
        ref_gloss_tables_free(&made[k].tables);
        mcv_scene_free(made[k].scene);
    }
    return close_device(state);
}

static int open_gloss(void **state) {
    element_features = MCV_FEATURE_BIT(GLOSS) | MCV_FEATURE_BIT(ANISOTROPY) |
                       MCV_FEATURE_BIT(METAL) | MCV_FEATURE_BIT(METALLIC) |
                       MCV_FEATURE_BIT(ROUGH_GLASS) | MCV_FEATURE_BIT(TEXTURE) |
                       MCV_FEATURE_BIT(DIELECTRIC) | MCV_FEATURE_BIT(COATING);
    return open_device(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference), cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_furnace),   cmocka_unit_test(test_directions),
        cmocka_unit_test(test_walk),      cmocka_unit_test(test_brushed),
        cmocka_unit_test(test_choices)};
    return cmocka_run_group_tests(tests, open_gloss, close_gloss);
}
