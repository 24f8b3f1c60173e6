/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: timeout 600 */
/*
 * Traversal on the device: the same hit as a loop over all triangles, to the last bit; closed
 * meshes without a crack and without a double hit; rays from offset origins. test_traversal_slow.c
 * runs the same tests with many more rays.
 */
#include "test.h"
#include <string.h>

#include "mcvisi/offset.h"
#include "mesh.h"
#include "rays.h"
#include "truths.h"

#ifndef RAY_FACTOR
#define RAY_FACTOR 1
#endif

static tracer device;

/* 0 of so many rays, for the table. */
static void note_rays(const char *what, uint64_t rays, uint64_t wrong) {
    char name[96];
    snprintf(name, sizeof name, "traversal: %s, of %.2g rays", what, (double)rays);
    note_truth(name, "device", (double)wrong, 0);
}

static void must(mcv_result result, const mcv_error *error) {
    if (result != MCV_OK) fail_msg("%s", error->text);
}

static void load(const mesh *m, mcv_bvh *bvh) {
    mcv_error error = {""};
    must(mcv_bvh_build(m->positions, m->indices, m->triangle_count, 0, bvh, &error), &error);
    must(tracer_load(&device, bvh, &error), &error);
}

static void run(cl_kernel kernel, const batch_ray *rays, uint32_t count, void *out) {
    mcv_error error = {""};
    must(tracer_run(&device, kernel, rays, count, out, &error), &error);
}

static const float *corner(const mesh *m, uint32_t triangle, uint32_t which) {
    return m->positions + 3 * (size_t)m->indices[3 * (size_t)triangle + which];
}

/* A point on an edge of the mesh (kind 0), a vertex (1) or inside a triangle (2), rounded to float.
 */
static void surface_point(const mesh *m, uint64_t *seed, int kind, double p[3]) {
    const uint32_t triangle = (uint32_t)(random_bits(seed) % m->triangle_count),
                   first = (uint32_t)(random_bits(seed) % 3);
    const float *a = corner(m, triangle, first), *b = corner(m, triangle, (first + 1) % 3),
                *c = corner(m, triangle, (first + 2) % 3);
    const double s = kind == 1 ? 0.0 : random_unit(seed),
                 r = kind == 2 ? random_unit(seed) * (1.0 - s) : 0.0;
    for (int k = 0; k < 3; ++k) p[k] = (float)((1.0 - s - r) * a[k] + s * b[k] + r * c[k]);
}

static batch_ray ray_between(const double from[3], const double to[3]) {
    batch_ray ray = {.t_max = INFINITY};
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = (float)from[k];
        ray.direction[k] = (float)(to[k] - ray.origin[k]);
    }
    return ray;
}

/* Rays of all sorts near a mesh of about unit size: at vertices, edges and faces, along axes, from
 * the surface, anywhere. */
static void make_mixed_rays(const mesh *m, uint64_t seed, batch_ray *rays, uint32_t count) {
    double first_from[3] = {0}, first_to[3] = {0};
    for (uint32_t i = 0; i < count; ++i) {
        double from[3], to[3], d[3];
        surface_point(m, &seed, (int)(i % 3), to);
        random_direction(&seed, d);
        const double distance = i % 5 ? 3.0 : 300.0;
        for (int k = 0; k < 3; ++k) from[k] = i % 7 == 0 ? 1.2 * d[k] : to[k] + distance * d[k];
        if (i % 11 == 0) surface_point(m, &seed, 2, from);
        /* Half of them in eights that go much the same way, from one point, parallel or neither. */
        if (i / 8 % 2 && i % 8) {
            for (int k = 0; k < 3; ++k) {
                from[k] = first_from[k] + (i / 16 % 3 ? 0.02 * (random_unit(&seed) - 0.5) : 0.0);
                to[k] = i / 16 % 3 == 1 ? first_to[k] + from[k] - first_from[k]
                                        : 0.02 * to[k] + 0.98 * first_to[k];
            }
        } else {
            memcpy(first_from, from, sizeof from);
            memcpy(first_to, to, sizeof to);
        }
        rays[i] = ray_between(from, to);
        if (i % 13 == 0) { /* along an axis, through a vertex or a point of an edge exactly */
            const int axis = (int)(random_bits(&seed) % 3);
            for (int k = 0; k < 3; ++k)
                rays[i].direction[k] = k == axis ? (i % 2 ? 1.0f : -1.0f) : 0.0f;
            for (int k = 0; k < 3; ++k)
                rays[i].origin[k] = (float)to[k] - 4.0f * rays[i].direction[k];
        }
        if (i % 17 == 0)
            rays[i].t_max = (float)(2.0 * random_unit(&seed)); /* the target is at t = 1 */
        if (i % 19 == 0) {
            for (int k = 0; k < 3; ++k) rays[i].direction[k] *= 1e-3f;
        }
    }
}

/* Rays end before their end: what they meet there, a shadow ray's light, is not in their way. Ends
 * the rays at their closest hits; returns how many find something then. */
static uint64_t count_hits_at_ends(uint32_t mesh_number, batch_ray *rays, uint32_t count,
                                   const mcv_hit *closest, int *found) {
    uint64_t wrong = 0;
    for (uint32_t i = 0; i < count; ++i)
        if (closest[i].primitive != MCV_NONE) rays[i].t_max = closest[i].t;
    for (int way = 0; way < 3; ++way) {
        run(way == 0   ? device.any
            : way == 1 ? device.any_alone
                       : device.any_together,
            rays, count, found);
        for (uint32_t i = 0; i < count; ++i)
            if (found[i] && wrong++ < 5)
                print_error("mesh %u, ray %u: %s it meets what lies at its end, %a\n", mesh_number,
                            i,
                            way == 0   ? "alone"
                            : way == 1 ? "in turns"
                                       : "in a bundle",
                            rays[i].t_max);
    }
    return wrong;
}

static void test_same_hit_as_all_triangles(void **state) {
    (void)state;
    enum { COUNT = 220000 };
    /* The last ones are so small that the hierarchy may be its root (mcv_is_flat). */
    mesh meshes[] = {mesh_sphere(5, 0.1), mesh_terrain(12, 0.3, 1), mesh_needles(250, 2),
                     mesh_bipyramid(120), mesh_duplicates(256, 3),  mesh_bipyramid(3),
                     mesh_needles(12, 4), mesh_duplicates(16, 5)};
    batch_ray *rays = calloc(COUNT, sizeof *rays);
    mcv_hit *got = calloc(COUNT, sizeof *got), *wanted = calloc(COUNT, sizeof *wanted),
            *got_many = calloc(COUNT, sizeof *got_many);
    int *found = calloc(COUNT, sizeof *found), *found_many = calloc(COUNT, sizeof *found_many);
    uint64_t hits = 0, wrong = 0;
    for (uint32_t number = 0; number < sizeof meshes / sizeof meshes[0]; ++number) {
        mesh *m = meshes + number;
        mcv_bvh bvh;
        load(m, &bvh);
        for (uint32_t round = 0; round < RAY_FACTOR; ++round) {
            make_mixed_rays(m, 100 + number + 1000 * round, rays, COUNT);
            run(device.closest, rays, COUNT, got);
            run(device.any, rays, COUNT, found);
            run(device.all, rays, COUNT, wanted);
            for (int together = 0; together < 2; ++together) {
                run(together ? device.closest_together : device.closest_alone, rays, COUNT,
                    got_many);
                run(together ? device.any_together : device.any_alone, rays, COUNT, found_many);
                for (uint32_t i = 0; i < COUNT; ++i) {
                    const bool same = memcmp(got + i, got_many + i, sizeof *got) == 0 &&
                                      found[i] == found_many[i];
                    if (!same && wrong++ < 5)
                        print_error("mesh %u, ray %u: another answer in %s\n", number, i,
                                    together ? "a bundle" : "turns");
                }
            }
            for (uint32_t i = 0; i < COUNT; ++i) {
                hits += wanted[i].primitive != MCV_NONE;
                /* Of the four equal triangles in a plane of duplicates only the first may be seen.
                 */
                if ((number == 4 || number == 7) && wanted[i].primitive != MCV_NONE &&
                    wanted[i].primitive % 8 - 1 < 3)
                    ++wrong;
                if (memcmp(got + i, wanted + i, sizeof *got) == 0 &&
                    found[i] == (wanted[i].primitive != MCV_NONE))
                    continue;
                if (wrong++ < 5) {
                    print_error("mesh %u, ray %u from (%a, %a, %a) along (%a, %a, %a): hierarchy t "
                                "%a, u %a, v %a, triangle %u (any: %d), all "
                                "triangles t %a, u %a, v %a, triangle %u\n",
                                number, i, rays[i].origin[0], rays[i].origin[1], rays[i].origin[2],
                                rays[i].direction[0], rays[i].direction[1], rays[i].direction[2],
                                got[i].t, got[i].u, got[i].v, got[i].primitive, found[i],
                                wanted[i].t, wanted[i].u, wanted[i].v, wanted[i].primitive);
                }
            }
            wrong += count_hits_at_ends(number, rays, COUNT, got, found);
        }
        mcv_bvh_free(&bvh);
        mesh_free(m);
    }
    const uint64_t rays_count = sizeof meshes / sizeof meshes[0] * (uint64_t)COUNT * RAY_FACTOR;
    print_message("%lu rays, %lu hits, %lu differ\n", rays_count, hits, wrong);
    note_rays("hits other than all triangles', to the bit", rays_count, wrong);
    assert_int_equal(wrong, 0);
    /* Four of five rays of a mesh aim at it; the other meshes hide nothing. Fewer hits would mean
     * an empty test. */
    assert_true(hits > 3ul * COUNT * RAY_FACTOR);
    free(rays);
    free(got);
    free(got_many);
    free(found_many);
    free(wanted);
    free(found);
}

/*
 * A closed mesh is entered as often as it is left: a ray that begins outside crosses an even number
 * of triangles, one that begins inside an odd number. Each crack or double hit changes the parity
 * by one. Rays aim at vertices and edges. The triangles have a leaf each, so that every crossing
 * counts.
 */
static void test_closed_meshes_have_even_crossings(void **state) {
    (void)state;
    enum { COUNT = 400000 };
    mesh meshes[] = {mesh_sphere(3, 0.0), mesh_sphere(4, 0.2), mesh_bipyramid(50),
                     mesh_sphere(1, 0.0), mesh_bipyramid(4)};
    batch_ray *rays = calloc(COUNT, sizeof *rays);
    int *crossings = calloc(COUNT, sizeof *crossings);
    uint64_t wrong = 0, crossed = 0, all = 0;
    for (uint32_t number = 0; number < sizeof meshes / sizeof meshes[0]; ++number) {
        mesh *m = meshes + number;
        uint64_t seed = 200 + number;
        mcv_bvh single = {calloc(1, sizeof(mcv_node)), calloc(m->triangle_count, sizeof(mcv_leaf)),
                          1, m->triangle_count};
        for (uint32_t i = 0; i < m->triangle_count; ++i) {
            for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane)
                single.leaves[i].triangle[lane] = lane ? MCV_NONE : i;
            for (uint32_t k = 0; k < 9; ++k)
                single.leaves[i].vertex[k / 3][k % 3][0] = corner(m, i, k / 3)[k % 3];
        }
        mcv_error error = {""};
        must(tracer_load(&device, &single, &error), &error);
        /* Most rays go where a ray costs least: through meshes of 8 and 12 triangles. */
        const uint32_t rounds = number < 3 ? RAY_FACTOR : 12 * RAY_FACTOR;
        all += (uint64_t)rounds * COUNT;
        for (uint32_t round = 0; round < rounds; ++round) {
            for (uint32_t i = 0; i < COUNT; ++i) {
                double from[3], to[3], d[3];
                surface_point(m, &seed, (int)(i % 2), to);
                random_direction(&seed, d);
                /* All meshes hold a ball of radius 0.2 about the origin and lie in one of
                 * radius 1.3. */
                for (int k = 0; k < 3; ++k)
                    from[k] = (i % 4 == 3 ? 0.2 * random_unit(&seed) : 5.0) * d[k];
                rays[i] = ray_between(from, to);
                if (i % 8 == 1) { /* along an axis and through a vertex exactly */
                    for (int k = 0; k < 3; ++k)
                        rays[i].direction[k] = k == (int)(i / 8 % 3) ? 1.0f : 0.0f;
                    for (int k = 0; k < 3; ++k)
                        rays[i].origin[k] = (float)to[k] - 5.0f * rays[i].direction[k];
                }
            }
            run(device.count, rays, COUNT, crossings);
            for (uint32_t i = 0; i < COUNT; ++i) {
                crossed += crossings[i] > 0;
                if (crossings[i] % 2 != (i % 4 == 3) && wrong++ < 5) {
                    print_error("mesh %u, ray %u from (%a, %a, %a) along (%a, %a, %a), which "
                                "begins %s, crosses %d triangles\n",
                                number, i, rays[i].origin[0], rays[i].origin[1], rays[i].origin[2],
                                rays[i].direction[0], rays[i].direction[1], rays[i].direction[2],
                                i % 4 == 3 ? "inside" : "outside", crossings[i]);
                }
            }
        }
        mcv_bvh_free(&single);
        mesh_free(m);
    }
    print_message("%lu rays, %lu crossed a mesh, %lu of the wrong parity\n", all, crossed, wrong);
    note_rays("misses and double hits at edges and vertices", all, wrong);
    assert_int_equal(wrong, 0);
    assert_true(crossed > all / 3 * 2);
    free(rays);
    free(crossings);
}

/* From inside a larger closed mesh nothing gets out, through the hierarchy. */
static void test_nothing_leaves_a_closed_mesh(void **state) {
    (void)state;
    enum { COUNT = 1000000 };
    mesh m = mesh_sphere(60, 0.1);
    batch_ray *rays = calloc(COUNT, sizeof *rays);
    mcv_hit *hits = calloc(COUNT, sizeof *hits);
    int *found = calloc(COUNT, sizeof *found);
    mcv_bvh bvh;
    load(&m, &bvh);
    uint64_t seed = 300;
    uint64_t wrong = 0;
    for (uint32_t round = 0; round < RAY_FACTOR; ++round) {
        for (uint32_t i = 0; i < COUNT; ++i) {
            double from[3], to[3];
            surface_point(&m, &seed, (int)(i % 2), to);
            random_direction(&seed, from);
            for (int k = 0; k < 3; ++k) from[k] *= 0.5 * random_unit(&seed);
            rays[i] = ray_between(from, to);
        }
        run(device.closest, rays, COUNT, hits);
        run(device.any, rays, COUNT, found);
        for (uint32_t i = 0; i < COUNT; ++i) wrong += hits[i].primitive == MCV_NONE || !found[i];
    }
    print_message("%d rays, %lu escaped\n", COUNT * RAY_FACTOR, wrong);
    note_rays("out of a closed mesh at its edges", (uint64_t)COUNT * RAY_FACTOR, wrong);
    assert_int_equal(wrong, 0);
    mcv_bvh_free(&bvh);
    mesh_free(&m);
    free(rays);
    free(hits);
    free(found);
}

static mcv_vec3 vec_of(const float *p) { return mcv_vec(p[0], p[1], p[2]); }

/* The depth of a hit along the ray's main axis [m], computed in double, and the bound that
 * kernels/traverse/bvh8.h derives for it. */
static double exact_depth(const mesh *m, uint32_t triangle, const batch_ray *ray, double *bound) {
    int main_axis = 0;
    for (int k = 1; k < 3; ++k) {
        if (fabsf(ray->direction[k]) >= fabsf(ray->direction[main_axis])) main_axis = k;
    }
    const int axes[3] = {(main_axis + 1) % 3, (main_axis + 2) % 3, main_axis};
    double p[3][3], shear[2], largest[3] = {0};
    for (int k = 0; k < 2; ++k)
        shear[k] = (double)ray->direction[axes[k]] / ray->direction[main_axis];
    for (uint32_t i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            p[i][k] = (double)corner(m, triangle, i)[axes[k]] - ray->origin[axes[k]];
        for (int k = 0; k < 2; ++k) p[i][k] -= shear[k] * p[i][2];
        for (int k = 0; k < 3; ++k) largest[k] = fmax(largest[k], fabs(p[i][k]));
    }
    const double a = p[2][0] * p[1][1] - p[2][1] * p[1][0],
                 b = p[0][0] * p[2][1] - p[0][1] * p[2][0],
                 c = p[1][0] * p[0][1] - p[1][1] * p[0][0];
    const double u = 0x1p-24, gamma = 3.0 * u / (1.0 - 3.0 * u), x = largest[0], y = largest[1],
                 z = largest[2];
    const double error_x = gamma * (x + fabs(shear[0]) * z),
                 error_y = gamma * (y + fabs(shear[1]) * z);
    const double error_det = 3.0 * (2.0 * (x * error_y + y * error_x) + 4.0 * u * x * y),
                 sure_det = fabs(a + b + c) - error_det;
    const double range =
        fmax(p[0][2], fmax(p[1][2], p[2][2])) - fmin(p[0][2], fmin(p[1][2], p[2][2]));
    double e[2][3];
    for (int i = 0; i < 2; ++i) {
        for (int k = 0; k < 3; ++k) e[i][k] = p[i + 1][k] - p[0][k];
    }
    const double slope_x = fabs(e[0][1] * e[1][2] - e[0][2] * e[1][1]) + 10.0 * range * error_y;
    const double slope_y = fabs(e[0][2] * e[1][0] - e[0][0] * e[1][2]) + 10.0 * range * error_x;
    *bound = sure_det > 0.0 ? (slope_x * error_x + slope_y * error_y) / sure_det + 12.0 * u * z
                            : INFINITY;
    return (a * p[0][2] + b * p[1][2] + c * p[2][2]) / (a + b + c) *
           (ray->direction[main_axis] < 0.0f ? -1.0 : 1.0);
}

/*
 * Every reported t lies within its derived bound of a computation in double, and every hit lies
 * ahead of the origin, also of origins that are points of a triangle rounded to float: half of
 * these begin behind it by a rounding error.
 */
static void test_hits_lie_ahead_within_their_error(void **state) {
    (void)state;
    enum { COUNT = 100000 };
    mesh meshes[] = {mesh_sphere(5, 0.1), mesh_terrain(12, 0.3, 1), mesh_needles(250, 2),
                     mesh_bipyramid(120)};
    batch_ray *rays = malloc(COUNT * sizeof *rays);
    mcv_hit *hits = malloc(COUNT * sizeof *hits);
    uint32_t behind = 0, inexact = 0, checked = 0;
    double worst = 0.0;
    for (uint32_t number = 0; number < sizeof meshes / sizeof meshes[0]; ++number) {
        mesh *m = meshes + number;
        mcv_bvh bvh;
        load(m, &bvh);
        for (uint32_t round = 0; round < RAY_FACTOR; ++round) {
            make_mixed_rays(m, 500 + number + 1000 * round, rays, COUNT);
            uint64_t seed = 600 + number + 1000 * round;
            for (uint32_t i = 0; i < COUNT; i += 2) {
                double from[3], d[3];
                surface_point(m, &seed, 2, from);
                random_direction(&seed, d);
                for (int k = 0; k < 3; ++k) d[k] += from[k];
                rays[i] = ray_between(from, d);
            }
            run(device.closest, rays, COUNT, hits);
            for (uint32_t i = 0; i < COUNT; ++i) {
                if (hits[i].primitive == MCV_NONE) continue;
                double bound;
                const double depth = exact_depth(m, hits[i].primitive, rays + i, &bound);
                float main_component = 0.0f;
                for (int k = 0; k < 3; ++k)
                    main_component = fmaxf(main_component, fabsf(rays[i].direction[k]));
                const double off = fabs((double)hits[i].t * main_component - depth);
                checked += isfinite(bound);
                behind += depth <= 0.0;
                inexact += off > bound;
                worst = fmax(worst, off / bound);
            }
        }
        mcv_bvh_free(&bvh);
        mesh_free(m);
    }
    print_message(
        "%u hits, %u behind the origin, %u outside their bound, worst error %.2f of the bound\n",
        checked, behind, inexact, worst);
    assert_int_equal(behind, 0);
    assert_int_equal(inexact, 0);
    assert_true(checked > COUNT * RAY_FACTOR);
    free(rays);
    free(hits);
}

/* A tetrahedron of about the given size at a distance from the origin; its faces run
 * counter-clockwise from outside. */
static mesh random_tetrahedron(uint64_t *seed, double size, double distance, double centroid[3]) {
    mesh m = mesh_new(4, 4);
    for (;;) {
        double centre[3];
        random_direction(seed, centre);
        for (int i = 0; i < 4; ++i) {
            double d[3];
            random_direction(seed, d);
            for (int k = 0; k < 3; ++k)
                m.positions[3 * i + k] = (float)(distance * centre[k] + size * d[k]);
        }
        double edge[3][3];
        for (int k = 0; k < 3; ++k) {
            centroid[k] = 0.25 * ((double)m.positions[k] + m.positions[3 + k] + m.positions[6 + k] +
                                  m.positions[9 + k]);
            for (int i = 0; i < 3; ++i)
                edge[i][k] = (double)m.positions[3 * (i + 1) + k] - m.positions[k];
        }
        const double volume = edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
                              edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
                              edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
        /* Not too flat: the offset must stay small against the thickness. */
        if (fabs(volume) < size * size * size) continue;
        const uint32_t faces[2][12] = {{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3},
                                       {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0}};
        memcpy(m.indices, faces[volume < 0], sizeof faces[0]);
        return m;
    }
}

/*
 * From a hit on a convex body, a ray on the outer side must meet nothing, whatever its angle; one
 * towards the body's middle must meet another face than the one it starts from. Hits lie inside
 * faces, on edges and on corners.
 */
static void test_offset_origins_leave_their_surface(void **state) {
    (void)state;
    enum { BODIES = 100 * RAY_FACTOR, COUNT = 4000 };
    batch_ray *rays = calloc(COUNT, sizeof *rays);
    uint32_t *from = calloc(COUNT, sizeof *from);
    mcv_hit *hits = calloc(COUNT, sizeof *hits);
    int *found = calloc(COUNT, sizeof *found);
    uint64_t seed = 400;
    uint32_t caught = 0, lost = 0;
    double largest = 0.0;
    for (uint32_t number = 0; number < BODIES; ++number) {
        const double size = pow(10.0, 6.0 * random_unit(&seed) - 4.0),
                     distance = size * pow(10.0, 5.0 * random_unit(&seed) - 1.0);
        double centroid[3];
        mesh m = random_tetrahedron(&seed, size, distance, centroid);
        mcv_bvh bvh;
        load(&m, &bvh);
        for (uint32_t i = 0; i < COUNT; ++i) {
            const uint32_t triangle = from[i] = i / 2 % 4;
            const mcv_vec3 a = vec_of(corner(&m, triangle, 0)), b = vec_of(corner(&m, triangle, 1)),
                           c = vec_of(corner(&m, triangle, 2));
            const float u = i % 32 < 4 ? 0.0f : (float)random_unit(&seed),
                        v = i % 64 < 4 ? 0.0f : (1.0f - u) * (float)random_unit(&seed);
            mcv_vec3 error;
            const mcv_vec3 point = mcv_hit_point(a, b, c, u, v, &error);
            const mcv_vec3 normal = mcv_normalize(mcv_cross(mcv_sub(b, a), mcv_sub(c, a)));
            double d[3];
            random_direction(&seed, d);
            const bool outside = i % 2;
            if (outside) {
                const double side = d[0] * normal.x + d[1] * normal.y + d[2] * normal.z;
                for (int k = 0; k < 3; ++k) d[k] = side < 0.0 ? -d[k] : d[k];
            } else {
                d[0] = centroid[0] - point.x;
                d[1] = centroid[1] - point.y;
                d[2] = centroid[2] - point.z;
            }
            const mcv_vec3 direction = mcv_vec((float)d[0], (float)d[1], (float)d[2]);
            const mcv_vec3 origin = mcv_offset_origin(point, error, normal, direction);
            const mcv_vec3 moved = mcv_sub(origin, point);
            largest = fmax(largest, sqrt((double)mcv_dot(moved, moved)) / (distance + size));
            rays[i] = (batch_ray){{origin.x, origin.y, origin.z},
                                  INFINITY,
                                  {direction.x, direction.y, direction.z},
                                  0};
        }
        run(device.closest, rays, COUNT, hits);
        run(device.any, rays, COUNT, found);
        for (uint32_t i = 0; i < COUNT; ++i) {
            assert_int_equal(found[i], hits[i].primitive != MCV_NONE);
            const bool wrong = i % 2 ? found[i] : !found[i] || hits[i].primitive == from[i];
            if (!wrong) continue;
            if (caught + lost < 5) {
                print_error("body %u (size %g m at %g m), face %u, %s ray %u from (%a, %a, %a) "
                            "along (%a, %a, %a): triangle %u at t = %g\n",
                            number, size, distance, from[i], i % 2 ? "outer" : "inner", i,
                            rays[i].origin[0], rays[i].origin[1], rays[i].origin[2],
                            rays[i].direction[0], rays[i].direction[1], rays[i].direction[2],
                            hits[i].primitive, hits[i].t);
            }
            caught += i % 2;
            lost += !(i % 2);
        }
        mcv_bvh_free(&bvh);
        mesh_free(&m);
    }
    print_message("%u outer rays, %u hit; %u inner rays, %u wrong; largest offset %.3g of the "
                  "distance from the origin\n",
                  BODIES * COUNT / 2, caught, BODIES * COUNT / 2, lost, largest);
    assert_int_equal(caught, 0);
    assert_int_equal(lost, 0);
    /* At most γ(7) per coordinate, weighed with |n| (at most √3), and one step to the next float.
     */
    assert_true(largest < sqrt(3.0) * sqrt(3.0) * MCV_GAMMA(7) + sqrt(3.0) * 0x1p-23);
    free(rays);
    free(from);
    free(hits);
    free(found);
}

/* No triangles, no direction, NaN and infinity: nothing is hit and everything ends. */
static void test_odd_rays_miss(void **state) {
    (void)state;
    const float inf = INFINITY;
    const batch_ray odd[] = {
        {{0, 0, 0}, inf, {0, 0, 0}, 0},    {{NAN, 0, 0}, inf, {0, 0, 1}, 0},
        {{0, 0, 0}, inf, {NAN, 0, 1}, 0},  {{0, 0, 0}, NAN, {0, 0, 1}, 0},
        {{inf, 0, 0}, inf, {-1, 0, 0}, 0}, {{0, 0, 0}, inf, {inf, 0, 0}, 0},
        {{0, 0, 0}, -1, {0, 0, 1}, 0},     {{0, 0, 0}, 0, {0, 0, 1}, 0},
        {{9, 9, 9}, inf, {0, 0, 1}, 0},    {{0, 0, 9}, inf, {0, 0, 1e-9f}, 0},
        {{0, 0, 0}, 0.5f, {0, 0, 1}, 0},
    };
    enum { COUNT = sizeof odd / sizeof odd[0] };
    for (int number = 0; number < 3; ++number) {
        mesh m = number == 0 ? mesh_new(1, 0) : number == 1 ? mesh_new(3, 5) : mesh_sphere(8, 0.0);
        if (number == 1) { /* no area: points and lines */
            memset(m.positions, 0, 36);
            m.positions[8] = 1.0f;
            for (int i = 0; i < 15; ++i) m.indices[i] = i < 7 ? 0 : (uint32_t)i % 3;
        }
        mcv_bvh bvh;
        mcv_hit hits[COUNT] = {{0}};
        int found[COUNT] = {0};
        load(&m, &bvh);
        run(device.closest, odd, COUNT, hits);
        run(device.any, odd, COUNT, found);
        for (int i = 0; i < 3 * COUNT; ++i) {
            /* Twice more, in turns and in bundles. */
            if (i == COUNT) {
                run(device.closest_alone, odd, COUNT, hits);
                run(device.any_alone, odd, COUNT, found);
            }
            if (i == 2 * COUNT) {
                run(device.closest_together, odd, COUNT, hits);
                run(device.any_together, odd, COUNT, found);
            }
            const int ray = i % COUNT;
            if (hits[ray].primitive != MCV_NONE || found[ray])
                fail_msg("mesh %d: odd ray %d hits triangle %u at t = %g", number, ray,
                         hits[ray].primitive, hits[ray].t);
        }
        mcv_bvh_free(&bvh);
        mesh_free(&m);
    }
}

static int open_device(void **state) {
    mcv_error error = {""};
    (void)state;
    if (tracer_open(&device, &error) == MCV_OK) return 0;
    print_error("%s\n", error.text);
    return -1;
}

static int close_device(void **state) {
    (void)state;
    tracer_close(&device);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_hit_as_all_triangles),
        cmocka_unit_test(test_closed_meshes_have_even_crossings),
        cmocka_unit_test(test_nothing_leaves_a_closed_mesh),
        cmocka_unit_test(test_offset_origins_leave_their_surface),
        cmocka_unit_test(test_odd_rays_miss),
        cmocka_unit_test(test_hits_lie_ahead_within_their_error),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
