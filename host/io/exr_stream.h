/* SPDX-License-Identifier: Apache-2.0 */
/* What the files that write OpenEXR share: what the library's callbacks work on, and errors. */
#ifndef MCVISI_HOST_IO_EXR_STREAM_H
#define MCVISI_HOST_IO_EXR_STREAM_H

#include "io/exr.h"

#include "core/output_file.h"

#include <openexr.h>

/* What the library's callbacks work on. */
typedef struct mcv_exr_stream {
    const char *path;
    mcv_output *output;
    mcv_error *error;
    char message[512]; /* the library's last one */
    mcv_result result; /* of mcv_output_write_at, which knows more than the library */
} mcv_exr_stream;

#define MCV_TRY_EXR(call) \
    do { \
        const exr_result_t try_result = (call); \
        if (try_result != EXR_ERR_SUCCESS) return try_result; \
    } while (0)

void mcv_exr_on_error(exr_const_context_t context, exr_result_t code, const char *message);

/* Turns a failed call into the sentence for the user; what our own callback has written stands. */
mcv_result mcv_exr_failed(mcv_exr_stream *s, mcv_result code, exr_result_t result);

const char *mcv_exr_channel_name(const mcv_exr_part *part, uint32_t channel);

/* Points the library's channels at row `row` of the planes. The library sorts channels by name:
 * they are found by it. */
bool mcv_exr_attach_planes(exr_coding_channel_info_t *channels, int count, const mcv_exr_part *part,
                           uint32_t row);

#endif
