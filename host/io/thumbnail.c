/* SPDX-License-Identifier: Apache-2.0 */
#include "io/thumbnail.h"

#include "io/html.h"
#include "io/png.h"

#include <math.h>
#include <png.h>
#include <stdlib.h>

/* RFC 4648, section 4. */
static void put_base64(FILE *out, const uint8_t *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const size_t rest = size - i;
        const uint32_t word = (uint32_t)bytes[i] << 16 |
                              (uint32_t)(rest > 1 ? bytes[i + 1] : 0) << 8 |
                              (rest > 2 ? bytes[i + 2] : 0);
        fputc(digits[word >> 18], out);
        fputc(digits[word >> 12 & 63], out);
        fputc(rest > 1 ? digits[word >> 6 & 63] : '=', out);
        fputc(rest > 2 ? digits[word & 63] : '=', out);
    }
}

/* The mean of a block of finite values. */
static double mean_of(const mcv_image *image, uint32_t channel, uint32_t side, uint32_t column,
                      uint32_t row) {
    const float *plane = image->pixels + (size_t)channel * image->width * image->height;
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t y = row * side; y < (row + 1) * side && y < image->height; ++y)
        for (uint32_t x = column * side; x < (column + 1) * side && x < image->width; ++x) {
            const double value = plane[(size_t)y * image->width + x];
            if (!isfinite(value)) continue;
            sum += value;
            ++count;
        }
    return count ? sum / count : 0;
}

static void put_png(FILE *out, png_image *png, const uint8_t *pixels) {
    png_alloc_size_t size = 0;
    if (!png_image_write_get_memory_size(*png, size, 0, pixels, 0, NULL)) return;
    uint8_t *bytes = malloc(size);
    if (bytes && png_image_write_to_memory(png, bytes, &size, 0, pixels, 0, NULL))
        put_base64(out, bytes, size);
    free(bytes);
}

void mcv_thumbnail_put(FILE *out, const mcv_image *image, const char *label) {
    const uint32_t channels = image->channels,
                   by_height = (image->height + MCV_THUMBNAIL_HEIGHT - 1) / MCV_THUMBNAIL_HEIGHT,
                   by_width = (image->width + MCV_THUMBNAIL_WIDTH - 1) / MCV_THUMBNAIL_WIDTH,
                   side = by_height > by_width ? by_height : by_width;
    if ((channels != 1 && channels != 3) || side == 0) return;
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (image->width + side - 1) / side,
                     .height = (image->height + side - 1) / side,
                     .format = channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY};
    uint8_t *pixels = malloc((size_t)png.width * png.height * channels), *to = pixels;
    const double white = mcv_preview_white(image);
    for (uint32_t row = 0; pixels && row < png.height; ++row)
        for (uint32_t column = 0; column < png.width; ++column)
            for (uint32_t c = 0; c < channels; ++c)
                *to++ = mcv_srgb_of(mean_of(image, c, side, column, row) / white);
    if (!pixels) return;
    fputs("<img alt=\"", out);
    mcv_html_text(out, label);
    fprintf(out, "\" width=\"%u\" height=\"%u\" src=\"data:image/png;base64,", png.width,
            png.height);
    put_png(out, &png, pixels);
    fputs("\">", out);
    free(pixels);
}
