/* SPDX-License-Identifier: Apache-2.0 */
/* Where sums of records go: each decision between memory and file is forced, and makes the same
 * matrix. Sums themselves, from the smallest values to the largest. */
#include "matrices.h"

#include "mcvisi/tables.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { REPLICATES = 4, SAMPLES = 8, ALL = (int)1 << 30 };
/* Three channels: bytes of a record that waits, and of the sums of a replicate's entry. At least
 * PORTION records wait; from 864 PORTION bytes of memory on, more do. */
enum { CHANNELS = 3, WORDS = 2 + CHANNELS, WAITING = 44, ITEM = 64, PORTION = 4096 };
enum { MOST_OF_PORTION = 864 * PORTION };

static mcv_error error;
#define WELL(call) \
    do { \
        if ((call) != MCV_OK) fail_msg("%s", error.text); \
    } while (0)

static uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* So many records in pixels below `pixels`; each `alike` in a row are of one entry and replicate,
 * and after `entries` entries they come again. */
static uint32_t *make_records(size_t count, uint32_t pixels, uint32_t alike, uint32_t entries) {
    uint32_t *records = malloc(count * WORDS * sizeof *records), state = 1;
    assert_non_null(records);
    for (size_t i = 0; i < count; ++i) {
        uint32_t *r = records + i * WORDS;
        const uint32_t entry = (uint32_t)i / alike % entries;
        r[0] = entry * 7919u % pixels * REPLICATES + entry % REPLICATES;
        r[1] = entry;
        for (int c = 0; c < CHANNELS; ++c) {
            const float value = (float)ldexp(1 + (double)(next_random(&state) & 0xffff) / 0x10000,
                                             -(int)(next_random(&state) % 40));
            memcpy(r + 2 + c, &value, sizeof value);
        }
    }
    return records;
}

/* Where the runs were before the matrix was made, and after. */
typedef struct where {
    size_t runs, in_file, merge_at, in_file_at_last;
} where;

static where make_in(size_t memory, const uint32_t *records, size_t count, uint32_t width,
                     uint32_t height, mcv_matrix *matrix) {
    mcv_gather gather;
    WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, memory, &error));
    WELL(mcv_gather_add(&gather, records, count, &error));
    where at = {gather.runs.count, gather.runs.in_file, gather.runs.merge_at, 0};
    WELL(mcv_matrix_make(&gather, width, height, SAMPLES, (uint32_t)count, 1, matrix, &error));
    at.in_file_at_last = gather.runs.in_file;
    mcv_gather_free(&gather);
    return at;
}

/* The matrix in so much memory is the one in ample memory. */
static where expect_same(const char *what, size_t memory, const uint32_t *records, size_t count,
                         uint32_t width, uint32_t height) {
    mcv_matrix whole, small;
    const where ample = make_in(ALL, records, count, width, height, &whole),
                at = make_in(memory, records, count, width, height, &small);
    assert_int_equal(ample.in_file_at_last, 0);
    assert_int_equal(ample.runs, 0); /* all wait: one portion */
    expect_equal(what, &whole, &small);
    mcv_matrix_free(&whole);
    mcv_matrix_free(&small);
    return at;
}

/* 1 MB has room for 4096 that wait (180 kB) and three portions of sums (262 kB each): a fourth one
 * sends those before it to the file, and all go there before the matrix is made. Each portion has
 * nearly the same entries, so that the matrix has room. */
static void test_a_portion_without_room_sends_sums_to_the_file(void **state) {
    enum { COUNT = 5 * PORTION + 100 };
    (void)state;
    uint32_t *records = make_records(COUNT, 20, 1, PORTION + 4);
    const where at = expect_same("five portions in 1 MB", (size_t)1 << 20, records, COUNT, 5, 4);
    assert_int_equal(at.runs, 5);
    assert_int_equal(at.in_file, 3);
    assert_int_equal(at.in_file_at_last, 6);
    free(records);
}

/* Sixteen portions of two records an entry are 2.1 MB of sums: they are there, but merging them
 * would take as much once more. */
static void test_runs_without_room_to_merge_go_to_the_file(void **state) {
    enum { COUNT = 16 * PORTION + 1 };
    (void)state;
    assert_true(WAITING * PORTION + 15 * PORTION / 2 * ITEM + PORTION * ITEM < MOST_OF_PORTION);
    assert_true(WAITING * PORTION + 2 * 16 * PORTION / 2 * ITEM > MOST_OF_PORTION);
    uint32_t *records = make_records(COUNT, 20, 2, COUNT);
    const where at =
        expect_same("sixteen portions in 3.5 MB", MOST_OF_PORTION, records, COUNT, 5, 4);
    assert_int_equal(at.runs, 16);
    assert_int_equal(at.in_file, 16);
    free(records);
}

/* With four records an entry there is room to merge. As the sixteen runs have no entry in common,
 * it is worth while only with twice as many from then on. */
static void test_runs_that_merging_does_not_shorten_are_merged_less_often(void **state) {
    enum { COUNT = 16 * PORTION + 1 };
    (void)state;
    assert_true(WAITING * PORTION + 2 * 16 * PORTION / 4 * ITEM < MOST_OF_PORTION);
    uint32_t *records = make_records(COUNT, 20, 4, COUNT);
    const where at = expect_same("merged in 3.5 MB", MOST_OF_PORTION, records, COUNT, 5, 4);
    assert_int_equal(at.runs, 1);
    assert_int_equal(at.in_file, 0);
    assert_int_equal(at.merge_at, 32);
    free(records);
}

/* Sums of 1000 entries (64 kB) and a matrix of 60000 rows (480 kB and 84 kB) have room in 1 MB;
 * side by side with 16 bytes a row (960 kB) they do not, so that rows are added up one by one. */
static void test_rows_without_room_side_by_side_are_read_in_order(void **state) {
    enum { COUNT = 1000, WIDTH = 200, HEIGHT = 100, ROWS = WIDTH * HEIGHT * CHANNELS };
    static const size_t memory = 1000000;
    mcv_gather gather;
    mcv_wide largest = -1;
    (void)state;
    uint32_t *records = make_records(COUNT, WIDTH * HEIGHT, 1, COUNT);
    const where at = expect_same("60000 rows in 1 MB", memory, records, COUNT, WIDTH, HEIGHT);
    assert_int_equal(at.in_file_at_last, 0);
    for (int tight = 0; tight < 2; ++tight) {
        WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, tight ? memory : ALL, &error));
        WELL(mcv_gather_add(&gather, records, COUNT, &error));
        WELL(mcv_gather_sort(&gather, 0, 0, &error));
        assert_int_equal(gather.runs.in_file, 0);
        assert_int_equal(mcv_gather_largest_row(&gather, ROWS, &largest), !tight);
        mcv_gather_free(&gather);
    }
    assert_true(largest > 0);
    free(records);
}

/* What is made of the sums decides whether they stay: 1000 entries of 64 bytes and so many bytes
 * for what is beside them, to the byte. */
static void test_sums_stay_where_there_is_room_beside_them(void **state) {
    enum { COUNT = 1000, OF_ENTRY = 28 };
    static const size_t memory = 1000000, beside = memory - COUNT * (ITEM + OF_ENTRY);
    mcv_gather gather;
    mcv_gather_entry entry;
    (void)state;
    uint32_t *records = make_records(COUNT, 20, 1, COUNT);
    for (size_t more = 0; more < 2; ++more) {
        bool there = true;
        size_t count = 0;
        WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, memory, &error));
        WELL(mcv_gather_add(&gather, records, COUNT, &error));
        WELL(mcv_gather_sort(&gather, beside + more, OF_ENTRY, &error));
        assert_int_equal(gather.runs.in_file, more);
        WELL(mcv_gather_rewind(&gather, &error));
        for (;; ++count) {
            WELL(mcv_gather_next(&gather, &entry, &there, &error));
            if (!there) break;
        }
        assert_int_equal(count, COUNT);
        mcv_gather_free(&gather);
    }
    free(records);
}

/* Three runs of the file, read with so little memory that there is room for one item of each, or
 * for all: keys ascend, and sums are those of the runs that have the key. */
static void test_runs_are_read_item_by_item_if_need_be(void **state) {
    enum { COUNT = 50 };
    (void)state;
    for (size_t bytes = 0; bytes <= (size_t)1 << 20; bytes += (size_t)1 << 20) {
        mcv_runs runs;
        mcv_runs_new(&runs, 1);
        for (int run = 0; run < 3; ++run) {
            mcv_wide *items = malloc(COUNT * 2 * sizeof *items);
            assert_non_null(items);
            for (int i = 0; i < COUNT; ++i) {
                items[2 * i] = (mcv_wide)(i * (run + 1)) << 64;
                items[2 * i + 1] = 1000 + run;
            }
            WELL(mcv_runs_add(&runs, items, COUNT, &error));
        }
        WELL(mcv_runs_spill(&runs, &error));
        assert_int_equal(runs.in_file, 3);
        WELL(mcv_runs_rewind(&runs, bytes, &error));
        for (int expected = 0; expected < 3 * COUNT; ++expected) {
            int sum = 0;
            for (int run = 0; run < 3; ++run)
                if (expected % (run + 1) == 0 && expected / (run + 1) < COUNT) sum += 1000 + run;
            if (sum == 0) continue;
            mcv_wide key = -1;
            const mcv_wide *sums = NULL;
            WELL(mcv_runs_next(&runs, &key, &sums, &error));
            if (!sums || (int)(key >> 64) != expected || *sums != sum)
                fail_msg("%zu bytes: key %d with %d, must be %d with %d", bytes, (int)(key >> 64),
                         sums ? (int)*sums : -1, expected, sum);
        }
        mcv_runs_free(&runs);
    }
}

/* Without a folder for the file, one sentence says what would help; sums stay the gather's. */
static void test_a_file_that_cannot_be_made_is_told(void **state) {
    enum { COUNT = 5 * PORTION };
    mcv_gather gather;
    (void)state;
    uint32_t *records = make_records(COUNT, 20, 1, COUNT);
    const char *kept = getenv("TMPDIR");
    char folder[1024];
    snprintf(folder, sizeof folder, "%s", kept ? kept : "");
    setenv("TMPDIR", "no/such/folder", 1);
    WELL(mcv_gather_new(&gather, CHANNELS, REPLICATES, 1, (size_t)1 << 20, &error));
    assert_int_equal(mcv_gather_add(&gather, records, COUNT, &error), MCV_FAILED);
    if (kept)
        setenv("TMPDIR", folder, 1);
    else
        unsetenv("TMPDIR");
    if (!strstr(error.text, "no/such/folder") || !strstr(error.text, "--memory") ||
        !strstr(error.text, "TMPDIR"))
        fail_msg("\"%s\" must name folder, --memory and TMPDIR", error.text);
    mcv_gather_free(&gather);
    free(records);
}

/* --- sums --- */

/* The mean of two values over the samples, as the matrix has it: from their exact sum in units. */
static float mean_of(const float values[2], double scale) {
    __int128 sum = 0;
    for (int i = 0; i < 2; ++i) {
        int exponent;
        const int64_t digits =
            (int64_t)ldexp(frexp((double)values[i] * scale, &exponent), DBL_MANT_DIG);
        exponent -= DBL_MANT_DIG;
        if (exponent >= 0)
            sum += (__int128)digits << exponent;
        else
            sum += llrint(ldexp((double)digits, exponent));
    }
    return (float)((double)sum / SAMPLES / scale);
}

/* Entries of one and of two values from 2^-75 to 2^47, at a brightest value of 1, whose unit is
 * 2^-71: below 2^-47 values are rounded to units, above no bit of a value is lost. */
static void test_sums_are_exact(void **state) {
    enum { EXPONENTS = 123, EACH = 64, COUNT = EXPONENTS * EACH };
    static const double scale = 0x1p71;
    static float values[COUNT][2];
    static uint32_t records[2 * COUNT * 3];
    mcv_gather gather;
    mcv_matrix m;
    uint32_t random = 1;
    (void)state;
    for (int i = 0; i < 2 * COUNT; ++i) {
        const int entry = i % COUNT, second = i / COUNT;
        const float value = (float)ldexp(1 + next_random(&random) / 0x1p24, entry / EACH - 75);
        /* The second value of an entry is of any size below the first one's; every other has none.
         */
        values[entry][second] = !second ? value
                                : entry % 2
                                    ? 0
                                    : (float)ldexp(value, -(int)(next_random(&random) % 60));
        uint32_t *r = records + (size_t)i * 3;
        r[0] = 0;
        r[1] = (uint32_t)entry;
        memcpy(r + 2, &values[entry][second], sizeof(float));
    }
    WELL(mcv_gather_new(&gather, 1, 1, 1, ALL, &error));
    WELL(mcv_gather_add(&gather, records, (size_t)2 * COUNT, &error));
    WELL(mcv_gather_sort(&gather, 0, 0, &error));
    WELL(mcv_matrix_make(&gather, 1, 1, SAMPLES, COUNT, 1, &m, &error));
    assert_true(m.row_begins[1] > COUNT / 4);
    for (uint64_t i = 0; i < m.row_begins[1]; ++i) {
        const float *v = values[m.columns[i]];
        if (m.replicates_of[i] != mean_of(v, scale))
            fail_msg("%a and %a: the matrix has %a, must have %a", (double)v[0], (double)v[1],
                     (double)m.replicates_of[i], (double)mean_of(v, scale));
    }
    mcv_matrix_free(&m);
    mcv_gather_free(&gather);
}

/* From 2^49 of the brightest value on a sum would have no room: told, not wrong. */
static void test_a_value_beyond_the_range_is_told(void **state) {
    static const float values[] = {0x1.fffffep48f, 0x1p49f};
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_gather gather;
        uint32_t record[3] = {0};
        memcpy(record + 2, values + i, sizeof *values);
        WELL(mcv_gather_new(&gather, 1, 1, 1, ALL, &error));
        WELL(mcv_gather_add(&gather, record, 1, &error));
        assert_int_equal(mcv_gather_sort(&gather, 0, 0, &error), i ? MCV_FAILED : MCV_OK);
        mcv_gather_free(&gather);
    }
    if (!strstr(error.text, "beyond the range")) fail_msg("\"%s\" must name the range", error.text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_portion_without_room_sends_sums_to_the_file),
        cmocka_unit_test(test_runs_without_room_to_merge_go_to_the_file),
        cmocka_unit_test(test_runs_that_merging_does_not_shorten_are_merged_less_often),
        cmocka_unit_test(test_rows_without_room_side_by_side_are_read_in_order),
        cmocka_unit_test(test_sums_stay_where_there_is_room_beside_them),
        cmocka_unit_test(test_runs_are_read_item_by_item_if_need_be),
        cmocka_unit_test(test_a_file_that_cannot_be_made_is_told),
        cmocka_unit_test(test_sums_are_exact),
        cmocka_unit_test(test_a_value_beyond_the_range_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
