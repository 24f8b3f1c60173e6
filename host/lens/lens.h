/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A lens prescription, as the readers of lens files fill it and first-order optics and the writer
 * use it. Lengths are in the file's unit, along the axis; the first surface is the object, the last
 * one the image.
 */
#ifndef MCVISI_HOST_LENS_LENS_H
#define MCVISI_HOST_LENS_LENS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "lens/lens_file.h"
#include "scene/surfaces.h"

enum { MCV_LENS_SURFACES = 200, MCV_LENS_GLASSES = 32, MCV_LENS_NAME = 64, MCV_LENS_WORDS = 64 };

/* A transparent material: `catalogue` is an option of the parameter `glass`; where it is 0, n_d and
 * V_d (0: no dispersion). */
typedef struct mcv_lens_glass {
    char name[MCV_LENS_NAME]; /* empty: air */
    int catalogue;
    double index, abbe;               /* index 0: to be found by its name */
    double stated_index, stated_abbe; /* beside a name, for want of anything better; 0: none */
} mcv_lens_glass;

typedef struct mcv_lens_surface {
    int line;                                          /* of the file */
    double curvature, conic, thickness, semi_diameter; /* semi-diameter 0: not given */
    double asphere[MCV_ASPHERE_TERMS];
    mcv_lens_glass glass; /* behind it */
    bool unsure;          /* `curvature` may be a radius */
    bool image_solve;     /* `thickness` leads to the paraxial image */
} mcv_lens_surface;

/* What the value of an aperture or field is. */
typedef enum mcv_lens_aperture {
    MCV_LENS_STOP_SIZE, /* as wide as the stop's, or the surfaces', semi-diameter lets it be: no
                           value */
    MCV_LENS_PUPIL_DIAMETER,
    MCV_LENS_F_NUMBER,         /* focal length over entrance pupil */
    MCV_LENS_WORKING_F_NUMBER, /* 1/(2 u') */
    MCV_LENS_OBJECT_SLOPE,     /* tangent of the marginal ray in object space */
} mcv_lens_aperture;

typedef enum mcv_lens_field {
    MCV_LENS_FIELD_TANGENT, /* of the angle in object space */
    MCV_LENS_OBJECT_HEIGHT,
    MCV_LENS_IMAGE_HEIGHT,
} mcv_lens_field;

typedef struct mcv_lens {
    const char *path;
    int line; /* being read */
    char name[MCV_LENS_NAME];
    double unit;       /* [m] */
    double wavelength; /* primary [m] */
    mcv_lens_aperture aperture_is;
    double aperture;
    mcv_lens_field field_is;
    double field[2];     /* the largest, along x and y */
    double focal_length; /* that the file states, 0: none */
    int stop, count;     /* stop 0: none given */
    mcv_lens_surface surfaces[MCV_LENS_SURFACES];
    mcv_lens_glass glasses[MCV_LENS_GLASSES]; /* the file's own */
    int glass_count;
    mcv_lens_report *report;
} mcv_lens;

/* --- text (lens_text.c) --- */

/* UTF-16 (with a byte order mark or by its zeros), UTF-8 or Latin-1 to UTF-8 that ends with 0 and
 * holds none; the caller frees. */
mcv_result mcv_lens_text_load(const char *path, char **text, mcv_error *error);

/* Cuts a statement into words in place, quoted ones as one; returns how many. */
int mcv_lens_split(char *statement, char *words[MCV_LENS_WORDS]);

bool mcv_lens_is(const char *word, const char *other);       /* whatever the case */
bool mcv_lens_is_one_of(const char *word, const char *list); /* of words with blanks around each */
void mcv_lens_copy_name(char out[MCV_LENS_NAME], const char *text); /* cut at a whole character */

/* A number below 1e30, or a distance, which may be infinite. */
mcv_result mcv_lens_number(const mcv_lens *l, const char *word, double *value, mcv_error *error);

mcv_result mcv_lens_distance(const mcv_lens *l, const char *word, double *value, mcv_error *error);

/* MCV_BAD_INPUT: "PATH: line N: surface K: what", the line and the surface where they are above 0
 * and -1. */
mcv_result mcv_lens_fail(const mcv_lens *l, int line, int surface, mcv_error *error,
                         const char *format, ...) __attribute__((format(printf, 5, 6)));
void mcv_lens_warn(mcv_lens *l, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Appends an empty surface that begins in the current line. */
mcv_result mcv_lens_add_surface(mcv_lens *l, mcv_error *error);

/* --- readers --- */

mcv_result mcv_lens_zemax_read(mcv_lens *l, char *text, mcv_error *error);
mcv_result mcv_lens_codev_read(mcv_lens *l, mcv_lens_shape shape, char *text, mcv_error *error);

/* --- glasses (lens_glass.c) --- */

/* Finds what stands behind each surface; `indices` as in mcv_lens_options. */
mcv_result mcv_lens_find_glasses(mcv_lens *l, const char *const *indices, size_t index_count,
                                 mcv_error *error);

/* n_d and V_d from indices at one wavelength [nm] or more, linear in 1/λ² between; false where that
 * is no glass. */
bool mcv_lens_fit_glass(mcv_lens_glass *glass, const double *wavelengths, const double *indices,
                        int count);

/* The index behind a surface at a wavelength [m]. */
double mcv_lens_index(const mcv_lens_surface *s, double wavelength);

/* --- first-order optics (lens_first_order.c) --- */

/* NAN where there is none; distances count from the last surface that bounds glass. */
typedef struct mcv_lens_first_order {
    double focal_length, back_focus;
    double object_distance; /* INFINITY */
    double image_distance;  /* of the axial object point: the back focus of one at infinity */
    double stated_image_distance;
    double f_number;         /* focal length over entrance pupil */
    double working_f_number; /* 1/(2 u') */
} mcv_lens_first_order;

/* Whether the surface bounds glass. */
bool mcv_lens_bounds_glass(const mcv_lens *l, int surface);

/* Thickness of the last gap where the file asks for the paraxial image. */
void mcv_lens_solve_image(mcv_lens *l);

/* Whether the axial bundle passes each surface at a height below its radius of curvature, and the
 * semi-diameters fit it. */
bool mcv_lens_is_possible(const mcv_lens *l);

/* The f-numbers are those of the stated aperture; or, `as_written`, of what the semi-diameters of
 * stop and bodies let through. */
mcv_lens_first_order mcv_lens_trace(const mcv_lens *l, bool as_written);

/*
 * Semi-diameters of the surfaces first … end - 1 of which `given` says that the file gives none: as
 * on the other face of its body, else as wide as the bundle. MCV_BAD_INPUT where nothing says how
 * wide that is.
 */
mcv_result mcv_lens_find_semi_diameters(mcv_lens *l, int first, int end, const bool *given,
                                        mcv_error *error);

/* --- glTF (lens_write.c) --- */

/* The surfaces first … end - 1, and a stop that is none of a body; places count from the first
 * glass. NULL without memory. */
json_t *mcv_lens_write(const mcv_lens *l, int first, int end);

#endif
