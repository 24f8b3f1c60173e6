/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Output files that appear whole or not at all. The bytes go to a new file in the same directory,
 * which is flushed to the disk and then renamed; until then the old file stays. Only regular files
 * are replaced: no links, devices or pipes.
 */
#ifndef MCVISI_HOST_CORE_OUTPUT_FILE_H
#define MCVISI_HOST_CORE_OUTPUT_FILE_H

#include "core/error.h"

#include <stdio.h>

typedef struct mcv_output {
    int descriptor;
    uint64_t size; /* bytes so far, the offset of mcv_output_write */
    char *path, *temporary;
} mcv_output;

/* Checks whether a file can be written at path, by making and removing the temporary file. To be
 * called before hours of rendering. */
mcv_result mcv_output_check(const char *path, mcv_error *error);

/* Whether both names are one existing file: an input must not be overwritten. */
bool mcv_same_file(const char *a, const char *b);

/* Opens the temporary file. After success exactly one of commit and discard must follow.
 * MCV_BAD_INPUT with the path and the reason if it cannot be written. */
mcv_result mcv_output_open(mcv_output *output, const char *path, mcv_error *error);

/* Appends bytes. MCV_FAILED with the reason (disk full …). */
mcv_result mcv_output_write(mcv_output *output, const void *bytes, size_t count, mcv_error *error);

/* Writes at an offset, for formats with tables that are completed at the end. */
mcv_result mcv_output_write_at(mcv_output *output, const void *bytes, size_t count, uint64_t offset,
                               mcv_error *error);

/* Flushes, renames, frees. On failure the old file stays and the temporary file is removed. */
mcv_result mcv_output_commit(mcv_output *output, mcv_error *error);

/* Removes the temporary file and frees. */
void mcv_output_discard(mcv_output *output);

/* Opens a regular file for reading: a pipe or device may never end. MCV_BAD_INPUT names it. */
mcv_result mcv_file_open(const char *path, FILE **file, uint64_t *size, mcv_error *error);

/* Reads a whole regular file of at most 4 GiB, or half of the memory; the caller frees *bytes.
 * MCV_BAD_INPUT names it. */
mcv_result mcv_file_load(const char *path, uint8_t **bytes, size_t *size, mcv_error *error);

/* Writes a whole file: opens, writes, commits. */
mcv_result mcv_output_whole(const char *path, const void *bytes, size_t count, mcv_error *error);

#endif
