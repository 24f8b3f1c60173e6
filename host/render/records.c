/* SPDX-License-Identifier: Apache-2.0 */
/* The records of a launch: which element of an emitter has brought what to a pixel
 * (kernels/stage/record_light.h). */
#include "render/renderer.h"

#include <stdlib.h>

#define COUNT_BYTES (sizeof(cl_uint) * MCV_RECORD_COUNT_WORDS)

enum { RECORD_BYTES = 1 << 26 };

static size_t record_bytes(const mcv_renderer *r) {
    return sizeof(cl_uint) * MCV_RECORD_WORDS(r->film->channels);
}

mcv_result mcv_open_records(mcv_renderer *r) {
    if (!r->options->records) return MCV_OK;
    size_t bytes = r->options->records->bytes > 0 ? r->options->records->bytes : RECORD_BYTES;
    if (bytes > r->cl.largest_allocation / 4) bytes = r->cl.largest_allocation / 4;
    r->frame.record_capacity = (uint32_t)((bytes - COUNT_BYTES) / record_bytes(r));
    r->frame.splat_weight =
        (float)(mcv_frame_splat_value(&r->frame) * (double)r->frame.splat_scale);
    r->records = malloc(bytes);
    if (!r->records) return mcv_fail(r->error, MCV_FAILED, "no memory for the records of a launch");
    mcv_cl_release(&r->scene.records);
    return mcv_cl_buffer(&r->cl, "the records of a launch", bytes, NULL, &r->scene.records,
                         r->error);
}

mcv_result mcv_clear_records(mcv_renderer *r) {
    const cl_uint none[MCV_RECORD_COUNT_WORDS] = {0};
    if (r->frame.record_capacity == 0) return MCV_OK;
    return mcv_cl_write(&r->cl, r->scene.records, 0, COUNT_BYTES, none, r->error);
}

/* Repeats the launch for so many of its sets, or for one set for so many of its samples. Its sums
 * and what it counts are known already. */
static mcv_result repeat(mcv_renderer *r, uint32_t sets, uint32_t log2_samples) {
    const mcv_render_stats before = *r->stats;
    r->frame.log2_samples = log2_samples;
    r->frame.path_count = sets << log2_samples;
    MCV_TRY(mcv_clear_records(r));
    MCV_TRY(mcv_schedule_start(&r->schedule, &r->frame, r->stats, r->error));
    MCV_TRY(mcv_schedule_wait(&r->schedule, r->stats, r->error));
    MCV_TRY(mcv_read_records(r));
    *r->stats = before;
    return MCV_OK;
}

static mcv_result repeat_in_halves(mcv_renderer *r) {
    const mcv_frame whole = r->frame;
    const uint32_t sets = whole.path_count >> whole.log2_samples;
    mcv_result result;
    if (sets > 1) {
        r->recording_sets = sets / 2;
        result = repeat(r, sets / 2, whole.log2_samples);
        r->frame.first_set += sets / 2;
        if (result == MCV_OK) result = repeat(r, sets - sets / 2, whole.log2_samples);
    } else if (whole.log2_samples > 0) {
        result = repeat(r, 1, whole.log2_samples - 1);
        r->frame.first_sample += 1u << (whole.log2_samples - 1);
        if (result == MCV_OK) result = repeat(r, 1, whole.log2_samples - 1);
    } else {
        result = mcv_fail(r->error, MCV_DEVICE, "%s: too little memory for the records of a path",
                          r->cl.name);
    }
    r->frame = whole;
    return result;
}

mcv_result mcv_give_records(mcv_renderer *r) {
    const mcv_record_sink *sink = r->options->records;
    const size_t count = r->record_count;
    r->record_count = 0;
    return count > 0 ? sink->take(sink->user, r->records, count, r->error) : MCV_OK;
}

mcv_result mcv_read_records(mcv_renderer *r) {
    cl_uint count;
    if (r->frame.record_capacity == 0) return MCV_OK;
    MCV_TRY(mcv_give_records(r));
    MCV_TRY(mcv_cl_read(&r->cl, r->scene.records, 0, sizeof count, &count, r->error));
    if (count > r->frame.record_capacity) return repeat_in_halves(r);
    r->record_count = count;
    if (count == 0) return MCV_OK;
    return mcv_cl_read(&r->cl, r->scene.records, COUNT_BYTES, count * record_bytes(r), r->records,
                       r->error);
}
