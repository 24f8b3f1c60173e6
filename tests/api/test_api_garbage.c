/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Damaged JSON at every place where the public interface takes some: nothing crashes, and each
 * refusal is one sentence. The damage is drawn from a seed, so that a failure can be repeated. With
 * sanitizers (`./run test --asan`) this finds what reads or writes beside its memory.
 */
#include "api.h"

#include "program.h"

enum { ROUNDS = 3000, FILE_ROUNDS = 500, LONGEST = 4096 };

static uint64_t random_state = 1;

static unsigned draw(unsigned below) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(random_state >> 33) % below;
}

/* A text with one to four bytes or words of it changed. */
static size_t damage(const char *text, char out[LONGEST]) {
    static const char *const words[] = {"null",  "-1",       "1e308", "[]",      "{}",
                                        "\"\"",  "\\u0000",  "true",  "0.5",     "1e-9",
                                        "\"x\"", "\xff\xfe", ",",     "99999999"};
    size_t length = strlen(text);
    assert_true(length + 64 < LONGEST);
    memcpy(out, text, length + 1);
    for (unsigned n = 1 + draw(4); n > 0 && length > 1; --n) {
        const size_t at = draw((unsigned)length), rest = length - at;
        const char *word = words[draw(sizeof words / sizeof words[0])];
        const size_t size = strlen(word), gone = 1 + draw(rest < 8 ? (unsigned)rest : 8);
        switch (draw(4)) {
        case 0: /* a byte becomes another one */
            out[at] = (char)(1 + draw(255));
            if (out[at] == '\n') out[at] = ' '; /* sentences quote texts as they are */
            break;
        case 1: /* some bytes are missing */
            memmove(out + at, out + at + gone, rest - gone + 1);
            length -= gone;
            break;
        case 2: /* a word comes in between */
            if (length + size + 1 >= LONGEST) break;
            memmove(out + at + size, out + at, rest + 1);
            /* NOLINTNEXTLINE(bugprone-not-null-terminated-result): into the middle of a text */
            memcpy(out + at, word, size);
            length += size;
            break;
        default: /* a word takes the place of some bytes */
            if (length + size + 1 >= LONGEST) break;
            memmove(out + at + size, out + at + gone, rest - gone + 1);
            /* NOLINTNEXTLINE(bugprone-not-null-terminated-result): into the middle of a text */
            memcpy(out + at, word, size);
            length = length + size - gone;
        }
    }
    return length;
}

/* A result is a success, or a failure with one line. */
static void one_sentence(mcv_result result, const mcv_error *error, const char *call,
                         const char *text) {
    const size_t length = strlen(error->text);
    if (result != MCV_OK && (length == 0 || strchr(error->text, '\n')))
        fail_msg("%s with %s: %d, \"%s\"", call, text, result, error->text);
}

#define TRY(call) \
    do { \
        mcv_error error = {""}; \
        one_sentence((call), &error, #call, text); \
    } while (0)

static bool stop(void *user, const mcv_progress *progress) {
    (void)user;
    (void)progress;
    return false;
}

static bool stop_sweep(void *user, const char *row) {
    (void)user;
    return row != NULL;
}

static void test_damaged_options(void **state) {
    static const char *const renders[] = {
        "{\"spp\": 4, \"seed\": 3, \"sampler\": \"random\", \"set\": "
        "[\"sensors/camera/resolution=[2,2]\"]}",
        "{\"error\": 0.5, \"time\": \"1ms\", \"replicates\": 2, \"parts\": \"replicates\", "
        "\"depth\": 4}",
        "{\"samples\": [0, 4], \"sensor\": \"camera\", \"split\": \"off\"}"};
    static const char *const measures[] = {
        "{\"region\": [\"a=0,0,4,4\", \"b=1,1,3,3\"], \"background\": \"4,4,4,4\", \"noise\": 0.1}",
        "{\"edge\": \"e=0,0,8,8\", \"line\": \"0,0,8,8+8,0,8,8\", \"circle\": \"c=0,0,9,9\", "
        "\"channel\": \"red\"}"};
    static const char camera[] = "{\"expose_to\": 0.5, \"wavelength\": [5e-7, 5.5e-7, 6e-7], "
                                 "\"bits\": 8, \"bayer\": \"RGGB\", \"lens_mtf\": \"none\"}";
    static const char sweep[] = "{\"vary\": \"emitters/sky/radiance=1..2:2\", \"metric\": "
                                "\"m:=image.mean\", \"region\": \"image=0,0,8,8\", \"spp\": 4}";
    mcv_session *session = open_session("{\"device\": \"reference\", \"threads\": 1}"), *other;
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *picture = render(session, rig, "{\"spp\": 4}"), *made = NULL;
    char text[LONGEST], *report;
    (void)state;
    for (int i = 0; i < ROUNDS; ++i) {
        damage("{\"device\": \"reference\", \"threads\": 2, \"precision\": \"double\"}", text);
        TRY(mcv_session_open(text, &other, &error));
        mcv_session_close(other);
        damage(renders[i % 3], text);
        TRY(mcv_session_render(session, rig, text, stop, NULL, &made, &report, &error));
        mcv_picture_free(made);
        mcv_text_free(report);
        damage(measures[i % 2], text);
        TRY(mcv_picture_measure(picture, NULL, NULL, text, &report, &error));
        mcv_text_free(report);
        damage(camera, text);
        TRY(mcv_picture_camera(picture, text, &made, &report, &error));
        mcv_picture_free(made);
        mcv_text_free(report);
        damage(sweep, text);
        TRY(mcv_session_sweep(session, rig, text, stop_sweep, NULL, &report, &error));
        mcv_text_free(report);
        damage("{\"preview\": true, \"parts\": [\"image\"]}", text);
        TRY(mcv_picture_write(picture, "nowhere/x.exr", text, &error));
        damage("{\"a\": \"text\", \"b\": 1.5, \"c\": [1, 2]}", text);
        TRY(mcv_picture_make(1, 1, 1, &(float){1}, NULL, text, &made, &error));
        mcv_picture_free(made);
    }
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void write_bytes(const char *path, const char *text, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fwrite(text, 1, size, file) == size);
    assert_int_equal(fclose(file), 0);
}

/* The text of a camera in a format of another program. */
static char *camera_text(const mcv_rig *rig, const char *options) {
    char *text = NULL;
    WELL(mcv_rig_camera_model(rig, options, &text, &error));
    return text;
}

/* Files of cameras, and the options of what reads and writes them. */
static void test_damaged_cameras(void **state) {
    static const char options[] = "{\"format\": \"halcon\", \"sensor\": \"camera\", "
                                  "\"resolution\": [8, 6], \"output\": \"nowhere/x\"}";
    mcv_rig *rig = parse_rig(sky_rig);
    char *files[4] = {
        camera_text(rig, "{\"format\": \"json\"}"), camera_text(rig, "{\"format\": \"opencv\"}"),
        camera_text(rig, "{\"format\": \"ros\"}"), camera_text(rig, "{\"format\": \"halcon\"}")};
    static const char *const colmap[] = {"1 OPENCV 16 12 1250 1250 8 6 0 0 0 0\n",
                                         "1 1 0 0 0 0.1 0.2 0.3 1 a.png\n\n"};
    char text[LONGEST], *report;
    unsigned read = 0;
    (void)state;
    mkdir("colmap", 0777);
    for (int i = 0; i < FILE_ROUNDS; ++i) {
        mcv_rig *made = parse_rig(sky_rig);
        size_t length = damage(files[i % 4], text);
        write_bytes("camera", text, length);
        TRY(mcv_rig_add_camera(made, "camera", "{\"sensor\": \"x\"}", &report, &error));
        read += report != NULL;
        mcv_text_free(report);
        for (int k = 0; k < 2; ++k) {
            length = damage(colmap[k], text);
            write_bytes(k ? "colmap/images.txt" : "colmap/cameras.txt", text, length);
        }
        TRY(mcv_rig_add_camera(made, "colmap", NULL, &report, &error));
        mcv_text_free(report);
        damage("{\"sensor\": \"y\", \"pixel_size\": \"3um\", \"json\": false}", text);
        TRY(mcv_rig_add_camera(made, "camera", text, &report, &error));
        mcv_text_free(report);
        damage(options, text);
        TRY(mcv_rig_camera_model(made, text, &report, &error));
        mcv_text_free(report);
        mcv_rig_free(made);
    }
    print_message("%d files, %u read\n", FILE_ROUNDS, read);
    assert_true(read > FILE_ROUNDS / 100 && read < FILE_ROUNDS);
    for (int i = 0; i < 4; ++i) mcv_text_free(files[i]);
    mcv_rig_free(rig);
}

static bool stop_told(void *user, const char *report) {
    (void)user;
    return report == NULL;
}

/* Calls that the program makes: what they write goes nowhere, or, where
 * the path is damaged, into the test's folder; each file is flushed to the disk, so that there are
 * fewer rounds. */
static void test_damaged_options_of_files(void **state) {
    static const char files[] = "{\"spp\": 4, \"output\": \"nowhere/x.exr\", \"camera\": "
                                "\"nowhere/y.png\", \"expose_to\": 0.5, \"json\": false}",
                      rays[] = "{\"rays\": \"rays.csv\", \"output\": \"nowhere/t.csv\", "
                               "\"depth\": 4}",
                      compare[] = "{\"output\": \"nowhere/d.png\", \"json\": true}",
                      lightfield[] = "{\"angular\": \"2x2\", \"output\": \"nowhere/v.png\", "
                                     "\"form\": \"mass\"}",
                      check[] = "{\"defines\": true, \"sensor\": \"camera\", \"json\": false}";
    mcv_session *session = open_session("{\"device\": \"reference\", \"threads\": 1}");
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *picture = render(session, rig, "{\"spp\": 4}"), *made;
    char text[LONGEST], *report;
    (void)state;
    write_bytes("rays.csv", "0,0,0,0,0,-1\n", 13);
    for (int i = 0; i < FILE_ROUNDS; ++i) {
        damage(files, text);
        TRY(mcv_session_render_files(session, rig, text, stop, stop_told, NULL, &error));
        damage(rays, text);
        TRY(mcv_session_trace(session, rig, NULL, 0, text, NULL, &report, &error));
        mcv_text_free(report);
        damage(compare, text);
        TRY(mcv_picture_compare(picture, picture, text, NULL, NULL, &report, &error));
        mcv_text_free(report);
        damage(lightfield, text);
        TRY(mcv_picture_views(picture, text, &made, &report, &error));
        mcv_picture_free(made);
        mcv_text_free(report);
        TRY(mcv_picture_emd_gradient(picture, text, &made, &report, &error));
        mcv_picture_free(made);
        mcv_text_free(report);
        damage(check, text);
        TRY(mcv_session_check(session, i % 2 ? rig : NULL, text, &report, &error));
        mcv_text_free(report);
    }
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void test_damaged_rigs(void **state) {
    mcv_session *session = open_session(NULL);
    char text[LONGEST], *report;
    unsigned parsed = 0, checked = 0;
    (void)state;
    for (int i = 0; i < ROUNDS; ++i) {
        mcv_rig *rig = NULL;
        const size_t length = damage(sky_rig, text);
        TRY(mcv_rig_parse(text, length, NULL, &rig, &error));
        if (!rig) continue;
        ++parsed;
        TRY(mcv_session_check(session, rig, NULL, &report, &error));
        checked += report != NULL;
        mcv_text_free(report);
        TRY(mcv_rig_paths(rig, &report, &error));
        mcv_text_free(report);
        TRY(mcv_rig_get(rig, "sensors/camera", &report, &error));
        mcv_text_free(report);
        TRY(mcv_rig_set(rig, "emitters/sky/radiance", "3", &error));
        mcv_rig_free(rig);
    }
    print_message("%d documents, %u parsed, %u checked\n", ROUNDS, parsed, checked);
    assert_true(parsed > ROUNDS / 100 && checked < parsed);
    mcv_session_close(session);
}

static void test_damaged_paths(void **state) {
    static const char *const paths[] = {"sensors/camera/resolution", "nodes/camera/translation/z",
                                        "emitters/0/radiance", "materials/x/ior", "spectrum/y"};
    mcv_rig *rig = parse_rig(sky_rig);
    char text[LONGEST], value[LONGEST], *json;
    (void)state;
    for (int i = 0; i < ROUNDS; ++i) {
        damage(paths[i % 5], text);
        damage("[1, \"2mm\", {\"a\": null}]", value);
        TRY(mcv_rig_get(rig, text, &json, &error));
        mcv_text_free(json);
        TRY(mcv_rig_set(rig, text, value, &error));
    }
    mcv_rig_free(rig);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_damaged_options),
        cmocka_unit_test(test_damaged_cameras),
        cmocka_unit_test(test_damaged_options_of_files),
        cmocka_unit_test(test_damaged_rigs),
        cmocka_unit_test(test_damaged_paths),
    };
    mkdir("no vendors", 0777);
    setenv("OCL_ICD_VENDORS", "../no vendors", 1);
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
