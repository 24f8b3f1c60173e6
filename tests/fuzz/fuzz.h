/* SPDX-License-Identifier: Apache-2.0 */
/* What the targets of libFuzzer share: inputs as files, in the folder where the target runs. */
#ifndef MCVISI_TESTS_FUZZ_H
#define MCVISI_TESTS_FUZZ_H

#include "core/error.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A sentence that names nothing, or says nothing, counts as a crash. */
static inline void fuzz_sentence(mcv_result result, const mcv_error *error) {
    if (result != MCV_OK && (error->text[0] == '\0' || strchr(error->text, '\n'))) {
        fprintf(stderr, "result %d without a sentence of one line: %s\n", (int)result, error->text);
        abort();
    }
}

static inline void fuzz_file(const char *path, const uint8_t *data, size_t size) {
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

#endif
