/* SPDX-License-Identifier: Apache-2.0 */
#include "drive.h"
#include "device/features.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/sensor_find.h"
#include "harness.h"
#include "scene/sensors.h"
#include "loader/load.h"

const char *const stage_names[STAGE_COUNT] = {
#define MCV_X(stage, runs) #stage,
    MCV_STAGES(MCV_X)
#undef MCV_X
};

/* --- scenes
 * -----------------------------------------------------------------------------------------------------
 */

static int is_scene(const struct dirent *entry) {
    const char *ending = strrchr(entry->d_name, '.');
    /* The part is no scene of its own. */
    return ending && (strcmp(ending, ".gltf") == 0 || strcmp(ending, ".glb") == 0) &&
           strcmp(entry->d_name, "2CylinderEngine.glb") != 0;
}

mcv_result shipped_scenes(const char *only, char *names[MAX_SCENES], size_t *count,
                          mcv_error *error) {
    struct dirent **entries;
    *count = 0;
    const int found = scandir(MCV_SOURCE_DIR "/scenes", &entries, is_scene, alphasort);
    if (found < 0)
        return mcv_fail(error, MCV_FAILED, "%s: cannot be read", MCV_SOURCE_DIR "/scenes");
    for (int i = 0; i < found; ++i) {
        if (*count < MAX_SCENES && (!only || strstr(entries[i]->d_name, only)))
            names[(*count)++] = strdup(entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
    return *count > 0
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE, "no scene has \"%s\" in its name", only ? only : "");
}

mcv_result load_shipped(const char *name, double pixels, mcv_scene **scene, mcv_error *error) {
    char path[1024];
    uint32_t film[2];
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, error));
    if ((*scene)->sensor_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has no sensor", path);
    mcv_sensor *sensor = (*scene)->sensors;
    mcv_sensor_film_size(sensor, film, film + 1);
    const mcv_readout readout = mcv_sensor_readout(sensor);
    if (readout.film[0] != readout.size[0] || readout.film[1] != readout.size[1]) return MCV_OK;
    const double factor = sqrt(pixels / ((double)film[0] * film[1]));
    return mcv_sensor_resize(sensor, (uint64_t)lround(fmax(1, readout.size[0] * factor)),
                             (uint64_t)lround(fmax(1, readout.size[1] * factor)), *scene, error);
}

/* --- launches
 * ---------------------------------------------------------------------------------------------------
 */

drive_options drive_defaults(uint32_t schedule) {
    return (drive_options){.schedule = schedule,
                           .log2_samples = 2,
                           .first_sample = 4,
                           .depth = mcv_render_defaults().depth};
}

/*
 * The features of all elements. Left out are choices of a technique (precision, pupil guiding,
 * splitting, early roulette, light paths, emitter selection), an environment's image, which must
 * exist to be sampled, and dispersion, with which a path keeps one channel.
 */
static uint64_t all_features(const mcv_packed *packed) {
    const uint64_t not_elements = MCV_FEATURE_BIT(PUPIL_GUIDE) | MCV_FEATURE_BIT(LIGHT_TRACING) |
                                  MCV_FEATURE_BIT(ENVIRONMENT_IMAGE) | MCV_FEATURE_BIT(DISPERSION) |
                                  MCV_FEATURE_BIT(REACH) | MCV_FEATURE_BIT(SPLIT) |
                                  MCV_FEATURE_BIT(EARLY_ROULETTE) | MCV_FEATURE_BIT(MIXED);
    uint64_t features = MCV_ALL_FEATURES & ~not_elements;
    if (packed->emitter_count == 0)
        features &= ~(MCV_FEATURE_BIT(NEXT_EVENT) | MCV_FEATURE_BIT(RECTANGLE));
    return features | packed->features;
}

/* What the kernels of all features read: normals of 0 are those of flat meshes. */
static mcv_result add_buffers(mcv_cl *cl, mcv_device_scene *device, mcv_error *error) {
    mcv_packed *packed = &device->packed;
    const size_t vertices = packed->vertex_count;
    float *nothing = calloc(4 * vertices + 1, sizeof *nothing);
    if (!nothing) return mcv_fail(error, MCV_FAILED, "no memory for the buffers of all features");
    mcv_result result = MCV_OK;
    /* MCV_NONE: smooth, as they are where nothing glossy is. */
    if (!device->interface_albedos)
        memset(packed->interface_albedos, 0xff, sizeof packed->interface_albedos);
    const struct {
        cl_mem *buffer;
        size_t bytes;
        const void *data;
    } needed[] = {
        {&device->normals, 12 * vertices, nothing},
        {&device->texcoords, 8 * vertices, nothing},
        {&device->tangents, 16 * vertices, nothing},
        {&device->medium_table, sizeof packed->medium_table, packed->medium_table},
        {&device->interfaces, sizeof packed->interfaces, packed->interfaces},
        {&device->interface_albedos, sizeof packed->interface_albedos, packed->interface_albedos}};
    for (size_t i = 0; i < sizeof needed / sizeof needed[0] && result == MCV_OK; ++i) {
        if (!*needed[i].buffer)
            result = mcv_cl_buffer(cl, "a buffer of all features", needed[i].bytes, needed[i].data,
                                   needed[i].buffer, error);
    }
    free(nothing);
    return result;
}

/* Builds the program again, with its clock, and makes room for its readings. */
static mcv_result add_clock(drive *d, const mcv_render_options *options, mcv_error *error) {
    char defines[2048];
    mcv_schedule *s = &d->schedule;
    const mcv_packed *packed = &d->device.packed;
    mcv_feature_defines(packed->features, packed->channels, d->scene->sensors[0].type,
                        options->sampler, s->slice, defines, sizeof defines);
    strncat(defines, " -DMCV_CLOCK", sizeof defines - strlen(defines) - 1);
    for (int i = 0; i < MCV_STREAM_KERNEL_COUNT; ++i) {
        if (s->kernels[i]) clReleaseKernel(s->kernels[i]);
        s->kernels[i] = NULL;
    }
    clReleaseProgram(s->program);
    s->program = NULL;
    mcv_cl_release(&s->counters);
    MCV_TRY(mcv_cl_build(d->cl, "schedule/tile", defines, &s->program, error));
    if (packed->features >> MCV_FEATURE_PUPIL_GUIDE & 1)
        MCV_TRY(
            mcv_cl_kernel(s->program, "guide_pupils", &s->kernels[MCV_KERNEL_guide_pupils], error));
    MCV_TRY(mcv_cl_kernel(s->program, "render_tile", &s->kernels[MCV_KERNEL_generate_rays], error));
    const size_t slices = s->capacity / s->slice;
    return mcv_cl_buffer(d->cl, "the counters",
                         sizeof(cl_uint) * slices * (MCV_COUNTER_COUNT + STAGE_COUNT), NULL,
                         &s->counters, error);
}

mcv_result drive_open(mcv_cl *cl, const mcv_scene *scene, drive_options options, drive *d,
                      mcv_error *error) {
    mcv_render_options render = mcv_render_defaults();
    render.schedule = options.schedule;
    render.depth = options.depth;
    memset(d, 0, sizeof *d);
    d->cl = cl;
    d->scene = scene;
    MCV_TRY(mcv_device_scene_open(cl, scene, 0, &d->device, error));
    mcv_packed *packed = &d->device.packed;
    packed->features =
        mcv_decide_features(scene, packed, scene->sensors, (mcv_feature_options){0}, NULL) &
        ~(MCV_FEATURE_BIT(LIGHT_TRACING) | MCV_FEATURE_BIT(SPLIT));
    if (options.all_features) {
        packed->features = all_features(packed);
        packed->channels = 3;
        MCV_TRY(add_buffers(cl, &d->device, error));
    }
    const bench_seconds begun = bench_now();
    MCV_TRY(
        mcv_schedule_open(cl, &d->device, scene->sensors[0].type, &render, &d->schedule, error));
    d->seconds_program = bench_since(begun).by[BENCH_WALL];
    if (options.clock) MCV_TRY(add_clock(d, &render, error));
    d->clock = options.clock;

    uint32_t film[2];
    mcv_sensor_film_size(scene->sensors, film, film + 1);
    const uint32_t sets = (film[0] + 7) / 8 * ((film[1] + 7) / 8) * 64 * DRIVE_REPLICATES;
    d->frame = (mcv_frame){.width = film[0],
                           .height = film[1],
                           .replicates = DRIVE_REPLICATES,
                           .log2_samples = options.log2_samples,
                           .first_sample = options.first_sample,
                           .path_count = sets << options.log2_samples,
                           .depth = options.depth};
    if (d->frame.path_count > d->schedule.capacity)
        return mcv_fail(error, MCV_FAILED, "%s: %u paths are more than a launch holds", scene->path,
                        d->frame.path_count);
    const uint32_t block = mcv_block_size(options.log2_samples);
    d->sum_count = (size_t)2 * d->frame.path_count / block * packed->channels;
    d->sums = malloc(d->sum_count * sizeof *d->sums);
    if (!d->sums) return mcv_fail(error, MCV_FAILED, "no memory for the sums of a launch");
    MCV_TRY(mcv_device_scene_place(cl, scene, 0, &d->device, &d->frame, error));
    return mcv_schedule_guide(&d->schedule, &d->frame, &d->stats, error);
}

void drive_close(drive *d) {
    mcv_schedule_close(&d->schedule);
    mcv_device_scene_close(&d->device);
    free(d->sums);
    d->sums = NULL;
}

mcv_result drive_run(void *user, mcv_error *error) {
    drive *d = user;
    memset(&d->stats, 0, sizeof d->stats);
    MCV_TRY(mcv_schedule_start(&d->schedule, &d->frame, &d->stats, error));
    MCV_TRY(mcv_schedule_wait(&d->schedule, &d->stats, error));
    return mcv_cl_read(d->cl, d->schedule.sums, 0, d->sum_count * sizeof *d->sums, d->sums, error);
}

static size_t tick_count(const drive *d) {
    return (d->frame.path_count + d->schedule.slice - 1) / d->schedule.slice * STAGE_COUNT;
}

mcv_result drive_add_ticks(drive *d, drive_ticks *all, mcv_error *error) {
    const size_t count = tick_count(d), before = count / STAGE_COUNT * MCV_COUNTER_COUNT;
    cl_uint *ticks = malloc(count * sizeof *ticks);
    double total = 0;
    if (!ticks) return mcv_fail(error, MCV_FAILED, "no memory for the ticks");
    const mcv_result result = mcv_cl_read(d->cl, d->schedule.counters, sizeof *ticks * before,
                                          count * sizeof *ticks, ticks, error);
    for (size_t i = 0; i < count; ++i) {
        total += ticks[i];
        if (all->least && ticks[i] < all->least[i]) all->least[i] = ticks[i];
    }
    all->per_second = fmax(all->per_second, total / d->stats.stages[0].seconds);
    if (all->least)
        free(ticks);
    else
        all->least = ticks;
    return result;
}

void drive_least_seconds(const drive *d, const drive_ticks *ticks, double seconds[STAGE_COUNT]) {
    for (int k = 0; k < STAGE_COUNT; ++k) seconds[k] = 0;
    for (size_t i = 0; i < tick_count(d); ++i)
        seconds[i % STAGE_COUNT] += ticks->least[i] / ticks->per_second;
}

/* Each stage's share of the ticks of the last run, of the seconds that the launch took. */
static mcv_result clock_seconds(drive *d, double seconds[STAGE_COUNT], mcv_error *error) {
    drive_ticks ticks = {NULL, 0};
    const mcv_result result = drive_add_ticks(d, &ticks, error);
    if (result == MCV_OK) drive_least_seconds(d, &ticks, seconds);
    free(ticks.least);
    return result;
}

mcv_result drive_stage_seconds(drive *d, double seconds[STAGE_COUNT], mcv_error *error) {
    for (int i = 0; i < STAGE_COUNT; ++i) seconds[i] = 0;
    if (d->clock) return clock_seconds(d, seconds, error);
    for (uint32_t i = 0; i < d->stats.stage_count; ++i) {
        for (int k = 0; k < STAGE_COUNT; ++k) {
            if (strcmp(d->stats.stages[i].name, stage_names[k]) == 0)
                seconds[k] = d->stats.stages[i].seconds;
        }
    }
    return MCV_OK;
}
