/* SPDX-License-Identifier: Apache-2.0 */
/* The rays of a launch, for the benchmarks that follow them again without the rest of a render. */
#ifndef MCVISI_BENCH_RECORDER_H
#define MCVISI_BENCH_RECORDER_H

#include "drive.h"
#include "kernels/path/camera_path.h"
#include "rays.h"

/* The words of a path that its features ask for. */
#define MCV_X(field, words) FIELD_##field,
enum { FIELD_END, MCV_PATH_FIELDS(MCV_X) FIELD_COUNT };
#undef MCV_X

void recorder_field_words(const mcv_packed *packed, uint32_t words[FIELD_COUNT]);

/* The first rays, the later ones, shadow rays to a point and those that must meet their emitter. */
enum {
    RECORDED_FIRST,
    RECORDED_LATER,
    RECORDED_SHADOW_ANY,
    RECORDED_SHADOW_CLOSEST,
    RECORDED_KINDS
};

typedef struct ray_list {
    batch_ray *rays;
    mcv_hit *hits; /* what the render found; of shadow rays nothing */
    uint32_t *paths;
    size_t count, capacity;
} ray_list;

void ray_list_free(ray_list *list);

/* The rays of a stream drive's frame as a tile schedule with these slices would follow them. Free
 * the lists even after a failure. */
mcv_result record_rays(drive *d, uint32_t slice, ray_list lists[RECORDED_KINDS], mcv_error *error);

#endif
