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
    bool tiled;
    uint32_t tile_width, tile_height; /* at most those of the image */
    uint32_t level_mode;              /* MCV_EXR_ONE_LEVEL … */
    bool round_up;                    /* sizes of levels are rounded up */
} mcv_exr_part_header;

/* OpenEXR's numbers. */
enum { MCV_EXR_ONE_LEVEL, MCV_EXR_MIPMAP, MCV_EXR_RIPMAP };
enum {
    MCV_EXR_NONE,
    MCV_EXR_RLE,
    MCV_EXR_ZIPS,
    MCV_EXR_ZIP,
    MCV_EXR_PIZ,
    MCV_EXR_PXR24,
    MCV_EXR_B44,
    MCV_EXR_B44A,
    MCV_EXR_DWAA,
    MCV_EXR_DWAB,
    MCV_EXR_COMPRESSIONS
};

typedef struct mcv_exr_header {
    mcv_exr_part_header *parts;
    uint32_t part_count;
    mcv_attribute *attributes; /* of part 0; owned */
    uint32_t attribute_count;
    uint64_t attribute_bytes; /* of all parts */
} mcv_exr_header;

/*
 * Fills the header from a whole file in memory, or says what is wrong (MCV_BAD_INPUT, naming path).
 * After success every chunk lies in the file, in its place, and can hold the pixels that the header
 * promises.
 */
mcv_result mcv_exr_header_read(const char *path, const uint8_t *bytes, size_t size,
                               mcv_exr_header *header, mcv_error *error);
void mcv_exr_header_free(mcv_exr_header *header);

/*
 * Gives all attributes that decoding does not need a type that OpenEXR does not know, in a file
 * whose header was read. OpenEXR then keeps their bytes as they are. It takes those of known types
 * by what they say of themselves: a preview or a manifest of 20 bytes asks for gigabytes, and an
 * integer of 8 bytes moves all that follows. Tiles get the sizes of the header.
 */
void mcv_exr_simplify(uint8_t *bytes, size_t size, const mcv_exr_header *header);

/* The bytes that reading takes beside the file: of pixels, of attributes, and of what OpenEXR keeps
 * of each part until it has read all. */
uint64_t mcv_exr_reading_bytes(const mcv_exr_header *header);

/* A file in memory while its header is read: `at` is the next byte. */
typedef struct mcv_exr_reader {
    const char *path;
    const uint8_t *bytes;
    size_t size, at;
    bool multi_part, long_names, tiled;
    mcv_error *error;
} mcv_exr_reader;

/* An attribute as the file has it. */
typedef struct mcv_exr_raw {
    const char *name, *type;
    const uint8_t *value;
    uint32_t size;
} mcv_exr_raw;

/* Behind the first eight bytes, with what their flags say; at 0 where the file has fewer. */
mcv_exr_reader mcv_exr_reader_begin(const char *path, const uint8_t *bytes, size_t size,
                                    mcv_error *error);

/* The next count bytes, or NULL where the file has fewer. */
const uint8_t *mcv_exr_take(mcv_exr_reader *r, size_t count);
mcv_result mcv_exr_damaged(const mcv_exr_reader *r, const char *what);

/* The next attribute; the empty name that ends a part's has no value. False where the file ends. */
bool mcv_exr_take_attribute(mcv_exr_reader *r, mcv_exr_raw *a);

/* exr_attributes.c: what is wrong with the type or size of an attribute that decoding needs, or
 * NULL. */
const char *mcv_exr_wrong_attribute(const mcv_exr_raw *a);

/* Little endian numbers. */
uint32_t mcv_exr_u32(const uint8_t *b);
int32_t mcv_exr_i32(const uint8_t *b);
uint64_t mcv_exr_u64(const uint8_t *b);

/* exr_chunks.c: the chunks of a part, at most 2^32 - 1. */
uint32_t mcv_exr_count_chunks(const mcv_exr_part_header *part);

/* exr_chunks.c: reads the tables of chunk offsets, which follow the headers, and checks every
 * chunk. */
mcv_result mcv_exr_check_chunks(mcv_exr_reader *r, const mcv_exr_header *header);

#endif
