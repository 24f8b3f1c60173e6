/* SPDX-License-Identifier: Apache-2.0 */
/* What to render and when to stop, by the options of a verb. */
#include "verbs/render_picture.h"

static const double default_error = 0.01;
static const double default_seconds = 60;

mcv_result mcv_render_options_read(const mcv_command *command, mcv_render_options *options,
                                   mcv_error *error) {
    *options = mcv_render_defaults();
    options->sampler = command->sampler ? MCV_SAMPLER_RANDOM : MCV_SAMPLER_SOBOL;
    options->no_split = command->split != 0;
    options->replicates = (uint32_t)command->replicates;
    options->seed = (uint32_t)command->seed;
    options->depth = (uint32_t)command->depth;
    options->schedule = (uint32_t)command->schedule;
    options->threads = (uint32_t)command->threads;
    options->device = command->device;
    options->error = command->error;
    options->seconds = command->time;
    MCV_TRY(mcv_precision_read(command, &options->precision, error));
    if (command->spp && command->samples[1])
        return mcv_fail(error, MCV_USAGE,
                        "--spp and --samples both set the number of samples: give one of them");
    if (command->part && !command->samples[1])
        return mcv_fail(error, MCV_USAGE,
                        "--film is for parts of a render: give their samples by --samples A:B");
    if (command->error > 0 && command->replicates < 2)
        return mcv_fail(
            error, MCV_USAGE,
            "--error needs at least two replicates to estimate the error: give --replicates 2 or "
            "more");
    /* The words of --adaptive. */
    static const uint32_t adaptive[] = {MCV_ADAPTIVE_AUTO, MCV_ADAPTIVE_ON, MCV_ADAPTIVE_OFF};
    options->adaptive =
        command->verb == MCV_VERB_RENDER ? adaptive[command->adaptive] : MCV_ADAPTIVE_OFF;
    if (options->adaptive == MCV_ADAPTIVE_ON && command->samples[1])
        return mcv_fail(
            error, MCV_USAGE,
            "--adaptive needs a whole render: leave out --samples, and limit them by --spp");
    if (options->adaptive == MCV_ADAPTIVE_ON && mcv_wants_reference(command))
        return mcv_fail(error, MCV_USAGE,
                        "--adaptive: the reference renderer gives all pixels the same samples: "
                        "leave out one of the two");
    if (command->samples[1] || mcv_wants_reference(command)) options->adaptive = MCV_ADAPTIVE_OFF;
    options->no_light_paths = command->light_paths == 2;
    /* Sets of a sweep, and scenes that are compared, have as many of them each. */
    options->light_pilot =
        command->light_paths == 0 && !command->samples[1] && command->verb == MCV_VERB_RENDER;
    options->first = command->samples[0];
    options->last = command->samples[1];
    if (command->spp) {
        const uint64_t each = (command->spp + command->replicates - 1) / command->replicates;
        for (options->last = 1; options->last < each;) options->last *= 2;
        if (options->last > 0x80000000u)
            return mcv_fail(error, MCV_USAGE,
                            "--spp %llu: must be at most 2^31 for each of the %llu replicates",
                            (unsigned long long)command->spp,
                            (unsigned long long)command->replicates);
    }
    if (options->last == 0 && options->error == 0 && options->seconds == 0) {
        options->error = default_error;
        options->seconds = default_seconds;
    }
    return MCV_OK;
}
