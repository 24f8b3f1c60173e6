/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A lens prescription. The readers of lens files fill it; first-order optics and the writer use it.
 * Lengths are in the file's unit, along the axis. The first surface is the object, the last one the
 * image.
 */
#ifndef MCVISI_HOST_LENS_LENS_H
#define MCVISI_HOST_LENS_LENS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "lens/lens_file.h"
#include "scene/surfaces.h"

enum { MCV_LENS_SURFACES = 200, MCV_LENS_GLASSES = 32, MCV_LENS_NAME = 64, MCV_LENS_WORDS = 64 };

/* A transparent material: `catalogue` is an option of the parameter `glass`; if it is 0, n_d and
 * V_d (0: no dispersion). */
typedef struct mcv_lens_glass {
    char name[MCV_LENS_NAME]; /* empty: air */
    int catalogue;
    double index, abbe; /* index 0: to be looked up by name */
    double stated_index,
        stated_abbe; /* given beside a name, used if nothing better is known; 0: none */
} mcv_lens_glass;

typedef struct mcv_lens_surface {
    int line;                                          /* line of the file */
    double curvature, conic, thickness, semi_diameter; /* semi-diameter 0: not given */
    double asphere[MCV_ASPHERE_TERMS];
    mcv_lens_glass glass; /* behind it */
    bool unsure;          /* `curvature` may be a radius */
    bool image_solve;     /* `thickness` leads to the paraxial image */
} mcv_lens_surface;

/* The meaning of the value of an aperture or field. */
typedef enum mcv_lens_aperture {
    MCV_LENS_STOP_SIZE, /* no value: the semi-diameter of the stop, or of the surfaces, limits the
                           bundle */
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
    double focal_length; /* as the file states it, 0: not stated */
    int stop, count;     /* stop 0: none given */
    mcv_lens_surface surfaces[MCV_LENS_SURFACES];
    mcv_lens_glass glasses[MCV_LENS_GLASSES]; /* defined in the file */
    int glass_count;
    mcv_lens_report *report;
} mcv_lens;

/* --- text (lens_text.c) --- */

/* Converts UTF-16 (with a byte order mark, or recognised by its zeros), UTF-8 or Latin-1 to UTF-8
 * that ends with 0 and contains no other 0; the caller frees it. */
mcv_result mcv_lens_text_load(const char *path, char **text, mcv_error *error);

/* Splits a statement into words in place, quoted ones as one; returns their number. */
int mcv_lens_split(char *statement, char *words[MCV_LENS_WORDS]);

bool mcv_lens_is(const char *word, const char *other); /* ignores case */
bool mcv_lens_is_one_of(const char *word,
                        const char *list); /* a list of words, each with blanks around it */
void mcv_lens_copy_name(char out[MCV_LENS_NAME], const char *text); /* cut at a whole character */

/* Reads a number below 1e30, or a distance, which may be infinite. */
mcv_result mcv_lens_number(const mcv_lens *l, const char *word, double *value, mcv_error *error);

mcv_result mcv_lens_distance(const mcv_lens *l, const char *word, double *value, mcv_error *error);

/* Fails with MCV_BAD_INPUT: "PATH: line N: surface K: what"; the line only if above 0, the surface
 * unless it is -1. */
mcv_result mcv_lens_fail(const mcv_lens *l, int line, int surface, mcv_error *error,
                         const char *format, ...) __attribute__((format(printf, 5, 6)));
void mcv_lens_warn(mcv_lens *l, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Appends an empty surface with the current line. */
mcv_result mcv_lens_add_surface(mcv_lens *l, mcv_error *error);

/* --- readers --- */

mcv_result mcv_lens_zemax_read(mcv_lens *l, char *text, mcv_error *error);
mcv_result mcv_lens_codev_read(mcv_lens *l, mcv_lens_shape shape, char *text, mcv_error *error);

/* --- glasses (lens_glass.c) --- */

/* Finds the glass behind each surface; `indices` as in mcv_lens_options. */
mcv_result mcv_lens_find_glasses(mcv_lens *l, const char *const *indices, size_t index_count,
                                 mcv_error *error);

/* n_d and V_d from indices at one or more wavelengths [nm], interpolated linearly in 1/λ²; false if
 * this is not a glass. */
bool mcv_lens_fit_glass(mcv_lens_glass *glass, const double *wavelengths, const double *indices,
                        int count);

/* The index behind a surface at a wavelength [m]. */
double mcv_lens_index(const mcv_lens_surface *s, double wavelength);

/* --- first-order optics (lens_first_order.c) --- */

/* NAN if a quantity does not exist; distances count from the last surface that bounds glass. */
typedef struct mcv_lens_first_order {
    double focal_length, back_focus;
    double object_distance; /* INFINITY */
    double image_distance; /* of the axial object point; for an object at infinity the back focus */
    double stated_image_distance;
    double f_number;         /* focal length over entrance pupil */
    double working_f_number; /* 1/(2 u') */
} mcv_lens_first_order;

/* Does the surface bound glass? */
bool mcv_lens_bounds_glass(const mcv_lens *l, int surface);

/* Computes the thickness of the last gap if the file requests the paraxial image. */
void mcv_lens_solve_image(mcv_lens *l);

/* Does the axial bundle pass each surface at a height below its radius of curvature, and within the
 * semi-diameters? */
bool mcv_lens_is_possible(const mcv_lens *l);

/* The f-numbers are those of the stated aperture; with `as_written` those that the semi-diameters
 * of stop and bodies give. */
mcv_lens_first_order mcv_lens_trace(const mcv_lens *l, bool as_written);

/*
 * Finds the semi-diameters of those of the surfaces first … end - 1 for which `given` is false:
 * that of the other face of the body, else the width of the bundle. MCV_BAD_INPUT if the width
 * cannot be determined.
 */
mcv_result mcv_lens_find_semi_diameters(mcv_lens *l, int first, int end, const bool *given,
                                        mcv_error *error);

/* --- glTF (lens_write.c) --- */

/* The surfaces first … end - 1, and a stop that is not a surface of a body; positions count from
 * the first glass. NULL without memory. */
json_t *mcv_lens_write(const mcv_lens *l, int first, int end);

#endif
