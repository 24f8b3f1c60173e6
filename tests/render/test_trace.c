/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A million rays through the shipped lenses, on the device and on the reference: hits and refracted
 * directions within float32 bounds. u = 2^-24.
 */
#include "scene_builder.h"

#include "reference/random.h"
#include "reference/reference.h"
#include "reference/vector.h"
#include "loader/load.h"
#include "scene/geometry.h"

enum { RAYS = 1 << 20 };
static const double u = 0x1p-24;

static mcv_scene *load(const char *name) {
    char path[512];
    mcv_scene *scene;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error));
    return scene;
}

static ref_vec vec(const double v[3]) { return (ref_vec){v[0], v[1], v[2]}; }

/* Worst error of what was compared, as a share of its bound. */
typedef struct outcome {
    size_t compared, elsewhere;
    double position, direction;
} outcome;

/*
 * The first two vertices after the start. Bounds, with M the largest coordinate of the re-centred
 * scene and rays, t the distance, i the angle of incidence on the face and s the sine-to-cosine
 * ratio behind it:
 *
 * The start and the corners round to float32 (√3 u M each), the direction's components too and it
 * is normalised again (3 u t sideways), intersection and interpolation of the point lose at most
 * γ(7) Σ|b_i p_i| √3 <= 13 u M: in all e = 17 u M + 3 u t across the ray, e / cos i along the
 * surface. A second hit starts from an error of e_1 and turns by the error of its direction: e_2 =
 * 17 u M + 3 u t + (e_1 + t a_1)/cos i.
 *
 * A refracted direction errs by 4 u (1 + η tanθ_t) (accuracy.md 0b), by the incident direction's
 * and the normal's own errors: both turn it by no more than themselves times (1 + η (1 + tanθ_t)).
 * A normal interpolated over the facet of size h at radius of curvature R moves by the point's
 * error over R, and rounds by 4 u; R is at least the mesh's smallest, `radius`.
 *
 * Rays that meet another triangle (within their error of an edge) are counted: as many as the lines
 * along all edges are wide.
 */
static outcome compare(const mcv_scene *scene, const mcv_trace_ray *rays, size_t count,
                       double largest, double radius) {
    mcv_render_options options = mcv_render_defaults();
    mcv_vertex *device;
    mcv_vertex *reference;
    size_t device_count;
    size_t reference_count;
    outcome o = {0};
    options.depth = 2;
    BUILD(mcv_trace(scene, rays, count, &options, &device, &device_count, &builder_error));
    BUILD(mcv_reference_trace(scene, rays, count, &options, &reference, &reference_count,
                              &builder_error));
    size_t d = 0;
    size_t r = 0;
    for (uint32_t ray = 0; ray < count; ++ray) {
        double position_bound = 0;
        double direction_bound = 3 * u;
        bool same = true;
        ref_vec incident = ref_unit(vec(rays[ray].direction));
        for (; d < device_count && device[d].ray == ray; ++d) {
            while (r < reference_count &&
                   (reference[r].ray < ray ||
                    (reference[r].ray == ray && reference[r].index < device[d].index)))
                ++r;
            if (r == reference_count || reference[r].ray != ray ||
                reference[r].index != device[d].index) {
                break;
            }
            const mcv_vertex *x = &device[d];
            const mcv_vertex *y = &reference[r];
            if (x->index == 0 || !same) continue;
            if (x->primitive != y->primitive || x->event != y->event) {
                ++o.elsewhere;
                same = false;
                continue;
            }
            if (x->event == MCV_EVENT_MISS) continue;
            ++o.compared;
            double corners[3][3];
            const uint32_t instance = mcv_scene_instance_of(scene, y->primitive);
            mcv_scene_corners(scene, instance,
                              y->primitive - scene->instances[instance].first_triangle, corners);
            const ref_vec face = ref_unit(ref_cross(ref_sub(vec(corners[1]), vec(corners[0])),
                                                    ref_sub(vec(corners[2]), vec(corners[0]))));
            const double cosine = fabs(ref_dot(face, incident));
            position_bound = 17 * u * largest + 3 * u * y->distance +
                             (position_bound + y->distance * direction_bound) / cosine;
            const double off = ref_length(ref_sub(vec(x->position), vec(y->position)));
            o.position = fmax(o.position, off / position_bound);
            if (x->event != MCV_EVENT_REFRACT) continue;
            const double n_before = y->index == 1 ? 1 : y[-1].ior;
            const double eta = n_before / y->ior;
            const ref_vec t = vec(y->direction);
            const double cosine_t = fabs(ref_dot(vec(y->normal), t));
            const double tangent = sqrt(fmax(0, 1 - cosine_t * cosine_t)) / cosine_t;
            const double normal_bound = 4 * u + position_bound / radius;
            direction_bound = 4 * u * (1 + eta * tangent) +
                              (direction_bound + normal_bound) * (1 + eta * (1 + tangent));
            o.direction =
                fmax(o.direction, ref_length(ref_sub(vec(x->direction), t)) / direction_bound);
            incident = t;
        }
        while (d < device_count && device[d].ray == ray) ++d;
    }
    free(device);
    free(reference);
    return o;
}

static void check(const char *name, const mcv_scene *scene, const mcv_trace_ray *rays,
                  double largest, double radius, double crossing_share) {
    const outcome o = compare(scene, rays, RAYS, largest, radius);
    print_message("%s: %zu hits compared, %zu rays met another triangle, position %.2f of its "
                  "bound, direction %.2f\n",
                  name, o.compared, o.elsewhere, o.position, o.direction);
    assert_true(o.compared >= RAYS);
    assert_true(o.position <= 1);
    assert_true(o.direction <= 1);
    assert_true((double)o.elsewhere <= crossing_share * RAYS);
}

/* From the camera's pupil at the lens of 14 mm and its mount. Facets of 0.29 mm: a ray is within
 * 1e-7 m of one of two edges with p < 2e-3.
 */
static void test_report_lens(void **state) {
    mcv_scene *scene = load("report-clean.glb");
    mcv_trace_ray *rays = malloc(RAYS * sizeof *rays);
    ref_random random = {7};
    (void)state;
    assert_non_null(rays);
    for (size_t i = 0; i < RAYS; ++i) {
        const double a = 2 * M_PI * ref_random_unit(&random);
        const double r = 0.0139 * sqrt(ref_random_unit(&random));
        rays[i] = (mcv_trace_ray){.origin = {0.02 * (ref_random_unit(&random) - 0.5),
                                             0.02 * (ref_random_unit(&random) - 0.5), 0}};
        rays[i].direction[0] = r * cos(a) - rays[i].origin[0];
        rays[i].direction[1] = r * sin(a) - rays[i].origin[1];
        rays[i].direction[2] = -0.298;
    }
    /* The scene is centred between its lens and panel; the rays start 0.34 m away from there. */
    check("report lens", scene, rays, 0.385, 0.31, 2e-3);
    free(rays);
    mcv_scene_free(scene);
}

/* A ball of glass with 64 rings, from all around: every angle of incidence up to 80°. */
static void test_glass_ball(void **state) {
    mcv_scene *scene = mcv_scene_new("ball");
    mcv_trace_ray *rays = malloc(RAYS * sizeof *rays);
    ref_random random = {8};
    (void)state;
    assert_non_null(rays);
    add_sphere(scene, 0.01, 64, add_glass(scene, 1.5168, 0, 0), mcv_transform_identity());
    for (size_t i = 0; i < RAYS; ++i) {
        const double z = 2 * ref_random_unit(&random) - 1;
        const double a = 2 * M_PI * ref_random_unit(&random);
        const double s = sqrt(1 - z * z);
        const ref_vec from = {0.05 * s * cos(a), 0.05 * s * sin(a), 0.05 * z};
        const ref_vec across = ref_unit(ref_cross(from, (ref_vec){z, s, 1 - s}));
        const double miss = 0.0098 * sqrt(ref_random_unit(&random));
        const ref_vec to = ref_sub(ref_scale(miss, across), from);
        rays[i] = (mcv_trace_ray){{from.x, from.y, from.z}, {to.x, to.y, to.z}};
    }
    check("glass ball", scene, rays, 0.05, 0.01, 2e-3);
    free(rays);
    mcv_scene_free(scene);
}

/*
 * A traced ray passes a beam splitter where light can. One that reflects all turns it back with all
 * of its light, one that absorbs all lets it on with none; no quotient of zeros is left.
 */
static void test_opaque_splitters(void **state) {
    (void)state;
    for (int reflects = 0; reflects < 2; ++reflects) {
        mcv_scene *scene = mcv_scene_new("opaque splitter");
        const double share = reflects;
        const uint32_t splitter = add_material(
            scene, MCV_MATERIAL_BEAM_SPLITTER,
            &(mcv_material){.as.beam_splitter = {.reflectance = {share, share, share}}});
        const mcv_trace_ray ray = {.origin = {0, 0, 1}, .direction = {0, 0, -1}};
        mcv_render_options options = mcv_render_defaults();
        options.depth = 3;
        add_rectangle(scene, 1, 1, splitter, looking_up_z(0, 0, 0.5));
        add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, 0));
        for (int reference = 0; reference < 2; ++reference) {
            mcv_vertex *vertices = NULL;
            size_t count = 0;
            BUILD((reference ? mcv_reference_trace : mcv_trace)(scene, &ray, 1, &options, &vertices,
                                                                &count, &builder_error));
            assert_int_equal(count, 3);
            if (vertices[2].transmittance != share ||
                vertices[1].event != (reflects ? MCV_EVENT_REFLECT : MCV_EVENT_PASS))
                fail_msg("after a splitter of reflectance %g, event %u, %s says that %g is left",
                         share, vertices[1].event, reference ? "the reference" : "the device",
                         vertices[2].transmittance);
            free(vertices);
        }
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_report_lens),
                                       cmocka_unit_test(test_glass_ball),
                                       cmocka_unit_test(test_opaque_splitters)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
