/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Time to an image of a given error against Mitsuba 3: bench_render [--quick] [--only TEXT]
 * [OUTPUT.json]. Without Mitsuba (`./run deps peers`) only `sampling_gain` and `adaptive_gain` are
 * measured. docs/benchmarks.md has the method.
 *
 * Both describe the same scenes (tests/common/peer_scenes.h, tests/peers/mitsuba_peer.py): three
 * channels, 32 surfaces a path, all cores, wall clock; scene loaded and kernels compiled before.
 * Mitsuba takes part with each variant, sampler and integrator that fits; the best counts. For
 * `samples_per_second` that is the fastest, for `time_to_rmse` the first to reach the error. A
 * sample of Mitsuba's is one path from the camera. For `paths_per_second` ours is one too: without
 * light paths and branches.
 *
 * Each renderer has its own truth, with 64 times the samples and another seed; mcv_compare_films
 * must find no difference between the two. The truth's variance is subtracted from the mean squared
 * error. The error to reach is the geometric mean of both errors at the same number of samples. The
 * number of samples that reaches it follows from each renderer's own power law, and the time from
 * that number and the time of an image without samples.
 *
 * `sampling_gain` has no peer: RMSE x √seconds of report-clean with random numbers, without
 * splitting and without light paths, over that of a usual render. `adaptive_gain` is the same of
 * part-backlight (128 x 96 pixels, 64 samples of 4 replicates) without adaptive sampling over that
 * with it.
 */
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "analysis/compare.h"
#include "convergence.h"
#include "harness.h"
#include "image_maker.h"
#include "racers.h"
#include "io/png.h"
#include "peer_scenes.h"
#include "device/albedo.h"

#include "workload.h" /* after the scenes, whose parameters are called like its mesh */

enum { MESH_ASSEMBLY = 4, MOST_WORDS = 1024 };

typedef enum group { PLAIN, OPTICS, OPENING, CONE, MESH, GROUPS } group;

static const struct {
    const char *name, *integrator;
    group group;
    bool is_seen_diffuse; /* light paths connect all that the camera sees: ptracer fits */
    double lost;          /* bound of the multiple scattering of rough metal, which Mitsuba leaves
                             out: by mcv_microsurface walks where emitters are low */
    uint32_t surfaces;    /* the depth limit, where it is not SURFACES */
} scenes[] = {{"lens", "path", OPTICS, false, 0, 0},
              {"assembly", "path", PLAIN, false, 0, 0},
              {"satin conductor", "path", PLAIN, false, 0, 0},
              {"rough glass", "path", OPTICS, false, 0, 0},
              {"telecentric backlight", "path", OPTICS, false, 0, 0},
              {"sky", "path", PLAIN, false, 0, 0},
              {"absorbing", "volpath", OPTICS, false, 0, 0},
              {"cube", "path", OPTICS, false, 0, 0},
              {"area", "path", PLAIN, true, 0, 0},
              {"parallel panel", "path", CONE, true, 0, 0},
              {"opening", "path", OPENING, true, 0, 0},
              {"mesh lens", "path", MESH, false, 0, 0},
              {"mesh board", "path", MESH, true, 0, 0},
              {"mesh part", "path", MESH, true, 0, 0},
              {"mesh metal part", "path", MESH, false, 0.1, 0},
              {"mesh part in the sun", "path", MESH, false, 0.1, 0},
              {"mesh vial", "volpath", MESH, false, 0, 0},
              {"mesh displaced", "path", MESH, true, 0, 8},
              {"mesh lamps", "path", MESH, true, 0, 8},
              {"mesh plate", "path", MESH, false, 0.22, 0},
              {"mesh tray", "path", MESH, false, 0.1, 0}};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

enum { LLVM, SCALAR, MONO, VARIANTS };
static const char *const variants[VARIANTS] = {"llvm_ad_rgb", "scalar_rgb", "llvm_ad_mono"},
                         *const variant_names[VARIANTS] = {"llvm", "scalar", "llvm mono"};
static const char *const samplers[] = {"independent", "multijitter", "ldsampler"};
enum { SAMPLERS = 3 };

/* --- one scene
 * ----------------------------------------------------------------------------------------------------
 */

enum { FIRST_LOOK = 2, LAST_POINT = RACE_POINTS - 1 };

typedef struct race {
    peer peers[VARIANTS];
    mcv_mesh assembly;
    race_means means;
    bench_mean time_of[GROUPS]; /* to an error */
    char left_out[256], failed[256];
} race;

/* Our ways, then Mitsuba's. */
enum { UNIFORM, ADAPTIVE, SINGLE, MOST_RACERS = SINGLE + 1 + VARIANTS * (SAMPLERS + 1) };

/* Times all that are not out in turns. sides[i] is that of racers[i], or was before it went out. */
static mcv_result measure_point(const bench *b, racer *racers, bench_side *sides, size_t count,
                                int point, mcv_error *error) {
    image_maker makers[MOST_RACERS];
    bench_side taking_part[MOST_RACERS];
    size_t place[MOST_RACERS], n = 0;
    for (size_t i = 0; i < count; ++i) {
        if (racers[i].is_out) continue;
        makers[n] = racers[i].maker;
        makers[n].samples >>= 2 * (LAST_POINT - point);
        makers[n].seed = 1000 * ((uint32_t)point + 1);
        taking_part[n] = (bench_side){.run = make_image, .user = makers + n};
        if (makers[n].peer) taking_part[n].process = makers[n].peer->process;
        place[n++] = i;
    }
    MCV_TRY(bench_time(b, taking_part, n, error));
    for (size_t k = 0; k < n; ++k) {
        for (int clock = 0; clock < RACE_CLOCKS; ++clock)
            racers[place[k]].seconds[clock][point] = bench_side_median(b, taking_part + k, clock);
        racers[place[k]].rmse[point] = rmse_of(makers + k);
        sides[place[k]] = taking_part[k];
    }
    return MCV_OK;
}

/* Where the other variant draws the same samples in clearly less time, the errors being equal. */
static void send_out(const bench *b, racer *racers, const bench_side *sides, size_t count) {
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < count; ++k) {
            const image_maker *x = &racers[i].maker, *y = &racers[k].maker;
            if (!x->peer || !y->peer || x->integrator != y->integrator || x->sampler != y->sampler)
                continue;
            if (bench_side_median(b, sides + i, BENCH_WALL) >
                1.5 * bench_side_median(b, sides + k, BENCH_WALL))
                racers[i].is_out = true;
        }
}

/* Measures all samples once and drops the racers that are too slow, with a row of their own. Then
 * measures all samples again; the sides keep these times. */
static mcv_result measure_all(bench *b, racer *racers, bench_side *sides, size_t count,
                              mcv_error *error) {
    bench look = *b;
    const double values =
        (double)racers->maker.samples * racers->maker.pixels * racers->maker.pixels;
    look.repetitions = FIRST_LOOK;
    MCV_TRY(measure_point(&look, racers, sides, count, LAST_POINT, error));
    send_out(&look, racers, sides, count);
    for (size_t i = 0; i < count; ++i) {
        if (!racers[i].is_out) continue;
        bench_row(&look, BENCH_WALL, sides, sides + i, values, "Msamples/s", "%s, %s",
                  racers->maker.scene_name, racers[i].name);
        bench_more(b, "samples", racers->maker.samples);
        bench_more(b, "turns", FIRST_LOOK);
    }
    for (int point = 0; point < RACE_POINTS; ++point)
        if (racers->maker.samples >> 2 * (LAST_POINT - point))
            MCV_TRY(measure_point(b, racers, sides, count, point, error));
    return MCV_OK;
}

/* Someone beside our two: how fast ours is that is not adaptive, and the time of ours that is. */
static void note_racer(bench *b, const racer *ours, const bench_side *our_sides, const racer *other,
                       const bench_side *side) {
    const racer *adaptive = ours + ADAPTIVE;
    const image_maker *m = &adaptive->maker;
    const double values = (double)m->samples * m->pixels * m->pixels;
    bench_row(b, BENCH_CPU, our_sides + UNIFORM, side, values, "Msamples/s", "%s, %s",
              m->scene_name, other->name);
    bench_more(b, "samples", m->samples);
    bench_more(b, "seconds", racer_whole(adaptive, BENCH_WALL));
    bench_more(b, "peer_seconds", racer_whole(other, BENCH_WALL));
    bench_more(b, "processor_seconds", racer_whole(adaptive, BENCH_CPU));
    bench_more(b, "peer_processor_seconds", racer_whole(other, BENCH_CPU));
    bench_more(b, "ratio_by_wall",
               racer_whole(other, BENCH_WALL) / racer_whole(ours + UNIFORM, BENCH_WALL));
    bench_more(b, "rmse", adaptive->rmse[LAST_POINT] / mcv_film_mean(m->truth));
    bench_more(b, "uniform_rmse", ours[UNIFORM].rmse[LAST_POINT] / mcv_film_mean(m->truth));
    bench_more(b, "peer_rmse", other->rmse[LAST_POINT] / mcv_film_mean(other->maker.truth));
    bench_more(b, "exponent", racer_exponent(adaptive));
    bench_more(b, "peer_exponent", racer_exponent(other));
    bench_more(b, "time_to_rmse", racer_time_ratio(adaptive, other, BENCH_WALL));
    bench_more(b, "uniform_time_to_rmse", racer_time_ratio(ours + UNIFORM, other, BENCH_WALL));
    bench_more(b, "processor_time_to_rmse", racer_time_ratio(adaptive, other, BENCH_CPU));
    bench_more(b, "uniform_processor_time_to_rmse",
               racer_time_ratio(ours + UNIFORM, other, BENCH_CPU));
}

/* --- pictures at equal time
 * ---------------------------------------------------------------------------------------- */

enum { ZOOM = 2, GAP = 8, PICTURES = 3, MOST_TIMES = 16 };
static const double LOOK_SECONDS = 0.05;

static void paste(const mcv_film *film, int place, mcv_image *page) {
    const uint32_t size = film->width * ZOOM;
    for (uint32_t c = 0; c < 3; ++c)
        for (uint32_t y = 0; y < size; ++y)
            for (uint32_t x = 0; x < size; ++x)
                page->pixels[(c * page->height + y) * page->width + (size + GAP) * (uint32_t)place +
                             x] =
                    (float)film_value(film,
                                      (c % film->channels * film->height + y / ZOOM) * film->width +
                                          x / ZOOM);
}

/* Ours, theirs and the truth side by side, equally bright, as STEM-SCENE.png. */
static mcv_result write_pictures(const bench *b, const char *name, const mcv_film films[PICTURES],
                                 mcv_error *error) {
    const uint32_t size = films->width * ZOOM, width = PICTURES * size + (PICTURES - 1) * GAP;
    char path[sizeof b->stem + 64];
    mcv_image truth = {0}, page;
    mcv_preview preview;
    MCV_TRY(mcv_image_new(&page, width, size, 3, error));
    mcv_result result = mcv_film_develop(films + PICTURES - 1, &truth, NULL, error);
    if (result == MCV_OK) {
        preview.white = mcv_preview_white(&truth);
        for (size_t i = 0; i < 3 * (size_t)width * size; ++i) page.pixels[i] = (float)preview.white;
        for (int i = 0; i < PICTURES; ++i) paste(films + i, i, &page);
        snprintf(path, sizeof path, "%s-%s.png", b->stem, name);
        for (char *c = path + strlen(b->stem); *c; ++c)
            if (*c == ' ') *c = '-';
        result = mcv_png_write_preview(path, &page, "W/(m^2 sr)", &preview, error);
    }
    mcv_image_free(&truth);
    mcv_image_free(&page);
    return result;
}

static mcv_result time_film(const image_maker *m, mcv_film *film, double *seconds,
                            mcv_error *error) {
    const bench_seconds start = bench_now();
    MCV_TRY(make_film(m, film, error));
    *seconds = bench_since(start).by[BENCH_WALL];
    return MCV_OK;
}

/* As many samples as take so long, one at least. */
static double samples_in(const racer *x, double seconds) {
    const double all = x->maker.samples, fixed = racer_seconds(x, BENCH_WALL, 0),
                 slope = racer_seconds(x, BENCH_WALL, 1) - fixed;
    return fmin(fmax((seconds - fixed) / fmax(slope, 0.1 * racer_whole(x, BENCH_WALL)) * all, 1),
                MOST_TIMES * all);
}

/* The first power of two of ours that takes LOOK_SECONDS, and one of theirs too, and as many of
 * theirs as fit into that. */
static mcv_result draw_pictures(bench *b, const racer *ours, const racer *best, mcv_error *error) {
    image_maker makers[2] = {ours->maker, best->maker};
    mcv_film films[PICTURES] = {{0}, {0}, *ours->maker.truth};
    double seconds[2] = {0, 0};
    const double all = ours->maker.samples,
                 least =
                     samples_in(ours, fmax(LOOK_SECONDS, racer_seconds(best, BENCH_WALL, 1 / all)));
    makers[0].samples = 1u << (unsigned)ceil(log2(least));
    makers[1].samples =
        (uint32_t)samples_in(best, racer_seconds(ours, BENCH_WALL, makers[0].samples / all));
    mcv_result result = MCV_OK;
    for (int i = 0; i < 2 && result == MCV_OK; ++i)
        result = time_film(makers + i, films + i, seconds + i, error);
    if (result == MCV_OK) {
        bench_number(
            b, errors_against(films, makers[0].truth).rmse / mcv_film_mean(makers[0].truth),
            errors_against(films + 1, makers[1].truth).rmse / mcv_film_mean(makers[1].truth),
            "RMSE/mean", "%s, at equal time", ours->maker.scene_name);
        for (int i = 0; i < 2; ++i) {
            bench_more(b, i ? "peer_picture_samples" : "picture_samples", makers[i].samples);
            bench_more(b, i ? "peer_picture_seconds" : "picture_seconds", seconds[i]);
        }
        result = write_pictures(b, ours->maker.scene_name, films, error);
    }
    for (int i = 0; i < 2; ++i) mcv_film_free(films + i);
    return result;
}

/* --- the race
 * ------------------------------------------------------------------------------------------------------
 */

/* The best of the other side by one clock: at all samples, and to an error of ours that is adaptive
 * and that is not. */
typedef struct best_peers {
    size_t fastest, first, uniform_first;
} best_peers;

static best_peers find_best(const racer *racers, size_t count, bench_clock clock) {
    best_peers best = {0, 0, 0};
    for (size_t i = SINGLE + 1; i < count; ++i) {
        const racer *x = racers + i;
        if (x->is_out) continue;
        if (!best.fastest || racer_whole(x, clock) < racer_whole(racers + best.fastest, clock))
            best.fastest = i;
        if (!best.first || racer_time_ratio(racers + ADAPTIVE, x, clock) <
                               racer_time_ratio(racers + ADAPTIVE, racers + best.first, clock))
            best.first = i;
        if (!best.uniform_first ||
            racer_time_ratio(racers + UNIFORM, x, clock) <
                racer_time_ratio(racers + UNIFORM, racers + best.uniform_first, clock))
            best.uniform_first = i;
    }
    return best;
}

static void add_ratios(race *r, group kind, const racer *racers, best_peers best,
                       bench_clock clock) {
    const race_set set = kind == MESH ? RACE_MESHES : RACE_ANALYTIC;
    const double fastest = racer_whole(racers + best.fastest, clock);
    race_means_add(&r->means, RACE_SAMPLES, set, clock,
                   fastest / racer_whole(racers + UNIFORM, clock));
    race_means_add(&r->means, RACE_PATHS, set, clock,
                   fastest / racer_whole(racers + SINGLE, clock));
    race_means_add(&r->means, RACE_TIME, set, clock,
                   racer_time_ratio(racers + ADAPTIVE, racers + best.first, clock));
    race_means_add(&r->means, RACE_UNIFORM_TIME, set, clock,
                   racer_time_ratio(racers + UNIFORM, racers + best.uniform_first, clock));
}

/*
 * For an image of a given error ours is adaptive, in all scenes, as docs/adaptive-sampling.md
 * advises; samples per second are those of the render that is not.
 */
static mcv_result race_all_sides(bench *b, race *r, int scene, racer *racers, size_t count,
                                 mcv_error *error) {
    static const char *const clocks[RACE_CLOCKS] = {"time", "processor time"};
    bench_side sides[MOST_RACERS];
    const racer *uniform = racers + UNIFORM, *adaptive = racers + ADAPTIVE;
    const group kind = scenes[scene].group;
    size_t first = 0;
    MCV_TRY(measure_all(b, racers, sides, count, error));
    for (size_t i = ADAPTIVE; i < count; ++i)
        if (!racers[i].is_out) note_racer(b, racers, sides, racers + i, sides + i);
    for (int clock = RACE_CLOCKS - 1; clock >= 0; --clock) {
        const best_peers best = find_best(racers, count, clock);
        const double rmse = racer_equal_error(adaptive, racers + best.first);
        bench_number(b, racer_seconds_to(adaptive, clock, rmse),
                     racer_seconds_to(racers + best.first, clock, rmse), "s",
                     "%s, %s to RMSE %.2g %%", adaptive->maker.scene_name, clocks[clock],
                     100 * rmse / mcv_film_mean(adaptive->maker.truth));
        if (kind != CONE) add_ratios(r, kind, racers, best, clock);
        first = best.first;
    }
    for (size_t i = 0; i < count; ++i)
        if (!racers[i].maker.peer || i == first) racer_note_curve(b, racers + i);
    bench_mean_add(&r->time_of[kind], racer_time_ratio(adaptive, racers + first, BENCH_WALL));
    /* So early that there is no look yet. */
    return draw_pictures(b, uniform, racers + first, error);
}

/* --- who takes part
 * ------------------------------------------------------------------------------------------------
 */

static void add_racer(racer *racers, size_t *count, const image_maker *maker, const char *format,
                      ...) __attribute__((format(printf, 4, 5)));
static void add_racer(racer *racers, size_t *count, const image_maker *maker, const char *format,
                      ...) {
    racer *x = &racers[(*count)++];
    va_list words;
    *x = (racer){.maker = *maker};
    va_start(words, format);
    vsnprintf(x->name, sizeof x->name, format, words);
    va_end(words);
}

static void add_peer(const race *r, int variant, image_maker maker, racer *racers, size_t *count) {
    maker.peer = (peer *)r->peers + variant;
    add_racer(racers, count, &maker, "%s %s %s", maker.integrator, variant_names[variant],
              maker.sampler);
}

/* The panel's light is a plugin in Python, which a scalar variant would ask anew for each ray. The
 * scalar variant takes minutes for a scene of meshes, and was never first. A scene without colours
 * is one of one channel to both. */
static void add_peers(const race *r, int scene, image_maker maker, racer *racers, size_t *count) {
    const bool llvm_alone = scenes[scene].group == CONE || scenes[scene].group == MESH;
    for (int v = 0; v < VARIANTS; ++v) {
        if ((v == MONO) != (maker.channels == 1) || (v == SCALAR && llvm_alone)) continue;
        maker.integrator = scenes[scene].integrator;
        for (int s = 0; s < SAMPLERS; ++s) {
            maker.sampler = samplers[s];
            add_peer(r, v, maker, racers, count);
        }
        maker.integrator = "ptracer";
        maker.sampler = samplers[0];
        if (scenes[scene].is_seen_diffuse) add_peer(r, v, maker, racers, count);
    }
}

/* The share of light from all sides that rough microfacets of a scene lose where what they send on
 * to each other is not given back. */
static double share_lost(const char *name) {
    enum { OUTSIDE, INSIDE, MEANS };
    const double alpha = PEER_SATIN * PEER_SATIN;
    float block[MOST_WORDS] = {0};
    if (mcv_albedo_words(1) > MOST_WORDS) return 0;
    if (strcmp(name, "satin conductor") == 0) {
        mcv_albedo_reflection(alpha, alpha, 1, block);
        block[INSIDE] = 0;
    } else if (strcmp(name, "rough glass") == 0) {
        mcv_albedo_interface(alpha, alpha, 1, 1.5, 0, 1, block);
    }
    return block[OUTSIDE] + block[INSIDE];
}

/*
 * Mitsuba starts rays (1 + |p|) 1500 roundings off surfaces, so that its image depends on the
 * scale: the assembly's mean is 0.046979, 0.046997 and 0.047064 at 1, 1/10 and 1/50 of its size
 * (each ± 0.000002). A line through these gives 0.046974 to 0.046975 without an offset: ours. This
 * is twice the deviation at size 1.
 */
static const double OFFSETS = 2e-4;

/*
 * Whether both pictures are the same: within their noise, or their means within the effect of the
 * offsets and of multiple scattering between microfacets, which Mitsuba loses. The bound of the
 * latter takes all light to have met such a surface once.
 */
static mcv_result compare_truths(bench *b, int scene, const mcv_film truths[2], bool *agree,
                                 mcv_error *error) {
    const char *name = scenes[scene].name;
    const double lost = fmax(share_lost(name), scenes[scene].lost);
    char words[64] = "pictures differ";
    mcv_comparison c;
    MCV_TRY(mcv_compare_films(truths, truths + 1, &c, error));
    printf("%s: means %.6g and %.6g; %s\n", name, c.mean_x, c.mean_y, c.reason);
    *agree = !c.different ||
             (c.mean_y <= (1 + OFFSETS) * c.mean_x && c.mean_y >= (1 - lost - OFFSETS) * c.mean_x);
    if (!c.different) snprintf(words, sizeof words, "pictures agree");
    if (c.different && *agree)
        snprintf(words, sizeof words, "means agree but for %.2g %%", 100 * (lost + OFFSETS));
    bench_number(b, c.mean_x, c.mean_y, "mean", "%s, %s", name, words);
    return MCV_OK;
}

/* Adds a name to a list of them. */
static void list_name(char *list, size_t size, const char *name) {
    const size_t length = strlen(list);
    snprintf(list + length, size - length, "%s%s", length ? ", " : "", name);
}

static mcv_result race_scene(bench *b, race *r, int scene, const image_maker *base,
                             mcv_film truths[2], mcv_error *error) {
    racer racers[MOST_RACERS];
    image_maker ours = *base, theirs = *base;
    bool agree;
    size_t count = 0;
    /* Only light paths meet a cone of half a degree often enough for a truth. */
    theirs.integrator = scenes[scene].group == CONE ? "ptracer" : scenes[scene].integrator;
    theirs.sampler = samplers[scenes[scene].group == CONE ? 0 : 1];
    MCV_TRY(make_truth(ours, truths, error));
    ours.channels = theirs.channels = truths->channels;
    theirs.peer = r->peers + (theirs.channels == 1 ? MONO : LLVM);
    MCV_TRY(make_truth(theirs, truths + 1, error));
    MCV_TRY(compare_truths(b, scene, truths, &agree, error));
    if (!agree) {
        list_name(r->left_out, sizeof r->left_out, base->scene_name);
        return MCV_OK;
    }
    ours.truth = truths;
    ours.truth_variance = variance_of(truths);
    theirs.truth = truths + 1;
    theirs.truth_variance = variance_of(truths + 1);
    add_racer(racers, &count, &ours, "MC ViSi");
    ours.is_adaptive = true;
    add_racer(racers, &count, &ours, "MC ViSi adaptive");
    ours.is_adaptive = false;
    ours.is_single = true;
    add_racer(racers, &count, &ours, "MC ViSi single paths");
    add_peers(r, scene, theirs, racers, &count);
    return race_all_sides(b, r, scene, racers, count, error);
}

/* STEM-NAME.gltf, which mesh_scenes.py writes. */
static mcv_result load_mesh_scene(const bench *b, const char *name, uint32_t pixels,
                                  mcv_scene **scene, mcv_error *error) {
    char path[sizeof b->stem + 64], command[3 * sizeof path];
    const int folder = snprintf(path, sizeof path, "%s-meshes", b->stem);
    snprintf(command, sizeof command,
             PYTHON " '" MCV_SOURCE_DIR "/bench/mesh_scenes.py' --seed %u '%s' '%s'", b->seed, path,
             name);
    if (system(command) != 0)
        return mcv_fail(error, MCV_FAILED, "mesh_scenes.py did not write \"%s\"", name);
    snprintf(path + folder, sizeof path - (size_t)folder, "/%s.gltf", name);
    for (char *c = path + folder; *c; ++c)
        if (*c == ' ') *c = '-';
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, error));
    mcv_sensor *sensor = (*scene)->sensors;
    if (sensor->type == MCV_SENSOR_THIN_LENS)
        shrink_film(sensor->as.thin_lens.resolution, sensor->as.thin_lens.pixelSize, pixels,
                    pixels);
    else
        shrink_film(sensor->as.pinhole.resolution, sensor->as.pinhole.pixelSize, pixels, pixels);
    return MCV_OK;
}

static mcv_result make_scene(const bench *b, const race *r, int i, image_maker *base,
                             mcv_scene **scene, mcv_error *error) {
    const char *name = scenes[i].name;
    *base = (image_maker){.scene_name = name,
                          .pixels = b->quick ? 64 : 96,
                          .samples = b->quick ? 16 : 256,
                          .surfaces = scenes[i].surfaces,
                          .truth_factor = 64,
                          .replicates = 1};
    if (scenes[i].group == MESH) {
        base->pixels = b->quick ? 128 : 256;
        base->samples = b->quick ? 16 : 64;
        base->truth_factor = 16;
        return load_mesh_scene(b, name, base->pixels, scene, error);
    }
    *scene = make_peer_scene(name, base->pixels, true,
                             strcmp(name, "assembly") == 0 ? &r->assembly : NULL);
    return MCV_OK;
}

static mcv_result open_scene(bench *b, race *r, int i, mcv_error *error) {
    image_maker base;
    mcv_scene *scene = NULL;
    MCV_TRY(make_scene(b, r, i, &base, &scene, error));
    mcv_film truths[2] = {{0}, {0}};
    base.scene = scene;
    base.renderer = mcv_renderer_new();
    mcv_result result = base.renderer ? race_scene(b, r, i, &base, truths, error)
                                      : mcv_fail(error, MCV_FAILED, "no memory for a renderer");
    for (int k = 0; k < 2; ++k) mcv_film_free(truths + k);
    mcv_renderer_free(base.renderer);
    mcv_scene_free(scene);
    return result;
}

/* --- sampling alone
 * --------------------------------------------------------------------------------------------- */

/* RMSE x √seconds of the other way to sample over that of the usual one. */
static mcv_result measure_gain(bench *b, image_maker *usual, image_maker *other, const char *what,
                               const char *key, mcv_error *error) {
    const double truth_variance = variance_of(usual->truth);
    usual->truth_variance = other->truth_variance = truth_variance;
    other->truth = usual->truth;
    other->renderer = mcv_renderer_new();
    if (!other->renderer) return mcv_fail(error, MCV_FAILED, "no memory for a renderer");
    bench_side sides[2] = {{.run = make_image, .user = usual}, {.run = make_image, .user = other}};
    const mcv_result result = bench_time(b, sides, 2, error);
    mcv_renderer_free(other->renderer);
    if (result != MCV_OK) return result;
    bench_row(b, BENCH_WALL, sides, sides + 1, 0, "s", "%s, %s", usual->scene_name, what);
    const double gain =
        bench_number(b, rmse_of(usual) * sqrt(bench_side_median(b, sides, BENCH_WALL)),
                     rmse_of(other) * sqrt(bench_side_median(b, sides + 1, BENCH_WALL)), "RMSE √s",
                     "%s, sampling alone", usual->scene_name);
    bench_summary(b, key, gain);
    return MCV_OK;
}

static mcv_result measure_gain_on(bench *b, mcv_scene *scene, image_maker usual, const char *what,
                                  const char *key, mcv_error *error) {
    mcv_film truth = {0};
    usual.scene = scene;
    usual.renderer = mcv_renderer_new();
    mcv_result result = usual.renderer ? make_truth(usual, &truth, error)
                                       : mcv_fail(error, MCV_FAILED, "no memory for a renderer");
    usual.truth = &truth;
    image_maker other = usual;
    other.is_random = other.is_single = !usual.is_adaptive;
    other.is_adaptive = false;
    if (result == MCV_OK) result = measure_gain(b, &usual, &other, what, key, error);
    mcv_film_free(&truth);
    mcv_renderer_free(usual.renderer);
    mcv_scene_free(scene);
    return result;
}

static mcv_result gain(bench *b, mcv_error *error) {
    const image_maker usual = {
        .scene_name = "report-clean", .samples = b->quick ? 256 : 1024, .replicates = 1};
    mcv_scene *scene;
    MCV_TRY(load_small("report-clean.glb", &scene, error));
    return measure_gain_on(b, scene, usual, "random points without light paths", "sampling_gain",
                           error);
}

static mcv_result adaptive_gain(bench *b, mcv_error *error) {
    const image_maker adaptive = {
        .scene_name = "part-backlight", .samples = 64, .replicates = 4, .is_adaptive = true};
    mcv_scene *scene;
    MCV_TRY(load_small("part-backlight.gltf", &scene, error));
    mcv_telecentric_params *p = &scene->sensors[0].as.telecentric;
    shrink_film(p->resolution, p->pixelSize, b->quick ? 64 : 128, b->quick ? 48 : 96);
    return measure_gain_on(b, scene, adaptive, "the same samples for all pixels", "adaptive_gain",
                           error);
}

/* --- all
 * --------------------------------------------------------------------------------------------------------
 */

static mcv_result write_ply(const mesh *m, const char *path, mcv_error *error) {
    FILE *file = fopen(path, "w");
    if (!file) return mcv_fail(error, MCV_FAILED, "%s: cannot be written", path);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %u\nproperty float x\nproperty float "
            "y\nproperty float z\n",
            m->vertex_count);
    fprintf(file, "element face %u\nproperty list uchar int vertex_indices\nend_header\n",
            m->triangle_count);
    for (uint32_t i = 0; i < m->vertex_count; ++i)
        fprintf(file, "%.9g %.9g %.9g\n", (double)m->positions[3 * i],
                (double)m->positions[3 * i + 1], (double)m->positions[3 * i + 2]);
    for (uint32_t i = 0; i < m->triangle_count; ++i)
        fprintf(file, "3 %u %u %u\n", m->indices[3 * i], m->indices[3 * i + 1],
                m->indices[3 * i + 2]);
    return fclose(file) == 0 ? MCV_OK : mcv_fail(error, MCV_FAILED, "%s: cannot be written", path);
}

static mcv_result open_peers(const bench *b, race *r, mcv_error *error) {
    char path[sizeof b->stem + 16], folder[sizeof b->stem + 16];
    snprintf(path, sizeof path, "%s-assembly.ply", b->stem);
    snprintf(folder, sizeof folder, "%s-meshes", b->stem);
    for (int v = 0; v < VARIANTS; ++v)
        MCV_TRY(peer_open(variants[v], path, folder, b->seed, r->peers + v, error));
    return MCV_OK;
}

static void close_peers(race *r) {
    for (int v = 0; v < VARIANTS; ++v) peer_close(r->peers + v);
}

/* A scene that fails is told, and the others follow, with a Mitsuba that knows nothing of it. */
static mcv_result race_scenes(bench *b, race *r, mcv_error *error) {
    for (int i = 0; i < SCENES; ++i) {
        mcv_error reason = {""};
        if (b->only && !strstr(scenes[i].name, b->only)) continue;
        if (open_scene(b, r, i, &reason) == MCV_OK) continue;
        printf("%s failed: %s\n", scenes[i].name, reason.text);
        list_name(r->failed, sizeof r->failed, scenes[i].name);
        close_peers(r);
        MCV_TRY(open_peers(b, r, error));
    }
    return MCV_OK;
}

static void note_mean(bench *b, const char *key, const bench_mean *mean) {
    if (mean->count) bench_summary(b, key, bench_mean_value(mean));
}

static mcv_result race_all(bench *b, race *r, const mesh *assembly, mcv_error *error) {
    char path[sizeof b->stem + 16];
    snprintf(path, sizeof path, "%s-assembly.ply", b->stem);
    MCV_TRY(write_ply(assembly, path, error));
    MCV_TRY(open_peers(b, r, error));
    r->assembly = (mcv_mesh){.vertex_count = assembly->vertex_count,
                             .triangle_count = assembly->triangle_count,
                             .positions = assembly->positions,
                             .indices = assembly->indices};
    MCV_TRY(race_scenes(b, r, error));
    race_means_note(b, &r->means);
    note_mean(b, "time_to_rmse_optics", r->time_of + OPTICS);
    note_mean(b, "time_to_rmse_cone", r->time_of + CONE);
    note_mean(b, "time_to_rmse_opening", r->time_of + OPENING);
    bench_summary_text(b, "left_out", r->left_out[0] ? r->left_out : "none");
    bench_summary_text(b, "failed", r->failed[0] ? r->failed : "none");
    if (r->failed[0]) return mcv_fail(error, MCV_FAILED, "these scenes failed: %s", r->failed);
    return MCV_OK;
}

static mcv_result run(bench *b, mcv_error *error) {
    workload_mesh assembly;
    race r = {0};
    bench_title("Against Mitsuba 3, and sampling alone");
    if (!b->only || strstr("report-clean", b->only)) MCV_TRY(gain(b, error));
    if (!b->only || strstr("part-backlight", b->only)) MCV_TRY(adaptive_gain(b, error));
    if (access(PYTHON, X_OK) != 0 || system(PYTHON " -c 'import mitsuba' 2>/dev/null") != 0) {
        puts("Mitsuba is not there: `./run deps peers` installs it");
        return MCV_OK;
    }
    signal(SIGPIPE, SIG_IGN); /* a peer that has died is seen where its image is missing */
    MCV_TRY(workload_load(MESH_ASSEMBLY, &assembly, error));
    mcv_result result = race_all(b, &r, &assembly.mesh, error);
    close_peers(&r);
    mesh_free(&assembly.mesh);
    return result;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "render", run); }
