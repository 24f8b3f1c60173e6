/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi warm` has compiled is not compiled again. */
#include "test.h"

#include "program.h"

#include <ftw.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define SCENE MCV_SOURCE_DIR "/scenes/caustic.gltf"

static int compiled;

static int count_compiled(const char *path, const struct stat *status, int kind,
                          struct FTW *place) {
    (void)status;
    (void)kind;
    (void)place;
    const char *ending = strrchr(path, '.');
    compiled += ending && (strcmp(ending, ".so") == 0 || strcmp(ending, ".bc") == 0);
    return 0;
}

/* Programs and kernels in the driver's cache. */
static int cached(void) {
    compiled = 0;
    assert_int_equal(nftw("cache", count_compiled, 8, FTW_PHYS), 0);
    return compiled;
}

/* PoCL has a file for each program and each kernel of it. Light paths, their pilot and adaptive
 * sampling launch all kernels of the scene. */
static void test_renders_find_what_was_compiled(void **state) {
    (void)state;
    assert_int_equal(mkdir("cache", 0700), 0);
    setenv("POCL_CACHE_DIR", "cache", 1);
    program_well("warm " SCENE " --json");
    assert_non_null(strstr(said, "\"programs\":[{\"name\":\"camera\""));
    assert_non_null(strstr(said, "\"seconds\":"));
    const int warm = cached();
    if (warm == 0) print_message("the driver keeps no files: nothing is shown\n");
    program_well("render " SCENE " -o warm.exr --resolution 40x32 --spp 256 --adaptive");
    if (cached() != warm)
        fail_msg("%d programs and kernels were compiled, %d after a render", warm, cached());
    unsetenv("POCL_CACHE_DIR");
}

static void test_what_cannot_be_compiled_is_told(void **state) {
    (void)state;
    program_fails("warm " SCENE " --device reference", 2, "has no programs to compile");
    program_fails("warm missing.gltf", 3, "missing.gltf");
    program_fails("warm " SCENE " --sensor other", 2, "there is no sensor other");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_renders_find_what_was_compiled),
        cmocka_unit_test(test_what_cannot_be_compiled_is_told),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
