/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi defect and mcv_rig_add_defect: the rig that they make, what they tell, and what they
 * refuse. No OpenCL device is needed. */
#include "api.h"

#include "program.h"

#include <math.h>

/* A plate of one triangle in the plane z = 0, with corners (0, 0), (40, 0) and (0, 40) mm, and a
 * telecentric camera above it whose pixels see 0.1 mm. */
static const char rig_text[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1]}],"
    " \"extensionsUsed\": [\"MCVISI_sensors\"],"
    " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": ["
    "{\"name\": \"camera\", \"type\": \"telecentric\", \"magnification\": 0.1, "
    "\"workingDistance\": \"100mm\", \"fNumber\": 8, \"resolution\": [800, 800], "
    "\"pixelSize\": \"10um\"}]}},"
    " \"buffers\": [{\"byteLength\": 36, \"uri\": \"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAACtcjPQAAAAAAAAAAAAAAAArXIz0AAAAA\"}],"
    " \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}],"
    " \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, "
    "\"type\": \"VEC3\", \"min\": [0, 0, 0], \"max\": [0.04, 0.04, 0]}],"
    " \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}],"
    " \"nodes\": [{\"name\": \"plate\", \"mesh\": 0},"
    "{\"name\": \"eye\", \"translation\": [0, 0, 0.1], "
    "\"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}}]}";

static json_t *document(const mcv_rig *rig, const char *path) {
    char *text = NULL;
    WELL(mcv_rig_get(rig, path, &text, &error));
    json_t *value = json_loads(text, JSON_DECODE_ANY, NULL);
    mcv_text_free(text);
    assert_non_null(value);
    return value;
}

static mcv_rig *new_rig(void) {
    mcv_rig *rig = NULL;
    WELL(mcv_rig_parse(rig_text, strlen(rig_text), ".", &rig, &error));
    return rig;
}

/* What is given stands in the document as it was given; the report is in SI units. */
static void adds_defects(void **state) {
    mcv_rig *rig = new_rig();
    char *text = NULL;
    (void)state;
    WELL(mcv_rig_add_defect(rig, "dent",
                            "{\"node\": \"plate\", \"at\": \"10mm,5mm,0\", \"size\": \"0.8mm\"}",
                            &text, &error));
    json_t *report = json_loads(text, 0, NULL);
    mcv_text_free(text);
    assert_string_equal(json_string_value(json_object_get(report, "defect")), "dent-1");
    const double position[3] = {0.01, 0.005, 0}, normal[3] = {0, 0, 1};
    for (int i = 0; i < 3; ++i) {
        char path[32];
        snprintf(path, sizeof path, "position/%d", i);
        assert_true(fabs(number_at(report, path) - position[i]) < 1e-9);
        snprintf(path, sizeof path, "normal/%d", i);
        assert_true(fabs(number_at(report, path) - normal[i]) < 1e-9);
    }
    assert_true(fabs(number_at(report, "depth") - 8e-5) < 1e-12);
    assert_true(number_at(report, "triangles") > 1000);
    assert_null(json_object_get(report, "notes"));
    json_decref(report);
    WELL(mcv_rig_add_defect(rig, "dent",
                            "{\"node\": \"plate\", \"triangle\": \"0,0.2,0.3,0.5\", "
                            "\"size\": \"1mm\", \"with\": [\"shape=cosine\"]}",
                            NULL, &error));
    json_t
        *defects = document(rig, "defects"),
        *wanted = json_loads(
            "[{\"name\": \"dent-1\", \"type\": \"dent\", \"node\": \"plate\", \"size\": \"0.8mm\","
            " \"at\": [\"10mm\", \"5mm\", \"0\"]},"
            "{\"name\": \"dent-2\", \"type\": \"dent\", \"node\": \"plate\", \"size\": \"1mm\","
            " \"triangle\": 0, \"barycentric\": [0.2, 0.3, 0.5], \"shape\": \"cosine\"}]",
            0, NULL);
    if (!json_equal(defects, wanted)) fail_msg("%s", json_dumps(defects, 0));
    json_decref(defects);
    json_decref(wanted);
    json_t *used = document(rig, "");
    assert_int_equal(json_array_size(json_object_get(used, "extensionsUsed")), 2);
    json_decref(used);
    mcv_rig_free(rig);
}

/* After a failure the rig is as it was. */
static void refuses(const char *type, const char *options, mcv_result code, const char *words) {
    mcv_rig *rig = new_rig();
    mcv_error error = {""};
    json_t *before = document(rig, "");
    char *text = (char *)1;
    const mcv_result result = mcv_rig_add_defect(rig, type, options, &text, &error);
    if (result != code || text || !strstr(error.text, words) || strchr(error.text, '\n'))
        fail_msg("%s %s: %d \"%s\", must be %d \"%s\"", type, options, result, error.text, code,
                 words);
    json_t *after = document(rig, "");
    assert_true(json_equal(before, after));
    json_decref(before);
    json_decref(after);
    mcv_rig_free(rig);
}

static void refuses_bad_input(void **state) {
    (void)state;
    refuses("dint", "{\"node\": \"plate\", \"at\": \"0,0,0\"}", MCV_USAGE, "did you mean dent?");
    refuses("dent", "{\"at\": \"0,0,0\", \"size\": \"1mm\"}", MCV_USAGE, "--node is missing");
    refuses("dent", "{\"node\": \"plate\", \"size\": \"1mm\"}", MCV_USAGE, "--triangle");
    refuses("dent", "{\"node\": \"plate\", \"at\": \"0,0,0\", \"triangle\": \"0\"}", MCV_USAGE,
            "not by both");
    refuses("dent", "{\"node\": \"plate\", \"at\": \"0,0\", \"size\": \"1mm\"}", MCV_USAGE,
            "must be X,Y,Z");
    refuses("dent", "{\"node\": \"plate\", \"at\": \"1deg,0,0\", \"size\": \"1mm\"}", MCV_USAGE,
            "must be X,Y,Z");
    refuses("dent", "{\"node\": \"plate\", \"triangle\": \"-1\", \"size\": \"1mm\"}", MCV_USAGE,
            "--triangle -1");
    refuses("dent", "{\"node\": \"plate\", \"at\": \"1mm,1mm,0\", \"with\": [\"size\"]}", MCV_USAGE,
            "KEY=VALUE");
    refuses("dent",
            "{\"node\": \"plate\", \"at\": \"1mm,1mm,0\", \"size\": \"1mm\", \"with\": "
            "[\"size=1\"]}",
            MCV_USAGE, "given already");
    refuses("dent", "{\"node\": \"plate\", \"at\": \"10mm,10mm,0\"}", MCV_BAD_INPUT, "size");
    refuses("dent", "{\"node\": \"plate\", \"at\": \"10mm,10mm,2mm\", \"size\": \"1mm\"}",
            MCV_BAD_INPUT, "0.002 m off the surface");
    refuses("dent", "{\"output\": \"x.gltf\"}", MCV_USAGE, "output");
}

/* The note about a size, as the program tells it. */
static void warns(const char *size, const char *words) {
    char options[128], *text = NULL;
    mcv_rig *rig = new_rig();
    snprintf(options, sizeof options,
             "{\"node\": \"plate\", \"at\": \"10mm,10mm,0\", \"size\": \"%s\"}", size);
    WELL(mcv_rig_add_defect(rig, "bump", options, &text, &error));
    if (words ? !strstr(text, words) : strstr(text, "notes") != NULL)
        fail_msg("%s: must say \"%s\": %s", size, words ? words : "nothing", text);
    mcv_text_free(text);
    mcv_rig_free(rig);
}

/* Two wavelengths of 587.6 nm; a hundredth of the 100 µm that a pixel sees. */
static void warns_of_small_sizes(void **state) {
    (void)state;
    warns("1.17um", "smaller than two wavelengths, 1.18 µm");
    warns("1.19um", NULL);
    warns("0.99um", "less than a hundredth of the 100 µm that a pixel of sensor \\\"camera\\\"");
}

/* The program: the file beside the rig, and its defect in what check understands. */
static void program_writes_rigs(void **state) {
    (void)state;
    write_file("rig.gltf", rig_text);
    program_well("defect rig.gltf scratch --node plate --at 10mm,10mm,0 --size 0.1mm "
                 "--length 2mm --direction 1,1,0 --with profile=U --name scar");
    assert_non_null(strstr(said, "scar"));
    program_well("defect rig-scratch.gltf bump --node plate --at 20mm,5mm,0 --size 1mm "
                 "-o rig-scratch.gltf");
    json_t *report = program_json("check rig-scratch.gltf --json --set defects/scar/size=0.2mm");
    json_decref(report);
    program_fails("defect rig.gltf dent --node plate --at 10mm,10mm,5mm --size 1mm", 3,
                  "defects/dent-1/at");
    assert_int_equal(access("rig-dent.gltf", F_OK), -1);
    program_fails("defect rig.gltf", 2, "defect");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(adds_defects), cmocka_unit_test(refuses_bad_input),
        cmocka_unit_test(warns_of_small_sizes), cmocka_unit_test(program_writes_rigs)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
