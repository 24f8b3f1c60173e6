/* SPDX-License-Identifier: Apache-2.0 */
/* Reading scene files and the files that they name. Only regular files are opened. */
#ifndef MCVISI_HOST_CORE_INPUT_FILE_H
#define MCVISI_HOST_CORE_INPUT_FILE_H

#include "core/json_path.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mcv_bytes {
    uint8_t *data; /* malloc'ed, or a part of something that is */
    size_t size;
} mcv_bytes;

/* Reads the whole file; the caller frees bytes->data. `place` is where the file is named. */
mcv_result mcv_file_read(const char *path, mcv_bytes *bytes, const mcv_json_path *place,
                         mcv_error *error);

/* The size of a regular file; and `size` bytes of it from byte `first` on. */
mcv_result mcv_file_size(const char *path, uint64_t *size, const mcv_json_path *place,
                         mcv_error *error);
mcv_result mcv_file_read_part(const char *path, uint64_t first, uint64_t size, uint8_t *bytes,
                              const mcv_json_path *place, mcv_error *error);

/* Do two relative URIs beside the file `base` lead to one file? */
bool mcv_file_is_same(const char *base, const char *uri, const char *other);

/*
 * The path of a relative URI beside the file `base`, percent-decoded. Refused are schemes, absolute
 * paths, and everything that leads out of the directory of `base`, symbolic links included. The
 * caller frees *path.
 */
mcv_result mcv_file_resolve(const char *base, const char *uri, char **path,
                            const mcv_json_path *place, mcv_error *error);

/*
 * Splits a GLB into its chunks, which are parts of `file`. A file that does not begin like a GLB is
 * JSON as a whole; binary->data is then NULL. A GLB without a binary chunk has one of size 0.
 */
mcv_result mcv_glb_split(mcv_bytes file, mcv_bytes *json, mcv_bytes *binary,
                         const mcv_json_path *place, mcv_error *error);

#ifdef __cplusplus
}
#endif
#endif
