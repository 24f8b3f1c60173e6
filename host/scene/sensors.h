/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors on the host: quantities derived from their parameters, in double. */
#ifndef MCVISI_HOST_SCENE_SENSORS_H
#define MCVISI_HOST_SCENE_SENSORS_H

#include "core/json_path.h"
#include "scene/scene.h"

/* Fills in derived parameters; refuses contradictions and what the sensor does not support. */
#define MCV_SENSOR_FUNCTIONS(name, key, NAME) \
    mcv_result mcv_##name##_resolve(mcv_##name##_params *params, const mcv_json_path *place, \
                                    mcv_error *error); \
    void mcv_##name##_prepare(const mcv_##name##_params *params, mcv_##name *device);
MCV_SENSORS(MCV_SENSOR_FUNCTIONS)
#undef MCV_SENSOR_FUNCTIONS

/* Checks required parameters and ranges by the table, then resolves. */
mcv_result mcv_sensor_resolve(mcv_sensor *sensor, const mcv_json_path *place, mcv_error *error);

/* The type that the scene tells: a laser triangulation head is rendered as a thin lens. */
static inline uint32_t mcv_sensor_told_type(const mcv_sensor *sensor) {
    return sensor->is_head ? MCV_SENSOR_LASER_TRIANGULATION : sensor->type;
}

/* κ = (b - f)/(b f), the inverse of the focused depth [1/m]. */
static inline double mcv_kappa(double focal_length, double image_distance) {
    return (image_distance - focal_length) / (image_distance * focal_length);
}

/* The parameters that MCV_LENS_PARAMS gives an element. */
typedef struct mcv_lens {
    double f, *b, *w, *diameter, *f_number;
} mcv_lens;

/* Derives b and D from the parameters that may replace them, and the reverse. A focus at infinity
 * or behind the lens has no focusDistance. */
mcv_result mcv_lens_resolve(mcv_lens l, const mcv_json_path *place, mcv_error *error);

/* The region of the film that is read out, in pixels; for a light field camera in macro pixels. */
typedef struct mcv_readout {
    uint32_t film[2];    /* of the whole film */
    uint32_t first[2];   /* column and row of the first that is read out */
    uint32_t size[2];    /* of the image, binned */
    uint32_t binning[2]; /* that make one of the image */
    uint32_t angular[2]; /* pixels of a macro pixel; 1 of a pixel */
    double pitch[2];     /* [m] */
    double centre[2];    /* the principal point, from the film's top-left corner */
} mcv_readout;
mcv_readout mcv_sensor_readout(const mcv_sensor *sensor);

/*
 * The quantities of a datasheet: lengths in m, angles in rad, NaN if the sensor does not have the
 * quantity. They are those of first-order optics of the thin lens, on the axis. The depth of field
 * of a light field camera is that of its sub-aperture views: their pixel is a macro pixel, their
 * aperture one of J x K parts of the lens.
 */
typedef struct mcv_optics {
    double focused_depth;  /* from the main lens to the plane in focus, 1/κ; infinite, or negative
                              where it is virtual */
    double magnification;  /* image size over object size in that plane: 0 at infinity, negative
                              where it is virtual */
    double field[2];       /* width and height seen in that plane (infinite at infinity) */
    double field_angle[2]; /* full angles of view; 0 for telecentric */
    double
        f_number; /* working, image side: distance over diameter of the cone that meets the image */
    double numerical_aperture; /* object side, radius over distance of the cone that leaves the
                                  plane in focus */
    double depth_of_field[2];  /* depths of the nearest and the farthest plane blurred by one pixel;
                                  may be infinite */
    double macro_pixel[2];     /* pitch of the macro pixels */
    double object_tilt;     /* of the plane in focus against the lens, of a tilted film; else NaN */
    double plane_depths[2]; /* least and largest depth in focus at the corners of what is read out;
                               focused_depth of a film that is not tilted */
} mcv_optics;
mcv_optics mcv_sensor_optics(const mcv_sensor *sensor);

/* Pixels of the sensor's image. */
void mcv_sensor_film_size(const mcv_sensor *sensor, uint32_t *width, uint32_t *height);

#endif
