/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a render, joined in any order, are the render. */
#include "test.h"

#include "child.h"
#include "same_image.h"

#include "film/film_file.h"

#define SCENES MCV_SOURCE_DIR "/scenes/"
#define BEAM SCENES "beam.gltf --resolution 32x24 --checkpoint off"

static void render_part(const char *options, unsigned first, unsigned last, const char *name) {
    char line[1024];
    snprintf(line, sizeof line, "render %s --samples %u:%u -o %s.exr --film %s.film", options,
             first, last, name, name);
    program_well(line);
}

/* Parts [begin, end) of `samples` each, into NAME-0.film …; the words of a line that merges them,
 * in an order that depends on the seed. */
static void render_parts(const char *options, unsigned samples, unsigned begin, unsigned end,
                         const char *name, unsigned seed, char *words, size_t size) {
    unsigned order[64];
    for (unsigned i = begin; i < end; ++i) {
        char part[64];
        snprintf(part, sizeof part, "%s-%u", name, i);
        render_part(options, i * samples, (i + 1) * samples, part);
        order[i - begin] = i;
    }
    srand48(seed);
    words[0] = '\0';
    for (unsigned left = end - begin; left > 0; --left) {
        const unsigned k = (unsigned)(drand48() * left);
        snprintf(words + strlen(words), size - strlen(words), " %s-%u.film", name, order[k]);
        order[k] = order[left - 1];
    }
}

static void parts_are_one_render(const char *options, unsigned count, unsigned seed) {
    char words[2048], line[4096];
    snprintf(line, sizeof line, "render %s --samples 0:64 -o whole.exr", options);
    program_well(line);
    render_parts(options, 64 / count, 0, count, "part", seed, words, sizeof words);
    snprintf(line, sizeof line, "merge %s -o merged.exr", words);
    program_well(line);
    expect_same_image("whole.exr", "merged.exr");
    assert_int_equal(access("merged.png", R_OK), 0);
}

static void test_parts_in_any_order_are_one_render(void **state) {
    (void)state;
    parts_are_one_render(BEAM, 8, 1);
    render_part(BEAM, 32, 64, "half");
    program_well("merge half.film part-3.film part-0.film part-2.film part-1.film -o merged.exr");
    expect_same_image("whole.exr", "merged.exr");
    parts_are_one_render(SCENES "caustic.gltf --resolution 24x24 --checkpoint off", 4, 2);
    parts_are_one_render(BEAM " --device reference --replicates 2", 4, 3);
}

/* The middle of a sequence is a picture, too: that of the range. */
static void test_a_range_in_the_middle(void **state) {
    char words[512], line[1024];
    (void)state;
    program_well("render " BEAM " --samples 16:32 -o whole.exr --parts replicates");
    render_parts(BEAM, 4, 4, 8, "middle", 5, words, sizeof words);
    snprintf(line, sizeof line, "merge %s -o merged.exr --parts replicates", words);
    program_well(line);
    expect_same_image("whole.exr", "merged.exr");
}

static void copy_file(const char *from, const char *to, size_t most, long flipped) {
    static char bytes[1 << 20];
    FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
    assert_true(in && out);
    size_t size = fread(bytes, 1, sizeof bytes, in);
    if (size > most) size = most;
    if (flipped >= 0) bytes[flipped] ^= 4;
    assert_int_equal(fwrite(bytes, 1, size, out), size);
    fclose(in);
    fclose(out);
}

static void test_what_is_wrong_is_named(void **state) {
    static const struct {
        const char *files, *words;
        int code;
    } cases[] = {
        {"p-0.film p-2.film p-3.film", "samples 4:8 are missing", 3},
        {"p-0.film p-1.film p-2.film", "samples 12:16 are missing", 3},
        {"p-1.film", "", 0},
        {"p-1.film p-2.film p-3.film", "samples 0:4 are missing", 3},
        {"p-0.film p-1.film p-1.film", "both hold samples 4:8", 3},
        {"p-0.film big.film", "both hold samples 0:4", 3},
        {"p-0.film seed-1.film", "--seed differs", 3},
        {"p-0.film sky-1.film", "the scene differs", 3},
        {"p-0.film cut.film", "cut.film: is no whole film file", 3},
        {"p-0.film flipped.film", "flipped.film: is no whole film file", 3},
        {"p-0.film p-0.exr", "p-0.exr: is no film file", 3},
        {"p-0.film nothing.film", "nothing.film: cannot be read", 3},
    };
    char words[512], line[1024];
    (void)state;
    render_parts(BEAM, 4, 0, 4, "p", 1, words, sizeof words);
    render_part(BEAM, 0, 8, "big");
    render_part(BEAM " --seed 3", 4, 8, "seed-1");
    render_part(SCENES "sky.gltf --resolution 32x24", 4, 8, "sky-1");
    copy_file("p-1.film", "cut.film", 20000, -1);
    copy_file("p-1.film", "flipped.film", 1 << 20, 30000);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        snprintf(line, sizeof line, "merge %s -o wrong.exr", cases[i].files);
        program_fails(line, cases[i].code, cases[i].words);
    }
    program_fails("merge p-0.film p-1.film", 2, "give -o IMAGE.exr");
    program_fails("merge p-0.film p-1.film -o p-0.film", 2, "must end in .exr");
    program_fails("render " BEAM " --spp 8 --film x.film", 2, "give their samples by --samples");
}

/* A part of another driver joins with a warning. */
static void test_other_drivers_are_told(void **state) {
    mcv_film_file file;
    mcv_error error = {""};
    (void)state;
    render_part(BEAM, 0, 4, "own");
    render_part(BEAM, 4, 8, "other");
    assert_int_equal(mcv_film_file_read("other.film", &file, &error), MCV_OK);
    json_object_set_new(json_object_get(file.facts, "device"), "driver", json_string("of others"));
    json_object_del(file.facts, "film");
    assert_int_equal(mcv_film_file_write("other.film", &file.film, &file.round, file.facts, &error),
                     MCV_OK);
    mcv_film_file_free(&file);
    program_well("merge other.film own.film -o merged.exr");
    assert_non_null(strstr(said, "different devices or drivers"));
}

/* The library gives the picture itself. */
static void test_library(void **state) {
    static const char *const files[] = {"own.film", "other.film"};
    mcv_error error = {""};
    mcv_picture *picture = NULL;
    char *report = NULL;
    mcv_part part = {.size = sizeof part};
    (void)state;
    assert_int_equal(mcv_films_merge(files, 2, NULL, &picture, &report, &error), MCV_OK);
    assert_int_equal(mcv_picture_part(picture, 0, &part, &error), MCV_OK);
    assert_int_equal(part.width, 32);
    assert_non_null(strstr(report, "\"parts\":2"));
    mcv_text_free(report);
    mcv_picture_free(picture);
    assert_int_equal(mcv_films_merge(files, 0, NULL, &picture, NULL, &error), MCV_USAGE);
    assert_int_equal(mcv_films_merge(NULL, 2, NULL, &picture, NULL, &error), MCV_USAGE);
    assert_null(picture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_in_any_order_are_one_render),
        cmocka_unit_test(test_a_range_in_the_middle),
        cmocka_unit_test(test_what_is_wrong_is_named),
        cmocka_unit_test(test_other_drivers_are_told),
        cmocka_unit_test(test_library),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
