/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters of scene elements. Each element (a sensor, an emitter, a material) has one list
 *
 *     X(kind, key, default, min, max, "doc [unit]")
 *
 * The list generates the struct that the host works with (SI, double), the parser, --set, `mcvisi
 * check`, the help and the JSON schema. Its kinds are length, angle, number, integer, int2, int4,
 * length2, number2, spectrum, choice, flag, image, pattern, mask, curve and text.
 *
 * Both ends of [min, max] are allowed; MCV_POSITIVE as min means "above 0". A default of
 * MCV_REQUIRED means that the key must be given. A default of MCV_UNSET is NaN (0 for integer and
 * int2, MCV_NONE for int4, image and pattern) until the element's resolve function derives the
 * value or leaves it out.
 *
 * A choice has the name of an option as default; min and max are the first and the last index that
 * the element has. Its options stand in MCV_CHOICES below. A flag is true or false, 1 or 0. An
 * image is the index or the name of one of the file's images, or {"uri": FILE.exr}; the loader
 * replaces it by the index of a texture. A pattern is an object (mcvisi/pattern.h). A mask is a
 * square array of rows, the upper one first, of numbers from 0 to 1. A curve is an array of pairs
 * of a length, which grows, and a number above 0; between them it is straight. A text is a name or
 * a path.
 */
#ifndef MCVISI_PARAMS_H
#define MCVISI_PARAMS_H

#include "mcvisi/dialect.h"

/* The options of the choice `aperture`. */
enum {
    MCV_APERTURE_SQUARE,
    MCV_APERTURE_CIRCLE,
    MCV_APERTURE_DISC,
    MCV_APERTURE_RING,
    MCV_APERTURE_HALF,
    MCV_APERTURE_BLADES,
    MCV_APERTURE_CODED,
    MCV_APERTURE_MASK
};

#define MCV_MASK_SIDE 32    /* cells of a side at most */
#define MCV_CURVE_POINTS 16 /* pairs at most */

#if !MCV_ON_DEVICE

#include <float.h>
#include <stddef.h>

#define MCV_POSITIVE DBL_MIN
#define MCV_REQUIRED (-1e300)
#define MCV_UNSET (-2e300)

/* The fields of each kind in a parameter struct. length2, number2 and int2 also accept one number
 * for both fields. */
#define MCV_FIELD_length(key) double key;
#define MCV_FIELD_angle(key) double key;
#define MCV_FIELD_number(key) double key;
#define MCV_FIELD_integer(key) uint32_t key;
#define MCV_FIELD_int2(key) uint32_t key[2];
#define MCV_FIELD_int4(key) uint32_t key[4];
#define MCV_FIELD_length2(key) double key[2];
#define MCV_FIELD_number2(key) double key[2];
#define MCV_FIELD_spectrum(key) double key[3]; /* a number is grey, an array is R, G, B */
#define MCV_FIELD_choice(key) int key;
#define MCV_FIELD_flag(key) int key;
#define MCV_FIELD_image(key) uint32_t key; /* index into the scene's textures */
#define MCV_FIELD_pattern(key) mcv_pattern key;
#define MCV_FIELD_mask(key) mcv_mask key;
#define MCV_FIELD_curve(key) mcv_curve key;
#define MCV_FIELD_text(key) char key[MCV_TEXT_BYTES];

#define MCV_DEFINE_FIELD(kind, key, default_value, min, max, doc) MCV_FIELD_##kind(key)

/* X(key, "option 0", "option 1" …): the options of each choice key, in the order of its enum. */
#define MCV_CHOICES(X) \
    X(radiometry, "radiance", "irradiance") \
    X(falloff, "objectSide", "imageSide") \
    X(aperture, "square", "circle", "disc", "ring", "half", "blades", "coded", "mask") \
    X(orientation, "vertical", "horizontal") \
    X(shutter, "global", "rolling", "line") \
    X(shape, "gaussian", "cosine") \
    X(profile, "V", "U") \
    X(widthMeasure, "none", "1/e2", "FWHM") \
    X(fanProfile, "plane", "angle", "gaussian", "table") \
    X(extractor, "cog", "parabola", "logGauss", "blaisRioux", "gauss", "steger") \
    X(across, "columns", "rows") \
    X(metal, "aluminium", "chromium", "copper", "gold", "iron", "nickel", "silver", "titanium") \
    X(glass, "none", "N-BK7", "N-K5", "N-BAK4", "N-SK2", "N-SK16", "N-SSK2", "N-LAK8", "N-LAK22", \
      "N-LASF9", "N-BAF10", "F2", "N-F2", "F5", "SF5", "N-SF5", "SF6", "N-SF6", "N-SF10", \
      "N-SF11", "N-SF57", "N-FK51A", "fusedSilica", "water", "PMMA", "polycarbonate")

enum { MCV_RADIOMETRY_RADIANCE, MCV_RADIOMETRY_IRRADIANCE };
enum { MCV_FALLOFF_OBJECT_SIDE, MCV_FALLOFF_IMAGE_SIDE };
enum { MCV_ORIENTATION_VERTICAL, MCV_ORIENTATION_HORIZONTAL };

typedef enum mcv_param_kind {
    MCV_PARAM_length,
    MCV_PARAM_angle,
    MCV_PARAM_number,
    MCV_PARAM_integer,
    MCV_PARAM_int2,
    MCV_PARAM_int4,
    MCV_PARAM_length2,
    MCV_PARAM_number2,
    MCV_PARAM_spectrum,
    MCV_PARAM_choice,
    MCV_PARAM_flag,
    MCV_PARAM_image,
    MCV_PARAM_pattern,
    MCV_PARAM_mask,
    MCV_PARAM_curve,
    MCV_PARAM_text,
} mcv_param_kind;

/* A sequence of patterns. Parameters that its type does not have are 0. */
typedef struct mcv_pattern {
    uint32_t type; /* MCV_PATTERN_…, or MCV_NONE if none is given */
    uint32_t steps;
    double periods;
    int orientation;
    uint32_t resolution[2];
} mcv_pattern;

/* The numbers of a mask, row by row. */
typedef struct mcv_mask {
    uint32_t side; /* 0: none is given */
    float values[MCV_MASK_SIDE * MCV_MASK_SIDE];
} mcv_mask;

/* The pairs of a curve. */
typedef struct mcv_curve {
    uint32_t count; /* 0: none is given */
    double at[MCV_CURVE_POINTS], value[MCV_CURVE_POINTS];
} mcv_curve;

#define MCV_TEXT_BYTES 256 /* of a text at most, with its end */

/* One row of an element's parameter table; `offset` points into its parameter struct. */
typedef struct mcv_param {
    mcv_param_kind kind;
    const char *key;
    size_t offset;
    double default_value, min, max;
    const char *doc;
} mcv_param;

#endif /* !MCV_ON_DEVICE */

#endif
