/* SPDX-License-Identifier: Apache-2.0 */
/* Light transport matrices, .npz: read and relit. The checksums of members are made right, so that
 * what they protect is read. */
#include "fuzz.h"

#include "transport/matrix_file.h"
#include "verbs/transport.h"

#include <zlib.h>

static size_t number(const uint8_t *from, int bytes) {
    size_t value = 0;
    for (int i = bytes - 1; i >= 0; --i) value = value << 8 | from[i];
    return value;
}

/* Of each entry of the directory whose member lies in the file. */
static void mend_checksums(uint8_t *file, size_t size) {
    static const uint8_t entry[4] = {'P', 'K', 1, 2};
    for (size_t at = 0; at + 46 <= size; ++at) {
        uint8_t *e = file + at;
        if (memcmp(e, entry, sizeof entry) != 0) continue;
        const size_t bytes = number(e + 24, 4), local = number(e + 42, 4);
        if (local > size || size - local < 30) continue;
        const size_t data =
            local + 30 + number(file + local + 26, 2) + number(file + local + 28, 2);
        if (data > size || size - data < bytes) continue;
        const uint32_t checksum = (uint32_t)crc32(crc32(0, NULL, 0), file + data, (uInt)bytes);
        memcpy(e + 16, &checksum, sizeof checksum);
    }
}

static void relight(const mcv_matrix *matrix) {
    const char *brighter = "emitters/a/radiance=[1,2,3]";
    mcv_command command = {.set = {&brighter, 1}};
    mcv_error error = {""};
    mcv_image mean, deviation;
    float *pattern;
    json_decref(mcv_matrix_header(matrix));
    const mcv_result result = mcv_pattern_read(&command, matrix, &pattern, &error);
    fuzz_sentence(result, &error);
    if (mcv_matrix_relight(matrix, result == MCV_OK ? pattern : matrix->pattern, &mean, &deviation,
                           &error) == MCV_OK) {
        mcv_image_free(&mean);
        mcv_image_free(&deviation);
    }
    if (result == MCV_OK) free(pattern);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    mcv_matrix matrix;
    mcv_error error = {""};
    uint8_t *copy = malloc(size + 1);
    if (!copy) return 0;
    memcpy(copy, data, size);
    mend_checksums(copy, size);
    fuzz_file("in.npz", copy, size);
    free(copy);
    const mcv_result result = mcv_matrix_read("in.npz", &matrix, &error);
    fuzz_sentence(result, &error);
    if (result != MCV_OK) return 0;
    relight(&matrix);
    mcv_matrix_free(&matrix);
    return 0;
}
