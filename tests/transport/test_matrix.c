/* SPDX-License-Identifier: Apache-2.0 */
/* Light transport matrices of made-up records: sums, thinning, products, files. */
#include "matrices.h"
#include "program.h"
#include "test.h"

#include "mcvisi/tables.h"
#include "transport/matrix_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 5, HEIGHT = 4, CHANNELS = 3, REPLICATES = 4, SAMPLES = 8, ELEMENTS = 30 };
enum { RECORDS = 6000, WORDS = 2 + CHANNELS };

static mcv_error error;
#define WELL(call) \
    do { \
        if ((call) != MCV_OK) fail_msg("%s", error.text); \
    } while (0)

static uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Values over 40 powers of two. */
static void make_records(uint32_t *records) {
    uint32_t state = 1;
    for (int i = 0; i < RECORDS; ++i) {
        uint32_t *r = records + (size_t)i * WORDS;
        r[0] = next_random(&state) % (WIDTH * HEIGHT * REPLICATES);
        r[1] = next_random(&state) % ELEMENTS;
        for (int c = 0; c < CHANNELS; ++c) {
            const float value = (float)ldexp(1 + (double)(next_random(&state) & 0xffff) / 0x10000,
                                             -(int)(next_random(&state) % 40));
            memcpy(r + 2 + c, &value, sizeof value);
        }
    }
}

/* In so many bytes of memory, which have room for all or send most to a file. */
static mcv_matrix make_in(size_t memory, const uint32_t *records, bool backwards, double keep) {
    mcv_gather gather;
    mcv_matrix matrix;
    WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, memory, &error));
    for (int i = 0; i < RECORDS; ++i) {
        const size_t at = (size_t)(backwards ? RECORDS - 1 - i : i) * WORDS;
        WELL(mcv_gather_add(&gather, records + at, 1, &error));
    }
    WELL(mcv_matrix_make(&gather, WIDTH, HEIGHT, SAMPLES, ELEMENTS, keep, &matrix, &error));
    mcv_gather_free(&gather);
    return matrix;
}

static mcv_matrix make_matrix(const uint32_t *records, bool backwards) {
    return make_in((size_t)1 << 30, records, backwards, 1);
}

/* A header, which files need. */
static void describe(mcv_matrix *m) {
    m->group_count = 2;
    m->groups = calloc(2, sizeof *m->groups);
    m->pattern = calloc(ELEMENTS * CHANNELS, sizeof *m->pattern);
    for (uint32_t i = 0; i < 2; ++i) {
        m->groups[i] = (mcv_element_group){.emitter = strdup(i ? "lamp" : "projector"),
                                           .type = strdup(i ? "area" : "projector"),
                                           .first = i ? ELEMENTS - 1 : 0,
                                           .width = i ? 1 : ELEMENTS - 1,
                                           .height = 1,
                                           .radiance = {1, 2, 3}};
        m->groups[i].to_world[4] = 0.1;
    }
    for (int i = 0; i < ELEMENTS * CHANNELS; ++i) m->pattern[i] = 0.25f * (float)i;
    m->attributes = json_pack("{s:s}", "mcvisi:unit", "W/m^2");
}

/*
 * An entry is the sum of its records over samples and replicates. The quantum is 2^-52 of the
 * largest row sum or less; the sum of the test and the entry's conversion each round by 2^-53 of
 * it.
 */
static void test_entries_are_means(void **state) {
    static uint32_t records[RECORDS * WORDS];
    static double sums[WIDTH * HEIGHT * CHANNELS][ELEMENTS], largest;
    (void)state;
    make_records(records);
    for (int i = 0; i < RECORDS; ++i)
        for (int c = 0; c < CHANNELS; ++c) {
            const uint32_t *r = records + (size_t)i * WORDS;
            float value;
            memcpy(&value, r + 2 + c, sizeof value);
            sums[r[0] / REPLICATES * CHANNELS + (uint32_t)c][r[1]] += (double)value;
        }
    mcv_matrix m = make_matrix(records, false), other = make_matrix(records, true);
    for (size_t row = 0; row < m.row_count; ++row) {
        double sum = 0;
        for (int e = 0; e < ELEMENTS; ++e) sum += sums[row][e];
        largest = fmax(largest, sum);
    }
    size_t entries = 0;
    for (size_t row = 0; row < m.row_count; ++row) {
        size_t filled = 0;
        for (int e = 0; e < ELEMENTS; ++e) filled += sums[row][e] != 0;
        if (m.row_begins[row + 1] - m.row_begins[row] != filled)
            fail_msg("row %zu has %d entries, must have %zu", row,
                     (int)(m.row_begins[row + 1] - m.row_begins[row]), filled);
        for (uint64_t i = m.row_begins[row]; i < m.row_begins[row + 1]; ++i, ++entries) {
            const double expected = sums[row][m.columns[i]] / (SAMPLES * REPLICATES);
            double of_replicates = 0;
            for (int r = 0; r < REPLICATES; ++r)
                of_replicates += (double)m.replicates_of[i * REPLICATES + (uint64_t)r];
            if (!(fabs(m.values[i] - expected) <=
                  0x1p-52 * largest / (SAMPLES * REPLICATES) + 0x1p-50 * expected))
                fail_msg("row %zu, element %u: %.17g, expected %.17g", row, m.columns[i],
                         m.values[i], expected);
            /* Four floats, rounded once each. */
            assert_true(fabs(of_replicates / REPLICATES - expected) <= 0x1p-23 * expected);
        }
    }
    print_message("%zu entries\n", entries);
    expect_equal("records backwards", &m, &other);
    mcv_matrix_free(&m);
    mcv_matrix_free(&other);
}

static double row_sum(const mcv_matrix *m, size_t row, bool backwards) {
    const uint64_t first = m->row_begins[row], last = m->row_begins[row + 1];
    double sum = 0;
    for (uint64_t i = first; i < last; ++i)
        sum += m->values[backwards ? last - 1 - (i - first) : i];
    return sum;
}

/* Rows have the same sum in any order, and after thinning: to the bit. White is the sum. */
static void test_thinning_keeps_white(void **state) {
    static uint32_t records[RECORDS * WORDS];
    float ones[ELEMENTS * CHANNELS];
    mcv_image white, deviation;
    (void)state;
    make_records(records);
    mcv_matrix m = make_matrix(records, false),
               thin = make_in((size_t)1 << 30, records, false, 0.9);
    for (int i = 0; i < ELEMENTS * CHANNELS; ++i) ones[i] = 1;
    WELL(mcv_matrix_relight(&thin, ones, &white, &deviation, &error));
    assert_int_equal(thin.column_count, ELEMENTS + 1);
    for (size_t row = 0; row < m.row_count; ++row) {
        const double sum = row_sum(&m, row, false);
        const uint64_t last = thin.row_begins[row + 1] - 1;
        if (row_sum(&m, row, true) != sum || row_sum(&thin, row, false) != sum)
            fail_msg("row %zu: %.17g, backwards %.17g, thinned %.17g", row, sum,
                     row_sum(&m, row, true), row_sum(&thin, row, false));
        assert_true(white.pixels[row % CHANNELS * WIDTH * HEIGHT + row / CHANNELS] == (float)sum);
        /* What is dropped is a tenth at most, and one entry less would be kept without need. */
        if (thin.columns[last] != ELEMENTS || thin.values[last] > 0.1 * sum)
            fail_msg("row %zu: %g of %g dropped", row, thin.values[last], sum);
        double least = sum;
        for (uint64_t i = thin.row_begins[row]; i < last; ++i) least = fmin(least, thin.values[i]);
        assert_true(thin.values[last] + least >= 0.1 * sum * (1 - 0x1p-50));
    }
    assert_true(thin.row_begins[thin.row_count] < m.row_begins[m.row_count]);
    mcv_image_free(&white);
    mcv_image_free(&deviation);
    mcv_matrix_free(&m);
    mcv_matrix_free(&thin);
}

/* A pattern's image is the product; its error is that of the mean of the replicates' products. */
static void test_relighting_is_the_product(void **state) {
    static uint32_t records[RECORDS * WORDS];
    mcv_image mean, deviation;
    (void)state;
    make_records(records);
    mcv_matrix m = make_matrix(records, false);
    describe(&m);
    WELL(mcv_matrix_relight(&m, m.pattern, &mean, &deviation, &error));
    for (size_t row = 0; row < m.row_count; ++row) {
        const size_t c = row % CHANNELS, at = c * WIDTH * HEIGHT + row / CHANNELS;
        double sum = 0, by[REPLICATES] = {0}, variance = 0;
        for (uint64_t i = m.row_begins[row]; i < m.row_begins[row + 1]; ++i) {
            const double shown = 0.25 * (m.columns[i] * CHANNELS + (double)c);
            sum += shown * m.values[i];
            for (int r = 0; r < REPLICATES; ++r)
                by[r] += shown * (double)m.replicates_of[i * REPLICATES + (uint64_t)r];
        }
        const double middle = (by[0] + by[1] + by[2] + by[3]) / REPLICATES;
        for (int r = 0; r < REPLICATES; ++r) variance += pow(by[r] - middle, 2);
        const double expected = sqrt(variance / (REPLICATES - 1) / REPLICATES);
        /* One rounding to float each. */
        assert_true(fabs((double)mean.pixels[at] - sum) <= 0x1p-23 * sum);
        assert_true(fabs((double)deviation.pixels[at] - expected) <= 0x1p-22 * expected);
    }
    mcv_image_free(&mean);
    mcv_image_free(&deviation);
    mcv_matrix_free(&m);
}

/* --- files --- */

static uint8_t *read_all(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*size);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

static void write_all(const char *path, const uint8_t *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static void must_refuse(const char *what, size_t at) {
    mcv_matrix m;
    error.text[0] = '\0';
    if (mcv_matrix_read("bad.npz", &m, &error) != MCV_BAD_INPUT || !strstr(error.text, "bad.npz"))
        fail_msg("%s at byte %zu is not refused: \"%s\"", what, at, error.text);
}

/* What is written is read; each cut and each changed byte of a member is refused. */
static void test_files(void **state) {
    static uint32_t records[RECORDS * WORDS];
    mcv_matrix read;
    size_t size;
    (void)state;
    make_records(records);
    mcv_matrix m = make_in((size_t)1 << 30, records, false, 0.5);
    describe(&m);
    WELL(mcv_matrix_write(&m, "good.npz", &error));
    WELL(mcv_matrix_read("good.npz", &read, &error));
    expect_equal("written and read", &m, &read);
    assert_string_equal(read.groups[1].emitter, "lamp");
    assert_int_equal(read.groups[1].first, ELEMENTS - 1);
    assert_true(read.groups[0].to_world[4] == 0.1 && read.kept == 0.5);
    assert_memory_equal(read.pattern, m.pattern, ELEMENTS * CHANNELS * sizeof *m.pattern);
    uint8_t *bytes = read_all("good.npz", &size);
    for (size_t cut = 0; cut < size; cut += 1 + size / 64) {
        write_all("bad.npz", bytes, cut);
        must_refuse("a cut", cut);
    }
    /* Bytes 10 to 13 of a local header are a date and flags that nobody reads: those of the first
     * member begin the file. */
    for (size_t at = 64; at < size / 2; at += 1 + size / 128) {
        bytes[at] ^= 0x10;
        write_all("bad.npz", bytes, size);
        mcv_matrix damaged;
        if (mcv_matrix_read("bad.npz", &damaged, &error) == MCV_OK) {
            expect_equal("a byte between members", &m, &damaged);
            mcv_matrix_free(&damaged);
        }
        bytes[at] ^= 0x10;
    }
    /* In the largest array, each change counts. */
    for (size_t at = size / 2; at < size * 3 / 4; at += 1 + size / 64) {
        bytes[at] ^= 0x01;
        write_all("bad.npz", bytes, size);
        must_refuse("a changed byte", at);
        bytes[at] ^= 0x01;
    }
    free(bytes);
    mcv_matrix_free(&m);
    mcv_matrix_free(&read);
}

static void test_matrix_market(void **state) {
    static uint32_t records[RECORDS * WORDS];
    char line[128];
    size_t rows, columns, entries, row;
    unsigned column;
    double value;
    (void)state;
    make_records(records);
    mcv_matrix m = make_matrix(records, false);
    WELL(mcv_matrix_write(&m, "market.mtx", &error));
    FILE *file = fopen("market.mtx", "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line, "%%MatrixMarket matrix coordinate real general\n");
    // NOLINTNEXTLINE(cert-err34-c): numbers that do not fit are not equal below
    assert_int_equal(fscanf(file, "%zu %zu %zu", &rows, &columns, &entries), 3);
    assert_int_equal(rows, m.row_count);
    assert_int_equal(columns, ELEMENTS);
    assert_int_equal(entries, m.row_begins[m.row_count]);
    for (size_t r = 0; r < m.row_count; ++r)
        for (uint64_t i = m.row_begins[r]; i < m.row_begins[r + 1]; ++i) {
            // NOLINTNEXTLINE(cert-err34-c): numbers that do not fit are not equal below
            assert_int_equal(fscanf(file, "%zu %u %lf", &row, &column, &value), 3);
            assert_true(row == r + 1 && column == m.columns[i] + 1 && value == m.values[i]);
        }
    fclose(file);
    mcv_matrix_free(&m);
}

/* Records of as many entries: each has an element of its own. */
static void tell_apart(uint32_t *records) {
    for (int i = 0; i < RECORDS; ++i) records[i * WORDS + 1] = (uint32_t)(i % 4500);
}

/* The sums of 6000 records, 64 bytes each, do not fit into 1 MB with the 4096 that wait (44 bytes
 * each) three times over: what went to a file, in part twice, makes the same matrix, whole and
 * thinned. */
static void test_files_take_what_memory_has_no_room_for(void **state) {
    static uint32_t records[RECORDS * WORDS];
    static const double keeps[] = {1, 0.7};
    (void)state;
    make_records(records);
    tell_apart(records);
    for (size_t i = 0; i < sizeof keeps / sizeof keeps[0]; ++i) {
        mcv_matrix m = make_in((size_t)1 << 30, records, false, keeps[i]),
                   small = make_in((size_t)1 << 20, records, true, keeps[i]);
        /* Each channel of an entry is one of the matrix. */
        assert_true(i > 0 || m.row_begins[m.row_count] > (uint64_t)4096 * CHANNELS);
        expect_equal("in 1 MB", &m, &small);
        mcv_matrix_free(&m);
        mcv_matrix_free(&small);
    }
}

/* Records that come sixty times are 19 portions in 16 MB, which has room for them all: what is
 * merged on the way makes the same matrix as one portion, without a file. */
static void test_portions_are_merged(void **state) {
    static uint32_t records[RECORDS * WORDS];
    mcv_matrix made[2];
    (void)state;
    make_records(records);
    tell_apart(records);
    for (int small = 0; small < 2; ++small) {
        mcv_gather gather;
        WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1,
                            small ? (size_t)1 << 24 : (size_t)1 << 30, &error));
        for (int i = 0; i < 60; ++i) WELL(mcv_gather_add(&gather, records, RECORDS, &error));
        /* Less than the 19 portions: some have become one. */
        if (small) assert_in_range(gather.runs.count, 1, 15);
        WELL(mcv_matrix_make(&gather, WIDTH, HEIGHT, SAMPLES, ELEMENTS, 1, made + small, &error));
        assert_int_equal(gather.runs.in_file, 0);
        mcv_gather_free(&gather);
    }
    expect_equal("merged", made, made + 1);
    mcv_matrix_free(made);
    mcv_matrix_free(made + 1);
}

/* Too little for 4096 records, 44 bytes each and 64 of their sums, is refused at once; too little
 * for the matrix, 18000 entries of 28 bytes, when it is known. */
static void test_memory_is_bounded(void **state) {
    static uint32_t records[RECORDS * WORDS];
    mcv_gather gather;
    mcv_matrix matrix;
    (void)state;
    assert_int_equal(
        mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, (size_t)4096 * 108 - 1, &error),
        MCV_BAD_INPUT);
    if (!strstr(error.text, "--memory") || !strstr(error.text, "tile"))
        fail_msg("\"%s\" must name --memory and a tile", error.text);
    make_records(records);
    tell_apart(records);
    WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, (size_t)4096 * 108, &error));
    WELL(mcv_gather_add(&gather, records, RECORDS, &error));
    gather.most_bytes = 400000;
    error.text[0] = '\0';
    assert_int_equal(mcv_matrix_make(&gather, WIDTH, HEIGHT, SAMPLES, ELEMENTS, 1, &matrix, &error),
                     MCV_BAD_INPUT);
    if (!strstr(error.text, "--memory")) fail_msg("\"%s\" must name --memory", error.text);
    mcv_gather_free(&gather);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_entries_are_means),
        cmocka_unit_test(test_thinning_keeps_white),
        cmocka_unit_test(test_relighting_is_the_product),
        cmocka_unit_test_setup_teardown(test_files, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_matrix_market, enter_folder, leave_folder),
        cmocka_unit_test(test_files_take_what_memory_has_no_room_for),
        cmocka_unit_test(test_portions_are_merged),
        cmocka_unit_test(test_memory_is_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
