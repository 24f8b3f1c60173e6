/* SPDX-License-Identifier: Apache-2.0 */
#include "render/renderer.h"

static bool is_power_of_two(uint64_t x) { return x > 0 && (x & (x - 1)) == 0; }

mcv_result mcv_render_check_options(const mcv_scene *scene, uint32_t sensor,
                                    const mcv_render_options *options, bool device,
                                    mcv_error *error) {
    if (scene->sensor_count == 0) {
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
            scene->path);
    }
    if (sensor >= scene->sensor_count) {
        return mcv_fail(error, MCV_USAGE, "%s: there is no sensor %u: the scene has %u",
                        scene->path, sensor, scene->sensor_count);
    }
    if (options->replicates < 1 || options->replicates > 64)
        return mcv_fail(error, MCV_USAGE, "replicates must be 1 to 64, not %u",
                        options->replicates);
    if (options->depth < 1 || options->depth > 1000000)
        return mcv_fail(error, MCV_USAGE, "depth must be 1 to 1000000, not %u", options->depth);
    if (device && options->precision > MCV_PRECISION_MIXED)
        return mcv_fail(
            error, MCV_USAGE,
            "precision must be single or mixed on a device: double is for the reference renderer");
    if (device && (options->slice % MCV_BLOCK != 0 || options->slice > 4096)) {
        return mcv_fail(error, MCV_USAGE,
                        "a slice must be a multiple of %d paths of at most 4096, not %u", MCV_BLOCK,
                        options->slice);
    }
    if (options->last == 0 && !(options->error > 0) && !(options->seconds > 0)) {
        return mcv_fail(error, MCV_USAGE, "no limit is given: give samples, an error or a time");
    }
    if (options->last > MCV_MOST_SAMPLES ||
        ((options->first > 0 || options->last > 0) && options->first >= options->last)) {
        return mcv_fail(error, MCV_USAGE, "the sample range %llu:%llu is empty or ends beyond 2^31",
                        (unsigned long long)options->first, (unsigned long long)options->last);
    }
    if (options->adaptive == MCV_ADAPTIVE_ON && options->first > 0)
        return mcv_fail(
            error, MCV_USAGE,
            "adaptive sampling needs a whole render: its samples cannot be rendered in parts");
    if (options->adaptive == MCV_ADAPTIVE_ON && options->last > MCV_MOST_ADAPTIVE)
        return mcv_fail(
            error, MCV_USAGE,
            "adaptive sampling gives pixels at most 2^28 samples per replicate on average, not "
            "%llu",
            (unsigned long long)options->last);
    if (options->adaptive == MCV_ADAPTIVE_ON && options->records)
        return mcv_fail(error, MCV_USAGE,
                        "adaptive sampling cannot be recorded: all pixels need the same samples");
    const uint64_t count = options->last - options->first;
    if (options->last > 0 && (!is_power_of_two(count) || options->first % count != 0)) {
        return mcv_fail(error, MCV_USAGE,
                        "the sample range %llu:%llu must hold a power of two of samples per "
                        "replicate and begin at a multiple of it",
                        (unsigned long long)options->first, (unsigned long long)options->last);
    }
    return MCV_OK;
}
