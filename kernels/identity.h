/* SPDX-License-Identifier: Apache-2.0 */
/* Which sample a path is, and with it all its random numbers. */
#ifndef MCVISI_KERNELS_IDENTITY_H
#define MCVISI_KERNELS_IDENTITY_H

#include "sampler.h"
#include "world.h"

/* Which sample of which pixel a path is. */
typedef struct mcv_identity {
    uint column, row;
    uint stream; /* of random numbers: pixel, replicate, seed */
    uint sample;
} mcv_identity;

/* Pixels are numbered tile by tile, 8 x 8 each; those of a tile that stick out of the image have no paths. */
MCV_FUNCTION mcv_identity mcv_identify(__constant const mcv_frame *frame, uint path) {
    mcv_identity id;
    const uint set = frame->first_set + (path >> frame->log2_samples);
    const uint pixel = set / frame->replicates;
    const uint tiles = (frame->width + 7u) / 8u;
    id.column = (pixel >> 6) % tiles * 8u + (pixel & 7u);
    id.row = (pixel >> 6) / tiles * 8u + ((pixel >> 3) & 7u);
    id.stream = mcv_hash_2(mcv_hash_2(frame->seed, frame->first_pixel + id.row * frame->row_pitch + id.column), set % frame->replicates);
    id.sample = frame->first_sample + (path & ((1u << frame->log2_samples) - 1u));
    return id;
}

#endif
