/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NPZ files: a ZIP archive of NPY arrays (numpy.lib.format 1.0), without compression, as
 * numpy.savez writes them. Other members, such as a text, are kept as bytes. Files have less than 4
 * GiB.
 */
#ifndef MCVISI_HOST_IO_NPZ_H
#define MCVISI_HOST_IO_NPZ_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>

enum { MCV_NPZ_DIMENSIONS = 3, MCV_NPZ_MEMBERS = 32 };

/* A member to write. */
typedef struct mcv_npz_member {
    const char *name;  /* in the archive: "data.npy" */
    const char *dtype; /* as NumPy writes it: "<f8"; NULL: `bytes` bytes as they are */
    size_t shape[MCV_NPZ_DIMENSIONS]; /* of an array, 0 behind the last one */
    bool scalar;                      /* an array without dimensions */
    const void *data;
    size_t bytes;
} mcv_npz_member;

/* Writes the archive, whole or not at all. MCV_BAD_INPUT where it would have 4 GiB or more. */
mcv_result mcv_npz_write(const char *path, const mcv_npz_member *members, size_t count,
                         mcv_error *error);

/* One array as an NPY file; its name does not count. */
mcv_result mcv_npy_write(const char *path, const mcv_npz_member *array, mcv_error *error);

/* An archive in memory. */
typedef struct mcv_npz {
    uint8_t *file;
    size_t size;
    const char *path; /* borrowed, for messages */
    struct {
        char name[64];
        const uint8_t *data; /* in `file` */
        size_t bytes;
    } members[MCV_NPZ_MEMBERS];
    size_t count;
} mcv_npz;

/* Reads an archive and checks it: places, sizes and checksums of its members. MCV_BAD_INPUT with
 * one sentence for what is damaged, compressed or too large. */
mcv_result mcv_npz_read(const char *path, mcv_npz *npz, mcv_error *error);

/* The bytes of a member; NULL: there is none of this name. */
const uint8_t *mcv_npz_bytes(const mcv_npz *npz, const char *name, size_t *bytes);

/* The data of an array of exactly this type and shape (0 behind the last dimension; *length where
 * one dimension may have any size: SIZE_MAX stands there). It need not be aligned. */
mcv_result mcv_npz_array(const mcv_npz *npz, const char *name, const char *dtype,
                         const size_t shape[MCV_NPZ_DIMENSIONS], size_t *length,
                         const uint8_t **data, mcv_error *error);

void mcv_npz_free(mcv_npz *npz);

#endif
