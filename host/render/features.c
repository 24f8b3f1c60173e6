/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "../../kernels/path.h"
#include "render/pack.h"
#include "render/render.h"

static const char *const feature_words[] = {
#define MCV_X(NAME, word, why) word,
    MCV_FEATURES(MCV_X)
#undef MCV_X
};

static const char *const sensor_names[] = {
#define MCV_X(name, key, NAME) #name,
    MCV_SENSORS(MCV_X)
#undef MCV_X
};

void mcv_feature_names(uint32_t features, char *names, size_t size) {
    size_t length = 0;
    names[0] = '\0';
    for (unsigned i = 0; i < MCV_FEATURE_COUNT; ++i) {
        if (!(features >> i & 1) || length >= size) continue;
        length += (size_t)snprintf(names + length, size - length, "%s%s", length > 0 ? " " : "", feature_words[i]);
    }
}

void mcv_feature_options(uint32_t features, uint32_t channels, uint32_t sensor_type, uint32_t sampler, uint32_t slice, char *options,
                         size_t size) {
    snprintf(options, size,
             "-DMCV_CHANNELS=%u -DMCV_SENSOR=%s -DMCV_SENSOR_%s=1 -DMCV_SAMPLER_RANDOM=%d -DMCV_SLICE=%u"
#define MCV_X(NAME, word, why) " -DMCV_WITH_" #NAME "=%u"
             MCV_FEATURES(MCV_X)
#undef MCV_X
                 ,
             channels, sensor_names[sensor_type], sensor_names[sensor_type], sampler == MCV_SAMPLER_RANDOM,
             slice
#define MCV_X(NAME, word, why) , features >> MCV_FEATURE_##NAME & 1
                 MCV_FEATURES(MCV_X)
#undef MCV_X
    );
}

uint32_t mcv_path_words(uint32_t features, uint32_t channels) {
#define MCV_CHANNELS channels
#define MCV_WITH_DIELECTRIC (features >> MCV_FEATURE_DIELECTRIC & 1)
#define MCV_WITH_NEXT_EVENT (features >> MCV_FEATURE_NEXT_EVENT & 1)
#define MCV_X(field, words) +(words)
    return 0 MCV_PATH_FIELDS(MCV_X);
#undef MCV_X
}
