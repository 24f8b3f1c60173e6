/* SPDX-License-Identifier: Apache-2.0 */
/* Findings of check --strict against those of Khronos' validator: code and JSON pointer of each. */
#include "test.h"

#include "program.h"
#include "strict/strict.h"

#include <ftw.h>
#include <time.h>

static const uint64_t most = 100000000;

/* Files where the two part, with the reason. */
static const struct {
    const char *path, *reason;
} exceptions[] = {{"camera/infinite_znear.gltf",
                   "1e309 is no number to this program's JSON reader: the file is INVALID_JSON"}};

static bool is_exception(const char *path) {
    for (size_t i = 0; i < sizeof exceptions / sizeof exceptions[0]; ++i)
        if (strstr(path, exceptions[i].path)) return true;
    return false;
}

static bool has(const mcv_strict_findings *f, const char *code, const char *pointer) {
    for (size_t i = 0; i < f->count; ++i)
        if (strcmp(f->items[i].code, code) == 0 && strcmp(f->items[i].pointer, pointer) == 0)
            return true;
    return false;
}

static size_t compared, agreed;

/* Compares with the errors of a report, [{"code", "pointer"}]. */
static void compare(const char *path, const json_t *errors) {
    mcv_strict_findings f;
    mcv_error error;
    char wrong[4096] = "";
    if (mcv_strict_check(path, most, &f, &error) != MCV_OK) fail_msg("%s: %s", path, error.text);
    for (size_t i = 0; i < json_array_size(errors); ++i) {
        const json_t *e = json_array_get(errors, i);
        const char *code = json_string_value(json_object_get(e, "code")),
                   *pointer = json_string_value(json_object_get(e, "pointer"));
        if (!has(&f, code, pointer && strcmp(pointer, "/") != 0 ? pointer : ""))
            snprintf(wrong + strlen(wrong), sizeof wrong - strlen(wrong), "\n  lacks %s %s", code,
                     pointer ? pointer : "");
    }
    for (size_t i = 0; i < f.count; ++i) {
        bool known = false;
        for (size_t k = 0; k < json_array_size(errors); ++k) {
            const json_t *e = json_array_get(errors, k);
            const char *pointer = json_string_value(json_object_get(e, "pointer"));
            const char *place = pointer && strcmp(pointer, "/") != 0 ? pointer : "";
            known = known ||
                    (strcmp(f.items[i].code, json_string_value(json_object_get(e, "code"))) == 0 &&
                     strcmp(f.items[i].pointer, place) == 0);
        }
        if (!known)
            snprintf(wrong + strlen(wrong), sizeof wrong - strlen(wrong), "\n  has %s %s: %s",
                     f.items[i].code, f.items[i].pointer, f.items[i].text);
    }
    mcv_strict_free(&f);
    ++compared;
    agreed += !wrong[0];
    if (wrong[0] && !is_exception(path)) fail_msg("%s%s", path, wrong);
    if (!wrong[0] && is_exception(path)) fail_msg("%s is no exception any more", path);
}

/* khronos/findings.txt: a file, then its findings, each behind a tab. */
static void test_subset(void **state) {
    (void)state;
    FILE *list = fopen(MCV_SOURCE_DIR "/tests/strict/khronos/findings.txt", "r");
    char line[1024], path[2048] = "";
    json_t *errors = json_array();
    assert_non_null(list);
    compared = agreed = 0;
    while (fgets(line, sizeof line, list)) {
        line[strcspn(line, "\n")] = '\0';
        if (line[0] == '#') continue;
        if (line[0] == '\t') {
            char *pointer = strchr(line, ' ');
            if (pointer) *pointer++ = '\0';
            json_array_append_new(errors, json_pack("{s:s, s:s}", "code", line + 1, "pointer",
                                                    pointer ? pointer : ""));
            continue;
        }
        if (path[0]) compare(path, errors);
        json_array_clear(errors);
        snprintf(path, sizeof path, "%s/tests/strict/khronos/%s", MCV_SOURCE_DIR, line);
    }
    compare(path, errors);
    json_decref(errors);
    fclose(list);
    print_message("%zu files, %zu as Khronos' validator says\n", compared, agreed);
    assert_true(compared > 100);
}

static int compare_report(const char *path, const struct stat *status, int type, struct FTW *ftw) {
    const char *suffix = strstr(path, ".report.json");
    (void)status;
    (void)ftw;
    if (type != FTW_F || !suffix || suffix[12]) return 0;
    char file[1024];
    snprintf(file, sizeof file, "%.*s", (int)(suffix - path), path);
    json_t *report = json_load_file(path, 0, NULL), *errors = json_array();
    const json_t *messages = json_object_get(json_object_get(report, "issues"), "messages");
    for (size_t i = 0; i < json_array_size(messages); ++i) {
        json_t *message = json_array_get(messages, i);
        if (json_integer_value(json_object_get(message, "severity")) == 0)
            json_array_append(errors, message);
    }
    compare(file, errors);
    json_decref(errors);
    json_decref(report);
    return 0;
}

static void test_all_reports(void **state) {
    (void)state;
    const char *folder = MCV_SOURCE_DIR "/../shared/data/gltf-validator";
    if (access(folder, R_OK) != 0) folder = MCV_SOURCE_DIR "/../../shared/data/gltf-validator";
    if (access(folder, R_OK) != 0) skip();
    compared = agreed = 0;
    nftw(folder, compare_report, 16, FTW_PHYS);
    print_message("%zu files, %zu as Khronos' validator says\n", compared, agreed);
    assert_true(compared > 0 && (double)agreed >= 0.98 * (double)compared);
}

static char *whole(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *bytes = calloc(1, 1 << 20);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    return bytes;
}

/* Damaged files: findings or none, and no crash. */
static void test_damaged(void **state) {
    (void)state;
    static const char *const files[] = {"base/mesh/uv.gltf",
                                        "base/glb/valid_buffer.glb",
                                        "base/skin/no_common_root.gltf",
                                        "base/accessor_data/out_of_range_elements_sint16.gltf",
                                        "base/animation/sampler_output_count_invalid.gltf",
                                        "ext/KHR_materials_variants/primitive/non_unique.gltf"};
    static const char letters[] = "0123456789[]{}\",:.-eE \x7f\xff";
    uint32_t seed = 1;
    size_t found = 0;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        char path[1024];
        size_t size;
        snprintf(path, sizeof path, "%s/tests/strict/khronos/%s", MCV_SOURCE_DIR, files[i]);
        char *bytes = whole(path, &size);
        const char *name = strstr(path, ".glb") ? "damaged.glb" : "damaged.gltf";
        for (int run = 0; run < 500; ++run) {
            char *copy = malloc(size);
            memcpy(copy, bytes, size);
            for (int k = 0; k < 2; ++k) {
                seed = seed * 1664525 + 1013904223;
                copy[(seed >> 8) % size] = letters[(seed >> 3) % (sizeof letters - 1)];
            }
            FILE *file = fopen(name, "wb");
            fwrite(copy, 1, size, file);
            fclose(file);
            free(copy);
            mcv_strict_findings f;
            mcv_error error;
            if (mcv_strict_check(name, most, &f, &error) != MCV_OK) fail_msg("%s", error.text);
            found += f.count;
            mcv_strict_free(&f);
        }
        free(bytes);
    }
    assert_true(found > 1000);
}

/* A document of one primitive with the attributes _0 … of accessors 0 … (all of accessor 0 where
 * they are `same`), all in one view; or with as many mappings of variants. */
static json_t *wide_document(int count, bool same, bool mappings) {
    json_t *attributes = json_object(), *accessors = json_array(), *list = json_array();
    for (int i = 0; i < count; ++i) {
        char name[16];
        snprintf(name, sizeof name, "_%d", i);
        if (!mappings) json_object_set_new(attributes, name, json_integer(same ? 0 : i));
        if (!mappings && (i == 0 || !same))
            json_array_append_new(accessors,
                                  json_pack("{s:i, s:i, s:i, s:s}", "bufferView", 0,
                                            "componentType", 5126, "count", 1, "type", "SCALAR"));
        if (mappings)
            json_array_append_new(list, json_pack("{s:i, s:[i]}", "material", 0, "variants", i));
    }
    return json_pack("{s:{s:s}, s:o, s:[{s:i, s:i}], s:[{s:[{s:o, s:{s:{s:o}}}]}]}", "asset",
                     "version", "2.0", "accessors", accessors, "bufferViews", "buffer", 0,
                     "byteLength", 4, "meshes", "primitives", "attributes", attributes,
                     "extensions", "KHR_materials_variants", "mappings", list);
}

/* Findings of this code in a document, as "/place /place …" without the primitive's own. */
static void places_of(const json_t *root, const char *code, char places[1024]) {
    static const char primitive[] = "/meshes/0/primitives/0";
    mcv_strict_findings f;
    mcv_error error;
    if (mcv_strict_check_document("wide.gltf", root, (mcv_bytes){NULL, 0}, most, &f, &error) !=
        MCV_OK)
        fail_msg("%s", error.text);
    places[0] = '\0';
    for (size_t i = 0; i < f.count; ++i) {
        if (strcmp(f.items[i].code, code) != 0) continue;
        assert_memory_equal(f.items[i].pointer, primitive, sizeof primitive - 1);
        const size_t length = strlen(places);
        snprintf(places + length, 1024 - length, "%s%s", length ? " " : "",
                 f.items[i].pointer + sizeof primitive - 1);
    }
    mcv_strict_free(&f);
}

/* A view without a byteStride holds one accessor, whatever the attributes of it. */
static void test_shared_views(void **state) {
    (void)state;
    static const struct {
        int accessors[6];
        const char *places;
    } cases[] = {{{0, 0, 0, 0, 0, 0}, ""},
                 {{0, 1, 2, 0, 1, 2}, ""}, /* in views of their own */
                 {{0, 0, 3, 1, 3, 0}, "/attributes/_2 /attributes/_4 /attributes/_5"},
                 {{0, 9, 4, 5, 5, 4}, "/attributes/_3 /attributes/_4 /attributes/_5"},
                 {{7, 8, 7, 6, 6, 6}, ""}, /* with a byteStride; without a view */
                 {{1, 2, 4, 5, 0, 3}, "/attributes/_3 /attributes/_5"}};
    static const int views[] = {0, 1, 2, 0, 3, 3, -1, 4, 4};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        char places[1024];
        json_t *root = wide_document(6, true, false), *accessors = json_array(),
               *all = json_array();
        json_t *primitive = json_array_get(
            json_object_get(json_array_get(json_object_get(root, "meshes"), 0), "primitives"), 0);
        json_t *attributes = json_object_get(primitive, "attributes");
        for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i)
            json_array_append_new(accessors, views[i] < 0
                                                 ? json_object()
                                                 : json_pack("{s:i}", "bufferView", views[i]));
        for (int i = 0; i < 5; ++i)
            json_array_append_new(all,
                                  i == 4 ? json_pack("{s:i}", "byteStride", 4) : json_object());
        for (int i = 0; i < 6; ++i) {
            char name[16];
            snprintf(name, sizeof name, "_%d", i);
            json_object_set_new(attributes, name, json_integer(cases[c].accessors[i]));
        }
        json_object_set_new(root, "accessors", accessors);
        json_object_set_new(root, "bufferViews", all);
        places_of(root, "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", places);
        assert_string_equal(places, cases[c].places);
        json_decref(root);
    }
}

/* A variant may stand twice in one mapping, but not in another, too. */
static void test_shared_variants(void **state) {
    (void)state;
#define PLACE "/extensions/KHR_materials_variants/mappings/"
    static const struct {
        const char *mappings, *places;
    } cases[] = {
        {"[[0,0],[1,2],[3]]", ""},
        {"[[0,1],[2,1],[0,0]]", PLACE "1/variants/1 " PLACE "2/variants/0 " PLACE "2/variants/1"},
        {"[[0],[0.0],[-0.0],[1.5],[\"0\"],[0]]", PLACE "2/variants/0 " PLACE "5/variants/0"},
        {"[[{\"a\":1,\"b\":[]}],[{\"b\":[],\"a\":1}],[null],[true],[null]]",
         PLACE "1/variants/0 " PLACE "4/variants/0"}};
#undef PLACE
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        char places[1024];
        json_t *root = wide_document(0, true, true), *all = json_loads(cases[c].mappings, 0, NULL);
        json_t *primitive = json_array_get(
            json_object_get(json_array_get(json_object_get(root, "meshes"), 0), "primitives"), 0);
        json_t *list = json_object_get(
            json_object_get(json_object_get(primitive, "extensions"), "KHR_materials_variants"),
            "mappings");
        for (size_t i = 0; i < json_array_size(all); ++i)
            json_array_append_new(list, json_pack("{s:O}", "variants", json_array_get(all, i)));
        places_of(root, "KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT", places);
        assert_string_equal(places, cases[c].places);
        json_decref(all);
        json_decref(root);
    }
}

/* Seconds of processor time of a check. */
static double seconds_for(int count, bool same, bool mappings) {
    json_t *root = wide_document(count, same, mappings);
    mcv_strict_findings f;
    mcv_error error;
    struct timespec begin, end;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    assert_int_equal(
        mcv_strict_check_document("wide.gltf", root, (mcv_bytes){NULL, 0}, most, &f, &error),
        MCV_OK);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    mcv_strict_free(&f);
    json_decref(root);
    return (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
}

/* Eight times as many attributes or mappings take eight times as long, not 64 times. Half way
 * between, as times vary. */
static void test_time_of_wide_primitives(void **state) {
    (void)state;
    static const struct {
        const char *what;
        bool same, mappings;
    } kinds[] = {{"attributes of one accessor", true, false},
                 {"attributes that share a view", false, false},
                 {"mappings of variants", false, true}};
    for (size_t i = 0; i < 3; ++i) {
        const double few = seconds_for(2000, kinds[i].same, kinds[i].mappings),
                     many = seconds_for(16000, kinds[i].same, kinds[i].mappings);
        print_message("2000 %s: %.2g s, 16000: %.2g s\n", kinds[i].what, few, many);
        if (many > 22 * few) fail_msg("%s: 2000 take %g s, 16000 %g s", kinds[i].what, few, many);
    }
}

static void test_program(void **state) {
    (void)state;
    const char *uv = "check --strict " MCV_SOURCE_DIR "/tests/strict/khronos/base/mesh/uv.gltf";
    program_fails(uv, 3, "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS /meshes/0/primitives/0/material: its");
    program_fails(uv, 3, "uv.gltf: the file has 7 findings");
    program_well("check --strict " MCV_SOURCE_DIR "/scenes/beam.gltf");
    assert_string_equal(said, "no findings\n");
    program_well("check --strict --json " MCV_SOURCE_DIR "/scenes/furnace.glb");
    json_t *report = json_loads(said, 0, NULL);
    assert_int_equal(json_array_size(json_object_get(report, "strict")), 0);
    assert_true(json_is_array(json_object_get(report, "strict")));
    json_decref(report);
    program_fails("check --strict", 2, "SCENE is missing");
    program_fails("check --strict nosuch.gltf", 3, "nosuch.gltf");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_subset),
        cmocka_unit_test(test_all_reports),
        cmocka_unit_test(test_shared_views),
        cmocka_unit_test(test_shared_variants),
        cmocka_unit_test(test_time_of_wide_primitives),
        cmocka_unit_test_setup_teardown(test_damaged, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_program, enter_folder, leave_folder)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
