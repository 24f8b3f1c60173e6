/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How far the edges of a thick part grow before a backlight.
 *
 * A pixel beside a wall that runs along the optical axis takes in a cone of rays of sight. Those
 * that lean towards the part are cut by the rim before the focus, or by the one behind it: the
 * picture's edge lies outside of the wall. With u, the tangent of a ray across the wall, and the
 * contour points (x, z) of the part, x outwards and z along the axis, the shadow of one direction
 * of rays ends at h(u) = max (x - u z). `measure` finds the place at which a sharp edge would hold
 * the same light, so the growth is the mean of h over the cone, less h(0), the contour that
 * parallel rays see. Over the disk of the tangents, of radius a,
 *
 *     a wall of depth T:  T/2 <|u|> = 2/(3π) a T, wherever the focus lies
 *
 * and a width grows by twice that: a part of 6 mm at m = 0.08 and f/5.6 (a = m/(2N) = 0.00714)
 * by 18.2 µm. a is the tangent of the pupil's cone or, if that is narrower, of the backlight's.
 * Where the camera is entocentric and the chief ray leans by c against the wall, the mean is of |c
 * + u| - |c|: the same on the axis, nothing where it leans by more than a; there perspective
 * decides which rim is seen.
 *
 * Matte walls stay dark at grazing incidence. Smooth metal, plastic and glass reflect the backlight
 * there, and the more they do the less the edge grows: then the growth is anything between 0 and
 * this.
 */
#ifndef MCVISI_HOST_CHECK_GROWTH_H
#define MCVISI_HOST_CHECK_GROWTH_H

#include "analysis/region.h"
#include "scene/camera_model.h"

typedef struct mcv_growth {
    uint32_t emitter;       /* the backlight, of the scene */
    double backlight;       /* its depth [m]: what lies behind casts no shadow */
    uint32_t instance;      /* of the thickest opaque node before it */
    double thickness;       /* of that node along the optical axis [m] */
    double cone;            /* a */
    double f_number;        /* of the sensor */
    bool light_is_narrower; /* a is the backlight's */
    bool telecentric;       /* else the growth is that on the axis */
    bool glossy;            /* a wall may reflect: the growth is between 0 and twice the value */
    mcv_quantity edge;      /* of each edge, in the object [m], for a wall of that thickness */
} mcv_growth;

/* False where no flat emitter faces the sensor behind an opaque part, or the sensor has no
 * aperture. */
bool mcv_growth_of(const mcv_scene *scene, const mcv_sensor *sensor, mcv_growth *growth);

/* What people are told of it, in one sentence of at most 511 bytes. */
void mcv_growth_sentence(const mcv_scene *scene, const mcv_growth *growth, char text[512]);

/*
 * Of an edge in the image, by the part's mesh there: the straight line through `point` [pixel] of
 * the unit `normal` towards the bright side, `length` pixels long. Value and uncertainty in the
 * object [m]. MCV_FAILED where the part has no contour within `reach` pixels, with a sentence.
 */
mcv_result mcv_growth_at(const mcv_scene *scene, const mcv_camera_model *model,
                         const mcv_growth *growth, const double point[2], const double normal[2],
                         double length, double reach, mcv_quantity *edge, mcv_error *error);

/*
 * The same of a circle in the image, whose radius grows so (bright inside: shrinks), as the mean
 * all around it; centre and radius in pixels.
 */
mcv_result mcv_growth_of_circle(const mcv_scene *scene, const mcv_camera_model *model,
                                const mcv_growth *growth, const double centre[2], double radius,
                                bool bright_inside, double reach, mcv_quantity *edge,
                                mcv_error *error);

#endif
