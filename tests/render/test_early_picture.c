/* SPDX-License-Identifier: Apache-2.0 */
/* Coarse pictures before an image is done (host/render/early_picture.c), and the reference
 * renderer's drafts. */
#include "estimates.h"

#include "peer_scenes.h"
#include "reference/reference.h"

/* A film of 162 x 112 pixels has more than a picture may have: 81 x 56 of 2 x 2. */
enum { WIDTH = 162, HEIGHT = 112, SEEDS = 8 };

static void add_camera(mcv_scene *scene, mcv_transform at) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_PINHOLE);
    sensor.as.pinhole.imageDistance = 1;
    sensor.as.pinhole.resolution[0] = WIDTH;
    sensor.as.pinhole.resolution[1] = HEIGHT;
    sensor.as.pinhole.pixelSize[0] = sensor.as.pinhole.pixelSize[1] = 0.5 / WIDTH;
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, at);
}

/* A ball of glass over a floor, through which a narrow cone shines: most of it comes by light
 * paths. */
static mcv_scene *new_caustic(void) {
    mcv_scene *scene = new_scene();
    add_environment(scene, 0.01);
    add_rectangle(scene, 4, 4, add_peer_diffuse(scene, false, 0.6), looking_up_z(0, 0, 0));
    add_ball(scene, 0.3, 1.5, add_glass(scene, 1.5, 0, 0));
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.3, 0.3, add_absorber(scene), looking_down_z(0, 0, 5)), 1e4,
                M_PI / 180);
    /* From aside: the ball mirrors the cone by at most 60° from the vertical. */
    const double down = sqrt(0.1), along = 3 * down;
    add_camera(scene, looking((const double[3]){3, 0, 1}, (const double[3]){-along, 0, -down},
                              (const double[3]){-down, 0, along}));
    return scene;
}

/* The last picture that a render gave. */
typedef struct seen {
    unsigned count;
    uint32_t width, height, stride;
    double mean;
} seen;

static void see(void *user, const mcv_image *picture, uint32_t stride) {
    seen *s = user;
    const size_t values = (size_t)picture->width * picture->height * picture->channels;
    double sum = 0;
    for (size_t i = 0; i < values; ++i) sum += (double)picture->pixels[i];
    s->mean = sum / (double)values;
    s->width = picture->width;
    s->height = picture->height;
    s->stride = stride;
    ++s->count;
}

static bool once(void *user, const mcv_film *film) {
    (void)user;
    (void)film;
    return true;
}

/* The first rounds of a render that has no end of its own. */
static mcv_film render(const mcv_scene *scene, uint32_t seed, mcv_picture_told *picture, seen *s,
                       mcv_render_stats *stats) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    options.seed = seed;
    options.picture = picture;
    options.error = 1e-9;
    options.enough = once;
    options.user = s;
    BUILD(render_again(scene, 0, &options, &film, stats, &builder_error));
    return film;
}

/* The picture shows the image: all of its light, that of light paths too, in the film's units. */
static void test_picture_has_the_light(void **state) {
    (void)state;
    mcv_scene *scene = new_caustic();
    double pictures[SEEDS], films[SEEDS], carried = 0;
    for (uint32_t i = 0; i < SEEDS; ++i) {
        mcv_render_stats stats;
        seen s = {0};
        mcv_film film = render(scene, i, see, &s, &stats);
        assert_int_equal(s.count, 1);
        assert_int_equal(s.width, (WIDTH + 1) / 2);
        assert_int_equal(s.height, (HEIGHT + 1) / 2);
        assert_int_equal(s.stride, 2);
        assert_non_null(film.splats);
        pictures[i] = s.mean;
        films[i] = mcv_film_mean(&film);
        double all = 0, camera = 0;
        for (size_t k = 0; k < mcv_film_values(&film); ++k) {
            all += film.sums[k];
            camera += film.camera_sums[k];
        }
        carried += (1 - camera / all) / SEEDS;
        mcv_film_free(&film);
    }
    const mcv_estimate picture = mcv_estimate_replicates(pictures, SEEDS),
                       film = mcv_estimate_replicates(films, SEEDS);
    const double error = sqrt(picture.variance + film.variance);
    print_message("picture %.5g, film %.5g ± %.2g, by light paths %.2g of it\n", picture.mean,
                  film.mean, error, carried);
    /* A picture without light paths, or with twice as much of them, would be seen. */
    assert_true(carried * film.mean > 20 * error);
    /* Student's t with 7 degrees of freedom: 7.9 standard errors happen with probability 1e-4. */
    if (!(fabs(picture.mean - film.mean) <= 7.9 * error))
        fail_msg("the picture's mean is %g ± %g, the film's %g", picture.mean, error, film.mean);
    mcv_scene_free(scene);
}

/* No bit of the image and no number of its statistics comes from the picture. */
static void test_picture_leaves_the_image(void **state) {
    (void)state;
    mcv_scene *scene = new_caustic();
    mcv_render_stats with, without;
    seen s = {0};
    mcv_film a = render(scene, 3, see, &s, &with), b = render(scene, 3, NULL, &s, &without);
    assert_int_equal(s.count, 1);
    assert_int_equal(a.samples, b.samples);
    assert_memory_equal(a.sums, b.sums, 8 * mcv_film_values(&a));
    assert_memory_equal(a.splats, b.splats, 8 * mcv_film_values(&a));
    assert_int_equal(with.paths, without.paths);
    assert_int_equal(with.rays, without.rays);
    assert_int_equal(with.shadow_rays, without.shadow_rays);
    mcv_film_free(&a);
    mcv_film_free(&b);
    mcv_scene_free(scene);
}

/* A render of few paths is done in a moment: it has no picture before. */
static void test_short_render_has_no_picture(void **state) {
    (void)state;
    mcv_scene *scene = new_caustic();
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    seen s = {0};
    options.last = 1;
    options.picture = see;
    options.user = &s;
    BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    assert_int_equal(s.count, 0);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/* --- the reference renderer's draft --- */

static mcv_film draft(const mcv_scene *scene, uint32_t seed, uint32_t stride) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    options.replicates = 1;
    options.last = 4;
    options.seed = seed;
    BUILD(mcv_reference_draft(scene, 0, &options, stride, &film, &builder_error));
    return film;
}

/* Every pixel of a uniform sky has its radiance, also where a pixel sticks out of the sensor. */
static void test_draft_of_the_sky(void **state) {
    (void)state;
    for (uint32_t stride = 1; stride <= 8; stride += 7) {
        mcv_scene *scene = new_scene();
        add_environment(scene, 2);
        add_camera(scene, looking_down_z(0, 0, 4));
        mcv_film film = draft(scene, 0, stride);
        assert_int_equal(film.width, (WIDTH + stride - 1) / stride);
        assert_int_equal(film.height, (HEIGHT + stride - 1) / stride);
        for (size_t i = 0; i < mcv_film_values(&film); ++i)
            if (film.sums[i] != 2.0 * (double)film.samples)
                fail_msg("stride %u, value %zu: %g", stride, i,
                         film.sums[i] / (double)film.samples);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

/* The pixels of a draft lie where those of the image do: a lamp in one quarter of the view. */
static void test_draft_is_in_place(void **state) {
    (void)state;
    mcv_scene *scene = new_scene();
    /* At a distance of 4 the view is 2 wide: the lamp covers its left half, the upper half. */
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 2, 2, add_absorber(scene), looking_up_z(-1, 1, 0)), 3, 0);
    add_camera(scene, looking_down_z(0, 0, 4));
    enum { STRIDE = 7 };
    mcv_film film = draft(scene, 0, STRIDE);
    for (uint32_t row = 0; row < film.height; ++row)
        for (uint32_t column = 0; column < film.width; ++column) {
            /* The middle column and row of the film are cut in two. */
            const uint32_t left = column * STRIDE, right = left + STRIDE, top = row * STRIDE,
                           bottom = top + STRIDE;
            const double value = film.sums[row * film.width + column] / (double)film.samples;
            if (right <= WIDTH / 2 && bottom <= HEIGHT / 2 && value != 3)
                fail_msg("column %u, row %u: %g instead of 3", column, row, value);
            if ((left > WIDTH / 2 || top > HEIGHT / 2) && value != 0)
                fail_msg("column %u, row %u: %g instead of 0", column, row, value);
        }
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/* A white furnace: rough metal that absorbs nothing returns what comes from all sides. The draft's
 * albedos are sums of 16 x 16 microfacets: 1 % of the exact ones at this roughness. */
static void test_draft_of_rough_metal(void **state) {
    (void)state;
    mcv_scene *scene = new_scene();
    mcv_material metal = {.texture = MCV_NONE, .surface_texture = MCV_NONE};
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_METALLIC_ROUGHNESS), &metal.as);
    for (int k = 0; k < 3; ++k) metal.as.metallic_roughness.baseColor[k] = 1;
    metal.as.metallic_roughness.metallic = 1;
    metal.as.metallic_roughness.roughness = 0.7;
    add_environment(scene, 1);
    add_rectangle(scene, 4, 4, add_material(scene, MCV_MATERIAL_METALLIC_ROUGHNESS, &metal),
                  looking_up_z(0, 0, 0));
    add_camera(scene, looking_down_z(0, 0, 4));
    double means[SEEDS];
    for (uint32_t i = 0; i < SEEDS; ++i) {
        mcv_film film = draft(scene, i, 8);
        means[i] = mcv_film_mean(&film);
        mcv_film_free(&film);
    }
    const mcv_estimate mean = mcv_estimate_replicates(means, SEEDS);
    print_message("a draft's furnace: %.5g ± %.2g\n", mean.mean, sqrt(mean.variance));
    if (!(fabs(mean.mean - 1) <= 0.01 + 7.9 * sqrt(mean.variance)))
        fail_msg("%g ± %g instead of 1", mean.mean, sqrt(mean.variance));
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_picture_has_the_light),
        cmocka_unit_test(test_picture_leaves_the_image),
        cmocka_unit_test(test_short_render_has_no_picture),
        cmocka_unit_test(test_draft_of_the_sky),
        cmocka_unit_test(test_draft_is_in_place),
        cmocka_unit_test(test_draft_of_rough_metal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
