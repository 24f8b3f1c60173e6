/* SPDX-License-Identifier: Apache-2.0 */
/* Records of light by element of an emitter (kernels/stage/record_light.h): they add up to the
 * image, in both schedules, however often a launch is repeated for want of room. */
#include "estimates.h"

#include "device/pack.h"
#include "loader/load.h"
#include "mcvisi/tables.h"
#include "scene/sensors.h"
#include "scene/spectra.h"

enum { SAMPLES = 4, DEPTH = 8 };

/* What the records of a render add up to. */
typedef struct sums {
    double *cells;   /* [pixel][replicate][channel] */
    uint64_t digest; /* of all records, in any order */
    size_t count;
    uint32_t channels, cell_count, element_count;
} sums;

static uint64_t mix(uint64_t word) {
    word = (word ^ word >> 31) * 0x9e3779b97f4a7c15u;
    return word ^ word >> 29;
}

static mcv_result add_records(void *user, const uint32_t *records, size_t count, mcv_error *error) {
    sums *s = user;
    const size_t words = MCV_RECORD_WORDS(s->channels);
    (void)error;
    for (size_t i = 0; i < count; ++i, records += words) {
        uint64_t digest = 0;
        if (records[0] >= s->cell_count || records[1] >= s->element_count)
            fail_msg("a record of cell %u, element %u: there are %u and %u", records[0], records[1],
                     s->cell_count, s->element_count);
        for (size_t k = 0; k < words; ++k) digest = mix(digest + records[k]);
        s->digest += digest;
        for (uint32_t c = 0; c < s->channels; ++c) {
            float value;
            memcpy(&value, records + 2 + c, sizeof value);
            s->cells[(size_t)records[0] * s->channels + c] += value;
        }
    }
    s->count += count;
    return MCV_OK;
}

static mcv_scene *load(const char *name) {
    char path[512];
    mcv_scene *scene;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error));
    return scene;
}

/* Renders with records; bytes: room for those of a launch. */
static mcv_film record(const mcv_scene *scene, uint32_t schedule, size_t bytes, sums *s) {
    mcv_record_sink sink = {add_records, s, bytes};
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    uint32_t width, height;
    mcv_sensor_film_size(&scene->sensors[0], &width, &height);
    options.last = SAMPLES;
    options.depth = DEPTH;
    options.schedule = schedule;
    options.records = &sink;
    *s = (sums){.channels = mcv_scene_channels(scene),
                .cell_count = width * height * options.replicates};
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        s->element_count += mcv_emitter_elements(scene, scene->emitters + i);
    s->cells = calloc((size_t)s->cell_count * s->channels, sizeof *s->cells);
    assert_non_null(s->cells);
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    assert_non_null(strstr(stats.features, "records"));
    return film;
}

/*
 * The records of each cell must add up to the film's sum. A path's radiance is a sum of at most two
 * lights per surface, each rounded once with u = 2^-24 of the sum so far, then multiplied twice; a
 * record is the product of three roundings. So both differ by (2 DEPTH + 5) u of the sum at most,
 * and the film adds without a rounding that counts.
 */
static void expect_sums(const char *what, const mcv_film *film, const sums *s) {
    const size_t plane = (size_t)film->width * film->height;
    double most = 0, total = 0;
    for (uint32_t r = 0; r < film->replicates; ++r)
        for (uint32_t c = 0; c < film->channels; ++c)
            for (size_t i = 0; i < plane; ++i) {
                const double sum = film->sums[((size_t)r * film->channels + c) * plane + i],
                             of_records = s->cells[(i * film->replicates + r) * film->channels + c];
                total += sum;
                if (sum > 0) most = fmax(most, fabs(of_records - sum) / sum);
                if (!(fabs(of_records - sum) <= (2 * DEPTH + 5) * 0x1p-24 * sum))
                    fail_msg("%s: pixel %zu, replicate %u: records %.9g, film %.9g", what, i, r,
                             of_records, sum);
            }
    print_message("%s: %zu records, at most %.1e off\n", what, s->count, most);
    if (!(total > 0)) fail_msg("%s: the image is black", what);
}

/* Elements are pixels of all images, but not of an environment's. */
static void tell_pixels_apart(mcv_scene *scene) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        scene->emitters[i].by_pixel = scene->emitters[i].texture != MCV_NONE &&
                                      scene->emitters[i].type != MCV_EMITTER_ENVIRONMENT;
}

static void test_records_are_the_image(void **state) {
    (void)state;
    /* A telecentric projector, met along its cone; a projector behind a lens; views by direction; a
     * sky that many paths see, by a picture. */
    static const char *const names[] = {"gray-code.gltf", "lens-projector.gltf", "light-field.gltf",
                                        "sky.gltf"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        sums tile = {0}, again = {0}, stream = {0};
        mcv_scene *scene = load(names[i]);
        tell_pixels_apart(scene);
        mcv_film film = record(scene, MCV_SCHEDULE_TILE, 0, &tile),
                 repeated = record(scene, MCV_SCHEDULE_TILE, 1 << 18, &again),
                 streamed = record(scene, MCV_SCHEDULE_STREAM, 0, &stream);
        expect_sums(names[i], &film, &tile);
        assert_memory_equal(film.sums, streamed.sums, 8 * mcv_film_values(&film));
        assert_memory_equal(film.sums, repeated.sums, 8 * mcv_film_values(&film));
        if (tile.digest != stream.digest || tile.count != stream.count)
            fail_msg("%s: %zu records in tiles, %zu in streams, or others", names[i], tile.count,
                     stream.count);
        if (tile.digest != again.digest || tile.count != again.count)
            fail_msg("%s: %zu records at once, %zu in repeated launches, or others", names[i],
                     tile.count, again.count);
        mcv_film_free(&film);
        mcv_film_free(&repeated);
        mcv_film_free(&streamed);
        free(tile.cells);
        free(again.cells);
        free(stream.cells);
        mcv_scene_free(scene);
    }
}

/*
 * Light paths are recorded instead of splatted. The image without records has the same light paths;
 * each splat is rounded at random by less than one unit.
 */
static void test_light_paths_are_recorded(void **state) {
    (void)state;
    sums s = {0};
    mcv_scene *scene = load("caustic.gltf");
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film whole, film = record(scene, MCV_SCHEDULE_TILE, 0, &s);
    double of_film = 0, of_records = 0, of_camera = 0;
    options.last = SAMPLES;
    options.depth = DEPTH;
    BUILD(mcv_render(scene, 0, &options, &whole, &stats, &builder_error));
    assert_non_null(strstr(stats.features, "light-tracing"));
    for (size_t i = 0; i < mcv_film_values(&whole); ++i) {
        of_film += whole.sums[i];
        of_camera += film.sums[i];
        of_records += s.cells[i];
    }
    const double rounding =
        (2 * DEPTH + 5) * 0x1p-24 * of_film + (double)s.count * whole.splat_value;
    print_message("caustic: %.9g of the film, %.9g of %zu records, %.3g without light paths\n",
                  of_film, of_records, s.count, of_camera);
    if (!(fabs(of_records - of_film) <= rounding))
        fail_msg("records %.9g, film %.9g, may differ by %.2g", of_records, of_film, rounding);
    if (!(of_camera < of_film - rounding)) fail_msg("light paths bring nothing");
    mcv_film_free(&film);
    mcv_film_free(&whole);
    free(s.cells);
    mcv_scene_free(scene);
}

enum { MANY = 1 << 18 }; /* samples of a replicate: four launches of a set, hours of all */

/* What a stopped render was told. */
typedef struct stopping {
    uint32_t calls, stop_after;
    double fraction; /* the last one */
} stopping;

static bool stop_later(void *user, double fraction, double seconds, double error) {
    stopping *s = user;
    (void)seconds, (void)error;
    if (isnan(fraction)) return true;
    if (s->calls == s->stop_after) fail_msg("goes on after the stop, at %g", fraction);
    if (!(fraction > s->fraction && fraction < 1))
        fail_msg("call %u: %g of the render is done, after %g", s->calls, fraction, s->fraction);
    s->fraction = fraction;
    return ++s->calls < s->stop_after;
}

static mcv_result drop_records(void *user, const uint32_t *records, size_t count,
                               mcv_error *error) {
    (void)user, (void)records, (void)count, (void)error;
    return MCV_OK;
}

/*
 * A render that records has one round, which may take hours; a single pixel's samples take many
 * launches. It must end with the launch after which it is stopped, without an image. The first pass
 * has one set, of which a launch has 2^16 samples.
 */
static void test_stops_with_a_launch(void **state) {
    (void)state;
    static const uint32_t schedules[] = {MCV_SCHEDULE_TILE, MCV_SCHEDULE_STREAM};
    for (size_t i = 0; i < sizeof schedules / sizeof schedules[0]; ++i) {
        mcv_scene *scene = load("gray-code.gltf");
        mcv_record_sink sink = {.take = drop_records};
        stopping s = {.stop_after = 2};
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        mcv_film film;
        tell_pixels_apart(scene);
        options.last = MANY;
        options.depth = DEPTH;
        options.schedule = schedules[i];
        options.records = &sink;
        options.progress = stop_later;
        options.user = &s;
        BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
        if (s.calls != s.stop_after || !stats.interrupted || film.samples > 0)
            fail_msg("%u calls, stopped at %u: %sinterrupted, %llu samples", s.calls, s.stop_after,
                     stats.interrupted ? "" : "not ", (unsigned long long)film.samples);
        if (stats.paths > 2u << 16)
            fail_msg("%llu paths in 2 launches", (unsigned long long)stats.paths);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_records_are_the_image),
        cmocka_unit_test(test_light_paths_are_recorded),
        cmocka_unit_test(test_stops_with_a_launch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
