/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lists of all elements, X(name, "name in the scene file", NAME), and their headers. The enums,
 * the parser, the dispatch, the help and the schemas are generated from them.
 * docs/adding-an-element.md has the steps.
 */
#ifndef MCVISI_ELEMENTS_H
#define MCVISI_ELEMENTS_H

#include "mcvisi/dialect.h"

#define MCV_SENSORS(X) \
    X(pinhole, "pinhole", PINHOLE) \
    X(thin_lens, "thinLens", THIN_LENS) \
    X(telecentric, "telecentric", TELECENTRIC) \
    X(light_field, "lightField", LIGHT_FIELD) \
    X(flying_spot, "flyingSpotScanner", FLYING_SPOT)

/* Emitters without extent. They differ in how their intensity depends on the angle from the axis
 * (mcvisi/point_light.h). */
/* clang-format off */
#define MCV_POINT_LIGHTS(X) \
    X(point, "point", POINT) \
    X(spot, "spot", SPOT)
/* clang-format on */

/* Emitters with a surface, by how their radiance depends on the angle from its normal
 * (mcvisi/surface_light.h). */
/* clang-format off */
#define MCV_SURFACE_LIGHTS(X) \
    X(area, "area", AREA) \
    X(screen, "screen", SCREEN)
/* clang-format on */

#define MCV_EMITTERS(X) \
    X(parallel, "parallel", PARALLEL) \
    X(telecentric_projector, "telecentricProjector", TELECENTRIC_PROJECTOR) \
    X(light_field_emitter, "lightField", LIGHT_FIELD_EMITTER) \
    X(projector, "projector", PROJECTOR) \
    MCV_SURFACE_LIGHTS(X) \
    X(environment, "environment", ENVIRONMENT) \
    X(collimated_beam, "collimatedBeam", COLLIMATED_BEAM) \
    X(laser, "laser", LASER) \
    MCV_POINT_LIGHTS(X) \
    X(directional, "directional", DIRECTIONAL)

/* Presets: emitters that the loader builds from geometry and the elements above. Kernels do not
 * know them. */
#define MCV_PRESETS(X) \
    X(ring, "ring", RING) \
    X(bar, "bar", BAR) \
    X(dome, "dome", DOME) \
    X(coaxial, "coaxial", COAXIAL)

/*
 * Materials with a BSDF of their own: two functions, mcv_scatter_<name> and mcv_respond_<name> in
 * kernels/bsdf/. The struct mcv_<name> holds what these functions need beside the reflectance.
 */
/* clang-format off */
#define MCV_OWN_BSDFS(X) \
    X(retroreflector, "retroreflector", RETROREFLECTOR)
/* clang-format on */

/*
 * Plates without thickness: they reflect one share of the light and pass another straight on.
 * mcv_scatter_<name> in kernels/bsdf/ describes each. A struct mcv_<name> holds what it needs.
 */
#define MCV_PLATES(X) \
    X(sheet, "sheet", SHEET) \
    X(beam_splitter, "beamSplitter", BEAM_SPLITTER)

/*
 * Materials that fill a body of glass, fluid or gas: their parameters begin with MCV_MEDIUM_PARAMS
 * (mcvisi/materials/material.h). One whose surface scatters light by a law of its own is in
 * MCV_OWN_BSDFS, too.
 */
/* clang-format off */
#define MCV_MEDIUM_MATERIALS(X) \
    X(dielectric, "dielectric", DIELECTRIC)
/* clang-format on */

#define MCV_MATERIALS(X) \
    X(diffuse, "diffuse", DIFFUSE) \
    X(dielectric, "dielectric", DIELECTRIC) \
    MCV_PLATES(X) \
    X(mirror, "mirror", MIRROR) \
    X(conductor, "conductor", CONDUCTOR) \
    X(metallic_roughness, "metallicRoughness", METALLIC_ROUGHNESS) \
    MCV_OWN_BSDFS(X) \
    X(absorber, "absorber", ABSORBER)

#define MCV_SENSOR_ENUM(name, key, NAME) MCV_SENSOR_##NAME,
#define MCV_EMITTER_ENUM(name, key, NAME) MCV_EMITTER_##NAME,
#define MCV_PRESET_ENUM(name, key, NAME) MCV_PRESET_##NAME,
#define MCV_MATERIAL_ENUM(name, key, NAME) MCV_MATERIAL_##NAME,
enum { MCV_SENSORS(MCV_SENSOR_ENUM) MCV_SENSOR_COUNT };
/* Words for another sensor with some of its parameters, or more (mcvisi/sensors/thin_lens.h,
 * laser_triangulation.h). */
enum {
    MCV_SENSOR_LINE_SCAN = MCV_SENSOR_COUNT,
    MCV_SENSOR_LASER_TRIANGULATION,
    MCV_SENSOR_TYPE_COUNT
};
enum { MCV_EMITTERS(MCV_EMITTER_ENUM) MCV_EMITTER_COUNT };
enum {
    MCV_PRESET_BEFORE = MCV_EMITTER_COUNT - 1,
    MCV_PRESETS(MCV_PRESET_ENUM) MCV_EMITTER_TYPE_COUNT
}; /* the numbers of the presets follow */
enum { MCV_MATERIALS(MCV_MATERIAL_ENUM) MCV_MATERIAL_COUNT };

/* Whether a type is in a list, such as MCV_IS_MATERIAL_OF(MCV_PLATES, type). */
#define MCV_EMITTER_BIT(name, key, NAME) | 1u << MCV_EMITTER_##NAME
#define MCV_MATERIAL_BIT(name, key, NAME) | 1u << MCV_MATERIAL_##NAME
#define MCV_IS_EMITTER_OF(LIST, type) (((0u LIST(MCV_EMITTER_BIT)) >> (type)&1u) != 0u)
#define MCV_IS_MATERIAL_OF(LIST, type) (((0u LIST(MCV_MATERIAL_BIT)) >> (type)&1u) != 0u)

/* Headers of the elements. The device includes only those that the scene needs. */
#if !MCV_ON_DEVICE || defined(MCV_SENSOR_pinhole)
#include "mcvisi/sensors/pinhole.h"
#endif
#if !MCV_ON_DEVICE || defined(MCV_SENSOR_thin_lens)
#include "mcvisi/sensors/thin_lens.h"
#endif
#if !MCV_ON_DEVICE
#include "mcvisi/sensors/laser_triangulation.h"
#endif
#if !MCV_ON_DEVICE || defined(MCV_SENSOR_telecentric)
#include "mcvisi/sensors/telecentric.h"
#endif
#if !MCV_ON_DEVICE || defined(MCV_SENSOR_light_field)
#include "mcvisi/sensors/light_field.h"
#endif
#if !MCV_ON_DEVICE || defined(MCV_SENSOR_flying_spot)
#include "mcvisi/sensors/flying_spot.h"
#endif

#if !MCV_ON_DEVICE || MCV_WITH_PARALLEL
#include "mcvisi/emitters/parallel.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_FIELD
#include "mcvisi/emitters/light_field.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_PROJECTOR
#include "mcvisi/emitters/projector.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_AREA
#include "mcvisi/emitters/area.h"
#include "mcvisi/emitters/screen.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_ENVIRONMENT_IMAGE
#include "mcvisi/emitters/environment.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_BEAM
#include "mcvisi/emitters/collimated_beam.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_LASER
#include "mcvisi/emitters/laser.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_PUNCTUAL
#include "mcvisi/emitters/directional.h"
#include "mcvisi/emitters/point.h"
#include "mcvisi/emitters/spot.h"
#endif

#if !MCV_ON_DEVICE || MCV_WITH_DIFFUSE
#include "mcvisi/materials/diffuse.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_SHEET
#include "mcvisi/materials/beam_splitter.h"
#include "mcvisi/materials/sheet.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_REFLECTOR
#include "mcvisi/materials/retroreflector.h"
#endif

/* Host only. */
#if !MCV_ON_DEVICE
#include "mcvisi/emitters/telecentric_projector.h"
#include "mcvisi/materials/absorber.h"
#include "mcvisi/materials/conductor.h"
#include "mcvisi/materials/dielectric.h"
#include "mcvisi/materials/metallic_roughness.h"
#include "mcvisi/materials/mirror.h"
#endif

#endif
