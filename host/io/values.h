/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values as other programs open them: PNG, TIFF and NPY of whole numbers, 8 or 16 bits,
 * linear, the values as they are. */
#ifndef MCVISI_HOST_IO_VALUES_H
#define MCVISI_HOST_IO_VALUES_H

#include "film/film.h"

/* What the endings .png, .tif, .tiff and .npy say. */
#define MCV_VALUES_ENDINGS ".png, .tif, .tiff or .npy"
bool mcv_values_named(const char *path);

/*
 * Writes an image of 1 or 3 channels (grey or RGB) of whole numbers from 0 to 2^bits - 1, bits = 8
 * or 16; others are rounded and clipped. An NPY array has the shape (height, width) or (height,
 * width, 3).
 */
mcv_result mcv_values_write(const char *path, const mcv_image *image, int bits, mcv_error *error);

/* Reads such a file, of 8 or 16 bits, NPY of 32 or 64 bit floats too; alpha is left out.
 * MCV_BAD_INPUT names the file. */
mcv_result mcv_values_read(const char *path, mcv_image *image, mcv_error *error);

/* The parts. Interleaved values in the machine's byte order; the caller frees. NULL without memory.
 */
void *mcv_values_pack(const mcv_image *image, int bits);
mcv_result mcv_values_unpack(const void *values, int bits, uint32_t width, uint32_t height,
                             uint32_t stride, uint32_t channels, mcv_image *image,
                             mcv_error *error);
mcv_result mcv_tiff_write_values(const char *path, const mcv_image *image, int bits,
                                 mcv_error *error);
mcv_result mcv_tiff_read_values(const char *path, mcv_image *image, mcv_error *error);
mcv_result mcv_npy_write_values(const char *path, const mcv_image *image, int bits,
                                mcv_error *error);
mcv_result mcv_npy_read_values(const char *path, mcv_image *image, mcv_error *error);

#endif
