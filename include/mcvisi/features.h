/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a scene needs. Only the needed features are compiled, launched and allocated. Each feature
 * is a macro MCV_WITH_<NAME>, 0 or 1, in the kernels; the host sets it (host/device/features.c).
 *
 * X(NAME, "word for people", "reason"): `mcvisi check` prints the last two.
 */
#ifndef MCVISI_FEATURES_H
#define MCVISI_FEATURES_H

#define MCV_FEATURES(X) \
    X(DIFFUSE, "diffuse", "a material reflects diffusely") \
    X(TRANSLUCENT, "translucent", "a diffuse material transmits light") \
    X(DIELECTRIC, "dielectric", "a body of glass, fluid or gas refracts") \
    X(ABSORPTION, "absorption", "a medium absorbs along the path") \
    X(COATING, "coating", "a coating changes the reflectance of a body") \
    X(DISPERSION, "dispersion", "the refractive index of a body depends on the wavelength") \
    X(SPLIT, "split", \
      "a path splits in two at the first glass, sheet or beam splitter: reflected and " \
      "transmitted") \
    X(SHEET, "sheet", "a plate, such as a thin sheet or a beam splitter, transmits") \
    X(MIRROR, "mirror", "a mirror reflects") \
    X(GLOSSY, "gloss", "a metal or a rough surface reflects") \
    X(METAL, "metal", "a conductor reflects") \
    X(METALLIC, "metallic-roughness", "a metallic-roughness surface reflects") \
    X(ROUGH_GLASS, "rough-glass", "the surface of a body of glass is rough") \
    X(ANISOTROPY, "anisotropy", "a rough surface has a direction, as brushed metal has") \
    X(REFLECTOR, "retroreflector", "a surface has a BSDF of its own, such as a retroreflector") \
    X(CONTACT, "contact", \
      "bodies of glass or fluid may touch: rays check for coincident surfaces") \
    X(SURFACES, "surfaces", "a lens or another body has exact surfaces") \
    X(TEXTURE, "texture", "an image modulates a material or an emitter") \
    X(NORMALS, "normals", "a mesh has interpolated normals") \
    X(PARALLEL, "parallel", "the scene has a parallel emitter or a telecentric projector") \
    X(LIGHT_FIELD, "light-field", "the scene has a light field emitter") \
    X(PROJECTOR, "projector", "the scene has a projector") \
    X(AREA, "area", "the scene has an area emitter or a screen") \
    X(SCREEN, "screen", "a screen has gaps between its pixels, or a fall-off with the angle") \
    X(ENVIRONMENT, "environment", "the scene has a uniform environment") \
    X(ENVIRONMENT_IMAGE, "environment-image", "the scene has an environment with an image") \
    X(BEAM, "collimated-beam", "the scene has a collimated beam") \
    X(LASER, "laser", "the scene has a laser") \
    X(PUNCTUAL, "punctual", "the scene has a point, spot or directional light") \
    X(NEXT_EVENT, "next-event", \
      "next-event estimation: surfaces that scatter light sample the emitters") \
    X(RECTANGLE, "rectangle", "a sampled emitter is a rectangle: it is sampled by solid angle") \
    X(REACH, "reach", \
      "there are few emitters: each surface chooses by what an emitter can contribute to it") \
    X(LIGHT_TREE, "light-tree", \
      "there are many emitters: each surface chooses by a tree of what they can contribute to it") \
    X(MANY_EMITTERS, "many-emitters", \
      "there are so many emitters that few paths of a slice sample the same one") \
    X(EARLY_ROULETTE, "early-roulette", \
      "next-event estimation samples all light: later vertices contribute little, so Russian " \
      "roulette ends paths earlier") \
    X(MOTION, "motion", "the sensor or parts move, or rows are exposed in turn") \
    X(MOVING, "moving", "parts move") \
    X(APERTURE, "aperture", "the sensor's aperture is no full disc") \
    X(DISTORTION, "distortion", "the sensor's film is tilted, or its lens distorts") \
    X(PUPIL_GUIDE, "pupil-guiding", \
      "pupil guiding: the cone of a parallel emitter is narrower than the sensor's pupil") \
    X(LIGHT_TRACING, "light-tracing", \
      "light tracing (`render` measures whether it pays): emitters light scattering surfaces, or " \
      "a " \
      "beam reaches the lens, by way of smooth surfaces") \
    X(MIXED, "mixed", \
      "--precision mixed: hits on smooth surfaces and directions behind them are computed in " \
      "double") \
    X(RECORDS, "records", "what each element of an emitter brings is recorded")

enum {
#define MCV_X(NAME, word, why) MCV_FEATURE_##NAME,
    MCV_FEATURES(MCV_X)
#undef MCV_X
        MCV_FEATURE_COUNT
};
/* A set of features is a uint64_t, bit MCV_FEATURE_…. */
#define MCV_FEATURE_BIT(NAME) (UINT64_C(1) << MCV_FEATURE_##NAME)
#define MCV_ALL_FEATURES (UINT64_MAX >> (64 - MCV_FEATURE_COUNT))

/* X(stage, condition): the stages. A scene has a stage if its condition, in terms of MCV_WITH_…, is
 * not 0. Here they stand in the order in which they run; mcv_render_slice
 * (kernels/schedule/tile.cl) and launch_depth (host/render/schedule.c) make that order, and leave
 * out next-event estimation at the last depth. The names are keys of `check --json`;
 * kernels/README.md says which file holds each stage. */
#define MCV_STAGES(X) \
    X(guide_pupils, MCV_WITH_PUPIL_GUIDE) \
    X(generate_rays, 1) \
    X(intersect_closest, 1) \
    X(sample_emitters, MCV_WITH_NEXT_EVENT) \
    X(intersect_shadow, MCV_WITH_NEXT_EVENT) \
    X(shade_surfaces, 1) \
    X(accumulate_film, 1) \
    X(trace_emitter_paths, MCV_WITH_LIGHT_TRACING)

#endif
