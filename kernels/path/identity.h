/* SPDX-License-Identifier: Apache-2.0 */
/* Which sample a path is, and with it all its random numbers. */
#ifndef MCVISI_KERNELS_IDENTITY_H
#define MCVISI_KERNELS_IDENTITY_H

#include "path/camera_path.h"
#include "path/sampler.h"
#include "world.h"

/* Which sample of which pixel a path is. */
typedef struct mcv_identity {
    uint column, row;
    uint stream; /* of random numbers: pixel, replicate, seed; a branch gets another */
    uint sample;
    uint cell; /* on the film: mcv_film_cell */
} mcv_identity;

/* The number of a pixel and a replicate on the film. */
MCV_LOOP_FUNCTION uint mcv_film_cell(__constant const mcv_frame *frame, uint column, uint row,
                                     uint replicate) {
    return (row * frame->width + column) * frame->replicates + replicate;
}

/* Pixels are numbered as listed or in squares of 8 x 8; those of a square that stick out of the
 * image have no paths. */
MCV_FUNCTION mcv_identity mcv_identify(mcv_world world, uint path) {
    __constant const mcv_frame *frame = world.frame;
    mcv_identity id;
    const uint set = frame->first_set + (path >> frame->log2_samples);
    const uint pixel = set / frame->replicates;
    const uint across = (frame->width + 7u) / 8u;
    const uint square = pixel >> 6;
    if (frame->listed) {
        id.column = world.listed[pixel] % frame->width;
        id.row = world.listed[pixel] / frame->width;
    } else {
        id.column = square % across * 8u + (pixel & 7u);
        id.row = square / across * 8u + ((pixel >> 3) & 7u);
    }
    const uint replicate = set % frame->replicates;
    id.stream = mcv_hash_2(
        mcv_hash_2(frame->seed, frame->first_pixel + id.row * frame->row_pitch + id.column),
        replicate);
    id.cell = mcv_film_cell(frame, id.column, id.row, replicate);
    id.sample = frame->first_sample + (path & ((1u << frame->log2_samples) - 1u));
    return id;
}

#if MCV_TILE
/* A pair that the tile schedule has drawn for the surface that a path has met (mcv_draw_pairs). It
 * keeps none of other depths. */
MCV_LOOP_FUNCTION mcv_pair mcv_drawn(mcv_slot slot, uint use) {
    const mcv_pair drawn = {MCV_LOAD(slot, drawn, 2u * use), MCV_LOAD(slot, drawn, 2u * use + 1u)};
    return drawn;
}
#endif

/* A pair of random numbers of the surface that a path has met, the depth-th one. In the tile
 * schedule that is the depth whose pairs have been drawn. */
MCV_LOOP_FUNCTION mcv_pair mcv_draw(mcv_slot slot, uint depth, uint use) {
#if MCV_TILE
    (void)depth;
    return mcv_drawn(slot, use);
#else
    return mcv_sample_pair(MCV_WORD(slot, stream, 0), MCV_WORD(slot, sample, 0),
                           MCV_SURFACE_PAIR(depth, use));
#endif
}

#endif
