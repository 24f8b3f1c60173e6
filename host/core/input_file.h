/* SPDX-License-Identifier: Apache-2.0 */
/* Reading scene files and what they point to. Nothing but regular files is opened. */
#ifndef MCVISI_HOST_CORE_INPUT_FILE_H
#define MCVISI_HOST_CORE_INPUT_FILE_H

#include "core/json_path.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mcv_bytes {
    uint8_t *data; /* malloc'ed, or inside of something that is */
    size_t size;
} mcv_bytes;

/* The whole file; the caller frees bytes->data. `place` is where it is asked for. */
mcv_result mcv_file_read(const char *path, mcv_bytes *bytes, const mcv_json_path *place,
                         mcv_error *error);

/*
 * The path of a relative URI beside the file `base`: percent-decoded; no scheme, no absolute path,
 * nothing (a symbolic link included) that leads out of the directory of `base`. The caller frees
 * *path.
 */
mcv_result mcv_file_resolve(const char *base, const char *uri, char **path,
                            const mcv_json_path *place, mcv_error *error);

/*
 * The chunks of a GLB; both lie inside `file`. A file that does not begin like a GLB is JSON as a
 * whole. `binary->data` is NULL where the file is no GLB; a GLB without a binary chunk has one of
 * size 0.
 */
mcv_result mcv_glb_split(mcv_bytes file, mcv_bytes *json, mcv_bytes *binary,
                         const mcv_json_path *place, mcv_error *error);

#ifdef __cplusplus
}
#endif
#endif
