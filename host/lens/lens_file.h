/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens files of design programs, .zmx (Zemax OpticStudio; UTF-16, UTF-8 or Latin-1) and .seq (CODE
 * V), as glTF with MCVISI_surfaces. Supported are spherical, conic and even aspheric surfaces,
 * glasses of the catalogue or with a given index, and the stop, as a disc with a hole.
 * Semi-diameters are those of the file. Missing ones are computed to first order from the axial and
 * the outermost bundle, with a margin of a twentieth.
 */
#ifndef MCVISI_HOST_LENS_LENS_FILE_H
#define MCVISI_HOST_LENS_LENS_FILE_H

#include <jansson.h>
#include <stdbool.h>

#include "core/error.h"

typedef enum mcv_lens_shape {
    MCV_LENS_SHAPE_AUTO,
    MCV_LENS_SHAPE_RADIUS,
    MCV_LENS_SHAPE_CURVATURE
} mcv_lens_shape;

typedef struct mcv_lens_options {
    const char *const *indices; /* NAME=N for glasses that are not in the catalogue */
    size_t index_count;
    mcv_lens_shape shape; /* meaning of the surfaces' numbers in a .seq file; AUTO: as the file
                             says, else the one that focuses */
} mcv_lens_options;

enum { MCV_LENS_WARNINGS = 16 };

/* First-order figures of the lens [m] at the primary wavelength, and those that the file states;
 * NAN if there is none. */
typedef struct mcv_lens_report {
    double wavelength;
    double focal_length, stated_focal_length;
    double back_focus; /* from the last surface that bounds glass */
    double image_distance,
        stated_image_distance;        /* the same for the axial object point of the file */
    double object_distance;           /* from the first surface; INFINITY */
    double f_number, stated_f_number; /* focal length over entrance pupil, of the lens as written */
    bool working;                     /* they are 1/(2 u') of the file's object distance instead */
    char warnings[MCV_LENS_WARNINGS][300];
    int warning_count;
} mcv_lens_report;

/* *scene is a glTF document, which the caller releases. MCV_BAD_INPUT names file, line and surface;
 * MCV_USAGE is for wrong options. */
mcv_result mcv_lens_file_read(const char *path, const mcv_lens_options *options, json_t **scene,
                              mcv_lens_report *report, mcv_error *error);

#endif
