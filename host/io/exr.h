/* SPDX-License-Identifier: Apache-2.0 */
/*
 * OpenEXR: images in lines, of float, ZIP, one part or several; what is written is read back bit
 * for bit (-0, denormals, NaN, ∞). Part 0 is what viewers show. The attributes in its header hold
 * all that is needed to repeat a render.
 */
#ifndef MCVISI_HOST_IO_EXR_H
#define MCVISI_HOST_IO_EXR_H

#include "film/film.h"

/* Names of attributes, channels and parts have at most 255 bytes; files with attribute names above
 * 31 bytes cannot be read by programs older than OpenEXR 1.7, so such names are refused on writing.
 */
enum {
    MCV_EXR_NAME = 256,
    MCV_EXR_ATTRIBUTE_NAME = 32,
    MCV_EXR_MAX_CHANNELS = 64,
    MCV_EXR_MAX_PARTS = 128,
    MCV_EXR_MAX_SIDE = 32768
};

/* The largest file that is read: bytes of its pixels as float. */
#define MCV_EXR_MAX_BYTES ((uint64_t)1 << 32)

/* A text, or count numbers: 1, 2, 4 (of which float32 remains) or 16 (a matrix by rows). */
typedef struct mcv_attribute {
    const char *name;
    const char *text; /* NULL: numbers */
    double numbers[16];
    uint32_t count;
} mcv_attribute;

typedef struct mcv_exr_part {
    const char *name; /* unique in the file */
    mcv_image image;
    const char **channel_names; /* one per channel of the image; NULL on writing: "Y" for one, "R"
                                   "G" "B" for three */
} mcv_exr_part;

/* What was read. The attributes are part 0's, without those that OpenEXR writes by itself (name,
 * type, pixelAspectRatio …) and those whose type is neither text, number, pair nor 4 x 4 matrix:
 * they can be written again as they are. */
typedef struct mcv_exr {
    mcv_exr_part *parts;
    uint32_t part_count;
    mcv_attribute *attributes;
    uint32_t attribute_count;
} mcv_exr;

/*
 * Writes the parts (not owned) and puts the attributes into part 0. Numbers become double
 * attributes, except under the standard names that OpenEXR defines as float (expTime, aperture,
 * focus, sensorPhotositePitch, worldToCamera …).
 */
mcv_result mcv_exr_write(const char *path, const mcv_exr_part *parts, uint32_t part_count,
                         const mcv_attribute *attributes, uint32_t attribute_count,
                         mcv_error *error);

/*
 * Reads images in lines or tiles, of half, float or 32-bit integer channels, in any of OpenEXR's
 * compressions; of several levels the largest. Deep images and subsampled channels are refused.
 * R, G, B come first where a part has them, the others follow in the file's order. Header and chunk
 * table are checked before OpenEXR sees the file: damaged ones are MCV_BAD_INPUT with one sentence.
 */
mcv_result mcv_exr_read(const char *path, mcv_exr *exr, mcv_error *error);
void mcv_exr_free(mcv_exr *exr);

/* The same for callers that have counted what it takes; mcv_exr_read refuses what takes more than
 * half of the memory. */
mcv_result mcv_exr_read_counted(const char *path, mcv_exr *exr, mcv_error *error);

/* By the header alone: pixels of part 0, and the bytes that reading all parts takes beside the
 * file. */
mcv_result mcv_exr_size(const char *path, uint64_t *pixels, uint64_t *reading, mcv_error *error);

/* The attribute of this name, or NULL. */
const mcv_attribute *mcv_exr_attribute(const mcv_exr *exr, const char *name);

/* The numbers of the attribute of this name, if it has `count` of them; or NULL. */
const double *mcv_exr_numbers(const mcv_exr *exr, const char *name, uint32_t count);

/* The image of the part of this name, if it has part 0's size and channels; or NULL. */
mcv_image *mcv_exr_image(const mcv_exr *exr, const char *name);

/*
 * The standard error of each value of part 0, which a render has as its second part; or NULL. Grey
 * values have in it the noise of the camera, too: the render's share is the part "render error".
 */
mcv_image *mcv_exr_error(const mcv_exr *exr);
#define MCV_EXR_RENDER_ERROR "render error"

/* Of grey values: how the lens has correlated the render's error, four numbers as in
 * mcv_correlation. */
#define MCV_EXR_CORRELATION "mcvisi:renderCorrelation"

/* How the channels share the render's error (mcv_film_channel_correlation); 1 where the header does
 * not say. */
#define MCV_EXR_CHANNELS "mcvisi:channelCorrelation"
double mcv_exr_channel_correlation(const mcv_exr *exr);

#endif
