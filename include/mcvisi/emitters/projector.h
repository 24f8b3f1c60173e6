/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Projector (type "projector"): the thin lens camera reversed. An image of W x H pixels of size l
 * stands at the distance b behind a lens of focal length f and diameter D, whose centre is the
 * node's origin. Each point o = (o_x, o_y) of the lens emits into a direction the light of one
 * pixel: that which a thin lens camera at this node would see from o in this direction. In the
 * node's frame (x right, y up, z along the optical axis, the node's -z), with κ = (b - f)/(b f) =
 * 1/throw and the direction d:
 *
 *     column = W/2 + b/l_x (d_x/d_z + κ o_x)        row = H/2 - b/l_y (d_y/d_z + κ o_y)
 *
 * The picture is sharp at the depth 1/κ, where a pixel is l/(b κ) large. Row 0 lies at +y and
 * column 0 at -x: on a wall it reads right from behind the projector; "mirror": true flips the
 * columns. A pixel is uniform, nothing is interpolated. The emitter is a square of side D that
 * absorbs what falls on it; outside the disk it does not emit.
 *
 * `radiance` is that of the value 1 as it leaves the lens; `power` is what leaves the lens, per
 * channel. A direction element dm = l_x l_y/b² of the image at the distance m from the axis, over
 * b, emits through the disk of radius R = D/2 (by inversion of the disk)
 *
 *     dΦ = L dm 2π R²/(B (A + B)),   A = 1 + m² - κ²R²,   B² = (1 + (m - κR)²) (1 + (m + κR)²)
 *
 * which is L πR² dm on the axis with the focus at infinity.
 *
 * `pattern` with `index` replaces the image (mcvisi/pattern.h); its `resolution` is then W x H.
 *
 * focusDistance, the throw, may be given in place of imageDistance, and fNumber = b/D in place of
 * lensDiameter.
 *
 *     {"type": "projector", "image": "stripes", "focalLength": "16mm", "focusDistance": "300mm",
 *      "fNumber": 2.8, "pixelSize": "7.6um", "power": 0.5}
 *
 * Emission: a point uniform on the square (density 1/D²) and a point uniform on the image; together
 * they give the direction.
 */
#ifndef MCVISI_EMITTERS_PROJECTOR_H
#define MCVISI_EMITTERS_PROJECTOR_H

#include "mcvisi/emitters/emitter.h"
#include "mcvisi/sensors/sensor.h"

#define MCV_PROJECTOR_PARAMS(X) \
    MCV_PICTURE_PARAMS(X) \
    X(length2, pixelSize, MCV_REQUIRED, MCV_POSITIVE, 1, \
      "width and height of the image's pixels behind the lens [m]") \
    MCV_LENS_PARAMS(X) \
    X(spectrum, radiance, MCV_UNSET, 0, 1e30, "radiance L of the image's value 1 [W/(m² sr)]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power that leaves the lens, in place of radiance [W]") \
    X(flag, mirror, 0, 0, 1, "column 0 at +x instead of -x")

typedef struct mcv_projector {
    float x[3], y[3]; /* the image's axes in the world, to the right and down; they turn tangents
                         into shares of the image's sides */
    float axis[3];    /* unit; direction of emission */
    float blur[2];    /* shift of the picture across the lens's whole width, in the image's sides */
    uint padding;
} mcv_projector;
MCV_ASSERT_SIZE(mcv_projector, 48);

/*
 * The point of the image whose light leaves the point (s, t) of the lens's square in a unit
 * direction. Both points are in units of the sides from the upper left corner. Returns 0 if the
 * lens emits nothing there.
 */
MCV_LOOP_FUNCTION int mcv_projector_place(MCV_GLOBAL const mcv_projector *emitter, float s, float t,
                                          mcv_vec3 direction, float *across, float *down) {
    const float right = s - 0.5f;
    const float below = t - 0.5f;
    const float ahead =
        mcv_dot(direction, mcv_vec(emitter->axis[0], emitter->axis[1], emitter->axis[2]));
    *across =
        mcv_fma(emitter->blur[0], right,
                mcv_dot(direction, mcv_vec(emitter->x[0], emitter->x[1], emitter->x[2])) / ahead) +
        0.5f;
    *down =
        mcv_fma(emitter->blur[1], below,
                mcv_dot(direction, mcv_vec(emitter->y[0], emitter->y[1], emitter->y[2])) / ahead) +
        0.5f;
    const int on_lens = (mcv_fma(right, right, below * below) <= 0.25f) & (ahead > 0.0f);
    return on_lens & (*across >= 0.0f) & (*across <= 1.0f) & (*down >= 0.0f) & (*down <= 1.0f);
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/*
 * The direction of a light path from a point of the lens's square through the point (xi, eta) of
 * the image; *cosine gets the cosine of its angle to the axis. Each path carries the flux L cos⁴θ A
 * M, or 0 outside the disk. A is the square's area, M the image's in tangents.
 */
MCV_FUNCTION mcv_vec3 mcv_projector_emit(MCV_GLOBAL const mcv_projector *emitter, float s, float t,
                                         float xi, float eta, float *cosine) {
    const mcv_vec3 x = mcv_vec(emitter->x[0], emitter->x[1], emitter->x[2]);
    const mcv_vec3 y = mcv_vec(emitter->y[0], emitter->y[1], emitter->y[2]);
    const float across = mcv_fma(-emitter->blur[0], s - 0.5f, xi - 0.5f) / mcv_dot(x, x);
    const float down = mcv_fma(-emitter->blur[1], t - 0.5f, eta - 0.5f) / mcv_dot(y, y);
    const mcv_vec3 axis = mcv_vec(emitter->axis[0], emitter->axis[1], emitter->axis[2]);
    const mcv_vec3 direction = mcv_along(mcv_along(axis, across, x), down, y);
    *cosine = 1.0f / mcv_sqrt(mcv_dot(direction, direction));
    return mcv_normalize(direction);
}
#endif

#endif
