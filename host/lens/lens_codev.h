/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the reader of CODE V sequences share (lens/lens_codev.c); only they use it. */
#ifndef MCVISI_HOST_LENS_LENS_CODEV_H
#define MCVISI_HOST_LENS_LENS_CODEV_H

#include "lens/lens.h"

#include <ctype.h>

typedef struct mcv_codev {
    mcv_lens *l;
    mcv_lens_shape shape; /* meaning of the numbers of S statements; AUTO: not yet known */
    bool forced;          /* by the user's option */
    bool image, go, private_glasses;
    double wavelengths[MCV_LENS_WORDS], private_wavelengths[MCV_LENS_WORDS]; /* [nm] */
    int wavelength_count, private_count, reference;
    char unknown[160]; /* ignored words */
    int first_unknown;
} mcv_codev;

/* The values of a statement, after the words for its target. */
typedef struct mcv_codev_statement {
    char **words;
    int count, first, last; /* surfaces; -1: none named */
    bool named, zoom;
} mcv_codev_statement;

mcv_result mcv_codev_fail(const mcv_codev *c, int surface, mcv_error *error, const char *what,
                          const char *word);

/* lens_codev_words.c */

/*
 * Splits off the statement that begins at *rest, without comments (!); lines that end in & are
 * joined. Sets the line in which it begins. NULL at the end of the text.
 */
char *mcv_codev_next_statement(char **rest, int *line, int *next_line);

/* Removes the surfaces S3 or S3..5 and the zoom position Z1 from the start of a statement; without
 * them it applies to the current surface. */
mcv_result mcv_codev_read_target(const mcv_codev *c, char **words, int n, mcv_codev_statement *s,
                                 mcv_error *error);

/* Is a word the statement `key`, by its first three letters? */
bool mcv_codev_means(const char *word, const char *key);
bool mcv_codev_means_one_of(const char *word, const char *list);

/* lens_codev_surfaces.c */

mcv_result mcv_codev_set_glass(mcv_codev *c, int surface, const char *name, mcv_error *error);

/* S radius thickness glass; SO and SI, or by its number. */
mcv_result mcv_codev_read_surface(mcv_codev *c, char **words, int n, mcv_error *error);

/* A statement of a solve (THI PIM, CUY UMY -0.1) has a word in place of the value; the value is
 * that of the S statement. */
mcv_result mcv_codev_read_shape(mcv_codev *c, const mcv_codev_statement *s, mcv_lens_shape shape,
                                mcv_error *error);
mcv_result mcv_codev_read_thickness(mcv_codev *c, const mcv_codev_statement *s, mcv_error *error);

/* CIR radius, of the clear aperture (CLR) or the edge (EDG); the clear aperture has precedence. */
mcv_result mcv_codev_read_aperture(mcv_codev *c, const mcv_codev_statement *s, mcv_error *error);

/* K, and A to J of r^4 to r^20. */
mcv_result mcv_codev_read_coefficient(mcv_codev *c, const char *key, const mcv_codev_statement *s,
                                      mcv_error *error);

#endif
