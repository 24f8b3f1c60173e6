/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: timeout 600 */
/*
 * How surfaces look for every emitter, a million samples each: directions have the density that
 * they claim (χ²), what is sampled is what a ray along it meets, delta lights are the reference's;
 * cones in their own frame; which pixel shines, against the formula. u = 2^-24 is the relative
 * error of one float32 operation.
 */
#include "elements.h"
#include "device/features.h"
#include "image_emitters.h"

#include "kernels/light/discrete.h"
#include "reference/lights.h"
#include "reference/random.h"
#include "device/device_scene.h"
#include "device/light.h"
#include "scene/emitters.h"

enum { CASES = 1 << 20, RINGS = 8, SECTORS = 32, BINS = RINGS * SECTORS, CELLS = 64 };
static const double u = 0x1p-24;

static ref_random random_numbers;

static double uniform(double low, double high) {
    return low + (high - low) * ref_random_unit(&random_numbers);
}

static float random_float(void) {
    return (float)(ref_random_bits(&random_numbers) >> 40) * 0x1p-24f;
}

/* Fails above 4 standard deviations: one right sampler of 30 000; seeds are fixed. Bins of less
 * than 5 are pooled with `rest`. */
static void expect_counts(const char *what, const double *counts, const double *expected,
                          size_t bins, double rest, double expected_rest) {
    double chi_squared = 0, freedom = -1;
    for (size_t i = 0; i < bins; ++i) {
        if (expected[i] < 5) {
            rest += counts[i];
            expected_rest += expected[i];
            continue;
        }
        chi_squared += pow(counts[i] - expected[i], 2) / expected[i];
        ++freedom;
    }
    if (expected_rest >= 1000) {
        chi_squared += pow(rest - expected_rest, 2) / expected_rest;
        ++freedom;
    } else if (!(fabs(rest - expected_rest) <=
                 4 * sqrt(1000) +
                     CASES / (2.0 * RINGS * CELLS))) { /* an edge along a ring, half a cell off */
        fail_msg("%s: %g samples where %g are expected", what, rest, expected_rest);
    }
    print_message("%s: chi squared %.4g of %g degrees of freedom, %.2f standard deviations\n", what,
                  chi_squared, freedom, normal_of(chi_squared, freedom));
    assert_true(freedom >= 7);
    if (!(normal_of(chi_squared, freedom) <= 4))
        fail_msg("%s: chi squared %g of %g degrees of freedom", what, chi_squared, freedom);
}

/* --- next-event estimation
 * -------------------------------------------------------------------------------------- */

typedef struct world_on_device {
    mcv_device_scene scene;
    cl_program program;
} world_on_device;

static void open_world(world_on_device *w, const mcv_scene *scene) {
    char options[2048];
    BUILD(mcv_device_scene_open(&cl, scene, 1, &w->scene, &builder_error));
    const mcv_packed *packed = &w->scene.packed;
    const mcv_frame frame = {.emitter_count = packed->emitter_count,
                             .environment_emitter = packed->environment_emitter};
    BUILD(mcv_cl_write(&cl, w->scene.frame, 0, sizeof frame, &frame, &builder_error));
    /* All kinds of emitters, as in a scene that has them: the cases share programs. */
    uint64_t features = packed->features | MCV_FEATURE_BIT(PARALLEL) | MCV_FEATURE_BIT(AREA) |
                        MCV_FEATURE_BIT(BEAM) | MCV_FEATURE_BIT(PUNCTUAL);
    if (features >> MCV_FEATURE_TEXTURE & 1)
        features |= MCV_FEATURE_BIT(LIGHT_FIELD) | MCV_FEATURE_BIT(PROJECTOR);
    mcv_feature_defines(features, packed->channels, MCV_SENSOR_PINHOLE, MCV_SAMPLER_SOBOL,
                        MCV_BLOCK, options, sizeof options);
    BUILD(mcv_cl_build(&cl, "test/emitters", options, &w->program, &builder_error));
}

static void close_world(world_on_device *w) {
    clReleaseProgram(w->program);
    mcv_device_scene_close(&w->scene);
}

/* Eight floats in and out of each case. */
static void run_world(const world_on_device *w, const char *name, const float *in, float *out) {
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 3];
    cl_kernel kernel;
    cl_mem cases, results;
    const cl_uint emitter = 0;
    const size_t bytes = 8 * sizeof(float) * CASES;
    BUILD(mcv_cl_kernel(w->program, name, &kernel, &builder_error));
    BUILD(mcv_cl_buffer(&cl, "cases", bytes, in, &cases, &builder_error));
    BUILD(mcv_cl_buffer(&cl, "results", bytes, NULL, &results, &builder_error));
    mcv_device_scene_arguments(&w->scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(emitter);
    arguments[MCV_SCENE_ARGUMENTS + 1] = MCV_ARG(cases);
    arguments[MCV_SCENE_ARGUMENTS + 2] = MCV_ARG(results);
    BUILD(mcv_cl_launch(&cl, kernel, CASES, 64, arguments, MCV_SCENE_ARGUMENTS + 3, NULL,
                        &builder_error));
    BUILD(mcv_cl_read(&cl, results, 0, bytes, out, &builder_error));
    mcv_cl_release(&cases);
    mcv_cl_release(&results);
    clReleaseKernel(kernel);
}

/* Directions by solid angle about an axis: ring q = sin²(θ/2)/sin²(widest/2), sector. */
typedef struct chart {
    ref_vec axis, x, y;
    double widest; /* sin²(θ/2) */
} chart;

static size_t bin_of(const chart *c, ref_vec d) {
    const ref_vec off = ref_sub(d, c->axis);
    const double ring = RINGS * ref_dot(off, off) / 4 / c->widest;
    const double sector = SECTORS * (atan2(ref_dot(d, c->y), ref_dot(d, c->x)) / (2 * M_PI) + 0.5);
    return (size_t)fmin(floor(ring), RINGS - 1) * SECTORS +
           (size_t)fmin(floor(sector), SECTORS - 1);
}

static ref_vec direction_at(const chart *c, double ring, double sector) {
    const double q = ring / RINGS * c->widest, level = 2 * sqrt(q * (1 - q)),
                 angle = 2 * M_PI * (sector / SECTORS - 0.5);
    return ref_add(ref_scale(1 - 2 * q, c->axis), ref_add(ref_scale(level * cos(angle), c->x),
                                                          ref_scale(level * sin(angle), c->y)));
}

static ref_vec vector_of(const float *v) { return (ref_vec){v[0], v[1], v[2]}; }

/* Was light expected, and does the ray meet it? What is sampled behind an emitter's own front is
 * not. */
static bool brings(const float *result) { return result[3] > 0 && result[6] > 0; }

/*
 * Samples from one receiver, given in the device's re-centred world. Those whose ray meets the
 * shining emitter are counted in bins of equal solid angle that hold them all; the density that is
 * claimed along rays through 64 x 64 places of each bin, where they meet it shining, says how many
 * there should be. That grid errs by 64^-1.5 = 0.2 % of a bin that an edge cuts, an eighth of its
 * own noise. What is sampled and what a ray meets agree within 1e-4, but for a share of 1e-4 at the
 * edges; a density by area goes with 1/cosine, and the end of a ray to a place is lifted off it,
 * which turns the ray by up to 100 u. Where a cone's image is looked up once the ray has met it
 * (image_later), radiance is 1 before.
 */
static void check_sampling(const char *what, const mcv_scene *scene, const double receiver[3],
                           const double normal[3], bool image_later) {
    world_on_device w;
    float *in = malloc(8 * sizeof(float) * CASES), *out = malloc(8 * sizeof(float) * CASES);
    static double counts[BINS], expected[BINS];
    size_t brought = 0, unmatched = 0, lost = 0;
    chart c = {.widest = 0};
    assert_non_null(in);
    assert_non_null(out);
    open_world(&w, scene);
    random_numbers.state = 1;
    for (size_t i = 0; i < CASES; ++i) {
        for (int k = 0; k < 3; ++k) {
            in[8 * i + k] = (float)(receiver[k] - w.scene.packed.centre[k]);
            in[8 * i + 3 + k] = (float)normal[k];
        }
        in[8 * i + 6] = random_float();
        in[8 * i + 7] = random_float();
    }
    run_world(&w, "sample_towards", in, out);
    for (size_t i = 0; i < CASES; ++i) {
        const float *s = out + 8 * i;
        lost += !(s[3] > 0) && s[6] > 0 &&
                s[4] == s[7]; /* nothing expected of a direction in the cone that meets light */
        if (!brings(s)) {
            unmatched +=
                s[3] > 0 &&
                s[7] >
                    0; /* met, but dark: at an edge; a direction past the emitter claims nothing */
            continue;
        }
        c.axis = ref_add(c.axis, vector_of(s));
        ++brought;
        const double radiance = image_later ? 1 : s[6];
        if (!(fabs(s[3] * (double)s[4] / radiance - 1) <= 1e-4) ||
            !(fabs((double)s[4] / s[7] - 1) <= 1e-4 + 100 * u / s[5]))
            ++unmatched;
    }
    if (!(unmatched <= 1e-4 * CASES))
        fail_msg("%s: %zu of %zu samples are not what is met", what, unmatched, brought);
    if (!(lost <= 1e-4 * CASES))
        fail_msg("%s: %zu samples meet light that they do not expect", what, lost);
    assert_true(brought > CASES / 100);
    c.axis = ref_unit(c.axis);
    ref_frame(c.axis, &c.x, &c.y);
    for (size_t i = 0; i < CASES; ++i) {
        const ref_vec off = ref_sub(ref_unit(vector_of(out + 8 * i)), c.axis);
        if (brings(out + 8 * i)) c.widest = fmax(c.widest, ref_dot(off, off) / 4);
    }
    c.widest = fmin(c.widest * 1.001, 1);
    memset(counts, 0, sizeof counts);
    memset(expected, 0, sizeof expected);
    for (size_t i = 0; i < CASES; ++i)
        if (brings(out + 8 * i)) ++counts[bin_of(&c, ref_unit(vector_of(out + 8 * i)))];

    for (size_t i = 0; i < CASES; ++i) {
        const size_t bin = i / (CELLS * CELLS), cell = i % (CELLS * CELLS);
        const ref_vec d = direction_at(&c, bin / SECTORS + (cell / CELLS + 0.5) / CELLS,
                                       bin % SECTORS + (cell % CELLS + 0.5) / CELLS);
        in[8 * i + 3] = (float)d.x;
        in[8 * i + 4] = (float)d.y;
        in[8 * i + 5] = (float)d.z;
    }
    run_world(&w, "meet_emitter", in, out);
    double total = 0;
    for (size_t i = 0; i < CASES; ++i)
        if (out[8 * i + 6] > 0)
            expected[i / (CELLS * CELLS)] += out[8 * i + 7] * 4 * M_PI * c.widest;
    for (size_t i = 0; i < BINS; ++i) total += expected[i];
    expect_counts(what, counts, expected, BINS, (double)(CASES - brought), CASES - total);
    close_world(&w);
    free(in);
    free(out);
}

/* The mean of a bin's places is times its solid angle 4π widest/BINS and CASES samples: 4π widest
 * of each of its CELLS² = CASES/BINS. */
_Static_assert(CASES == BINS * CELLS * CELLS, "a place per case");

static void check_panel(uint32_t type, double half_angle, double size, const double receiver[3]) {
    char what[96];
    mcv_scene *scene = mcv_scene_new("panel");
    const double s = sqrt(1 / 3.0);
    add_emitter(
        scene, type,
        add_rectangle(scene, size, 0.7 * size, add_absorber(scene), looking_down_z(0.1, 0.2, 1)), 3,
        half_angle);
    snprintf(what, sizeof what, "%s panel of %g m, %g rad, from %g m",
             type == MCV_EMITTER_AREA ? "area" : "parallel", size, half_angle, 1 - receiver[2]);
    check_sampling(what, scene, receiver, (const double[]){s, s, s}, false);
    mcv_scene_free(scene);
}

static void test_panels(void **state) {
    (void)state;
    check_panel(MCV_EMITTER_AREA, 0, 0.1, (const double[]){0, 0, 0});
    check_panel(MCV_EMITTER_AREA, 0, 1, (const double[]){0.5, 0.1, 0.8});
    check_panel(MCV_EMITTER_PARALLEL, 1, 1, (const double[]){0.1, 0.1, 0.5});
    check_panel(MCV_EMITTER_PARALLEL, 0.3, 1,
                (const double[]){0.4, 0.1, 0.5}); /* a cone that is cut by the panel's edge */
    check_panel(MCV_EMITTER_PARALLEL, 0.01, 0.5, (const double[]){0.2, 0.1, 0});
    check_panel(MCV_EMITTER_PARALLEL, 0.01, 0.5,
                (const double[]){0.345, 0.37, 0}); /* opposite a corner */
    check_panel(MCV_EMITTER_PARALLEL, 2e-4, 0.5, (const double[]){0.2, 0.1, 0});
    check_panel(MCV_EMITTER_PARALLEL, 0.02, 0.001,
                (const double[]){0.1, 0.2, 0.9}); /* smaller than its cone: by area */
}

/* Meshes of many triangles with normals of their own: always by area. */
static void test_meshes(void **state) {
    (void)state;
    for (int parallel = 0; parallel < 2; ++parallel) {
        mcv_scene *scene = mcv_scene_new("sphere");
        add_emitter(scene, parallel ? MCV_EMITTER_PARALLEL : MCV_EMITTER_AREA,
                    add_sphere(scene, 0.2, 12, add_absorber(scene), looking_down_z(0, 0, 1)), 3,
                    0.5);
        check_sampling(parallel ? "parallel sphere" : "area sphere", scene,
                       (const double[]){0.1, 0, 0.3}, (const double[]){0, 0, 1}, false);
        mcv_scene_free(scene);
    }
}

static void check_file(const char *what, const char *emitter, const double receiver[3],
                       bool image_later) {
    mcv_scene *scene;
    char *text = rig_text("", emitter, ONE_PIXEL, 0.1, "sampling.png");
    BUILD(load_text("sampling.gltf", text, NULL, &scene, &builder_error));
    add_rectangle(scene, 1e-3, 1e-3, add_absorber(scene),
                  looking_down_z(0, 0, 1)); /* behind all of them */
    check_sampling(what, scene, receiver, (const double[]){0, 0, 1}, image_later);
    mcv_scene_free(scene);
    free(text);
}

static void test_images(void **state) {
    (void)state;
    write_png("sampling.png", 12, 8);
    check_file("telecentric projector, as a cone",
               "\"type\":\"telecentricProjector\",\"image\":0,\"size\":[0.03,0.02],\"halfAngle\":0."
               "02,\"radiance\":1",
               (const double[]){0.004, 0.003, -0.1}, true);
    check_file("telecentric projector, by area",
               "\"type\":\"telecentricProjector\",\"image\":0,\"size\":[0.03,0.02],\"halfAngle\":0."
               "4,\"radiance\":1",
               (const double[]){0.004, 0.003, -0.05}, false);
    check_file("light field",
               "\"type\":\"lightField\",\"image\":0,\"size\":[0.03,0.02],\"spatialResolution\":[3,"
               "2],\"angularResolution\":[4,4],\"radiance\":1",
               (const double[]){0.01, 0, -0.02}, false);
    check_file("projector",
               "\"type\":\"projector\",\"image\":0,\"focalLength\":0.02,\"focusDistance\":0.3,"
               "\"lensDiameter\":0.01,\"pixelSize\":1e-4,"
               "\"radiance\":1",
               (const double[]){0.005, 0.002, -0.2}, false);
    check_file("environment", "\"type\":\"environment\",\"image\":0,\"radiance\":1",
               (const double[]){0.005, 0.002, -0.2}, false);
}

/* --- lights that no direction meets by chance
 * ------------------------------------------------------------------- */

/*
 * Direction, and irradiance over the chance of 1, from a million receivers. Positions round to
 * float32 before: 4 u of the direction, with 8 u of the irradiance, and within 16 u of an edge or,
 * where a spot ends, times the slope of a² in sines, a receiver may be on either side.
 */
static void check_delta(const char *what, const char *emitter, double reach) {
    mcv_scene *scene;
    world_on_device w;
    float *in = malloc(8 * sizeof(float) * CASES), *out = malloc(8 * sizeof(float) * CASES);
    size_t lit = 0, other = 0;
    double worst_direction = 0, worst_light = 0;
    char *text = rig_text("", emitter, ONE_PIXEL, 0.1, "sampling.png");
    assert_non_null(in);
    assert_non_null(out);
    BUILD(load_text("sampling.gltf", text, NULL, &scene, &builder_error));
    add_rectangle(scene, 1e-3, 1e-3, add_absorber(scene), looking_down_z(0, 0, 0.5));
    open_world(&w, scene);
    random_numbers.state = 2;
    for (size_t i = 0; i < CASES; ++i) {
        const double p[3] = {uniform(-reach, reach), uniform(-reach, reach), uniform(-0.3, -0.05)};
        for (int k = 0; k < 3; ++k) {
            in[8 * i + k] = (float)(p[k] - w.scene.packed.centre[k]);
            in[8 * i + 3 + k] = k == 2;
        }
        in[8 * i + 6] = in[8 * i + 7] = 0.5f;
    }
    run_world(&w, "sample_towards", in, out);
    for (size_t i = 0; i < CASES; ++i) {
        ref_light light;
        ref_vec point = vector_of(in + 8 * i);
        const double *centre = w.scene.packed.centre;
        point = ref_add(point, (ref_vec){centre[0], centre[1], centre[2]});
        const bool expected = ref_light_at(scene, &scene->emitters[0], point, NULL, &light) &&
                              light.irradiance[0] > 0;
        assert_true(out[8 * i + 4] == 0);
        if ((out[8 * i + 3] > 0) != expected) {
            ++other;
            continue;
        }
        if (!expected) continue;
        ++lit;
        worst_direction =
            fmax(worst_direction, ref_length(ref_sub(vector_of(out + 8 * i), light.direction)));
        worst_light = fmax(worst_light, fabs(out[8 * i + 3] - light.irradiance[0]) *
                                            pow(isinf(light.distance) ? 1 : light.distance, 2));
    }
    print_message("%s: %zu lit, direction within %.1f u, light within %.1f u, %zu at the edge\n",
                  what, lit, worst_direction / u, worst_light / u, other);
    assert_true(lit > CASES / 20);
    assert_true(other <= 1e-4 * CASES);
    if (!(worst_direction <= 32 * u))
        fail_msg("%s: directions differ by %g", what, worst_direction);
    if (!(worst_light <= 1e-4))
        fail_msg("%s: light differs by %g of the full one", what, worst_light);
    close_world(&w);
    mcv_scene_free(scene);
    free(text);
    free(in);
    free(out);
}

static void test_delta_lights(void **state) {
    (void)state;
    check_delta("collimated beam",
                "\"type\":\"collimatedBeam\",\"size\":[0.03,0.02],\"irradiance\":1", 0.02);
    check_delta(
        "round beam",
        "\"type\":\"collimatedBeam\",\"size\":[0.03,0.02],\"aperture\":\"circle\",\"irradiance\":1",
        0.02);
    check_delta("point light", "\"type\":\"point\",\"intensity\":1,\"range\":0.4", 0.2);
    check_delta("spot light",
                "\"type\":\"spot\",\"intensity\":1,\"innerConeAngle\":0.3,\"outerConeAngle\":0.6",
                0.2);
    check_delta("directional light", "\"type\":\"directional\",\"irradiance\":1", 0.2);
}

/* --- elements alone
 * --------------------------------------------------------------------------------------------- */

/* T21: uniform in the solid angle down to 1e-6 rad, in the cone's own frame: sin²(θ/2) = (x² +
 * y²)/(2 (1 + z)). */
static void test_cones(void **state) {
    (void)state;
    static const double half_angles[] = {1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1, 1.5, M_PI / 2};
    float *cases = malloc(3 * sizeof(float) * CASES),
          *directions = malloc(3 * sizeof(float) * CASES);
    assert_non_null(cases);
    assert_non_null(directions);
    for (size_t h = 0; h < sizeof half_angles / sizeof half_angles[0]; ++h) {
        const double widest = pow(sin(half_angles[h] / 2), 2);
        double counts[BINS] = {0}, expected[BINS];
        char what[64];
        random_numbers.state = h;
        for (size_t i = 0; i < CASES; ++i) {
            cases[3 * i] = random_float();
            cases[3 * i + 1] = random_float();
            cases[3 * i + 2] = (float)sin(half_angles[h] / 2);
        }
        run_elements("sample_cones", MCV_SENSOR_PINHOLE, NULL, 0, CASES, cases,
                     3 * sizeof(float) * CASES, directions, 3 * sizeof(float) * CASES);
        for (size_t i = 0; i < CASES; ++i) {
            const double x = directions[3 * i], y = directions[3 * i + 1],
                         z = directions[3 * i + 2];
            const double ring = fmin(RINGS * (x * x + y * y) / (2 * (1 + z)) / widest, RINGS - 1);
            const double sector = fmin(SECTORS * (atan2(y, x) / (2 * M_PI) + 0.5), SECTORS - 1);
            ++counts[(size_t)ring * SECTORS + (size_t)sector];
        }
        for (size_t i = 0; i < BINS; ++i) expected[i] = (double)CASES / BINS;
        snprintf(what, sizeof what, "cone of %g rad", half_angles[h]);
        expect_counts(what, counts, expected, BINS, 0, 0);
    }
    free(cases);
    free(directions);
}

/* Sines and places are known to some 4 u: what is nearer to an edge than that, in cells, may be on
 * either side. */
static void test_light_field_pixels(void **state) {
    (void)state;
    enum { M = 40, N = 30, J = 9, K = 7 };
    const double range = 0.3;
    const mcv_light_field_emitter device = {.macro_width = M,
                                            .macro_height = N,
                                            .angular_width = J,
                                            .angular_height = K,
                                            .x = {(float)(1 / range), 0, 0},
                                            .y = {0, (float)(1 / range), 0}};
    float *cases = malloc(5 * sizeof(float) * CASES);
    uint32_t *pixels = malloc(2 * sizeof(uint32_t) * CASES);
    size_t at_edge = 0, dark = 0;
    assert_non_null(cases);
    assert_non_null(pixels);
    random_numbers.state = 3;
    for (size_t i = 0; i < CASES; ++i) {
        const double x = uniform(-0.35, 0.35), y = uniform(-0.35, 0.35);
        const double values[5] = {ref_random_unit(&random_numbers),
                                  ref_random_unit(&random_numbers), x, y, -sqrt(1 - x * x - y * y)};
        for (int k = 0; k < 5; ++k) cases[5 * i + k] = (float)values[k];
    }
    run_elements("find_light_field_pixels", MCV_SENSOR_PINHOLE, &device, sizeof device, CASES,
                 cases, 5 * sizeof(float) * CASES, pixels, 2 * sizeof(uint32_t) * CASES);
    for (size_t i = 0; i < CASES; ++i) {
        const float *in = cases + 5 * i;
        const double s = in[0] * (double)M, t = in[1] * (double)N;
        const double j = (in[2] / range + 1) / 2 * J, k = (1 - in[3] / range) / 2 * K;
        const bool lit = fabs((double)in[2]) <= range && fabs((double)in[3]) <= range;
        const uint32_t column =
            lit ? (uint32_t)(fmin(floor(s), M - 1) * J + fmin(floor(j), J - 1)) : MCV_NONE;
        const uint32_t row =
            lit ? (uint32_t)(fmin(floor(t), N - 1) * K + fmin(floor(k), K - 1)) : MCV_NONE;
        dark += !lit;
        if (pixels[2 * i] == column && pixels[2 * i + 1] == row) continue;
        const double edge = fmin(fmin(fabs(s - round(s)) / M, fabs(t - round(t)) / N),
                                 fmin(fabs(j - round(j)) / J, fabs(k - round(k)) / K));
        ++at_edge;
        if (edge > 4 * u)
            fail_msg("case %zu: pixel (%u, %u), expected (%u, %u)", i, pixels[2 * i],
                     pixels[2 * i + 1], column, row);
    }
    print_message("light field: %zu of %d dark, %zu at an edge\n", dark, CASES, at_edge);
    assert_true(dark > CASES / 10 && dark < CASES / 2);
    free(cases);
    free(pixels);
}

/*
 * The projector is the thin lens camera reversed: what the camera's ray of a place on its film
 * meets is that place on the projector's image. In pixels, of W/2 from the axis and up to blur/2
 * more from the lens's rim: some 10 roundings of each.
 */
static void test_projector_is_a_camera(void **state) {
    (void)state;
    static const double lenses[][3] = {
        {0.025, 0.0256, 0.006}, {0.016, 0.0171, 0.012}, {0.05, 0.05, 0.01}, {0.05, 0.045, 0.01}};
    uint32_t *places = malloc(6 * sizeof(uint32_t) * CASES);
    float *sights = malloc(7 * sizeof(float) * CASES), *cases = malloc(5 * sizeof(float) * CASES),
          *found = malloc(2 * sizeof(float) * CASES);
    assert_non_null(places);
    assert_non_null(sights);
    assert_non_null(cases);
    assert_non_null(found);
    for (size_t l = 0; l < sizeof lenses / sizeof lenses[0]; ++l) {
        enum { WIDTH = 1281, HEIGHT = 800 };
        const double f = lenses[l][0], b = lenses[l][1], diameter = lenses[l][2], pixel = 7.6e-6,
                     kappa = 1 / f - 1 / b;
        mcv_scene *scene = mcv_scene_new("camera");
        mcv_sensor camera = sensor_defaults(MCV_SENSOR_THIN_LENS);
        camera.as.thin_lens.focalLength = f;
        camera.as.thin_lens.imageDistance = b;
        camera.as.thin_lens.lensDiameter = diameter;
        camera.as.thin_lens.resolution[0] = WIDTH;
        camera.as.thin_lens.resolution[1] = HEIGHT;
        camera.as.thin_lens.pixelSize[0] = camera.as.thin_lens.pixelSize[1] = pixel;
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera, mcv_transform_identity());
        const double wide = WIDTH * pixel / b, high = HEIGHT * pixel / b;
        const mcv_projector device = {
            .x = {(float)(1 / wide), 0, 0},
            .y = {0, (float)(-1 / high), 0},
            .axis = {0, 0, -1},
            .blur = {(float)(kappa * diameter / wide), (float)(kappa * diameter / high)}};
        random_numbers.state = l;
        for (size_t i = 0; i < CASES; ++i) {
            places[6 * i] = (uint32_t)uniform(0, WIDTH);
            places[6 * i + 1] = (uint32_t)uniform(0, HEIGHT);
            for (int k = 2; k < 6; ++k) places[6 * i + k] = as_uint(random_float());
        }
        device_sights(&scene->sensors[0], CASES, places, sights);
        for (size_t i = 0; i < CASES; ++i) {
            const float *s = sights + 7 * i; /* in the optical frame, whose z is the node's -z */
            const ref_vec d = ref_unit((ref_vec){s[3], s[4], -s[5]});
            const double values[5] = {0.5 + s[0] / diameter, 0.5 - s[1] / diameter, d.x, d.y, d.z};
            for (int k = 0; k < 5; ++k) cases[5 * i + k] = (float)values[k];
        }
        run_elements("find_projector_places", MCV_SENSOR_PINHOLE, &device, sizeof device, CASES,
                     cases, 5 * sizeof(float) * CASES, found, 2 * sizeof(float) * CASES);
        double worst = 0;
        size_t at_rim = 0;
        for (size_t i = 0; i < CASES; ++i) {
            if (found[2 * i] < 0) {
                ++at_rim;
                continue;
            }
            worst = fmax(worst, fabs(found[2 * i] * (double)WIDTH - places[6 * i] -
                                     (double)as_float(places[6 * i + 2])));
            worst = fmax(worst, fabs(found[2 * i + 1] * (double)HEIGHT - places[6 * i + 1] -
                                     (double)as_float(places[6 * i + 3])));
        }
        const double bound = 10 * u * (WIDTH + fabs(kappa) * diameter * b / pixel);
        print_message("projector f %g b %g: within %.2g pixels of %.2g, %zu at an edge\n", f, b,
                      worst, bound, at_rim);
        assert_true(at_rim <= CASES * 1e-4);
        if (!(worst <= bound)) fail_msg("a camera's ray is %g pixels off", worst);
        mcv_scene_free(scene);
    }
    free(places);
    free(sights);
    free(cases);
    free(found);
}

/*
 * A direction sampled in a pixel of the sky lies in it, against atan2 in double: angles are known
 * to 1e-6 rad, so that a share of some 1e-6 (W + 2 H)/π lies over an edge. Solid angles add up to
 * 4π, each within 8 u.
 */
static void test_environment_pixels(void **state) {
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {8, 5}, {64, 32}, {2048, 1024}, {7, 3}};
    uint32_t *cases = malloc(4 * sizeof(uint32_t) * CASES);
    float *results = malloc(6 * sizeof(float) * CASES);
    assert_non_null(cases);
    assert_non_null(results);
    for (size_t n = 0; n < sizeof sizes / sizeof sizes[0]; ++n) {
        const uint32_t width = sizes[n][0], height = sizes[n][1];
        const mcv_environment device = {
            .x = {1, 0, 0}, .y = {0, 1, 0}, .z = {0, 0, 1}, .width = width, .height = height};
        size_t over = 0, device_over = 0;
        double worst = 0, worst_angle = 0;
        random_numbers.state = n;
        for (size_t i = 0; i < CASES; ++i) {
            cases[4 * i] = (uint32_t)uniform(0, width);
            cases[4 * i + 1] = (uint32_t)uniform(0, height);
            for (int k = 2; k < 4; ++k) cases[4 * i + k] = as_uint(random_float());
        }
        run_elements("sample_environment", MCV_SENSOR_PINHOLE, &device, sizeof device, CASES, cases,
                     4 * sizeof(uint32_t) * CASES, results, 6 * sizeof(float) * CASES);
        for (size_t i = 0; i < CASES; ++i) {
            const ref_vec d = vector_of(results + 6 * i);
            const double across = width * (0.5 + atan2(d.x, -d.z) / (2 * M_PI)),
                         down = height * atan2(hypot(d.x, d.z), d.y) / M_PI;
            over += floor(fmin(across, width - 1)) != cases[4 * i] ||
                    floor(fmin(down, height - 1)) != cases[4 * i + 1];
            device_over += floor(fmin(across, width - 1)) != results[6 * i + 3] ||
                           floor(fmin(down, height - 1)) != results[6 * i + 4];
            worst = fmax(worst, fabs(ref_length(d) - 1));
            const double angle = 4 * M_PI / width * sin(M_PI / (2 * height)) *
                                 sin((2 * cases[4 * i + 1] + 1) * M_PI / (2 * height));
            worst_angle = fmax(worst_angle, fabs(results[6 * i + 5] / angle - 1));
        }
        print_message("sky of %u x %u: length within %.1f u, solid angle within %.1f u, %zu and "
                      "%zu over an edge\n",
                      width, height, worst / u, worst_angle / u, over, device_over);
        assert_true(worst <= 16 * u);
        assert_true(worst_angle <= 16 * u);
        assert_true(over <= 4 + 1e-6 * (width + 2 * height) / M_PI * CASES);
        assert_true(device_over <= 4 + 1e-6 * (width + 2 * height) / M_PI * CASES);
    }
    free(cases);
    free(results);
}

/* --- round trips
 * ------------------------------------------------------------------------------------------------
 */

/* The power that a radiance (irradiance, intensity) makes, given as power, makes that again: some
 * roundings of double. */
static void test_power_and_back(void **state) {
    (void)state;
    static const struct {
        const char *emitter, *key;
    } cases[] = {
        {"\"type\":\"parallel\",\"size\":[0.03,0.02],\"halfAngle\":%g", "radiance"},
        {"\"type\":\"area\",\"size\":[0.03,%g]", "radiance"},
        {"\"type\":\"telecentricProjector\",\"image\":0,\"size\":[0.03,0.02],\"halfAngle\":%g",
         "radiance"},
        {"\"type\":\"lightField\",\"image\":0,\"size\":[0.03,0.02],\"spatialResolution\":[3,2],"
         "\"angularResolution\":[4,4],"
         "\"angularRange\":%g",
         "radiance"},
        {"\"type\":\"projector\",\"image\":0,\"focalLength\":0.02,\"focusDistance\":0.3,"
         "\"lensDiameter\":%g,\"pixelSize\":1e-3",
         "radiance"},
        {"\"type\":\"collimatedBeam\",\"size\":[0.03,%g],\"image\":0", "irradiance"},
        {"\"type\":\"collimatedBeam\",\"size\":[0.03,%g],\"image\":0,\"aperture\":\"circle\"",
         "irradiance"},
        {"\"type\":\"point\",\"range\":%g", "intensity"},
        {"\"type\":\"spot\",\"outerConeAngle\":%g", "intensity"},
    };
    static const double values[] = {1e-6, 1e-3, 0.1, 0.7, 1};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        for (size_t v = 0; v < sizeof values / sizeof values[0]; ++v) {
            double power[3], mean[3], first[3];
            for (int back = 0; back < 2; ++back) {
                mcv_scene *scene;
                char *start = text_of(cases[i].emitter, values[v]);
                char *emitter = back ? text_of("%s,\"power\":[%.17g,%.17g,%.17g]", start, power[0],
                                               power[1], power[2])
                                     : text_of("%s,\"%s\":[1,0.5,3]", start, cases[i].key);
                char *text = rig_text("", emitter, ONE_PIXEL, 0.1, "sampling.png");
                BUILD(load_text("sampling.gltf", text, NULL, &scene, &builder_error));
                const mcv_emitter *e = &scene->emitters[0];
                mcv_emitter_image_mean(scene, e, mean);
                for (int k = 0; k < 3; ++k) {
                    if (!back) {
                        first[k] = e->radiance[k];
                        power[k] = e->radiance[k] * mean[k] * mcv_emitter_unit_power(scene, e);
                    } else if (!(fabs(e->radiance[k] / first[k] - 1) <= 1e-14)) {
                        fail_msg("%s: %s %.17g came back as %.17g", start, cases[i].key, first[k],
                                 e->radiance[k]);
                    }
                }
                mcv_scene_free(scene);
                free(text);
                free(emitter);
                free(start);
            }
        }
    }
}

/* Of a mesh of millions of triangles each is chosen by its share: here one of 2^-26, which 24 bits
 * could not give. */
static void test_rare_choices(void **state) {
    (void)state;
    const double areas[] = {1, 0x1p26 - 2, 1};
    uint32_t cdf[4], chosen[3] = {0, 0, 0};
    mcv_write_cdf(cdf, 3, areas);
    /* All pairs of which the first number is the least or the largest there is, the others have all
     * last bits. */
    for (uint32_t i = 0; i < 2 * 128; ++i) {
        const uint32_t bits = mcv_cdf_bits(i & 1 ? 1 - 0x1p-24f : 0,
                                           (float)(0xabc00 + i / 2) * 0x1p-24f),
                       found = mcv_search_cdf(cdf, 3, bits);
        const float remainder = mcv_cdf_remainder(cdf, found, bits);
        ++chosen[found];
        assert_true(remainder >= 0 && remainder < 1);
    }
    /* Each number stands for 2^-24: of 128 · 2^24 pairs 32 are 2^-26. */
    if (chosen[0] != 32 || chosen[1] != 192 || chosen[2] != 32)
        fail_msg("chosen %u, %u and %u times, must be 32, 192 and 32", chosen[0], chosen[1],
                 chosen[2]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rare_choices),
        cmocka_unit_test(test_panels),
        cmocka_unit_test(test_meshes),
        cmocka_unit_test(test_images),
        cmocka_unit_test(test_delta_lights),
        cmocka_unit_test(test_cones),
        cmocka_unit_test(test_light_field_pixels),
        cmocka_unit_test(test_projector_is_a_camera),
        cmocka_unit_test(test_environment_pixels),
        cmocka_unit_test(test_power_and_back),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
