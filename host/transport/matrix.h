/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A light transport matrix: what each element of the emitters brings to each pixel. Its product
 * with a pattern, a value per element, is the image that the pattern makes.
 *
 * Row (pixel, channel) has the number pixel * channels + channel; columns are elements (emitter by
 * emitter, of an image row by row) and, in a thinned matrix, one more for what was dropped. Values
 * are those of the image: irradiance [W/m²] or radiance [W/(m² sr)] of the pixel for a pattern of
 * 1, which is an image of ones at the emitter's radiance.
 *
 * All values are multiples of one power of two, small enough that each row's sum is exact in double
 * in any order: rows of a thinned matrix have the sums of the whole one, to the bit.
 */
#ifndef MCVISI_HOST_TRANSPORT_MATRIX_H
#define MCVISI_HOST_TRANSPORT_MATRIX_H

#include "film/film.h"
#include "scene/scene.h"
#include "transport/gather.h"

#include <jansson.h>

/* The elements of an emitter. */
typedef struct mcv_element_group {
    char *emitter;          /* its name */
    char *type;             /* as in scenes: "telecentricProjector" */
    uint32_t first;         /* column of its first element */
    uint32_t width, height; /* of the image whose pixels are elements; 1 x 1: it is one element */
    double radiance[3];     /* (irradiance, intensity) that a pattern of 1 stands for, by channel */
    double to_world[12];    /* rows of rotation and scale, then the position: of its node */
    uint32_t binning[2];    /* pixels of the image that an element holds, across and down */
    double size[2];         /* of a rectangle that emits [m]; else 0 */
    double slope_range[2];  /* of a projector: the width and height that it lights at 1 m [m]; else
                               0 */
    bool mirror;            /* whether columns run along -x of its node */
    uint32_t angular[2];    /* of a light field emitter: directions J, K of a macro pixel; else 0 */
    double angular_range;   /* and the sine of the largest angle */
} mcv_element_group;

typedef struct mcv_matrix {
    uint32_t width, height, channels, replicates;
    uint64_t samples; /* per pixel and replicate */
    double kept;      /* share of each row that thinning has kept; 1: all */
    mcv_element_group *groups;
    uint32_t group_count;
    uint32_t element_count;
    size_t row_count;      /* width * height * channels */
    uint32_t column_count; /* elements, and 1 for what was dropped if kept < 1 */
    uint64_t *row_begins;  /* row_count + 1 */
    uint32_t *columns;     /* of each entry, ascending in a row */
    double *values;        /* mean over the replicates */
    float *replicates_of;  /* [entry][replicate]: the value by each replicate */
    float *pattern;        /* [element][channel]: that of the scene */
    json_t *attributes;    /* those of the image's header */
} mcv_matrix;

/*
 * From what was gathered. `elements`: of the scene's emitters. The groups, pattern and
 * attributes are empty. Keeps the strongest entries of each row that make up the share `keep` of
 * its sum, 0 < keep <= 1; the others are added up in one more column, whose value in a pattern is
 * the mean of the pattern. MCV_BAD_INPUT if the matrix has no room in the gather's memory.
 */
mcv_result mcv_matrix_make(mcv_gather *gather, uint32_t width, uint32_t height, uint64_t samples,
                           uint32_t elements, double keep, mcv_matrix *matrix, mcv_error *error);

/*
 * The image of a pattern, [element][channel], and its standard error from the replicates (NaN of a
 * single one). Entries of one pixel share rays, so that only the replicates give its error.
 */
mcv_result mcv_matrix_relight(const mcv_matrix *matrix, const float *pattern, mcv_image *mean,
                              mcv_image *deviation, mcv_error *error);

/* The group of the emitter of this name, or NULL. */
const mcv_element_group *mcv_matrix_group(const mcv_matrix *matrix, const char *emitter);

void mcv_matrix_free(mcv_matrix *matrix);

#endif
