/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all emitters share. Most emitters are a set of triangles: a mesh, or the rectangle that
 * `size` spans in the node's xy plane, facing -z. They emit radiance only from the front side,
 * given by the interpolated normal. Sizes do not scale with the node. Rectangles absorb what falls
 * on them; meshes keep their material. Environments, lasers and point, spot and directional lights
 * have no surface. Rays hit the environment by chance, but never the others nor the collimated
 * beam: only next-event estimation and light paths find those.
 *
 * An emitter is one header with
 *     MCV_<NAME>_PARAMS(X)      its parameters (mcvisi/params.h)
 *     mcv_<name>                what the device needs of them, 4-byte scalars
 *     mcv_<name>_profile        for MCV_POINT_LIGHTS and MCV_SURFACE_LIGHTS: its intensity
 *                               or radiance at an angle, over the largest
 * and one line in one of the lists of mcvisi/elements.h. An emitter that rays cannot hit also has
 * functions for next-event estimation. host/scene/emitters.c resolves the parameters,
 * emitters_device.c prepares the device struct.
 */
#ifndef MCVISI_EMITTERS_EMITTER_H
#define MCVISI_EMITTERS_EMITTER_H

#include "mcvisi/params.h"
#include "mcvisi/sampling.h"

/* Brightness: one is given, the other follows. Power is per channel, over the whole surface. */
#define MCV_RADIANCE_PARAMS(X) \
    X(spectrum, radiance, MCV_UNSET, 0, 1e30, "radiance L in its cone [W/(m² sr)]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power of the whole emitter, in place of radiance [W]") \
    X(length2, size, MCV_UNSET, MCV_POSITIVE, 1e6, \
      "width and height of the rectangle, for a node without a mesh [m]")

/* Brightness of a light without extent. */
#define MCV_INTENSITY_PARAMS(X) \
    X(spectrum, intensity, MCV_UNSET, 0, 1e30, "radiant intensity I [W/sr]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power of the whole light, in place of intensity [W]") \
    X(length, range, MCV_UNSET, MCV_POSITIVE, 1e6, \
      "distance at which its light ends; without it unlimited [m]")

/* Brightness of an emitter whose radiance an image modulates; it is always a rectangle. */
#define MCV_IMAGE_PARAMS(X) \
    X(image, image, MCV_REQUIRED, 0, 4294967294.0, \
      "index or name of one of the file's images, or {\"uri\": FILE.exr}") \
    MCV_IMAGE_RADIANCE_PARAMS(X)

/* For emitters whose image can be one of a sequence of patterns (mcvisi/pattern.h). */
#define MCV_PATTERN_PARAMS(X) \
    MCV_PICTURE_PARAMS(X) \
    MCV_IMAGE_RADIANCE_PARAMS(X)

#define MCV_PICTURE_PARAMS(X) \
    X(image, image, MCV_UNSET, 0, 4294967294.0, \
      "index or name of one of the file's images, or {\"uri\": FILE.exr}") \
    X(pattern, pattern, MCV_UNSET, 0, 4294967294.0, "a sequence of patterns, in place of image") \
    X(integer, index, 0, 0, 131071, "index of the pattern in its sequence")

#define MCV_IMAGE_RADIANCE_PARAMS(X) \
    X(spectrum, radiance, MCV_UNSET, 0, 1e30, "radiance L of the image's value 1 [W/(m² sr)]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power of the whole emitter, in place of radiance [W]") \
    X(length2, size, MCV_REQUIRED, MCV_POSITIVE, 1e6, "width and height of the rectangle [m]")

#endif
