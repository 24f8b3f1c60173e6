/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values as NPY arrays (numpy.lib.format, version 1.0), little-endian. */
#include "core/memory_limit.h"
#include "core/output_file.h"
#include "io/values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAGIC = 6, PREAMBLE = 10, ALIGNMENT = 64, MAX_DIMENSIONS = 3, MAX_SIDE = 65536 };
static const char magic[] = "\x93NUMPY";

mcv_result mcv_npy_write_values(const char *path, const mcv_image *image, int bits,
                                mcv_error *error) {
    char header[4 * ALIGNMENT];
    mcv_output output;
    snprintf(header, sizeof header,
             "%s\x01%c%c%c{'descr': '%s', 'fortran_order': False, 'shape': (%u, %u%s), }", magic, 0,
             0, 0, bits == 8 ? "|u1" : "<u2", image->height, image->width,
             image->channels == 3 ? ", 3" : "");
    /* Blanks and a newline up to a multiple of 64 bytes; two bytes hold the length of what follows
     * them. */
    const size_t text = strlen(header + PREAMBLE),
                 total = (PREAMBLE + text + 1 + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    memset(header + PREAMBLE + text, ' ', total - PREAMBLE - text);
    header[total - 1] = '\n';
    header[8] = (char)(total - PREAMBLE);
    void *values = mcv_values_pack(image, bits);
    if (!values)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for %u x %u grey values", path,
                        image->width, image->height);
    mcv_result result = mcv_output_open(&output, path, error);
    if (result == MCV_OK) {
        result = mcv_output_write(&output, header, total, error);
        if (result == MCV_OK)
            result = mcv_output_write(
                &output, values,
                (size_t)image->width * image->height * image->channels * (size_t)bits / 8, error);
        if (result == MCV_OK)
            result = mcv_output_commit(&output, error);
        else
            mcv_output_discard(&output);
    }
    free(values);
    return result;
}

/* What stands after 'key': in the header, or "". */
static const char *value_of(const char *header, const char *key) {
    char quoted[32];
    snprintf(quoted, sizeof quoted, "'%s':", key);
    const char *found = strstr(header, quoted);
    return found ? found + strlen(quoted) + strspn(found + strlen(quoted), " ") : "";
}

static double element(const uint8_t *bytes, char kind, size_t size) {
    float single;
    double value = 0;
    uint64_t whole = 0;
    if (kind == 'u') {
        for (size_t i = 0; i < size; ++i) whole |= (uint64_t)bytes[i] << 8 * i;
        return (double)whole;
    }
    if (size == sizeof value) {
        memcpy(&value, bytes, size);
        return value;
    }
    memcpy(&single, bytes, sizeof single);
    return single;
}

/* "(480, 640)": how many numbers there are; 0 where it is none, or has more. */
static int read_shape(const char *header, unsigned long shape[MAX_DIMENSIONS]) {
    const char *c = value_of(header, "shape");
    int count = 0;
    if (*c != '(') return 0;
    for (++c; count < MAX_DIMENSIONS; ++c) {
        char *end;
        const unsigned long number = strtoul(c, &end, 10);
        if (end == c) break;
        shape[count++] = number;
        c = end;
        if (*c != ',') break;
    }
    c += strspn(c, " ");
    return *c == ')' ? count : 0;
}

static mcv_result decode(const char *path, const uint8_t *bytes, size_t size, mcv_image *image,
                         mcv_error *error) {
    const size_t start = size > PREAMBLE + 2 ? (bytes[6] == 1 ? PREAMBLE : PREAMBLE + 2) : 0;
    if (!start || memcmp(bytes, magic, MAGIC) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: not an NPY file", path);
    const size_t length = (size_t)(bytes[8] | bytes[9] << 8);
    char header[1024] = "";
    if (length < sizeof header && length < size - start) memcpy(header, bytes + start, length);
    unsigned long shape[MAX_DIMENSIONS] = {0, 0, 1};
    const int dimensions = read_shape(header, shape);
    const char *type = value_of(header, "descr"); /* '<u2' */
    char kind = '\0';
    if (strlen(type) > 4 && type[4] == type[0]) kind = type[2];
    const size_t item = kind ? (size_t)(type[3] - '0') : 0;
    const bool known =
        kind && (type[1] == '<' || type[1] == '|') &&
        ((kind == 'u' && (item == 1 || item == 2)) || (kind == 'f' && (item == 4 || item == 8)));
    const bool fits = shape[0] > 0 && shape[1] > 0 && shape[0] <= MAX_SIDE &&
                      shape[1] <= MAX_SIDE && (shape[2] == 1 || shape[2] == 3);
    if (dimensions < 2 || !fits || !known ||
        strncmp(value_of(header, "fortran_order"), "False", 5) != 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: must be an array of shape (height, width) or (height, width, 3) of "
                        "u1, u2, f4 or f8",
                        path);
    const uint32_t height = (uint32_t)shape[0], width = (uint32_t)shape[1],
                   channels = (uint32_t)shape[2];
    const size_t plane = (size_t)width * height;
    if (size - start - length < plane * channels * item)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: is truncated: %zu of %zu bytes of values", path,
                        size - start - length, plane * channels * item);
    MCV_TRY(mcv_memory_check_image(path, plane, size + sizeof(float) * plane * channels, error));
    MCV_TRY(mcv_image_new(image, width, height, channels, error));
    const uint8_t *values = bytes + start + length;
    for (size_t i = 0; i < plane * channels; ++i)
        image->pixels[i % channels * plane + i / channels] =
            (float)element(values + i * item, kind, item);
    return MCV_OK;
}

mcv_result mcv_npy_read_values(const char *path, mcv_image *image, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    const mcv_result result = decode(path, bytes, size, image, error);
    free(bytes);
    return result;
}
