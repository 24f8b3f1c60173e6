/* SPDX-License-Identifier: Apache-2.0 */
/* From a part to a rig that renders: `mcvisi new`, and what Blender's exporter writes. */
#include "program.h"

#include <math.h>
#include <stdbool.h>

/* Which of the tests run: no file of them shall take long. */
enum { PART_PARTS, PART_LIGHTS };
#ifndef PART
#define PART PART_PARTS
#endif

/* Boxes that lie each way, their middle anywhere; [mm]. */
static const struct {
    double lower[3], upper[3];
} boxes[] = {
    {{10, 20, 5}, {50, 50, 17}},          /* seen along z */
    {{-3, -1, -2}, {-1, 5, 6}},           /* along x */
    {{0, 100, 0}, {0.4, 100.1, 0.9}},     /* along y, and upright */
    {{-300, -20, -100}, {500, 30, 1200}}, /* large */
};

static const char *const kinds[] = {"telecentric", "entocentric", "lightfield", "transparent"};

static void test_every_box_fits(void **state) {
    char line[256];
    (void)state;
    for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; ++b)
        for (size_t k = 0; k < 3; ++k) {
            double sides[3];
            write_box_stl("box.stl", boxes[b].lower, boxes[b].upper);
            snprintf(line, sizeof line, "new %s box.stl --unit mm --force -o rig.gltf", kinds[k]);
            program_well(line);
            json_t *checked = program_json("check rig.gltf --json");
            for (int i = 0; i < 3; ++i) sides[i] = 1e-3 * (boxes[b].upper[i] - boxes[b].lower[i]);
            for (int i = 0; i < 3; ++i)
                for (int j = i + 1; j < 3; ++j)
                    if (sides[j] > sides[i]) {
                        const double larger = sides[j];
                        sides[j] = sides[i];
                        sides[i] = larger;
                    }
            const double w = number_at(checked, "sensors/0/optics/field_of_view/0"),
                         h = number_at(checked, "sensors/0/optics/field_of_view/1");
            /* A tenth of room at least; not more than the next of the series (1.5) and the film's
             * other shape make. */
            if (!(w >= 1.1 * sides[0] && h >= 1.1 * sides[1]))
                fail_msg("box %zu, %s: field %g x %g m", b, kinds[k], w, h);
            if (!(w <= 2 * sides[0] || h <= 2 * sides[1]))
                fail_msg("box %zu, %s: field %g x %g m is too large", b, kinds[k], w, h);
            if (json_array_size(json_object_get(checked, "warnings")))
                fail_msg("box %zu, %s: check warns: %s", b, kinds[k], said);
            json_decref(checked);
        }
}

/*
 * The silhouette of a box 40 mm x 30 mm covers what its sides say: each edge pixel counts by its
 * share, so that the mean of the image tells the area, to its own noise, and nothing of the part
 * leaves the picture, so all of the border is bright. The box reaches 6 mm before and behind the
 * plane in focus, where a ray of slope t misses it by 6 mm |t| more: 4 NA/(3 pi) in the mean over
 * the round stop.
 */
static void test_silhouette_has_the_size(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    program_well("new telecentric box.stl --unit mm --force -o rig.gltf");
    json_t *checked = program_json("check rig.gltf --json");
    const double w = number_at(checked, "sensors/0/optics/field_of_view/0"),
                 h = number_at(checked, "sensors/0/optics/field_of_view/1");
    const double grown = 2 * (0.040 + 0.030) * 0.006 * 4 / (3 * M_PI) *
                         number_at(checked, "sensors/0/optics/numerical_aperture");
    json_decref(checked);
    program_well("render rig.gltf -o box.exr --resolution 160x128 --spp 64");
    json_t *figures =
        program_json("measure box.exr --region all=0,0,160,128 --region border=0,0,160,4 --json");
    const double all = number_at(figures, "regions/0/mean/value"),
                 u = number_at(figures, "regions/0/mean/uncertainty");
    const double bright = number_at(figures, "regions/1/mean/value");
    json_decref(figures);
    const double covered = 1 - all / bright, truth = (0.040 * 0.030 + grown) / (w * h);
    print_message("covered %.6f, by the sides %.6f, standard error %.6f\n", covered, truth,
                  u / bright);
    /* 5 standard errors of the mean; corners: a square of 10 um of the 2100 mm^2. */
    if (!(fabs(covered - truth) <= 5 * u / bright + 1e-6))
        fail_msg("covered %.6f, must be %.6f", covered, truth);
}

/* By the reference renderer: it is the rig that is tested, and kernels would be built for each. */
static void test_each_renders(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[1].lower, boxes[1].upper);
    for (size_t k = 0; k < 3; ++k) {
        char line[256];
        snprintf(line, sizeof line, "new %s box.stl --unit cm --force -o rig.gltf", kinds[k]);
        program_well(line);
        json_t *summary = program_json(
            k == 2 ? "render rig.gltf --resolution 20x16 --spp 4 --device reference --json"
                   : "render rig.gltf --resolution 80x64 --spp 4 --device reference --json");
        if (!(number_at(summary, "mean") > 0)) fail_msg("%s: the picture is black", kinds[k]);
        json_decref(summary);
    }
}

/* Lines that a person can edit: one for each thing, and a note. */
static void test_is_readable(void **state) {
    (void)state;
    write_box_stl("a part.stl", boxes[0].lower, boxes[0].upper);
    program_well("new telecentric 'a part.stl' --unit mm");
    const char *text = read_whole("a part-telecentric.gltf");
    size_t lines = 0, length = 0;
    for (const char *c = text; *c; ++c) {
        lines += *c == '\n';
        length = *c == '\n' ? 0 : length + 1;
        assert_true(length < 400);
    }
    assert_true(lines > 20 && lines < 60);
    assert_non_null(strstr(text, "\"note\": \"A telecentric camera"));
    assert_non_null(strstr(text, "\"uri\": \"a%20part.stl\", \"unit\": \"mm\""));
    program_well("check 'a part-telecentric.gltf'");
    if (!strstr(said, "faces               0, 0, 1\n"))
        fail_msg("the light faces another way, or its digits are those of rounding: %s", said);
}

/* The middle of a part in single precision is written without what that leaves behind its digits.
 */
static void test_middle_is_short(void **state) {
    static const struct {
        double lower[3], upper[3];
        const char *middle;
    } cases[] = {{{0, 100, 0}, {0.4, 100.1, 0.9}, "\"translation\": [0.0002, 0.10005, 0.00045]"},
                 {{0.1, 0.1, -0.2}, {0.2, 0.5, 0.2}, "\"translation\": [0.00015, 0.0003, 0]"},
                 {{-1000, 0.1, 0.3}, {3000, 0.5, 0.31}, "\"translation\": [1, 0.0003, 0.000305]"}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_box_stl("box.stl", cases[i].lower, cases[i].upper);
        program_well("new telecentric box.stl --unit mm --force -o rig.gltf");
        const char *text = read_whole("rig.gltf"), *at = strstr(text, "\"translation\"");
        if (!strstr(text, cases[i].middle))
            fail_msg("not %s but %.60s", cases[i].middle, at ? at : "none");
    }
}

static void test_bad_input(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    write_file("empty.stl", "");
    write_file("cut.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n");
    write_file("comma.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0,5 0 0\n");
    program_fails("new telecentric box.stl", 2, "is 40 x 30 x 12 units large; give --unit");
    program_fails("new telecentric box.stl --unit nm", 3, "is the unit");
    program_fails("new telecentric box.stl --unit furlong", 2, "must be one of");
    program_fails("new periscope box.stl --unit mm", 2, "must be `new telecentric`");
    program_fails("new telecentric none.stl --unit mm", 3, "none.stl");
    program_fails("new telecentric empty.stl --unit mm", 3, "is empty");
    program_fails("new telecentric cut.stl --unit mm", 3, "truncated");
    program_fails("new telecentric comma.stl --unit mm", 3, "line 4");
    program_fails("new telecentric part.step --unit mm", 2, "convert");
    mkdir("below", 0777);
    program_fails("new telecentric box.stl --unit mm -o below/rig.gltf", 2, "copy it there");
    assert_int_not_equal(access("below/rig.gltf", F_OK), 0);
    program_well("new telecentric box.stl --unit m --force -o rig.gltf");
    assert_non_null(strstr(said, "is the unit"));
}

/* --- what people have edited, and what they wish
 * ------------------------------------------------------------------ */

static void test_edited_rig_stays(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    program_well("new telecentric box.stl --unit mm -o kept.gltf");
    program_well("new telecentric box.stl --unit mm -o kept.gltf"); /* the same is no harm */
    write_file("kept.gltf", "edited");
    program_fails("new telecentric box.stl --unit mm -o kept.gltf", 2,
                  "kept.gltf exists with other contents");
    assert_string_equal(read_whole("kept.gltf"), "edited");
    program_well("new telecentric box.stl --unit mm -o kept.gltf --force");
    program_well("check kept.gltf");
    program_fails("new entocentric box.stl --unit mm -o kept.gltf", 2, "replace it by --force");
}

/* Each light of each camera: nothing that `check` warns of, and what stands before the part does so
 * between part and lens. */
static void test_every_light(void **state) {
    static const char *const lights[] = {"backlight", "ring", "darkfield", "coaxial", "dome"};
    char line[256];
    (void)state;
    for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; ++b)
        for (size_t k = 0; k < 4; ++k)
            for (size_t l = 0; l < (k == 3 ? 1 : 5); ++l) {
                write_box_stl("box.stl", boxes[b].lower, boxes[b].upper);
                snprintf(line, sizeof line,
                         "new %s box.stl --unit mm --light %s --force -o lit.gltf", kinds[k],
                         lights[l]);
                if (b == 2 && k == 2 && l > 2) { /* a part of 1 mm, seen at 37 degrees from the axis
                                                    at f/4: no room beside that */
                    program_fails(line, 2, "give a larger --f-number");
                    strcat(line, " --f-number 40");
                }
                program_well(line);
                json_t *checked = program_json("check lit.gltf --json");
                if (json_array_size(json_object_get(checked, "warnings")))
                    fail_msg(
                        "box %zu, %s: check warns: %s", b, line,
                        json_string_value(json_array_get(json_object_get(checked, "warnings"), 0)));
                json_decref(checked);
            }
    program_fails("new transparent box.stl --unit mm --light dome -o lit2.gltf", 2,
                  "lit from behind");
    program_fails("new telecentric box.stl --unit mm --light lamp -o lit2.gltf", 2,
                  "must be one of auto|backlight");
    /* A lens that is wished for may be too near for a light. */
    program_fails(
        "new entocentric box.stl --unit mm --light dome --working-distance 1.5m -o lit2.gltf", 2,
        "a dome light for this part extends");
}

/* All of a mirror has this radiance, its corners too, to five standard errors. The rig is what is
 * tested, so the reference renders it: each kind of light would need kernels of its own. */
static void expect_face(const char *rig, double radiance) {
    static const char *const regions = "--region all=6,6,28,20 --region a=6,6,6,5 --region "
                                       "b=28,6,6,5 --region c=6,21,6,5 --region d=28,21,6,5";
    char line[512];
    snprintf(line, sizeof line,
             "render %s --resolution 40x32 --spp 128 --device reference --set "
             "sensors/camera/radiometry=radiance -o face.exr",
             rig);
    program_well(line);
    snprintf(line, sizeof line, "measure face.exr --json %s", regions);
    json_t *figures = program_json(line);
    for (int i = 0; i < 5; ++i) {
        const json_t *mean =
            json_object_get(json_array_get(json_object_get(figures, "regions"), (size_t)i), "mean");
        const double value = number_at(mean, "value"), u = number_at(mean, "uncertainty");
        print_message("%s region %d: %.5f +- %.5f\n", rig, i, value, u);
        if (!(fabs(value - radiance) <= 5 * u + 1e-6 && u <= 0.05 * radiance))
            fail_msg("%s, region %d: radiance %g +- %g, must be %g", rig, i, value, u, radiance);
    }
    json_decref(figures);
}

/*
 * A flat mirror shows what a light is: under the half mirror half of a half of the panel's
 * radiance, all over it; under a low ring nothing.
 */
static void test_mirror_under_lights(void **state) {
    static const struct {
        const char *light;
        double radiance;
    } cases[] = {{"coaxial", 0.25}, {"darkfield", 0}};
    char line[256];
    (void)state;
    /* 40 mm x 30 mm, of which the region is inside in both fields. */
    write_box_stl("plate.stl", (const double[3]){0, 0, 0}, (const double[3]){40, 32, 2});
    for (size_t k = 0; k < 2; ++k)
        for (size_t l = 0; l < 2; ++l) {
            snprintf(
                line, sizeof line,
                "new %s plate.stl --unit mm --material mirror --light %s --force -o plate.gltf",
                kinds[k], cases[l].light);
            program_well(line);
            expect_face("plate.gltf", cases[l].radiance);
        }
}

static double wished(const char *options, const char *path) {
    char line[512];
    snprintf(line, sizeof line, "new %s --force -o wish.gltf", options);
    program_well(line);
    json_t *checked = program_json("check wish.gltf --json");
    const double value = number_at(checked, path);
    json_decref(checked);
    return value;
}

static void expect_wish(const char *options, const char *path, double value) {
    const double found = wished(options, path);
    if (!(fabs(found - value) <= 1e-6 * fabs(value)))
        fail_msg("new %s: %s is %.9g, must be %.9g", options, path, found, value);
}

/* What is wished is kept, what depends on it follows: m = f/(W - f), W = f (1 + 1/m), of a
 * telecentric lens W = f (1 + m)/m. */
static void test_wishes(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    expect_wish("telecentric box.stl --unit mm --magnification 0.1 --working-distance 110mm",
                "sensors/0/optics/magnification", 0.1);
    expect_wish("telecentric box.stl --unit mm --magnification 0.1 --focal-length 10mm",
                "sensors/0/optics/working_distance", 0.11);
    expect_wish("telecentric box.stl --unit mm --field-of-view 60mm",
                "sensors/0/optics/field_of_view/0", 0.060);
    expect_wish("telecentric box.stl --unit mm --resolution 2448x2048 --pixel-size 3.45um "
                "--field-of-view 60mm",
                "sensors/0/optics/magnification", 2448 * 3.45e-6 / 0.060);
    expect_wish("telecentric box.stl --unit mm --f-number 6", "sensors/0/optics/f_number", 6);
    expect_wish("entocentric box.stl --unit mm --focal-length 25mm --working-distance 0.3",
                "sensors/0/optics/magnification", 25 / 275.);
    expect_wish("entocentric box.stl --unit mm --focal-length 12mm --magnification 0.1",
                "sensors/0/optics/working_distance", 0.132);
    expect_wish("entocentric box.stl --unit mm --working-distance 0.22 --magnification 0.1",
                "sensors/0/focalLength", 0.020);
    expect_wish("lightfield box.stl --unit mm --resolution 100x80", "sensors/0/spatialResolution/0",
                100);
    expect_wish("transparent box.stl --unit mm", "sensors/0/angularResolution/0", 9);
    /* With one of them the part still fits, its nearest face too. */
    assert_true(wished("entocentric box.stl --unit mm --focal-length 16mm",
                       "sensors/0/optics/field_of_view/0") > 0.044);
    assert_true(wished("entocentric box.stl --unit mm --working-distance 250mm",
                       "sensors/0/optics/field_of_view/0") > 0.044);
    /* 1 inch. */
    write_box_stl("inch.stl", (const double[3]){0, 0, 0}, (const double[3]){1, 0.8, 0.1});
    program_well("new telecentric inch.stl --unit inch -o inch.gltf");
    assert_non_null(strstr(said, "25.4mm x 20.32mm x 2.54mm"));
    /* A field that is too small for the part is said to be. */
    program_well("new telecentric box.stl --unit mm --field-of-view 20mm --force -o wish.gltf");
    assert_non_null(strstr(said, "is larger than the field of view"));
    program_fails("new telecentric box.stl --unit mm --focal-length 25furlong -o wish.gltf", 2,
                  "must be a length above 0");
    program_fails("new telecentric box.stl --unit mm --working-distance -3mm -o wish.gltf", 2,
                  "must be a length above 0");
    program_fails(
        "new telecentric box.stl --unit mm --magnification 1 --field-of-view 6mm -o wish.gltf", 2,
        "determine each other");
    program_fails(
        "new telecentric box.stl --unit mm --focal-length 25mm --working-distance 1 -o wish.gltf",
        2, "leave it out");
    program_fails("new entocentric box.stl --unit mm --focal-length 25mm --working-distance 1 "
                  "--magnification 1 -o wish.gltf",
                  2, "give two of them");
}

/* The side that is asked for faces the camera: it stands there, and its sides are those across. */
static void test_views(void **state) {
    static const struct {
        const char *view, *across;
        double position[3]; /* from the middle, as a direction */
    } cases[] = {{"front", "40mm x 30mm x 12mm", {0, 0, 1}},
                 {"back", "40mm x 30mm x 12mm", {0, 0, -1}},
                 {"right", "30mm x 12mm x 40mm", {1, 0, 0}},
                 {"left", "30mm x 12mm x 40mm", {-1, 0, 0}},
                 {"top", "40mm x 12mm x 30mm", {0, 1, 0}},
                 {"bottom", "40mm x 12mm x 30mm", {0, -1, 0}},
                 {"0,0,-2", "40mm x 30mm x 12mm", {0, 0, -1}},
                 {"3,0,4", "39.2mm x 30mm x 33.6mm", {0.6, 0, 0.8}},
                 {"-1,1,0", "49.5mm x 12mm x 49.5mm", {-M_SQRT1_2, M_SQRT1_2, 0}}};
    const double middle[3] = {0.030, 0.035, 0.011};
    char line[256];
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        snprintf(line, sizeof line,
                 "new telecentric box.stl --unit mm --view %s --force -o view.gltf", cases[i].view);
        program_well(line);
        if (!strstr(said, cases[i].across)) fail_msg("%s: not %s: %s", line, cases[i].across, said);
        json_t *checked = program_json("check view.gltf --json");
        const double distance = number_at(checked, "sensors/0/optics/working_distance");
        for (int k = 0; k < 3; ++k) {
            snprintf(line, sizeof line, "sensors/0/position/%d", k);
            const double off =
                number_at(checked, line) - middle[k] - distance * cases[i].position[k];
            if (!(fabs(off) <= 1e-5 * distance))
                fail_msg("--view %s: the camera is %g m off along axis %d", cases[i].view, off, k);
        }
        if (json_array_size(json_object_get(checked, "warnings")))
            fail_msg("--view %s: check warns: %s", cases[i].view, said);
        json_decref(checked);
    }
    program_fails("new telecentric box.stl --unit mm --view fornt -o view.gltf", 2,
                  "did you mean front?");
    program_fails("new telecentric box.stl --unit mm --view 0,0,0 -o view.gltf", 2,
                  "or a direction X,Y,Z");
    program_fails("new telecentric box.stl --unit mm --view 0,1 -o view.gltf", 2,
                  "or a direction X,Y,Z");
}

/* A plate of 40 x 40 mm in a glTF file, with this material, and normals of its own or none. */
static void write_plate(const char *path, const char *material, bool normals) {
    char text[2048];
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
             "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,"
             "CtejvArXo7wAAAAACtejPArXo7wAAAAACtejPArXozwAAAAACtejvArXozwAAAAAAAABAAIAAAACAAMA\"}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
             "\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
             "\"count\":4,\"type\":\"VEC3\",\"min\":[-0.02,-0.02,0],\"max\":[0.02,0.02,0]},"
             "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0%s},\"indices\":1,"
             "\"material\":0}]}],\"nodes\":[{\"name\":\"plate\",\"mesh\":0}],\"materials\":[%s]}",
             normals ? ",\"NORMAL\":0" : "", material);
    write_file(path, text);
}

/* CAD exports glass as it does steel: in a rig for transparent parts it becomes glass, as an .stl
 * file's does. What passes light keeps its own material, and so does a part of other rigs. Glass
 * whose file has no normals gets a crease angle. */
static void test_materials_of_gltf_parts(void **state) {
    static const struct {
        const char *material, *kind;
        bool glass, normals, crease;
    } cases[] = {
        {"{\"name\":\"steel\",\"pbrMetallicRoughness\":{\"metallicFactor\":1}}", "transparent",
         true, false, true},
        {"{\"name\":\"steel\",\"pbrMetallicRoughness\":{\"metallicFactor\":1}}", "transparent",
         true, true, false},
        {"{\"name\":\"steel\",\"pbrMetallicRoughness\":{\"metallicFactor\":1}}", "telecentric",
         false, false, false},
        {"{\"name\":\"pane\",\"extensions\":{\"KHR_materials_transmission\":{"
         "\"transmissionFactor\":1}}}",
         "transparent", false, false, true},
        {"{\"name\":\"flint\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\","
         "\"glass\":\"N-SF11\"}}}",
         "transparent", false, false, true},
        {"{\"name\":\"flint\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\","
         "\"glass\":\"N-SF11\"}}}",
         "transparent", false, true, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[128];
        write_plate("plate.gltf", cases[i].material, cases[i].normals);
        snprintf(line, sizeof line, "new %s plate.gltf --force -o of.gltf", cases[i].kind);
        program_well(line);
        const char *rig = read_whole("of.gltf");
        if ((strstr(rig, "\"glass\": \"N-BK7\"") != NULL) != cases[i].glass ||
            (strstr(rig, "\"materials\"") != NULL) != cases[i].glass ||
            (strstr(rig, "\"creaseAngle\"") != NULL) != cases[i].crease)
            fail_msg("%s, %s: %s", cases[i].kind, cases[i].material, rig);
        program_well("check of.gltf");
    }
}

static void test_materials(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    program_well("new telecentric box.stl --unit mm --material aluminium --force -o of.gltf");
    assert_non_null(
        strstr(read_whole("of.gltf"), "{\"type\": \"conductor\", \"metal\": \"aluminium\""));
    assert_null(strstr(read_whole("of.gltf"), "creaseAngle"));
    program_well("new entocentric box.stl --unit mm --material PMMA --force -o of.gltf");
    assert_non_null(
        strstr(read_whole("of.gltf"), "\"material\": \"part\", \"creaseAngle\": \"30deg\"}"));
    program_well("new transparent box.stl --unit mm --force -o of.gltf");
    assert_non_null(strstr(read_whole("of.gltf"), "\"glass\": \"N-BK7\""));
    assert_non_null(strstr(read_whole("of.gltf"), "\"creaseAngle\": \"30deg\""));
    program_well("check of.gltf");
    program_fails("new telecentric box.stl --unit mm --material alu -o none.gltf", 2,
                  "known are aluminium, chromium");
    static const char *const others[] = {"steel", "stainlessSteel", "Brass", "metal"};
    for (int i = 0; i < 4; ++i) {
        char line[128];
        snprintf(line, sizeof line, "new telecentric box.stl --unit mm --material %s -o none.gltf",
                 others[i]);
        program_fails(line, 2,
                      "there is none: metals are aluminium, chromium, copper, gold, iron, nickel, "
                      "silver, titanium\n");
    }
    program_fails("new telecentric box.stl --unit mm --material aluminum -o none.gltf", 2,
                  "did you mean aluminium?");
    program_fails("new telecentric box.stl --unit mm --material N-BK8 -o none.gltf", 2,
                  "did you mean N-BK7?");
}

/*
 * As Blender's exporter writes a scene by default: neither cameras nor lights, names with dots, a
 * node per object with rotation and scale, +Y up, metres; an exporter's extras; a material of its
 * own making, double-sided.
 */
static const char blender[] =
    "{\"asset\":{\"generator\":\"Khronos glTF Blender I/O "
    "v4.2.70\",\"version\":\"2.0\"},\"scene\":0,"
    "\"extensionsUsed\":[\"KHR_materials_specular\",\"KHR_materials_ior\"],"
    "\"scenes\":[{\"name\":\"Scene\",\"nodes\":[1],\"extras\":{\"glTF2ExportSettings\":{\"export_"
    "cameras\":false}}}],"
    "\"nodes\":[{\"mesh\":0,\"name\":\"Bracket.001\",\"rotation\":[0,0.7071068286895752,0,0."
    "7071068286895752],\"scale\":[0.02,0.02,0.02]},"
    "{\"children\":[0],\"name\":\"Empty.002\",\"translation\":[0.1,0.05,-0.2]}],"
    "\"materials\":[{\"doubleSided\":true,\"name\":\"Material.001\",\"extensions\":{\"KHR_"
    "materials_specular\":{\"specularFactor\":0.5},"
    "\"KHR_materials_ior\":{\"ior\":1.45}},\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.8,"
    "0.8,1],\"metallicFactor\":0,"
    "\"roughnessFactor\":0.5}}],"
    "\"meshes\":[{\"name\":\"Mesh.003\",\"primitives\":[{\"attributes\":{\"POSITION\":0},"
    "\"indices\":1,\"material\":0}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"max\":[1,1,0.5],\"min\":"
    "[-1,-1,0],\"type\":\"VEC3\"},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48,\"byteOffset\":0,\"target\":34962},"
    "{\"buffer\":0,\"byteLength\":24,\"byteOffset\":48,\"target\":34963}],"
    "\"buffers\":[{\"byteLength\":72,\"uri\":\"part.bin\"}]}";

static void test_blender(void **state) {
    const float positions[12] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, 0.5f};
    const uint16_t indices[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    (void)state;
    FILE *file = fopen("part.bin", "wb");
    assert_non_null(file);
    fwrite(positions, 4, 12, file);
    fwrite(indices, 2, 12, file);
    assert_int_equal(fclose(file), 0);
    write_file("part.gltf", blender);
    program_well("new entocentric part.gltf --force -o rig.gltf");
    json_t *rig = json_load_file("rig.gltf", 0, NULL);
    /* In the world: z' = -x, x' = z, twice 20 mm across and 10 mm deep, below a parent that is
     * moved. */
    assert_true(fabs(number_at(rig, "nodes/1/translation/0") - 0.105) < 1e-6);
    assert_true(fabs(number_at(rig, "nodes/1/translation/1") - 0.05) < 1e-6);
    assert_true(fabs(number_at(rig, "nodes/1/translation/2") + 0.2) < 1e-6);
    json_decref(rig);
    json_t *checked = program_json("check rig.gltf --json");
    assert_true(number_at(checked, "sensors/0/optics/field_of_view/0") >= 0.044);
    json_decref(checked);
    program_well("render rig.gltf --resolution 40x32 --spp 4 --device reference");
    program_well("new entocentric part.gltf --material nickel -o nickel.gltf");
    checked = program_json("check nickel.gltf --json");
    assert_int_equal(json_array_size(json_object_get(checked, "materials")),
                     2); /* the light's, and not Material.001 */
    json_decref(checked);
    /* Names with dots are names: the path ends at a slash. */
    program_well("check part.gltf --set nodes/Empty.002/translation/x=0.2 --set "
                 "materials/Material.001/roughnessFactor=1 || true");
    assert_null(strstr(said, "there is no"));
}

int main(void) {
    const struct CMUnitTest parts[] = {
        cmocka_unit_test(test_every_box_fits),
        cmocka_unit_test(test_silhouette_has_the_size),
        cmocka_unit_test(test_each_renders),
        cmocka_unit_test(test_is_readable),
        cmocka_unit_test(test_middle_is_short),
        cmocka_unit_test(test_bad_input),
        cmocka_unit_test(test_edited_rig_stays),
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_materials),
        cmocka_unit_test(test_blender),
        cmocka_unit_test(test_materials_of_gltf_parts),
    };
    const struct CMUnitTest lights[] = {
        cmocka_unit_test(test_every_light),
        cmocka_unit_test(test_mirror_under_lights),
        cmocka_unit_test(test_wishes),
    };
    switch (PART) {
    case PART_PARTS:
        return cmocka_run_group_tests(parts, enter_folder, leave_folder);
    default:
        return cmocka_run_group_tests(lights, enter_folder, leave_folder);
    }
}
