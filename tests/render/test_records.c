/* SPDX-License-Identifier: Apache-2.0 */
/* Records of light by element of an emitter (kernels/stage/record_light.h): they add up to the
 * image, in both schedules, however often a launch is repeated for want of room. */
#include "records.h"

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
    /* A telecentric projector, met along its cone; a sky that many paths see, by a picture; a
     * projector behind a lens; views by direction. Streams record by the same function as tiles:
     * two scenes show that it is called, each scene costs kernels of its own. */
    static const char *const names[] = {"gray-code.gltf", "sky.gltf", "lens-projector.gltf",
                                        "light-field.gltf"};
    enum { STREAMED = 2 };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        sums tile = {0}, again = {0}, stream = {0};
        mcv_scene *scene = load(names[i]);
        tell_pixels_apart(scene);
        mcv_film film = record(scene, MCV_SCHEDULE_TILE, 0, &tile),
                 repeated = record(scene, MCV_SCHEDULE_TILE, 1 << 18, &again);
        expect_sums(names[i], &film, &tile);
        assert_memory_equal(film.sums, repeated.sums, 8 * mcv_film_values(&film));
        if (i < STREAMED) {
            mcv_film streamed = record(scene, MCV_SCHEDULE_STREAM, 0, &stream);
            assert_memory_equal(film.sums, streamed.sums, 8 * mcv_film_values(&film));
            mcv_film_free(&streamed);
            if (tile.digest != stream.digest || tile.count != stream.count)
                fail_msg("%s: %zu records in tiles, %zu in streams, or others", names[i],
                         tile.count, stream.count);
        }
        if (tile.digest != again.digest || tile.count != again.count)
            fail_msg("%s: %zu records at once, %zu in repeated launches, or others", names[i],
                     tile.count, again.count);
        mcv_film_free(&film);
        mcv_film_free(&repeated);
        free(tile.cells);
        free(again.cells);
        free(stream.cells);
        mcv_scene_free(scene);
    }
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
        cmocka_unit_test(test_stops_with_a_launch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
