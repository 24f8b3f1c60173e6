/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pixels of an OpenEXR file by the C++ library, behind a C interface: the C library of 3.1
 * lacks DWA and unpacks float channels of B44 wrongly. No exception leaves it.
 */
#ifndef MCVISI_HOST_IO_EXR_DECODE_H
#define MCVISI_HOST_IO_EXR_DECODE_H

#include "io/exr.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Fills the images of all parts from a file in memory, whose header and chunks hold
 * (io/exr_header.h). MCV_BAD_INPUT, naming path, where the pixels are damaged. */
mcv_result mcv_exr_decode(const char *path, const uint8_t *bytes, size_t size, const mcv_exr *exr,
                          mcv_error *error);

#ifdef __cplusplus
}
#endif
#endif
