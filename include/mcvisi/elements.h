/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lists of all elements: X(name, "name in the scene file", NAME). One line here and one header
 * make a new element; enums, parser, dispatch, help and schema follow.
 */
#ifndef MCVISI_ELEMENTS_H
#define MCVISI_ELEMENTS_H

#define MCV_SENSORS(X) \
    X(pinhole, "pinhole", PINHOLE) \
    X(thin_lens, "thinLens", THIN_LENS) \
    X(telecentric, "telecentric", TELECENTRIC) \
    X(light_field, "lightField", LIGHT_FIELD)

#define MCV_EMITTERS(X) \
    X(parallel, "parallel", PARALLEL) \
    X(telecentric_projector, "telecentricProjector", TELECENTRIC_PROJECTOR) \
    X(light_field_emitter, "lightField", LIGHT_FIELD_EMITTER) \
    X(projector, "projector", PROJECTOR) \
    X(area, "area", AREA) \
    X(environment, "environment", ENVIRONMENT) \
    X(collimated_beam, "collimatedBeam", COLLIMATED_BEAM) \
    X(point, "point", POINT) \
    X(spot, "spot", SPOT) \
    X(directional, "directional", DIRECTIONAL)

/* Types of emitters that the loader makes of geometry and the elements above: kernels know nothing
 * of them. */
#define MCV_PRESETS(X) \
    X(ring, "ring", RING) \
    X(bar, "bar", BAR) \
    X(dome, "dome", DOME) \
    X(coaxial, "coaxial", COAXIAL)

#define MCV_MATERIALS(X) \
    X(diffuse, "diffuse", DIFFUSE) \
    X(dielectric, "dielectric", DIELECTRIC) \
    X(sheet, "sheet", SHEET) \
    X(mirror, "mirror", MIRROR) \
    X(beam_splitter, "beamSplitter", BEAM_SPLITTER) \
    X(conductor, "conductor", CONDUCTOR) \
    X(metallic_roughness, "metallicRoughness", METALLIC_ROUGHNESS) \
    X(retroreflector, "retroreflector", RETROREFLECTOR) \
    X(absorber, "absorber", ABSORBER)

#define MCV_SENSOR_ENUM(name, key, NAME) MCV_SENSOR_##NAME,
#define MCV_EMITTER_ENUM(name, key, NAME) MCV_EMITTER_##NAME,
#define MCV_PRESET_ENUM(name, key, NAME) MCV_PRESET_##NAME,
#define MCV_MATERIAL_ENUM(name, key, NAME) MCV_MATERIAL_##NAME,
enum { MCV_SENSORS(MCV_SENSOR_ENUM) MCV_SENSOR_COUNT };
enum { MCV_EMITTERS(MCV_EMITTER_ENUM) MCV_EMITTER_COUNT };
enum {
    MCV_PRESET_BEFORE = MCV_EMITTER_COUNT - 1,
    MCV_PRESETS(MCV_PRESET_ENUM) MCV_EMITTER_TYPE_COUNT
}; /* presets number on */
enum { MCV_MATERIALS(MCV_MATERIAL_ENUM) MCV_MATERIAL_COUNT };

#endif
