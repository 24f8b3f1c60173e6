/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values of PNG files, by libpng: before it sees a file, its chunks are looked through. */
#include "core/basics.h"
#include "core/memory_limit.h"
#include "core/output_file.h"
#include "io/png.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

/* What libpng reads from. */
typedef struct source {
    const char *path;
    uint8_t *bytes;
    size_t size, at;
    size_t texts; /* the bytes that libpng keeps of texts */
    void *values;
    char *description; /* of the file, or NULL */
    uint32_t width, height;
    int channels, bits;
    mcv_error *error;
    mcv_result result;
} source;

static void on_read(png_structp png, png_bytep to, size_t count) {
    source *s = png_get_io_ptr(png);
    if (count > s->size - s->at) png_error(png, "it ends early");
    memcpy(to, s->bytes + s->at, count);
    s->at += count;
}

static void on_bad_input(png_structp png, png_const_charp message) {
    source *s = png_get_error_ptr(png);
    if (s->result == MCV_OK)
        s->result = mcv_fail(s->error, MCV_BAD_INPUT, "%s: damaged PNG file: %s", s->path, message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

/* The text under our key before the pixels, where there is memory for it. */
static char *description_of(png_structp png, png_infop info) {
    png_textp texts = NULL;
    int count = 0;
    png_get_text(png, info, &texts, &count);
    for (int i = 0; i < count; ++i)
        if (strcmp(texts[i].key, MCV_CAMERA_MODEL_KEY) == 0) return strdup(texts[i].text);
    return NULL;
}

/* A chunk of a file: length, name, data, checksum. */
typedef struct chunk {
    size_t at, length;
    const uint8_t *name, *data;
} chunk;

/* Goes to the next chunk, or the first behind one of zeros; false where the file ends. Data may
 * reach beyond the end. */
static bool next_chunk(const uint8_t *bytes, size_t size, chunk *c) {
    const size_t at = c->name ? c->at + 12 + c->length : 8;
    if (at > size || size - at < 12) return false;
    const uint8_t *b = bytes + at;
    *c = (chunk){at, (size_t)b[0] << 24 | (size_t)b[1] << 16 | (size_t)b[2] << 8 | b[3], b + 4,
                 b + 8};
    return true;
}

static bool is_named(const chunk *c, const char *name) { return memcmp(c->name, name, 4) == 0; }

/* Whether a chunk of this name (NULL: that of the pixels) is there, and all before it are whole.
 * What says how values are coded stands before the pixels. */
static bool find_chunk(const uint8_t *bytes, size_t size, const char *name) {
    for (chunk c = {0}; next_chunk(bytes, size, &c);) {
        const bool is_pixels = is_named(&c, "IDAT");
        if (is_pixels || (name && is_named(&c, name))) return is_pixels == !name;
    }
    return false;
}

/* Deflate makes at most so many bytes of one. */
#define LARGEST_GAIN 1032

/* The kind of text that has our key: "tEXt", or "zTXt" or "iTXt" where another program has saved
 * the file again; NULL where there is none before the pixels. */
static const char *kind_of_text(const source *s) {
    static const char *const kinds[] = {"tEXt", "zTXt", "iTXt"};
    static const char key[] = MCV_CAMERA_MODEL_KEY;
    for (chunk c = {0}; next_chunk(s->bytes, s->size, &c) && !is_named(&c, "IDAT");)
        for (size_t k = 0; k < 3; ++k)
            if (is_named(&c, kinds[k]) && c.length >= sizeof key &&
                s->size - c.at >= 12 + sizeof key && memcmp(c.data, key, sizeof key) == 0)
                return kinds[k];
    return NULL;
}

/* Reads the header, and of texts those of the kind that has our key; all else is passed over.
 * libpng keeps every text, and packed ones grow: their bytes are counted first. */
static void read_header(source *s, png_structp png, png_infop info) {
    const char *kind = kind_of_text(s);
    for (chunk c = {0}; kind && next_chunk(s->bytes, s->size, &c) && !is_named(&c, "IDAT");) {
        const size_t grown = kind[0] == 't' ? c.length : c.length * LARGEST_GAIN;
        const size_t most = png_get_chunk_malloc_max(png);
        if (is_named(&c, kind)) s->texts += grown < most ? grown : most;
    }
    s->result = mcv_memory_check_image(s->path, 0, s->size + s->texts, s->error);
    if (s->result != MCV_OK) png_error(png, "it is too large");
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, NULL, -1);
    if (kind)
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_AS_DEFAULT, (png_const_bytep)kind, 1);
    png_read_info(png, info);
}

/* Interleaved values in the machine's byte order, with alpha where the file has it. */
static void decode(source *s) {
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, s, on_bad_input, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info) {
        png_destroy_read_struct(&png, NULL, NULL);
        s->result = mcv_fail(s->error, MCV_FAILED, "%s: no memory for libpng", s->path);
        return;
    }
    if (setjmp(png_jmpbuf(png)) == 0) {
        png_set_read_fn(png, s, on_read);
        png_set_user_limits(png, 65536, 65536);
        /* Else libpng asks for as much memory as a chunk says that it has. */
        if (s->size >= 8 && png_sig_cmp(s->bytes, 0, 8) == 0 &&
            !find_chunk(s->bytes, s->size, NULL))
            png_error(png, "it ends early");
        read_header(s, png, info);
        /* As coded: colours of a palette and bits of a pixel become several bytes. */
        const size_t coded = png_get_rowbytes(png, info) * png_get_image_height(png, info);
        if (coded / LARGEST_GAIN > s->size) png_error(png, "it ends early");
        s->description = description_of(png, info);
        png_set_expand(png);
        png_set_swap(png);
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
        s->width = png_get_image_width(png, info);
        s->height = png_get_image_height(png, info);
        s->channels = png_get_channels(png, info);
        s->bits = png_get_bit_depth(png, info);
        const size_t row = png_get_rowbytes(png, info), pixels = (size_t)s->width * s->height,
                     values = pixels * (s->channels < 3 ? 1 : 3);
        s->result = mcv_memory_check_image(s->path, pixels,
                                           s->size + s->texts + sizeof(float) * values, s->error);
        if (s->result != MCV_OK) png_error(png, "it is too large");
        s->values = malloc(row * s->height);
        if (!s->values) png_error(png, "no memory for its pixels");
        const int passes = png_get_interlace_type(png, info) == PNG_INTERLACE_NONE ? 1 : 7;
        for (int pass = 0; pass < passes; ++pass)
            for (uint32_t y = 0; y < s->height; ++y)
                png_read_row(png, (png_bytep)s->values + y * row, NULL);
    }
    png_destroy_read_struct(&png, &info, NULL);
}

bool mcv_png_is_srgb(const char *path) {
    unsigned char *bytes;
    size_t size;
    mcv_error ignored;
    if (!mcv_ends_in(path, ".png") || mcv_file_load(path, &bytes, &size, &ignored) != MCV_OK)
        return false;
    const bool found = find_chunk(bytes, size, "sRGB");
    free(bytes);
    return found;
}

mcv_result mcv_png_read_values(const char *path, mcv_image *image, mcv_error *error) {
    source s = {.path = path, .error = error};
    MCV_TRY(mcv_file_load(path, &s.bytes, &s.size, error));
    decode(&s);
    if (s.result == MCV_OK)
        s.result = mcv_values_unpack(s.values, s.bits, s.width, s.height, (uint32_t)s.channels,
                                     s.channels < 3 ? 1 : 3, image, error);
    if (s.result == MCV_OK)
        image->description = s.description;
    else
        free(s.description);
    free(s.values);
    free(s.bytes);
    return s.result;
}
