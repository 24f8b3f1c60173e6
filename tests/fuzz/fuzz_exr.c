/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR images. */
#include "fuzz.h"

#include "io/exr.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    mcv_exr exr;
    mcv_error error = {""};
    uint64_t pixels, reading;
    fuzz_file("in.exr", data, size);
    mcv_result result = mcv_exr_size("in.exr", &pixels, &reading, &error);
    fuzz_sentence(result, &error);
    if (result != MCV_OK || reading > 40000000) return 0; /* which only takes time */
    result = mcv_exr_read("in.exr", &exr, &error);
    fuzz_sentence(result, &error);
    if (result == MCV_OK) mcv_exr_free(&exr);
    return 0;
}
