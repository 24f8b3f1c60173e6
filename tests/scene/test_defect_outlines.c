/* SPDX-License-Identifier: Apache-2.0 */
/* Defects with a sharp outline: digs, chips, missing parts and patches. Closed meshes stay closed,
 * volumes and areas are those of the closed forms, and what cannot be is refused in one sentence.
 */
#include "defect_parts.h"
#include "loader/load.h"
#include "scene/materials.h"
#include "scene_files.h"

static void expect_near(double value, double wanted, double tolerance, const char *what) {
    if (!(fabs(value - wanted) <= tolerance))
        fail_msg("%s: %.9g must be %.9g within %.2g", what, value, wanted, tolerance);
}

/* --- pits and ridges --- */

/* Between vertices h is linear: over triangles of edges e it errs by at most e²/8 times the second
 * derivative 1/R. With R of about size²/(8 depth) and half the depth as the mean height that is
 * 2 (e/size)² = 5e-4 of the volume, for e = size/64; steep walls curve more: four times as much. */
static void digs_are_caps(void **state) {
    uint64_t random = 11;
    (void)state;
    for (int i = 0; i < 12; ++i) {
        const part which = (part)(i % PART_COUNT);
        const mcv_transform frame = frame_of(i / PART_COUNT % 3);
        mcv_scene *scene = scene_of(which, &frame);
        mcv_defect d = {.name = (char *)"dig", .type = MCV_DEFECT_DIG};
        d.size = 0.02 * pow(5, random_unit(&random));
        d.depth = d.size * (0.01 + 0.35 * random_unit(&random));
        const mcv_defect_site site = {
            .node = "part", .by_point = true, .at = {which == BALL ? 0.9747 : 0.5, 0.1, -0.2}};
        const double before = volume_of(scene), a = d.size / 2,
                     cap = M_PI * d.depth * (3 * a * a + d.depth * d.depth) / 6;
        apply(scene, &site, &d);
        expect_closed(scene, "dig");
        expect_near(before - volume_of(scene), cap, 2e-3 * cap, "volume of a dig");
        mcv_scene_free(scene);
    }
}

/* On the edge between two sides of a cube the normal is that between them: the sampled mean is off
 * by less than a piece, 1/16, of the radius. The ridge's volume is that of its law. */
static void burrs_stand_on_edges(void **state) {
    const mcv_transform frame = frame_of(1);
    mcv_scene *scene = scene_of(CUBE, &frame);
    mcv_defect d = {.name = (char *)"burr",
                    .type = MCV_DEFECT_BURR,
                    .size = 0.05,
                    .depth = 0.02,
                    .length = 0.5};
    const mcv_defect_site site = {
        .node = "part", .by_point = true, .at = {0.5, 0.5, 0.05}, .direction = {0, 0, 1}};
    double normal[3], world[3];
    (void)state;
    const double before = volume_of(scene), law = d.depth * d.size / 2 * (d.length - 3 * d.size);
    apply(scene, &site, &d);
    expect_closed(scene, "burr");
    mcv_transform_vector(&frame, (const double[3]){M_SQRT1_2, M_SQRT1_2, 0}, world);
    mcv_normalize3(world, normal);
    for (int k = 0; k < 3; ++k) expect_near(d.axes[2][k], normal[k], 1.0 / 16, "normal of a burr");
    /* Across it edges are size/64 as for a cosine dent, along it they are 16 times that, where the
     * ends fade over 3 sizes: (π/12)²/8 times half the depth. */
    expect_near(volume_of(scene) - before, law, 5e-3 * law, "volume of a burr");
    mcv_scene_free(scene);
}

/* --- cuts --- */

typedef struct cut_case {
    const char *name;
    double at[3], direction[3], size, depth, volume;
    uint32_t type;
} cut_case;

/* A ball of the radius r about a corner, an edge and within a side, and planes. The faces of the
 * ball are chords of edges of size/64 = r/32: they cut off 2/3 sagitta, r/8192, of the bite's face,
 * at most 2 π r², the more the flatter the cap. */
static void cuts_have_their_volume(void **state) {
    const double r = 0.1, h = 0.04, d = 0.15;
    const cut_case cases[] = {
        {"corner", {0.5, 0.5, 0.5}, {1, 1, 1}, 2 * r, r, M_PI * r * r * r / 6, MCV_DEFECT_CHIP},
        {"edge", {0.5, 0.5, 0.07}, {1, 1, 0}, 2 * r, r, M_PI * r * r * r / 3, MCV_DEFECT_CHIP},
        {"side", {0.5, 0.1, 0.1}, {1, 0, 0}, 2 * r, h, M_PI * h * h * (r - h / 3), MCV_DEFECT_CHIP},
        {"no corner",
         {0.5, 0.5, 0.5},
         {1, 1, 1},
         d,
         0,
         sqrt(3) / 2 * d * d * d,
         MCV_DEFECT_MISSING_PART},
        {"no top", {0.5, 0.1, 0.2}, {1, 0, 0}, d, 0, d, MCV_DEFECT_MISSING_PART}};
    (void)state;
    for (size_t i = 0; i < 3 * sizeof cases / sizeof cases[0]; ++i) {
        const cut_case *one = cases + i / 3;
        const mcv_transform frame = frame_of((int)(i % 3));
        mcv_scene *scene = scene_of(i % 2 ? FLAT_CUBE : CUBE, &frame);
        mcv_defect_site site = {.node = "part", .by_point = true};
        mcv_defect cut = {
            .name = (char *)"cut", .type = one->type, .size = one->size, .depth = one->depth};
        memcpy(site.at, one->at, sizeof site.at);
        memcpy(site.direction, one->direction, sizeof site.direction);
        const double before = volume_of(scene);
        apply(scene, &site, &cut);
        expect_closed(scene, one->name);
        /* Planes: float32 corners near 2 in the turned frames, over areas of up to 1. */
        const double tolerance =
            one->type == MCV_DEFECT_CHIP ? 2 * M_PI * r * r * r / 8192 : 4 * (double)FLT_EPSILON;
        expect_near(before - volume_of(scene), one->volume, tolerance, one->name);
        mcv_scene_free(scene);
    }
}

/* A ball's face is concave, and smooth: its normals point to the middle of the ball. */
static void bites_have_normals_of_the_ball(void **state) {
    const mcv_transform frame = frame_of(0);
    mcv_scene *scene = scene_of(CUBE, &frame);
    const mcv_defect_site site = {
        .node = "part", .by_point = true, .at = {0.5, 0.5, 0.5}, .direction = {1, 1, 1}};
    mcv_defect d = {.name = (char *)"chip", .type = MCV_DEFECT_CHIP, .size = 0.2, .depth = 0.1};
    size_t found = 0;
    (void)state;
    apply(scene, &site, &d);
    for (uint32_t t = 0; t < scene->triangle_count; ++t) {
        double c[3][3], n[3][3];
        mcv_scene_corners(scene, 0, t, c);
        mcv_scene_vertex_normals(scene, 0, t, n);
        for (int k = 0; k < 3; ++k) {
            double towards[3], length = 0, off = 0;
            for (int i = 0; i < 3; ++i) towards[i] = 0.5 - c[k][i];
            for (int i = 0; i < 3; ++i) length += towards[i] * towards[i];
            length = sqrt(length);
            if (fabs(length - 0.1) > 1e-6) continue;
            for (int i = 0; i < 3; ++i) off = fmax(off, fabs(n[k][i] - towards[i] / length));
            if (off > 0.9) continue; /* a side of the cube where it ends at the bite */
            ++found;
            expect_near(off, 0, 1e-5, "normal of a bite");
        }
    }
    assert_true(found > 1000);
    mcv_scene_free(scene);
}

/* --- patches --- */

/* A steel plate of 40 mm, two triangles in z = 0; a lamp, which follows it, with the same mesh. */
static char *scene_text(const char *defects) {
    const float corners[12] = {-0.02f, -0.02f, 0, 0.02f,  -0.02f, 0,
                               0.02f,  0.02f,  0, -0.02f, 0.02f,  0};
    const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    char bytes[sizeof corners + sizeof indices];
    memcpy(bytes, corners, sizeof corners);
    memcpy(bytes + sizeof corners, indices, sizeof indices);
    char *data = base64(bytes, sizeof bytes);
    char *text = text_of(
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
        "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
        "\"min\":[-0.02,-0.02,0],\"max\":[0.02,0.02,0]},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"materials\":[{\"name\":\"steel\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
        "\"conductor\",\"metal\":\"iron\",\"roughness\":0.2}}},{\"name\":\"rust\",\"extensions\":"
        "{\"MCVISI_materials\":{\"type\":\"diffuse\",\"reflectance\":0.1}}},{\"name\":\"glass\","
        "\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\",\"ior\":1.5}}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
        "\"material\":0}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
        "\"material\":1}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
        "\"material\":2}]}],"
        "\"nodes\":[{\"name\":\"plate\",\"mesh\":0},{\"name\":\"lamp\",\"mesh\":1,"
        "\"translation\":[0,0,1],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}},"
        "{\"name\":\"pane\",\"mesh\":2,\"translation\":[1,0,0]}],"
        "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"type\":\"area\",\"radiance\":1}]},"
        "\"MCVISI_defects\":{\"defects\":[%s]}}}",
        data, defects);
    free(data);
    return text;
}

static double area_of(const mcv_scene *scene, uint32_t instance) {
    return mcv_scene_area(scene, instance);
}

/* A circle of chords of edges of at most size/32 lacks (edge/size)² 2/3 of its area; one patch on
 * another takes from it. All instances behind have moved on. */
static void patches_have_instances_of_their_own(void **state) {
    mcv_scene *scene;
    mcv_error error;
    char *text = scene_text(
        "{\"name\":\"spot\",\"type\":\"stain\",\"node\":\"plate\",\"at\":[0.005,0,0],"
        "\"size\":\"4mm\",\"material\":\"rust\"},{\"name\":\"worn\",\"type\":\"roughPatch\","
        "\"node\":\"plate\",\"at\":[-0.005,0,0],\"size\":\"6mm\",\"roughness\":0.6}");
    const double spot = M_PI / 4 * 16e-6, worn = M_PI / 4 * 36e-6, plate = 16e-4;
    (void)state;
    if (load_text("patches.gltf", text, NULL, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    free(text);
    assert_int_equal(scene->instance_count, 5);
    assert_int_equal(scene->frames[0].instances[0], 0);
    assert_int_equal(scene->frames[0].instances[1], 3);
    assert_int_equal(scene->frames[1].instances[0], 3);
    assert_int_equal(scene->emitters[0].instance, 3);
    assert_int_equal(scene->instances[3].emitter, 0);
    /* The younger patch lies directly behind the plate. */
    const mcv_material *rough = scene->materials + scene->instances[1].material,
                       *rust = scene->materials + scene->instances[2].material;
    expect_near(mcv_material_roughness(rough).roughness, 0.6, 0, "roughness");
    assert_int_equal(rough->type, MCV_MATERIAL_CONDUCTOR);
    assert_true(rough->by_name);
    assert_string_equal(rust->name, "rust");
    expect_near(area_of(scene, 1), worn, worn * 2 / 3 / 1024, "area of a rough patch");
    expect_near(area_of(scene, 2), spot, spot * 2 / 3 / 1024, "area of a stain");
    expect_near(area_of(scene, 0) + area_of(scene, 1) + area_of(scene, 2), plate, 1e-6 * plate,
                "area of the plate");
    uint32_t triangles = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        assert_int_equal(scene->instances[i].first_triangle, triangles);
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    }
    mcv_scene_free(scene);
}

static void patches_keep_parts_closed(void **state) {
    (void)state;
    for (int which = 0; which < PART_COUNT; ++which) {
        const mcv_transform frame = frame_of(2);
        mcv_scene *scene = scene_of((part)which, &frame);
        const mcv_defect_site site = {
            .node = "part", .by_point = true, .at = {which == BALL ? 0.9747 : 0.5, 0.1, -0.2}};
        mcv_defect d = {.name = (char *)"stain", .type = MCV_DEFECT_STAIN, .size = 0.1};
        d.material = add_diffuse(scene, 0.1);
        const double before = volume_of(scene);
        apply(scene, &site, &d);
        assert_int_equal(scene->instance_count, 2);
        expect_closed(scene, "stain");
        expect_near(volume_of(scene), before, 1e-6 * before, "volume of a stained part");
        mcv_scene_free(scene);
    }
}

/* --- sizes on drawings --- */

static void reads_notations(void **state) {
    static const struct {
        const char *text;
        uint32_t type;
        double size;
        uint64_t count;
    } known[] = {{"5/3x0.16", MCV_DEFECT_DIG, 0.16e-3 * M_2_SQRTPI, 3},
                 {"5/ 3 x 0.16; L 2 \xc3\x97 0.008; E 0.5", MCV_DEFECT_SCRATCH, 8e-6, 2},
                 {"5/ 3 x 0.16; L 2 x 0.008; E 0.5", MCV_DEFECT_CHIP, 1e-3, 0},
                 {"5/ C 4 x 0.1", MCV_DEFECT_STAIN, 0.1e-3 * M_2_SQRTPI, 4},
                 {"1/1x0.25", MCV_DEFECT_BUBBLE, 0.25e-3 * M_2_SQRTPI, 1},
                 {"60-40", MCV_DEFECT_SCRATCH, 6e-6, 0},
                 {"60-40", MCV_DEFECT_DIG, 0.4e-3, 0},
                 {"10-5", MCV_DEFECT_BUBBLE, 0.05e-3, 0}};
    static const struct {
        const char *text;
        uint32_t type;
    } wrong[] = {{"5/3x0.16", MCV_DEFECT_SCRATCH}, {"5/3x0.16", MCV_DEFECT_BUBBLE},
                 {"1/3x0.16", MCV_DEFECT_DIG},     {"5/x0.16", MCV_DEFECT_DIG},
                 {"5/3x", MCV_DEFECT_DIG},         {"5/3x0.16;", MCV_DEFECT_DIG},
                 {"5/3x0.16 mm", MCV_DEFECT_DIG},  {"5/0x0.16", MCV_DEFECT_DIG},
                 {"5/2.5x0.16", MCV_DEFECT_DIG},   {"60-40", MCV_DEFECT_DENT},
                 {"60-40", MCV_DEFECT_CHIP},       {"60-0", MCV_DEFECT_DIG},
                 {"60-40-20", MCV_DEFECT_DIG}};
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    double size;
    uint64_t count;
    (void)state;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        assert_true(mcv_defect_is_notation(known[i].text));
        if (mcv_defect_read_notation(known[i].text, known[i].type, &size, &count, &place, &error) !=
            MCV_OK)
            fail_msg("%s", error.text);
        expect_near(size, known[i].size, 1e-12 * known[i].size, known[i].text);
        assert_int_equal(count, known[i].count);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        if (mcv_defect_read_notation(wrong[i].text, wrong[i].type, &size, &count, &place, &error) !=
            MCV_BAD_INPUT)
            fail_msg("%s is taken for a %s", wrong[i].text, mcv_defect_types[wrong[i].type]);
    assert_false(mcv_defect_is_notation("1e-3"));
    assert_false(mcv_defect_is_notation("0.2mm"));
    assert_false(mcv_defect_is_notation("-5mm"));
}

/* Without a place the number of the drawing counts; with one there is one. */
static void draws_as_many_as_the_notation_says(void **state) {
    (void)state;
    for (int placed = 0; placed < 2; ++placed) {
        mcv_scene *scene;
        mcv_error error;
        char *defect = text_of("{\"name\":\"d\",\"type\":\"dig\",\"node\":\"plate\",%s"
                               "\"size\":\"5/3x0.4\"}",
                               placed ? "\"at\":[0,0,0]," : ""),
             *text = scene_text(defect);
        if (load_text("notation.gltf", text, NULL, &scene, &error) != MCV_OK)
            fail_msg("%s", error.text);
        assert_int_equal(scene->defect_count, placed ? 1 : 3);
        expect_near(scene->defects[0].size, 0.4e-3 * M_2_SQRTPI, 1e-12, "size");
        mcv_scene_free(scene);
        free(defect);
        free(text);
    }
}

/* --- bad input --- */

static void refuses(const char *defect, const char *says) {
    char *text = scene_text(defect);
    must_refuse("outlines-bad.gltf", text, says);
    free(text);
}

#define PLACED "\"node\":\"plate\",\"at\":[0,0,0],\"size\":1e-3"

static void refuses_bad_input(void **state) {
    (void)state;
    refuses("{\"type\":\"dig\"," PLACED ",\"depth\":5e-4}", "below half of the size");
    refuses("{\"type\":\"chip\"," PLACED ",\"depth\":6e-4}", "at most half of the size");
    refuses("{\"type\":\"stain\"," PLACED "}", "\"material\"");
    refuses("{\"type\":\"stain\"," PLACED ",\"material\":\"rost\"}", "rost");
    refuses("{\"type\":\"roughPatch\"," PLACED "}", "roughness");
    refuses("{\"type\":\"roughPatch\"," PLACED ",\"roughness\":2}", "roughness");
    refuses(
        "{\"type\":\"stain\",\"node\":\"plate\",\"at\":[0,0,0],\"size\":1,\"material\":\"rust\"}",
        "covers all of node \"plate\"");
    refuses("{\"type\":\"stain\",\"node\":\"pane\",\"at\":[0,0,0],\"size\":1e-3,\"material\":"
            "\"rust\"}",
            "would open its body");
    refuses("{\"type\":\"roughPatch\",\"node\":\"pane\",\"at\":[0,0,0],\"size\":1e-3,\"roughness\":"
            "0.5}",
            "would open its body");
    refuses("{\"type\":\"chip\",\"node\":\"lamp\",\"at\":[0,0,0],\"size\":1e-3,\"depth\":1e-4}",
            "emits light");
}

/* A bite through a thin plate, and a plane that leaves a roof without a wall below it. */
static void refuses_to_cut_through(void **state) {
    const mcv_transform thin = {{1, 0, 0, 0, 1, 0, 0, 0, 0.004, 0, 0, 0}};
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    (void)state;
    for (int i = 0; i < 2; ++i) {
        const mcv_transform frame = frame_of(0);
        mcv_scene *scene = scene_of(CUBE, i ? &frame : &thin);
        const mcv_defect_site sites[2] = {
            {.node = "part", .by_point = true, .at = {0.1, 0.1, 0.002}},
            {.node = "part", .by_point = true, .at = {0.5, 0, 0}, .direction = {0, 0, 1}}};
        mcv_defect d = {.name = (char *)"cut",
                        .type = i ? MCV_DEFECT_MISSING_PART : MCV_DEFECT_CHIP,
                        .size = i ? 0.6 : 0.1,
                        .depth = 0.01};
        assert_int_equal(mcv_defect_locate(scene, &sites[i], &d, &place, &error), MCV_OK);
        assert_int_equal(mcv_defect_apply(scene, &d, &place, &error), MCV_BAD_INPUT);
        if (!strstr(error.text, i ? "overhangs" : "another side")) fail_msg("%s", error.text);
        mcv_scene_free(scene);
    }
}

/* Dents and stains, first in one place and then side by side, each as it lies on the whole part. */
enum { MANY = 12 };
static void locate_many(mcv_scene *scene, part which, mcv_defect all[MANY]) {
    const mcv_json_path place = mcv_place_file("(test)");
    const uint32_t paint = add_diffuse(scene, 0.1);
    for (int i = 0; i < MANY; ++i) {
        const mcv_defect_site site = {
            .node = "part",
            .by_point = true,
            .at = {which == BALL ? 1 : 0.5, i < MANY / 2 ? 0 : 0.02 * i, -0.01 * i}};
        all[i] = (mcv_defect){.name = (char *)"one", .size = 0.1, .depth = 0.001};
        if (i % 3 == 2) all[i].type = MCV_DEFECT_STAIN, all[i].material = paint;
        BUILD(mcv_defect_locate(scene, &site, all + i, &place, &builder_error));
    }
}

static void expect_same_mesh(const mcv_mesh *a, const mcv_mesh *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->positions, b->positions, 3 * sizeof(float) * a->vertex_count);
    assert_memory_equal(a->normals, b->normals, 3 * sizeof(float) * a->vertex_count);
    assert_memory_equal(a->indices, b->indices, 3 * sizeof(uint32_t) * a->triangle_count);
}

/* Defects that change a mesh one after the other make the bits that each alone would make. */
static void many_are_as_one_by_one(void **state) {
    (void)state;
    for (int which = 0; which < PART_COUNT; ++which) {
        const mcv_transform frame = frame_of(2);
        const mcv_json_path place = mcv_place_file("(test)");
        mcv_scene *scenes[2];
        mcv_known_meshes known = {0};
        for (int together = 0; together < 2; ++together) {
            mcv_scene *scene = scenes[together] = scene_of((part)which, &frame);
            mcv_defect all[MANY];
            locate_many(scene, (part)which, all);
            for (int i = 0; i < MANY; ++i) {
                all[i].instances[1] = scene->instance_count; /* with earlier patches */
                BUILD(together
                          ? mcv_defect_apply_known(scene, &known, all + i, &place, &builder_error)
                          : mcv_defect_apply(scene, all + i, &place, &builder_error));
            }
        }
        BUILD(mcv_defects_finish(scenes[1], &known, &place, &builder_error));
        assert_int_equal(scenes[0]->triangle_count, scenes[1]->triangle_count);
        assert_int_equal(scenes[0]->mesh_count, scenes[1]->mesh_count);
        for (uint32_t m = 0; m < scenes[0]->mesh_count; ++m)
            expect_same_mesh(scenes[0]->meshes + m, scenes[1]->meshes + m);
        mcv_known_meshes_free(&known);
        for (int k = 0; k < 2; ++k) mcv_scene_free(scenes[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(digs_are_caps),
                                       cmocka_unit_test(burrs_stand_on_edges),
                                       cmocka_unit_test(cuts_have_their_volume),
                                       cmocka_unit_test(bites_have_normals_of_the_ball),
                                       cmocka_unit_test(patches_have_instances_of_their_own),
                                       cmocka_unit_test(patches_keep_parts_closed),
                                       cmocka_unit_test(many_are_as_one_by_one),
                                       cmocka_unit_test(reads_notations),
                                       cmocka_unit_test(draws_as_many_as_the_notation_says),
                                       cmocka_unit_test(refuses_bad_input),
                                       cmocka_unit_test(refuses_to_cut_through)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
