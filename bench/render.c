/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Time to an image of a given error against Mitsuba 3: bench_render [--quick] [--only TEXT] [OUTPUT.json]. Where Mitsuba is not
 * (`./run deps peers`), it says so, and only `sampling_gain` and `adaptive_gain` are measured.
 *
 * Scenes that both describe (tests/peer_scenes.h, tests/mitsuba_peer.py), three channels, 32 surfaces a path, all cores, wall clock; scene
 * loaded and kernels compiled before. Mitsuba takes part with each variant, sampler and integrator that fits, of which the best
 * counts: for `samples_per_second` the fastest, for `time_to_rmse` the one that reaches the error first.
 *
 * Each renderer's truth is its own, of 64 times the samples and another seed, after mcv_compare_films has found no difference between
 * both; the truth's own variance is taken off the mean squared error. The error that both are to reach is the geometric mean of
 * both errors at the same number of samples, and the time is that of the samples that the renderer's own power law asks for.
 *
 * `sampling_gain` has no peer: RMSE x √seconds of report-clean with random numbers, one way on from each surface and without light paths,
 * over that of a usual render;
 * `adaptive_gain`: of part-backlight (128 x 96 pixels, 64 samples of 4 replicates) without adaptive sampling, over that with it.
 */
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "analysis/compare.h"
#include "convergence.h"
#include "harness.h"
#include "peer_scenes.h"

#include "workload.h" /* after the scenes, whose parameters are called like its mesh */

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"

enum { REFERENCE_REPLICATES = 16, REFERENCE_FACTOR = 64, REFERENCE_SEED = 100000, SURFACES = 32, MOST_SIDES = 9, MESH_ASSEMBLY = 4 };

typedef enum group { PLAIN, OPTICS, CONE } group;

static const struct {
    const char *name, *integrator;
    group group;
    bool is_seen_diffuse; /* light paths reach the camera from all that it sees: ptracer fits */
} scenes[] = {{"lens", "path", OPTICS, false},
              {"assembly", "path", PLAIN, false},
              {"satin conductor", "path", PLAIN, false},
              {"rough glass", "path", OPTICS, false},
              {"telecentric backlight", "path", OPTICS, false},
              {"sky", "path", PLAIN, false},
              {"absorbing", "volpath", OPTICS, false},
              {"cube", "path", OPTICS, false},
              {"area", "path", PLAIN, true},
              {"narrow cone", "path", CONE, true}};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* --- Mitsuba ------------------------------------------------------------------------------------------------------ */

enum { LLVM, SCALAR, VARIANTS };
static const char *const variants[VARIANTS] = {"llvm_ad_rgb", "scalar_rgb"};
static const char *const samplers[] = {"independent", "multijitter", "ldsampler"};
enum { SAMPLERS = 3 };

typedef struct peer {
    FILE *to, *from;
    pid_t process;
} peer;

static mcv_result peer_open(const char *variant, const char *mesh_path, peer *p, mcv_error *error) {
    int to[2], from[2];
    if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0) return mcv_fail(error, MCV_FAILED, "no pipe to Mitsuba");
    p->process = fork();
    if (p->process < 0) return mcv_fail(error, MCV_FAILED, "no process for Mitsuba");
    if (p->process == 0) {
        dup2(to[0], STDIN_FILENO);
        dup2(from[1], STDOUT_FILENO);
        execl(PYTHON, PYTHON, MCV_SOURCE_DIR "/bench/render_peer.py", variant, mesh_path, (char *)NULL);
        _exit(127);
    }
    close(to[0]);
    close(from[1]);
    p->to = fdopen(to[1], "w");
    p->from = fdopen(from[0], "r");
    return p->to && p->from ? MCV_OK : mcv_fail(error, MCV_FAILED, "no pipe to Mitsuba");
}

static void peer_close(peer *p) {
    if (p->to) fclose(p->to);
    if (p->from) fclose(p->from);
    if (p->process > 0) waitpid(p->process, NULL, 0);
}

/* --- one image of one renderer ------------------------------------------------------------------------------------- */

typedef struct image_maker {
    peer *peer; /* NULL: ours */
    const char *scene_name, *integrator, *sampler;
    mcv_renderer *renderer;
    const mcv_scene *scene;
    bool is_plain; /* random numbers, no light paths, no splitting */
    bool is_adaptive;
    uint32_t replicates;   /* of ours */
    const mcv_film *truth; /* of its own renderer */
    double truth_variance; /* of a value, on average */
    uint32_t pixels, samples, seed;
    double squares; /* mean squared errors, summed over `images` */
    int images;
} image_maker;

static mcv_result peer_image(const image_maker *m, double *values, size_t count, mcv_error *error) {
    fprintf(m->peer->to, "%u %s %s %u %u %s\n", m->pixels, m->integrator, m->sampler, m->samples, m->seed, m->scene_name);
    fflush(m->peer->to);
    if (fread(values, sizeof *values, count, m->peer->from) != count)
        return mcv_fail(error, MCV_FAILED, "%s: Mitsuba's %s with %s gave no image", m->scene_name, m->integrator, m->sampler);
    return MCV_OK;
}

static mcv_result our_image(const image_maker *m, uint32_t replicates, mcv_film *film, mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    options.replicates = replicates;
    options.last = m->samples;
    options.seed = m->seed;
    options.depth = SURFACES;
    if (m->is_plain) options.sampler = MCV_SAMPLER_RANDOM;
    options.no_light_paths = options.no_split = m->is_plain;
    options.adaptive = m->is_adaptive && replicates == m->replicates; /* not the truth */
    return mcv_renderer_render(m->renderer, m->scene, 0, &options, film, &stats, error);
}

/* A bench_side: an image of the next seed, and its error. */
static mcv_result make_image(void *user, mcv_error *error) {
    image_maker *m = user;
    mcv_film film = {0};
    ++m->seed;
    if (m->peer) {
        MCV_TRY(mcv_film_new(&film, m->pixels, m->pixels, 3, 1, error));
        film.samples = 1;
    }
    mcv_result result = m->peer ? peer_image(m, film.sums, film_values(&film), error) : our_image(m, m->replicates, &film, error);
    if (result == MCV_OK) {
        const double rmse = errors_against(&film, m->truth).rmse;
        m->squares += rmse * rmse - m->truth_variance;
        ++m->images;
    }
    mcv_film_free(&film);
    return result;
}

static double rmse_of(const image_maker *m) { return sqrt(fmax(m->squares / m->images, 0)); }

/* --- truths ------------------------------------------------------------------------------------------------------- */

/* Of 64 times the samples in 16 replicates. */
static mcv_result make_truth(image_maker maker, mcv_film *film, mcv_error *error) {
    maker.samples = maker.samples * REFERENCE_FACTOR / REFERENCE_REPLICATES;
    maker.seed = REFERENCE_SEED;
    if (!maker.peer) return our_image(&maker, REFERENCE_REPLICATES, film, error);
    MCV_TRY(mcv_film_new(film, maker.pixels, maker.pixels, 3, REFERENCE_REPLICATES, error));
    film->samples = 1;
    for (uint32_t r = 0; r < REFERENCE_REPLICATES; ++r, ++maker.seed)
        MCV_TRY(peer_image(&maker, film->sums + r * film_values(film), film_values(film), error));
    return MCV_OK;
}

static double variance_of(const mcv_film *film) {
    const double standard_error = mcv_film_relative_error(film) * mcv_film_mean(film);
    return standard_error * standard_error;
}

/* --- one scene ---------------------------------------------------------------------------------------------------- */

typedef struct race {
    peer peers[VARIANTS];
    mcv_mesh assembly;
    bench_mean speed, time, time_of[CONE + 1];
} race;

/* The exponent of RMSE ~ samples^-exponent between a quarter of the samples and all. It cannot be below that of random numbers: what
 * seems to be is the noise of rare paths. */
static mcv_result exponent_of(const bench *b, const image_maker *full, double *exponent, mcv_error *error) {
    image_maker quarter = *full;
    quarter.samples /= 4;
    quarter.squares = quarter.images = 0;
    quarter.seed += 1000;
    for (int i = 0; i < b->repetitions; ++i) MCV_TRY(make_image(&quarter, error));
    *exponent = fmin(fmax(log(rmse_of(&quarter) / rmse_of(full)) / log(4), 0.5), 1);
    return MCV_OK;
}

static double seconds_to(double rmse, const bench *b, const bench_side *side, double exponent) {
    return bench_side_median(b, side, BENCH_WALL) * pow(rmse_of(side->user) / rmse, 1 / exponent);
}

static mcv_result race_sides(bench *b, race *r, int scene, bench_side *sides, size_t count, mcv_error *error) {
    const image_maker *ours = sides[0].user;
    const double values = (double)ours->samples * ours->pixels * ours->pixels;
    size_t fastest = 1, first = 1;
    double our_exponent, least_ratio = INFINITY, our_seconds = 0, peer_seconds = 0;
    MCV_TRY(bench_time(b, sides, count, error));
    MCV_TRY(exponent_of(b, ours, &our_exponent, error));
    for (size_t i = 1; i < count; ++i) {
        const image_maker *m = sides[i].user;
        const char *variant = m->peer == r->peers + LLVM ? "llvm" : "scalar";
        double exponent;
        MCV_TRY(exponent_of(b, m, &exponent, error));
        const double target = sqrt(rmse_of(ours) * rmse_of(m));
        const double mine = seconds_to(target, b, sides, our_exponent), theirs = seconds_to(target, b, sides + i, exponent);
        bench_row(b, BENCH_WALL, sides, sides + i, values, "Msamples/s", "%s, %s %s %s", ours->scene_name, m->integrator, variant,
                  m->sampler);
        bench_more(b, "samples", ours->samples);
        bench_more(b, "seconds", bench_side_median(b, sides, BENCH_WALL));
        bench_more(b, "peer_seconds", bench_side_median(b, sides + i, BENCH_WALL));
        bench_more(b, "rmse", rmse_of(ours) / mcv_film_mean(ours->truth));
        bench_more(b, "peer_rmse", rmse_of(m) / mcv_film_mean(m->truth));
        bench_more(b, "exponent", our_exponent);
        bench_more(b, "peer_exponent", exponent);
        bench_more(b, "time_to_rmse", theirs / mine);
        if (bench_side_median(b, sides + i, BENCH_WALL) < bench_side_median(b, sides + fastest, BENCH_WALL)) fastest = i;
        if (theirs / mine < least_ratio) {
            least_ratio = theirs / mine;
            first = i;
            our_seconds = mine;
            peer_seconds = theirs;
        }
    }
    bench_mean_add(&r->speed, bench_side_median(b, sides + fastest, BENCH_WALL) / bench_side_median(b, sides, BENCH_WALL));
    const image_maker *best = sides[first].user;
    bench_number(b, our_seconds, peer_seconds, "s", "%s, time to RMSE %.2g %%", ours->scene_name,
                 100 * sqrt(rmse_of(ours) * rmse_of(best)) / mcv_film_mean(ours->truth));
    bench_mean_add(&r->time, least_ratio);
    bench_mean_add(&r->time_of[scenes[scene].group], least_ratio);
    return MCV_OK;
}

static mcv_result race_scene(bench *b, race *r, int scene, const image_maker *base, mcv_film truths[2], mcv_error *error) {
    image_maker makers[MOST_SIDES], theirs = *base;
    bench_side sides[MOST_SIDES];
    mcv_comparison c;
    size_t count = 1;
    theirs.peer = r->peers + LLVM;
    theirs.integrator = scenes[scene].integrator;
    theirs.sampler = samplers[1];
    MCV_TRY(make_truth(*base, truths, error));
    MCV_TRY(make_truth(theirs, truths + 1, error));
    MCV_TRY(mcv_compare_films(truths, truths + 1, &c, error));
    printf("%s: means %.6g and %.6g; %s\n", base->scene_name, c.mean_x, c.mean_y, c.reason);
    bench_number(b, c.mean_x, c.mean_y, "mean", "%s, %s", base->scene_name, c.different ? "pictures differ" : "pictures agree");
    if (c.different) return MCV_OK;
    makers[0] = *base;
    makers[0].truth = truths;
    makers[0].truth_variance = variance_of(truths);
    theirs.truth = truths + 1;
    theirs.truth_variance = variance_of(truths + 1);
    for (int v = 0; v < VARIANTS; ++v)
        for (int s = 0; s < SAMPLERS; ++s, ++count) {
            makers[count] = theirs;
            makers[count].peer = r->peers + v;
            makers[count].sampler = samplers[s];
        }
    for (int v = 0; v < VARIANTS && scenes[scene].is_seen_diffuse; ++v, ++count) {
        makers[count] = theirs;
        makers[count].peer = r->peers + v;
        makers[count].integrator = "ptracer";
        makers[count].sampler = samplers[0];
    }
    for (size_t i = 0; i < count; ++i) sides[i] = (bench_side){.run = make_image, .user = makers + i};
    return race_sides(b, r, scene, sides, count, error);
}

static mcv_result open_scene(bench *b, race *r, int i, mcv_error *error) {
    const bool is_assembly = strcmp(scenes[i].name, "assembly") == 0;
    image_maker base = {.scene_name = scenes[i].name, .pixels = b->quick ? 64 : 96, .samples = b->quick ? 16 : 64};
    mcv_scene *scene = make_peer_scene(scenes[i].name, base.pixels, true, is_assembly ? &r->assembly : NULL);
    mcv_film truths[2] = {{0}, {0}};
    base.scene = scene;
    base.replicates = 1;
    base.renderer = mcv_renderer_new();
    mcv_result result = base.renderer ? race_scene(b, r, i, &base, truths, error) : mcv_fail(error, MCV_FAILED, "no memory for a renderer");
    for (int k = 0; k < 2; ++k) mcv_film_free(truths + k);
    mcv_renderer_free(base.renderer);
    mcv_scene_free(scene);
    return result;
}

/* --- sampling alone --------------------------------------------------------------------------------------------- */

/* RMSE x √seconds of the other way to sample over that of the usual one. */
static mcv_result measure_gain(bench *b, image_maker *usual, image_maker *other, const char *what, const char *key, mcv_error *error) {
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
    const double gain = bench_number(b, rmse_of(usual) * sqrt(bench_side_median(b, sides, BENCH_WALL)),
                                     rmse_of(other) * sqrt(bench_side_median(b, sides + 1, BENCH_WALL)), "RMSE √s", "%s, sampling alone",
                                     usual->scene_name);
    bench_summary(b, key, gain);
    return MCV_OK;
}

static mcv_result measure_gain_on(bench *b, mcv_scene *scene, image_maker usual, const char *what, const char *key, mcv_error *error) {
    mcv_film truth = {0};
    usual.scene = scene;
    usual.renderer = mcv_renderer_new();
    mcv_result result = usual.renderer ? make_truth(usual, &truth, error) : mcv_fail(error, MCV_FAILED, "no memory for a renderer");
    usual.truth = &truth;
    image_maker other = usual;
    other.is_plain = !usual.is_adaptive;
    other.is_adaptive = false;
    if (result == MCV_OK) result = measure_gain(b, &usual, &other, what, key, error);
    mcv_film_free(&truth);
    mcv_renderer_free(usual.renderer);
    mcv_scene_free(scene);
    return result;
}

static mcv_result gain(bench *b, mcv_error *error) {
    const image_maker usual = {.scene_name = "report-clean", .samples = b->quick ? 256 : 1024, .replicates = 1};
    mcv_scene *scene;
    MCV_TRY(load_small("report-clean.glb", &scene, error));
    return measure_gain_on(b, scene, usual, "random points without light paths", "sampling_gain", error);
}

static mcv_result adaptive_gain(bench *b, mcv_error *error) {
    const image_maker adaptive = {.scene_name = "part-backlight", .samples = 64, .replicates = 4, .is_adaptive = true};
    mcv_scene *scene;
    MCV_TRY(load_small("part-backlight.gltf", &scene, error));
    mcv_telecentric_params *p = &scene->sensors[0].as.telecentric;
    shrink_film(p->resolution, p->pixelSize, b->quick ? 64 : 128, b->quick ? 48 : 96);
    return measure_gain_on(b, scene, adaptive, "the same samples for all pixels", "adaptive_gain", error);
}

/* --- all -------------------------------------------------------------------------------------------------------- */

static mcv_result write_ply(const mesh *m, const char *path, mcv_error *error) {
    FILE *file = fopen(path, "w");
    if (!file) return mcv_fail(error, MCV_FAILED, "%s: cannot be written", path);
    fprintf(file, "ply\nformat ascii 1.0\nelement vertex %u\nproperty float x\nproperty float y\nproperty float z\n", m->vertex_count);
    fprintf(file, "element face %u\nproperty list uchar int vertex_indices\nend_header\n", m->triangle_count);
    for (uint32_t i = 0; i < m->vertex_count; ++i)
        fprintf(file, "%.9g %.9g %.9g\n", (double)m->positions[3 * i], (double)m->positions[3 * i + 1], (double)m->positions[3 * i + 2]);
    for (uint32_t i = 0; i < m->triangle_count; ++i)
        fprintf(file, "3 %u %u %u\n", m->indices[3 * i], m->indices[3 * i + 1], m->indices[3 * i + 2]);
    return fclose(file) == 0 ? MCV_OK : mcv_fail(error, MCV_FAILED, "%s: cannot be written", path);
}

static void note_mean(bench *b, const char *key, const bench_mean *mean) {
    if (mean->count) bench_summary(b, key, bench_mean_value(mean));
}

static mcv_result race_all(bench *b, race *r, const mesh *assembly, mcv_error *error) {
    char path[sizeof b->stem + 16];
    snprintf(path, sizeof path, "%s-assembly.ply", b->stem);
    MCV_TRY(write_ply(assembly, path, error));
    for (int v = 0; v < VARIANTS; ++v) MCV_TRY(peer_open(variants[v], path, r->peers + v, error));
    r->assembly = (mcv_mesh){.vertex_count = assembly->vertex_count,
                             .triangle_count = assembly->triangle_count,
                             .positions = assembly->positions,
                             .indices = assembly->indices};
    for (int i = 0; i < SCENES; ++i)
        if (!b->only || strstr(scenes[i].name, b->only)) MCV_TRY(open_scene(b, r, i, error));
    note_mean(b, "samples_per_second", &r->speed);
    note_mean(b, "time_to_rmse", &r->time);
    note_mean(b, "time_to_rmse_optics", r->time_of + OPTICS);
    note_mean(b, "time_to_rmse_cone", r->time_of + CONE);
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
    for (int v = 0; v < VARIANTS; ++v) peer_close(r.peers + v);
    mesh_free(&assembly.mesh);
    return result;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "render", run); }
