/* SPDX-License-Identifier: Apache-2.0 */
#include "recorder.h"

#include <stdlib.h>
#include <string.h>

#include "device/features.h"

void recorder_field_words(const mcv_packed *packed, uint32_t words[FIELD_COUNT]) {
    MCV_FEATURE_VARIABLES(packed->features)
    words[FIELD_END] = 0;
#define MCV_CHANNELS packed->channels
#define MCV_X(field, count) words[FIELD_##field] = (count);
    MCV_PATH_FIELDS(MCV_X)
#undef MCV_X
#undef MCV_CHANNELS
}

static mcv_result list_reserve(ray_list *list, size_t more, mcv_error *error) {
    if (list->count + more <= list->capacity) return MCV_OK;
    list->capacity =
        2 * list->capacity > list->count + more ? 2 * list->capacity : list->count + more;
    batch_ray *rays = realloc(list->rays, list->capacity * sizeof *rays);
    if (rays) list->rays = rays;
    mcv_hit *hits = realloc(list->hits, list->capacity * sizeof *hits);
    if (hits) list->hits = hits;
    uint32_t *paths = realloc(list->paths, list->capacity * sizeof *paths);
    if (paths) list->paths = paths;
    if (rays && hits && paths) return MCV_OK;
    (void)mcv_fail(error, MCV_FAILED, "no memory for the rays of a launch");
    return MCV_FAILED;
}

void ray_list_free(ray_list *list) {
    free(list->rays);
    free(list->hits);
    free(list->paths);
    *list = (ray_list){0};
}

/* From depth after depth to slice after slice, in which depth after depth. */
static mcv_result list_by_slice(ray_list *list, uint32_t slice, uint32_t slices, mcv_error *error) {
    ray_list sorted = {0};
    if (list->count == 0) return MCV_OK;
    size_t *next = calloc(slices + 1, sizeof *next);
    if (!next) return mcv_fail(error, MCV_FAILED, "no memory to sort rays");
    mcv_result result = list_reserve(&sorted, list->count, error);
    for (size_t i = 0; result == MCV_OK && i < list->count; ++i) ++next[list->paths[i] / slice + 1];
    for (uint32_t i = 0; result == MCV_OK && i < slices; ++i) next[i + 1] += next[i];
    for (size_t i = 0; result == MCV_OK && i < list->count; ++i) {
        const size_t place = next[list->paths[i] / slice]++;
        sorted.rays[place] = list->rays[i];
        sorted.hits[place] = list->hits[i];
        sorted.paths[place] = list->paths[i];
    }
    free(next);
    sorted.count = list->count;
    ray_list_free(list);
    *list = sorted;
    return result;
}

/* The stream schedule of a drive, stage by stage. */
typedef struct recorder {
    drive *d;
    uint32_t offsets[FIELD_COUNT]; /* words */
    uint32_t *queue, *rows;        /* room for a queue and for seven rows of the state */
    ray_list *lists;
    mcv_error *error;
} recorder;

static mcv_result run_stage(const recorder *r, uint32_t kernel, cl_uint depth) {
    mcv_schedule *s = &r->d->schedule;
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 7];
    mcv_device_scene_arguments(s->scene, arguments);
    const mcv_arg own[] = {MCV_ARG(s->paths),  MCV_ARG(s->sums),    MCV_ARG(s->counters),
                           MCV_ARG(s->queues), MCV_ARG(s->lengths), MCV_ARG(s->capacity),
                           MCV_ARG(depth)};
    memcpy(arguments + MCV_SCENE_ARGUMENTS, own, sizeof own);
    return mcv_cl_launch(s->cl, s->kernels[kernel], r->d->frame.path_count, 64, arguments,
                         MCV_SCENE_ARGUMENTS + 7, NULL, r->error);
}

static int by_number(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* The paths of a queue, in their order. */
static mcv_result read_queue(const recorder *r, uint32_t queue, uint32_t length_at,
                             uint32_t *count) {
    const mcv_schedule *s = &r->d->schedule;
    MCV_TRY(
        mcv_cl_read(s->cl, s->lengths, sizeof *count * length_at, sizeof *count, count, r->error));
    MCV_TRY(mcv_cl_read(s->cl, s->queues, sizeof(cl_uint) * queue * s->capacity,
                        sizeof(cl_uint) * *count, r->queue, r->error));
    qsort(r->queue, *count, sizeof *r->queue, by_number);
    return MCV_OK;
}

static mcv_result read_rows(const recorder *r, int field, uint32_t words, uint32_t row) {
    const mcv_schedule *s = &r->d->schedule;
    const size_t paths = r->d->frame.path_count;
    for (uint32_t k = 0; k < words; ++k) {
        MCV_TRY(mcv_cl_read(s->cl, s->paths,
                            sizeof(cl_uint) * (r->offsets[field] + k) * s->capacity,
                            sizeof(cl_uint) * paths, r->rows + (row + k) * paths, r->error));
    }
    return MCV_OK;
}

/* Appends the rays that rows 0 … 5 hold for the paths in the queue. Shadow rays with the target in
 * row 6 are of two kinds. */
static mcv_result append_rays(const recorder *r, uint32_t count, bool shadow, int kind) {
    const size_t paths = r->d->frame.path_count;
    for (int k = 0; k < RECORDED_KINDS; ++k) MCV_TRY(list_reserve(r->lists + k, count, r->error));
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t path = r->queue[i];
        const bool any = shadow && r->rows[6 * paths + path] >= MCV_SKY;
        ray_list *list =
            r->lists + (shadow ? any ? RECORDED_SHADOW_ANY : RECORDED_SHADOW_CLOSEST : kind);
        batch_ray *ray = list->rays + list->count;
        for (size_t k = 0; k < 3; ++k) {
            memcpy(ray->origin + k, r->rows + k * paths + path, 4);
            memcpy(ray->direction + k, r->rows + (3 + k) * paths + path, 4);
        }
        ray->t_max = any && r->rows[6 * paths + path] == MCV_NONE ? 1.0f : INFINITY;
        list->paths[list->count++] = path;
    }
    return MCV_OK;
}

/* The hits of the `count` rays that were appended last. */
static mcv_result append_hits(const recorder *r, uint32_t count, int kind) {
    const size_t paths = r->d->frame.path_count;
    ray_list *list = r->lists + kind;
    MCV_TRY(read_rows(r, FIELD_hit, 4, 0));
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t words[4];
        for (size_t k = 0; k < 4; ++k) words[k] = r->rows[k * paths + r->queue[i]];
        memcpy(list->hits + list->count - count + i, words, sizeof words);
    }
    return MCV_OK;
}

static mcv_result record_depth(const recorder *r, uint32_t depth, uint32_t *count) {
    const drive *d = r->d;
    const int kind = depth > 0 ? RECORDED_LATER : RECORDED_FIRST;
    MCV_TRY(read_queue(r, depth & 1, depth, count));
    if (*count == 0) return MCV_OK;
    MCV_TRY(read_rows(r, FIELD_origin, 3, 0));
    MCV_TRY(read_rows(r, FIELD_direction, 3, 3));
    MCV_TRY(append_rays(r, *count, false, kind));
    MCV_TRY(run_stage(r, MCV_KERNEL_intersect_closest, depth));
    MCV_TRY(append_hits(r, *count, kind));
    if (d->schedule.kernels[MCV_KERNEL_sample_emitters] && depth + 1 < d->frame.depth) {
        uint32_t shadows;
        MCV_TRY(run_stage(r, MCV_KERNEL_sample_emitters, depth));
        MCV_TRY(read_queue(r, 2, d->frame.depth + 1 + depth, &shadows));
        MCV_TRY(read_rows(r, FIELD_shadow_origin, 3, 0));
        MCV_TRY(read_rows(r, FIELD_shadow_direction, 3, 3));
        MCV_TRY(read_rows(r, FIELD_shadow_target, 1, 6));
        MCV_TRY(append_rays(r, shadows, true, 0));
    }
    return run_stage(r, MCV_KERNEL_shade_surfaces, depth);
}

static mcv_result record(recorder *r) {
    mcv_schedule *s = &r->d->schedule;
    const size_t lengths = 2 * sizeof(cl_uint) * (s->depth + 1);
    uint32_t words[FIELD_COUNT], offset = 0, count = 1;
    recorder_field_words(&r->d->device.packed, words);
    for (int i = 0; i < FIELD_COUNT; offset += words[i++]) r->offsets[i] = offset;
    MCV_TRY(mcv_cl_write(s->cl, s->scene->frame, 0, sizeof r->d->frame, &r->d->frame, r->error));
    MCV_TRY(mcv_cl_clear(s->cl, s->lengths, lengths, r->error));
    MCV_TRY(run_stage(r, MCV_KERNEL_generate_rays, 0));
    for (uint32_t depth = 0; depth < s->depth && count > 0; ++depth)
        MCV_TRY(record_depth(r, depth, &count));
    return MCV_OK;
}

mcv_result record_rays(drive *d, uint32_t slice, ray_list lists[RECORDED_KINDS], mcv_error *error) {
    const size_t paths = d->frame.path_count;
    recorder r = {.d = d,
                  .lists = lists,
                  .error = error,
                  .queue = malloc(4 * paths),
                  .rows = malloc(7 * 4 * paths)};
    mcv_result result =
        r.queue && r.rows ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory to record rays");
    if (result == MCV_OK) result = record(&r);
    free(r.queue);
    free(r.rows);
    for (int k = 0; k < RECORDED_KINDS && result == MCV_OK; ++k)
        result = list_by_slice(lists + k, slice, (uint32_t)((paths + slice - 1) / slice), error);
    return result;
}
