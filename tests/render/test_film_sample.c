/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include "film/film.h"
#include "render/render.h"
#include "reference/reference.h"
#include "scene/scene.h"

static void test_from_centre(void **state) {
    (void)state;
    assert_true(mcv_from_centre((mcv_centre){5, 0}, 2, 0.5f) == 0.0f);
    assert_true(mcv_from_centre((mcv_centre){4, 0}, 0, 0.25f) == 1.75f);
    assert_true(mcv_from_centre((mcv_centre){4, 0.125f}, 0, 0.25f) == 1.875f);
    assert_true(mcv_from_centre((mcv_centre){-3, -0.25f}, 2, 0.5f) == -4.25f);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_from_centre)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
