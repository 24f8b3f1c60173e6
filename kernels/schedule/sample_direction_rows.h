/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's loops of paths that sample an emitter in a direction. They search the sky's
 * tables together. */
#ifndef MCVISI_KERNELS_SAMPLE_DIRECTION_ROWS_H
#define MCVISI_KERNELS_SAMPLE_DIRECTION_ROWS_H

#include "schedule/tile.h"

#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
/* The pixels that the chosen paths choose of the sky. */
MCV_BATCH void mcv_find_sky_pixels(mcv_world world, mcv_slot slot,
                                   __global const mcv_device_emitter *e, const uint *chosen,
                                   uint count, uint *rows, uint *columns) {
    const uint height = e->environment.height, width = e->environment.width;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) rows[i] = columns[i] = 0;
    for (uint digit = mcv_cdf_digit(height); digit > 0; digit /= 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = chosen[i];
            const mcv_pair drawn = mcv_drawn(slot, MCV_PAIR_EMITTER);
            rows[i] = mcv_cdf_step(world.emitter_cdf + e->cdf, height, rows[i], digit,
                                   mcv_sky_row_bits(drawn));
        }
    }
    for (uint digit = mcv_cdf_digit(width); digit > 0; digit /= 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = chosen[i];
            const mcv_pair drawn = mcv_drawn(slot, MCV_PAIR_EMITTER);
            columns[i] = mcv_cdf_step(mcv_environment_row(world, e, rows[i]), width, columns[i],
                                      digit, mcv_sky_column_bits(drawn));
        }
    }
}

/* The chosen paths sample the sky. */
MCV_BATCH void mcv_sample_sky_rows(mcv_world world, mcv_slot slot, uint emitter, const uint *chosen,
                                   uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    uint rows[MCV_ROW], columns[MCV_ROW];
    mcv_find_sky_pixels(world, slot, e, chosen, count, rows, columns);
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        mcv_pixel pixel;
        pixel.row = rows[i];
        pixel.column = columns[i];
        const mcv_light_sample sample =
            mcv_sample_sky_pixel(world, at, e, pixel, mcv_drawn(slot, MCV_PAIR_EMITTER));
        mcv_store_light_sample(world, slot, emitter,
                               mcv_apply_selection(world, slot, at.point, emitter, sample));
    }
}
#endif

/* Whether chosen paths, in ascending order, lie side by side: these are then read as rows. */
MCV_FUNCTION int mcv_is_row(const uint *chosen, uint count) {
    return chosen[count - 1u] - chosen[0] == count - 1u;
}

/* The type of the emitter is known to the compiler, and whether the paths are a row. */
MCV_LOOP_FUNCTION void mcv_sample_direction_row(mcv_world world, mcv_slot slot, uint emitter,
                                                uint type, const uint *chosen, uint count,
                                                int row) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const uint first = chosen[0];
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = row ? first + i : chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        const mcv_light_sample sample =
            mcv_sample_direction(world, at, e, type, mcv_drawn(slot, MCV_PAIR_EMITTER));
        mcv_store_light_sample(world, slot, emitter,
                               mcv_apply_selection(world, slot, at.point, emitter, sample));
    }
}

/* The chosen paths sample an emitter in a direction. */
MCV_BATCH void mcv_sample_directions(mcv_world world, mcv_slot slot, uint emitter,
                                     const uint *chosen, uint count) {
    const uint type = world.emitters[emitter].type;
    const int row = mcv_is_row(chosen, count);
#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
    if (type == MCV_EMITTER_ENVIRONMENT) {
        mcv_sample_sky_rows(world, slot, emitter, chosen, count);
        return;
    }
#endif
#define MCV_X(TYPE, sample) \
    if (TYPE != MCV_EMITTER_ENVIRONMENT && type == TYPE && row) \
        mcv_sample_direction_row(world, slot, emitter, TYPE, chosen, count, 1); \
    else if (TYPE != MCV_EMITTER_ENVIRONMENT && type == TYPE) \
        mcv_sample_direction_row(world, slot, emitter, TYPE, chosen, count, 0);
    MCV_DIRECTION_SAMPLERS(MCV_X)
#undef MCV_X
    (void)slot, (void)type, (void)row;
}
#endif

#endif
