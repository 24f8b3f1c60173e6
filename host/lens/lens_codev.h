/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of reading CODE V sequences share (lens/lens_codev.c); nothing else calls them. */
#ifndef MCVISI_HOST_LENS_LENS_CODEV_H
#define MCVISI_HOST_LENS_LENS_CODEV_H

#include "lens/lens.h"

#include <ctype.h>

typedef struct mcv_codev {
    mcv_lens *l;
    mcv_lens_shape shape; /* what an S statement gives; AUTO: not known yet */
    bool forced;          /* by the user's option */
    bool image, go, private_glasses;
    double wavelengths[MCV_LENS_WORDS], private_wavelengths[MCV_LENS_WORDS]; /* [nm] */
    int wavelength_count, private_count, reference;
    char unknown[160]; /* words that were left out */
    int first_unknown;
} mcv_codev;

/* A statement's values, behind the words that say of what they are. */
typedef struct mcv_codev_statement {
    char **words;
    int count, first, last; /* surfaces; -1: none named */
    bool named, zoom;
} mcv_codev_statement;

mcv_result mcv_codev_fail(const mcv_codev *c, int surface, mcv_error *error, const char *what,
                          const char *word);

/* lens_codev_words.c */

/*
 * Ends the statement that begins at *rest, without comments (!) and joined where a line ends in &;
 * sets the line it begins in. NULL at the end of the text.
 */
char *mcv_codev_next_statement(char **rest, int *line, int *next_line);

/* Takes the surfaces S3 or S3..5 and the zoom position Z1 off a statement's head; without, the
 * current surface is meant. */
mcv_result mcv_codev_read_target(const mcv_codev *c, char **words, int n, mcv_codev_statement *s,
                                 mcv_error *error);

/* Whether a word means the statement `key`, by its first three letters. */
bool mcv_codev_means(const char *word, const char *key);
bool mcv_codev_means_one_of(const char *word, const char *list);

/* lens_codev_surfaces.c */

mcv_result mcv_codev_set_glass(mcv_codev *c, int surface, const char *name, mcv_error *error);

/* S radius thickness glass; SO and SI, or by its number. */
mcv_result mcv_codev_read_surface(mcv_codev *c, char **words, int n, mcv_error *error);

/* Statements of a solve (THI PIM, CUY UMY -0.1) name a word where a value would stand: the value is
 * that of the S statement. */
mcv_result mcv_codev_read_shape(mcv_codev *c, const mcv_codev_statement *s, mcv_lens_shape shape,
                                mcv_error *error);
mcv_result mcv_codev_read_thickness(mcv_codev *c, const mcv_codev_statement *s, mcv_error *error);

/* CIR radius, for the clear aperture (CLR) or the edge (EDG), the first of which counts. */
mcv_result mcv_codev_read_aperture(mcv_codev *c, const mcv_codev_statement *s, mcv_error *error);

/* K, and A to J of r^4 to r^20. */
mcv_result mcv_codev_read_coefficient(mcv_codev *c, const char *key, const mcv_codev_statement *s,
                                      mcv_error *error);

#endif
