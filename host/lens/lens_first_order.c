/* SPDX-License-Identifier: Apache-2.0 */
/* First-order optics of a lens prescription: paraxial rays (y, u) traced from surface to surface,
 * n' u' = n u - y c (n' - n). */
#include "lens/lens.h"

#include <math.h>

/* An object farther than this many units is at infinity: programs write 1e10 to 1e14 for it. */
static const double infinity = 1e8;

/* A height on each surface and the slope behind the last one before the image. */
typedef struct ray {
    double height[MCV_LENS_SURFACES], slope, object_slope, object_height;
} ray;

static double object_distance(const mcv_lens *l) {
    const double distance = l->surfaces[0].thickness;
    return isfinite(distance) && fabs(distance) < infinity && distance != 0 ? distance : INFINITY;
}

static ray trace(const mcv_lens *l, double y, double u) {
    ray r = {.object_slope = u, .object_height = y - u * l->surfaces[0].thickness};
    double n = 1;
    for (int i = 1; i < l->count - 1; ++i) {
        const mcv_lens_surface *s = l->surfaces + i;
        const double next = mcv_lens_index(s, l->wavelength);
        r.height[i] = y;
        u = (n * u - y * s->curvature * (next - n)) / next;
        y += (isfinite(s->thickness) ? s->thickness : 0) * u;
        n = next;
    }
    r.slope = u;
    return r;
}

/* a + k b */
static ray add(const ray *a, double k, const ray *b) {
    ray r = {.slope = a->slope + k * b->slope,
             .object_slope = a->object_slope + k * b->object_slope,
             .object_height = a->object_height + k * b->object_height};
    for (int i = 0; i < MCV_LENS_SURFACES; ++i) r.height[i] = a->height[i] + k * b->height[i];
    return r;
}

static ray axial_ray(const mcv_lens *l) {
    const double distance = object_distance(l);
    return isfinite(distance) ? trace(l, distance, 1) : trace(l, 1, 0);
}

static int stop_of(const mcv_lens *l) {
    return l->stop > 0 && l->stop < l->count - 1 ? l->stop : 1;
}

/* Through the middle of the stop. */
static ray chief_ray(const mcv_lens *l, const ray *axial) {
    const ray oblique = isfinite(object_distance(l)) ? trace(l, 1, 0) : trace(l, 0, 1);
    const int stop = stop_of(l);
    return axial->height[stop] != 0
               ? add(&oblique, -oblique.height[stop] / axial->height[stop], axial)
               : oblique;
}

/* Height of a ray in the entrance pupil, whose centre the chief ray meets; of telecentric lenses
 * that is at infinity. */
static double pupil_height(const ray *r, const ray *chief) {
    if (r->object_slope == 0) return r->height[1];
    return chief->object_slope != 0
               ? r->height[1] - r->object_slope * chief->height[1] / chief->object_slope
               : INFINITY;
}

bool mcv_lens_bounds_glass(const mcv_lens *l, int surface) {
    return *l->surfaces[surface].glass.name ||
           (surface > 0 && *l->surfaces[surface - 1].glass.name);
}

static int last_of_glass(const mcv_lens *l) {
    int last = 1;
    for (int i = 1; i < l->count; ++i)
        if (mcv_lens_bounds_glass(l, i)) last = i;
    return last;
}

/* Where a ray meets the axis, behind the last surface that bounds glass; the air behind it changes
 * no slope. */
static double crossing(const ray *r, int last) {
    return r->slope != 0 ? -r->height[last] / r->slope : INFINITY;
}

void mcv_lens_solve_image(mcv_lens *l) {
    const int last = l->count - 2;
    if (last < 1 || !l->surfaces[last].image_solve || l->surfaces[last].thickness != 0) return;
    const ray axial = axial_ray(l);
    const double distance = crossing(&axial, last);
    if (isfinite(distance)) l->surfaces[last].thickness = distance;
}

/* What the axial ray is to be multiplied by to become the marginal ray; 0 where nothing says. */
static double marginal_scale(const mcv_lens *l, const ray *axial) {
    const ray chief = chief_ray(l, axial), parallel = trace(l, 1, 0);
    const double pupil = fabs(pupil_height(axial, &chief));
    double scale = INFINITY;
    switch (l->aperture_is) {
    case MCV_LENS_PUPIL_DIAMETER:
        scale = l->aperture / 2 / pupil;
        break;
    case MCV_LENS_F_NUMBER:
        scale = 1 / fabs(2 * parallel.slope * l->aperture * pupil);
        break;
    case MCV_LENS_WORKING_F_NUMBER:
        scale = 1 / fabs(2 * l->aperture * axial->slope);
        break;
    case MCV_LENS_OBJECT_SLOPE:
        scale = axial->object_slope != 0 ? l->aperture / fabs(axial->object_slope) : INFINITY;
        break;
    case MCV_LENS_STOP_SIZE:
        if (l->stop > 0 && l->surfaces[l->stop].semi_diameter > 0) {
            scale = l->surfaces[l->stop].semi_diameter / fabs(axial->height[l->stop]);
            break;
        }
        for (int i = 1; i < l->count - 1; ++i)
            if (l->surfaces[i].semi_diameter > 0)
                scale = fmin(scale, l->surfaces[i].semi_diameter / fabs(axial->height[i]));
        break;
    }
    return isfinite(scale) && scale > 0 ? scale : 0;
}

/* What the chief ray is to be multiplied by to become that of the field's edge. */
static double field_scale(const mcv_lens *l, const ray *axial, const ray *chief) {
    const double field = hypot(l->field[0], l->field[1]);
    const int last = last_of_glass(l);
    const double image = crossing(axial, last);
    double unit = 0;
    switch (l->field_is) {
    case MCV_LENS_FIELD_TANGENT:
        unit = chief->object_slope;
        break;
    case MCV_LENS_OBJECT_HEIGHT:
        unit = isfinite(object_distance(l)) ? chief->object_height : 0;
        break;
    case MCV_LENS_IMAGE_HEIGHT:
        unit = isfinite(image) ? chief->height[last] + image * chief->slope : 0;
        break;
    }
    const double scale = unit != 0 ? field / fabs(unit) : 0;
    return isfinite(scale) ? scale : 0;
}

bool mcv_lens_is_possible(const mcv_lens *l) {
    const ray axial = axial_ray(l);
    const double scale = marginal_scale(l, &axial);
    for (int i = 1; i < l->count - 1; ++i) {
        const mcv_lens_surface *s = l->surfaces + i;
        const double height = fmax(s->semi_diameter, scale * fabs(axial.height[i])),
                     c = s->curvature;
        if ((1 + s->conic) * c * c * height * height >= 1) return false;
    }
    return true;
}

/* The edge of the body between a surface and the next: the larger of its two semi-diameters. */
static double edge_of(const mcv_lens *l, int surface) {
    return *l->surfaces[surface].glass.name
               ? fmax(l->surfaces[surface].semi_diameter, l->surfaces[surface + 1].semi_diameter)
               : INFINITY;
}

/* What the axial ray is to be multiplied by to touch the stop or the narrowest body. */
static double written_scale(const mcv_lens *l, const ray *axial) {
    double scale = INFINITY;
    for (int i = 1; i < l->count - 1; ++i) {
        double width = fmin(edge_of(l, i - 1), edge_of(l, i));
        if (i == l->stop && !mcv_lens_bounds_glass(l, i)) width = l->surfaces[i].semi_diameter;
        if (axial->height[i] != 0) scale = fmin(scale, width / fabs(axial->height[i]));
    }
    return isfinite(scale) ? scale : 0;
}

mcv_lens_first_order mcv_lens_trace(const mcv_lens *l, bool as_written) {
    const ray axial = axial_ray(l), parallel = trace(l, 1, 0), chief = chief_ray(l, &axial);
    const double scale = as_written ? written_scale(l, &axial) : marginal_scale(l, &axial);
    const double pupil = 2 * scale * fabs(pupil_height(&axial, &chief));
    const int last = last_of_glass(l);
    double stated = 0;
    for (int i = last; i < l->count - 1; ++i) stated += l->surfaces[i].thickness;
    mcv_lens_first_order f = {.focal_length = -1 / parallel.slope,
                              .back_focus = crossing(&parallel, last),
                              .object_distance = object_distance(l),
                              .image_distance = crossing(&axial, last),
                              .stated_image_distance =
                                  isfinite(stated) && stated != 0 ? stated : NAN,
                              .working_f_number = 1 / (2 * scale * fabs(axial.slope))};
    if (!isfinite(f.focal_length)) f.focal_length = f.back_focus = NAN;
    if (!isfinite(f.image_distance)) f.image_distance = NAN;
    f.f_number = pupil > 0 && isfinite(pupil) ? fabs(f.focal_length) / pupil : NAN;
    if (!isfinite(f.working_f_number)) f.working_f_number = NAN;
    return f;
}

/* What the file gives on the other faces of a surface's bodies, which end at one edge; 0 if
 * nothing. */
static double given_beside(const mcv_lens *l, const bool *given, int i) {
    const double before =
        *l->surfaces[i - 1].glass.name && given[i - 1] ? l->surfaces[i - 1].semi_diameter : 0;
    return fmax(before,
                *l->surfaces[i].glass.name && given[i + 1] ? l->surfaces[i + 1].semi_diameter : 0);
}

mcv_result mcv_lens_find_semi_diameters(mcv_lens *l, int first, int end, const bool *given,
                                        mcv_error *error) {
    const ray axial = axial_ray(l), chief = chief_ray(l, &axial);
    const double marginal = marginal_scale(l, &axial), field = field_scale(l, &axial, &chief);
    for (int i = first; i < end; ++i) {
        mcv_lens_surface *s = l->surfaces + i;
        const bool on_glass = mcv_lens_bounds_glass(l, i);
        if (on_glass && !given[i]) s->semi_diameter = given_beside(l, given, i);
        if (s->semi_diameter > 0 || (i != l->stop && !on_glass)) continue;
        if (marginal == 0 && l->aperture_is == MCV_LENS_OBJECT_SLOPE && l->aperture > 0 &&
            axial.object_slope == 0)
            return mcv_lens_fail(
                l, s->line, i, error,
                "has no semi-diameter, and the object is at infinity, where the object-side "
                "aperture "
                "(OBNA, NAO) has no meaning: give the object's distance (DISZ, SO) or another "
                "aperture (ENPD, EPD, FNO)");
        if (marginal == 0)
            return mcv_lens_fail(l, s->line, i, error,
                                 "has no semi-diameter (DIAM, CIR), and no aperture (ENPD, EPD, "
                                 "FNO, NAO …) gives the "
                                 "width of the bundle");
        const double height = marginal * fabs(axial.height[i]);
        s->semi_diameter =
            i == l->stop && !on_glass ? height : 1.05 * (height + field * fabs(chief.height[i]));
        if (!(s->semi_diameter > 0 && isfinite(s->semi_diameter)))
            return mcv_lens_fail(l, s->line, i, error,
                                 "the bundle has no width there, and no semi-diameter is given");
    }
    return MCV_OK;
}
