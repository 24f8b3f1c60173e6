/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens prescriptions of design programs, .zmx (Zemax OpticStudio; UTF-16, UTF-8 or Latin-1) and
 * .seq (CODE V), as glTF with MCVISI_surfaces: spherical, conic and even aspheric surfaces of
 * glasses of the catalogue or of a given index, and the stop as a disc with a hole. Semi-diameters
 * are the file's; where it gives none, those that the axial and the outermost bundle need to first
 * order, and a twentieth more.
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
    const char *const *indices; /* NAME=N of glasses that the catalogue lacks */
    size_t index_count;
    mcv_lens_shape shape; /* what the surfaces of a .seq file are given by; AUTO: what the file
                             says, else which of both focuses */
} mcv_lens_options;

enum { MCV_LENS_WARNINGS = 16 };

/* First-order figures of the lens [m] at the primary wavelength, and what the file states of them;
 * NAN where there is none. */
typedef struct mcv_lens_report {
    double wavelength;
    double focal_length, stated_focal_length;
    double back_focus; /* from the last surface that bounds glass */
    double image_distance,
        stated_image_distance;        /* likewise, of the axial object point of the file */
    double object_distance;           /* from the first surface; INFINITY */
    double f_number, stated_f_number; /* focal length over entrance pupil, as the lens is written */
    bool working;                     /* they are 1/(2 u') of the file's object distance instead */
    char warnings[MCV_LENS_WARNINGS][300];
    int warning_count;
} mcv_lens_report;

/* *scene is a glTF document; the caller releases it. MCV_BAD_INPUT names file, line and surface;
 * MCV_USAGE where an option is wrong. */
mcv_result mcv_lens_file_read(const char *path, const mcv_lens_options *options, json_t **scene,
                              mcv_lens_report *report, mcv_error *error);

#endif
