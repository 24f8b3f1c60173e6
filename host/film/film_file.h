/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Film files: sums of samples as they are, in double, for renders that go on later or are joined.
 *
 *     "MCVFILM1"
 *     the bytes of the text below, a 64-bit number
 *     JSON: the film's sizes and samples under "film", what the writer adds beside it
 *     zeros, up to a multiple of 8 bytes
 *     sums, or the camera paths' part of them      double [replicate][channel][row][column]
 *     splats, with light paths                     64-bit numbers, laid out as the sums
 *     levels, with adaptive sampling               signed bytes [row][column], up to 8 bytes
 *     sums of the unfinished round, if there is one, then splats up to its place
 *     the CRC-32 of all that, a 64-bit number
 *
 * Numbers are little-endian. A file is written whole or not at all (core/output_file.h).
 */
#ifndef MCVISI_HOST_FILM_FILM_FILE_H
#define MCVISI_HOST_FILM_FILM_FILE_H

#include "film/film.h"

#include <jansson.h>

/* A round of samples that is not complete. Its class of pixels and the sets of it that are done; of
 * the reference renderer, the rows that are done. */
typedef struct mcv_round {
    uint64_t first, count; /* its samples per replicate; count 0: there is none */
    uint64_t class, sets;
    double *sums;     /* laid out as the film's; NULL: nothing of it is done */
    uint64_t *splats; /* of the film and of what is done of the round; NULL without light paths */
} mcv_round;

typedef struct mcv_film_file {
    mcv_film film;
    mcv_round round;
    json_t *facts; /* what the writer has added */
} mcv_film_file;

/* Writes the file. The members of `facts` must not be named "film". */
mcv_result mcv_film_file_write(const char *path, const mcv_film *film, const mcv_round *round,
                               const json_t *facts, mcv_error *error);

/*
 * Reads a whole file. Its sizes are held against its length before memory is taken. MCV_BAD_INPUT
 * for one that is no film file, cut or damaged. On failure `file` is empty.
 */
mcv_result mcv_film_file_read(const char *path, mcv_film_file *file, mcv_error *error);

/* The same without the sums, which stay NULL: they are not checked. */
mcv_result mcv_film_file_look(const char *path, mcv_film_file *file, mcv_error *error);

void mcv_film_file_free(mcv_film_file *file);

#endif
