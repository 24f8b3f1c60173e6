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

/* What a sentence calls an instance: node "part", or its mesh where the node has no name. */
enum { MCV_LABEL = 96 };
const char *mcv_instance_label(const mcv_scene *scene, uint32_t instance, char text[MCV_LABEL]);

static inline double mcv_dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The primitives of a node stand one after the other, with one name. */
uint32_t mcv_node_end(const mcv_scene *scene, uint32_t first);

/* The same of a body: those of one name that stand in one place. */
uint32_t mcv_body_end(const mcv_scene *scene, uint32_t first);

/* Neither does it emit, nor does its node: housings and half mirrors belong to lights. */
bool mcv_is_part(const mcv_scene *scene, uint32_t instance);

/* Of a smooth surface that turns rays round: what is seen lies elsewhere. */
bool mcv_is_mirror(const mcv_material *material);

/* Half of a sensor's lens's width, in its corner; 0 of a pinhole [m]. */
double mcv_lens_radius(const mcv_sensor *sensor);

/* The image that is read out, from the axis, in multiples of its distance from the lens or over the
 * magnification: what is right and up in the scene is positive. */
typedef struct mcv_view {
    const mcv_sensor *sensor;
    mcv_optics optics;
    double film[2]
               [2];  /* [x, y][lower, upper]: telecentric, of the object [m]; otherwise tangents */
    double pixel[2]; /* of the image, in the same units; of a light field camera a macro pixel */
    bool is_telecentric;
} mcv_view;
mcv_view mcv_view_of(const mcv_sensor *sensor);

/* How large a pixel is at a depth, on the object's side [m]: the smaller side. */
double mcv_view_pixel(const mcv_view *view, double depth);

/* A point of the world in the sensor's frame: to the right, up, and its depth. */
void mcv_view_point(const mcv_view *view, const double world[3], double local[3]);

/* Where a point appears, in the units of film; false where it is not before the lens. */
bool mcv_view_project(const mcv_view *view, const double world[3], double film[2]);

/* By how many pixels a point at this depth is blurred; of a light field camera in one of its views.
 */
double mcv_view_blur(const mcv_view *view, double depth);

/* Where an instance lies, by its vertices. */
typedef struct mcv_extent {
    double middle[3];  /* of its box in the sensor's frame [m] */
    double depth[2];   /* nearest and farthest [m] */
    double film[2][2]; /* as the view's; of the vertices before the lens */
    bool crosses;      /* some lie before the lens and some do not: film says nothing */
} mcv_extent;
mcv_extent mcv_view_extent(const mcv_view *view, const mcv_scene *scene, uint32_t instance);

/* May any of it be in the picture, by its rectangle there? What is blurred counts. */
bool mcv_view_shows(const mcv_view *view, const mcv_extent *extent);

#endif
