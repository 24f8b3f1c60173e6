/* SPDX-License-Identifier: Apache-2.0 */
/* A device that fails in the middle of a render: one sentence, no picture, and a session that
 * renders again. Functions of OpenCL stand here before those of the library, and fail when told. */
#include "api.h"

#include <CL/cl.h>
#include <dlfcn.h>

/* The last parameters of a command. */
#define EVENTS cl_uint num_events_in_wait_list, const cl_event *event_wait_list, cl_event *event
#define EVENT_ARGUMENTS num_events_in_wait_list, event_wait_list, event

/* X(name, parameters, arguments): functions that return a code. */
#define FAILING(X) \
    X(clEnqueueNDRangeKernel, \
      (cl_command_queue command_queue, cl_kernel kernel, cl_uint work_dim, \
       const size_t *global_work_offset, const size_t *global_work_size, \
       const size_t *local_work_size, EVENTS), \
      (command_queue, kernel, work_dim, global_work_offset, global_work_size, local_work_size, \
       EVENT_ARGUMENTS)) \
    X(clEnqueueReadBuffer, \
      (cl_command_queue command_queue, cl_mem buffer, cl_bool blocking_read, size_t offset, \
       size_t size, void *ptr, EVENTS), \
      (command_queue, buffer, blocking_read, offset, size, ptr, EVENT_ARGUMENTS)) \
    X(clEnqueueWriteBuffer, \
      (cl_command_queue command_queue, cl_mem buffer, cl_bool blocking_write, size_t offset, \
       size_t size, const void *ptr, EVENTS), \
      (command_queue, buffer, blocking_write, offset, size, ptr, EVENT_ARGUMENTS)) \
    X(clSetKernelArg, \
      (cl_kernel kernel, cl_uint arg_index, size_t arg_size, const void *arg_value), \
      (kernel, arg_index, arg_size, arg_value)) \
    X(clFinish, (cl_command_queue command_queue), (command_queue))

enum {
#define X(name, parameters, arguments) OF_##name,
    FAILING(X)
#undef X
        OF_clCreateBuffer,
    FUNCTIONS
};
static const char *const names[] = {
#define X(name, parameters, arguments) #name,
    FAILING(X)
#undef X
        "clCreateBuffer"};

static int broken = -1;    /* the function that fails, */
static unsigned countdown; /* after so many more calls of it; then all of them do */

static bool is_time(int function) {
    if (function != broken) return false;
    if (countdown == 0) return true;
    --countdown;
    return false;
}

/* The function of that name in the libraries after this program. */
static void *of_library(const char *name) {
    void *function = dlsym(RTLD_NEXT, name);
    assert_non_null(function);
    return function;
}

#define X(name, parameters, arguments) \
    cl_int name parameters { \
        cl_int(*real) parameters; \
        *(void **)&real = of_library(#name); \
        return is_time(OF_##name) ? CL_OUT_OF_RESOURCES : real arguments; \
    }
FAILING(X)
#undef X

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void *host_ptr,
                      cl_int *errcode_ret) {
    cl_mem (*real)(cl_context, cl_mem_flags, size_t, void *, cl_int *);
    *(void **)&real = of_library("clCreateBuffer");
    if (!is_time(OF_clCreateBuffer)) return real(context, flags, size, host_ptr, errcode_ret);
    if (errcode_ret) *errcode_ret = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return NULL;
}

static const char options[] = "{\"spp\": 64, \"replicates\": 2}";

static bool all_equal(const mcv_picture *picture, float value) {
    const mcv_part part = part_of(picture, 0);
    for (size_t i = 0; i < (size_t)part.width * part.height; ++i)
        if (part.planes[i] != value) return false;
    return true;
}

/* Did it fail? Then with one sentence and nothing else. */
static bool fails_well(mcv_session *session, const mcv_rig *rig, int function, unsigned after) {
    mcv_error error = {""};
    mcv_picture *picture = NULL;
    char *stats = NULL;
    broken = function;
    countdown = after;
    const mcv_result result =
        mcv_session_render(session, rig, options, NULL, NULL, &picture, &stats, &error);
    broken = -1;
    if (result == MCV_OK) {
        assert_true(all_equal(picture, 2.5F));
        mcv_picture_free(picture);
        mcv_text_free(stats);
        return false;
    }
    if ((result != MCV_DEVICE && result != MCV_FAILED) || strlen(error.text) < 10 ||
        strchr(error.text, '\n') || strstr(error.text, "->") || strstr(error.text, "clEnqueue"))
        fail_msg("%s, call %u: %d, \"%s\"", names[function], after, result, error.text);
    assert_null(picture);
    assert_null(stats);
    if (after < 2) print_message("%s: %s\n", names[function], error.text);
    return true;
}

/* Of a session that has rendered, or of one whose buffers are still to be made. */
static void break_device(bool warm) {
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = parse_rig(sky_rig);
    if (warm) mcv_picture_free(render(session, rig, options));
    for (int function = 0; function < FUNCTIONS; ++function) {
        unsigned failures = 0;
        for (unsigned after = 0; after < 40; after += 1 + after / 4) {
            if (!warm) {
                mcv_session_close(session);
                session = open_session(NULL);
            }
            if (fails_well(session, rig, function, after)) ++failures;
            /* The session goes on. */
            mcv_picture *picture = render(session, rig, options);
            assert_true(all_equal(picture, 2.5F));
            mcv_picture_free(picture);
        }
        print_message("%s: %u renders failed\n", names[function], failures);
        if (function == OF_clEnqueueNDRangeKernel || (!warm && function == OF_clCreateBuffer))
            assert_true(failures > 0);
    }
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void test_a_device_that_fails(void **state) {
    (void)state;
    break_device(true);
    break_device(false);
}

/* A set of a sweep fails, the others are measured. */
static bool count_rows(void *user, const char *row) {
    unsigned *rows = user;
    if (!row) return true;
    rows[strstr(row, "\"message\":null") == NULL]++;
    broken = rows[0] + rows[1] == 1 ? OF_clEnqueueNDRangeKernel : -1;
    countdown = 0;
    return true;
}

static void test_a_sweep_goes_on(void **state) {
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = parse_rig(sky_rig);
    unsigned rows[2] = {0, 0};
    char *report = NULL;
    (void)state;
    WELL(mcv_session_sweep(session, rig,
                           "{\"vary\": \"emitters/sky/radiance=1,2,3\", \"metric\": "
                           "\"m:=image.mean\", \"region\": \"image=0,0,8,8\", \"spp\": 4}",
                           count_rows, rows, &report, &error));
    assert_int_equal(rows[0], 2);
    assert_int_equal(rows[1], 1);
    mcv_text_free(report);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_device_that_fails),
        cmocka_unit_test(test_a_sweep_goes_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
