/* SPDX-License-Identifier: Apache-2.0 */
/* What is no regular file is refused by each reader: a device never ends, a pipe without a writer
 * blocks. */
#include "test.h"

#include "analysis/blur.h"
#include "core/output_file.h"
#include "film/film_file.h"
#include "verbs/rays.h"

#include <sys/stat.h>
#include <unistd.h>

static void expect_refused(const char *reader, const char *path, mcv_result result,
                           const mcv_error *error) {
    if (result != MCV_BAD_INPUT || !strstr(error->text, path) ||
        !strstr(error->text, "regular file"))
        fail_msg("%s of %s: result %d, \"%s\"", reader, path, (int)result, error->text);
}

static void test_what_is_no_file(void **state) {
    static const char *const paths[] = {"/dev/zero", "waits.fifo", "."};
    (void)state;
    unlink("waits.fifo");
    assert_int_equal(mkfifo("waits.fifo", 0600), 0);
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; ++i) {
        mcv_error error = {""};
        mcv_trace_ray *rays;
        mcv_mtf_row *rows;
        mcv_film_file film;
        uint8_t *bytes;
        size_t count;
        const char *path = paths[i];
        expect_refused("rays", path, mcv_rays_read(path, &rays, &count, &error), &error);
        expect_refused("an MTF", path, mcv_mtf_read(path, &rows, &count, &error), &error);
        expect_refused("a film", path, mcv_film_file_read(path, &film, &error), &error);
        expect_refused("a file", path, mcv_file_load(path, &bytes, &count, &error), &error);
    }
    unlink("waits.fifo");
}

/* Zeros that a file has got by a loss of power are no blank rows. */
static void test_zeros_in_a_table(void **state) {
    static const char text[] = "0,0,1,0,0,-1\n\0\0\0\0\n0,0,2,0,0,-1\n";
    (void)state;
    mcv_trace_ray *rays;
    mcv_error error;
    size_t count;
    FILE *file = fopen("zeros.csv", "wb");
    assert_non_null(file);
    fwrite(text, 1, sizeof text - 1, file);
    fclose(file);
    assert_int_equal(mcv_rays_read("zeros.csv", &rays, &count, &error), MCV_BAD_INPUT);
    if (!strstr(error.text, "zeros.csv:2: has a NUL byte")) fail_msg("%s", error.text);
    unlink("zeros.csv");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_no_file),
        cmocka_unit_test(test_zeros_in_a_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
