/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A scene's programs hold nothing of the elements that it lacks: preprocessed with every unused
 * element's header replaced by an empty file they are the same text. To see that the comparison
 * sees, a used header is emptied too: the text changes.
 */
#include "test.h"

#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cl/flatten.h"
#include "device/features.h"
#include "device/pack.h"
#include "render/render.h"
#include "loader/load.h"

static char root[64]; /* a copy of the sources of the programs */

static const char *const programs[] = {"schedule/tile", "schedule/stream", "schedule/trace"};
enum { PROGRAMS = sizeof programs / sizeof programs[0] };

/* The headers of elements, and which features need them; 0: none does, the device knows nothing of
 * it. */
static const struct {
    const char *path;
    uint64_t features;
} element_headers[] = {
    {"sensors/laser_triangulation.h", 0}, /* a thin lens to the device */
    {"emitters/parallel.h", MCV_FEATURE_BIT(PARALLEL)},
    {"emitters/telecentric_projector.h", 0},
    {"emitters/light_field.h", MCV_FEATURE_BIT(LIGHT_FIELD)},
    {"emitters/projector.h", MCV_FEATURE_BIT(PROJECTOR)},
    {"emitters/area.h", MCV_FEATURE_BIT(AREA)},
    {"emitters/screen.h", MCV_FEATURE_BIT(AREA)},
    {"emitters/environment.h", MCV_FEATURE_BIT(ENVIRONMENT_IMAGE)},
    {"emitters/collimated_beam.h", MCV_FEATURE_BIT(BEAM)},
    {"emitters/laser.h", MCV_FEATURE_BIT(LASER)},
    {"emitters/point.h", MCV_FEATURE_BIT(PUNCTUAL)},
    {"emitters/spot.h", MCV_FEATURE_BIT(PUNCTUAL)},
    {"emitters/directional.h", MCV_FEATURE_BIT(PUNCTUAL)},
    {"materials/diffuse.h", MCV_FEATURE_BIT(DIFFUSE)},
    {"materials/dielectric.h", 0},
    {"materials/sheet.h", MCV_FEATURE_BIT(SHEET)},
    {"materials/mirror.h", 0},
    {"materials/beam_splitter.h", MCV_FEATURE_BIT(SHEET)},
    {"materials/conductor.h", 0},
    {"materials/metallic_roughness.h", 0},
    {"materials/microfacet.h", MCV_FEATURE_BIT(GLOSSY)},
    {"materials/brushed.h", MCV_FEATURE_BIT(GLOSSY)},
    {"materials/retroreflector.h", MCV_FEATURE_BIT(REFLECTOR)},
    {"materials/absorber.h", 0},
    {"sensors/distortion.h", MCV_FEATURE_BIT(DISTORTION)},
    {"sensors/aperture.h", MCV_FEATURE_BIT(APERTURE)},
    {"motion.h", MCV_FEATURE_BIT(MOTION)},
};

static const char *const sensor_headers[] = {
#define MCV_X(name, key, NAME) "sensors/" #name ".h",
    MCV_SENSORS(MCV_X)
#undef MCV_X
};

/* What all elements of a kind share. */
static const char *const shared_headers[] = {"sensors/sensor.h", "emitters/emitter.h",
                                             "materials/material.h"};

static void run(const char *format, const char *a) {
    char command[512];
    assert_true(snprintf(command, sizeof command, format, a, root) < (int)sizeof command);
    if (system(command) != 0) fail_msg("%s failed", command);
}

static int make_root(void **state) {
    (void)state;
    strcpy(root, "test_specialise.XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}

static int remove_root(void **state) {
    (void)state;
    run("rm -rf %.0s%s", "");
    return 0;
}

static void restore_sources(void) {
    run("cp -r '%s/kernels' %s/", MCV_SOURCE_DIR);
    run("cp -r '%s/include' %s/", MCV_SOURCE_DIR);
}

static void empty_header(const char *path) {
    char name[256];
    snprintf(name, sizeof name, "%s/include/mcvisi/%s", root, path);
    if (truncate(name, 0) != 0) fail_msg("%s cannot be emptied", name);
}

/* The program's text after the preprocessor, white space squeezed. The caller frees it. */
static char *preprocess(const char *program, const char *options) {
    char command[2048], path[128];
    char *source = NULL, *text = NULL;
    size_t size = 0;
    mcv_error error = {""};
    if (mcv_flatten(root, program, &source, &error) != MCV_OK) fail_msg("%s", error.text);
    snprintf(path, sizeof path, "%s/program.cl", root);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(source, file) >= 0);
    assert_int_equal(fclose(file), 0);
    free(source);
    assert_true(snprintf(command, sizeof command, "%s -E -P -x c -D__OPENCL_VERSION__=120 %s %s",
                         MCV_C_COMPILER, options, path) < (int)sizeof command);
    FILE *preprocessor = popen(command, "r");
    FILE *memory = open_memstream(&text, &size);
    assert_non_null(preprocessor);
    assert_non_null(memory);
    bool space = false;
    for (int c; (c = fgetc(preprocessor)) != EOF; space = isspace(c))
        if (!isspace(c) || !space) fputc(isspace(c) ? ' ' : c, memory);
    fclose(memory);
    if (pclose(preprocessor) != 0) fail_msg("%s failed", command);
    assert_non_null(strstr(text, "__kernel"));
    return text;
}

static void fail_at_difference(const char *what, const char *program, const char *full,
                               const char *spare) {
    size_t at = 0;
    while (full[at] && full[at] == spare[at]) ++at;
    const size_t from = at > 60 ? at - 60 : 0;
    fail_msg("%s: %s.cl holds what it does not need: ...%.160s...", what, program, full + from);
}

static void expect_nothing_unneeded(const char *what, uint64_t features, uint32_t channels,
                                    uint32_t sensor) {
    char options[2048];
    char *full[PROGRAMS];
    mcv_feature_defines(features, channels, sensor, MCV_SAMPLER_SOBOL, 256, options,
                        sizeof options);
    restore_sources();
    for (int p = 0; p < PROGRAMS; ++p) full[p] = preprocess(programs[p], options);
    /* Of light paths, which belong to no element. */
    static const char *const light[] = {"mcv_splat(", "mcv_update_path_class", "_invert(",
                                        "_connect(",  "_footprint(",           "_emit("};
    enum { OF_LIGHT = sizeof light / sizeof light[0] };
    for (int p = 0; p < PROGRAMS * OF_LIGHT; ++p)
        if (!(features & MCV_FEATURE_BIT(LIGHT_TRACING)) &&
            strstr(full[p / OF_LIGHT], light[p % OF_LIGHT]))
            fail_msg("%s: %s.cl holds %s without light-tracing", what, programs[p / OF_LIGHT],
                     light[p % OF_LIGHT]);
    for (int p = 0; p < PROGRAMS; ++p)
        if (!(features & MCV_FEATURE_BIT(MIXED)) && strstr(full[p], "mcv_dvec"))
            fail_msg("%s: %s.cl computes in double", what, programs[p]);
    for (size_t i = 0; i < sizeof element_headers / sizeof element_headers[0]; ++i)
        if (!(element_headers[i].features & features)) empty_header(element_headers[i].path);
    for (uint32_t s = 0; s < MCV_SENSOR_COUNT; ++s)
        if (s != sensor) empty_header(sensor_headers[s]);
    for (int p = 0; p < PROGRAMS; ++p) {
        char *spare = preprocess(programs[p], options);
        if (strcmp(full[p], spare) != 0) fail_at_difference(what, programs[p], full[p], spare);
        free(spare);
        free(full[p]);
    }
}

/* Every header of an element has its place in the tables above. */
static void test_headers_are_known(void **state) {
    (void)state;
    static const char *const folders[] = {"sensors", "emitters", "materials"};
    for (int f = 0; f < 3; ++f) {
        char path[512];
        snprintf(path, sizeof path, MCV_SOURCE_DIR "/include/mcvisi/%s", folders[f]);
        DIR *directory = opendir(path);
        assert_non_null(directory);
        for (struct dirent *entry; (entry = readdir(directory));) {
            bool known = entry->d_name[0] == '.';
            snprintf(path, sizeof path, "%s/%s", folders[f], entry->d_name);
            for (size_t i = 0; i < sizeof element_headers / sizeof element_headers[0]; ++i)
                known = known || strcmp(path, element_headers[i].path) == 0;
            for (size_t i = 0; i < MCV_SENSOR_COUNT; ++i)
                known = known || strcmp(path, sensor_headers[i]) == 0;
            for (size_t i = 0; i < sizeof shared_headers / sizeof shared_headers[0]; ++i)
                known = known || strcmp(path, shared_headers[i]) == 0;
            if (!known) fail_msg("%s: say in this test which features need it", path);
        }
        closedir(directory);
    }
}

static void test_shipped_scenes(void **state) {
    (void)state;
    int count = 0;
    DIR *directory = opendir(MCV_SOURCE_DIR "/scenes");
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char path[512];
        mcv_scene *scene;
        mcv_packed packed;
        mcv_error error = {""};
        const char *ending = strrchr(entry->d_name, '.');
        if (!ending || (strcmp(ending, ".gltf") != 0 && strcmp(ending, ".glb") != 0)) continue;
        if (strcmp(entry->d_name, "2CylinderEngine.glb") == 0)
            continue; /* a part, not a scene of its own */
        snprintf(path, sizeof path, MCV_SOURCE_DIR "/scenes/%s", entry->d_name);
        if (mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &error) != MCV_OK)
            fail_msg("%s", error.text);
        if (mcv_pack_for_features(scene, &packed, &error) != MCV_OK) fail_msg("%s", error.text);
        for (uint32_t s = 0; s < scene->sensor_count; ++s, ++count)
            expect_nothing_unneeded(entry->d_name, packed.features, packed.channels,
                                    scene->sensors[s].type);
        mcv_packed_free(&packed);
        mcv_scene_free(scene);
    }
    closedir(directory);
    assert_true(count > 0);
}

static void test_single_features(void **state) {
    (void)state;
    static const char *const words[] = {
#define MCV_X(NAME, word, why) word,
        MCV_FEATURES(MCV_X)
#undef MCV_X
    };
    for (uint32_t i = 0; i < MCV_FEATURE_COUNT; ++i)
        expect_nothing_unneeded(words[i], UINT64_C(1) << i, 1 + 2 * (i & 1), i % MCV_SENSOR_COUNT);
}

static void test_a_needed_header_is_missed(void **state) {
    (void)state;
    const uint64_t all = MCV_ALL_FEATURES;
    char options[2048], lens_options[2048];
    mcv_feature_defines(all, 3, MCV_SENSOR_LIGHT_FIELD, MCV_SAMPLER_SOBOL, 256, options,
                        sizeof options);
    /* Light field cameras have neither distortion nor such apertures. */
    mcv_feature_defines(all, 3, MCV_SENSOR_THIN_LENS, MCV_SAMPLER_SOBOL, 256, lens_options,
                        sizeof lens_options);
    restore_sources();
    char *full = preprocess("schedule/tile", options),
         *lens = preprocess("schedule/tile", lens_options);
    for (size_t i = 0; i < sizeof element_headers / sizeof element_headers[0]; ++i) {
        const bool of_lens = strncmp(element_headers[i].path, "sensors/", 8) == 0;
        if (element_headers[i].features == 0) continue;
        empty_header(element_headers[i].path);
        char *without = preprocess("schedule/tile", of_lens ? lens_options : options);
        if (strcmp(of_lens ? lens : full, without) == 0)
            fail_msg("%s: nobody misses it", element_headers[i].path);
        free(without);
        restore_sources();
    }
    free(lens);
    empty_header(sensor_headers[MCV_SENSOR_LIGHT_FIELD]);
    char *without = preprocess("schedule/tile", options);
    assert_string_not_equal(full, without);
    free(without);
    free(full);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_headers_are_known),
        cmocka_unit_test(test_shipped_scenes),
        cmocka_unit_test(test_single_features),
        cmocka_unit_test(test_a_needed_header_is_missed),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
