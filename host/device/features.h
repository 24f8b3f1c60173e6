/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which features a render needs (mcvisi/features.h). One function decides it, from the scene, its
 * packed tables, the sensor and the options; each feature comes with its cause.
 */
#ifndef MCVISI_HOST_DEVICE_FEATURES_H
#define MCVISI_HOST_DEVICE_FEATURES_H

#include "device/pack.h"

/* Declares MCV_WITH_<NAME>, 0 or 1, of each feature as a variable, so that the host can evaluate
 * conditions of the kernels. */
#define MCV_FEATURE_VARIABLES(features) \
    const uint64_t feature_bits = (features); \
    MCV_FEATURES(MCV_FEATURE_VARIABLE)
#define MCV_FEATURE_VARIABLE(NAME, word, why) \
    const uint32_t MCV_WITH_##NAME = feature_bits >> MCV_FEATURE_##NAME & 1; \
    (void)MCV_WITH_##NAME;

enum { MCV_CAUSE_SIZE = 160 };

/* The options that decide features. */
typedef struct mcv_feature_options {
    bool mixed;          /* --precision mixed */
    bool no_light_paths; /* leaves out LIGHT_TRACING */
    bool records;        /* what each element of an emitter brings */
    bool no_split;       /* leaves out SPLIT */
} mcv_feature_options;

/* The first cause of each feature, such as `material "glass"`; empty for features that are not
 * needed. */
typedef struct mcv_feature_causes {
    char of[MCV_FEATURE_COUNT][MCV_CAUSE_SIZE];
} mcv_feature_causes;

/*
 * Decides the features, bit MCV_FEATURE_…, of a packed scene. REACH, RECTANGLE, MANY_EMITTERS and
 * EARLY_ROULETTE need packed emitters; PUPIL_GUIDE and LIGHT_TRACING depend on the sensor. `sensor`
 * and `causes` may be NULL. The result depends on the arguments alone.
 */
uint64_t mcv_decide_features(const mcv_scene *scene, const mcv_packed *packed,
                             const mcv_sensor *sensor, mcv_feature_options options,
                             mcv_feature_causes *causes);

/* "dielectric normals parallel": the names of a set of features. */
void mcv_feature_names(uint64_t features, char *names, size_t size);

/* The -D options that specialise a program for a scene and one kind of sensor. random: independent
 * random numbers instead of Sobol' points. */
void mcv_feature_defines(uint64_t features, uint32_t channels, uint32_t sensor_type, bool random,
                         uint32_t slice, char *options, size_t size);

/* 32-bit words of a path's state with these features. */
uint32_t mcv_path_words(uint64_t features, uint32_t channels);

/* The largest number of branches of a sample's path with these features. */
uint32_t mcv_path_branches(uint64_t features);

#endif
