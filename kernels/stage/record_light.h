/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes down which element of an emitter has brought what to a pixel: a record of the cell (pixel
 * and replicate), the element, and the value that the film gets. The order of the records depends
 * on the device; the host adds them up as integers (host/transport/gather.h). What no longer fits
 * is counted, and the host renders it again in smaller launches.
 *
 * reads weight, cell -> writes records
 */
#ifndef MCVISI_KERNELS_RECORD_LIGHT_H
#define MCVISI_KERNELS_RECORD_LIGHT_H

#include "stage/accumulate_film.h"

/* Whether this launch records. A pilot does not. */
MCV_LOOP_FUNCTION int mcv_records(mcv_world world) {
    return MCV_WITH_RECORDS && world.frame->record_capacity > 0u;
}

#if MCV_WITH_RECORDS
MCV_FUNCTION void mcv_append_record(mcv_world world, uint cell, uint element, mcv_color value) {
    int brings = 0;
    MCV_EACH_CHANNEL(c) {
        value.c[c] = mcv_abs(value.c[c]) <= MCV_LARGEST_VALUE ? value.c[c] : 0.0f;
        brings |= value.c[c] != 0.0f;
    }
    if (!brings) return;
    const uint place = atomic_inc(world.records);
    if (place >= world.frame->record_capacity) return;
    __global uint *record =
        world.records + MCV_RECORD_COUNT_WORDS + (size_t)place * MCV_RECORD_WORDS(MCV_CHANNELS);
    record[0] = cell;
    record[1] = element;
    MCV_EACH_CHANNEL(c) record[2 + c] = as_uint(value.c[c]);
}
#endif

/* Light that has been added to the radiance of a camera path. */
MCV_LOOP_FUNCTION void mcv_record_radiance(mcv_world world, mcv_slot slot, uint element,
                                           mcv_color light) {
#if MCV_WITH_RECORDS
    mcv_color value;
    if (!mcv_records(world)) return;
    MCV_EACH_CHANNEL(c)
    value.c[c] = mcv_film_value(world, MCV_LOAD(slot, weight, 0), light.c[c], (uint)c);
    mcv_append_record(world, MCV_WORD(slot, cell, 0), element, value);
#else
    (void)world, (void)slot, (void)element, (void)light;
#endif
}

#endif
