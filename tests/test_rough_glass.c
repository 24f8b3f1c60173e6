/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/*
 * Rough glass against light that walks from microfacet to microfacet of the surface that Smith's masking describes until it leaves it
 * (Heitz, Hanika, d'Eon and Dachsbacher 2016). The reference renderer's surfaces stand for the device's (test_gloss.c compares these).
 */
#include "scene_builder.h"

#include "reference/gloss.h"
#include "reference/interface.h"
#include "truths.h"

/* Smith's Λ of GGX; of a direction that goes down it is -1 - Λ of its opposite. */
static double smith(double alpha, ref_vec w) {
    const double slope = alpha * hypot(w.x, w.y) / fabs(w.z), up = (sqrt(1 + slope * slope) - 1) / 2;
    return w.z > 0 ? up : -1 - up;
}

/* The area of microfacets that w sees, over that of the surface. */
static double seen_area(double alpha, ref_vec w) { return w.z > 0 ? w.z * (1 + smith(alpha, w)) : -w.z * smith(alpha, ref_scale(-1, w)); }

static double distribution(double alpha, ref_vec h) {
    const double s = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z;
    return h.z > 0 ? 1 / (M_PI * alpha * alpha * s * s) : 0;
}

/* A normal as microfacets show them to w, which may come from below (Dupuy and Benyoub 2023). */
static ref_vec visible_normal(double alpha, ref_vec w, ref_random *random) {
    const ref_vec on = ref_unit((ref_vec){alpha * w.x, alpha * w.y, w.z});
    const double phi = 2 * M_PI * ref_random_unit(random), z = (1 - ref_random_unit(random)) * (1 + on.z) - on.z,
                 sine = sqrt(fmax(1 - z * z, 0));
    const ref_vec h = {sine * cos(phi) + on.x, sine * sin(phi) + on.y, z + on.z};
    return ref_unit((ref_vec){alpha * h.x, alpha * h.y, fmax(h.z, 0)});
}

static double fresnel(double from, double to, double cosine) {
    double s, p;
    ref_fresnel(from, to, fmin(cosine, 1), &s, &p);
    return (s + p) / 2;
}

/* A direction in which light may leave, and what does: after one meeting with a microfacet, after more, with the sum of its squares. */
typedef struct goal {
    ref_vec to;
    double once, more, squares;
} goal;

static ref_vec flipped(ref_vec w) { return (ref_vec){w.x, w.y, -w.z}; }

/*
 * f cosθ towards each goal, of walks from a direction; each microfacet is asked for what it sends there. `below` is the share of the
 * surface below the light, uniform where it meets a microfacet first. Light in the body walks on the surface turned about.
 */
static void walk_to(double alpha, double n_outside, double n_inside, ref_vec from, int walks, ref_random *random, int count, goal *goals) {
    double more[256];
    for (int i = 0; i < walks; ++i) {
        ref_vec w = ref_scale(-1, from);
        double below = 1;
        bool inside = false;
        memset(more, 0, sizeof more);
        for (int meetings = 1; meetings < 200; ++meetings) {
            const double left = pow(ref_random_unit(random), 1 / smith(alpha, w));
            if (w.z > 0 && below >= left) break;
            below /= left;
            const double n1 = inside ? n_inside : n_outside, n2 = inside ? n_outside : n_inside;
            const ref_vec back = ref_scale(-1, w);
            const double seen = seen_area(alpha, back);
            for (int g = 0; g < count; ++g) {
                const ref_vec to = inside ? flipped(goals[g].to) : goals[g].to;
                const bool bends = to.z < 0;
                ref_vec h = bends ? ref_add(ref_scale(n1, back), ref_scale(n2, to)) : ref_add(back, to);
                if (bends && h.z < 0) h = ref_scale(-1, h);
                const double length = ref_length(h);
                h = ref_scale(1 / length, h);
                const double c = ref_dot(back, h), behind = -ref_dot(to, h);
                if (!(h.z > 0 && c > 0 && (!bends || behind > 0))) continue;
                const double reflected = fresnel(n1, n2, c);
                const double sent = bends ? (1 - reflected) * c * n2 * n2 * behind / (length * length) : reflected / 4;
                const double leaves = bends ? pow(1 - below, smith(alpha, flipped(to))) : pow(below, smith(alpha, to));
                const double value = sent * distribution(alpha, h) / seen * leaves;
                if (meetings == 1)
                    goals[g].once += value / walks;
                else
                    more[g] += value;
            }
            const ref_vec h = visible_normal(alpha, back, random);
            const double c = fmin(fmax(ref_dot(back, h), 0), 1), ratio = n1 / n2, squared = 1 - ratio * ratio * (1 - c * c);
            if (ref_random_unit(random) < fresnel(n1, n2, c)) {
                w = ref_sub(ref_scale(2 * c, h), back);
            } else {
                w = flipped(ref_add(ref_scale(-ratio, back), ref_scale(ratio * c - sqrt(fmax(squared, 0)), h)));
                below = 1 - below;
                inside = !inside;
            }
        }
        for (int g = 0; g < count; ++g) {
            goals[g].more += more[g] / walks;
            goals[g].squares += more[g] * more[g] / walks;
        }
    }
}

static double lambda_beta(double a, double b) { return exp(lgamma(1 + a) + lgamma(1 + b) - lgamma(2 + a + b)); }

enum { ANGLES = 6, TURNS = 5, RING = 12, PLACES = 4 };

static void test_directions(void **state) {
    static const double angles[] = {10, 30, 50, 65, 75, 85}, alphas[] = {0.05, 0.1, 0.2, 0.35, 0.6};
    const int WALKS = getenv("W") ? atoi(getenv("W")) : 20000;
    (void)state;
    for (int a = 0; a < 5; ++a)
        for (int inside = 0; inside < 2; ++inside) {
            mcv_scene *scene = mcv_scene_new("glass");
            mcv_material material = {
                .name = (char *)"glass", .type = MCV_MATERIAL_DIELECTRIC, .texture = MCV_NONE, .surface_texture = MCV_NONE};
            material.as.dielectric = (mcv_dielectric_params){.ior = {1.5, 1.5, 1.5}, .roughness = sqrt(alphas[a])};
            BUILD(mcv_scene_add_material(scene, &material, &builder_error));
            add_box(scene, (const double[]){1, 1, 1}, 0, mcv_transform_identity());
            ref_gloss_tables tables;
            BUILD(ref_gloss_tables_new(scene, &tables, &builder_error));
            const double n1 = inside ? 1.5 : 1, n2 = inside ? 1 : 1.5;
            const ref_gloss gloss = {.material = &scene->materials[0],
                                     .table = ref_gloss_find(&tables, scene, 0, 1),
                                     .roughness = 1,
                                     .from = n1,
                                     .to = n2,
                                     .inside = inside};
            if (getenv("V")) {
                const ref_albedos *t = &gloss.table->albedos;
                printf("missing, mean %.5f %.5f (n2 ratio %.4f):", 1 - t->means[0], 1 - t->means[1],
                       2.25 * (1 - t->means[1]) / (1 - t->means[0]));
                for (int k = 5; k < 100; k += 15) printf(" %.4f %.4f;", 1 - t->pairs[2 * k], 1 - t->pairs[2 * k + 1]);
                printf("\n");
            }
            ref_random random = {(uint64_t)a * 2 + inside};
            double known[2] = {0}, squares[2][4] = {{0}}, moved[2][4] = {{0}}, total[2] = {0}, worst[2] = {0};
            double rings[2][2][6] = {{{0}}};
            for (int f = 0; f < ANGLES + 2; ++f) {
                const double angle = f < ANGLES ? angles[f] * M_PI / 180 : f == ANGLES ? 0 : M_PI / 4;
                const ref_vec o = {sin(angle), 0, cos(angle)};
                goal goals[256];
                int count = 0;
                for (int far = 0; far < 2; ++far)
                    if (f < ANGLES)
                        for (int y = 0; y < ANGLES; ++y)
                            for (int turn = 0; turn < TURNS; ++turn) {
                                const double t = angles[y] * M_PI / 180, phi = turn * M_PI / 4;
                                goals[count++] = (goal){{sin(t) * cos(phi), sin(t) * sin(phi), far ? -cos(t) : cos(t)}, 0, 0, 0};
                            }
                    else
                        for (int k = 0; k < RING * PLACES; ++k) {
                            const double up = (8 + (k % RING + 0.5)) * M_PI / 180, phi = M_PI * (k / RING + 0.5) / PLACES;
                            goals[count++] = (goal){{cos(up) * cos(phi), cos(up) * sin(phi), far ? -sin(up) : sin(up)}, 0, 0, 0};
                        }
                walk_to(alphas[a], n1, n2, o, f < ANGLES ? WALKS : 2 * WALKS, &random, count, goals);
                for (int g = 0; g < count; ++g) {
                    double value[3];
                    const ref_vec i = goals[g].to;
                    const bool far = i.z < 0;
                    ref_gloss_evaluate(&gloss, o, i, value);
                    const double l = smith(alphas[a], o), m = smith(alphas[a], far ? flipped(i) : i);
                    const double masked = far ? lambda_beta(l, m) : 1 / (1 + l + m);
                    ref_vec h = far ? ref_add(ref_scale(n1, o), ref_scale(n2, i)) : ref_add(o, i);
                    if (far && h.z < 0) h = ref_scale(-1, h);
                    const double length = ref_length(h);
                    h = ref_scale(1 / length, h);
                    const double c = ref_dot(o, h), behind = -ref_dot(i, h);
                    double lobe = 0;
                    if (h.z > 0 && c > 0 && (!far || behind > 0)) {
                        const double r = fresnel(n1, n2, c);
                        lobe = (far ? (1 - r) * c * n2 * n2 * behind / (length * length) : r / 4) * distribution(alphas[a], h) / o.z;
                    }
                    const double once = lobe * masked, truth = once + goals[g].more;
                    const double variance = (goals[g].squares - goals[g].more * goals[g].more) / WALKS,
                                 error = sqrt(fmax(variance, 0)) / truth;
                    const double models[4] = {value[0], once, lobe / (1 + l + m), truth};
                    if (f >= ANGLES) {
                        for (int k = 0; k < 4; ++k) rings[f - ANGLES][far][k] += models[k];
                        rings[f - ANGLES][far][4] += variance / 2;
                        continue;
                    }
                    const double weight = sin(angle) * cos(angle) * sqrt(1 - i.z * i.z);
                    total[far] += weight * truth;
                    for (int k = 0; k < 3; ++k) moved[far][k] += weight * fmax(fabs(models[k] - truth) - error * truth, 0);
                    if (!(error <= 0.01) || truth < 1e-4) continue;
                    known[far]++;
                    for (int k = 0; k < 3; ++k) squares[far][k] += pow(models[k] / truth - 1, 2) - error * error;
                    worst[far] = fmax(worst[far], fabs(models[0] / truth - 1));
                }
            }
            for (int far = 0; far < 2; ++far) {
                printf("α %.2f from %s, %s: %g pairs, rms ours %.4f once %.4f once-now %.4f, worst %.3f; energy moved %.4f %.4f %.4f",
                       alphas[a], inside ? "inside" : "outside", far ? "transmitted" : "reflected", known[far],
                       sqrt(fmax(squares[far][0], 0) / known[far]), sqrt(fmax(squares[far][1], 0) / known[far]),
                       sqrt(fmax(squares[far][2], 0) / known[far]), worst[far], moved[far][0] / total[far], moved[far][1] / total[far],
                       moved[far][2] / total[far]);
                for (int view = 0; view < 2; ++view)
                    printf("; ring %s ours %.4f once %.4f now-once %.4f ± %.4f", view ? "45°" : "above",
                           rings[view][far][0] / rings[view][far][3], rings[view][far][1] / rings[view][far][3],
                           rings[view][far][2] / rings[view][far][3], sqrt(rings[view][far][4]) / rings[view][far][3]);
                printf("\n");
            }
            ref_gloss_tables_free(&tables);
            mcv_scene_free(scene);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_directions)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
