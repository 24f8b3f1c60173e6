/* SPDX-License-Identifier: Apache-2.0 */
/* The program as its users meet it: what it writes, what it says of bad input, and that it leaves
 * nothing half-written. */
#include "test.h"

#include <ctype.h>
#include <dirent.h>
#include <fcntl.h>
#include <math.h>
#include <png.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <jansson.h>

#include "analysis/noise.h"
#include "area_samples.h"
#include "io/exr.h"
#include "core/output_file.h"
#include "io/figure.h"
#include "scene/camera_model.h"

/* Which of the tests run: no file of them shall take long. */
enum { PART_MAKE, PART_MEASURE, PART_LIGHT_FIELD };
#ifndef PART
#define PART PART_MAKE
#endif

#define PROGRAM MCV_BINARY_DIR "/mcvisi"

enum { MAX_ARGUMENTS = 24, MAX_TEXT = 1 << 18 };

static char folder[64]; /* the working folder of the program, emptied before each test */
static char out[MAX_TEXT], err[MAX_TEXT];

/* --- scenes
 * -----------------------------------------------------------------------------------------------------
 */

/* Looks along -z from the origin; an emitter stands 1 m before it and faces it. */
static const char scene_format[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_emitters\"],\"extensions\":{"
    "\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",%s}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"panel\",%s}]}},"
    "\"nodes\":[{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},"
    "{\"translation\":[0,0,-1],\"rotation\":[0,1,0,0],\"extensions\":{\"MCVISI_emitters\":{"
    "\"emitter\":0}}}]}";

/* 24 x 16 pixels that see 0.96 m x 0.64 m at a distance of 1 m: 40 mm each. */
static const char pinhole[] =
    "\"type\":\"pinhole\",\"imageDistance\":0.01,\"resolution\":[24,16],\"pixelSize\":0.0004";
static const char panel[] =
    "\"type\":\"area\",\"size\":[0.48,0.32],\"radiance\":2.5"; /* ends between pixels */
static const char panel_noisy[] =
    "\"type\":\"area\",\"size\":[0.4931,0.3317],\"radiance\":2.5"; /* ends inside pixels */

static void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void write_scene(const char *path, const char *sensor, const char *emitter) {
    char text[2048];
    assert_true(snprintf(text, sizeof text, scene_format, sensor, emitter) < (int)sizeof text);
    write_text(path, text);
}

/* --- running the program
 * ---------------------------------------------------------------------------------------- */

static int fresh_folder(void **state) {
    (void)state;
    char command[256];
    if (!folder[0]) {
        strcpy(folder, "test_cli.XXXXXX");
        if (!mkdtemp(folder)) return -1;
        return chdir(folder);
    }
    snprintf(command, sizeof command, "rm -rf ../%s/* ../%s/.[!.]*", folder, folder);
    return system(command);
}

static int remove_folder(void **state) {
    (void)state;
    char command[256];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return chdir("..") || system(command);
}

/* Files in the working folder, hidden ones too. */
static int count_files(void) {
    int count = 0;
    DIR *directory = opendir(".");
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(directory);
    return count;
}

/* Starts the program with the words of a line as arguments. Its output goes to files beside the
 * working folder. */
static pid_t start(const char *line) {
    char words[1024];
    char *arguments[MAX_ARGUMENTS] = {(char *)PROGRAM};
    pid_t pid;
    posix_spawn_file_actions_t actions;
    assert_true(snprintf(words, sizeof words, "%s", line) < (int)sizeof words);
    int count = 1;
    for (char *rest = NULL, *word = strtok_r(words, " ", &rest); word;
         word = strtok_r(NULL, " ", &rest)) {
        assert_true(count + 1 < MAX_ARGUMENTS);
        arguments[count++] = word;
    }
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, "../test_cli.out", O_WRONLY | O_CREAT | O_TRUNC,
                                     0666);
    posix_spawn_file_actions_addopen(&actions, 2, "../test_cli.err", O_WRONLY | O_CREAT | O_TRUNC,
                                     0666);
    assert_int_equal(posix_spawn(&pid, PROGRAM, &actions, NULL, arguments, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    return pid;
}

static void read_text(const char *path, char text[MAX_TEXT]) {
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, MAX_TEXT - 1, file)] = '\0';
    fclose(file);
}

static int finish(pid_t pid) {
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    read_text("../test_cli.out", out);
    read_text("../test_cli.err", err);
    if (WIFSIGNALED(status)) return -WTERMSIG(status);
    return WEXITSTATUS(status);
}

static int run(const char *line) { return finish(start(line)); }

static void run_well(const char *line) {
    const int code = run(line);
    if (code != 0) fail_msg("mcvisi %s: exit code %d: %s", line, code, err);
}

/* Exit code, and one line on standard error that holds each of the parts; and no file more or less
 * than before. */
static void expect_failure(const char *line, int code, const char *const parts[]) {
    const int files = count_files();
    const int got = run(line);
    if (got != code) fail_msg("mcvisi %s: exit code %d instead of %d: %s", line, got, code, err);
    const char *end = strchr(err, '\n');
    if (!end || end[1] != '\0')
        fail_msg("mcvisi %s: not one line on standard error: %s", line, err);
    for (; *parts; ++parts)
        if (!strstr(err, *parts))
            fail_msg("mcvisi %s: \"%s\" is missing in: %s", line, *parts, err);
    if (out[0] != '\0') fail_msg("mcvisi %s: printed a result: %s", line, out);
    if (count_files() != files)
        fail_msg("mcvisi %s: there were %d files and now there are %d", line, files, count_files());
}
#define EXPECT_FAILURE(line, code, ...) \
    expect_failure(line, code, (const char *const[]){__VA_ARGS__, NULL})

/* --- usage
 * ------------------------------------------------------------------------------------------------------
 */

static void test_wrong_usage(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    EXPECT_FAILURE("", 2, "mcvisi help");
    EXPECT_FAILURE("rendr s.gltf", 2, "rendr", "did you mean render?");
    EXPECT_FAILURE("render", 2, "SCENE");
    EXPECT_FAILURE("render s.gltf t.gltf", 2, "t.gltf");
    EXPECT_FAILURE("render s.gltf --sp 4", 2, "unknown option --sp: did you mean --spp?");
    EXPECT_FAILURE("render s.gltf --temperature=4", 2, "unknown option --temperature",
                   "mcvisi help render");
    EXPECT_FAILURE("render s.gltf -x", 2, "-x", "mcvisi help render");
    EXPECT_FAILURE("check s.gltf --spp 4", 2, "--spp is an option of render, not of check");
    EXPECT_FAILURE("render s.gltf --spp", 2, "--spp needs a value");
    EXPECT_FAILURE("render s.gltf --spp --json", 2, "--spp needs a value");
    EXPECT_FAILURE("render s.gltf --json=1", 2, "--json takes no value");
    EXPECT_FAILURE("render s.gltf --spp 0", 2, "--spp 0", "from 1");
    EXPECT_FAILURE("render s.gltf --spp 4x", 2, "--spp 4x");
    EXPECT_FAILURE("render s.gltf --spp -4", 2, "--spp -4");
    EXPECT_FAILURE("render s.gltf --error nan", 2, "--error nan");
    EXPECT_FAILURE("render s.gltf --time 0", 2, "--time 0", "above 0");
    EXPECT_FAILURE("render s.gltf --resolution 640", 2, "--resolution 640", "640x480");
    EXPECT_FAILURE("render s.gltf --resolution 0x4", 2, "--resolution 0x4");
    EXPECT_FAILURE("render s.gltf --samples 4:4", 2, "--samples 4:4", "A < B");
    EXPECT_FAILURE("render s.gltf --samples 3:5", 2, "3:5", "power of two");
    EXPECT_FAILURE("render s.gltf --samples 0:4 --spp 16", 2, "--spp", "--samples");
    EXPECT_FAILURE("render s.gltf --sampler sobo", 2, "--sampler sobo", "sobol|random");
    EXPECT_FAILURE("render s.gltf --replicates 1 --error 0.1", 2, "--error", "--replicates");
    EXPECT_FAILURE("render s.gltf --adaptive --samples 0:4", 2, "--adaptive", "--samples", "--spp");
    EXPECT_FAILURE("render s.gltf --adaptive=maybe", 2, "--adaptive maybe", "auto|on|off");
    EXPECT_FAILURE("render s.gltf --adaptive on --samples 0:4", 2, "--adaptive", "--samples");
    EXPECT_FAILURE("render s.gltf --adaptive --device reference", 2, "--adaptive", "reference");
    EXPECT_FAILURE("render s.gltf --adaptive --precision double", 2, "--adaptive", "reference");
    EXPECT_FAILURE("render s.gltf --sensor left", 2, "s.gltf", "left", "cam");
    EXPECT_FAILURE("trace s.gltf", 2, "--rays");
    EXPECT_FAILURE("devices s.gltf", 2, "s.gltf");
    EXPECT_FAILURE("check", 2, "SCENE");
    EXPECT_FAILURE("help rendr", 2, "did you mean render?");
    EXPECT_FAILURE("render s.gltf -o s.gltf", 2, "s.gltf", "the scene");
    EXPECT_FAILURE("render s.gltf -o a.png", 2, "a.png", "--png");
}

static void test_help(void **state) {
    (void)state;
    run_well("--version");
    assert_string_equal(out, "mcvisi " MCV_VERSION "\n");
    run_well("help");
    assert_non_null(strstr(out, "mcvisi render SCENE"));
    run_well("help render");
    assert_non_null(strstr(out, "--replicates R"));
    assert_null(strstr(out, "--rays"));
    run_well("trace --help");
    assert_non_null(strstr(out, "--rays rays.csv"));
}

/* --- bad input
 * --------------------------------------------------------------------------------------------------
 */

static void test_bad_files(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    EXPECT_FAILURE("render missing.gltf", 3, "missing.gltf");
    EXPECT_FAILURE("check missing.gltf", 3, "missing.gltf");
    assert_int_equal(mkdir("folder.gltf", 0777), 0);
    EXPECT_FAILURE("render folder.gltf", 3, "folder.gltf", "directory");
    EXPECT_FAILURE("render s.gltf -o absent/x.exr", 3, "absent/x.exr");
    EXPECT_FAILURE("render s.gltf -o folder.gltf", 3, "folder.gltf");
    EXPECT_FAILURE("render s.gltf --png absent/x.png", 3, "absent/x.png");
    EXPECT_FAILURE("render s.gltf --resolution 40000x1", 3, "s.gltf", "sensors/cam", "40000",
                   "32768");

    /* A GLB that promises more than there is: cut in its header, its JSON and its buffer. */
    char command[256];
    const int cuts[] = {3, 15, 400, -1};
    for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; ++i) {
        snprintf(command, sizeof command, "head -c %d '%s/scenes/furnace.glb' > cut.glb", cuts[i],
                 MCV_SOURCE_DIR);
        assert_int_equal(system(command), 0);
        EXPECT_FAILURE("render cut.glb", 3, "cut.glb");
    }
}

static void test_bad_scenes(void **state) {
    (void)state;
    write_text("blind.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":["
                             "0]}],\"nodes\":[{\"name\":\"n\"}]}");
    EXPECT_FAILURE("render blind.gltf", 3, "blind.gltf", "sensor");
    write_scene("cone.gltf", pinhole,
                "\"type\":\"parallel\",\"size\":1,\"radiance\":1,\"halfAngle\":0");
    EXPECT_FAILURE("render cone.gltf", 3, "cone.gltf", "panel/halfAngle", "collimated beam");
    write_scene("near.gltf",
                "\"type\":\"telecentric\",\"focalLength\":0.02,\"imageDistance\":0.02,"
                "\"stopDiameter\":0.001,\"lensDiameter\":0.01,"
                "\"resolution\":[8,8],\"pixelSize\":\"5um\"",
                panel);
    EXPECT_FAILURE("render near.gltf", 3, "near.gltf", "cam/imageDistance",
                   "must exceed focalLength");
    write_scene(
        "key.gltf",
        "\"type\":\"pinhole\",\"imagedistance\":0.01,\"resolution\":[24,16],\"pixelSize\":0.0004",
        panel);
    EXPECT_FAILURE("render key.gltf", 3, "key.gltf", "cam", "imagedistance",
                   "did you mean \"imageDistance\"?");
    write_scene("s.gltf", pinhole, panel);
    EXPECT_FAILURE("render s.gltf --set sensors/cam/imageDistance=0", 3, "s.gltf",
                   "cam/imageDistance", "above 0");
    EXPECT_FAILURE("render s.gltf --set sensors/cma/imageDistance=1", 3, "s.gltf", "cma");
    EXPECT_FAILURE("render s.gltf --set sensors/cam/imageDistance", 2, "sensors/cam/imageDistance",
                   "PATH=VALUE");
}

/* No name in a file steers a terminal: control characters come as JSON writes them. */
static void test_names_with_control_characters(void **state) {
    static const char *const lines[] = {"check c.gltf", "render c.gltf --spp 1",
                                        "render c.gltf --sensor x"};
    char text[2048];
    (void)state;
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
             "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"c\\u001b[31m\\u009bü\","
             "%s}]},\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"p\\u007f\\t\",%s}]}},"
             "\"nodes\":[{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},"
             "{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},"
             "{\"translation\":[0,0,-1],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}",
             pinhole, panel);
    write_text("c.gltf", text);
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        assert_int_equal(run(lines[i]), i == 2 ? 2 : 0);
        const char *const said[] = {out, err};
        for (int k = 0; k < 2; ++k)
            for (const char *c = said[k]; *c; ++c)
                if ((iscntrl((unsigned char)*c) && *c != '\n') ||
                    (c[0] == '\xc2' && (unsigned char)c[1] < 0xa0))
                    fail_msg("mcvisi %s: prints the byte 0x%02x", lines[i], (unsigned char)*c);
        if (!strstr(i == 0 ? out : err, "c\\u001b[31m\\u009bü"))
            fail_msg("mcvisi %s: no name in %s%s", lines[i], out, err);
        if (i < 2 && !strstr(i == 0 ? out : err, "p\\u007f\\u0009\""))
            fail_msg("mcvisi %s: no emitter's name in %s%s", lines[i], out, err);
    }
}

static void test_no_device(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    assert_int_equal(mkdir("vendors", 0777), 0);
    assert_int_equal(setenv("OCL_ICD_VENDORS", "vendors/", 1), 0);
    EXPECT_FAILURE("render s.gltf", 4, "no OpenCL device", "pocl-opencl-icd");
    EXPECT_FAILURE("devices", 4, "no OpenCL device", "pocl-opencl-icd");
    assert_int_equal(unsetenv("OCL_ICD_VENDORS"), 0);
    EXPECT_FAILURE("render s.gltf --device 99", 4, "99", "mcvisi devices");
}

/* --- render
 * -----------------------------------------------------------------------------------------------------
 */

static const mcv_attribute *attribute(const mcv_exr *exr, const char *name) {
    for (uint32_t i = 0; i < exr->attribute_count; ++i)
        if (strcmp(exr->attributes[i].name, name) == 0) return exr->attributes + i;
    fail_msg("attribute %s is missing", name);
    return NULL;
}

static mcv_exr read_exr(const char *path) {
    mcv_exr exr;
    mcv_error error = {""};
    if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    return exr;
}

static void expect_png(const char *path, uint32_t width, uint32_t height) {
    png_image image = {.version = PNG_IMAGE_VERSION};
    if (!png_image_begin_read_from_file(&image, path)) fail_msg("%s: %s", path, image.message);
    assert_int_equal(image.width, width);
    assert_int_equal(image.height, height);
    png_image_free(&image);
}

/*
 * The panel fills the middle half of the image in both directions. Pixels that do not touch its
 * edge are the radiance, exactly, or black; at the edge a sample may fall on either side by the
 * rounding of its direction.
 */
static void expect_panel(const char *path, uint32_t width, uint32_t height) {
    mcv_exr exr = read_exr(path);
    const mcv_image *image = &exr.parts[0].image;
    assert_int_equal(exr.part_count, 2);
    assert_string_equal(exr.parts[1].name, "error");
    assert_string_equal(exr.parts[0].channel_names[0], "Y");
    assert_int_equal(image->width, width);
    assert_int_equal(image->height, height);
    for (uint32_t row = 0; row < height; ++row) {
        for (uint32_t column = 0; column < width; ++column) {
            const bool inside = column > width / 4 && column < 3 * width / 4 - 1 &&
                                row > height / 4 && row < 3 * height / 4 - 1;
            const bool outside = column < width / 4 - 1 || column > 3 * width / 4 ||
                                 row < height / 4 - 1 || row > 3 * height / 4;
            const float value = image->pixels[row * width + column];
            const float error = exr.parts[1].image.pixels[row * width + column];
            if ((inside && value != 2.5f) || (outside && value != 0) ||
                ((inside || outside) && error != 0))
                fail_msg("%s: pixel (%u, %u) is %g ± %g", path, column, row, (double)value,
                         (double)error);
        }
    }
    mcv_exr_free(&exr);
}

/* The part that tells where the samples went: some pixels have more, some fewer, all a power of
 * two, on the average what was allowed at most. */
static void test_render_adaptive(void **state) {
    double sum = 0, least = INFINITY, most = 0;
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    run_well(
        "render s.gltf --spp 256 --resolution 94x62 --adaptive --sampler random"); /* the panel ends
                                                                                      within pixels
                                                                                    */
    assert_non_null(strstr(out, "samples on the average"));
    mcv_exr exr = read_exr("s.exr");
    assert_string_equal(attribute(&exr, "mcvisi:sampling")->text, "adaptive");
    assert_int_equal(exr.part_count, 3);
    assert_string_equal(exr.parts[2].name, "samples");
    for (size_t i = 0; i < 94 * 62; ++i) {
        const double samples = (double)exr.parts[2].image.pixels[i];
        if (exp2(rint(log2(samples))) != samples) fail_msg("pixel %zu has %g samples", i, samples);
        sum += samples;
        least = fmin(least, samples);
        most = fmax(most, samples);
    }
    if (!(sum <= 256 * 94 * 62 && least < 256 && most > 256))
        fail_msg("%g to %g samples, mean %g", least, most, sum / (94 * 62));
    mcv_exr_free(&exr);
    /* Alone it may stand before the scene; with `auto` and `off` nothing is wrong with a part of
     * the samples. */
    static const char *const uniform[] = {"render s.gltf --spp 256 --adaptive off",
                                          "render --adaptive auto s.gltf --samples 0:4"};
    for (int i = 0; i < 2; ++i) {
        run_well(uniform[i]);
        exr = read_exr("s.exr");
        assert_string_equal(attribute(&exr, "mcvisi:sampling")->text, "uniform");
        assert_int_equal(exr.part_count, 2);
        mcv_exr_free(&exr);
    }
    run_well("render --adaptive s.gltf --spp 256 --resolution 94x62 --sampler random");
    exr = read_exr("s.exr");
    assert_string_equal(attribute(&exr, "mcvisi:sampling")->text, "adaptive");
    mcv_exr_free(&exr);
    /* It is the default, and has other random numbers: what needs the same noise is told. */
#define PICTURE "render s.gltf --spp 256 --resolution 94x62 --sampler random --parts replicates "
    run_well(PICTURE "-o auto.exr");
    exr = read_exr("auto.exr");
    assert_string_equal(attribute(&exr, "mcvisi:sampling")->text, "adaptive");
    mcv_exr_free(&exr);
    run_well(PICTURE "--adaptive off -o off.exr");
    run_well("detect auto.exr off.exr --electrons-per-unit 1000");
    if (!strstr(err, "--adaptive off for both")) fail_msg("%s", err);
    run_well("detect auto.exr auto.exr --electrons-per-unit 1000");
    if (strstr(err, "--adaptive")) fail_msg("%s", err);
#undef PICTURE
}

static bool file_says(const char *path, const char *text) {
    char *line = NULL;
    size_t room = 0;
    bool found = false;
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    while (!found && getline(&line, &room, file) > 0) found = strstr(line, text) != NULL;
    free(line);
    fclose(file);
    return found;
}

/* A pilot decides how many light paths a picture has, and each picture has its own: the header says
 * how many, and what needs the same noise tells where they differ. */
static void test_pictures_that_differ_in_light_paths(void **state) {
#define PICTURE \
    "render " MCV_SOURCE_DIR \
    "/scenes/caustic.gltf --resolution 24x24 --spp 8 --adaptive off --parts replicates "
    static const char *const lines[] = {PICTURE "--light-paths on -o on.exr",
                                        PICTURE "--light-paths off -o off.exr"};
#undef PICTURE
    (void)state;
    for (int i = 0; i < 2; ++i) {
        run_well(lines[i]);
        mcv_exr exr = read_exr(i == 0 ? "on.exr" : "off.exr");
        const double paths = attribute(&exr, "mcvisi:lightPaths")->numbers[0];
        if (i == 0 ? !(paths > 0) : paths != 0) fail_msg("%s: %g light paths", lines[i], paths);
        mcv_exr_free(&exr);
    }
    run_well("detect on.exr off.exr --electrons-per-unit 1000 --html pair.html");
    if (!strstr(err, "--light-paths on helps")) fail_msg("%s", err);
    assert_true(file_says("pair.html", "differ in their light paths"));
    run_well("detect on.exr on.exr --electrons-per-unit 1000 --html same.html");
    if (strstr(err, "light paths")) fail_msg("%s", err);
    assert_false(file_says("same.html", "differ in their light paths"));
}

static void test_render_writes_pictures(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    run_well("render s.gltf --spp 5 --seed 7 --set emitters/panel/radiance=2.5");
    assert_non_null(
        strstr(out, "cam: 24 x 16 pixels, 8 samples each")); /* 4 replicates of ceil(5/4) = 2 */
    assert_string_equal(err, "");
    expect_png("s.png", 24, 16);
    expect_panel("s.exr", 24, 16);
    assert_int_equal(count_files(), 3);

    mcv_exr exr = read_exr("s.exr");
    assert_string_equal(attribute(&exr, "mcvisi:version")->text, MCV_VERSION);
    assert_string_equal(attribute(&exr, "mcvisi:scene")->text, "s.gltf");
    assert_string_equal(attribute(&exr, "mcvisi:set")->text, "emitters/panel/radiance=2.5");
    assert_string_equal(attribute(&exr, "mcvisi:sensor")->text, "cam");
    assert_string_equal(attribute(&exr, "mcvisi:unit")->text, "W/(m^2 sr)");
    assert_int_equal(strlen(attribute(&exr, "mcvisi:sceneFNV1a")->text), 16);
    assert_true(attribute(&exr, "mcvisi:seed")->numbers[0] == 7);
    assert_true(attribute(&exr, "mcvisi:replicates")->numbers[0] == 4);
    assert_true(attribute(&exr, "mcvisi:samplesPerReplicate")->numbers[0] == 2);
    mcv_exr_free(&exr);

    /* A part of the film, binned: its header says so. */
    run_well("render s.gltf --spp 4 -o part.exr --set sensors/cam/regionOfInterest=[4,2,16,8] "
             "--set sensors/cam/principalPoint=[10,9] "
             "--set sensors/cam/binning=[2,2]");
    exr = read_exr("part.exr");
    assert_int_equal(exr.parts[0].image.width, 8);
    assert_int_equal(exr.parts[0].image.height, 4);
    const double *region = attribute(&exr, "mcvisi:regionOfInterest")->numbers;
    assert_true(region[0] == 4 && region[1] == 2 && region[2] == 16 && region[3] == 8);
    mcv_exr_free(&exr);

    /* More pixels, the same field of view. */
    run_well("render s.gltf --spp 4 --resolution 48x32 -o big.exr --png small.png");
    expect_panel("big.exr", 48, 32);
    expect_png("small.png", 48, 32);

    /* One replicate has no error. */
    run_well("render s.gltf --spp 4 --replicates 1 -o one.exr");
    exr = read_exr("one.exr");
    assert_int_equal(exr.part_count, 1);
    mcv_exr_free(&exr);
}

static void test_reference_device(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    run_well("render s.gltf --spp 8 --device reference");
    expect_panel("s.exr", 24, 16);
    /* The variable counts as the option does, which is before it. */
    assert_int_equal(setenv("MCVISI_OPENCL_DEVICE", "reference", 1), 0);
    run_well("render s.gltf --spp 8 --json");
    unsetenv("MCVISI_OPENCL_DEVICE");
    if (!strstr(out, "\"device\": \"reference")) fail_msg("%s", out);
    expect_panel("s.exr", 24, 16);
}

/* The panel is seen alike; the file says what was computed how. Double is the reference renderer,
 * whatever else is asked for. */
static void test_precision(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    static const char *const words[] = {"single", "mixed", "double"};
    for (int i = 0; i < 3; ++i) {
        char line[64];
        snprintf(line, sizeof line, "render s.gltf --spp 8 --precision %s", words[i]);
        run_well(line);
        expect_panel("s.exr", 24, 16);
        mcv_exr exr = read_exr("s.exr");
        const mcv_attribute *said = mcv_exr_attribute(&exr, "mcvisi:precision");
        assert_non_null(said);
        assert_string_equal(said->text, words[i]);
        mcv_exr_free(&exr);
    }
    EXPECT_FAILURE("render s.gltf --precision half", 2, "--precision half", "single|mixed|double");
    EXPECT_FAILURE("render s.gltf --precision mixed --device reference", 2, "--precision mixed",
                   "double");
    EXPECT_FAILURE("render s.gltf --precision double --device 0", 2, "--precision double",
                   "--device 0");
    EXPECT_FAILURE("render s.gltf --precision double --schedule tile", 2, "--precision double",
                   "--schedule");
    write_text("rays.csv", "0,0,0,0,0,-2\n");
    EXPECT_FAILURE("trace s.gltf --rays rays.csv --precision double --device 0", 2,
                   "--precision double", "--device 0");
}

/* Light field images are judged by their neighbours: all have the same noise unless it is asked
 * otherwise. */
static void test_light_fields_are_uniform(void **state) {
    (void)state;
#define QUICK \
    "render " MCV_SOURCE_DIR "/scenes/light-field.gltf --spp 64 --resolution 16x16 -o s.exr "
    run_well(QUICK);
    assert_non_null(strstr(out, "64 samples each"));
    run_well(QUICK "--adaptive");
    assert_non_null(strstr(out, "samples on the average"));
}

/* The field of view of a light field camera is M macro pixels wide: with other macro pixels it must
 * see the panel alike. */
static void test_light_field_resolution(void **state) {
    (void)state;
    write_scene("s.gltf",
                "\"type\":\"lightField\",\"focalLength\":\"9.900990099009901mm\",\"imageDistance\":"
                "0.01,\"lensDiameter\":\"1mm\","
                "\"spatialResolution\":[24,16],\"angularResolution\":[2,2],\"pixelSize\":0.0002",
                panel);
    run_well("render s.gltf --spp 4 --resolution 12x8 --device reference");
    /* Focused on the panel: all 2 x 2 pixels of a macro pixel see its centre, so none sees the
     * edge. */
    expect_panel("s.exr", 24, 16);
}

static void test_several_sensors(void **state) {
    (void)state;
    char text[2048];
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
             "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_emitters\"],\"extensions\":{"
             "\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"left\",%s},{\"name\":\"a/b\",%s}]},"
             "\"MCVISI_emitters\":{\"emitters\":[{\"type\":\"environment\",\"radiance\":1}]}},"
             "\"nodes\":[{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{\"extensions\":{"
             "\"MCVISI_sensors\":{\"sensor\":1}}},"
             "{\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}",
             pinhole, pinhole);
    write_text("two.gltf", text);
    run_well("render two.gltf --spp 4 --device reference");
    expect_png("two-left.png", 24, 16);
    expect_png("two-a_b.png", 24, 16);
    assert_int_equal(count_files(), 5);
    run_well("render two.gltf --spp 4 --sensor a/b -o only.exr --device reference");
    expect_png("only.png", 24, 16);
    assert_int_equal(count_files(), 7);

    /* Both names make one file's: one picture would replace the other. */
    char *name = strstr(text, "left");
    assert_non_null(name);
    memcpy(name, "a_b\",", 5);
    memmove(name + 5, name + 6, strlen(name + 6) + 1);
    write_text("same.gltf", text);
    EXPECT_FAILURE("render same.gltf --spp 4", 3, "same-a_b.exr", "a_b", "a/b", "--sensor");
}

static void test_json(void **state) {
    (void)state;
    json_error_t failure;
    write_scene("s.gltf", pinhole, panel);
    run_well("render s.gltf --spp 16 --json");
    json_t *root = json_loads(out, 0, &failure);
    if (!root) fail_msg("line %d: %s", failure.line, failure.text);
    assert_int_equal(json_integer_value(json_object_get(root, "samples")), 16);
    assert_int_equal(json_integer_value(json_object_get(json_object_get(root, "rays"), "paths")),
                     16 * 24 * 16);
    assert_int_equal(json_integer_value(json_object_get(root, "width")), 24);
    assert_string_equal(json_string_value(json_array_get(json_object_get(root, "features"), 0)),
                        "area");
    assert_true(
        json_number_value(json_object_get(json_object_get(root, "seconds"), "first_sample")) > 0);
    assert_true(json_is_false(json_object_get(root, "interrupted")));
    assert_true(json_object_size(json_object_get(root, "stages")) > 0);
    const char *stage;
    json_t *seconds;
    json_object_foreach(json_object_get(root, "stages"), stage, seconds)
        assert_true(json_number_value(seconds) > 0);
    json_decref(root);

    run_well("check s.gltf --json");
    root = json_loads(out, 0, &failure);
    if (!root) fail_msg("line %d: %s", failure.line, failure.text);
    const json_t *emitter = json_array_get(json_object_get(root, "emitters"), 0);
    /* Lambert: power = π L A, exitance π L. json_real keeps doubles whole, so that only the
     * products' rounding is left. */
    const double power = json_number_value(json_array_get(json_object_get(emitter, "power"), 0));
    const double expected = M_PI * 2.5 * 0.48 * 0.32;
    /* The size is rounded to float32 in the mesh, twice. */
    if (!(fabs(power - expected) <= 2 * 0x1p-24 * expected + 1e-15))
        fail_msg("power %.17g instead of %.17g", power, expected);
    json_decref(root);
    run_well("devices --json");
    root = json_loads(out, 0, &failure);
    if (!root) fail_msg("line %d: %s", failure.line, failure.text);
    assert_true(json_array_size(json_object_get(root, "devices")) > 0);
    json_decref(root);
}

/* Two halves of the samples make the whole: each pixel is their mean but for the rounding of three
 * values to float32. */
static void test_sample_ranges(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel_noisy);
    run_well("render s.gltf --samples 0:8 -o all.exr");
    run_well("render s.gltf --samples 0:4 -o first.exr");
    run_well("render s.gltf --samples 4:8 -o second.exr");
    mcv_exr all = read_exr("all.exr"), first = read_exr("first.exr"),
            second = read_exr("second.exr");
    int different = 0;
    for (int i = 0; i < 24 * 16; ++i) {
        const double a = (double)first.parts[0].image.pixels[i],
                     b = (double)second.parts[0].image.pixels[i];
        const double mean = (double)all.parts[0].image.pixels[i];
        different += a != b;
        /* Half an ulp of each, at most 2^-24 of 2.5 in the whole and half of that from each half.
         */
        if (fabs(mean - (a + b) / 2) > 2 * 0x1p-24 * 2.5)
            fail_msg("pixel %d: %.9g and %.9g do not make %.9g", i, a, b, mean);
    }
    assert_true(different > 0); /* the panel's edge is noisy */
    assert_true(attribute(&second, "mcvisi:firstSample")->numbers[0] == 4);
    mcv_exr_free(&all);
    mcv_exr_free(&first);
    mcv_exr_free(&second);
}

/* --- check and trace
 * -------------------------------------------------------------------------------------------- */

static void test_check(void **state) {
    (void)state;
    write_scene("s.gltf",
                "\"type\":\"telecentric\",\"magnification\":0.25,\"workingDistance\":\"110mm\","
                "\"fNumber\":8,"
                "\"resolution\":[2448,2048],\"pixelSize\":\"3.45um\"",
                panel);
    run_well("check s.gltf --memory 1.5GiB");
    assert_non_null(strstr(out, "limit                 1.5 GiB"));
    /* f = W m/(1 + m), b = f (1 + m), D_t = (b - f)/N, NA = m/(2N). */
    assert_non_null(strstr(out, "focalLength         22 mm"));
    assert_non_null(strstr(out, "imageDistance       27.5 mm"));
    assert_non_null(strstr(out, "stopDiameter        687.5 µm"));
    assert_non_null(strstr(out, "numericalAperture   0.015625"));
    assert_non_null(strstr(out, "magnification       0.25"));
    /* A cone of a tenth of the aperture's lights about a hundredth of the pupil; turned round, the
     * panel lights nothing. */
    run_well(
        "check s.gltf --set emitters/panel/type=parallel --set emitters/panel/halfAngle=1.5625e-3");
    assert_non_null(strstr(out, "share of pupil lit"));
    assert_non_null(strstr(out, "% of the pupil of sensor \"cam\""));
    run_well("check s.gltf --set nodes/1/rotation=[0,0,0,1]");
    assert_non_null(strstr(out, "emitter \"panel\" lights nothing"));
    run_well("check s.gltf --json --set nodes/1/rotation=[0,0,0,1]");
    json_t *root = json_loads(out, 0, NULL);
    const json_t *findings = json_object_get(root, "findings"),
                 *first = json_array_get(findings, 0);
    assert_string_equal(json_string_value(json_object_get(first, "severity")), "error");
    assert_string_equal(json_string_value(json_object_get(first, "path")), "emitters/panel");
    assert_non_null(strstr(json_string_value(json_object_get(first, "text")),
                           "emitter \"panel\" lights nothing"));
    assert_int_equal(json_array_size(json_object_get(root, "warnings")), json_array_size(findings));
    json_decref(root);
    run_well("check s.gltf --html s.html");
    assert_int_equal(access("s.html", R_OK), 0);
    EXPECT_FAILURE("check s.gltf --html missing/s.html", 3, "missing/s.html");
    run_well("render s.gltf --spp 4 --set nodes/1/rotation=[0,0,0,1] --device reference");
    assert_ptr_equal(strstr(err, "mcvisi: error: emitter \"panel\" lights nothing"), err);
    assert_non_null(
        strstr(err, "mcvisi: warning: sensor \"cam\" looks at the back of emitter \"panel\""));
    run_well("check s.gltf --defines");
    assert_non_null(strstr(out, "-DMCV_SENSOR=telecentric"));
    assert_non_null(strstr(out, "-DMCV_WITH_AREA=1"));
    assert_non_null(strstr(out, "-DMCV_WITH_DIELECTRIC=0"));
    run_well("check --defines");
    assert_non_null(strstr(out, "-DMCV_CHANNELS=3"));
    assert_non_null(strstr(out, "-DMCV_SENSOR=light_field"));
    assert_null(strstr(out, "WITH_AREA=0"));
}

static void expect_trace(const char *line) {
    run_well(line);
    read_text("paths.csv", out);
    int rows = 0;
    for (const char *c = out; *c; ++c) rows += *c == '\n';
    assert_int_equal(rows, 1 + 2 + 2);
    assert_non_null(strstr(out, "ray,vertex,event,x [m],y [m],z [m]"));
    /* The first ray meets the panel at z = -1 in 1 m; the second looks away. */
    const char *end = strstr(out, "\n0,1,end,0,0,-1,");
    if (!end) fail_msg("mcvisi %s: ray 0 does not end on the panel: %s", line, out);
    assert_non_null(strstr(out, "\n1,1,miss,"));
}

static void test_trace(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    write_text("rays.csv",
               "# two rays\nx, y, z, dx, dy, dz\n0,0,0,0,0,-2\n\n 0.1, 0, 0, 0, 0, 1 \r\n");
    expect_trace("trace s.gltf --rays rays.csv -o paths.csv");
    expect_trace("trace s.gltf --rays rays.csv -o paths.csv --device reference");
    expect_trace("trace s.gltf --rays rays.csv -o paths.csv --precision mixed");
    expect_trace("trace s.gltf --rays rays.csv -o paths.csv --precision double");
    run_well("trace s.gltf --rays rays.csv --device reference");
    assert_true(strncmp(out, "ray,vertex,", 11) == 0);

    EXPECT_FAILURE("trace s.gltf --rays missing.csv", 3, "missing.csv", "x,y,z,dx,dy,dz");
    EXPECT_FAILURE("trace s.gltf --rays rays.csv -o absent/p.csv", 3, "absent/p.csv");
    write_text("bad.csv", "0,0,0,0,0,1\n0,0,0,0,0\n");
    EXPECT_FAILURE("trace s.gltf --rays bad.csv", 3, "bad.csv:2", "dy", "x,y,z,dx,dy,dz");
    write_text("bad.csv", "0,0,0,0,0,1,3\n");
    EXPECT_FAILURE("trace s.gltf --rays bad.csv", 3, "bad.csv:1", "x,y,z,dx,dy,dz");
    write_text("bad.csv", "0,0,0,0,0,0\n");
    EXPECT_FAILURE("trace s.gltf --rays bad.csv", 3, "bad.csv:1", "direction");
    write_text("bad.csv", "a,b,c\n");
    EXPECT_FAILURE("trace s.gltf --rays bad.csv", 3, "bad.csv:1", "x,y,z,dx,dy,dz");
    write_text("bad.csv", "0,0,inf,0,0,1\n");
    EXPECT_FAILURE("trace s.gltf --rays bad.csv", 3, "bad.csv:1", "finite");
    write_text("bad.csv", "# nothing\n");
    EXPECT_FAILURE("trace s.gltf --rays bad.csv", 3, "bad.csv", "no ray");
    EXPECT_FAILURE("trace s.gltf --rays .", 3, ".", "directory");
}

/* --- camera and compare
 * ----------------------------------------------------------------------------------------- */

/* Looks at the middle of the panel: irradiance π L D²/(4 b²) cos⁴. */
static const char lens[] = "\"type\":\"thinLens\",\"focalLength\":0.0198,\"imageDistance\":0.02,"
                           "\"lensDiameter\":0.01,\"resolution\":[24,16],"
                           "\"pixelSize\":[\"4um\",\"5um\"],\"radiometry\":\"irradiance\"";

static void test_camera(void **state) {
    (void)state;
    write_scene("s.gltf", lens, panel);
    run_well("render s.gltf --spp 64");
    run_well("camera s.exr -o grey.exr --exposure-time 2e-4 --quantum-efficiency 0.5 --wavelength "
             "600e-9 --read-noise 3 --bits 10 "
             "--black-level 20 --json");
    json_t *report = json_loads(out, 0, NULL);
    assert_non_null(report);
    /* eta A t lambda/(h c) by hand: 0.5 * 20e-12 * 2e-4 * 600e-9 / (6.62607015e-34 * 299792458). */
    const double per_unit = json_real_value(json_object_get(report, "electrons_per_unit"));
    if (fabs(per_unit / 6040.93988 - 1) > 1e-8) fail_msg("%.9g electrons per W/m^2", per_unit);

    /* The header of the image is kept, but for what the values are. */
    mcv_exr image = read_exr("s.exr"), grey = read_exr("grey.exr");
    assert_string_equal(attribute(&grey, "mcvisi:quantity")->text, "grey value");
    assert_string_equal(attribute(&grey, "mcvisi:unit")->text, "DN");
    assert_true(attribute(&grey, "mcvisi:blackLevel")->numbers[0] == 20);
    for (uint32_t i = 0; i < image.attribute_count; ++i) {
        const mcv_attribute *a = image.attributes + i;
        if (strcmp(a->name, "mcvisi:quantity") == 0 || strcmp(a->name, "mcvisi:unit") == 0)
            continue;
        if (strcmp(a->name, "mcvisi:cameraModel") == 0)
            continue; /* tells what the values are, too: test_camera_model */
        const mcv_attribute *kept = attribute(&grey, a->name);
        assert_int_equal(kept->count, a->count);
        if (a->text) assert_string_equal(kept->text, a->text);
        assert_memory_equal(kept->numbers, a->numbers, sizeof a->numbers);
    }
    /* By default the full well, 10 000 electrons, is the largest grey value: K = (1023 - 20)/10000.
     */
    double electrons = 0, values = 0;
    for (size_t i = 0; i < 24 * 16; ++i) {
        electrons += per_unit * (double)image.parts[0].image.pixels[i] / (24 * 16);
        values += (double)grey.parts[0].image.pixels[i] / (24 * 16);
    }
    /* Five standard errors of the mean of 384 pixels, read noise and rounding (1/12 DN²) included.
     */
    const double gain = 0.1003, expected = 20 + gain * electrons;
    const double allowed = 5 * sqrt((gain * gain * (electrons + 9) + 1.0 / 12) / (24 * 16));
    assert_true(electrons > 1000);
    if (fabs(values - expected) > allowed)
        fail_msg("mean grey value %g instead of %g +- %g", values, expected, allowed);
    json_decref(report);
    mcv_exr_free(&image);
    mcv_exr_free(&grey);

    run_well("camera s.exr -o grey.png --expose-to 0.8 --bits 8");
    assert_string_equal(err, "");
    expect_png("grey.png", 24, 16);
    run_well("camera s.exr -o grey.png --expose-to 1.5");
    assert_non_null(strstr(err, "384 of 384 values (100 %) are saturated"));
}

static void test_camera_bad_input(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    run_well("render s.gltf --spp 4");
    run_well("camera s.exr -o grey.exr --expose-to 0.8");
    run_well("render s.gltf --spp 4 -o dark.exr --set emitters/panel/radiance=0");
    float pixels[] = {1, NAN};
    const mcv_exr_part part = {.name = "image",
                               .image = {.width = 2, .height = 1, .channels = 1, .pixels = pixels}};
    const mcv_attribute radiance = {.name = "mcvisi:quantity", .text = "radiance"};
    const mcv_attribute irradiance = {.name = "mcvisi:quantity", .text = "irradiance"};
    mcv_error error = {""};
    assert_int_equal(mcv_exr_write("nan.exr", &part, 1, &radiance, 1, &error), MCV_OK);
    assert_int_equal(mcv_exr_write("bare.exr", &part, 1, NULL, 0, &error), MCV_OK);
    pixels[1] = 1;
    assert_int_equal(mcv_exr_write("sizeless.exr", &part, 1, &irradiance, 1, &error), MCV_OK);
    EXPECT_FAILURE("camera", 2, "IMAGE.exr");
    EXPECT_FAILURE("camera s.exr", 2, "--output is missing");
    EXPECT_FAILURE("camera s.exr -o x.jpg --expose-to 1", 2, "x.jpg",
                   ".exr, .png, .tif, .tiff or .npy");
    EXPECT_FAILURE("camera s.exr -o s.exr --expose-to 1", 2, "s.exr is the image");
    EXPECT_FAILURE("camera s.exr -o x.png", 2,
                   "--exposure-time, --electrons-per-unit or --expose-to");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --electrons-per-unit 4", 2, "once");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --bits 8 --black-level 256", 2,
                   "--black-level 256", "below 256");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --bits 17", 2, "--bits 17");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --red-noise 1", 2,
                   "did you mean --read-noise?");
    EXPECT_FAILURE("camera s.exr -o x.png --exposure-time 1", 3, "s.exr", "is radiance",
                   "irradiance");
    EXPECT_FAILURE("camera grey.exr -o x.png --expose-to 1", 3, "grey.exr", "mcvisi:quantity",
                   "is grey value");
    EXPECT_FAILURE("camera bare.exr -o x.png --expose-to 1", 3, "bare.exr", "mcvisi:quantity",
                   "is missing");
    EXPECT_FAILURE("camera nan.exr -o x.png --expose-to 1", 3, "nan.exr", "column 1, row 0", "nan");
    EXPECT_FAILURE("camera sizeless.exr -o x.png --exposure-time 1", 3, "sizeless.exr",
                   "mcvisi:pixelSize");
    EXPECT_FAILURE("camera dark.exr -o x.png --expose-to 1", 3, "dark.exr", "dark everywhere");
    EXPECT_FAILURE("camera missing.exr -o x.png --expose-to 1", 3, "missing.exr");
    EXPECT_FAILURE("camera s.exr -o absent/x.png --expose-to 1", 3, "absent/x.png");
}

/* --- measure
 * ----------------------------------------------------------------------------------------------------
 */

static double measured(const json_t *object, const char *key, double *uncertainty) {
    const json_t *quantity = json_object_get(object, key);
    if (!quantity) fail_msg("%s is missing in: %s", key, out);
    if (uncertainty) *uncertainty = json_number_value(json_object_get(quantity, "uncertainty"));
    return json_number_value(json_object_get(quantity, "value"));
}

/* A panel of 4 mm x 3 mm, turned by 5° about the axis, in the focus of a telecentric camera whose
 * pixels see 40 µm. */
static const char bar_scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_emitters\"],\"extensions\":{"
    "\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"telecentric\",\"magnification\":"
    "0.1,\"workingDistance\":%s,"
    "\"fNumber\":2,\"resolution\":[160,128],\"pixelSize\":\"4um\",\"radiometry\":\"irradiance\"}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"panel\",\"type\":\"area\",\"size\":[0.004,0."
    "003],\"radiance\":2}]}},"
    "\"nodes\":[{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},"
    "{\"translation\":[0,0,-0.1],\"rotation\":[-0.0436193874,0.9990482216,0,0],\"extensions\":{"
    "\"MCVISI_emitters\":{\"emitter\":0}}}]}";

static void write_bar_scene(const char *distance) {
    char text[2048];
    assert_true(snprintf(text, sizeof text, bar_scene, distance) < (int)sizeof text);
    write_text("bar.gltf", text);
}

static double bessel_mtf(double radius, double frequency) {
    const double x = 2 * M_PI * radius * frequency;
    return x == 0 ? 1 : 2 * j1(x) / x;
}

/* The MTF of an edge of the panel, from the JSON, against box pixel and blur of this radius
 * [pixel], up to Nyquist. */
static void expect_mtf(const json_t *edge, double radius) {
    const json_t *frequency = json_object_get(edge, "frequency"),
                 *mtf = json_object_get(edge, "mtf");
    const double tilt = 5 * M_PI / 180;
    assert_true(json_array_size(frequency) == 65);
    for (size_t i = 1; i <= 32; ++i) {
        const double f = json_number_value(json_array_get(frequency, i)), a = M_PI * f * cos(tilt),
                     b = M_PI * f * sin(tilt);
        const double truth = fabs(sin(a) / a * sin(b) / b * bessel_mtf(radius, f)),
                     found = json_number_value(json_array_get(mtf, i));
        if (fabs(found - truth) > 0.01)
            fail_msg("blur %g: MTF(%g) is %g instead of %g", radius, f, found, truth);
    }
}

/*
 * What is rendered has the size and the sharpness that it should: length within a hundredth of a
 * pixel, MTF within 0.01, in focus and 4 mm out of it, where a point is blurred to a disc of radius
 * m NA Δz = 0.1 · 0.1/(2·2) · 4 mm = 10 µm, 2.5 pixels.
 */
static void test_measure_a_render(void **state) {
    static const char *const distances[] = {"0.1", "0.096"};
    (void)state;
    for (int i = 0; i < 2; ++i) {
        double u;
        write_bar_scene(distances[i]);
        run_well("render bar.gltf --spp 1024");
        run_well("measure bar.exr --edge left=2,34,56,60 --edge right=102,34,56,60 --edge "
                 "top=50,2,60,46 "
                 "--line both=2,34,56,28+2,66,56,28 --caliper bar=2,44,156,40 --json");
        json_t *report = json_loads(out, 0, NULL);
        assert_non_null(report);
        /* The preview is coded for the eye, and shifts edges. */
        assert_null(strstr(err, "sRGB"));
        run_well("measure bar.png --edge left=2,34,56,60");
        assert_non_null(strstr(err, "warning: bar.png: its values are encoded in sRGB"));
        const json_t *edges = json_object_get(report, "edges"),
                     *distances_found = json_object_get(report, "distances");
        const double pixel =
            json_number_value(json_array_get(json_object_get(report, "object_pixel"), 0));
        assert_true(fabs(pixel - 40e-6) < 1e-12);
        const double length = measured(json_array_get(distances_found, 0), "length", &u);
        if (fabs(fabs(length) - 0.004) > 0.01 * 40e-6) fail_msg("length %.9g ± %g m", length, u);
        assert_true(u > 0 && u < 0.01 * 40e-6);
        const double tilt = measured(json_array_get(edges, 0), "tilt", &u);
        if (fabs(fabs(tilt) - 5 * M_PI / 180) > 1e-4 + 3 * u) fail_msg("tilt %g ± %g", tilt, u);
        for (size_t k = 0; k < 3; ++k) expect_mtf(json_array_get(edges, k), i ? 2.5 : 0);
        const json_t *line = json_array_get(json_object_get(report, "lines"), 0),
                     *caliper = json_array_get(json_object_get(report, "calipers"), 0);
        const double same = measured(line, "tilt", &u);
        if (fabs(same - tilt) > 1e-4 + 4 * u)
            fail_msg("the line's tilt is %g ± %g, the edge's %g", same, u, tilt);
        const double width = measured(caliper, "width_length", &u);
        if (fabs(width - 0.004) > 0.01 * 40e-6) fail_msg("width %.9g ± %g m", width, u);
        assert_true(measured(json_array_get(distances_found, 2), "distance", &u) <
                    0.01); /* of the line from the edge it follows */
        /* The top is square to the sides: what stands between the boxes is no distance. */
        const json_t *to_top = json_array_get(distances_found, 1);
        assert_string_equal(json_string_value(json_object_get(to_top, "name")), "left to top");
        assert_null(json_object_get(to_top, "distance"));
        assert_null(json_object_get(to_top, "length"));
        assert_non_null(
            strstr(json_string_value(json_object_get(to_top, "no_distance")), "not parallel"));
        json_decref(report);
    }
}

static void test_measure(void **state) {
    double u, v;
    (void)state;
    write_bar_scene("0.1");
    run_well("render bar.gltf --spp 64 --camera grey.exr --expose-to 0.8 --read-noise 5 --bits 12 "
             "--black-level 40");
    assert_non_null(strstr(out, "grey.exr"));
    /* The same as by `camera`. */
    run_well(
        "camera bar.exr -o again.exr --expose-to 0.8 --read-noise 5 --bits 12 --black-level 40");
    run_well("measure grey.exr --minus again.exr --json");
    json_t *report = json_loads(out, 0, NULL);
    const json_t *all = json_array_get(json_object_get(report, "regions"), 0);
    assert_string_equal(json_string_value(json_object_get(all, "name")), "image");
    assert_true(measured(all, "mean", NULL) == 0 && measured(all, "deviation", NULL) == 0);
    json_decref(report);
    /* Another exposure differs by noise alone; K = (4095 - 40)/10000. */
    run_well("camera bar.exr -o other.exr --expose-to 0.8 --read-noise 5 --bits 12 --black-level "
             "40 --seed 5");
    run_well("measure grey.exr --minus other.exr --region 70,54,20,20 --json");
    report = json_loads(out, 0, NULL);
    all = json_array_get(json_object_get(report, "regions"), 0);
    const double deviation = measured(all, "deviation", &u),
                 noise = json_number_value(json_object_get(all, "noise"));
    /* The render's own error, which both share, is in the noise that is stated, but small here. */
    if (fabs(deviation - noise) > 4 * u + 0.02 * noise)
        fail_msg("deviation %g ± %g, noise %g", deviation, u, noise);
    if (fabs(measured(all, "mean", &u)) > 4 * u) fail_msg("the mean difference is %s", out);
    json_decref(report);
    /* PNG: the noise by the camera's numbers, and by estimate; and the scale by the scene. */
    run_well(
        "camera bar.exr -o grey.png --expose-to 0.8 --read-noise 5 --bits 12 --black-level 40");
    run_well("measure grey.png --gain 0.4055 --read-noise 5 --black-level 40 --region "
             "p=70,54,20,20 --background 2,2,20,20 --scene "
             "bar.gltf --json");
    report = json_loads(out, 0, NULL);
    all = json_array_get(json_object_get(report, "regions"), 0);
    const double cnr = measured(all, "contrast_to_noise", NULL), mean = measured(all, "mean", &u);
    /* 0.8 of 4055 above 5 e- of noise, 2.03 DN, and the rounding: √(4.11 + 1/12) = 2.05. */
    if (fabs(cnr - 0.8 * 4055 / 2.05) > 0.2 * cnr) fail_msg("contrast to noise %g", cnr);
    assert_true(fabs(json_number_value(json_array_get(json_object_get(report, "object_pixel"), 1)) -
                     40e-6) < 1e-12);
    json_decref(report);
    run_well("measure grey.png --region p=70,54,20,20 --json");
    report = json_loads(out, 0, NULL);
    all = json_array_get(json_object_get(report, "regions"), 0);
    assert_true(measured(all, "mean", &v) == mean);
    if (fabs(v / u - 1) > 0.4) fail_msg("the uncertainty is estimated as %g instead of %g", v, u);
    json_decref(report);
    run_well("measure grey.png");
    assert_non_null(strstr(out, "uniformity"));
    assert_non_null(strstr(out, " ± "));
}

/*
 * --expose-to takes the same level of a render of few samples as of one of many, within what is
 * stated of both (one in 1000 is 3.3 deviations off). A scratch in dark field is noisy: of 16
 * samples the brightest square of 16 x 16 pixels is known to 1 or 2 %.
 */
static void test_level_of_a_render(void **state) {
    static const int samples[] = {256, 16, 16, 16, 64};
    double levels[5], uncertainties[5];
    (void)state;
    for (int i = 0; i < 5; ++i) {
        char line[512];
        snprintf(line, sizeof line,
                 "render " MCV_SOURCE_DIR
                 "/scenes/scratch.gltf --resolution 64x48 --spp %d --seed %d -o s.exr",
                 samples[i], i);
        run_well(line);
        run_well("camera s.exr -o grey.exr --expose-to 0.8 --json");
        json_t *report = json_loads(out, 0, NULL);
        const double level = measured(report, "level", uncertainties + i);
        assert_true(level == 8000);
        levels[i] = 1 / json_number_value(json_object_get(report, "electrons_per_unit"));
        uncertainties[i] *= levels[i] / level;
        json_decref(report);
        const double off = levels[i] - levels[0];
        print_message("%d samples: %+.3f %%, stated %.3f %%\n", samples[i], 100 * off / levels[0],
                      100 * uncertainties[i] / levels[i]);
        if (fabs(off) > 3.3 * hypot(uncertainties[0], uncertainties[i]))
            fail_msg("%d samples: the level is off by %g of %g ± %g", samples[i], off, levels[0],
                     uncertainties[i]);
    }
    assert_true(uncertainties[0] > 0 && uncertainties[0] < 0.01 * levels[0]);
}

/* --- the render's own error
 * ------------------------------------------------------------------------------------- */

/* What a render of so many samples gives of a bright half and a darker one; irradiance, 4
 * replicates, f/4. */
static void write_noisy(const char *path, double samples) {
    enum { WIDTH = 120, HEIGHT = 80 };
    mcv_image image, deviation;
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&image, WIDTH, HEIGHT, 1, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&deviation, WIDTH, HEIGHT, 1, &error), MCV_OK);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
        mcv_noise noise = mcv_noise_begin((uint32_t)samples, 0, i);
        const double truth = i % WIDTH < WIDTH / 2 ? 1 : 0.8, one = 1.2 * truth / sqrt(samples / 4);
        double values[4], mean = 0, squares = 0;
        for (int k = 0; k < 4; ++k)
            mean += (values[k] = truth + one * mcv_noise_normal(&noise)) / 4;
        for (int k = 0; k < 4; ++k) squares += pow(values[k] - mean, 2);
        image.pixels[i] = (float)fmax(0, mean);
        deviation.pixels[i] = (float)sqrt(squares / 12);
    }
    const mcv_camera_model model = {.telecentric = true,
                                    .size = {WIDTH, HEIGHT},
                                    .macro = {1, 1},
                                    .pixel = {3.45e-6, 3.45e-6},
                                    .object_pixel = {34.5e-6, 34.5e-6},
                                    .bits = NAN,
                                    .black_level = NAN,
                                    .gain = NAN};
    char *text = mcv_camera_model_write(&model);
    const mcv_attribute attributes[] = {
        {.name = "mcvisi:quantity", .text = "irradiance"},
        {.name = "mcvisi:unit", .text = "W/m^2"},
        {.name = "mcvisi:fNumber", .numbers = {4}, .count = 1},
        {.name = "mcvisi:pixelSize", .numbers = {3.45e-6, 3.45e-6}, .count = 2},
        {.name = "mcvisi:errorFreedom", .numbers = {3}, .count = 1},
        {.name = MCV_CAMERA_MODEL_KEY, .text = text}};
    const mcv_exr_part parts[] = {{.name = "image", .image = image},
                                  {.name = "error", .image = deviation}};
    assert_non_null(text);
    assert_int_equal(mcv_exr_write(path, parts, 2, attributes, 6, &error), MCV_OK);
    free(text);
    mcv_image_free(&image);
    mcv_image_free(&deviation);
}

/*
 * One scene, one camera, 16 to 16384 samples: contrast to noise, SNR and RMS contrast are those of
 * the camera within 3.3 of their stated uncertainties (one in 1000), or refused with the samples
 * that are needed, never wrong; without the blur of the lens and with it, from every file that has
 * a header. By hand, of 10 000 e- of full well at 0.8, m = 8000 and b = 6400 e-: (m - b)/√(b + 25)
 * and so on; rounding to 12 bits adds (10000/4095)²/12 = 0.5 e-².
 */
static void check_contrast(const char *file, double samples, double render_noise[2]) {
    const double noise = sqrt(6400 + 25 + 0.5), truth = 1600 / noise,
                 ratio = 8000 / sqrt(8000 + 25 + 0.5);
    char line[256];
    double u;
    snprintf(line, sizeof line,
             "measure %s --region a=8,8,44,64 --region b=11,9,15,61 --background 68,8,44,64 --json",
             file);
    run_well(line);
    json_t *report = json_loads(out, 0, NULL);
    const json_t *regions = json_object_get(report, "regions"), *a = json_array_get(regions, 0);
    const bool told = json_object_get(a, "contrast_to_noise"),
               refused = json_object_get(a, "no_contrast_to_noise");
    if (strcmp(json_string_value(json_object_get(report, "render_error")), "taken out") != 0)
        fail_msg("%s: %s", file, out);
    assert_true(told != refused);
    if (samples < 32 && told)
        fail_msg("%s: of 16 samples there must be no contrast to noise: %s", file, out);
    if (samples > 4000 && refused) fail_msg("%s: %g samples are enough: %s", file, samples, out);
    const double rms = measured(a, "rms_contrast", &u);
    if (fabs(rms) > 3.3 * u)
        fail_msg("%s of %g samples: an RMS contrast of %g ± %g where there is none", file, samples,
                 rms, u);
    const double cnr = told ? measured(a, "contrast_to_noise", &u) : truth;
    if (told && fabs(cnr - truth) > 3.3 * u)
        fail_msg("%s of %g samples: contrast to noise %g ± %g, not %g", file, samples, cnr, u,
                 truth);
    const double snr = json_object_get(a, "snr") ? measured(a, "snr", &u) : ratio;
    if (json_object_get(a, "snr") && fabs(snr - ratio) > 3.3 * u)
        fail_msg("%s of %g samples: SNR %g ± %g, not %g", file, samples, snr, u, ratio);
    for (int i = 0; i < 2; ++i)
        render_noise[i] =
            json_number_value(json_object_get(json_array_get(regions, (size_t)i), "render_noise"));
    json_decref(report);
}

/*
 * A header tells the errors by cells of 8 x 8 pixels, here to a thousandth of a DN. The variances
 * of region b, 915 pixels of whose cells half are outside, are means of different pixels: each is
 * known to √(2/3), so that both agree within 3.3 √(2/3 · 2/915)/2 = 7 % of a deviation. Region a
 * cuts 1/12 of its pixels off from their cells.
 */
static void test_contrast_without_the_render(void **state) {
    static const double samples[] = {16, 64, 1024, 4096, 16384};
    static const char *const files[] = {"noisy-grey.exr", "noisy-grey.png", "noisy-grey.tif"};
    (void)state;
    for (int i = 0; i < 10; ++i) {
        char line[256];
        double found[3][2];
        write_noisy("noisy.exr", samples[i % 5]);
        for (int k = 0; k < 3; ++k) {
            snprintf(
                line, sizeof line,
                "camera noisy.exr -o %s --electrons-per-unit 8000 --read-noise 5 --lens-mtf %s",
                files[k], i < 5 ? "none" : "diffraction");
            run_well(line);
            check_contrast(files[k], samples[i % 5], found[k]);
            for (int r = 0; r < 2; ++r)
                if (fabs(found[k][r] / found[0][r] - 1) > 0.07)
                    fail_msg("%s: the render's error is %g instead of %g", files[k], found[k][r],
                             found[0][r]);
        }
    }
    /* The render itself has nothing but its error here. */
    run_well("measure noisy.exr --region 8,8,44,64");
    assert_non_null(strstr(out, "times as many samples"));
    assert_non_null(strstr(out, "render error"));
    /* Files that do not tell say so. */
    run_well("camera noisy.exr -o noisy.npy --electrons-per-unit 8000");
    assert_non_null(strstr(out, "noisy-preview.png"));
    expect_png("noisy-preview.png", 120, 80);
    run_well("measure noisy.npy");
    assert_non_null(strstr(out, "part of the noise"));
}

/*
 * The mean of three channels, each with an error of 0.1, whose pairs have the correlation that the
 * header tells (1 where it does not): 0.1 √((1 + 2ρ)/3) of a pixel, over the root of 768 pixels.
 */
static void test_channels_of_a_colour_picture(void **state) {
    static const struct {
        bool told;
        double correlation, truth;
    } cases[] = {
        {true, 1, 0.1}, {true, 0, 0.057735027}, {true, 0.25, 0.070710678}, {false, 0, 0.1}};
    enum { WIDTH = 32, HEIGHT = 24, VALUES = 3 * WIDTH * HEIGHT };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        mcv_image image, deviation;
        mcv_error error = {""};
        double u;
        assert_int_equal(mcv_image_new(&image, WIDTH, HEIGHT, 3, &error), MCV_OK);
        assert_int_equal(mcv_image_new(&deviation, WIDTH, HEIGHT, 3, &error), MCV_OK);
        for (uint32_t i = 0; i < VALUES; ++i) {
            image.pixels[i] = 1;
            deviation.pixels[i] = 0.1F;
        }
        const mcv_attribute attributes[] = {
            {.name = "mcvisi:quantity", .text = "radiance"},
            {.name = "mcvisi:errorFreedom", .numbers = {3}, .count = 1},
            {.name = MCV_EXR_CHANNELS, .numbers = {cases[k].correlation}, .count = 1}};
        const mcv_exr_part parts[] = {{.name = "image", .image = image},
                                      {.name = "error", .image = deviation}};
        assert_int_equal(
            mcv_exr_write("colour.exr", parts, 2, attributes, cases[k].told ? 3 : 2, &error),
            MCV_OK);
        mcv_image_free(&image);
        mcv_image_free(&deviation);
        run_well("measure colour.exr --json");
        json_t *report = json_loads(out, 0, NULL);
        measured(json_array_get(json_object_get(report, "regions"), 0), "mean", &u);
        json_decref(report);
        const double found = u * sqrt(WIDTH * HEIGHT);
        if (fabs(found / cases[k].truth - 1) > 1e-5)
            fail_msg("correlation %g: an error of %g, not %g", cases[k].correlation, found,
                     cases[k].truth);
    }
}

static void test_units_of_options(void **state) {
    static const char *const lines[] = {"--exposure-time 2e-3 --wavelength 550e-9",
                                        "--exposure-time 2ms --wavelength 550nm",
                                        "--exposure-time=2000us --wavelength 0.55um,0.55um,550nm"};
    double found[3];
    (void)state;
    write_noisy("noisy.exr", 64);
    for (int i = 0; i < 3; ++i) {
        char line[256];
        snprintf(line, sizeof line, "camera noisy.exr -o g.exr %s --json", lines[i]);
        run_well(line);
        json_t *report = json_loads(out, 0, NULL);
        found[i] = json_number_value(json_object_get(report, "electrons_per_unit"));
        json_decref(report);
    }
    assert_true(found[0] > 0 && fabs(found[1] / found[0] - 1) < 1e-14 &&
                fabs(found[2] / found[0] - 1) < 1e-14);
    EXPECT_FAILURE("camera noisy.exr -o g.exr --exposure-time 2mm", 2, "--exposure-time 2mm",
                   "10ms");
    EXPECT_FAILURE("camera noisy.exr -o g.exr --exposure-time 2ms --wavelength 550ms", 2,
                   "--wavelength 550ms", "550nm");
}

/* Bright discs on 20 DN as an .npy of 32-bit floats, exact pixels. */
static void write_discs(const char *path, uint32_t width, uint32_t height, const double (*discs)[3],
                        size_t count) {
    char header[128];
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    memset(header, ' ', sizeof header);
    static const char magic[10] = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0, 118, 0};
    memcpy(header, magic, sizeof magic);
    const int length =
        snprintf(header + 10, 118, "{'descr': '<f4', 'fortran_order': False, 'shape': (%u, %u), }",
                 height, width);
    header[10 + length] = ' ';
    header[127] = '\n';
    fwrite(header, 1, sizeof header, stream);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            float value = 20;
            for (size_t i = 0; i < count; ++i)
                value += (float)(180 * disc_coverage_of_pixel(x - discs[i][0], y - discs[i][1],
                                                              discs[i][2]));
            fwrite(&value, sizeof value, 1, stream);
        }
    assert_int_equal(fclose(stream), 0);
}

/* Bores of a plate: exact pixels, so thousandths of a pixel as test_circle asks. */
static void test_measure_circles(void **state) {
    static const double discs[2][3] = {{30.3, 40.6, 15.25}, {90.7, 35.2, 20.5}};
    (void)state;
    write_discs("bores.npy", 128, 80, discs, 2);
    run_well("measure bores.npy --noise 0.5 --circle a=8,18,45,45 --circle b=62,6,58,58 --arc "
             "c=64,8,54,30 --json");
    json_t *report = json_loads(out, 0, NULL);
    const json_t *circles = json_object_get(report, "circles"),
                 *arc = json_array_get(json_object_get(report, "arcs"), 0),
                 *distances = json_object_get(report, "distances");
    assert_true(json_array_size(circles) == 2 && json_array_size(distances) == 2);
    for (size_t i = 0; i < 3; ++i) {
        static const char *const keys[] = {"column", "row", "radius"};
        const json_t *found = i < 2 ? json_array_get(circles, i) : arc;
        const double *truth = discs[i < 1 ? 0 : 1];
        double u;
        for (int k = 0; k < 3; ++k)
            if (fabs(measured(found, keys[k], &u) - truth[k]) > 2e-3)
                fail_msg("circle %zu: %s is %g", i, keys[k], measured(found, keys[k], &u));
        assert_true(measured(found, "diameter", &u) == 2 * measured(found, "radius", &u));
        assert_null(json_object_get(found, "radius_length")); /* nobody knows the scale */
    }
    const double known = hypot(discs[1][0] - discs[0][0], discs[1][1] - discs[0][1]);
    assert_string_equal(json_string_value(json_object_get(json_array_get(distances, 0), "name")),
                        "a to b");
    for (size_t i = 0; i < 2; ++i)
        if (fabs(measured(json_array_get(distances, i), "distance", NULL) - known) > 3e-3)
            fail_msg("the centres are not %g apart: %s", known, out);
    json_decref(report);
    run_well("measure bores.npy --noise 0.5 --circle 8,18,45,45");
    assert_non_null(strstr(out, "roundness"));
    EXPECT_FAILURE("measure bores.npy --noise 0.5 --edge side=60,26,22,18", 1,
                   "edge side is curved", "sagitta", "--circle");
    EXPECT_FAILURE("measure bores.npy --noise 0.5 --circle 0,0,12,12", 1, "circle 1");
    EXPECT_FAILURE("measure bores.npy --noise 0.5 --line 0,0,12,12+5", 2, "line 0,0,12,12+5");
    EXPECT_FAILURE("measure bores.npy --noise 0.5 --caliper 0,0,12,12", 2, "square");
    EXPECT_FAILURE("measure bores.npy --noise 0.5 --arc 0,0,12,12", 1, "arc 1");
}

static void test_measure_bad_input(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel);
    run_well("render s.gltf --spp 4");
    run_well("camera s.exr -o g.png --expose-to 0.8");
    EXPECT_FAILURE("measure", 2, "IMAGE");
    EXPECT_FAILURE("measure g.jpg", 2, "g.jpg", ".png");
    EXPECT_FAILURE("measure missing.png", 3, "missing.png");
    EXPECT_FAILURE("measure s.exr --region 20,10,5,5", 2, "20,10,5,5", "24 x 16");
    EXPECT_FAILURE("measure s.exr --region a=1,2,3", 2, "a=1,2,3", "X,Y,W,H");
    EXPECT_FAILURE("measure s.exr --background absent.png", 3, "absent.png");
    EXPECT_FAILURE("measure s.exr --edge 0,0,24,17", 2, "24 x 16");
    EXPECT_FAILURE("measure s.exr --edge 8,4,8,8", 1, "edge 1", "no edge");
    EXPECT_FAILURE("measure s.exr --edge 0,0,8,8", 1, "edge 1", "too little");
    EXPECT_FAILURE("measure s.exr --minus missing.exr", 3, "missing.exr");
    EXPECT_FAILURE("measure s.exr --channel green", 2, "1 channel");
    EXPECT_FAILURE("measure s.exr --metric mtf", 2, "--metric");
    EXPECT_FAILURE("measure g.png --scene s.gltf", 3, "s.gltf", "no plane in focus");
    EXPECT_FAILURE("measure g.png --scene s.gltf --set sensors/cam/resolution=[12,8]", 3, "24 x 16",
                   "12 x 8");
    EXPECT_FAILURE("render s.gltf --expose-to 1", 2, "--camera");
    EXPECT_FAILURE("render s.gltf --camera g.png --exposure-time 1", 3, "measures radiance",
                   "--expose-to");
    EXPECT_FAILURE("render s.gltf --camera g.jpg --expose-to 1", 2, "g.jpg");
    EXPECT_FAILURE("render s.gltf -o x.exr --camera x.exr --expose-to 1", 2, "x.exr");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --quantum-efficiency 0.5,0.5", 2,
                   "one number or three");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --dark-current 10", 2, "--exposure-time");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --exposure-time 1", 2, "--exposure-time",
                   "with --expose-to", "--dark-current");
    EXPECT_FAILURE("camera s.exr -o x.png --electrons-per-unit 1 --exposure-time 1", 2,
                   "with --electrons-per-unit", "--dark-current");
    run_well("camera s.exr -o x.exr --expose-to 1 --exposure-time 1 --dark-current 10");
    EXPECT_FAILURE("measure s.exr --region "
                   "n234567890123456789012345678901234567890123456789012345678901234=0,0,8,8",
                   2, "its name has 64 bytes", "at most 63");
    EXPECT_FAILURE("measure s.exr --edge "
                   "n234567890123456789012345678901234567890123456789012345678901234=0,0,8,8",
                   2, "its name has 64 bytes", "at most 63");
    EXPECT_FAILURE("camera s.exr -o x.png --expose-to 1 --lens-mtf missing.csv", 3, "missing.csv");
}

/* The verdict in JSON; the exit code must say the same. */
static bool compare_says_different(const char *line, const char *pixel_test) {
    const int code = run(line);
    if (code != 0 && code != 1) fail_msg("mcvisi %s: exit code %d: %s", line, code, err);
    json_t *report = json_loads(out, 0, NULL);
    assert_non_null(report);
    const bool different = json_is_true(json_object_get(report, "different"));
    assert_int_equal(different, code);
    assert_string_equal(json_string_value(json_object_get(report, "pixel_test")), pixel_test);
    json_decref(report);
    return different;
}

/* 5 % more radiance is far beyond the noise: only the pixels at the edge of the panel have any. */
static void test_compare(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel_noisy);
    run_well("render s.gltf --spp 1024 --adaptive off --replicates 16 -o a.exr --parts replicates");
    run_well("render s.gltf --spp 1024 --adaptive off --replicates 16 -o b.exr --parts replicates "
             "--seed 1");
    run_well("render s.gltf --spp 1024 --adaptive off --replicates 16 -o c.exr --parts replicates "
             "--seed 2 --set "
             "emitters/panel/radiance=2.625");
    run_well("render s.gltf --spp 1024 --adaptive off --replicates 16 -o plain.exr --seed 3");
    mcv_exr exr = read_exr("a.exr");
    assert_int_equal(exr.part_count, 18);
    assert_string_equal(exr.parts[17].name, "replicate 15");
    /* The image is the mean of its replicates, each rounded to float. */
    for (size_t i = 0; i < 24 * 16; ++i) {
        double mean = 0;
        for (int r = 0; r < 16; ++r) mean += (double)exr.parts[2 + r].image.pixels[i] / 16;
        const double value = exr.parts[0].image.pixels[i];
        if (fabs(mean - value) > 0x1p-23 * value)
            fail_msg("pixel %zu: %g, the mean of its replicates %g", i, value, mean);
    }
    mcv_exr_free(&exr);
    assert_false(compare_says_different("compare a.exr b.exr --json -o difference.png",
                                        "Mann-Whitney and Welch"));
    /* 24 pixels are enlarged 26 times (640/24), beside a bar, with three margins of 16; 16 rows
     * under a title of 36 and above a margin. */
    expect_png("difference.png", 24 * 26 + 3 * 16 + MCV_COLOR_BAR_WIDTH, 16 * 26 + 36 + 16);
    assert_true(compare_says_different("compare a.exr c.exr --json", "Mann-Whitney and Welch"));
    assert_true(compare_says_different("compare c.exr plain.exr --json", "Welch"));
    assert_string_equal(err, "");
    assert_int_equal(run("compare a.exr a.exr"), 0);
    assert_non_null(strstr(out, "no difference"));
    assert_non_null(strstr(err, "both images have seed 0"));
    assert_non_null(strstr(err, "note: both images are identical"));
}

/* Scenes are rendered: with other options, by the other renderer, against an image. */
static void test_compare_scenes(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel_noisy);
    run_well("render s.gltf --spp 1024 --replicates 16 -o a.exr --parts replicates");
    assert_false(
        compare_says_different("compare s.gltf s.gltf --spp 256 --json", "Mann-Whitney and Welch"));
    assert_false(
        compare_says_different("compare s.gltf s.gltf --spp 64 --json --against=--device=reference",
                               "Mann-Whitney and Welch"));
    assert_true(compare_says_different(
        "compare s.gltf s.gltf --spp 256 --json --against=--set=emitters/panel/radiance=2.625",
        "Mann-Whitney and Welch"));
    assert_false(
        compare_says_different("compare a.exr s.gltf --spp 256 --json", "Mann-Whitney and Welch"));
    assert_true(compare_says_different(
        "compare s.gltf a.exr --spp 256 --json --set emitters/panel/radiance=2.625",
        "Mann-Whitney and Welch"));
    assert_int_equal(run("compare s.gltf s.gltf --spp 256"), 0);
    assert_non_null(strstr(out, "tiles by p"));
    EXPECT_FAILURE("compare s.gltf s.gltf --against=--dept=3", 2, "--against", "--depth");
    EXPECT_FAILURE("compare s.gltf a.exr --against=--depth=3", 2, "--against", "a.exr is an image");
    EXPECT_FAILURE("compare a.exr a.exr --spp 16", 2, "--spp is for scenes");
    EXPECT_FAILURE("compare s.gltf s.gltf --sensor nobody", 2, "nobody");
    EXPECT_FAILURE("compare s.gltf missing.gltf --spp 16", 3, "missing.gltf");
}

static void test_compare_bad_input(void **state) {
    (void)state;
    write_scene("s.gltf", pinhole, panel_noisy);
    run_well("render s.gltf --spp 16");
    run_well("render s.gltf --spp 16 -o small.exr --resolution 12x8");
    run_well("render s.gltf --spp 16 -o single.exr --replicates 1");
    write_scene("t.gltf", lens, panel);
    run_well("render t.gltf --spp 16");
    EXPECT_FAILURE("compare", 2, "compare A B");
    EXPECT_FAILURE("compare s.exr", 2, "compare A B");
    EXPECT_FAILURE("compare s.exr t.exr s.exr", 2, "A B", "leave out s.exr");
    EXPECT_FAILURE("compare s.exr missing.exr", 3, "missing.exr");
    EXPECT_FAILURE("compare s.exr small.exr", 3, "24 x 16", "12 x 8");
    EXPECT_FAILURE("compare s.exr single.exr", 3, "single.exr", "error", "--replicates");
    EXPECT_FAILURE("compare s.exr t.exr", 3, "s.exr is radiance", "t.exr is irradiance");
    EXPECT_FAILURE("compare s.exr s.exr -o absent/x.png", 3, "absent/x.png");
}

/* --- lightfield
 * -------------------------------------------------------------------------------------------------
 */

/* 12 x 8 macro pixels of 2 x 2; the middle half of them, which is in focus on the panel, is lit
 * evenly, exactly, and the rest is black. */
static void render_light_field(void) {
    write_scene("s.gltf",
                "\"type\":\"lightField\",\"focalLength\":\"9.900990099009901mm\",\"imageDistance\":"
                "0.01,\"lensDiameter\":\"1mm\","
                "\"spatialResolution\":[12,8],\"angularResolution\":[2,2],\"pixelSize\":0.0004",
                panel);
    run_well("render s.gltf --spp 4");
}

/* A box that cuts macro pixels weighs their directions unevenly, which is told once. */
static void test_light_field_boxes(void **state) {
    static const struct {
        const char *box;
        bool cuts;
    } cases[] = {{"--region a=2,4,6,2", false},
                 {"--region a=3,4,6,2", true},
                 {"--region a=2,4,6,2 --region b=2,4,6,3 --background 0,0,2,2", true},
                 {"--region a=2,4,6,2 --background b=2,4,6,3", true},
                 {"", false}};
    (void)state;
    render_light_field();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[160];
        snprintf(line, sizeof line, "measure s.exr %s", cases[i].box);
        run_well(line);
        const char *note = strstr(err, "mcvisi: note: ");
        if ((note != NULL) != cases[i].cuts || (note && strstr(note + 14, "note:")))
            fail_msg("mcvisi %s: %s", line, err);
        if (note && !strstr(note, i == 1 ? "3,4,6,2 cuts macro pixels of 2 x 2 pixels"
                                         : "2,4,6,3 cuts macro pixels of 2 x 2 pixels"))
            fail_msg("mcvisi %s: %s", line, err);
    }
    write_scene("p.gltf", pinhole, panel);
    run_well("render p.gltf --spp 4");
    run_well("measure p.exr --region 3,4,6,3");
    assert_null(strstr(err, "macro"));
}

/* Views of grey values keep each pixel's error, and the render's part of it: each goes where its
 * value goes. */
static void expect_errors_in_views(void) {
    run_well("camera s.exr --electrons-per-unit 1000 -o grey.exr");
    run_well("lightfield views grey.exr -o grey-v.exr");
    mcv_exr before = read_exr("grey.exr"), after = read_exr("grey-v.exr");
    assert_int_equal(before.part_count, 3);
    assert_int_equal(after.part_count, 3);
    for (uint32_t part = 1; part < 3; ++part) {
        assert_string_equal(after.parts[part].name, before.parts[part].name);
        for (uint32_t i = 0; i < 24 * 16; ++i) {
            const uint32_t column = i % 24, row = i / 24,
                           from = (row % 8 * 2 + row / 8) * 24 + column % 12 * 2 + column / 12;
            assert_true(after.parts[part].image.pixels[i] == before.parts[part].image.pixels[from]);
        }
    }
    assert_non_null(mcv_exr_error(&after));
    mcv_exr_free(&before);
    mcv_exr_free(&after);
    run_well("measure grey-v.exr --region 3,2,6,4 --json");
    json_t *report = json_loads(out, 0, NULL);
    assert_string_equal(json_string_value(json_object_get(report, "render_error")), "taken out");
    json_decref(report);
}

static void test_light_field_views(void **state) {
    (void)state;
    render_light_field();
    expect_errors_in_views();
    run_well("lightfield views s.exr -o v.exr --png v.png");
    expect_png("v.png", 24 + 2, 16 + 2);
    mcv_exr exr = read_exr("v.exr");
    for (uint32_t row = 0; row < 16; ++row) {
        for (uint32_t column = 0; column < 24; ++column) {
            const uint32_t m = column % 12, n = row % 8;
            const float known = m >= 3 && m < 9 && n >= 2 && n < 6 ? 2.5f : 0,
                        value = exr.parts[0].image.pixels[row * 24 + column];
            if (value != known)
                fail_msg("views: pixel (%u, %u) is %g instead of %g", column, row, (double)value,
                         (double)known);
        }
    }
    mcv_exr_free(&exr);
}

static void expect_lens(const char *line, const char *words) {
    char whole[256];
    snprintf(whole, sizeof whole,
             "%s --expose-to 0.8 --wavelength 550e-9 --noise-free --bits 16 --json", line);
    run_well(whole);
    json_t *told = json_loads(out, 0, NULL);
    const char *found = json_string_value(json_object_get(told, "lens_mtf"));
    if (!found || strcmp(found, words) != 0)
        fail_msg("%s: the lens is %s instead of %s", whole, found, words);
    json_decref(told);
}

static double mtf_at_nyquist(const char *image) {
    char line[128];
    snprintf(line, sizeof line, "measure %s --edge 2,34,56,60 --json", image);
    run_well(line);
    json_t *report = json_loads(out, 0, NULL);
    const double found =
        measured(json_array_get(json_object_get(report, "edges"), 0), "mtf_at_nyquist", NULL);
    json_decref(report);
    return found;
}

/*
 * The diffraction of the working f-number, unless it is left out or a table stands for it; never on
 * a light field. At Nyquist, 125 cycles per mm, the lens of f/2 has s = 0.1375: 2/π (acos s - s √(1
 * - s²)). MTFs of one render are measured, so that its noise is in all.
 */
static void test_lens_of_the_camera(void **state) {
    const double s = 125e3 * 550e-9 * 2, known = 2 / M_PI * (acos(s) - s * sqrt(1 - s * s));
    (void)state;
    write_bar_scene("0.1");
    write_text("half.csv", "0, 1\n125, 0.5\n250, 0\n");
    run_well("render bar.gltf --spp 256 --adaptive off");
    expect_lens("camera bar.exr -o none.exr --lens-mtf none", "none");
    expect_lens("camera bar.exr -o lens.exr", "diffraction at f/2");
    expect_lens("camera bar.exr -o half.exr --lens-mtf half.csv", "table half.csv");
    const double bare = mtf_at_nyquist("none.exr"), diffracted = mtf_at_nyquist("lens.exr"),
                 halved = mtf_at_nyquist("half.exr");
    if (fabs(diffracted - known * bare) > 0.01)
        fail_msg("behind the lens of %g at Nyquist %g becomes %g", known, bare, diffracted);
    if (fabs(halved - 0.5 * bare) > 0.01)
        fail_msg("behind a lens of 0.5 at Nyquist %g becomes %g", bare, halved);
    render_light_field();
    expect_lens("camera s.exr -o plain.exr --lens-mtf none", "none");
    expect_lens("camera s.exr -o lens.exr", "none");
    run_well("measure lens.exr --minus plain.exr --json");
    json_t *report = json_loads(out, 0, NULL);
    const json_t *all = json_array_get(json_object_get(report, "regions"), 0);
    assert_true(json_number_value(json_object_get(all, "largest")) == 0 &&
                json_number_value(json_object_get(all, "smallest")) == 0);
    json_decref(report);
}

static void test_light_field_gradient(void **state) {
    (void)state;
    render_light_field();
    run_well("lightfield emd-gradient s.exr -o g.exr --png g.png --threads 2 --json");
    json_t *told = json_loads(out, 0, NULL);
    assert_non_null(told);
    assert_string_equal(json_string_value(json_object_get(told, "form")), "normalized");
    json_decref(told);
    mcv_exr exr = read_exr("g.exr");
    assert_int_equal(exr.parts[0].image.width, 12);
    assert_int_equal(exr.parts[0].image.height, 8);
    assert_string_equal(attribute(&exr, "mcvisi:quantity")->text, "Earth Mover's gradient");
    assert_string_equal(attribute(&exr, "mcvisi:sensor")->text, "cam");
    for (uint32_t n = 0; n < 8; ++n) {
        for (uint32_t m = 0; m < 12; ++m) {
            /* Where one of two neighbours is lit and the other dark, they are max(c) = √½ apart. */
            const bool row = n >= 2 && n < 6, column = m >= 3 && m < 9;
            const double across = row && (m == 2 || m == 3 || m == 8 || m == 9) ? sqrt(0.5) : 0;
            const double down = column && (n == 1 || n == 2 || n == 5 || n == 6) ? sqrt(0.5) : 0;
            const double known = 0.5 * hypot(across, down),
                         value = exr.parts[0].image.pixels[n * 12 + m];
            if (m == 0 || m == 11 || n == 0 || n == 7) {
                if (!isnan(value))
                    fail_msg("the gradient's border (%u, %u) is %g instead of NaN", m, n, value);
            } else if (!(fabs(value - known) <= 0x1p-24 * known)) { /* rounded to float */
                fail_msg("the gradient at (%u, %u) is %.9g instead of %.9g", m, n, value, known);
            }
        }
    }
    mcv_exr_free(&exr);
    run_well("lightfield emd-gradient s.exr -o g.png --form mass");
}

static void test_light_field_bad_input(void **state) {
    (void)state;
    render_light_field();
    write_scene("p.gltf", pinhole, panel);
    run_well("render p.gltf --spp 4");
    run_well("lightfield emd-gradient s.exr -o g.exr");
    EXPECT_FAILURE("lightfield views", 2, "views|emd-gradient IMAGE.exr");
    EXPECT_FAILURE("lightfield view s.exr -o x.png", 2, "lightfield view:", "`lightfield views`");
    EXPECT_FAILURE("lightfield views s.exr", 2, "--output is missing");
    EXPECT_FAILURE("lightfield views s.exr -o x.tif", 2, "x.tif", ".png or .exr");
    EXPECT_FAILURE("lightfield views s.exr -o s.exr", 2, "s.exr is the light field image itself");
    EXPECT_FAILURE("lightfield views s.exr -o x.png --png y.png", 2, "--png", "x.png");
    EXPECT_FAILURE("lightfield emd-gradient s.exr -o x.png --form both", 2, "normalized|mass");
    EXPECT_FAILURE("lightfield emd-gradient s.exr -o absent/x.png", 3, "absent/x.png");
    EXPECT_FAILURE("lightfield emd-gradient s.gltf -o x.png", 2, "s.gltf", "must end in .exr");
    EXPECT_FAILURE("lightfield emd-gradient p.exr -o x.png", 3, "p.exr",
                   "an image of a light field camera", "--angular");
    EXPECT_FAILURE("lightfield views g.exr -o x.png", 3, "g.exr",
                   "an image of a light field camera");
    EXPECT_FAILURE("lightfield emd-gradient p.exr -o x.png --angular 5x4", 3, "p.exr", "24 x 16",
                   "5 x 4");
    EXPECT_FAILURE("lightfield emd-gradient g.exr -o x.png --angular 2x2", 3, "g.exr", "(0, 0)",
                   "NaN");
    run_well("lightfield emd-gradient p.exr -o x.png --angular 3x4");
}

/* --- signals
 * ----------------------------------------------------------------------------------------------------
 */

/* Waits until the program handles a signal, as the kernel tells. False after
 * 30 s or at its end. */
static bool wait_for_handler(pid_t pid, int signal) {
    char path[64], line[256];
    snprintf(path, sizeof path, "/proc/%d/status", (int)pid);
    for (int i = 0; i < 30000; ++i) {
        unsigned long long caught = 0;
        FILE *file = fopen(path, "r");
        while (file && fgets(line, sizeof line, file))
            if (strncmp(line, "SigCgt:", 7) == 0) caught = strtoull(line + 7, NULL, 16);
        if (file) fclose(file);
        if (caught >> (signal - 1) & 1) return true;
        nanosleep(&(struct timespec){0, 1000000}, NULL);
    }
    return false;
}

static void test_first_signal_saves(void **state) {
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM};
    for (int i = 0; i < 2; ++i) {
        write_scene("s.gltf", pinhole, panel);
        const pid_t pid = start("render s.gltf --time 100");
        assert_true(wait_for_handler(pid, signals[i]));
        kill(pid, signals[i]);
        const int code = finish(pid);
        if (code != 128 + signals[i])
            fail_msg("exit code %d instead of %d: %s", code, 128 + signals[i], err);
        assert_non_null(strstr(err, "s.exr"));
        expect_panel("s.exr", 24, 16);
        expect_png("s.png", 24, 16);
        assert_int_equal(count_files(), 3);
    }
}

/* A preview comes before the image. Where the image then cannot be written, the preview's file is
 * what it was before: absent, or that of an earlier image. */
static void test_failed_render_withdraws_its_preview(void **state) {
    (void)state;
    /* OpenCL's compiler writes files of 1.4 MB; an image of noise in four parts is 3.2 MB. */
    static const char command[] =
        "trap '' XFSZ; ulimit -f 5000; '" MCV_BINARY_DIR "/mcvisi' render '" MCV_SOURCE_DIR
        "/scenes/scratch.gltf' -o s.exr --resolution 500x400 --replicates 2 --parts replicates "
        "--error 0.9 "
        "> failed.txt 2>&1";
    run_well("render " MCV_SOURCE_DIR "/scenes/scratch.gltf -o s.exr --resolution 24x16 --spp 4");
    for (int older = 1; older >= 0; --older) {
        struct stat before = {0}, after;
        uint8_t *bytes[2] = {0};
        size_t sizes[2];
        mcv_error error = {""};
        if (older) {
            assert_int_equal(stat("s.png", &before), 0);
            assert_int_equal(mcv_file_load("s.png", &bytes[0], &sizes[0], &error), MCV_OK);
        } else {
            assert_int_equal(unlink("s.png"), 0);
        }
        const int status = system(command);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != 1)
            fail_msg("exit code %d instead of 1; see failed.txt", WEXITSTATUS(status));
        assert_int_equal(system("grep -q 's.exr: writing failed' failed.txt"), 0);
        assert_int_equal(stat("s.png", &after), older ? 0 : -1);
        if (older) {
            /* It was replaced, and put back. */
            assert_true(before.st_ino != after.st_ino ||
                        before.st_mtim.tv_nsec != after.st_mtim.tv_nsec);
            assert_int_equal(mcv_file_load("s.png", &bytes[1], &sizes[1], &error), MCV_OK);
            assert_int_equal(sizes[0], sizes[1]);
            assert_memory_equal(bytes[0], bytes[1], sizes[0]);
        }
        free(bytes[0]);
        free(bytes[1]);
    }
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup(name, fresh_folder)
    const struct CMUnitTest made[] = {
        TEST(test_wrong_usage),
        TEST(test_help),
        TEST(test_bad_files),
        TEST(test_bad_scenes),
        TEST(test_no_device),
        TEST(test_names_with_control_characters),
        TEST(test_render_adaptive),
        TEST(test_pictures_that_differ_in_light_paths),
        TEST(test_render_writes_pictures),
        TEST(test_reference_device),
        TEST(test_precision),
        TEST(test_light_fields_are_uniform),
        TEST(test_light_field_resolution),
        TEST(test_several_sensors),
        TEST(test_json),
        TEST(test_sample_ranges),
        TEST(test_check),
        TEST(test_trace),
        TEST(test_failed_render_withdraws_its_preview),
        TEST(test_first_signal_saves),
    };
    const struct CMUnitTest measured[] = {
        TEST(test_camera),
        TEST(test_camera_bad_input),
        TEST(test_measure_a_render),
        TEST(test_measure),
        TEST(test_level_of_a_render),
        TEST(test_contrast_without_the_render),
        TEST(test_channels_of_a_colour_picture),
        TEST(test_units_of_options),
        TEST(test_measure_circles),
        TEST(test_measure_bad_input),
        TEST(test_compare),
        TEST(test_compare_scenes),
        TEST(test_compare_bad_input),
    };
    const struct CMUnitTest light_fields[] = {
        TEST(test_light_field_boxes),     TEST(test_light_field_views),
        TEST(test_lens_of_the_camera),    TEST(test_light_field_gradient),
        TEST(test_light_field_bad_input),
    };
#undef TEST
    switch (PART) {
    case PART_MAKE:
        return cmocka_run_group_tests(made, NULL, remove_folder);
    case PART_MEASURE:
        return cmocka_run_group_tests(measured, NULL, remove_folder);
    default:
        return cmocka_run_group_tests(light_fields, NULL, remove_folder);
    }
}
