/* SPDX-License-Identifier: Apache-2.0 */
/* A renderer that is used again and again gives the bits of one that is used once, and keeps what
 * has not changed. */
#include "scene_builder.h"

#include "device/pack.h"
#include "render/render.h"

/* A diffuse ball before a panel, which has another place, cone and radiance each time. */
typedef struct setup {
    double panel_distance, half_angle, radiance, ball_x, sensor_x;
    uint32_t pixels;
    uint32_t split; /* this triangle of the ball is three, one moved in; 0: none is */
    const char *what;
    bool keeps_structure, keeps_program;
} setup;

/* The ball with a triangle that is three around its middle, half way to the centre. */
static void split_triangle(mcv_mesh *m, uint32_t triangle) {
    const size_t v = m->vertex_count, t = m->triangle_count, at = 3 * (size_t)triangle;
    m->positions = realloc(m->positions, 12 * (v + 1));
    m->indices = realloc(m->indices, 12 * (t + 2));
    m->normals = realloc(m->normals, 12 * (v + 1));
    assert_true(m->positions && m->normals && m->indices);
    memcpy(m->normals + 3 * v, m->normals + 3 * (size_t)m->indices[at], 12);
    const uint32_t corner[3] = {m->indices[at], m->indices[at + 1], m->indices[at + 2]};
    for (size_t k = 0; k < 3; ++k) {
        m->positions[3 * v + k] = 0;
        for (int i = 0; i < 3; ++i)
            m->positions[3 * v + k] += m->positions[3 * (size_t)corner[i] + k] / 6;
    }
    /* The others follow, so that they have other numbers. */
    memmove(m->indices + at, m->indices + at + 3, 12 * (t - triangle - 1));
    for (size_t k = 0; k < 3; ++k) {
        m->indices[3 * (t - 1 + k)] = corner[k];
        m->indices[3 * (t - 1 + k) + 1] = corner[(k + 1) % 3];
        m->indices[3 * (t - 1 + k) + 2] = (uint32_t)v;
    }
    m->vertex_count += 1;
    m->triangle_count += 2;
}

static mcv_scene *make_scene(const setup *s) {
    mcv_scene *scene = mcv_scene_new("renderer");
    add_sphere(scene, 0.5, 16, add_diffuse(scene, 0.5), looking_down_z(s->ball_x, 0, 0));
    if (s->split) {
        split_triangle(scene->meshes, s->split);
        const mcv_json_path place = mcv_place_file("renderer");
        BUILD(mcv_scene_number_triangles(scene, &place, &builder_error));
    }
    const uint32_t panel =
        add_rectangle(scene, 2, 2, add_absorber(scene), looking_down_z(0, 0, s->panel_distance));
    mcv_emitter emitter = {.name = (char *)"panel",
                           .type = MCV_EMITTER_PARALLEL,
                           .instance = panel,
                           .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(MCV_EMITTER_PARALLEL), &emitter.as);
    emitter.as.parallel.halfAngle = s->half_angle;
    for (int c = 0; c < 3; ++c) emitter.as.parallel.radiance[c] = s->radiance;
    BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
    add_pinhole(scene, s->pixels, 0.5, looking_down_z(s->sensor_x, 0, 3));
    return scene;
}

static void render_once(const mcv_scene *scene, mcv_renderer *renderer, mcv_film *film,
                        mcv_render_stats *stats) {
    mcv_render_options options = mcv_render_defaults();
    mcv_error error = {""};
    options.last = 4;
    const mcv_result result =
        renderer ? mcv_renderer_render(renderer, scene, 0, &options, film, stats, &error)
                 : mcv_render(scene, 0, &options, film, stats, &error);
    if (result != MCV_OK) fail_msg("%s", error.text);
}

static void test_same_bits_and_kept(void **state) {
    static const setup setups[] = {
        {4, 0.3, 1, 0, 0, 20, 0, "the first", false, false},
        {4, 0.3, 1, 0, 0, 20, 0, "nothing new", true, true},
        {4, 0.3, 2, 0, 0, 20, 0, "another radiance", true, true},
        {4, 0.6, 2, 0, 0, 20, 0, "another cone", true, true},
        {4, 0.6, 2, 0, 0.1, 20, 0, "the sensor moved", true, true},
        {4, 0.6, 2, 0, 0.1, 28, 0, "more pixels", true, true},
        {4.5, 0.6, 2, 0, 0.1, 28, 0, "the panel moved", true, true},
        {3.9, 0.6, 2, 0.2, 0.1, 28, 0, "the panel and the ball moved", true, true},
        {4.5, 0.6, 2, 0.2, 0.1, 28, 0, "the panel moved back", true, true},
        {4.5, 0.6, 2, 0.2, 0.1, 28, 30, "a triangle of the ball split", true, true},
        {4.5, 0.6, 2, 0.2, 0.1, 28, 30, "again", true, true},
        {4.5, 0.6, 2, 0.2, 0.1, 28, 300, "another one", true, true},
        {4.5, 0.6, 2, 0.2, 0.1, 28, 31, "its neighbour in the list", true, true},
        {4.5, 0.6, 2, 0.2, 0.1, 28, 0, "whole again", true, true},
        {4.5, 0.6, 2, 0.9, 0.1, 28, 40, "the ball moved and one split", false, true},
        {4.5, 0.6, 2, 0.9, 0.1, 28, 41, "another one there", true, true},
    };
    mcv_renderer *renderer = mcv_renderer_new();
    (void)state;
    assert_non_null(renderer);
    for (size_t i = 0; i < sizeof setups / sizeof setups[0]; ++i) {
        const setup *s = setups + i;
        mcv_scene *scene = make_scene(s);
        mcv_film kept, alone;
        mcv_render_stats stats, other;
        render_once(scene, renderer, &kept, &stats);
        render_once(scene, NULL, &alone, &other);
        const size_t values =
            (size_t)alone.width * alone.height * alone.channels * alone.replicates;
        assert_int_equal(kept.width, alone.width);
        if (memcmp(kept.sums, alone.sums, values * sizeof *kept.sums) != 0)
            fail_msg("%s: other bits than rendered alone", s->what);
        if (stats.kept_structure != s->keeps_structure || stats.kept_program != s->keeps_program)
            fail_msg("%s: structure kept %d, program kept %d", s->what, stats.kept_structure,
                     stats.kept_program);
        assert_false(other.kept_structure || other.kept_program);
        mcv_film_free(&kept);
        mcv_film_free(&alone);
        mcv_scene_free(scene);
    }
    mcv_renderer_free(renderer);
}

/* Ends as soon as it is told to, in the round that it is told after. */
static bool enough_at_16(void *user, const mcv_film *film) {
    ++*(int *)user;
    return film->samples >= 16;
}

static void test_enough(void **state) {
    const setup s = {4, 0.3, 1, 0, 0, 8, 0, "", false, false};
    mcv_scene *scene = make_scene(&s);
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    mcv_render_stats stats;
    mcv_error error = {""};
    int asked = 0;
    (void)state;
    options.last = 256;
    options.enough = enough_at_16;
    options.user = &asked;
    if (mcv_render(scene, 0, &options, &film, &stats, &error) != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(film.samples, 16);
    assert_int_equal(asked, 3); /* after 4, 8 and 16 */
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/* A scene that cannot be rendered leaves a renderer that can. */
static void test_goes_on_after_a_failure(void **state) {
    const setup s = {4, 0.3, 1, 0, 0, 8, 0, "", false, false};
    mcv_scene *scene = make_scene(&s);
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    mcv_render_stats stats;
    mcv_error error = {""};
    (void)state;
    render_once(scene, renderer, &film, &stats);
    mcv_film_free(&film);
    options.last = 3;
    assert_int_equal(mcv_renderer_render(renderer, scene, 0, &options, &film, &stats, &error),
                     MCV_USAGE);
    render_once(scene, renderer, &film, &stats);
    assert_true(stats.kept_structure && stats.kept_program);
    mcv_film_free(&film);
    mcv_renderer_free(renderer);
    mcv_scene_free(scene);
}

static mcv_packed pack_metal(double roughness, const mcv_packed *earlier) {
    mcv_scene *scene = mcv_scene_new("metal");
    mcv_material metal = {.type = MCV_MATERIAL_CONDUCTOR, .texture = MCV_NONE};
    mcv_packed packed;
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_CONDUCTOR), &metal.as);
    metal.as.conductor.roughness = roughness;
    add_sphere(scene, 1, 4, add_material(scene, MCV_MATERIAL_CONDUCTOR, &metal),
               mcv_transform_identity());
    BUILD(mcv_pack(scene, earlier, &packed, &builder_error));
    mcv_scene_free(scene);
    return packed;
}

/* Albedos of the scene before serve again, as a mark in them shows, but not those of another
 * roughness. */
static void test_keeps_albedos(void **state) {
    (void)state;
    mcv_packed first = pack_metal(0.3, NULL), other = pack_metal(0.4, NULL);
    first.albedos[5] = -1;
    mcv_packed same = pack_metal(0.3, &first), different = pack_metal(0.4, &first);
    assert_int_equal(same.albedo_count, first.albedo_count);
    assert_memory_equal(same.albedos, first.albedos, first.albedo_count * sizeof *first.albedos);
    assert_int_equal(different.albedo_count, other.albedo_count);
    assert_memory_equal(different.albedos, other.albedos,
                        other.albedo_count * sizeof *other.albedos);
    mcv_packed *const all[] = {&first, &other, &same, &different};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i) mcv_packed_free(all[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits_and_kept),
        cmocka_unit_test(test_enough),
        cmocka_unit_test(test_goes_on_after_a_failure),
        cmocka_unit_test(test_keeps_albedos),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
