/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Profiles: the laser line of an image, and the points of the part that it lights. A point lies
 * where the chief ray of its place in the image meets the plane of the light:
 *
 *     P = C + d (n · (P0 - C))/(n · d).
 */
#ifndef MCVISI_HOST_TRIANGULATION_PROFILE_H
#define MCVISI_HOST_TRIANGULATION_PROFILE_H

#include "core/error.h"
#include "film/film.h"
#include "scene/camera_model.h"
#include "triangulation/laser_line.h"

/* A point of a profile. */
typedef struct mcv_profile_point {
    mcv_line_place line;
    double uncertainty; /* of the place, speckle included; NaN: not known [pixel] */
    double at[3];       /* [m]; NaN without a place, or where the ray does not meet the plane */
    double u_z;         /* standard uncertainty of at[2] [m] */
} mcv_profile_point;

typedef struct mcv_profile_settings {
    mcv_line_settings line;
    double threshold_share; /* line.threshold over the brightest value */
    bool rows;              /* a place in each row, not in each column */
    /* Of the laser's light on the film, for speckle; contrast 0: there is none, or it is not known
     */
    double contrast, wavelength;        /* [1, m] */
    const mcv_aperture_shape *aperture; /* what of the stop is open; NULL: the full disc */
    /* With heights: */
    const mcv_transform *laser; /* of the node, whose xz plane is that of the light; or NULL */
    const mcv_transform *frame; /* coordinates of points; not NULL beside a laser */
    double feed;                /* along the laser's y: that the part has moved [m] */
} mcv_profile_settings;

/* How many points a profile of the image has. */
uint32_t mcv_profile_length(const mcv_profile_settings *settings, const mcv_image *values);

/*
 * Finds them in an image of one channel. `deviations` are standard uncertainties of its values, or
 * NULL; `model`: of the image, needed for heights and speckle, else NULL.
 */
void mcv_profile_find(const mcv_profile_settings *settings, const mcv_image *values,
                      const mcv_image *deviations, const mcv_camera_model *model,
                      mcv_profile_point *points);

/* Where the chief ray of a place of the image meets the xz plane of a node; false where it does not
 * meet it before a perspective camera. */
bool mcv_triangulate(const mcv_camera_model *model, const mcv_transform *laser,
                     const double place[2], double world[3]);

/* Root of the mean square of the heights about each profile's straight line, and how many points
 * it is of. `length` points make a profile. */
double mcv_profile_residual(const mcv_profile_point *points, size_t count, size_t length,
                            uint64_t *used);

#endif
