/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes down which element of an emitter has brought what to a pixel: a record of the cell (pixel
 * and replicate), the element, and the value that the film gets. The order of the records depends
 * on the device; the host adds them up as integers (host/transport/gather.h). What no longer fits
 * is counted, and the host renders it again in smaller launches.
 */
#ifndef MCVISI_KERNELS_RECORD_LIGHT_H
#define MCVISI_KERNELS_RECORD_LIGHT_H

#include "stage/accumulate_film.h"

/* Whether this launch records. A pilot does not. */
MCV_LOOP_FUNCTION int mcv_records(mcv_world world) {
    return MCV_WITH_RECORDS && world.frame->record_capacity > 0u;
}

/* Makes room for so many records, and returns the place of the first one. One call for many is
 * faster, because devices take their turns. */
MCV_LOOP_FUNCTION uint mcv_reserve_records(mcv_world world, uint count) {
#if MCV_WITH_RECORDS
    return mcv_records(world) ? atomic_add(world.records, count) : 0u;
#else
    (void)world, (void)count;
    return 0u;
#endif
}

#if MCV_WITH_RECORDS
/* Writes a record at a place that was reserved. */
MCV_LOOP_FUNCTION void mcv_put_record(mcv_world world, uint place, uint cell, uint emitter_element,
                                      mcv_color value) {
    if (place >= world.frame->record_capacity) return;
    __global uint *record =
        world.records + MCV_RECORD_COUNT_WORDS + (size_t)place * MCV_RECORD_WORDS(MCV_CHANNELS);
    record[0] = cell;
    record[1] = emitter_element;
    MCV_EACH_CHANNEL(c)
    record[2 + c] = as_uint(mcv_abs(value.c[c]) <= MCV_LARGEST_VALUE ? value.c[c] : 0.0f);
}

MCV_FUNCTION void mcv_append_record(mcv_world world, uint cell, uint emitter_element,
                                    mcv_color value) {
    int brings = 0;
    MCV_EACH_CHANNEL(c)
    brings |= (value.c[c] != 0.0f) & (mcv_abs(value.c[c]) <= MCV_LARGEST_VALUE);
    if (brings) mcv_put_record(world, mcv_reserve_records(world, 1u), cell, emitter_element, value);
}

/* What light in the radiance of a camera path adds to the film. */
MCV_LOOP_FUNCTION mcv_color mcv_recorded_value(mcv_world world, mcv_slot slot, mcv_color light) {
    mcv_color value;
    MCV_EACH_CHANNEL(c)
    value.c[c] = mcv_film_value(world, MCV_LOAD(slot, weight, 0), light.c[c], (uint)c);
    return value;
}
#endif

/* Light that has been added to the radiance of a camera path. */
MCV_LOOP_FUNCTION void mcv_record_radiance(mcv_world world, mcv_slot slot, uint emitter_element,
                                           mcv_color light) {
#if MCV_WITH_RECORDS
    if (mcv_records(world))
        mcv_append_record(world, MCV_WORD(slot, cell, 0), emitter_element,
                          mcv_recorded_value(world, slot, light));
#else
    (void)world, (void)slot, (void)emitter_element, (void)light;
#endif
}

/* The same where a place has been reserved: the light may be none. */
MCV_LOOP_FUNCTION void mcv_record_at(mcv_world world, mcv_slot slot, uint place,
                                     uint emitter_element, mcv_color light) {
#if MCV_WITH_RECORDS
    if (mcv_records(world))
        mcv_put_record(world, place, MCV_WORD(slot, cell, 0), emitter_element,
                       mcv_recorded_value(world, slot, light));
#else
    (void)world, (void)slot, (void)place, (void)emitter_element, (void)light;
#endif
}

#endif
