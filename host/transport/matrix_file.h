/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files of light transport matrices: NPZ, whose arrays data, indices, indptr, shape and format are
 * those of scipy.sparse.load_npz; and MatrixMarket, for MATLAB and others.
 *
 * Beside them an NPZ file has: replicates, [entry][replicate], the values by each replicate;
 * pattern, [element][channel], that of the scene; and header.json: the pixel grid, the elements,
 * the image's header.
 */
#ifndef MCVISI_HOST_TRANSPORT_MATRIX_FILE_H
#define MCVISI_HOST_TRANSPORT_MATRIX_FILE_H

#include "transport/matrix.h"

/* Writes .npz, or .mtx with the values alone; whole or not at all. */
mcv_result mcv_matrix_write(const mcv_matrix *matrix, const char *path, mcv_error *error);

/* Reads .npz. MCV_BAD_INPUT with one sentence for what is no such matrix. */
mcv_result mcv_matrix_read(const char *path, mcv_matrix *matrix, mcv_error *error);

/* The header as JSON; NULL without memory. */
json_t *mcv_matrix_header(const mcv_matrix *matrix);

#endif
