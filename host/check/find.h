/* SPDX-License-Identifier: Apache-2.0 */
/* What the functions behind the list of findings share (check/findings.h). */
#ifndef MCVISI_HOST_CHECK_FIND_H
#define MCVISI_HOST_CHECK_FIND_H

#include "check/findings.h"
#include "scene/sensors.h"

#define MCV_X(name) \
    mcv_result mcv_find_##name(const mcv_scene *scene, mcv_findings *findings, mcv_error *error);
MCV_FINDINGS(MCV_X)
#undef MCV_X

/* A length as people read it, "4.8 mm". */
const char *mcv_length_in_words(double metres, char text[32]);

/* Length of an instance's label in a sentence: node "part", or its mesh if the node has no name. */
enum { MCV_LABEL = 96 };
const char *mcv_instance_label(const mcv_scene *scene, uint32_t instance, char text[MCV_LABEL]);

static inline double mcv_dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The end of a node's primitives, which are consecutive instances with one name. */
uint32_t mcv_node_end(const mcv_scene *scene, uint32_t first);

/* The end of a body's primitives: consecutive instances with one name and one placement. */
uint32_t mcv_body_end(const mcv_scene *scene, uint32_t first);

/* Neither the instance nor its node emits: housings and half mirrors belong to lights. */
bool mcv_is_part(const mcv_scene *scene, uint32_t instance);

/*
 * Walks over the instances that are parts, each node looked at once:
 *
 *     for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end); i < scene->instance_count;
 *          i = mcv_next_part(scene, i + 1, &end))
 *
 * The first part from `i` on, or the number of instances. end: the end of the parts that are known.
 */
uint32_t mcv_next_part(const mcv_scene *scene, uint32_t i, uint32_t *end);

/* Does a smooth surface change the direction of rays, so that what is seen lies elsewhere? */
bool mcv_is_mirror(const mcv_material *material);

/* Half of the lens's width, in the corner of a square one; 0 for a pinhole [m]. */
double mcv_lens_radius(const mcv_sensor *sensor);

/* The image that is read out, relative to the axis; x is right and y up in the scene. Units:
 * tangents, for telecentric cameras metres of the object. */
typedef struct mcv_view {
    const mcv_sensor *sensor;
    mcv_optics optics;
    double film[2]
               [2];  /* [x, y][lower, upper]: telecentric, of the object [m]; otherwise tangents */
    double pixel[2]; /* of the image, in the same units; for a light field camera a macro pixel */
    bool is_telecentric;
} mcv_view;
mcv_view mcv_view_of(const mcv_sensor *sensor);

/* The smaller side of a pixel at a depth, on the object's side [m]. */
double mcv_view_pixel(const mcv_view *view, double depth);

/* A point of the world in the sensor's frame: right, up, depth. */
void mcv_view_point(const mcv_view *view, const double world[3], double local[3]);

/* The position of a point in the image, in the units of film; false if it is not before the
 * lens. */
bool mcv_view_project(const mcv_view *view, const double world[3], double film[2]);

/* The blur at this depth in pixels; for a light field camera in one of its views. */
double mcv_view_blur(const mcv_view *view, double depth);

/* The extent of an instance's vertices. */
typedef struct mcv_extent {
    double middle[3];  /* of its box in the sensor's frame [m] */
    double depth[2];   /* nearest and farthest [m] */
    double film[2][2]; /* in the view's units, for the vertices before the lens */
    bool crosses; /* some vertices lie before the lens and some behind it: film has no meaning */
} mcv_extent;
mcv_extent mcv_view_extent(const mcv_view *view, const mcv_scene *scene, uint32_t instance);

/* May the image show some of it? The test uses its rectangle in the image, widened by the blur. */
bool mcv_view_shows(const mcv_view *view, const mcv_extent *extent);

#endif
