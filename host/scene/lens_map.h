/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tilted films and lens distortion in double, both ways (mcvisi/sensors/distortion.h has the
 * formulas and the frame: x right, y down, lengths on the film over h).
 */
#ifndef MCVISI_HOST_SCENE_LENS_MAP_H
#define MCVISI_HOST_SCENE_LENS_MAP_H

#include "core/json_path.h"
#include "scene/scene.h"

typedef struct mcv_lens_map {
    bool tilted;
    uint32_t model;    /* MCV_UNDISTORTED … */
    double axes[2][3]; /* a1, a2 */
    double k[6], p[2], s[4];
    double kappa;           /* κ h² */
    double tilt, direction; /* HALCON's [rad]; NaN where tiltX and tiltY are given */
    double tilt_xy[2];      /* OpenCV's [rad]; NaN where tilt is given */
    double reach; /* largest |u| before the distortion folds; infinite where it never does */
} mcv_lens_map;

/* A film without tilt before a lens without distortion. */
mcv_lens_map mcv_lens_map_none(void);

/* Sets the film's axes from HALCON's angles, or from OpenCV's. */
void mcv_lens_map_tilt(mcv_lens_map *map, double tilt, double direction);
void mcv_lens_map_tilt_xy(mcv_lens_map *map, double x, double y);

/* Leaves the distortion out, but not the tilt. */
void mcv_lens_map_forget(mcv_lens_map *map);

/* Sets `reach`, of a map whose other members are set. */
void mcv_lens_map_find_reach(mcv_lens_map *map);

/* Does anything differ from a film across the axis and a lens without distortion? */
static inline bool mcv_lens_map_is_used(const mcv_lens_map *map) {
    return map->tilted || map->model != 0;
}

/* Slopes without distortion to distorted ones, and back. The second is false where no slope within
 * the reach gives `s`, or so many steps as the device takes do not find it. */
void mcv_lens_map_distort(const mcv_lens_map *map, const double u[2], double s[2]);
bool mcv_lens_map_undistort(const mcv_lens_map *map, const double s[2], double u[2]);

/* From a place on the film to the chief ray's slope, and the stretch e; and back. False where there
 * is none. */
bool mcv_lens_map_look(const mcv_lens_map *map, const double film[2], double u[2], double *stretch);
bool mcv_lens_map_meet(const mcv_lens_map *map, const double u[2], double film[2]);

/* The parameters of a sensor as a map, with an infinite reach: none for a light field camera. */
mcv_lens_map mcv_sensor_lens_map(const mcv_sensor *sensor);

/* h: the distance from the centre of the aperture to the film along the axis [m]. */
double mcv_sensor_film_distance(const mcv_sensor *sensor);

/*
 * Derives k1 from what a datasheet states; refuses contradictions, a film that meets the lens and a
 * distortion that folds back within the film. The sensor's other parameters are resolved. Nothing
 * for a light field camera.
 */
mcv_result mcv_sensor_resolve_distortion(mcv_sensor *sensor, const mcv_json_path *place,
                                         mcv_error *error);

/* For the device: `from` are those of the sensor from `tilt` on, h its film's distance. */
void mcv_distortion_prepare(const void *from, double h, mcv_distortion *device);

#endif
