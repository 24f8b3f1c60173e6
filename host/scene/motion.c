/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/motion.h"

#include "scene/params.h"
#include "scene/sensors.h"

#include <math.h>

static double or_0(double value) { return isnan(value) ? 0 : value; }

#define EXPOSURE_OF(p) \
    ((mcv_exposure){.shutter = (p)->shutter, \
                    .time = or_0((p)->exposureTime), \
                    .line_time = or_0((p)->lineTime), \
                    .strobe_delay = or_0((p)->strobeDelay), \
                    .strobe_time = or_0((p)->strobeTime), \
                    .stages = (p)->stages ? (p)->stages : 1, \
                    .jitter = or_0((p)->encoderJitter), \
                    .ripple = or_0((p)->encoderRipple), \
                    .ripples_per_line = or_0(1 / (p)->encoderPeriod), \
                    .seed = (p)->encoderSeed})

mcv_exposure mcv_sensor_exposure(const mcv_sensor *sensor) {
    switch (sensor->type) {
    case MCV_SENSOR_PINHOLE:
        return EXPOSURE_OF(&sensor->as.pinhole);
    case MCV_SENSOR_THIN_LENS:
        return EXPOSURE_OF(&sensor->as.thin_lens);
    case MCV_SENSOR_TELECENTRIC:
        return EXPOSURE_OF(&sensor->as.telecentric);
    default:
        return (mcv_exposure){.stages = 1};
    }
}

bool mcv_moves(const mcv_node_motion *motion) {
    const double *v = motion->velocity;
    return v[0] != 0 || v[1] != 0 || v[2] != 0 || motion->rate != 0;
}

bool mcv_needs_time(const mcv_scene *scene, const mcv_sensor *sensor) {
    const mcv_exposure e = mcv_sensor_exposure(sensor);
    return e.shutter == MCV_SHUTTER_LINE || e.strobe_time > 0 || mcv_moves(&scene->part_motion) ||
           (mcv_moves(&sensor->motion) && (e.time > 0 || e.shutter == MCV_SHUTTER_ROLLING));
}

static mcv_result resolve_encoder(const mcv_exposure *e, const mcv_json_path *place,
                                  mcv_error *error) {
    const mcv_json_path jitter = mcv_json_path_key(place, "encoderJitter"),
                        ripple = mcv_json_path_key(place, "encoderRipple"),
                        period = mcv_json_path_key(place, "encoderPeriod"),
                        seed = mcv_json_path_key(place, "encoderSeed");
    const bool line = e->shutter == MCV_SHUTTER_LINE;
    if (e->jitter > 0 && !line)
        return mcv_fail_at(&jitter, error,
                           "is of a \"line\" shutter, whose lines an encoder begins");
    if (e->ripple > 0 && !line)
        return mcv_fail_at(&ripple, error,
                           "is of a \"line\" shutter, whose lines an encoder begins");
    if (e->ripple > 0 && !(e->ripples_per_line > 0))
        return mcv_fail_at(&period, error, "is missing: the encoderRipple needs a period in lines");
    if (e->ripples_per_line > 0 && !(e->ripple > 0))
        return mcv_fail_at(&period, error, "is that of an encoderRipple, which is missing");
    if (e->seed > 0 && !(e->jitter > 0))
        return mcv_fail_at(&seed, error, "is that of an encoderJitter, which is missing");
    return MCV_OK;
}

/* lineTime from lineRate. */
static mcv_result resolve_rate(mcv_sensor *sensor, const mcv_json_path *place, mcv_error *error) {
    const mcv_param_table table = mcv_sensor_table(sensor->type);
    double *line = mcv_params_find(table, "lineTime", &sensor->as);
    const double *rate = mcv_params_find(table, "lineRate", &sensor->as);
    const mcv_json_path here = mcv_json_path_key(place, "lineRate");
    if (isnan(*rate)) return MCV_OK;
    if (isnan(*line)) *line = 1 / *rate;
    /* What derives from another value may have been rounded. */
    if (fabs(*line * *rate - 1) > 5e-4)
        return mcv_fail_at(&here, error, "%g Hz contradicts lineTime, %g s: give one of them",
                           *rate, *line);
    return MCV_OK;
}

mcv_result mcv_sensor_resolve_exposure(mcv_sensor *sensor, const mcv_json_path *place,
                                       mcv_error *error) {
    const mcv_param_table table = mcv_sensor_table(sensor->type);
    double *time = mcv_params_find(table, "exposureTime", &sensor->as);
    const mcv_json_path line = mcv_json_path_key(place, "lineTime"),
                        stages = mcv_json_path_key(place, "stages"),
                        strobe = mcv_json_path_key(place, "strobeTime"),
                        delay = mcv_json_path_key(place, "strobeDelay");
    if (!time) return MCV_OK;
    MCV_TRY(resolve_rate(sensor, place, error));
    const mcv_exposure e = mcv_sensor_exposure(sensor);
    const char *const *words = mcv_param_options("shutter");
    if (e.shutter != MCV_SHUTTER_GLOBAL && !(e.line_time > 0))
        return mcv_fail_at(&line, error, "is missing: a \"%s\" shutter needs the time between rows",
                           words[e.shutter]);
    if (e.shutter == MCV_SHUTTER_GLOBAL && e.line_time > 0)
        return mcv_fail_at(&line, error, "is of a \"rolling\" or \"line\" shutter");
    if (e.shutter != MCV_SHUTTER_LINE && e.stages > 1)
        return mcv_fail_at(&stages, error, "are of a \"line\" shutter");
    if (e.shutter == MCV_SHUTTER_LINE && isnan(*time)) *time = e.line_time;
    if (e.shutter == MCV_SHUTTER_LINE && *time > e.line_time)
        return mcv_fail_at(&line, error, "%g s is less than the exposureTime of %g s", e.line_time,
                           *time);
    if (e.strobe_delay > 0 && !(e.strobe_time > 0))
        return mcv_fail_at(&delay, error, "needs strobeTime, which says for how long");
    if (e.strobe_time > 0 && !(*time > 0))
        return mcv_fail_at(&strobe, error, "needs an exposureTime, in which it falls");
    if (e.strobe_time > 0 && e.shutter == MCV_SHUTTER_LINE)
        return mcv_fail_at(&strobe, error,
                           "is one flash, which a \"line\" shutter sees in few rows: shorten the "
                           "exposureTime to that of the flashes");
    return resolve_encoder(&e, place, error);
}

void mcv_motion_prepare(const mcv_sensor *sensor, mcv_motion *device) {
    const mcv_exposure e = mcv_sensor_exposure(sensor);
    const mcv_node_motion *motion = &sensor->motion;
    const double *m = sensor->to_world.m;
    *device = (mcv_motion){.sensor.turns_per_second = (float)(-motion->rate / (2 * M_PI)),
                           .exposure = (float)e.time,
                           .line_time = (float)e.line_time,
                           .strobe_begin = (float)e.strobe_delay,
                           .strobe_end = (float)(e.strobe_delay + e.strobe_time),
                           .shutter = (uint32_t)e.shutter,
                           .stages = e.stages,
                           .jitter = (float)e.jitter,
                           .ripple = (float)e.ripple,
                           .ripples_per_line = (float)e.ripples_per_line,
                           .seed = e.seed};
    /* Into the sensor's frame, whose z is the node's -z. */
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const float to = (float)((i == 2 ? -1 : 1) * m[3 * j + i]);
            device->sensor.velocity[i] += to * (float)motion->velocity[j];
            device->sensor.axis[i] += to * (float)motion->axis[j];
            device->sensor.centre[i] += to * (float)(motion->centre[j] - m[9 + j]);
        }
}

void mcv_part_motion_prepare(const mcv_scene *scene, const double origin[3],
                             mcv_rigid_motion *device) {
    const mcv_node_motion *motion = &scene->part_motion;
    device->turns_per_second = (float)(motion->rate / (2 * M_PI));
    for (int i = 0; i < 3; ++i) {
        device->velocity[i] = (float)motion->velocity[i];
        device->axis[i] = (float)motion->axis[i];
        device->centre[i] = (float)(motion->centre[i] - origin[i]);
    }
}
