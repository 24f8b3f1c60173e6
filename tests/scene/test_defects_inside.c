/* SPDX-License-Identifier: Apache-2.0 */
/* Bubbles, inclusions and striae inside of bodies, and defects in places by chance. */
#include "test.h"

#include <math.h>

#include "check/findings.h"
#include "defects/defects.h"
#include "loader/load.h"
#include "mcvisi/surfaces/solid.h"
#include "scene/materials.h"
#include "scene_files.h"

/* A box of glass of 20 mm, n = 1.5, about its node in (0.1, 0, 0); a plate of steel of 40 mm, two
 * triangles in the plane z = 0.5. */
static char *scene_text(const char *defects) {
    const float corners[12] = {-0.02f, -0.02f, 0, 0.02f,  -0.02f, 0,
                               0.02f,  0.02f,  0, -0.02f, 0.02f,  0};
    const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    char bytes[sizeof corners + sizeof indices];
    memcpy(bytes, corners, sizeof corners);
    memcpy(bytes + sizeof corners, indices, sizeof indices);
    char *data = base64(bytes, sizeof bytes);
    char *text = text_of(
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
        "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
        "\"min\":[-0.02,-0.02,0],\"max\":[0.02,0.02,0]},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"materials\":[{\"name\":\"glass\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
        "\"dielectric\",\"ior\":1.5,\"absorption\":2,\"priority\":3}}},{\"name\":\"steel\","
        "\"extensions\":{\"MCVISI_materials\":{\"type\":\"conductor\",\"metal\":\"iron\"}}},"
        "{\"name\":\"flint\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\","
        "\"ior\":1.7}}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
        "\"material\":1}]}],"
        "\"nodes\":[{\"name\":\"block\",\"translation\":[0.1,0,0],\"extensions\":{"
        "\"MCVISI_surfaces\":{\"surface\":0}}},{\"name\":\"plate\",\"mesh\":0,"
        "\"translation\":[0,0,0.5]}],"
        "\"extensions\":{\"MCVISI_surfaces\":{\"surfaces\":[{\"type\":\"box\",\"width\":0.02,"
        "\"height\":0.02,\"depth\":0.02,\"material\":\"glass\"}]},"
        "\"MCVISI_defects\":{\"defects\":[%s]}}}",
        data, defects);
    free(data);
    return text;
}

static mcv_scene *load(const char *defects) {
    mcv_scene *scene;
    mcv_error error;
    char *text = scene_text(defects);
    if (load_text("inside.gltf", text, NULL, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    free(text);
    return scene;
}

static const mcv_material *material_of(const mcv_scene *scene, uint32_t solid) {
    return scene->materials + scene->instances[scene->solids[solid].instances[0]].material;
}

static void adds_balls(void **state) {
    mcv_scene *scene =
        load("{\"name\":\"b\",\"type\":\"bubble\",\"node\":\"block\",\"at\":[\"4mm\",0,\"-2mm\"],"
             "\"size\":\"0.4mm\"},"
             "{\"name\":\"i\",\"type\":\"inclusion\",\"node\":\"block\",\"at\":[0,0,0],"
             "\"size\":\"0.2mm\",\"material\":\"flint\"},"
             "{\"name\":\"s\",\"type\":\"inclusion\",\"node\":\"block\",\"at\":[0,\"5mm\",0],"
             "\"size\":\"0.2mm\",\"material\":\"steel\"}");
    (void)state;
    assert_int_equal(scene->solid_count, 4);
    const mcv_solid *bubble = scene->solids + 1;
    const double middle[3] = {0.104, 0, -0.002};
    assert_int_equal(bubble->side, MCV_SIDE_SPHERE);
    assert_true(fabs(bubble->radius - 2e-4) < 1e-15);
    for (int i = 0; i < 3; ++i) assert_true(fabs(bubble->to_world.m[9 + i] - middle[i]) < 1e-12);
    assert_true(material_of(scene, 1)->as.medium.ior[0] == 1);
    assert_true(material_of(scene, 1)->as.medium.priority == 4);
    assert_true(material_of(scene, 1)->as.medium.absorption[0] == 0);
    /* Flint of priority 0 would be overruled by the glass around it. */
    assert_true(fabs(material_of(scene, 2)->as.medium.ior[0] - 1.7) < 1e-12);
    assert_true(material_of(scene, 2)->as.medium.priority == 4);
    assert_string_equal(material_of(scene, 3)->name, "steel");
    mcv_scene_free(scene);
}

/* Across the middle of the stria the optical path is ∫ Δn exp(-r²/2s²) = Δn s √(2π) longer; tubes
 * of 2 r_k with the step Δn/K each sum to that. Integrating the inverse function by K midpoints
 * errs most where it is steep, at level 0: by less than 1/K of the last tube, 1 % for 16. */
static void adds_nested_tubes(void **state) {
    mcv_scene *scene =
        load("{\"name\":\"t\",\"type\":\"stria\",\"node\":\"block\",\"at\":[0,0,0],\"size\":"
             "\"0.8mm\",\"length\":\"5mm\",\"direction\":[0,1,1],\"indexStep\":2e-3,\"tubes\":16}");
    double path = 0;
    (void)state;
    assert_int_equal(scene->solid_count, 17);
    for (uint32_t k = 1; k < 17; ++k) {
        const mcv_solid *tube = scene->solids + k;
        const mcv_medium_params *medium = &material_of(scene, k)->as.medium;
        assert_int_equal(tube->side, MCV_SIDE_CYLINDER);
        assert_true(fabs(medium->ior[1] - 1.5 - 2e-3 * k / 16) < 1e-12);
        assert_true(medium->priority == 3 + k);
        assert_true(medium->absorption[0] == 2);
        if (k > 1) assert_true(tube->radius < tube[-1].radius);
        assert_true(fabs(tube->to_world.m[2]) < 1e-12);
        assert_true(fabs(tube->to_world.m[5] - M_SQRT1_2) < 1e-12);
        path += 2 * tube->radius * 2e-3 / 16;
    }
    const double wanted = 2e-3 * 2e-4 * sqrt(2 * M_PI);
    if (fabs(path / wanted - 1) > 0.01) fail_msg("the path is %g, must be %g", path, wanted);
    mcv_scene_free(scene);
}

/* A disc of gas across the direction, an exact cylinder of the opening's length. */
static void adds_cracks(void **state) {
    mcv_scene *scene =
        load("{\"name\":\"c\",\"type\":\"crack\",\"node\":\"block\",\"at\":[\"2mm\",0,0],\"size\":"
             "\"3mm\",\"opening\":\"5um\",\"direction\":[0,1,1]}");
    (void)state;
    assert_int_equal(scene->solid_count, 2);
    const mcv_solid *disc = scene->solids + 1;
    assert_int_equal(disc->side, MCV_SIDE_CYLINDER);
    assert_true(fabs(disc->radius - 1.5e-3) < 1e-15);
    assert_true(fabs(disc->caps[1].z - disc->caps[0].z - 5e-6) < 1e-15);
    assert_true(fabs(disc->to_world.m[9] - 0.102) < 1e-12);
    for (int i = 0; i < 3; ++i)
        assert_true(fabs(disc->to_world.m[3 * i + 2] - (i ? M_SQRT1_2 : 0)) < 1e-12);
    assert_true(material_of(scene, 1)->as.medium.ior[0] == 1);
    assert_true(material_of(scene, 1)->as.medium.priority == 4);
    mcv_scene_free(scene);
}

/* Twice the longest wavelength, 587.6 nm in grey scenes and the like in others, is below 2 µm. */
static void warns_of_closed_cracks(void **state) {
    (void)state;
    for (int i = 0; i < 2; ++i) {
        char *crack =
            text_of("{\"name\":\"c\",\"type\":\"crack\",\"node\":\"block\",\"at\":[0,0,0],"
                    "\"size\":\"3mm\",\"opening\":\"%s\"}",
                    i ? "2um" : "0.5um");
        mcv_scene *scene = load(crack);
        mcv_findings findings;
        mcv_error error;
        bool warned = false;
        assert_int_equal(mcv_findings_of(scene, &findings, &error), MCV_OK);
        for (size_t f = 0; f < findings.count; ++f)
            warned = warned || strstr(findings.items[f].sentence, "tunnels through it");
        assert_int_equal(warned, i == 0);
        mcv_findings_free(&findings);
        mcv_scene_free(scene);
        free(crack);
    }
}

static void refuses(const char *defect, const char *says) {
    char *text = scene_text(defect);
    must_refuse("inside-bad.gltf", text, says);
    free(text);
}

static void refuses_bad_input(void **state) {
    (void)state;
    refuses("{\"type\":\"bubble\",\"node\":\"block\",\"at\":[0.011,0,0],\"size\":1e-4}",
            "does not lie inside of node \"block\"");
    refuses("{\"type\":\"bubble\",\"node\":\"block\",\"at\":[0.0099,0,0],\"size\":1e-3}",
            "reaches out of it");
    refuses("{\"type\":\"stria\",\"node\":\"block\",\"at\":[0,0,0],\"size\":1e-3}", "reaches out");
    /* Its middle lies inside, its rim does not. */
    refuses("{\"type\":\"crack\",\"node\":\"block\",\"at\":[0.009,0,0],\"size\":4e-3,"
            "\"direction\":[0,0,1]}",
            "reaches out");
    refuses("{\"type\":\"bubble\",\"node\":\"block\",\"triangle\":0,\"size\":1e-3}", "\"at\"");
    refuses("{\"type\":\"inclusion\",\"node\":\"block\",\"at\":[0,0,0],\"size\":1e-3}",
            "\"material\"");
    refuses("{\"type\":\"bubble\",\"node\":\"block\",\"density\":5,\"size\":1e-3}", "\"count\"");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"count\":5,\"at\":[0,0,0],\"size\":1e-3}",
            "by chance");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"count\":5,\"density\":5,\"size\":1e-3}",
            "not both");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"density\":1e9,\"size\":1e-3}", "at most 1000");
    refuses("{\"type\":\"bubble\",\"node\":\"block\",\"count\":2,\"size\":0.03}", "by chance");
}

static const char lone[] =
    "{\"type\":\"bubble\",\"node\":\"block\",\"at\":[0,0,0],\"size\":\"1mm\"}";

/* Places of 400 dents by chance; the meshes stay as they are. */
static void choose(const mcv_scene *scene, uint64_t seed, double places[400][3]) {
    const mcv_json_path place = mcv_place_file("(test)");
    const mcv_defect_site site = {.node = "plate"};
    mcv_chance chance = {.count = 400, .state = seed};
    mcv_error error;
    for (int i = 0; i < 400; ++i) {
        mcv_defect d = {.name = (char *)"d", .form = MCV_SHAPE_COSINE, .size = 2e-5};
        if (mcv_chance_locate(scene, &site, &chance, &d, &place, &error) != MCV_OK)
            fail_msg("%s", error.text);
        memcpy(places[i], d.centre, sizeof d.centre);
    }
}

/* Even over 40 mm: means are 0 within 3 x 40/√(12 x 400), mean squares (20 mm)²/3 within 3 x 0.9 of
 * it/√400. */
static void chance_is_even(void **state) {
    static double places[3][400][3];
    mcv_scene *scene = load(lone);
    (void)state;
    for (int i = 0; i < 3; ++i) choose(scene, i < 2 ? 5 : 6, places[i]);
    assert_memory_equal(places[0], places[1], sizeof places[0]);
    assert_true(places[0][0][0] != places[2][0][0]);
    for (int k = 0; k < 2; ++k) {
        double mean = 0, square = 0;
        for (int i = 0; i < 400; ++i) {
            mean += places[0][i][k] / 400;
            square += pow(places[0][i][k], 2) / 400;
        }
        assert_true(fabs(mean) < 3 * 0.04 / sqrt(12 * 400));
        assert_true(fabs(square * 3 / 4e-4 - 1) < 3 * 0.9 / sqrt(400));
    }
    mcv_scene_free(scene);
}

/* Of 1000 seeds with 2 defects on average: the mean number within 3 x √(2/1000), the variance that
 * of Poisson, 2, within 3 x √(10/1000) (its fourth central moment is 3 λ² + λ). */
static void density_is_poisson(void **state) {
    enum { SEEDS = 1000 };
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_scene *scene = load(lone);
    mcv_error error;
    double sum = 0, squares = 0;
    (void)state;
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        mcv_chance chance = {.density = 1250, .state = seed << 32};
        uint64_t count;
        assert_int_equal(mcv_chance_count(scene, "plate", &chance, &count, &place, &error), MCV_OK);
        sum += (double)count;
        squares += (double)count * (double)count;
    }
    const double mean = sum / SEEDS, variance = squares / SEEDS - mean * mean;
    if (fabs(mean - 2) > 3 * sqrt(2.0 / SEEDS) || fabs(variance - 2) > 3 * sqrt(10.0 / SEEDS))
        fail_msg("mean %g, variance %g: both must be 2", mean, variance);
    mcv_scene_free(scene);
}

/* From the file: names count, and bubbles lie inside. */
static void reads_chance(void **state) {
    mcv_scene *scene = load("{\"name\":\"d\",\"type\":\"dent\",\"node\":\"plate\",\"count\":3,"
                            "\"seed\":5,\"size\":\"1mm\"},{\"name\":\"b\",\"type\":\"bubble\","
                            "\"node\":\"block\",\"count\":20,\"size\":\"1mm\"}");
    (void)state;
    assert_int_equal(scene->defect_count, 23);
    assert_int_equal(scene->solid_count, 21);
    assert_string_equal(scene->defects[2].name, "d-3");
    for (uint32_t s = 1; s < 21; ++s)
        for (int k = 0; k < 3; ++k)
            assert_true(fabs(scene->solids[s].to_world.m[9 + k] - (k == 0 ? 0.1 : 0)) < 0.0095);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(adds_balls),         cmocka_unit_test(adds_nested_tubes),
        cmocka_unit_test(adds_cracks),        cmocka_unit_test(warns_of_closed_cracks),
        cmocka_unit_test(refuses_bad_input),  cmocka_unit_test(chance_is_even),
        cmocka_unit_test(density_is_poisson), cmocka_unit_test(reads_chance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
