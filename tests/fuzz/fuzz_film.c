/* SPDX-License-Identifier: Apache-2.0 */
/* Film files: checkpoints, and parts to merge with a good one. The checksum is made right, so that
 * what it protects is read. */
#include "fuzz.h"

#include "core/basics.h"
#include "verbs/checkpoint.h"
#include "verbs/merge.h"

#include <zlib.h>

/* The second half of a render of 2 x 1 pixels and 8 samples. */
static void write_other(void) {
    double sums[2] = {1, 2};
    mcv_error error = {""};
    const mcv_film film = {
        .width = 2, .height = 1, .channels = 1, .replicates = 1, .samples = 4, .sums = sums};
    const mcv_round none = {.count = 0};
    json_t *facts =
        json_pack("{s:s, s:{}, s:{s:s}, s:{s:f}, s:[i, i]}", "version", mcv_version(), "identity",
                  "device", "name", "d", "stats", "paths", 8.0, "range", 4, 8);
    if (mcv_film_file_write("other.film", &film, &none, facts, &error) != MCV_OK) abort();
    json_decref(facts);
}

static void merge(const char *const *paths, size_t count) {
    mcv_error error = {""};
    mcv_report report;
    mcv_exr exr;
    if (mcv_report_keep(&report, true, &error) != MCV_OK) return;
    const mcv_result result =
        mcv_parts_merge((mcv_texts){paths, count}, true, &exr, &report, &error);
    fuzz_sentence(result, &error);
    if (result == MCV_OK) mcv_exr_free(&exr);
    mcv_report_free(&report);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bool begun;
    static const char *const paths[] = {"in.film", "other.film"};
    mcv_film_file file;
    mcv_checkpoint checkpoint;
    mcv_error error = {""};
    if (!begun) write_other();
    begun = true;
    if (size < 8) return 0;
    uint8_t *copy = malloc(size);
    if (!copy) return 0;
    const uint64_t checksum = crc32(crc32(0, NULL, 0), data, (uInt)(size - 8));
    memcpy(copy, data, size - 8);
    memcpy(copy + size - 8, &checksum, sizeof checksum);
    fuzz_file(paths[0], copy, size);
    free(copy);
    mcv_result result = mcv_film_file_look(paths[0], &file, &error);
    fuzz_sentence(result, &error);
    if (result != MCV_OK) return 0;
    result =
        mcv_checkpoint_read(paths[0], json_object_get(file.facts, "identity"), &checkpoint, &error);
    fuzz_sentence(result, &error);
    if (result == MCV_OK) mcv_checkpoint_free(&checkpoint);
    mcv_film_file_free(&file);
    merge(paths, 1);
    merge(paths, 2);
    return 0;
}
