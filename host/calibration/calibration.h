/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Camera models (scene/camera_model.h) in the formats of other programs, both ways.
 *
 * OpenCV, ROS and HALCON count pixels from the centre of the first one: 1/2 is taken off c_x and
 * c_y. COLMAP and our own JSON count from the image's corner. All poses are those of the camera in
 * the world's coordinates, as R X + t, in metres.
 */
#ifndef MCVISI_HOST_CALIBRATION_CALIBRATION_H
#define MCVISI_HOST_CALIBRATION_CALIBRATION_H

#include "scene/camera_model.h"

#include <jansson.h>

/* X(NAME, "word of --format", "name of the program"), in the order of that option's words. */
#define MCV_CALIBRATIONS(X) \
    X(JSON, "json", "MC ViSi") \
    X(OPENCV, "opencv", "OpenCV") \
    X(ROS, "ros", "ROS") \
    X(HALCON, "halcon", "HALCON") \
    X(COLMAP, "colmap", "COLMAP")

typedef enum mcv_calibration_format {
#define MCV_X(NAME, word, program) MCV_CALIBRATION_##NAME,
    MCV_CALIBRATIONS(MCV_X)
#undef MCV_X
} mcv_calibration_format;

/* COLMAP has a folder of three files, in this order; other formats have one. */
enum { MCV_CALIBRATION_FILES = 3 };
extern const char *const mcv_colmap_files[MCV_CALIBRATION_FILES];

/* Texts of files, to be freed; NULL: none. */
typedef struct mcv_calibration_texts {
    char *items[MCV_CALIBRATION_FILES];
} mcv_calibration_texts;
void mcv_calibration_texts_free(mcv_calibration_texts *texts);

/* Writes the model of the sensor `name`. MCV_BAD_INPUT for a camera that the format cannot hold. */
mcv_result mcv_calibration_write(const mcv_camera_model *model, const char *name,
                                 mcv_calibration_format format, mcv_calibration_texts *texts,
                                 mcv_error *error);

/* A camera of a file. What the file does not state is 0: pixel, object_pixel; NaN: f_number,
 * focused_depth. The model has no nodes. */
typedef struct mcv_calibration {
    mcv_camera_model model;
    char name[128]; /* or "" */
    bool posed;     /* the file states R and t; else they are those of the world's origin */
} mcv_calibration;

/*
 * Reads a file of any of the formats, or COLMAP's folder: its contents tell which one it is.
 * MCV_BAD_INPUT with the file and what is wrong; also for distortion that sensors do not have.
 */
mcv_result mcv_calibration_read(const char *path, mcv_calibration *camera, mcv_error *error);

/*
 * Adds the camera to a glTF document: a sensor `name` of type pinhole or telecentric, and a node
 * with its pose. `pixel`: width of a pixel where the file does not state it [m]. MCV_USAGE where
 * the document has such a sensor already.
 */
mcv_result mcv_calibration_add(const mcv_calibration *camera, const char *path, const char *name,
                               double pixel, json_t *document, mcv_error *error);

/* --- the parts --- */

/* read_yaml.c and read_halcon.c: of the text of a file; read_colmap.c: of a folder. */
mcv_result mcv_calibration_read_yaml(const char *path, const char *text, mcv_calibration *camera,
                                     mcv_error *error);
mcv_result mcv_calibration_read_halcon(const char *path, const char *text, mcv_calibration *camera,
                                       mcv_error *error);

mcv_result mcv_calibration_read_colmap(const char *folder, mcv_calibration *camera,
                                       mcv_error *error);

/* read.c: the text of a file, to be freed, without a mark of UTF-8 before it. */
mcv_result mcv_calibration_load(const char *path, char **text, mcv_error *error);

/* read.c: width and height of the image [pixel]; MCV_BAD_INPUT where they are no whole numbers. */
mcv_result mcv_calibration_set_size(const char *path, const double size[2], mcv_calibration *camera,
                                    mcv_error *error);

/* read.c: sets K and its like, c counted from the corner; checks lengths and the pose. */
mcv_result mcv_calibration_set_perspective(const char *path, const double focal[2],
                                           const double centre[2], mcv_calibration *camera,
                                           mcv_error *error);
mcv_result mcv_calibration_set_telecentric(const char *path, const double object_pixel[2],
                                           const double centre[2], mcv_calibration *camera,
                                           mcv_error *error);

/* read.c: MCV_BAD_INPUT where one of the numbers of distortion is not finite. */
mcv_result mcv_calibration_check_numbers(const char *path, const double *numbers, size_t count,
                                         mcv_error *error);

/* lens.c: OpenCV's coefficients, of which it takes 5, 8, 12 or all; the rest is 0. */
enum { MCV_OPENCV_COEFFICIENTS = 14 };
int mcv_lens_to_opencv(const mcv_lens_map *map, double coefficients[MCV_OPENCV_COEFFICIENTS]);
void mcv_lens_of_opencv(const double coefficients[MCV_OPENCV_COEFFICIENTS], mcv_lens_map *map);

/* lens.c: HALCON's Tilt, not below 0, and Rot, from 0 to 360 [degrees]. */
void mcv_lens_to_halcon(const mcv_lens_map *map, double *tilt, double *rot);

/* lens.c: MCV_BAD_INPUT where the format cannot hold tilt and distortion of the model. */
mcv_result mcv_calibration_check_lens(const mcv_camera_model *model, const char *name,
                                      mcv_calibration_format format, const char *program,
                                      mcv_error *error);

/* The middle of a telecentric image: what the projection of the camera's axis is. */
void mcv_calibration_centre(const mcv_camera_model *model, double centre[2]);

/* rotation.c: rotations by rows. Quaternions are w, x, y, z, and need not be of length 1; a
 * rotation vector is axis times angle; HALCON's "gba" is R_x R_y R_z of three angles [degrees]. */
void mcv_rotation_to_quaternion(const double r[9], double q[4]);
void mcv_rotation_of_quaternion(const double q[4], double r[9]);
void mcv_rotation_to_vector(const double r[9], double v[3]);
void mcv_rotation_of_vector(const double v[3], double r[9]);
void mcv_rotation_to_gba(const double r[9], double degrees[3]);
void mcv_rotation_of_gba(const double degrees[3], double r[9]);

#endif
