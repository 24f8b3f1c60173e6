/* SPDX-License-Identifier: Apache-2.0 */
/* The bound on the levels holds where the surface area heuristic would go deeper: the builder,
 * compiled with a low bound. */
#include "test.h"

#define MCV_BVH_LEVELS 5
#include "accel/bvh.c"
#include "accel/bvh_binary.c"
#include "accel/bvh_collapse.c"
#include "accel/bvh_triangles.c"
#include "mesh.h"

static uint32_t levels_below(const mcv_bvh *bvh, uint32_t number) {
    uint32_t deepest = 0;
    for (int i = 0; i < MCV_BVH_WIDTH; ++i) {
        const uint32_t child = bvh->nodes[number].child[i];
        if (child == MCV_NONE || child & MCV_CHILD_LEAF) continue;
        const uint32_t below = levels_below(bvh, child);
        if (below > deepest) deepest = below;
    }
    return deepest + 1;
}

/*
 * Sizes from 2^-60 to 2^60 around one corner: the heuristic takes off the largest, one after the
 * other, 7 per level. That makes 121 / 7 levels; 4 triangles of each size make a leaf, and 484
 * triangles fit into 3 levels, so 5 can be kept.
 */
static void test_levels_are_bounded(void **state) {
    (void)state;
    enum { SIZES = 121, COPIES = 4 };
    mesh m = mesh_new(3 * SIZES, SIZES * COPIES);
    for (uint32_t i = 0; i < SIZES; ++i) {
        const float size = ldexpf(1.0f, (int)i - 60);
        for (uint32_t k = 0; k < 9; ++k) m.positions[9 * i + k] = k % 4 == 0 ? size : 0.0f;
    }
    for (uint32_t i = 0; i < 3 * m.triangle_count; ++i) m.indices[i] = i % (3 * SIZES);
    mcv_bvh bvh;
    mcv_error error = {""};
    assert_int_equal(mcv_bvh_build(m.positions, m.indices, m.triangle_count, 2, &bvh, &error),
                     MCV_OK);
    assert_int_equal(levels_below(&bvh, 0), MCV_BVH_LEVELS);
    uint32_t triangles = 0;
    for (uint32_t i = 0; i < bvh.leaf_count; ++i) {
        for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane)
            triangles += bvh.leaves[i].triangle[lane] != MCV_NONE;
    }
    assert_int_equal(triangles, m.triangle_count);
    mcv_bvh_free(&bvh);
    mesh_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_levels_are_bounded)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
