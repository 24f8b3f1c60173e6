/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "io/exr.h"
#include "io/exr_header.h"

static const char PATH[] = "test_exr.exr";

static mcv_image new_image(uint32_t width, uint32_t height, uint32_t channels) {
    mcv_image image;
    mcv_error error = {""};
    if (mcv_image_new(&image, width, height, channels, &error) != MCV_OK)
        fail_msg("%s", error.text);
    return image;
}

/* Every kind of float: random bits hold NaNs with payloads, infinities, denormals and both zeros;
 * those that must be there come first. */
static void fill(mcv_image *image, uint32_t seed) {
    const uint32_t special[] = {0x80000000u, 0u,          1u,          0x807fffffu, 0x7f800000u,
                                0xff800000u, 0x7fc00000u, 0xffc12345u, 0x7f7fffffu};
    const size_t count = (size_t)image->width * image->height * image->channels;
    for (size_t i = 0; i < count; ++i) {
        seed = seed * 1664525u + 1013904223u;
        /* Half random, half constant, so that some chunks compress and others do not. */
        const uint32_t noise = i < count / 2 ? seed : 0x3f800000u;
        memcpy(&image->pixels[i], i < sizeof special / sizeof special[0] ? &special[i] : &noise,
               sizeof noise);
    }
}

static void expect_same_bits(const mcv_image *a, const mcv_image *b, const char *what) {
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    const size_t count = (size_t)a->width * a->height * a->channels;
    for (size_t i = 0; i < count; ++i) {
        uint32_t x, y;
        memcpy(&x, &a->pixels[i], 4);
        memcpy(&y, &b->pixels[i], 4);
        if (x != y) fail_msg("%s: value %zu was %08x and came back as %08x", what, i, x, y);
    }
}

static const mcv_attribute *find(const mcv_exr *exr, const char *name) {
    for (uint32_t i = 0; i < exr->attribute_count; ++i) {
        if (strcmp(exr->attributes[i].name, name) == 0) return &exr->attributes[i];
    }
    fail_msg("attribute %s is missing", name);
    return NULL;
}

static void write_parts(const mcv_exr_part *parts, uint32_t count, const mcv_attribute *attributes,
                        uint32_t attribute_count) {
    mcv_error error = {""};
    if (mcv_exr_write(PATH, parts, count, attributes, attribute_count, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

static mcv_exr read_back(void) {
    mcv_exr exr;
    mcv_error error = {""};
    if (mcv_exr_read(PATH, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    return exr;
}

/* Sizes around the 16 lines of a chunk, one and three channels, one, two and three parts. */
static void test_round_trip_keeps_every_bit(void **state) {
    (void)state;
    const uint32_t sizes[][2] = {{1, 1}, {7, 15}, {16, 16}, {5, 17}, {300, 100}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        for (uint32_t channels = 1; channels <= 3; channels += 2) {
            for (uint32_t count = 1; count <= 3; ++count) {
                const char *names[] = {"beauty", "error", "samples"};
                mcv_exr_part parts[3];
                for (uint32_t p = 0; p < count; ++p) {
                    parts[p] = (mcv_exr_part){
                        .name = names[p], .image = new_image(sizes[s][0], sizes[s][1], channels)};
                    fill(&parts[p].image, 100 * (uint32_t)s + 10 * channels + p);
                }
                write_parts(parts, count, NULL, 0);
                mcv_exr exr = read_back();
                assert_int_equal(exr.part_count, count);
                for (uint32_t p = 0; p < count; ++p) {
                    if (count > 1) assert_string_equal(exr.parts[p].name, names[p]);
                    assert_string_equal(exr.parts[p].channel_names[0], channels == 1 ? "Y" : "R");
                    if (channels == 3) assert_string_equal(exr.parts[p].channel_names[2], "B");
                    expect_same_bits(&parts[p].image, &exr.parts[p].image, names[p]);
                    mcv_image_free(&parts[p].image);
                }
                mcv_exr_free(&exr);
            }
        }
    }
    unlink(PATH);
}

/*
 * A chunk that compression leaves as long as it was must not be stored compressed, since its length
 * is how readers tell. Of images in which all but a few values are random, each few more compress
 * by some bytes more, so that some hit that length.
 */
static void test_chunks_that_do_not_shrink(void **state) {
    (void)state;
    mcv_image image = new_image(64, 16, 1);
    mcv_error error = {""};
    for (uint32_t constant = 0; constant < 400; ++constant) {
        uint32_t seed = constant;
        for (uint32_t i = 0; i < 64 * 16; ++i) {
            seed = seed * 1664525u + 1013904223u;
            const uint32_t bits =
                i < constant / 8 ? 0x3f800000u : 0x3f000000u | (seed ^ seed >> 15) >> 8;
            memcpy(&image.pixels[i], &bits, sizeof bits);
        }
        const mcv_exr_part part = {.name = "image", .image = image};
        mcv_exr exr;
        if (mcv_exr_write(PATH, &part, 1, NULL, 0, &error) != MCV_OK ||
            mcv_exr_read(PATH, &exr, &error) != MCV_OK)
            fail_msg("%u: %s", constant, error.text);
        char what[32];
        snprintf(what, sizeof what, "image %u", constant);
        expect_same_bits(&image, &exr.parts[0].image, what);
        mcv_exr_free(&exr);
    }
    mcv_image_free(&image);
    unlink(PATH);
}

static void test_attributes_come_back(void **state) {
    (void)state;
    mcv_attribute attributes[] = {
        {.name = "mcvisi:scene", .text = "{\"asset\":{\"version\":\"2.0\"}} µm"},
        {.name = "mcvisi:empty", .text = ""},
        {.name = "mcvisi:seed", .numbers = {4294967295.0}, .count = 1},
        {.name = "mcvisi:error", .numbers = {0.1}, .count = 1},
        {.name = "sensorOverallDimensions", .numbers = {8.4456, 7.0656}, .count = 2},
        {.name = "mcvisi:pair", .numbers = {0.1, -0.0}, .count = 2},
        {.name = "worldToCamera", .count = 16},
        {.name = "mcvisi:pose", .count = 16},
        {.name = "focus", .numbers = {0.11}, .count = 1},
        {.name = "mcvisi:region", .numbers = {65536, 3, 0.1, -7}, .count = 4},
    };
    for (int i = 0; i < 16; ++i) attributes[6].numbers[i] = attributes[7].numbers[i] = 0.1 * i;
    mcv_exr_part parts[2] = {{.name = "beauty", .image = new_image(3, 2, 1)},
                             {.name = "error", .image = new_image(3, 2, 1)}};
    for (uint32_t count = 1; count <= 2; ++count) {
        write_parts(parts, count, attributes, sizeof attributes / sizeof attributes[0]);
        mcv_exr exr = read_back();
        assert_string_equal(find(&exr, "mcvisi:scene")->text, attributes[0].text);
        assert_string_equal(find(&exr, "mcvisi:empty")->text, "");
        assert_true(find(&exr, "mcvisi:seed")->numbers[0] == 4294967295.0);
        assert_true(find(&exr, "mcvisi:error")->numbers[0] == 0.1);
        assert_true(find(&exr, "mcvisi:pair")->numbers[0] == 0.1 &&
                    signbit(find(&exr, "mcvisi:pair")->numbers[1]));
        assert_true(find(&exr, "mcvisi:pose")->numbers[15] == 0.1 * 15);
        /* Four numbers are a vector of float. */
        const mcv_attribute *region = find(&exr, "mcvisi:region");
        assert_int_equal(region->count, 4);
        assert_true(region->numbers[0] == 65536 && region->numbers[1] == 3 &&
                    region->numbers[2] == (double)0.1f && region->numbers[3] == -7);
        /* Standard names have OpenEXR's types, which are float. */
        assert_true(find(&exr, "focus")->numbers[0] == (double)0.11f);
        assert_true(find(&exr, "sensorOverallDimensions")->numbers[1] == (double)7.0656f);
        assert_true(find(&exr, "worldToCamera")->numbers[7] == (double)(float)(0.1 * 7));
        mcv_exr_free(&exr);
    }
    for (int p = 0; p < 2; ++p) mcv_image_free(&parts[p].image);
    unlink(PATH);
}

static uint8_t *load(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

/* Whether name, type, size and value of an attribute stand in the header, byte for byte as the file
 * layout wants it. */
static bool holds(const uint8_t *bytes, size_t size, const void *attribute, size_t length) {
    return memmem(bytes, size, attribute, length) != NULL;
}

/* The file against the published layout, not against our reader or the library. */
static void test_header_bytes_are_the_standards(void **state) {
    (void)state;
    mcv_exr_part parts[2] = {{.name = "beauty", .image = new_image(5, 20, 3)},
                             {.name = "error", .image = new_image(5, 20, 3)}};
    const mcv_attribute focus = {.name = "focus", .numbers = {1}, .count = 1};
    for (uint32_t count = 1; count <= 2; ++count) {
        write_parts(parts, count, &focus, 1);
        size_t size;
        uint8_t *bytes = load(PATH, &size);
        const uint8_t magic[] = {0x76, 0x2f, 0x31, 0x01, 2, count == 2 ? 0x10 : 0, 0, 0};
        assert_memory_equal(bytes, magic, sizeof magic);
        assert_true(holds(bytes, size, "compression\0compression\0\1\0\0\0\3", 29));
        assert_true(holds(bytes, size,
                          "dataWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\4\0\0\0\x13\0\0\0", 37));
        assert_true(holds(
            bytes, size, "displayWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\4\0\0\0\x13\0\0\0", 40));
        assert_true(holds(bytes, size, "focus\0float\0\4\0\0\0\0\0\x80\x3f", 20));
        assert_true(holds(
            bytes, size,
            "channels\0chlist\0\x37\0\0\0B\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0G\0\2\0\0\0", 44));
        assert_true(holds(bytes, size, "lineOrder\0lineOrder\0\1\0\0\0\0", 25));
        assert_true(holds(bytes, size, "pixelAspectRatio\0float\0\4\0\0\0\0\0\x80\x3f", 31));
        assert_true(holds(bytes, size, "screenWindowWidth\0float\0\4\0\0\0\0\0\x80\x3f", 32));
        if (count == 2) {
            assert_true(holds(bytes, size, "name\0string\0\6\0\0\0beauty", 22));
            assert_true(holds(bytes, size, "name\0string\0\5\0\0\0error", 21));
            assert_true(holds(bytes, size, "type\0string\0\x0d\0\0\0scanlineimage", 29));
            assert_true(holds(bytes, size, "chunkCount\0int\0\4\0\0\0\2\0\0\0", 23));
        }
        free(bytes);
    }
    for (int p = 0; p < 2; ++p) mcv_image_free(&parts[p].image);
    unlink(PATH);
}

static void test_writing_refuses_by_name(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_exr_part part = {.name = "beauty", .image = new_image(2, 2, 2)};
    assert_int_equal(mcv_exr_write(PATH, &part, 1, NULL, 0, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "beauty has 2 channels"));
    part.image.channels = 1;
    const mcv_attribute lengthy = {.name = "mcvisi:a name that is far too long", .text = "x"};
    assert_int_equal(mcv_exr_write(PATH, &part, 1, &lengthy, 1, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "far too long"));
    /* The library writes this one itself. */
    const mcv_attribute taken = {.name = "compression", .text = "x"};
    assert_int_equal(mcv_exr_write(PATH, &part, 1, &taken, 1, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, PATH));
    const mcv_exr_part twins[] = {part, part};
    assert_int_equal(mcv_exr_write(PATH, twins, 2, NULL, 0, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "two parts"));
    assert_int_equal(mcv_exr_write("no/such/folder.exr", &part, 1, NULL, 0, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "no/such/folder.exr"));
    assert_int_equal(access(PATH, F_OK), -1);
    mcv_image_free(&part.image);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID,
                  &t); /* of this process alone: the machine may be busy */
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Reads the file; a failure must be bad input in one sentence that names it. Returns whether it
 * could be read. */
static bool survives(const char *path) {
    mcv_exr exr;
    mcv_error error = {""};
    const double start = now();
    const mcv_result result = mcv_exr_read(path, &exr, &error);
    if (now() - start > 1) fail_msg("%s took %.2f s", path, now() - start);
    if (result == MCV_OK) {
        mcv_exr_free(&exr);
        return true;
    }
    if (result != MCV_BAD_INPUT)
        fail_msg("%s: code %d instead of %d: %s", path, result, MCV_BAD_INPUT, error.text);
    if (!strstr(error.text, path)) fail_msg("the sentence does not name %s: %s", path, error.text);
    return false;
}

/* Every byte of the header and tables of a small file, changed in several ways, and every length
 * the file may be cut to. */
static void test_damage_is_reported(void **state) {
    (void)state;
    mcv_exr_part parts[2] = {{.name = "beauty", .image = new_image(9, 33, 1)},
                             {.name = "error", .image = new_image(9, 33, 1)}};
    for (int p = 0; p < 2; ++p) fill(&parts[p].image, (uint32_t)p);
    const mcv_attribute note = {.name = "comments", .text = "a note"};
    for (uint32_t count = 1; count <= 2; ++count) {
        write_parts(parts, count, &note, 1);
        size_t size;
        uint8_t *bytes = load(PATH, &size);
        mcv_error error = {""};
        mcv_exr_header header;
        assert_int_equal(mcv_exr_header_read(PATH, bytes, size, &header, &error), MCV_OK);
        mcv_exr_header_free(&header);
        for (size_t length = 0; length < size; ++length) {
            /* A copy of the exact length: the address sanitizer sees one byte too far. */
            uint8_t *cut = malloc(length ? length : 1);
            assert_non_null(cut);
            memcpy(cut, bytes, length);
            if (mcv_exr_header_read(PATH, cut, length, &header, &error) != MCV_BAD_INPUT)
                fail_msg("cut to %zu bytes it is read", length);
            free(cut);
        }
        const uint8_t flips[] = {0x01, 0x80, 0xff};
        int rejected = 0, tried = 0;
        for (size_t at = 0; at < size && at < 1200; ++at) {
            const uint8_t flip = flips[at % sizeof flips];
            bytes[at] ^= flip;
            FILE *file = fopen(PATH, "wb");
            assert_non_null(file);
            assert_int_equal(fwrite(bytes, 1, size, file), size);
            fclose(file);
            bytes[at] ^= flip;
            rejected += !survives(PATH);
            ++tried;
        }
        /* Some bytes do not matter (a note's text, names of attributes that nobody needs, pixels);
         * the sizes and offsets do. */
        if (rejected < tried / 4)
            fail_msg("only %d of %d changed files were rejected", rejected, tried);
        free(bytes);
    }
    for (int p = 0; p < 2; ++p) mcv_image_free(&parts[p].image);
    unlink(PATH);
    assert_false(survives("no such file"));
    assert_false(survives("."));
    assert_false(survives("/dev/zero"));
}

/* Puts `count` bytes of attributes behind the version of a file of one part and one chunk. */
static void insert_attributes(const char *attributes, size_t count) {
    size_t size, table = 8;
    uint8_t *bytes = load(PATH, &size);
    /* The table of offsets has the place behind itself. */
    while (table + 8 < size && bytes[table] + 256U * bytes[table + 1] != table + 8) ++table;
    assert_true(table + 8 < size && table + 8 + count < 65536);
    bytes[table] = (uint8_t)(table + 8 + count);
    bytes[table + 1] = (uint8_t)((table + 8 + count) >> 8);
    FILE *file = fopen(PATH, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, 8, file), 8);
    assert_int_equal(fwrite(attributes, 1, count, file), count);
    assert_int_equal(fwrite(bytes + 8, 1, size - 8, file), size - 8);
    assert_int_equal(fclose(file), 0);
    free(bytes);
}

/* OpenEXR takes an attribute of a type that it knows by what it says of itself, not by its size:
 * the integer of 8 bytes moves all that follows, the others ask for some gigabytes. */
static void test_attributes_that_nobody_needs(void **state) {
    (void)state;
    static const char number[] = "a\0int\0\10\0\0\0\1\0\0\0\2\0\0",
                      preview[] = "preview\0preview\0\10\0\0\0\377\177\0\0\377\177\0",
                      manifest[] = "m\0idmanifest\0\14\0\0\0\0\377\377\177\0\0\0\0\1\2\3",
                      nothing[] = "n\0\0\0\0\0";
    static const struct {
        const char *bytes;
        size_t count;
    } cases[] = {{number, sizeof number},
                 {preview, sizeof preview},
                 {manifest, sizeof manifest},
                 {nothing, sizeof nothing}};
    mcv_exr_part part = {.name = NULL, .image = new_image(9, 13, 1)};
    fill(&part.image, 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_parts(&part, 1, NULL, 0);
        insert_attributes(cases[i].bytes, cases[i].count);
        mcv_exr exr = read_back();
        assert_memory_equal(exr.parts[0].image.pixels, part.image.pixels, sizeof(float) * 9 * 13);
        mcv_exr_free(&exr);
    }
    mcv_image_free(&part.image);
    unlink(PATH);
}

/* Attributes are kept by OpenEXR and by us, and count. */
static void test_attributes_count(void **state) {
    (void)state;
    enum { LONG = 10000 };
    char text[LONG + 1];
    mcv_exr_part part = {.name = "image", .image = new_image(9, 13, 1)};
    mcv_error error = {""};
    uint64_t pixels, reading[2];
    memset(text, 'a', LONG);
    for (int i = 0; i < 2; ++i) {
        text[i == 0 ? 0 : LONG] = '\0';
        const mcv_attribute told = {.name = "comments", .text = text};
        write_parts(&part, 1, &told, 1);
        assert_int_equal(mcv_exr_size(PATH, &pixels, reading + i, &error), MCV_OK);
        text[0] = 'a';
    }
    assert_int_equal(pixels, 9 * 13);
    assert_int_equal(reading[1] - reading[0], 4 * LONG);
    mcv_image_free(&part.image);
    unlink(PATH);
}

/* The channels of a picture correlate by -1 to 1: the ends are read, what lies beyond is refused.
 */
static void test_correlation_of_channels(void **state) {
    static const double values[] = {-1, 1, -1.001, 1e300, NAN};
    mcv_image image = new_image(3, 2, 3);
    mcv_error error = {""};
    mcv_exr exr;
    (void)state;
    for (size_t k = 0; k < sizeof values / sizeof values[0]; ++k) {
        const mcv_attribute told = {.name = MCV_EXR_CHANNELS, .numbers = {values[k]}, .count = 1};
        write_parts(&(mcv_exr_part){.name = "image", .image = image}, 1, &told, 1);
        if (k < 2) {
            assert_int_equal(mcv_exr_read(PATH, &exr, &error), MCV_OK);
            assert_true(mcv_exr_channel_correlation(&exr) == values[k]);
            mcv_exr_free(&exr);
        } else {
            assert_int_equal(mcv_exr_read(PATH, &exr, &error), MCV_BAD_INPUT);
            if (!strstr(error.text, PATH) || !strstr(error.text, "must be -1 to 1"))
                fail_msg("%g: %s", values[k], error.text);
        }
    }
    mcv_image_free(&image);
    unlink(PATH);
}

/* 87 files that have crashed OpenEXR, and three with extreme values. */
static void test_collected_files(void **state) {
    (void)state;
    static const char folder[] = MCV_SOURCE_DIR "/tests/io/openexr-images/damaged",
                      extreme[] = MCV_SOURCE_DIR "/tests/io/openexr-images/extreme";
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    int count = 0, readable = 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (entry->d_name[0] == '.') continue;
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        readable += survives(path);
        ++count;
    }
    closedir(directory);
    print_message("%d damaged files, %d of them readable all the same\n", count, readable);
    assert_int_equal(count, 87);

    char path[1024];
    mcv_error error = {""};
    mcv_exr exr;
    snprintf(path, sizeof path, "%s/BrightRingsNanInf.exr", extreme);
    if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(exr.parts[0].image.channels, 3);
    assert_int_equal(exr.parts[0].image.width, 800);
    assert_int_equal(exr.parts[0].image.height, 800);
    int nans = 0, infinities = 0;
    for (size_t i = 0; i < (size_t)3 * 800 * 800; ++i) {
        nans += isnan(exr.parts[0].image.pixels[i]);
        infinities += isinf(exr.parts[0].image.pixels[i]) != 0;
    }
    assert_int_equal(nans, 6); /* as OpenEXR's C++ reader finds them */
    assert_int_equal(infinities, 12);
    mcv_exr_free(&exr);
    for (int i = 0; i < 2; ++i) { /* PIZ and PXR24 */
        snprintf(path, sizeof path, "%s/%s", extreme,
                 i ? "WideFloatRange.exr" : "AllHalfValues.exr");
        if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
        mcv_exr_free(&exr);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip_keeps_every_bit),
        cmocka_unit_test(test_chunks_that_do_not_shrink),
        cmocka_unit_test(test_attributes_come_back),
        cmocka_unit_test(test_header_bytes_are_the_standards),
        cmocka_unit_test(test_writing_refuses_by_name),
        cmocka_unit_test(test_damage_is_reported),
        cmocka_unit_test(test_attributes_that_nobody_needs),
        cmocka_unit_test(test_attributes_count),
        cmocka_unit_test(test_correlation_of_channels),
        cmocka_unit_test(test_collected_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
