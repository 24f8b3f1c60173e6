/* SPDX-License-Identifier: Apache-2.0 */
#include "io/png.h"

#include "core/output_file.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

typedef struct target {
    mcv_output *output;
    mcv_error *error;
    mcv_result result;
} target;

static void on_write(png_structp png, png_bytep bytes, size_t count) {
    target *t = png_get_io_ptr(png);
    t->result = mcv_output_write(t->output, bytes, count, t->error);
    if (t->result != MCV_OK) png_error(png, "write");
}

/* The output is flushed once, at its commit. */
static void on_flush(png_structp png) { (void)png; }

static void on_error(png_structp png, png_const_charp message) {
    target *t = png_get_error_ptr(png);
    if (t->result == MCV_OK)
        t->result = mcv_fail(t->error, MCV_FAILED, "%s: libpng: %s", t->output->path, message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

/*
 * Rows are width * channels * bits / 8 bytes, 16-bit values in the machine's order. Texts are
 * written as tEXt chunks. What must outlive a longjmp belongs to the caller.
 */
static void encode(target *t, const uint8_t *bytes, uint32_t width, uint32_t height, int channels,
                   int bits, bool srgb, png_text *texts, int text_count) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, t, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info) {
        png_destroy_write_struct(&png, NULL);
        t->result = mcv_fail(t->error, MCV_FAILED, "%s: no memory for libpng", t->output->path);
        return;
    }
    if (setjmp(png_jmpbuf(png)) == 0) {
        png_set_write_fn(png, t, on_write, on_flush);
        png_set_user_limits(png, 0x7fffffff, 0x7fffffff);
        png_set_IHDR(png, info, width, height, bits,
                     channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_compression_level(
            png, 1); /* noise: level 6, the usual one, takes five times as long for 5 % less */
        if (srgb) png_set_sRGB(png, info, PNG_sRGB_INTENT_RELATIVE);
        png_set_text(png, info, texts, text_count);
        png_write_info(png, info);
        if (bits == 16) png_set_swap(png); /* of little-endian words; the host is one */
        const size_t stride = (size_t)width * (size_t)(channels * bits / 8);
        for (uint32_t row = 0; row < height; ++row) png_write_row(png, bytes + row * stride);
        png_write_end(png, info);
    }
    png_destroy_write_struct(&png, &info);
}

/* `level`: the preview's, whose values are sRGB; NULL: values as they are. `early`: as in
 * mcv_preview. */
static mcv_result write_file(const char *path, const uint8_t *bytes, const mcv_image *image,
                             int bits, char *level, const char *early, mcv_error *error) {
    char level_key[] = "White level", model_key[] = MCV_CAMERA_MODEL_KEY, early_key[] = "Preview";
    char early_text[160];
    png_text texts[3];
    int count = 0;
    if (early) {
        snprintf(early_text, sizeof early_text, "%s", early);
        texts[count++] = (png_text){
            .compression = PNG_TEXT_COMPRESSION_NONE, .key = early_key, .text = early_text};
    }
    if (level)
        texts[count++] =
            (png_text){.compression = PNG_TEXT_COMPRESSION_NONE, .key = level_key, .text = level};
    if (image->description)
        texts[count++] = (png_text){
            .compression = PNG_TEXT_COMPRESSION_NONE, .key = model_key, .text = image->description};
    mcv_output output;
    MCV_TRY(mcv_output_open(&output, path, error));
    target t = {.output = &output, .error = error, .result = MCV_OK};
    encode(&t, bytes, image->width, image->height, (int)image->channels, bits, level, texts, count);
    if (t.result != MCV_OK) {
        mcv_output_discard(&output);
        return t.result;
    }
    return mcv_output_commit(&output, error);
}

/*
 * The value of rank k (from 0) among the finite ones, by two passes over a histogram of 16 bits of
 * the float: for numbers not below 0 the bits are ordered as the numbers are. Negative ones count
 * as 0.
 */
static float select_rank(const mcv_image *image, uint64_t rank) {
    const size_t count = (size_t)image->width * image->height * image->channels;
    uint32_t prefix = 0;
    for (int shift = 16; shift >= 0; shift -= 16) {
        static const uint32_t BINS = 1u << 16;
        uint64_t *histogram = calloc(BINS, sizeof *histogram);
        if (!histogram) return 0;
        for (size_t i = 0; i < count; ++i) {
            const float value = image->pixels[i] > 0 ? image->pixels[i] : 0;
            uint32_t bits;
            memcpy(&bits, &value, sizeof bits);
            if (isfinite(image->pixels[i]) && (shift == 16 || bits >> 16 == prefix >> 16))
                ++histogram[bits >> shift & 0xffffu];
        }
        uint32_t bin = 0;
        while (bin < BINS - 1 && rank >= histogram[bin]) rank -= histogram[bin++];
        prefix |= bin << shift;
        free(histogram);
    }
    float value;
    memcpy(&value, &prefix, sizeof value);
    return value;
}

double mcv_preview_white(const mcv_image *image) {
    const size_t count = (size_t)image->width * image->height * image->channels;
    uint64_t finite = 0;
    double largest = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(image->pixels[i])) continue;
        ++finite;
        largest = fmax(largest, image->pixels[i]);
    }
    if (largest == 0) return 1;
    const double quantile = select_rank(image, (uint64_t)(0.995 * (double)(finite - 1)));
    return quantile > 0 ? quantile : largest;
}

uint8_t mcv_srgb_of(double share) {
    if (!(share > 0)) return 0;
    if (share >= 1) return 255;
    const double encoded = share <= 0.0031308 ? 12.92 * share : 1.055 * pow(share, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * encoded + 0.5);
}

/* Bytes of a larger picture, in which each pixel is repeated; NULL without memory. */
static uint8_t *enlarge(const uint8_t *bytes, const mcv_image *from, const mcv_preview *preview) {
    const uint32_t channels = from->channels, width = preview->size[0], height = preview->size[1];
    uint8_t *large = malloc((size_t)width * height * channels), *to = large;
    for (uint32_t y = 0; large && y < height; ++y)
        for (uint32_t x = 0; x < width; ++x, to += channels)
            memcpy(to,
                   bytes + ((size_t)(y / preview->repeat) * from->width + x / preview->repeat) *
                               channels,
                   channels);
    return large;
}

mcv_result mcv_png_write_preview(const char *path, const mcv_image *image, const char *unit,
                                 mcv_preview *preview, mcv_error *error) {
    if (image->channels != 1 && image->channels != 3) {
        return mcv_fail(error, MCV_FAILED,
                        "%s: an image of %u channels has no preview; 1 or 3 can be shown", path,
                        image->channels);
    }
    if (!(preview->white > 0) || isinf(preview->white)) preview->white = mcv_preview_white(image);
    const size_t pixels = (size_t)image->width * image->height;
    const size_t values = pixels * image->channels;
    uint8_t *bytes = values > 0 ? malloc(values) : NULL;
    if (!bytes)
        return mcv_fail(
            error, MCV_FAILED,
            "%s: a preview of %u x %u pixels: it is empty, or there is no memory for it", path,
            image->width, image->height);
    uint64_t saturated = 0;
    for (size_t i = 0; i < pixels; ++i) {
        bool above = false;
        for (uint32_t c = 0; c < image->channels; ++c) {
            const double value = image->pixels[c * pixels + i];
            // NOLINTNEXTLINE(clang-analyzer-unix.Malloc): pixels times channels is no 0, the image
            // itself is larger
            bytes[i * image->channels + c] = mcv_srgb_of(value / preview->white);
            above = above || value > preview->white;
        }
        saturated += above;
    }
    preview->saturated = (double)saturated / (double)pixels;

    char level[128];
    snprintf(level, sizeof level, "%.9g %s", preview->white, unit);
    mcv_image shown = *image;
    uint8_t *large = NULL;
    if (preview->repeat > 1) {
        large = enlarge(bytes, image, preview);
        shown.width = preview->size[0];
        shown.height = preview->size[1];
        if (!large) {
            free(bytes);
            return mcv_fail(error, MCV_FAILED, "%s: no memory for a preview of %u x %u pixels",
                            path, shown.width, shown.height);
        }
    }
    const mcv_result result =
        write_file(path, large ? large : bytes, &shown, 8, level, preview->early, error);
    free(large);
    free(bytes);
    return result;
}

mcv_result mcv_png_write_values(const char *path, const mcv_image *image, int bits,
                                mcv_error *error) {
    if (bits != 8 && bits != 16)
        return mcv_fail(error, MCV_USAGE, "%s: a PNG of grey values must have 8 or 16 bits, not %d",
                        path, bits);
    if (image->channels != 1 && image->channels != 3) {
        return mcv_fail(error, MCV_FAILED,
                        "%s: an image of %u channels cannot be a PNG; 1 or 3 can be written", path,
                        image->channels);
    }
    uint8_t *bytes = mcv_values_pack(image, bits);
    if (!bytes) {
        return mcv_fail(error, MCV_FAILED,
                        "%s: %u x %u grey values: it is empty, or there is no memory for it", path,
                        image->width, image->height);
    }
    const mcv_result result = write_file(path, bytes, image, bits, NULL, NULL, error);
    free(bytes);
    return result;
}
