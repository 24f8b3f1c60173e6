/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values as TIFF, by libtiff: uncompressed, one strip a row block, the values as they are. */
#include "core/memory_limit.h"
#include "core/output_file.h"
#include "io/values.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

/* A file in memory: libtiff seeks while it writes, and the output appears whole or not at all. */
typedef struct memory {
    uint8_t *bytes;
    size_t size, capacity, at;
    uint64_t tags;     /* the bytes that libtiff takes for the tags of the first image */
    char message[256]; /* what libtiff says goes into the sentence that we return */
} memory;

static tmsize_t on_read(thandle_t handle, void *to, tmsize_t count) {
    memory *m = (memory *)handle;
    const size_t left = m->at < m->size ? m->size - m->at : 0,
                 n = (size_t)count < left ? (size_t)count : left;
    memcpy(to, m->bytes + m->at, n);
    m->at += n;
    return (tmsize_t)n;
}

static tmsize_t on_write(thandle_t handle, void *from, tmsize_t count) {
    memory *m = (memory *)handle;
    const size_t end = m->at + (size_t)count;
    if (end > m->capacity) {
        const size_t capacity = end > 2 * m->capacity ? end : 2 * m->capacity;
        uint8_t *bytes = realloc(m->bytes, capacity);
        if (!bytes) return -1;
        m->bytes = bytes;
        m->capacity = capacity;
    }
    if (m->at > m->size) memset(m->bytes + m->size, 0, m->at - m->size);
    memcpy(m->bytes + m->at, from, (size_t)count);
    m->at = end;
    if (end > m->size) m->size = end;
    return count;
}

static toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
    memory *m = (memory *)handle;
    const toff_t from = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? m->at : m->size;
    return m->at = (size_t)(from + offset);
}

static int on_close(thandle_t handle) {
    (void)handle;
    return 0;
}

static toff_t on_size(thandle_t handle) { return ((memory *)handle)->size; }

__attribute__((format(printf, 4, 0))) static int
on_message(TIFF *tiff, void *user, const char *module, const char *format, va_list arguments) {
    memory *m = user;
    (void)tiff;
    (void)module;
    vsnprintf(m->message, sizeof m->message, format, arguments);
    return 1; /* the handlers of the process are not called */
}

static int on_warning(TIFF *tiff, void *user, const char *module, const char *format,
                      va_list arguments) {
    (void)tiff;
    (void)user;
    (void)module;
    (void)format;
    (void)arguments;
    return 1;
}

/* Handlers are those of the file alone: the process may have its own. */
static TIFF *open_memory(memory *m, const char *mode) {
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (!options) return NULL;
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_message, m);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, NULL);
    TIFF *tiff = TIFFClientOpenExt("memory", mode, (thandle_t)m, on_read, on_write, on_seek,
                                   on_close, on_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return tiff;
}

static bool encode(TIFF *tiff, const mcv_image *image, int bits, const uint8_t *values) {
    const size_t row = (size_t)image->width * image->channels * (size_t)bits / 8;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, image->width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, image->height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, image->channels);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                 image->channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
    if (image->description) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, image->description);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
    for (uint32_t y = 0; y < image->height; ++y)
        if (TIFFWriteScanline(tiff, (void *)(values + y * row), y, 0) != 1) return false;
    return TIFFFlush(tiff) == 1;
}

mcv_result mcv_tiff_write_values(const char *path, const mcv_image *image, int bits,
                                 mcv_error *error) {
    memory m = {0};
    void *values = mcv_values_pack(image, bits);
    TIFF *tiff = values ? open_memory(&m, "w") : NULL;
    const bool encoded = tiff && encode(tiff, image, bits, values);
    if (tiff) TIFFClose(tiff);
    free(values);
    const mcv_result result = encoded ? mcv_output_whole(path, m.bytes, m.size, error)
                                      : mcv_fail(error, MCV_FAILED, "%s: libtiff: %s", path,
                                                 m.message[0] ? m.message : "no memory");
    free(m.bytes);
    return result;
}

static mcv_result decode(TIFF *tiff, const memory *m, const char *path, mcv_image *image,
                         mcv_error *error) {
    uint32_t width = 0, height = 0;
    uint16_t bits = 1, samples = 1, kind = SAMPLEFORMAT_UINT, planar = PLANARCONFIG_CONTIG,
             photometric = PHOTOMETRIC_MINISBLACK;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &kind);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    const uint32_t channels = samples < 3 ? 1 : 3;
    if ((bits != 8 && bits != 16) || kind != SAMPLEFORMAT_UINT || planar != PLANARCONFIG_CONTIG ||
        samples > 4 || TIFFIsTiled(tiff) ||
        photometric != (channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: must be a TIFF of grey or RGB rows with 8 or 16 bits", path);
    const size_t row = (size_t)width * samples * bits / 8;
    if (width == 0 || height == 0 || width > 65536 || height > 65536 ||
        (size_t)TIFFScanlineSize(tiff) != row)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: a TIFF of %u x %u pixels cannot be read", path,
                        width, height);
    const size_t pixels = (size_t)width * height;
    MCV_TRY(mcv_memory_check_image(path, pixels,
                                   m->size + m->tags + sizeof(float) * pixels * channels, error));
    uint8_t *values = malloc(row * height);
    mcv_result result = values ? MCV_OK
                               : mcv_fail(error, MCV_FAILED, "%s: no memory for %u x %u pixels",
                                          path, width, height);
    for (uint32_t y = 0; result == MCV_OK && y < height; ++y)
        if (TIFFReadScanline(tiff, values + y * row, y, 0) != 1)
            result = mcv_fail(error, MCV_BAD_INPUT, "%s: damaged TIFF file: %s", path, m->message);
    if (result == MCV_OK)
        result = mcv_values_unpack(values, bits, width, height, samples, channels, image, error);
    const char *description = NULL;
    if (result == MCV_OK && TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &description) == 1)
        image->description = strdup(description);
    free(values);
    return result;
}

static uint64_t number_at(const memory *m, uint64_t at, int count) {
    uint64_t number = 0;
    for (int i = 0; i < count; ++i) {
        const int place = m->bytes[0] == 'M' ? i : count - 1 - i; /* big endian, or little */
        number = number << 8 | m->bytes[at + (uint64_t)place];
    }
    return number;
}

/* Finds what libtiff takes for the tags of the first image: their values, and once more those of
 * the largest. Values have their places in the file side by side: hostile tags share them. libtiff
 * passes over tags that cannot lie in the file, and tells where there is no list of them. */
static mcv_result count_tags(const char *path, memory *m, mcv_error *error) {
    static const uint8_t sizes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    if (m->size < 16) return MCV_OK;
    const bool large = number_at(m, 2, 2) == 43; /* BigTIFF */
    const uint64_t word = large ? 8 : 4, entry = large ? 20 : 12, head = large ? 8 : 2;
    const uint64_t list = number_at(m, large ? 8 : 4, (int)word);
    uint64_t sum = 0, largest = 0;
    if (list > m->size - head) return MCV_OK;
    uint64_t tags = number_at(m, list, (int)head), at = list + head;
    for (; tags > 0 && m->size - at >= entry; --tags, at += entry) {
        const uint64_t type = number_at(m, at + 2, 2), count = number_at(m, at + 4, (int)word);
        const uint64_t each = type < sizeof sizes ? sizes[type] : 0;
        if (each == 0 || count > m->size / each || count * each <= word) continue;
        sum += count * each;
        if (count * each > largest) largest = count * each;
        if (sum > m->size)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: damaged TIFF file: its tags have more bytes than the file", path);
    }
    m->tags = sum + largest;
    return mcv_memory_check_image(path, 0, m->size + m->tags, error);
}

mcv_result mcv_tiff_read_values(const char *path, mcv_image *image, mcv_error *error) {
    memory m = {0};
    mcv_result result = mcv_file_load(path, &m.bytes, &m.size, error);
    if (result == MCV_OK) result = count_tags(path, &m, error);
    TIFF *tiff = result == MCV_OK ? open_memory(&m, "rm") : NULL; /* m: not by mmap */
    if (result == MCV_OK && !tiff)
        result = mcv_fail(error, MCV_BAD_INPUT, "%s: not a TIFF file: %s", path, m.message);
    if (tiff) {
        result = decode(tiff, &m, path, image, error);
        TIFFClose(tiff);
    }
    free(m.bytes);
    return result;
}
