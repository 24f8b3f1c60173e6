/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The growth of a thick part's edges before a backlight.
 *
 * A pixel beside a wall along the optical axis receives a cone of rays. Rays that lean towards the
 * part are blocked by its near or its far rim, so the edge in the image lies outside the wall. Let
 * u be the tangent of a ray across the wall, and (x, z) the contour points of the part, x outwards
 * and z along the axis. The shadow for one direction of rays ends at h(u) = max (x - u z).
 * `measure` places the edge where a sharp edge would give the same amount of light. The growth is
 * therefore the mean of h over the cone, minus h(0), the contour for parallel rays. Over the disk
 * of tangents with radius a it is
 *
 *     for a wall of depth T:  T/2 <|u|> = 2/(3π) a T, independent of the focus
 *
 * A width grows by twice that: a part of 6 mm at m = 0.08 and f/5.6 (a = m/(2N) = 0.00714) by 18.2
 * µm. a is the tangent of the pupil's cone or, if it is narrower, of the backlight's. With an
 * entocentric camera the chief ray has the slope c against the wall, and the mean is that of |c +
 * u| - |c|. This is the same on the axis, and 0 if c is larger than a; perspective then decides
 * which rim is seen.
 *
 * Matte walls stay dark at grazing incidence. Smooth metal, plastic and glass reflect the backlight
 * there, which reduces the growth: it then lies between 0 and this value.
 */
#ifndef MCVISI_HOST_CHECK_GROWTH_H
#define MCVISI_HOST_CHECK_GROWTH_H

#include "analysis/region.h"
#include "scene/camera_model.h"

typedef struct mcv_growth {
    uint32_t emitter;       /* the backlight, of the scene */
    double backlight;       /* its depth [m]; what lies behind it casts no shadow */
    uint32_t instance;      /* of the thickest opaque node before it */
    double thickness;       /* of that node along the optical axis [m] */
    double cone;            /* a */
    double f_number;        /* of the sensor */
    bool light_is_narrower; /* a belongs to the backlight */
    bool telecentric;       /* false: the growth is that on the axis */
    bool glossy;            /* the walls may reflect: the growth is between 0 and twice the value */
    mcv_quantity edge;      /* of each edge, in the object [m], for a wall of that thickness */
} mcv_growth;

/* False if no flat emitter faces the sensor behind an opaque part, or if the sensor has no
 * aperture. */
bool mcv_growth_of(const mcv_scene *scene, const mcv_sensor *sensor, mcv_growth *growth);

/* The finding about it, one sentence of at most 511 bytes. */
void mcv_growth_sentence(const mcv_scene *scene, const mcv_growth *growth, char text[512]);

/*
 * The growth of an edge in the image, from the part's mesh. The edge is the straight line through
 * `point` [pixel] with the unit `normal` towards the bright side, `length` pixels long. Value and
 * uncertainty are in the object [m]. MCV_FAILED with a sentence if the part has no contour within
 * `reach` pixels.
 */
mcv_result mcv_growth_at(const mcv_scene *scene, const mcv_camera_model *model,
                         const mcv_growth *growth, const double point[2], const double normal[2],
                         double length, double reach, mcv_quantity *edge, mcv_error *error);

/*
 * The growth of a circle in the image: its radius grows by it (bright inside: shrinks). It is the
 * mean around the circle; centre and radius are in pixels.
 */
mcv_result mcv_growth_of_circle(const mcv_scene *scene, const mcv_camera_model *model,
                                const mcv_growth *growth, const double centre[2], double radius,
                                bool bright_inside, double reach, mcv_quantity *edge,
                                mcv_error *error);

#endif
