/* SPDX-License-Identifier: Apache-2.0 */
/* The public interface without any OpenCL device: rigs, pictures, the reference renderer, bad
 * input. */
#include "api.h"

#include "comma_locale.h"

#include <locale.h>
#include <math.h>
#include <sys/stat.h>

/* --- options --- */

static void test_options_are_checked(void **state) {
    mcv_session *session = NULL;
    char *text = NULL;
    (void)state;
    FAILS(MCV_USAGE, "not JSON", mcv_session_open("{device", &session, &error));
    FAILS(MCV_USAGE, "JSON object", mcv_session_open("[1]", &session, &error));
    FAILS(MCV_USAGE, "unknown option --devise: did you mean --device?",
          mcv_session_open("{\"devise\": \"0\"}", &session, &error));
    FAILS(MCV_USAGE, "--threads 0: must be an integer from 1 to 1024",
          mcv_session_open("{\"threads\": 0}", &session, &error));
    FAILS(MCV_USAGE, "a session takes", mcv_session_open("{\"spp\": 4}", &session, &error));
    FAILS(MCV_USAGE, "session must not be NULL", mcv_session_open(NULL, NULL, &error));
    assert_null(session);
    FAILS(MCV_USAGE, "unknown verb rendr", mcv_options_schema("rendr", &text, &error));
    assert_null(text);
    WELL(mcv_options_schema("render", &text, &error));
    assert_non_null(strstr(text, "\"replicates\""));
    mcv_text_free(text);
    mcv_text_free(NULL);
}

static void test_values_of_options(void **state) {
    static const struct {
        const char *options, *says;
    } wrong[] = {{"{\"spp\": \"many\"}", "--spp many: must be an integer"},
                 {"{\"spp\": {}}", "spp: must be a string, a number"},
                 {"{\"spp\": 1e999}", "not JSON"},
                 {"{\"resolution\": [16]}", "--resolution 16: must be WxH"},
                 {"{\"resolution\": [16, \"x\"]}", "must be a list of numbers"},
                 {"{\"resolution\": []}", "must be a list of numbers"},
                 {"{\"adaptive\": \"yes\"}", "--adaptive yes: must be one of auto|on|off"},
                 {"{\"output\": \"x.exr\"}", "--output is no option of this call"},
                 {"{\"bits\": 8}", "--bits is no option of this call"},
                 {"{\"region\": \"a\"}", "--region is an option of measure"},
                 {"{\"sampler\": \"sobel\"}", "must be one of sobol|random"},
                 {"{\"spp\": 4, \"spp\": 8}", "duplicate"},
                 {"{\"set\": [\"sensors/cam/x=1\"]}", "there is no \"cam\""},
                 {"{\"set\": [[1]]}", "must be a string, a number"},
                 {"{\"sensor\": \"other\"}", "other"}};
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        mcv_picture *picture = (mcv_picture *)1;
        mcv_error error = {""};
        const mcv_result result =
            mcv_session_render(session, rig, wrong[i].options, NULL, NULL, &picture, NULL, &error);
        if (result == MCV_OK || picture || !strstr(error.text, wrong[i].says))
            fail_msg("%s: %d, \"%s\", must say \"%s\"", wrong[i].options, result, error.text,
                     wrong[i].says);
    }
    mcv_picture_free(render(session, rig,
                            "{\"spp\": 4, \"noise_free\": false, \"time\": \"10s\", \"error\": "
                            "null, \"bits\": null}"));
    mcv_picture *picture = render(session, rig, "{\"resolution\": [8, 6], \"spp\": 4.0e0}");
    assert_int_equal(part_of(picture, 0).width, 8);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
    mcv_session_close(NULL);
}

/* --- rigs --- */

static void test_rig_is_changed_and_read(void **state) {
    mcv_rig *rig = parse_rig(sky_rig), *copy = NULL, *none = (mcv_rig *)1;
    char *text = NULL;
    (void)state;
    WELL(mcv_rig_get(rig, "sensors/camera/resolution", &text, &error));
    assert_string_equal(text, "[16,12]");
    mcv_text_free(text);
    WELL(mcv_rig_copy(rig, &copy, &error));
    WELL(mcv_rig_set(rig, "sensors/camera/resolution", "[4, 2]", &error));
    WELL(mcv_rig_set(rig, "nodes/camera/translation/z", "80mm", &error));
    WELL(mcv_rig_get(rig, "sensors/camera/resolution", &text, &error));
    assert_string_equal(text, "[4,2]");
    mcv_text_free(text);
    WELL(mcv_rig_get(rig, "nodes/camera/translation", &text, &error));
    char *end = NULL;
    assert_true(strtod(strrchr(text, ',') + 1, &end) == 0.08);
    assert_string_equal(end, "]");
    mcv_text_free(text);
    WELL(mcv_rig_get(copy, "sensors/camera/resolution", &text, &error));
    assert_string_equal(text, "[16,12]");
    mcv_text_free(text);
    WELL(mcv_rig_paths(copy, &text, &error));
    assert_non_null(strstr(text, "\"sensors/camera/pixelSize\""));
    assert_non_null(strstr(text, "\"emitters/sky/radiance\""));
    mcv_text_free(text);
    WELL(mcv_rig_get(copy, "", &text, &error));
    assert_non_null(strstr(text, "\"MCVISI_emitters\""));
    mcv_text_free(text);
    FAILS(MCV_BAD_INPUT, "did you mean \"camera\"",
          mcv_rig_set(rig, "sensors/camra/resolution", "[4, 2]", &error));
    FAILS(MCV_BAD_INPUT, "did you mean \"pixelSize\"",
          mcv_rig_get(rig, "sensors/camera/pixelsize", &text, &error));
    FAILS(MCV_BAD_INPUT, "its default counts", mcv_rig_get(rig, "nodes/sky/mesh", &text, &error));
    FAILS(MCV_USAGE, "must be a path", mcv_rig_set(rig, "", "1", &error));
    assert_null(text);
    FAILS(MCV_BAD_INPUT, "no such file", mcv_rig_open("./no such file.gltf", &none, &error));
    assert_null(none);
    FAILS(MCV_BAD_INPUT, "not JSON", mcv_rig_parse("{]", 2, NULL, &none, &error));
    FAILS(MCV_BAD_INPUT, "not JSON", mcv_rig_parse("", 0, NULL, &none, &error));
    mcv_rig_free(rig);
    mcv_rig_free(copy);
    mcv_rig_free(NULL);
}

/* A change that fails leaves the rig as it was. */
static void test_failed_change_leaves_the_rig(void **state) {
    mcv_rig *rig = parse_rig(sky_rig);
    char *before = NULL, *after = NULL;
    (void)state;
    WELL(mcv_rig_get(rig, "", &before, &error));
    FAILS(MCV_BAD_INPUT, "not an element of an array",
          mcv_rig_set(rig, "nodes/sky/translation/up", "1", &error));
    WELL(mcv_rig_get(rig, "", &after, &error));
    assert_string_equal(before, after);
    mcv_text_free(before);
    mcv_text_free(after);
    mcv_rig_free(rig);
}

static void test_rig_is_saved(void **state) {
    mcv_rig *rig = parse_rig(sky_rig), *again = NULL;
    char *text = NULL;
    (void)state;
    WELL(mcv_rig_set(rig, "emitters/sky/radiance", "1.5", &error));
    FAILS(MCV_USAGE, "must lie in the folder", mcv_rig_save(rig, "/tmp/sky.gltf", &error));
    FAILS(MCV_USAGE, "must end in .gltf or .glb", mcv_rig_save(rig, "sky.json", &error));
    assert_string_equal(mcv_rig_path(rig), "");
    for (int i = 0; i < 2; ++i) {
        const char *path = i ? "sky.glb" : "sky.gltf";
        WELL(mcv_rig_save(rig, path, &error));
        assert_string_equal(mcv_rig_path(rig), path);
        WELL(mcv_rig_open(path, &again, &error));
        WELL(mcv_rig_get(again, "emitters/sky/radiance", &text, &error));
        assert_string_equal(text, "1.5");
        mcv_text_free(text);
        mcv_rig_free(again);
    }
    mcv_rig_free(rig);
}

/* --- renders and pictures --- */

static void expect_all(const mcv_picture *picture, float value) {
    const mcv_part part = part_of(picture, 0);
    for (size_t i = 0; i < (size_t)part.width * part.height * part.channels; ++i)
        if (part.planes[i] != value)
            fail_msg("value %zu is %.9g, must be %.9g", i, (double)part.planes[i], (double)value);
}

static void test_reference_renders(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    char *report = NULL;
    (void)state;
    mcv_picture *picture = render(session, rig, "{\"spp\": 16}");
    assert_int_equal(mcv_picture_part_count(picture), 2);
    const mcv_part image = part_of(picture, 0), again = part_of(picture, 0),
                   deviation = part_of(picture, 1);
    assert_string_equal(image.name, "image");
    assert_string_equal(deviation.name, "error");
    assert_int_equal(image.width, 16);
    assert_int_equal(image.height, 12);
    assert_ptr_equal(image.planes, again.planes);
    expect_all(picture, 2.5F);
    FAILS(MCV_USAGE, "there is no part 2",
          mcv_picture_part(picture, 2, &(mcv_part){.size = sizeof(mcv_part)}, &error));
    FAILS(MCV_USAGE, "part->size", mcv_picture_part(picture, 0, &(mcv_part){.size = 0}, &error));
    WELL(mcv_rig_set(rig, "emitters/sky/radiance", "0.75", &error));
    WELL(mcv_session_check(session, rig, NULL, &report, &error));
    assert_non_null(strstr(report, "\"findings\""));
    mcv_text_free(report);
    mcv_picture *other =
        render(session, rig, "{\"spp\": 16, \"set\": \"sensors/camera/resolution=[3, 5]\"}");
    expect_all(other, 0.75F);
    assert_int_equal(part_of(other, 0).height, 5);
    WELL(mcv_picture_attributes(other, &report, &error));
    assert_non_null(
        strstr(report, "emitters/sky/radiance=0.75\\nsensors/camera/resolution=[3, 5]"));
    mcv_text_free(report);
    mcv_session_close(session); /* pictures and rigs outlive it */
    mcv_rig_free(rig);
    expect_all(picture, 2.5F);
    mcv_picture_free(picture);
    mcv_picture_free(other);
    mcv_picture_free(NULL);
}

static void test_no_device_is_told(void **state) {
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *picture = (mcv_picture *)1;
    char *report = NULL;
    (void)state;
    WELL(mcv_devices(&report, &error));
    assert_non_null(strstr(report, "\"devices\":[]"));
    assert_non_null(strstr(report, "\"message\":\""));
    mcv_text_free(report);
    FAILS(MCV_DEVICE, "device",
          mcv_session_render(session, rig, "{\"spp\": 4}", NULL, NULL, &picture, NULL, &error));
    assert_null(picture);
    /* The session goes on. */
    picture = render(session, rig, "{\"spp\": 4, \"device\": \"reference\"}");
    expect_all(picture, 2.5F);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

typedef struct told {
    mcv_session *session;
    mcv_rig *rig;
    unsigned calls, stop_after;
    mcv_picture *last;
} told;

static bool on_progress(void *user, const mcv_progress *progress) {
    told *t = user;
    mcv_picture *picture = NULL;
    ++t->calls;
    assert_int_equal(progress->size, sizeof *progress);
    FAILS(MCV_USAGE, "at work in another call",
          mcv_session_render(t->session, t->rig, NULL, NULL, NULL, &picture, NULL, &error));
    WELL(mcv_progress_picture(progress, &picture, &error));
    if (picture) {
        mcv_picture_free(t->last);
        t->last = picture;
    }
    return t->calls != t->stop_after;
}

static void test_progress_and_interruption(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    told t = {.session = session, .rig = rig, .stop_after = 3};
    mcv_picture *picture = NULL;
    char *stats = NULL;
    (void)state;
    FAILS(MCV_INTERRUPTED, "interrupted",
          mcv_session_render(session, rig, "{\"spp\": 65536}", on_progress, &t, &picture, &stats,
                             &error));
    assert_int_equal(t.calls, 3);
    assert_non_null(picture);
    assert_non_null(t.last);
    assert_non_null(strstr(stats, "\"interrupted\": true"));
    expect_all(picture, 2.5F);
    expect_all(t.last, 2.5F);
    mcv_text_free(stats);
    mcv_picture_free(picture);
    mcv_picture_free(t.last);
    t = (told){.session = session, .rig = rig};
    WELL(
        mcv_session_render(session, rig, "{\"spp\": 16}", on_progress, &t, &picture, NULL, &error));
    assert_true(t.calls > 0);
    mcv_picture_free(t.last);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void test_pictures_from_memory(void **state) {
    float planes[12], deviation[12], bad[12];
    mcv_picture *picture = NULL, *read = NULL;
    char *text = NULL;
    (void)state;
    for (int i = 0; i < 12; ++i) {
        planes[i] = (float)i;
        deviation[i] = 0.5F;
        bad[i] = i == 7 ? NAN : 1;
    }
    FAILS(MCV_BAD_INPUT, "channel 0, row 1, column 3 is nan",
          mcv_picture_make(4, 3, 1, bad, NULL, NULL, &picture, &error));
    bad[7] = -1;
    FAILS(MCV_BAD_INPUT, "must be finite and not negative",
          mcv_picture_make(4, 3, 1, planes, bad, NULL, &picture, &error));
    FAILS(MCV_USAGE, "1 or 3 channels",
          mcv_picture_make(3, 2, 2, planes, NULL, NULL, &picture, &error));
    FAILS(MCV_USAGE, "JSON object", mcv_picture_make(4, 3, 1, planes, NULL, "7", &picture, &error));
    FAILS(MCV_USAGE, "attributes: a: must be",
          mcv_picture_make(4, 3, 1, planes, NULL, "{\"a\": [1, 2, 3]}", &picture, &error));
    assert_null(picture);
    WELL(mcv_picture_make(4, 3, 1, planes, deviation, "{\"mcvisi:unit\": \"DN\", \"gain\": 2}",
                          &picture, &error));
    WELL(mcv_picture_write(picture, "made.exr", NULL, &error));
    WELL(mcv_picture_read("made.exr", &read, &error));
    assert_int_equal(mcv_picture_part_count(read), 2);
    assert_memory_equal(part_of(read, 0).planes, planes, sizeof planes);
    assert_memory_equal(part_of(read, 1).planes, deviation, sizeof deviation);
    WELL(mcv_picture_attributes(read, &text, &error));
    assert_string_equal(text, "{\"mcvisi:unit\":\"DN\",\"gain\":2.0}");
    mcv_text_free(text);
    mcv_picture_free(read);
    WELL(mcv_picture_write(picture, "made.exr", "{\"parts\": [\"image\"]}", &error));
    WELL(mcv_picture_read("made.exr", &read, &error));
    assert_int_equal(mcv_picture_part_count(read), 1);
    mcv_picture_free(read);
    FAILS(MCV_USAGE, "none of these parts",
          mcv_picture_write(picture, "made.exr", "{\"parts\": [\"x\"]}", &error));
    FAILS(MCV_USAGE, "options: must be",
          mcv_picture_write(picture, "made.exr", "{\"a\": 1}", &error));
    FAILS(MCV_USAGE, "as a preview into .png",
          mcv_picture_write(picture, "made.tif", NULL, &error));
    WELL(mcv_picture_write(picture, "made.png", NULL, &error));
    FAILS(MCV_BAD_INPUT, "no.exr", mcv_picture_read("no.exr", &read, &error));
    assert_null(read);
    mcv_picture_free(picture);
}

/* Grey values 0, 1, 2 … over a picture have a mean that everybody knows. */
static void test_measures_a_mean(void **state) {
    enum { SIDE = 32, COUNT = SIDE * SIDE };
    static float planes[COUNT];
    mcv_picture *picture = NULL;
    char *report = NULL;
    (void)state;
    for (int i = 0; i < COUNT; ++i) planes[i] = (float)i;
    WELL(mcv_picture_make(SIDE, SIDE, 1, planes, NULL,
                          "{\"mcvisi:quantity\": \"grey value\", \"mcvisi:unit\": \"DN\"}",
                          &picture, &error));
    WELL(mcv_picture_measure(picture, NULL, NULL,
                             "{\"region\": [\"all=0,0,32,32\", \"row=0,0,32,1\"], \"noise\": 1}",
                             &report, &error));
    assert_non_null(strstr(report, "\"mean\":{\"value\":511.5,"));
    assert_non_null(strstr(report, "\"mean\":{\"value\":15.5,"));
    mcv_text_free(report);
    WELL(mcv_picture_measure(picture, picture, NULL, "{\"noise\": 1}", &report, &error));
    assert_non_null(strstr(report, "\"mean\":{\"value\":0,"));
    mcv_text_free(report);
    FAILS(
        MCV_USAGE, "region",
        mcv_picture_measure(picture, NULL, NULL, "{\"region\": \"a=0,0,99,1\"}", &report, &error));
    assert_null(report);
    /* What was written is what was there. */
    WELL(mcv_picture_write(picture, "values.tif", NULL, &error));
    mcv_picture *read = NULL;
    WELL(mcv_picture_read("values.tif", &read, &error));
    assert_memory_equal(part_of(read, 0).planes, planes, sizeof planes);
    mcv_picture_free(read);
    mcv_picture_free(picture);
}

/* 1000 electrons on average, 2 electrons per grey value. */
static void test_camera(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *picture = render(session, rig, "{\"spp\": 16}"), *grey = NULL, *none = NULL;
    char *report = NULL;
    (void)state;
    WELL(mcv_picture_camera(picture,
                            "{\"electrons_per_unit\": 400, \"gain\": 0.5, \"noise_free\": true}",
                            &grey, &report, &error));
    expect_all(grey, 500);
    expect_all(picture, 2.5F); /* not blurred in place */
    assert_non_null(strstr(report, "\"electrons\":1000"));
    mcv_text_free(report);
    WELL(mcv_picture_write(grey, "grey.png", NULL, &error));
    WELL(mcv_picture_read("grey.png", &none, &error));
    expect_all(none, 500);
    mcv_picture_free(none);
    FAILS(MCV_USAGE, "expos", mcv_picture_camera(picture, NULL, &none, &report, &error));
    FAILS(MCV_BAD_INPUT, "grey value",
          mcv_picture_camera(grey, "{\"expose_to\": 0.5}", &none, &report, &error));
    assert_null(none);
    mcv_picture_free(grey);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- two pictures, rays --- */

static void test_compares(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *a = render(session, rig, "{\"spp\": 16}"), *b = NULL, *difference = NULL;
    char *report = NULL;
    (void)state;
    WELL(mcv_rig_set(rig, "emitters/sky/radiance", "2.6", &error));
    b = render(session, rig, "{\"spp\": 16, \"seed\": 1}");
    WELL(mcv_picture_compare(a, a, NULL, NULL, NULL, &report, &error));
    assert_non_null(strstr(report, "\"different\":false"));
    assert_non_null(
        strstr(report, "\"notes\":[{\"severity\":\"warning\",\"text\":\"both images have seed 0"));
    assert_non_null(strstr(report, "\"text\":\"both images are identical: all values"));
    mcv_text_free(report);
    WELL(mcv_picture_compare(a, b, NULL, NULL, &difference, &report, &error));
    assert_non_null(strstr(report, "\"different\":true"));
    assert_null(strstr(report, "identical"));
    assert_int_equal(part_of(difference, 0).width, 16);
    mcv_text_free(report);
    mcv_picture_free(difference);
    mcv_picture_free(a);
    mcv_picture_free(b);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void test_traces(void **state) {
    static const double rays[] = {0, 0, 0, 0, 0, -1}, wrong[] = {0, 0, 0, 0, 0, 0};
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    char *csv = NULL;
    (void)state;
    WELL(mcv_session_trace(session, rig, rays, 1, NULL, &csv, NULL, &error));
    assert_int_equal(strncmp(csv, "ray,vertex,event,", 17), 0);
    assert_non_null(strstr(csv, "\n0,0,"));
    mcv_text_free(csv);
    FAILS(MCV_BAD_INPUT,
          "ray 0:", mcv_session_trace(session, rig, wrong, 1, NULL, &csv, NULL, &error));
    assert_null(csv);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- sweeps --- */

static bool on_row(void *user, const char *row) {
    char *rows = user;
    if (!row) return true;
    strcat(rows, row);
    strcat(rows, "\n");
    return true;
}

static bool on_first_row(void *user, const char *row) {
    unsigned *count = user;
    *count += row != NULL;
    return !row;
}

static void test_sweeps(void **state) {
    static const char options[] =
        "{\"vary\": \"emitters/sky/radiance=1,2,4\", \"metric\": "
        "\"m:=image.mean\", \"region\": \"image=0,0,16,12\", \"spp\": 16}";
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    char rows[4096] = "", *report = NULL;
    unsigned count = 0;
    (void)state;
    WELL(mcv_session_sweep(session, rig, options, on_row, rows, &report, &error));
    for (int i = 0; i < 3; ++i) {
        char expected[64];
        snprintf(expected, sizeof expected, "\"metrics\":{\"m\":{\"value\":%d.0,", 1 << i);
        if (!strstr(rows, expected)) fail_msg("%s\n must hold %s", rows, expected);
    }
    assert_non_null(strstr(rows, "\"set\":2,\"sets\":3,\"parameters\":{\"radiance\":4.0}"));
    assert_non_null(strstr(report, "\"rows\":3,\"failed\":0"));
    mcv_text_free(report);
    FAILS(MCV_INTERRUPTED, "interrupted",
          mcv_session_sweep(session, rig, options, on_first_row, &count, &report, &error));
    assert_int_equal(count, 1);
    assert_null(report);
    FAILS(MCV_USAGE, "vary",
          mcv_session_sweep(session, rig, "{\"metric\": \"mean\"}", NULL, NULL, NULL, &error));
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- the host's locale --- */

static bool on_progress_in_locale(void *user, const mcv_progress *progress) {
    (void)progress;
    *(bool *)user = strcmp(localeconv()->decimal_point, ",") == 0;
    return true;
}

static void test_decimal_comma_does_no_harm(void **state) {
    char *expected = NULL, *got = NULL;
    bool comma_inside = false;
    (void)state;
    if (!make_comma_locale()) skip();
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    for (int i = 0; i < 2; ++i) {
        mcv_rig *rig = parse_rig(sky_rig);
        mcv_picture *picture = NULL, *grey = NULL;
        if (i && !setlocale(LC_ALL, "comma")) skip();
        WELL(mcv_rig_set(rig, "sensors/camera/imageDistance", "12.75mm", &error));
        WELL(mcv_rig_set(rig, "emitters/sky/radiance", "1.5", &error));
        WELL(mcv_session_render(session, rig, "{\"spp\": 16, \"error\": 0.5}",
                                on_progress_in_locale, &comma_inside, &picture, NULL, &error));
        expect_all(picture, 1.5F);
        WELL(mcv_picture_camera(picture, "{\"electrons_per_unit\": \"400.5\", \"gain\": 0.5}",
                                &grey, NULL, &error));
        WELL(mcv_picture_measure(grey, NULL, NULL, "{\"region\": \"a=0.0,0,4,4\"}",
                                 i ? &got : &expected, &error));
        mcv_picture_free(grey);
        mcv_picture_free(picture);
        mcv_rig_free(rig);
    }
    assert_string_equal(got, expected);
    assert_string_equal(localeconv()->decimal_point, ",");
    assert_true(comma_inside);
    setlocale(LC_ALL, "C");
    mcv_text_free(got);
    mcv_text_free(expected);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_options_are_checked),
        cmocka_unit_test(test_values_of_options),
        cmocka_unit_test(test_rig_is_changed_and_read),
        cmocka_unit_test(test_failed_change_leaves_the_rig),
        cmocka_unit_test(test_rig_is_saved),
        cmocka_unit_test(test_reference_renders),
        cmocka_unit_test(test_no_device_is_told),
        cmocka_unit_test(test_progress_and_interruption),
        cmocka_unit_test(test_pictures_from_memory),
        cmocka_unit_test(test_measures_a_mean),
        cmocka_unit_test(test_camera),
        cmocka_unit_test(test_compares),
        cmocka_unit_test(test_traces),
        cmocka_unit_test(test_sweeps),
        cmocka_unit_test(test_decimal_comma_does_no_harm),
    };
    /* The loader of OpenCL finds nothing there. */
    mkdir("no vendors", 0777);
    setenv("OCL_ICD_VENDORS", "no vendors", 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
