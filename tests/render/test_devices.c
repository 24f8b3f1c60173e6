/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Several devices render one image, to the bits of one device, also where devices fail. PoCL shows
 * the processor as two devices. The calls that the renderer makes of a device go through functions
 * of this test, which fail them.
 */
#include "scene_builder.h"

#include <dlfcn.h>
#include <stdatomic.h>
#include <unistd.h>

#include "cl/cl.h"
#include "render/render.h"
#include "verbs/checkpoint.h"

#ifndef STEP
#define STEP 9        /* of the calls of a device, every STEP-th is failed */
#define FIRST_LIGHT 1 /* 0: also without light paths */
#endif

enum { PIXELS = 24, REPLICATES = 4, VALUES = PIXELS * PIXELS * REPLICATES, MOST_CALLS = 4000 };

/* --- calls that fail --- */

static const char *const device_names[] = {"basic", "pthread"};
enum { DEVICES = 2 };

static struct {
    atomic_int calls, launches; /* since the counts were set to 0 */
    int from, count;            /* the first call that fails, from 1; how many do; 0: none */
} plans[DEVICES];

static int device_of(cl_command_queue queue) {
    cl_device_id device = NULL;
    char name[64] = "";
    clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof device, &device, NULL);
    clGetDeviceInfo(device, CL_DEVICE_NAME, 64, name, NULL);
    name[63] = '\0';
    return strncmp(name, device_names[0], strlen(device_names[0])) == 0 ? 0 : 1;
}

static bool fails(cl_command_queue queue) {
    const int i = device_of(queue);
    const int call = atomic_fetch_add(&plans[i].calls, 1) + 1;
    return plans[i].count > 0 && call >= plans[i].from && call < plans[i].from + plans[i].count;
}

#define NEXT(name) ((__typeof__(&(name)))dlsym(RTLD_NEXT, #name))

cl_int clEnqueueNDRangeKernel(cl_command_queue command_queue, cl_kernel kernel, cl_uint work_dim,
                              const size_t *global_work_offset, const size_t *global_work_size,
                              const size_t *local_work_size, cl_uint num_events_in_wait_list,
                              const cl_event *event_wait_list, cl_event *event) {
    if (fails(command_queue)) return CL_OUT_OF_RESOURCES;
    atomic_fetch_add(&plans[device_of(command_queue)].launches, 1);
    return NEXT(clEnqueueNDRangeKernel)(command_queue, kernel, work_dim, global_work_offset,
                                        global_work_size, local_work_size, num_events_in_wait_list,
                                        event_wait_list, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue command_queue, cl_mem buffer, cl_bool blocking_read,
                           size_t offset, size_t size, void *ptr, cl_uint num_events_in_wait_list,
                           const cl_event *event_wait_list, cl_event *event) {
    if (fails(command_queue)) return CL_DEVICE_NOT_AVAILABLE;
    return NEXT(clEnqueueReadBuffer)(command_queue, buffer, blocking_read, offset, size, ptr,
                                     num_events_in_wait_list, event_wait_list, event);
}

cl_int clEnqueueFillBuffer(cl_command_queue command_queue, cl_mem buffer, const void *pattern,
                           size_t pattern_size, size_t offset, size_t size,
                           cl_uint num_events_in_wait_list, const cl_event *event_wait_list,
                           cl_event *event) {
    if (fails(command_queue)) return CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return NEXT(clEnqueueFillBuffer)(command_queue, buffer, pattern, pattern_size, offset, size,
                                     num_events_in_wait_list, event_wait_list, event);
}

static void plan(int device, int from, int count) {
    for (int i = 0; i < DEVICES; ++i) {
        plans[i].calls = plans[i].launches = 0;
        plans[i].count = i == device ? count : 0;
        plans[i].from = from;
    }
}

/* --- renders --- */

static mcv_scene *scene;
static int warnings, saves_left;
static char warned[1024];

static void take_warning(void *user, const char *sentence) {
    (void)user;
    ++warnings;
    snprintf(warned, sizeof warned, "%s", sentence);
}

/* Light paths: a mirror ball below a lamp. Without: the same program, but for those. */
static mcv_scene *make_scene(void) {
    mcv_scene *s = mcv_scene_new("devices");
    add_sphere(s, 0.3, 16, add_material(s, MCV_MATERIAL_MIRROR, NULL), mcv_transform_identity());
    add_rectangle(s, 2, 2, add_diffuse(s, 0.6), looking_up_z(0, 0, -0.5));
    add_emitter(s, MCV_EMITTER_AREA,
                add_rectangle(s, 0.3, 0.3, add_absorber(s), looking_down_z(0.4, 0.4, 1)), 3, 0);
    add_pinhole(s, PIXELS, 0.9, looking_down_z(0.05, 0, 1.5));
    return s;
}

static mcv_render_options options_for(const char *device, bool light) {
    mcv_render_options options = mcv_render_defaults();
    options.device = device;
    options.last = 64;
    options.replicates = REPLICATES;
    options.no_light_paths = !light;
    options.warned = take_warning;
    /* With an error that is never reached there are several rounds: light paths are taken off the
     * devices after each. */
    options.error = light ? 1e-9 : 0;
    return options;
}

static mcv_result render_sums(mcv_renderer *renderer, const mcv_render_options *options,
                              double *sums, mcv_render_stats *stats, mcv_error *error) {
    mcv_film film;
    warnings = 0;
    const mcv_result result = mcv_renderer_render(renderer, scene, 0, options, &film, stats, error);
    if (result == MCV_OK) memcpy(sums, film.sums, VALUES * sizeof(double));
    mcv_film_free(&film);
    return result;
}

/* By a renderer of its own. */
static void render_with(const mcv_render_options *options, double *sums, mcv_render_stats *stats) {
    mcv_error error = {""};
    mcv_renderer *renderer = mcv_renderer_new();
    assert_non_null(renderer);
    const mcv_result result = render_sums(renderer, options, sums, stats, &error);
    mcv_renderer_free(renderer);
    if (result != MCV_OK) fail_msg("%s: %s", options->device, error.text);
}

static void expect_same(const double *one, const double *sums, const char *what) {
    for (size_t i = 0; i < VALUES; ++i)
        if (memcmp(&one[i], &sums[i], sizeof(double)) != 0)
            fail_msg("%s: sum %zu is %.17g, not %.17g as on one device", what, i, sums[i], one[i]);
}

static double alone[2][VALUES]; /* without and with light paths, on the second device */
static mcv_render_stats alone_stats[2];

#define BOTH "::basic,::pthread"

static void test_two_devices_give_the_bits_of_one(void **state) {
    static double sums[VALUES];
    double light_brings = 0;
    mcv_render_stats stats;
    (void)state;
    for (int light = FIRST_LIGHT; light < 2; ++light) {
        mcv_render_options options = options_for("::pthread", light);
        render_with(&options, alone[light], &alone_stats[light]);
        plan(-1, 0, 0);
        options.device = BOTH;
        render_with(&options, sums, &stats);
        expect_same(alone[light], sums, light ? "both, with light paths" : "both");
        /* The counts are of all, each sample once. */
        assert_int_equal(stats.paths, alone_stats[light].paths);
        assert_int_equal(stats.rays, alone_stats[light].rays);
        assert_int_equal(stats.shadow_rays, alone_stats[light].shadow_rays);
        if (plans[0].launches == 0 || plans[1].launches == 0)
            fail_msg("%d and %d launches", plans[0].launches, plans[1].launches);
        assert_non_null(strstr(stats.device, "basic"));
        assert_non_null(strstr(stats.device, " + "));
    }
    for (size_t i = 0; i < VALUES; ++i) light_brings += fabs(alone[1][i] - alone[0][i]);
    assert_true(light_brings > 0);
}

/* Every step-th call of a device fails, once or from there on. */
static int fail_calls(int device, bool light, int count, int step) {
    static double sums[VALUES];
    mcv_render_options options = options_for(BOTH, light);
    mcv_render_stats stats;
    mcv_error error = {""};
    char what[160];
    int met = 0;
    mcv_renderer *renderer = mcv_renderer_new();
    assert_non_null(renderer);
    for (int from = 1; from < MOST_CALLS; from += step) {
        plan(device, from, count);
        const mcv_result result = render_sums(renderer, &options, sums, &stats, &error);
        snprintf(what, sizeof what, "%s fails from call %d on, %d times", device_names[device],
                 from, count);
        if (result != MCV_OK) fail_msg("%s: %s", what, error.text);
        const bool failed = plans[device].calls >= from;
        met += failed;
        expect_same(alone[light], sums, what);
        assert_int_equal(stats.paths, alone_stats[light].paths);
        assert_int_equal(stats.rays, alone_stats[light].rays);
        if (warnings > 1) fail_msg("%s: %d sentences: %s", what, warnings, warned);
        if (warnings == 1 && (!strstr(warned, device_names[device]) || !strstr(warned, "given up")))
            fail_msg("%s: %s", what, warned);
        if (failed && count > 100 && warnings == 0) fail_msg("%s: nothing was said", what);
        if (warnings == 1) { /* it has only one device now: begin anew */
            mcv_renderer_free(renderer);
            renderer = mcv_renderer_new();
            assert_non_null(renderer);
        }
        if (!failed) break;
    }
    mcv_renderer_free(renderer);
    return met;
}

static void test_a_device_that_fails_changes_no_bit(void **state) {
    int met = 0;
    (void)state;
    for (int device = 0; device < DEVICES; ++device)
        for (int light = FIRST_LIGHT; light < 2; ++light) {
            met += fail_calls(device, light, 1, STEP);           /* out of resources for a moment */
            met += fail_calls(device, light, 1 << 20, 2 * STEP); /* lost */
        }
    print_message("%d faults\n", met);
    assert_true(met >= 4);
}

/* All fail: the render does, and says which call did. */
static void test_without_any_device(void **state) {
    static double sums[VALUES];
    const mcv_render_options options = options_for(BOTH, FIRST_LIGHT);
    mcv_render_stats stats;
    mcv_error error = {""};
    (void)state;
    for (int from = 1; from <= 10; from += 3) {
        plan(-1, from, 0);
        plans[0].count = plans[1].count = 1 << 20;
        mcv_renderer *renderer = mcv_renderer_new();
        const mcv_result result = render_sums(renderer, &options, sums, &stats, &error);
        mcv_renderer_free(renderer);
        assert_int_equal(result, MCV_DEVICE);
        if (!strstr(error.text, "failed on")) fail_msg("%s", error.text);
    }
    plan(-1, 0, 0);
}

static void test_bad_lists_are_refused(void **state) {
    static const struct {
        const char *device, *words;
    } cases[] = {{"::basic,::nothing", "no OpenCL device matches \"::nothing\""},
                 {"::basic,0,::basic", "twice"},
                 {",", "names no OpenCL device"},
                 {"0,reference", "no OpenCL device matches \"reference\""}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_film film;
        mcv_render_stats stats;
        mcv_error error = {""};
        const mcv_render_options options = options_for(cases[i].device, FIRST_LIGHT);
        assert_int_equal(mcv_render(scene, 0, &options, &film, &stats, &error), MCV_DEVICE);
        if (!strstr(error.text, cases[i].words)) fail_msg("%s: %s", cases[i].device, error.text);
    }
}

/* --- saved while both are at work --- */

#define FILE_NAME "devices.film"

static bool save_now(void *user, bool ending) {
    (void)user;
    (void)ending;
    return saves_left > 0;
}

static void save(void *user, const mcv_unfinished *unfinished) {
    mcv_error error = {""};
    (void)user;
    --saves_left;
    if (mcv_checkpoint_write(FILE_NAME, json_null(), unfinished, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

static const struct mcv_render_saving SAVING = {save_now, save};

static void test_what_both_have_saved_goes_on(void **state) {
    static double sums[VALUES];
    (void)state;
    for (int light = FIRST_LIGHT; light < 2; ++light)
        for (int saves = 1; saves < 24; saves += STEP) {
            char what[64];
            mcv_render_options options = options_for(BOTH, light);
            mcv_render_stats stats;
            mcv_checkpoint from;
            mcv_error error = {""};
            plan(saves % 3, saves, saves % 2);
            options.saving = &SAVING;
            saves_left = saves;
            snprintf(what, sizeof what, "after %d saves", saves);
            render_with(&options, sums, &stats);
            expect_same(alone[light], sums, what);
            plan(-1, 0, 0);
            if (mcv_checkpoint_read(FILE_NAME, json_null(), &from, &error) != MCV_OK)
                fail_msg("%s", error.text);
            options.saving = NULL;
            options.resume = &from.unfinished;
            options.device = saves % 2 ? BOTH : "::pthread";
            render_with(&options, sums, &stats);
            expect_same(alone[light], sums, what);
            assert_int_equal(stats.rays, alone_stats[light].rays);
            mcv_checkpoint_free(&from);
        }
    unlink(FILE_NAME);
}

static int open_test(void **state) {
    (void)state;
    scene = make_scene();
    return 0;
}

static int close_test(void **state) {
    (void)state;
    mcv_scene_free(scene);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_devices_give_the_bits_of_one),
        cmocka_unit_test(test_a_device_that_fails_changes_no_bit),
        cmocka_unit_test(test_without_any_device),
        cmocka_unit_test(test_bad_lists_are_refused),
        cmocka_unit_test(test_what_both_have_saved_goes_on),
    };
    mcv_cl found[MCV_MOST_DEVICES];
    uint32_t count;
    mcv_error error = {""};
    setenv("POCL_DEVICES", "basic pthread", 1);
    if (mcv_cl_find_all(BOTH, found, &count, &error) != MCV_OK) {
        printf("skipped: PoCL does not show the processor as two devices: %s\n", error.text);
        return 0;
    }
    return cmocka_run_group_tests(tests, open_test, close_test);
}
