/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a point of the world lies in an image, as the headers of images say it (JSON, the same text
 * in OpenEXR, PNG and TIFF).
 *
 * Pixels count from the image's top-left corner, columns to the right and rows down, as those of
 * --region and principalPoint do: the centre of the first pixel is (1/2, 1/2). OpenCV, ROS and
 * HALCON count from that centre: take 1/2 from c_x and c_y (or from the last column of `affine`)
 * for them. COLMAP counts as we do.
 *
 * The camera's axes are those of computer vision: x right, y down, z forward, so that p = R X + t
 * lies before it where p_z > 0. The node of the sensor looks along its -z with +y up: R = diag(1,
 * -1, -1) times the inverse of the node's rotation.
 *
 *     perspective:  column = k_xx p_x/p_z + c_x, row = k_yy p_y/p_z + c_y, with K = [k_xx 0 c_x; 0
 * k_yy c_y; 0 0 1] by rows; k_xx is the image distance over the width of a pixel telecentric:
 * (column, row) = A (X, 1), A of 2 x 4 by rows: the same at every depth
 *
 * Tilt of the film and distortion come behind: with (u, v) the place less the centre, over h and
 * the width and height of a pixel, the lens maps it (scene/lens_map.h), and back.
 *
 * This is the chief ray, which goes through the middle of lens or stop: a point out of focus is
 * spread about its place. What is read out of the film (region, binning, principal point) is in it.
 * A light field camera is perspective: of its image of M·J x N·K pixels a macro pixel, J x K of
 * them, shows one place of the plane in focus.
 */
#ifndef MCVISI_HOST_SCENE_CAMERA_MODEL_H
#define MCVISI_HOST_SCENE_CAMERA_MODEL_H

#include "scene/lens_map.h"
#include "scene/scene.h"

#include <jansson.h>

/* The key of its text in PNG files, and the attribute's name in OpenEXR. */
#define MCV_CAMERA_MODEL_KEY "mcvisi:cameraModel"

/* So many nodes stand in a header, the rig's before those of its assets. */
enum { MCV_CAMERA_MODEL_NODES = 64 };

/*
 * Of a cell of the image: the render's standard error [DN] of quiet pixels below a grey value, and
 * of those from it on. At an edge it grows with the grey values about a pixel: its square by edges²
 * (largest - value)(value - smallest) of the 3 x 3 pixels.
 */
typedef struct mcv_error_cell {
    double level, errors[2], edges[2];
} mcv_error_cell;

/* The render's own error of grey values (analysis/render_error.h); no items: not told. */
typedef struct mcv_render_error {
    uint32_t cells[2], channels; /* columns and rows of cells: pixel x lies in that of x
                                    columns/width, rounded down */
    double correlation[3];       /* sum, squares and stencil of mcv_correlation */
    double shared;               /* correlation of channels (mcv_film_channel_correlation) */
    double freedom;              /* degrees of freedom of each pixel's error */
    mcv_error_cell *items;       /* owned; [channel][row][column] */
} mcv_render_error;

typedef struct mcv_camera_model {
    bool telecentric;
    bool line;             /* rows of the image are times of one row of the film: no place of the
                              world can be told from the image, nor the other way */
    uint32_t size[2];      /* of the image */
    uint32_t macro[2];     /* pixels of a macro pixel; 1 of other cameras */
    double k[9];           /* perspective; 0 of a line */
    double affine[8];      /* telecentric */
    mcv_lens_map lens;     /* tilt of the film and distortion: K and A are without them */
    double film_distance;  /* h, by which lengths on the film are divided for `lens` [m] */
    double rotation[9];    /* R, by rows: from the world to the camera */
    double translation[3]; /* t [m] */
    double pixel[2]; /* width and height of a pixel (binned: of all that make it; light field: of a
                        macro pixel) on the film [m] */
    double focused_depth;   /* of the plane in focus, along the camera's z [m]; infinite or negative
                               where it is none */
    double object_pixel[2]; /* what a pixel (a macro pixel) sees there [m]; 0 where there is no such
                               plane, and of a line */
    double f_number;        /* working, on the image side; NaN of a pinhole */
    double numerical_aperture;      /* on the object side; NaN of a pinhole */
    double bits, black_level, gain; /* of grey values [1, DN, DN/e-]; NaN of light */
    mcv_render_error render_error;  /* of grey values */
    uint32_t node_count;
    mcv_placement *nodes; /* owned; named nodes of the scene */
} mcv_camera_model;

/* Of a sensor of the scene, with its nodes. MCV_FAILED without memory. */
mcv_result mcv_camera_model_of(const mcv_scene *scene, const mcv_sensor *sensor,
                               mcv_camera_model *model, mcv_error *error);
void mcv_camera_model_free(mcv_camera_model *model);

/*
 * Makes it that of an image of another size, in which each macro pixel is one pixel (a gradient, a
 * view). False where the image is neither that nor the whole: then the model says nothing of it.
 */
bool mcv_camera_model_fit(mcv_camera_model *model, uint32_t width, uint32_t height);

/* MCV_BAD_INPUT for a line's, which the functions below are not for; `what` needs the places. */
mcv_result mcv_camera_model_check_places(const mcv_camera_model *model, const char *what,
                                         mcv_error *error);

/* Column and row of a point of the world [m]; false where it does not lie before a perspective
 * camera, or where the lens's distortion folds back. */
bool mcv_camera_model_project(const mcv_camera_model *model, const double world[3],
                              double pixel[2]);

/* How deep a point lies along the camera's z [m], and how many pixels a metre across the axis has
 * there, along columns and rows; without tilt and distortion. */
double mcv_camera_model_depth(const mcv_camera_model *model, const double world[3]);
void mcv_camera_model_scale(const mcv_camera_model *model, double depth, double per_metre[2]);

/* The point of the world that a place of the image shows at a depth: the inverse of the projection.
 */
void mcv_camera_model_unproject(const mcv_camera_model *model, const double pixel[2], double depth,
                                double world[3]);

/* A node by its name, the rig's before its assets'. MCV_USAGE where there is none or several, with
 * the nearest name. `what` is where to look, for the message. */
mcv_result mcv_camera_model_node(const mcv_camera_model *model, const char *name, const char *what,
                                 const mcv_placement **frame, mcv_error *error);

/* As JSON, ASCII, on one line; the caller frees it. NULL without memory. Every number is read back
 * bit for bit. */
char *mcv_camera_model_write(const mcv_camera_model *model);

/* Puts tilt and distortion as a sensor's keys into an object, those that are not 0. */
void mcv_camera_model_put_lens(const mcv_camera_model *model, json_t *object);

/*
 * From such a text; *is_one tells whether it is one at all (headers hold other texts, too).
 * MCV_BAD_INPUT, with `path` and the member, where it is one but damaged; then the model is empty.
 */
mcv_result mcv_camera_model_read(const char *text, const char *path, mcv_camera_model *model,
                                 bool *is_one, mcv_error *error);

#endif
