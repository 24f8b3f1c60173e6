/* SPDX-License-Identifier: Apache-2.0 */
/* The OpenCL layer: choosing devices, building programs, saying what failed. */
#include "test.h"
#include <stdio.h>
#include <string.h>

#include "cl/cl.h"
#include "cl/program_cache.h"

static void count_device(void *user, unsigned index, const mcv_cl *device) {
    unsigned *count = user;
    assert_int_equal(index, *count);
    assert_true(device->memory > 0 && strchr(device->name, ':') != NULL);
    ++*count;
}

static void test_list_numbers_devices(void **state) {
    unsigned count = 0;
    mcv_error error = {""};
    (void)state;
    assert_int_equal(mcv_cl_list(count_device, &count, &error), MCV_OK);
    assert_true(count > 0);
}

static void test_open_by_number_and_by_name(void **state) {
    mcv_error error = {""};
    mcv_cl by_number;
    mcv_cl by_name;
    char name[300];
    (void)state;
    assert_int_equal(mcv_cl_open("0", &by_number, &error), MCV_OK);
    const char *colon = strchr(by_number.name, ':');
    snprintf(name, sizeof name, "%.*s:%s:%s", (int)(colon - by_number.name), by_number.name,
             by_number.cpu ? "CPU" : "gpu", colon + 2);
    assert_int_equal(mcv_cl_open(name, &by_name, &error), MCV_OK);
    assert_string_equal(by_number.name, by_name.name);
    mcv_cl_close(&by_number);
    mcv_cl_close(&by_name);
}

static void test_unknown_device_is_named(void **state) {
    static const char *const wanted[] = {"99", "no such platform::", "", "-1", "0x"};
    (void)state;
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; ++i) {
        mcv_error error = {""};
        mcv_cl cl;
        assert_int_equal(mcv_cl_open(wanted[i], &cl, &error), MCV_DEVICE);
        assert_non_null(strstr(error.text, wanted[i]));
        assert_non_null(strstr(error.text, "mcvisi devices"));
    }
}

static void test_build_failure_carries_the_log(void **state) {
    mcv_error error = {""};
    mcv_cl cl;
    cl_program program;
    (void)state;
    assert_int_equal(mcv_cl_open(NULL, &cl, &error), MCV_OK);
    assert_int_equal(mcv_cl_build(&cl, "test/intersect", "-Dfloat=nonsense", &program, &error),
                     MCV_DEVICE);
    assert_null(program);
    assert_non_null(strstr(error.text, "clBuildProgram of test/intersect.cl"));
    assert_non_null(strstr(error.text, "nonsense"));
    assert_int_equal(mcv_cl_build(&cl, "nothing", "", &program, &error), MCV_DEVICE);
    assert_non_null(strstr(error.text, "nothing"));
    mcv_cl_close(&cl);
}

static void test_too_large_a_buffer_names_its_purpose(void **state) {
    mcv_error error = {""};
    mcv_cl cl;
    cl_mem buffer;
    (void)state;
    assert_int_equal(mcv_cl_open(NULL, &cl, &error), MCV_OK);
    assert_int_equal(
        mcv_cl_buffer(&cl, "the test's buffer", cl.largest_allocation + 1, NULL, &buffer, &error),
        MCV_DEVICE);
    assert_null(buffer);
    assert_non_null(strstr(error.text, "the test's buffer"));
    mcv_cl_close(&cl);
}

static cl_program new_program(const mcv_cl *cl, const char *source) {
    cl_int code;
    cl_program program = clCreateProgramWithSource(cl->context, 1, &source, NULL, &code);
    assert_int_equal(code, CL_SUCCESS);
    return program;
}

/* A program is found by its context, its text's place and its options, as long as it is one of the
 * last four. */
static void test_programs_are_kept(void **state) {
    static const char source[] = "kernel void nothing() {}";
    static const char *const others[] = {"-DA=2", "-DA=3", "-DA=4", "-DA=5"};
    mcv_error error = {""};
    mcv_cl first, second;
    (void)state;
    assert_int_equal(mcv_cl_open(NULL, &first, &error), MCV_OK);
    assert_int_equal(mcv_cl_open(NULL, &second, &error), MCV_OK);
    assert_ptr_equal(first.context, second.context);
    mcv_cl_close(&second);
    assert_null(mcv_cached_program(first.context, source, "-DA=1"));
    cl_program program = new_program(&first, source);
    mcv_keep_program(first.context, source, "-DA=1", program);
    cl_program found = mcv_cached_program(first.context, source, "-DA=1");
    assert_ptr_equal(found, program);
    clReleaseProgram(found);
    clReleaseProgram(program);
    assert_null(mcv_cached_program(first.context, source, "-DA=2"));
    assert_null(mcv_cached_program(first.context, source + 1, "-DA=1"));
    assert_null(mcv_cached_program(NULL, source, "-DA=1"));
    for (int i = 0; i < 4; ++i) {
        program = new_program(&first, source);
        mcv_keep_program(first.context, source, others[i], program);
        clReleaseProgram(program);
    }
    assert_null(mcv_cached_program(first.context, source, "-DA=1"));
    mcv_cl_close(&first);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_list_numbers_devices),
        cmocka_unit_test(test_open_by_number_and_by_name),
        cmocka_unit_test(test_unknown_device_is_named),
        cmocka_unit_test(test_build_failure_carries_the_log),
        cmocka_unit_test(test_programs_are_kept),
        cmocka_unit_test(test_too_large_a_buffer_names_its_purpose),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
