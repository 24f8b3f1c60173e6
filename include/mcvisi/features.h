/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a scene needs. Only this is compiled, launched and allocated: each feature is a macro
 * MCV_WITH_<NAME> of 0 or 1 in the kernels, set by the host from the scene
 * (host/render/features.c).
 *
 * X(NAME, "word for people", "why")
 */
#ifndef MCVISI_FEATURES_H
#define MCVISI_FEATURES_H

#define MCV_FEATURES(X) \
    X(DIFFUSE, "diffuse", "a material reflects diffusely") \
    X(TRANSLUCENT, "translucent", "a diffuse material lets light through") \
    X(DIELECTRIC, "dielectric", "a body of glass, fluid or gas refracts") \
    X(ABSORPTION, "absorption", "a medium absorbs along the path") \
    X(COATING, "coating", "a coating changes how much a body reflects") \
    X(DISPERSION, "dispersion", "a body refracts colours differently") \
    X(SPLIT, "split", \
      "bodies of glass, sheets and beam splitters both reflect and pass light: paths follow both " \
      "ways from the first of them") \
    X(SHEET, "sheet", "a thin sheet or a beam splitter transmits") \
    X(MIRROR, "mirror", "a mirror reflects") \
    X(GLOSS, "gloss", "a metal reflects, or a surface of microfacets") \
    X(REFLECTOR, "retroreflector", \
      "a surface scatters by a law of its own, as a retroreflector does") \
    X(CONTACT, "contact", \
      "bodies of glass or fluid may touch: surfaces in the same place are looked for") \
    X(SURFACES, "surfaces", "a lens or another body has exact surfaces") \
    X(TEXTURE, "texture", "an image modulates a material or an emitter") \
    X(NORMALS, "normals", "a mesh has interpolated normals") \
    X(PARALLEL, "parallel", "a parallel emitter or a telecentric projector shines") \
    X(LIGHT_FIELD, "light-field", "a light field emitter shines") \
    X(PROJECTOR, "projector", "a projector shines through its lens") \
    X(AREA, "area", "an area emitter shines") \
    X(ENVIRONMENT, "environment", "the environment shines") \
    X(ENVIRONMENT_IMAGE, "environment-image", "the environment is an image") \
    X(BEAM, "collimated-beam", "a collimated beam shines") \
    X(PUNCTUAL, "punctual", "a point, spot or directional light shines") \
    X(NEXT_EVENT, "next-event", "surfaces that spread light look for emitters") \
    X(RECTANGLE, "rectangle", \
      "one of these emitters is a rectangle: they look for it by solid angle") \
    X(REACH, "reach", \
      "surfaces that spread light choose among a few emitters by what these may bring") \
    X(EARLY_ROULETTE, "early-roulette", \
      "surfaces that spread light look for all of it: what a path brings after its first ones is " \
      "little, and roulette ends more of them") \
    X(AIM, "aim", "a sensor sees a parallel emitter whose cone is narrower than its pupil") \
    X(LIGHT_TRACING, "light-tracing", \
      "light of emitters reaches surfaces that spread it, or a beam the lens, through smooth " \
      "ones") \
    X(MIXED, "mixed", \
      "--precision mixed: where smooth surfaces are met and which way rays go on is worked out " \
      "in double") \
    X(INTERLEAVE, "interleave", \
      "surfaces that spread light among so many triangles that rays which are left alone take " \
      "turns while others wait for memory")

enum {
#define MCV_X(NAME, word, why) MCV_FEATURE_##NAME,
    MCV_FEATURES(MCV_X)
#undef MCV_X
        MCV_FEATURE_COUNT
};

/* X(stage, whether it runs, in the terms of MCV_WITH_…): in the order in which they run. The names
 * are keys of `check --json`; kernels/README.md says which file has each. */
#define MCV_STAGES(X) \
    X(aim_pupils, MCV_WITH_AIM) \
    X(generate_rays, 1) \
    X(intersect_closest, 1) \
    X(sample_emitters, MCV_WITH_NEXT_EVENT) \
    X(intersect_shadow, MCV_WITH_NEXT_EVENT) \
    X(shade_surfaces, 1) \
    X(accumulate_film, 1) \
    X(trace_emitter_paths, MCV_WITH_LIGHT_TRACING)

#endif
