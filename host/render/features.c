/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "kernels/path/camera_path.h"
#include "device/light.h"
#include "device/pack.h"
#include "render/render.h"
#include "scene/sensors.h"

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
        length += (size_t)snprintf(names + length, size - length, "%s%s", length > 0 ? " " : "",
                                   feature_words[i]);
    }
}

void mcv_feature_options(uint32_t features, uint32_t channels, uint32_t sensor_type,
                         uint32_t sampler, uint32_t slice, char *options, size_t size) {
    snprintf(
        options, size,
        "-DMCV_CHANNELS=%u -DMCV_SENSOR=%s -DMCV_SENSOR_%s=1 -DMCV_SAMPLER_RANDOM=%d -DMCV_SLICE=%u"
#define MCV_X(NAME, word, why) " -DMCV_WITH_" #NAME "=%u"
        MCV_FEATURES(MCV_X)
#undef MCV_X
            ,
        channels, sensor_names[sensor_type], sensor_names[sensor_type],
        sampler == MCV_SAMPLER_RANDOM,
        slice
#define MCV_X(NAME, word, why) , features >> MCV_FEATURE_##NAME & 1
            MCV_FEATURES(MCV_X)
#undef MCV_X
    );
}

/*
 * The largest angle between the rays of sight of a pixel and the chief one, and where they go
 * through optics what these may make of it; 0 of a pinhole.
 */
static double pupil_half_angle(const mcv_sensor *sensor, bool through_optics) {
    const mcv_telecentric_params *t = &sensor->as.telecentric;
    const mcv_thin_lens_params *l = &sensor->as.thin_lens;
    const mcv_light_field_params *f = &sensor->as.light_field;
    /* The same optics may spread what the pupil collects over some larger angle. */
    const double spread = through_optics ? 4 : 1;
    if (sensor->type == MCV_SENSOR_TELECENTRIC)
        return spread * atan(t->stopDiameter / 2 / t->focalLength);
    /* To aim costs a dozen rays for each of the many pixels, which all see little of the lens: only
     * for certain. */
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD && (f->binning[0] > 1 || f->binning[1] > 1))
        return 0; /* several chief rays */
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD)
        return atan(f->lensDiameter / 2 / fmin(f->angularResolution[0], f->angularResolution[1]) *
                    fabs(mcv_kappa(f->focalLength, f->imageDistance)));
    if (sensor->type != MCV_SENSOR_THIN_LENS) return 0;
    /* Optics in between may part rays that are parallel here: assume about as strong ones as the
     * camera's. */
    const double power =
        through_optics ? 1 / l->focalLength : fabs(mcv_kappa(l->focalLength, l->imageDistance));
    return spread * atan(l->lensDiameter / 2 * power);
}

uint32_t mcv_sensor_features(const mcv_packed *packed, const mcv_sensor *sensor) {
    const bool through_optics =
        packed->features & (1u << MCV_FEATURE_DIELECTRIC | 1u << MCV_FEATURE_MIRROR);
    const double alpha = pupil_half_angle(sensor, through_optics);
    const double *m = sensor->to_world.m;
    uint32_t features =
        packed->features | (mcv_traces_light(packed, sensor) ? 1u << MCV_FEATURE_LIGHT_TRACING : 0);
    for (uint32_t i = 0; i < packed->emitter_count; ++i) {
        const mcv_device_emitter *e = &packed->emitters[i];
        if (e->type != MCV_EMITTER_PARALLEL || !e->parallel.from_receiver) continue;
        const double beta = 2 * asin((double)e->parallel.sin_half);
        /* Of the emitter's axis and the node's z: both point towards where the light goes. */
        const double apart =
            acos(fmin(fmax(e->parallel.axis[0] * m[2] + e->parallel.axis[1] * m[5] +
                               e->parallel.axis[2] * m[8],
                           -1),
                      1));
        const bool facing =
            through_optics || sensor->type != MCV_SENSOR_TELECENTRIC || apart <= alpha + beta;
        if (beta < alpha && facing) features |= 1u << MCV_FEATURE_AIM;
    }
    return features;
}

uint32_t mcv_path_words(uint32_t features, uint32_t channels) {
#define MCV_CHANNELS channels
#define MCV_WITH_DIELECTRIC (features >> MCV_FEATURE_DIELECTRIC & 1)
#define MCV_WITH_GLOSS (features >> MCV_FEATURE_GLOSS & 1)
#define MCV_WITH_NEXT_EVENT (features >> MCV_FEATURE_NEXT_EVENT & 1)
#define MCV_WITH_REACH (features >> MCV_FEATURE_REACH & 1)
#define MCV_WITH_LIGHT_TRACING (features >> MCV_FEATURE_LIGHT_TRACING & 1)
#define MCV_WITH_SPLIT (features >> MCV_FEATURE_SPLIT & 1)
#define MCV_WITH_SURFACES (features >> MCV_FEATURE_SURFACES & 1)
#define MCV_WITH_TEXTURE (features >> MCV_FEATURE_TEXTURE & 1)
#define MCV_WITH_SHEET (features >> MCV_FEATURE_SHEET & 1)
#define MCV_WITH_NORMALS (features >> MCV_FEATURE_NORMALS & 1)
#define MCV_WITH_MIXED (features >> MCV_FEATURE_MIXED & 1)
#define MCV_X(field, words) +(words)
    return 0 MCV_PATH_FIELDS(MCV_X);
#undef MCV_X
}

uint32_t mcv_path_branches(uint32_t features) { return MCV_BRANCHES; }
