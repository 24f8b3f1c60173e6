/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values: PNG, TIFF and NPY, by the first byte. */
#include "fuzz.h"

#include "io/values.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const names[] = {"in.png", "in.tiff", "in.npy"};
    mcv_image image = {0};
    mcv_error error = {""};
    if (size < 1) return 0;
    const char *name = names[data[0] % 3];
    fuzz_file(name, data + 1, size - 1);
    const mcv_result result = mcv_values_read(name, &image, &error);
    fuzz_sentence(result, &error);
    if (result == MCV_OK) mcv_image_free(&image);
    return 0;
}
