/* SPDX-License-Identifier: Apache-2.0 */
/* Names in files and paths may hold anything: nothing of it controls a terminal, and JSON stays
 * JSON. */
#include "test.h"

#include "program.h"

#include "core/basics.h"

/* An escape sequence, a C1 control, a line that looks like a message, a change of direction. */
#define NAME "n\\u001b[31m\\u009b2J\\nmcvisi: error: no\\r\\u202e\\u007f"

static const char *const scene =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"extensionsUsed\":[\"" NAME "\"],"
    "\"nodes\":[{\"name\":\"" NAME "\",\"mesh\":0},"
    "{\"camera\":0,\"name\":\"" NAME
    "\",\"translation\":[0,0,5],\"extensions\":{\"MCVISI_emitters\":"
    "{\"emitter\":0}}}],"
    "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"" NAME "\",\"type\":\"%s\","
    "\"radiance\":1}]}},"
    "\"cameras\":[{\"name\":\"" NAME "\",\"type\":\"perspective\",\"perspective\":{\"yfov\":1,"
    "\"znear\":1}}],\"materials\":[{\"name\":\"" NAME "\"}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
    "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
    "\"meshes\":[{\"name\":\"" NAME "\",\"primitives\":[{\"material\":0,\"attributes\":{"
    "\"POSITION\":0}}]}]}";

/* What the last run said must be UTF-8 without control characters but line feeds, and no line of it
 * may begin as the name does. */
static void must_be_plain(const char *line) {
    for (const char *c = said; *c;) {
        uint32_t code;
        const int length = mcv_character(c, &code);
        if (length == 0 || (code < 0x20 && code != '\n') || (code >= 0x7f && code < 0xa0) ||
            code == 0x202e)
            fail_msg("mcvisi %s: byte 0x%02x at %zu: %s", line, (unsigned char)*c,
                     (size_t)(c - said), said);
        c += length;
    }
    if (strstr(said, "\nmcvisi: error: no")) fail_msg("mcvisi %s: a forged line: %s", line, said);
}

static void write_scene(const char *name, const char *type) {
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fprintf(file, scene, type);
    fclose(file);
}

static void test_names(void **state) {
    (void)state;
    write_scene("plain.gltf", "environment");
    write_scene("wrong.gltf", NAME);
    static const char *const lines[] = {
        "check plain.gltf",
        "check --json plain.gltf",
        "render plain.gltf --device reference --resolution 4x4 --spp 1 -o out.exr",
        "render plain.gltf --device reference --resolution 4x4 --spp 1 -o out.exr --json",
        "measure out.exr --json",
        "measure out.exr",
        "trace plain.gltf --rays rays.csv",
        "check wrong.gltf",
        "check plain.gltf --set emitters/n=1",
        "check plain.gltf --sensor $(printf 'a\\033[2Jb\\233')",
        "$(printf 'a\\033[2Jb\\233')",
        "check --$(printf 'a\\033[2Jb\\233')"};
    FILE *rays = fopen("rays.csv", "w");
    fputs("0.1 0.1 4 0 0 -1\n", rays);
    fclose(rays);
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        program(lines[i]);
        must_be_plain(lines[i]);
    }
}

/* A path need not be UTF-8: it is opened, and told with U+FFFD. */
static void test_paths(void **state) {
    (void)state;
    write_scene("plain.gltf", "environment");
    assert_int_equal(rename("plain.gltf", "p\xff\x9bq.gltf"), 0);
    json_t *report = program_json("check --json $(printf 'p\\377\\233q.gltf')");
    assert_string_equal(json_string_value(json_object_get(report, "scene")),
                        "p\xef\xbf\xbd\xef\xbf\xbdq.gltf");
    json_decref(report);
    program_well("check $(printf 'p\\377\\233q.gltf')");
    must_be_plain("check");
    assert_non_null(strstr(said, "p\\xff\\x9bq.gltf"));
    program_fails("check $(printf 'no\\377.gltf')", 3, "no\\xff.gltf");
}

/* Numbers that kernels cannot multiply are no scene. */
static void test_extents(void **state) {
    (void)state;
    write_scene("plain.gltf", "environment");
    program_fails("check plain.gltf --set nodes/0/scale=[1e300,1,1]", 3, "may reach to 1e+12 m");
    program_fails("check plain.gltf --set nodes/1/translation=[0,0,1e13]", 3, "may reach to");
    program_well("check plain.gltf --set nodes/0/scale=[1e11,1e11,1e11]");
}

/* Drivers need addresses: that the limit is too low must be said. */
static void test_limit_of_addresses(void **state) {
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    skip(); /* the sanitizer itself needs more of them */
#endif
    char command[512];
    snprintf(command, sizeof command, "ulimit -v 200000; " MCV_BINARY_DIR "/mcvisi devices 2>&1");
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    said[fread(said, 1, sizeof said - 1, pipe)] = '\0';
    pclose(pipe);
    if (!strstr(said, "within the limit of the address space")) fail_msg("%s", said);
}

/* Values of any length leave room for what is wrong. The shell makes them. */
static void test_long_values(void **state) {
    (void)state;
    static const char *const values[] = {"x", "1,2,"};
    for (int i = 0; i < 2; ++i) {
        char line[256];
        snprintf(line, sizeof line,
                 "render s.gltf --sampler $(yes '%s' | head -8000 | tr -d '\\n')", values[i]);
        program_fails(line, 2, "…: must be one of ");
        snprintf(line, sizeof line, "render s.gltf --spp $(yes '%s' | head -8000 | tr -d '\\n')",
                 values[i]);
        program_fails(line, 2, "…: must be an integer from 1");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_names, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_long_values, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_paths, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_extents, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_limit_of_addresses, enter_folder, leave_folder)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
