/* SPDX-License-Identifier: Apache-2.0 */
#include "io/values.h"

#include "core/basics.h"
#include "io/png.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct format {
    const char *ending;
    mcv_result (*write)(const char *path, const mcv_image *image, int bits, mcv_error *error);
    mcv_result (*read)(const char *path, mcv_image *image, mcv_error *error);
} format;

static const format *find_format(const char *path) {
    static const format formats[] = {{".png", mcv_png_write_values, mcv_png_read_values},
                                     {".tif", mcv_tiff_write_values, mcv_tiff_read_values},
                                     {".tiff", mcv_tiff_write_values, mcv_tiff_read_values},
                                     {".npy", mcv_npy_write_values, mcv_npy_read_values}};
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; ++i)
        if (mcv_ends_in(path, formats[i].ending)) return formats + i;
    return NULL;
}

bool mcv_values_named(const char *path) { return find_format(path); }

mcv_result mcv_values_write(const char *path, const mcv_image *image, int bits, mcv_error *error) {
    const format *f = find_format(path);
    if (!f) return mcv_fail(error, MCV_USAGE, "%s: its name must end in " MCV_VALUES_ENDINGS, path);
    if (bits != 8 && bits != 16)
        return mcv_fail(error, MCV_USAGE, "%s: grey values are written with 8 or 16 bits, not %d",
                        path, bits);
    if (image->channels != 1 && image->channels != 3)
        return mcv_fail(error, MCV_FAILED,
                        "%s: an image of %u channels cannot be written in this format; 1 or 3 can",
                        path, image->channels);
    return f->write(path, image, bits, error);
}

mcv_result mcv_values_read(const char *path, mcv_image *image, mcv_error *error) {
    const format *f = find_format(path);
    if (!f)
        return mcv_fail(error, MCV_USAGE, "%s: its name must end in .exr, " MCV_VALUES_ENDINGS,
                        path);
    return f->read(path, image, error);
}

void *mcv_values_pack(const mcv_image *image, int bits) {
    const size_t plane = (size_t)image->width * image->height, count = plane * image->channels;
    const float largest = bits == 8 ? 255 : 65535;
    void *values = count ? malloc(count * (size_t)bits / 8) : NULL;
    uint8_t *bytes = values;
    uint16_t *words = values;
    for (size_t i = 0; values && i < count; ++i) {
        const float value = image->pixels[i % image->channels * plane + i / image->channels];
        const float whole = fminf(fmaxf(floorf(value + 0.5F), 0), largest);
        if (bits == 8)
            bytes[i] = (uint8_t)whole;
        else
            words[i] = (uint16_t)whole;
    }
    return values;
}

mcv_result mcv_values_unpack(const void *values, int bits, uint32_t width, uint32_t height,
                             uint32_t stride, uint32_t channels, mcv_image *image,
                             mcv_error *error) {
    MCV_TRY(mcv_image_new(image, width, height, channels, error));
    const size_t plane = (size_t)width * height;
    for (size_t i = 0; i < plane; ++i)
        for (uint32_t c = 0; c < channels; ++c)
            image->pixels[c * plane + i] = bits == 8
                                               ? (float)((const uint8_t *)values)[i * stride + c]
                                               : (float)((const uint16_t *)values)[i * stride + c];
    return MCV_OK;
}
