/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gain from compiling only what a scene needs: bench_specialise [--quick] [OUTPUT.json].
 *
 * Each scene that ships is compared with the program that has all elements and three channels (the
 * peer): seconds of a launch, bytes of a path's state, seconds to build and first launch the
 * program with PoCL's cache empty (cold) and filled (warm). The seconds from the start of a process
 * to the first sample of the report's scene are measured too, each in a process and a cache folder
 * of its own.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "drive.h"
#include "device/features.h"
#include "harness.h"
#include "loader/load.h"

static const char first_sample_scene[] = "report-clean.glb";

/* --- in a process of its own
 * ------------------------------------------------------------------------------------ */

/* And those of the processor: of this process and of those it ran. */
static void tell_seconds(double wall) {
    struct rusage self, children;
    getrusage(RUSAGE_SELF, &self);
    getrusage(RUSAGE_CHILDREN, &children);
    const struct timeval *times[] = {&self.ru_utime, &self.ru_stime, &children.ru_utime,
                                     &children.ru_stime};
    double processor = 0;
    for (int i = 0; i < 4; ++i)
        processor += (double)times[i]->tv_sec + 1e-6 * (double)times[i]->tv_usec;
    printf("%.6f %.6f\n", wall, processor);
    fflush(stdout);
}

static bool tell_first_sample(void *user, double fraction, double seconds, double error) {
    (void)seconds, (void)error;
    if (isnan(fraction)) return true; /* kernels are compiled first */
    tell_seconds(bench_now().by[BENCH_WALL] - *(const double *)user);
    _exit(0); /* the rest of the picture is of no interest */
}

static mcv_result first_sample(const char *name, double start, mcv_error *error) {
    char path[1024];
    mcv_scene *scene;
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, error));
    options.last = 1;
    options.progress = tell_first_sample;
    options.user = &start;
    return mcv_render(scene, 0, &options, &film, &stats, error);
}

static mcv_result compile(const char *name, bool all, mcv_error *error) {
    mcv_cl cl;
    mcv_scene *scene;
    drive d;
    drive_options options = drive_defaults(MCV_SCHEDULE_AUTO);
    options.all_features = all;
    MCV_TRY(load_shipped(name, 64, &scene, error));
    MCV_TRY(mcv_cl_open(NULL, &cl, error));
    MCV_TRY(drive_open(&cl, scene, options, &d, error));
    const bench_seconds launched = bench_now();
    MCV_TRY(drive_run(&d, error)); /* PoCL compiles a kernel when it is first launched */
    tell_seconds(d.seconds_program + bench_since(launched).by[BENCH_WALL]);
    return MCV_OK;
}

/* PROGRAM --child first SCENE START | --child compile SCENE specialised|all */
static int child(char **arguments) {
    mcv_error error = {""};
    const bool first = strcmp(arguments[0], "first") == 0;
    const mcv_result result = first
                                  ? first_sample(arguments[1], strtod(arguments[2], NULL), &error)
                                  : compile(arguments[1], strcmp(arguments[2], "all") == 0, &error);
    if (result != MCV_OK) fprintf(stderr, "bench_specialise: %s\n", error.text);
    return result;
}

static mcv_result ask_child(const char *program, const char *what, const char *scene,
                            const char *argument, const char *cache, bench_seconds *seconds,
                            mcv_error *error) {
    char command[4096];
    snprintf(command, sizeof command, "POCL_CACHE_DIR='%s' exec '%s' --child %s '%s' %s", cache,
             program, what, scene, argument);
    FILE *pipe = popen(command, "r");
    char line[128] = "", *wall_end = line, *cpu_end = line;
    if (pipe && fgets(line, sizeof line, pipe)) {
        seconds->by[BENCH_WALL] = strtod(line, &wall_end);
        seconds->by[BENCH_CPU] = strtod(wall_end, &cpu_end);
    }
    if (pipe) pclose(pipe);
    /* Both numbers stand there. */
    return wall_end > line && cpu_end > wall_end
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%s failed", command);
}

/* An empty folder beside the output. */
static mcv_result make_cache(const bench *b, char *folder, size_t size, mcv_error *error) {
    snprintf(folder, size, "%s-cache.XXXXXX", b->stem);
    char *made = mkdtemp(folder);
    if (!made) return mcv_fail(error, MCV_FAILED, "%s: cannot be made", folder);
    char *absolute = realpath(folder, NULL);
    if (absolute) snprintf(folder, size, "%s", absolute);
    free(absolute);
    return MCV_OK;
}

static void remove_cache(const char *folder) {
    char command[2048];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    if (system(command) != 0) fprintf(stderr, "bench_specialise: %s stays\n", folder);
}

static const char *this_program(void) {
    static char path[1024];
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
    path[length > 0 ? length : 0] = '\0';
    return path;
}

/* --- measurements
 * -----------------------------------------------------------------------------------------------
 */

/* Grey has one channel here and three equal ones there. */
static mcv_result check_sums(const char *name, const drive *own, const drive *all,
                             mcv_error *error) {
    const size_t channels = own->device.packed.channels;
    double sum = 0, difference = 0;
    for (size_t block = 0; block < own->sum_count / (2 * channels); ++block) {
        for (size_t c = 0; c < 3; ++c) {
            const double mine = own->sums[2 * (block * channels + (c < channels ? c : 0))];
            sum += mine;
            difference += fabs(mine - all->sums[2 * (3 * block + c)]);
        }
    }
    if (difference == 0) return MCV_OK;
    return mcv_fail(error, MCV_FAILED, "%s: the images differ by %g of their mean", name,
                    difference / sum);
}

static mcv_result bench_launches(bench *b, const char *name, const mcv_scene *scene,
                                 bench_mean *mean, bench_mean *of_processor, mcv_error *error) {
    drive own = {0}, all = {0};
    drive_options options = drive_defaults(MCV_SCHEDULE_AUTO);
    mcv_result result = drive_open(&b->cl, scene, options, &own, error);
    options.all_features = true;
    if (result == MCV_OK) result = drive_open(&b->cl, scene, options, &all, error);
    if (result == MCV_OK) result = drive_run(&own, error);
    if (result == MCV_OK) result = drive_run(&all, error);
    if (result == MCV_OK) result = check_sums(name, &own, &all, error);
    bench_side sides[] = {{drive_run, &own, {{{0}}}, 0}, {drive_run, &all, {{{0}}}, 0}};
    if (result == MCV_OK) result = bench_time(b, sides, 2, error);
    if (result == MCV_OK) {
        const mcv_packed *mine = &own.device.packed, *theirs = &all.device.packed;
        const double paths = (double)own.stats.paths;
        bench_mean_add(mean, bench_row(b, BENCH_WALL, sides, sides + 1, paths, "Mpaths/s",
                                       "%s, launch", name));
        bench_mean_add(of_processor, bench_row(b, BENCH_CPU, sides, sides + 1, paths, "Mpaths/s",
                                               "%s, launch, processor time", name));
        bench_number(b, 4 * mcv_path_words(mine->features, mine->channels),
                     4 * mcv_path_words(theirs->features, theirs->channels), "bytes", "%s, path",
                     name);
    }
    drive_close(&own);
    drive_close(&all);
    return result;
}

/* Once, because it takes long, and the scenes are many. The second run finds the cache filled. */
static mcv_result bench_compile(const bench *b, const char *name, mcv_error *error) {
    static const char *const programs[2] = {"specialised", "all"};
    bench once = *b;
    once.repetitions = 1;
    bench_side cold[2] = {0}, warm[2] = {0};
    for (int p = 0; p < 2; ++p) {
        char cache[1100];
        MCV_TRY(make_cache(b, cache, sizeof cache, error));
        mcv_result result =
            ask_child(this_program(), "compile", name, programs[p], cache, cold[p].seconds, error);
        if (result == MCV_OK)
            result = ask_child(this_program(), "compile", name, programs[p], cache, warm[p].seconds,
                               error);
        remove_cache(cache);
        MCV_TRY(result);
    }
    bench_row(&once, BENCH_WALL, cold, cold + 1, 0, "s", "%s, compile, cold", name);
    bench_row(&once, BENCH_WALL, warm, warm + 1, 0, "s", "%s, compile, warm", name);
    return MCV_OK;
}

static mcv_result bench_first_sample(bench *b, mcv_error *error) {
    bench_side cold = {0}, warm = {0};
    for (int r = 0; r < b->repetitions; ++r) {
        char cache[1100];
        MCV_TRY(make_cache(b, cache, sizeof cache, error));
        mcv_result result = MCV_OK;
        for (int k = 0; k < 2 && result == MCV_OK; ++k) {
            char start[32];
            snprintf(start, sizeof start, "%.6f", bench_now().by[BENCH_WALL]);
            result = ask_child(this_program(), "first", first_sample_scene, start, cache,
                               (k ? &warm : &cold)->seconds + r, error);
        }
        remove_cache(cache);
        MCV_TRY(result);
    }
    const bench_side *const sides[2] = {&cold, &warm};
    static const char *const names[2] = {"cold", "warm"};
    for (int k = 0; k < 2; ++k) {
        bench_row(b, BENCH_WALL, sides[k], NULL, 0, "s", "%s, start to first sample, %s",
                  first_sample_scene, names[k]);
        bench_row(b, BENCH_CPU, sides[k], NULL, 0, "s",
                  "%s, start to first sample, %s, processor time", first_sample_scene, names[k]);
    }
    bench_summary(b, "cold_s", bench_side_median(b, &cold, BENCH_WALL));
    bench_summary(b, "warm_s", bench_side_median(b, &warm, BENCH_WALL));
    return MCV_OK;
}

static mcv_result bench_scene(bench *b, const char *name, bench_mean *mean,
                              bench_mean *of_processor, mcv_error *error) {
    mcv_scene *scene = NULL;
    mcv_result result = load_shipped(name, b->quick ? 1 << 12 : 1 << 14, &scene, error);
    if (result == MCV_OK) result = bench_launches(b, name, scene, mean, of_processor, error);
    mcv_scene_free(scene);
    MCV_TRY(result);
    return bench_compile(b, name, error);
}

static mcv_result run(bench *b, mcv_error *error) {
    char *names[MAX_SCENES];
    size_t count;
    bench_mean mean = {0}, of_processor = {0};
    MCV_TRY(shipped_scenes(b->only, names, &count, error));
    bench_title("Programs: what the scene needs (ours) and all features (peer)");
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < count; ++i) {
        if (result == MCV_OK) result = bench_scene(b, names[i], &mean, &of_processor, error);
        free(names[i]);
    }
    MCV_TRY(result);
    MCV_TRY(bench_first_sample(b, error));
    bench_summary(b, "specialised", bench_mean_value(&mean));
    bench_summary(b, "specialised_of_processor", bench_mean_value(&of_processor));
    return MCV_OK;
}

int main(int argc, char **argv) {
    if (argc == 5 && strcmp(argv[1], "--child") == 0) return child(argv + 2);
    return bench_main(argc, argv, "specialise", run);
}
