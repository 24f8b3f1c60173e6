/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Our own reading of an OpenEXR header and its chunk tables (the OpenEXR File Layout document), so
 * that only files whose every size and offset holds reach the library.
 */
#ifndef MCVISI_HOST_IO_EXR_HEADER_H
#define MCVISI_HOST_IO_EXR_HEADER_H

#include "io/exr.h"

typedef struct mcv_exr_channel {
    char name[MCV_EXR_NAME];
    uint32_t bytes; /* per pixel in the file: 2 half, 4 float or integer */
} mcv_exr_channel;

typedef struct mcv_exr_part_header {
    char name[MCV_EXR_NAME];
    int32_t y_min;
    uint32_t width, height;
    uint32_t channel_count;
    mcv_exr_channel channels[MCV_EXR_MAX_CHANNELS];
    uint32_t compression;
    uint32_t chunk_count;
} mcv_exr_part_header;

typedef struct mcv_exr_header {
    mcv_exr_part_header *parts;
    uint32_t part_count;
    mcv_attribute *attributes; /* of part 0; owned */
    uint32_t attribute_count;
} mcv_exr_header;

/* Lines that one chunk holds. */
uint32_t mcv_exr_lines_per_chunk(uint32_t compression);

/*
 * Fills the header from a whole file in memory, or says what is wrong (MCV_BAD_INPUT, naming path).
 * After success every chunk lies in the file, in its place, and can hold the pixels that the header
 * promises.
 */
mcv_result mcv_exr_header_read(const char *path, const uint8_t *bytes, size_t size,
                               mcv_exr_header *header, mcv_error *error);
void mcv_exr_header_free(mcv_exr_header *header);

#endif
