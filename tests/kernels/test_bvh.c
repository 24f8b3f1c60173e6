/* SPDX-License-Identifier: Apache-2.0 */
/* The acceleration structure as built: complete, tight, bounded in depth, the same for any number
 * of threads. */
#include "test.h"
#include <string.h>

#include "accel/update.h"
#include "mesh.h"

static mcv_bvh build(const mesh *m, uint32_t threads) {
    mcv_bvh bvh;
    mcv_error error = {""};
    if (mcv_bvh_build(m->positions, m->indices, m->triangle_count, threads, &bvh, &error) != MCV_OK)
        fail_msg("%s", error.text);
    return bvh;
}

typedef struct walk {
    const mesh *mesh;
    const mcv_bvh *bvh;
    uint8_t *node_seen, *leaf_seen;
    uint32_t *points_seen; /* per triangle, a bit for each of its points that lies in one of its
                              leaves' boxes */
    uint32_t levels, references;
} walk;

/* Points of a triangle: its corners, its edges, its inside. */
static void triangle_point(const mesh *m, uint32_t triangle, int number, double point[3]) {
    uint64_t seed = (uint64_t)number;
    const double s = number < 3 ? 1.0 : random_unit(&seed),
                 t = number < 12 ? 0.0 : (1.0 - s) * random_unit(&seed);
    const double weights[3] = {s, 1.0 - s - t, t};
    for (int axis = 0; axis < 3; ++axis) {
        point[axis] = 0.0;
        for (int k = 0; k < 3; ++k)
            point[axis] += weights[(k + number) % 3] *
                           m->positions[3 * (size_t)m->indices[3 * (size_t)triangle + (uint32_t)k] +
                                        (uint32_t)axis];
    }
}

static void check_leaf(walk *w, uint32_t leaf, const float lower[3], const float upper[3]) {
    assert_in_range(leaf, 0, w->bvh->leaf_count - 1);
    assert_int_equal(w->leaf_seen[leaf]++, 0);
    const mcv_leaf *l = w->bvh->leaves + leaf;
    uint32_t used = 0;
    for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
        const uint32_t triangle = l->triangle[lane];
        if (triangle == MCV_NONE) continue;
        ++used;
        assert_in_range(triangle, 0, w->mesh->triangle_count - 1);
        for (int before = 0; before < lane; ++before) assert_true(l->triangle[before] != triangle);
        for (int i = 0; i < 9; ++i) {
            const float x = l->vertex[i / 3][i % 3][lane],
                        p = w->mesh->positions[3 * (size_t)w->mesh->indices[3 * (size_t)triangle +
                                                                            (uint32_t)i / 3] +
                                               (uint32_t)i % 3];
            if (x != p)
                fail_msg("triangle %u, corner %d, axis %d: %g in the leaf, %g in the mesh",
                         triangle, i / 3, i % 3, x, p);
        }
        /* Doubles round here and in the builder: 8 operations each at most, of numbers up to the
         * extent. */
        const double rounding = 16.0 * 0x1p-53 * w->bvh->nodes->extent;
        for (int i = 0; i < 32; ++i) {
            double p[3];
            bool within = true;
            triangle_point(w->mesh, triangle, i, p);
            for (int axis = 0; axis < 3; ++axis)
                within = within && p[axis] >= lower[axis] - rounding &&
                         p[axis] <= upper[axis] + rounding;
            if (within) w->points_seen[triangle] |= 1u << i;
        }
    }
    w->references += used;
    assert_in_range(used, 1, MCV_LEAF_TRIANGLES);
}

static void check_node(walk *w, uint32_t number, uint32_t level, const float lower[3],
                       const float upper[3]) {
    assert_in_range(number, 0, w->bvh->node_count - 1);
    assert_int_equal(w->node_seen[number]++, 0);
    if (level > w->levels) w->levels = level;
    const mcv_node *node = w->bvh->nodes + number;
    for (int i = 0; i < MCV_BVH_WIDTH; ++i) {
        float child_lower[3], child_upper[3];
        for (int axis = 0; axis < 3; ++axis) {
            child_lower[axis] = node->bounds[axis][0][i];
            child_upper[axis] = node->bounds[axis][1][i];
            if (node->child[i] == MCV_NONE) {
                assert_true(child_lower[axis] == INFINITY && child_upper[axis] == -INFINITY);
            } else if (child_lower[axis] < lower[axis] || child_upper[axis] > upper[axis] ||
                       child_lower[axis] > child_upper[axis]) {
                fail_msg("node %u, child %d, axis %d: %g to %g, the parent has %g to %g", number, i,
                         axis, child_lower[axis], child_upper[axis], lower[axis], upper[axis]);
            }
        }
        if (node->child[i] == MCV_NONE) continue;
        if (node->child[i] & MCV_CHILD_LEAF)
            check_leaf(w, node->child[i] & ~MCV_CHILD_LEAF, child_lower, child_upper);
        else
            check_node(w, node->child[i], level + 1, child_lower, child_upper);
    }
}

/*
 * Every point of every triangle in the box of one of its leaves at least and all boxes above it;
 * every node and leaf reached once; no more references than there is room for. Returns the levels.
 */
static uint32_t check(const mesh *m, const mcv_bvh *bvh) {
    const float lower[3] = {-INFINITY, -INFINITY, -INFINITY},
                upper[3] = {INFINITY, INFINITY, INFINITY};
    walk w = {m,
              bvh,
              calloc(bvh->node_count, 1),
              calloc(bvh->leaf_count + 1, 1),
              calloc(m->triangle_count + 1, 4),
              0,
              0};
    check_node(&w, 0, 1, lower, upper);
    for (uint32_t i = 0; i < bvh->node_count; ++i) assert_int_equal(w.node_seen[i], 1);
    for (uint32_t i = 0; i < bvh->leaf_count; ++i) assert_int_equal(w.leaf_seen[i], 1);
    for (uint32_t i = 0; i < m->triangle_count; ++i)
        assert_int_equal(w.points_seen[i], 0xffffffffu);
    assert_true(w.references <= 1.7 * m->triangle_count);
    float extent = 0.0f;
    for (uint32_t i = 0; i < 3 * m->triangle_count; ++i) {
        for (int axis = 0; axis < 3; ++axis)
            extent = fmaxf(extent, fabsf(m->positions[3 * (size_t)m->indices[i] + axis]));
    }
    assert_true(bvh->nodes->extent == extent);
    assert_in_range(w.levels, 1, MCV_BVH_LEVELS);
    free(w.node_seen);
    free(w.leaf_seen);
    free(w.points_seen);
    return w.levels;
}

static void test_structure(void **state) {
    (void)state;
    mesh meshes[] = {mesh_sphere(20, 0.1), mesh_terrain(60, 0.3, 1), mesh_needles(5000, 2),
                     mesh_bipyramid(1000), mesh_duplicates(4000, 3)};
    for (size_t i = 0; i < sizeof meshes / sizeof meshes[0]; ++i) {
        mcv_bvh bvh = build(meshes + i, 0);
        const uint32_t levels = check(meshes + i, &bvh);
        const double bytes = ((double)bvh.node_count * sizeof(mcv_node) +
                              (double)bvh.leaf_count * sizeof(mcv_leaf)) /
                             meshes[i].triangle_count;
        print_message(
            "mesh %zu: %u triangles, %u nodes, %u leaves, %u levels, %.1f bytes per triangle\n", i,
            meshes[i].triangle_count, bvh.node_count, bvh.leaf_count, levels, bytes);
        /* The scene's memory limit of 300 bytes per triangle leaves this much for the structure. */
        assert_true(bytes < 120.0);
        mcv_bvh_free(&bvh);
        mesh_free(meshes + i);
    }
}

/* A moved mesh's structure, fitted to it, is complete and tight as a new one's is; so is it where
 * only some of the vertices move. */
static void test_refit(void **state) {
    (void)state;
    for (int number = 0; number < 4; ++number) {
        mesh m = number % 2 ? mesh_sphere(20, 0.1) : mesh_terrain(40, 0.3, 1);
        mcv_error error = {""};
        mcv_bvh bvh = build(&m, 1);
        for (uint32_t i = 0; i < 3 * m.triangle_count; ++i) {
            float *p = m.positions + 3 * (size_t)m.indices[i];
            if (number >= 2 && p[0] < 0.2f) continue;
            for (int axis = 0; axis < 3; ++axis)
                p[axis] += 1e-3f * (float)(axis + 1) + 1e-4f * (float)(m.indices[i] % 7);
        }
        assert_int_equal(mcv_bvh_refit(&bvh, m.positions, m.indices, &error), MCV_OK);
        check(&m, &bvh);
        mcv_bvh_free(&bvh);
        mesh_free(&m);
    }
}

static void middle_of(const mesh *m, uint32_t triangle, float middle[3]) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
        middle[axis] = 0;
        for (uint32_t k = 0; k < 3; ++k)
            middle[axis] += m->positions[3 * m->indices[3 * triangle + k] + axis] / 3;
    }
}

/* A mesh in which every triangle that lies near one is three, behind the others or before them.
 * Of MCV_NONE none is. */
static mesh refine_near(const mesh *m, uint32_t triangle, float radius, bool before) {
    float at[3] = {INFINITY, INFINITY, INFINITY};
    if (triangle != MCV_NONE) middle_of(m, triangle, at);
    mesh fine = mesh_new(m->vertex_count + m->triangle_count, 3 * m->triangle_count);
    uint32_t *parts = malloc(9 * (size_t)m->triangle_count * sizeof *parts), part_count = 0,
             *kept = malloc(3 * (size_t)m->triangle_count * sizeof *kept), kept_count = 0;
    assert_true(parts && kept);
    memcpy(fine.positions, m->positions, 12 * (size_t)m->vertex_count);
    fine.vertex_count = m->vertex_count;
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        const uint32_t *corner = m->indices + 3 * (size_t)t;
        float middle[3], squared = 0;
        middle_of(m, t, middle);
        for (int axis = 0; axis < 3; ++axis)
            squared += (middle[axis] - at[axis]) * (middle[axis] - at[axis]);
        if (squared > radius * radius) {
            memcpy(kept + 3 * (size_t)kept_count++, corner, 12);
            continue;
        }
        memcpy(fine.positions + 3 * (size_t)fine.vertex_count, middle, sizeof middle);
        for (int k = 0; k < 3; ++k) {
            const uint32_t of_part[3] = {corner[k], corner[(k + 1) % 3], fine.vertex_count};
            memcpy(parts + 3 * (size_t)part_count++, of_part, sizeof of_part);
        }
        ++fine.vertex_count;
    }
    const uint32_t *first = before ? parts : kept, *second = before ? kept : parts;
    const uint32_t first_count = before ? part_count : kept_count;
    fine.triangle_count = part_count + kept_count;
    memcpy(fine.indices, first, 12 * (size_t)first_count);
    memcpy(fine.indices + 3 * (size_t)first_count, second,
           12 * (size_t)(fine.triangle_count - first_count));
    free(parts);
    free(kept);
    return fine;
}

static mcv_bvh_base base_of(const mesh *m) {
    mcv_bvh bvh = build(m, 1);
    mcv_bvh_base base;
    mcv_error error = {""};
    assert_int_equal(mcv_bvh_base_make(&bvh, m->triangle_count, &base, &error), MCV_OK);
    assert_null(bvh.nodes);
    return base;
}

/*
 * A structure that is made from that of a mesh with other refined triangles is complete and tight
 * as a new one is, and costs hardly more. What is the same is found in order, and in any order.
 */
static void test_update(void **state) {
    static const uint32_t places[4] = {1000, 1010, 5000, MCV_NONE};
    (void)state;
    for (int number = 0; number < 16; ++number) {
        const mesh plain = number < 8 ? mesh_sphere(30, 0.1) : mesh_terrain(60, 0.3, 1);
        mesh first = refine_near(&plain, places[0], 0.2f, false),
             m = refine_near(&plain, places[number / 2 % 4], 0.2f, number % 2);
        mcv_bvh_base base = base_of(&first);
        mcv_bvh bvh, fresh = build(&m, 1);
        mcv_error error = {""};
        assert_int_equal(
            mcv_bvh_update(&base, m.positions, m.indices, m.triangle_count, 2, &bvh, &error),
            MCV_OK);
        assert_non_null(bvh.nodes);
        check(&m, &bvh);
        const double cost = mcv_bvh_cost(&bvh), of_fresh = mcv_bvh_cost(&fresh);
        /* Boxes that grow around the new parts, and holes: below the 1.2 that is built anew. */
        if (!(cost < 1.2 * of_fresh)) fail_msg("mesh %d: costs %g, new %g", number, cost, of_fresh);
        mcv_bvh_free(&bvh);
        mcv_bvh_free(&fresh);
        mcv_bvh_base_free(&base);
        mesh_free(&m);
        mesh_free(&first);
        mesh plain_again = plain;
        mesh_free(&plain_again);
    }
}

/* Most of the leaves are taken as they are: what is new hangs in nodes of its own. */
static void test_update_builds_only_what_is_new(void **state) {
    (void)state;
    mesh m = mesh_sphere(60, 0.1), fine = refine_near(&m, 1000, 0.1f, false);
    mcv_bvh_base base = base_of(&m);
    mcv_matches matches;
    assert_true(
        mcv_match_triangles(&base, fine.positions, fine.indices, fine.triangle_count, &matches));
    /* Each of the triangles near the place became three. */
    assert_int_equal(3 * (m.triangle_count - matches.found_count),
                     fine.triangle_count - matches.found_count);
    assert_in_range(m.triangle_count - matches.found_count, 1, m.triangle_count / 20);
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        const uint32_t number = matches.numbers[t];
        if (number != MCV_NONE)
            assert_memory_equal(fine.indices + 3 * (size_t)number, m.indices + 3 * (size_t)t, 12);
    }
    mcv_matches_free(&matches);
    mcv_bvh_base_free(&base);
    mesh_free(&m);
    mesh_free(&fine);
}

/* Equal triangles are as many afterwards as they are; of another mesh nothing is made. */
static void test_update_of_equal_and_of_other_triangles(void **state) {
    (void)state;
    mesh m = mesh_duplicates(4000, 3), other = mesh_sphere(30, 0.1);
    mcv_bvh_base base = base_of(&m);
    mcv_bvh bvh;
    mcv_error error = {""};
    const uint32_t count = m.triangle_count - 100;
    m.triangle_count = count;
    assert_int_equal(mcv_bvh_update(&base, m.positions, m.indices, count, 1, &bvh, &error), MCV_OK);
    assert_non_null(bvh.nodes);
    check(&m, &bvh);
    mcv_bvh_free(&bvh);
    assert_int_equal(mcv_bvh_update(&base, other.positions, other.indices, other.triangle_count, 1,
                                    &bvh, &error),
                     MCV_OK);
    assert_null(bvh.nodes);
    mcv_bvh_base_free(&base);
    mesh_free(&m);
    mesh_free(&other);
}

/* Both above what one thread keeps to itself; long thin triangles are split in space. */
static void test_any_number_of_threads_gives_the_same_bits(void **state) {
    (void)state;
    for (int number = 0; number < 2; ++number) {
        mesh m = number ? mesh_needles(20000, 5) : mesh_sphere(60, 0.1);
        mcv_bvh one = build(&m, 1);
        for (uint32_t threads = 2; threads <= 9; ++threads) {
            mcv_bvh other = build(&m, threads);
            assert_int_equal(one.node_count, other.node_count);
            assert_int_equal(one.leaf_count, other.leaf_count);
            assert_memory_equal(one.nodes, other.nodes, one.node_count * sizeof *one.nodes);
            assert_memory_equal(one.leaves, other.leaves, one.leaf_count * sizeof *one.leaves);
            mcv_bvh_free(&other);
        }
        mcv_bvh_free(&one);
        mesh_free(&m);
    }
}

static uint32_t used_places(const mcv_bvh *bvh) {
    uint32_t used = 0;
    for (uint32_t i = 0; i < bvh->leaf_count; ++i) {
        for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane)
            used += bvh->leaves[i].triangle[lane] != MCV_NONE;
    }
    return used;
}

/* Long triangles across the scene lie in several leaves; small ones of a smooth surface hardly ever
 * do. */
static void test_long_triangles_are_split(void **state) {
    (void)state;
    mesh meshes[] = {mesh_needles(5000, 2), mesh_sphere(60, 0.1)};
    for (int number = 0; number < 2; ++number) {
        mcv_bvh bvh = build(meshes + number, 0);
        const double share = (double)used_places(&bvh) / meshes[number].triangle_count;
        print_message("mesh %d: %.3f references per triangle\n", number, share);
        if (number == 0 ? share < 1.05 : share > 1.02)
            fail_msg("mesh %d: %.3f references per triangle", number, share);
        mcv_bvh_free(&bvh);
        mesh_free(meshes + number);
    }
}

static void test_few_triangles(void **state) {
    (void)state;
    for (uint32_t count = 0; count <= 40; ++count) {
        mesh m = mesh_needles(count, count);
        mcv_bvh bvh = build(&m, 3);
        check(&m, &bvh);
        assert_true(((uintptr_t)bvh.nodes | (uintptr_t)bvh.leaves) % 128 == 0);
        mcv_bvh_free(&bvh);
        mesh_free(&m);
    }
}

/* No split can tell equal triangles apart: halves, and log2 of the number over three levels. */
static void test_equal_triangles(void **state) {
    (void)state;
    mesh m = mesh_needles(1000000, 4);
    for (uint32_t i = 0; i < 3 * m.triangle_count; ++i) m.indices[i] = 3 + i % 3;
    mcv_bvh bvh = build(&m, 0);
    /* A node of 8 leaves of 4 takes 32; every level above it multiplies by 8: 32 * 8^5 > 1e6. */
    assert_int_equal(check(&m, &bvh), 6);
    mcv_bvh_free(&bvh);
    mesh_free(&m);
}

static void test_too_many_triangles(void **state) {
    (void)state;
    mcv_bvh bvh;
    mcv_error error = {""};
    assert_int_equal(mcv_bvh_build(NULL, NULL, (1u << 28) + 1, 1, &bvh, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "268435457"));
    assert_null(bvh.nodes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_structure),
        cmocka_unit_test(test_refit),
        cmocka_unit_test(test_update),
        cmocka_unit_test(test_update_builds_only_what_is_new),
        cmocka_unit_test(test_update_of_equal_and_of_other_triangles),
        cmocka_unit_test(test_any_number_of_threads_gives_the_same_bits),
        cmocka_unit_test(test_few_triangles),
        cmocka_unit_test(test_equal_triangles),
        cmocka_unit_test(test_too_many_triangles),
        cmocka_unit_test(test_long_triangles_are_split),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
