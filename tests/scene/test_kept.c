/* SPDX-License-Identifier: Apache-2.0 */
/* Assets that are kept from one load to the next: the same scene as without, and new files where
 * they have changed. */
#include "program.h"

#include "scene/scene.h"
#include "loader/load.h"

static const char rig[] = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,"
                          "1,2]}],\"extensionsUsed\":[\"MCVISI_assets\"],"
                          "\"extensions\":{\"MCVISI_assets\":{\"assets\":[{\"uri\":\"box.stl\","
                          "\"unit\":\"mm\"},{\"uri\":\"part.gltf\"},"
                          "{\"uri\":\"box.stl\",\"unit\":\"cm\"}]}},\"nodes\":[{\"extensions\":{"
                          "\"MCVISI_assets\":{\"asset\":0}}},"
                          "{\"name\":\"part\",\"extensions\":{\"MCVISI_assets\":{\"asset\":1}}},{"
                          "\"extensions\":{\"MCVISI_assets\":{\"asset\":2}}}]}";

static const char part[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
    "\"mesh\":0}],"
    "\"images\":[{\"uri\":\"data:image/"
    "png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg=="
    "\"}],"
    "\"textures\":[{\"source\":0}],\"materials\":[{\"name\":\"%s\",\"pbrMetallicRoughness\":{"
    "\"baseColorTexture\":{\"index\":0}}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0}"
    "]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"max\":[1,1,0],\"min\":["
    "0,0,0],\"type\":\"VEC3\"},"
    "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":"
    "\"part.bin\"}]}";

static void write_part(const char *material, float size) {
    const float corners[9] = {0, 0, 0, size, 0, 0, 0, size, 0};
    char text[2048];
    snprintf(text, sizeof text, part, material);
    write_file("part.gltf", text);
    FILE *file = fopen("part.bin", "wb");
    assert_true(file && fwrite(corners, sizeof corners, 1, file) == 1);
    assert_int_equal(fclose(file), 0);
}

static void write_box(double width) {
    const double lower[3] = {0, 0, 0}, upper[3] = {width, 2, 3};
    write_box_stl("box.stl", lower, upper);
}

static mcv_scene *load(mcv_asset_cache *kept) {
    mcv_scene *scene;
    mcv_error error;
    if (mcv_scene_load_cached("rig.gltf", (mcv_overrides){NULL, 0}, 0, kept, &scene, &error) !=
        MCV_OK)
        fail_msg("%s", error.text);
    return scene;
}

static void expect_same(const mcv_scene *a, const mcv_scene *b) {
    assert_true(a->fingerprint == b->fingerprint);
    assert_int_equal(a->mesh_count, b->mesh_count);
    assert_int_equal(a->instance_count, b->instance_count);
    assert_int_equal(a->material_count, b->material_count);
    assert_int_equal(a->texture_count, b->texture_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    for (uint32_t i = 0; i < a->texture_count; ++i)
        assert_memory_equal(a->textures[i].rgba, b->textures[i].rgba, 4);
    for (uint32_t i = 0; i < a->material_count; ++i)
        assert_string_equal(a->materials[i].name, b->materials[i].name);
    for (uint32_t i = 0; i < a->instance_count; ++i) {
        assert_int_equal(a->instances[i].material, b->instances[i].material);
        assert_memory_equal(&a->instances[i].to_world, &b->instances[i].to_world,
                            sizeof a->instances[i].to_world);
    }
    for (uint32_t i = 0; i < a->mesh_count; ++i) {
        assert_int_equal(a->meshes[i].vertex_count, b->meshes[i].vertex_count);
        assert_memory_equal(a->meshes[i].positions, b->meshes[i].positions,
                            12 * (size_t)a->meshes[i].vertex_count);
    }
}

/* Loaded with what is kept, without, and after `kept` is gone: the same. */
static void test_same_scene(void **state) {
    (void)state;
    write_file("rig.gltf", rig);
    write_box(1);
    write_part("grey", 1);
    mcv_asset_cache *kept = mcv_asset_cache_new();
    mcv_scene *plain = load(NULL), *first = load(kept), *second = load(kept);
    assert_int_equal(mcv_asset_cache_reads(kept),
                     2); /* box.stl, which is placed twice, and part.gltf */
    mcv_asset_cache_free(kept);
    assert_int_equal(plain->mesh_count, 3);
    assert_int_equal(plain->texture_count, 1);
    expect_same(plain, first);
    expect_same(plain, second);
    mcv_scene_free(plain);
    mcv_scene_free(first);
    mcv_scene_free(second);
}

/* What has changed on disk is read again, and nothing else. */
static void test_changes_are_seen(void **state) {
    (void)state;
    write_file("rig.gltf", rig);
    write_box(1);
    write_part("grey", 1);
    mcv_asset_cache *kept = mcv_asset_cache_new();
    mcv_scene_free(load(kept));
    for (int change = 0; change < 4; ++change) {
        if (change == 0) write_box(5);
        if (change == 1) write_part("grey", 2); /* part.bin */
        if (change == 2) write_part("gray", 2); /* part.gltf, of the same size */
        if (change == 3) rename("part.gltf", "away.gltf");
        mcv_error error, without;
        mcv_scene *scene, *plain;
        if (change == 3) {
            assert_int_equal(mcv_scene_load_cached("rig.gltf", (mcv_overrides){NULL, 0}, 0, kept,
                                                   &scene, &error),
                             MCV_BAD_INPUT);
            assert_int_equal(mcv_scene_load("rig.gltf", (mcv_overrides){NULL, 0}, &plain, &without),
                             MCV_BAD_INPUT);
            assert_string_equal(error.text, without.text);
            break;
        }
        plain = load(NULL);
        scene = load(kept);
        expect_same(plain, scene);
        assert_int_equal(mcv_asset_cache_reads(kept), 3 + change);
        mcv_scene_free(plain);
        mcv_scene_free(scene);
    }
    mcv_asset_cache_free(kept);
}

/* A sweep reads its part once. */
static void test_sweep(void **state) {
    (void)state;
    write_box(4);
    program_well("new telecentric box.stl --unit mm -o box.gltf");
    json_t *report = program_json("sweep box.gltf --vary sensors/camera/fNumber=4,8,11 --metric "
                                  "mean --resolution 16x16 --spp 4 --json");
    assert_true(number_at(report, "rows") == 3 && number_at(report, "failed") == 0 &&
                number_at(report, "assets_read") == 1);
    json_decref(report);
    /* Another part is another sweep. */
    write_box(5);
    program_fails("sweep box.gltf --vary sensors/camera/fNumber=4,8,11 --metric mean --resolution "
                  "16x16 --spp 4 --resume",
                  3, "box.gltf or a file that it names has changed");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_scene),
        cmocka_unit_test(test_changes_are_seen),
        cmocka_unit_test(test_sweep),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
