/* SPDX-License-Identifier: Apache-2.0 */
/* The launches of one device for samples of a class of pixels (host/render/pass.c), which several
 * devices may share (host/render/share.c). A set is a replicate of a pixel. */
#ifndef MCVISI_HOST_RENDER_PASS_H
#define MCVISI_HOST_RENDER_PASS_H

#include "render/renderer.h"

/* The readback of some sets of a round: from the results of their launches on the device to the
 * round. */
typedef struct mcv_readback {
    uint32_t first_set, sets;
    uint32_t launched_blocks, blocks_per_set; /* of one launch; of the round */
    uint32_t first_block;                     /* of the launch that was read */
    float *read;                              /* its sums */
    double *blocks;                           /* [set][channel][block] */
    double share; /* weight of a sample in the round: 1 over the class's factor of samples */
    bool pending; /* `read` holds sums that are not yet added */
} mcv_readback;

/* What a device renders of a class: samples [first, first + count) of its sets. */
typedef struct mcv_class_pass {
    uint64_t first, count; /* with the class's factor */
    uint64_t first_set, set_count;
    uint32_t log2_samples;    /* of a launch, per set */
    uint32_t sets_per_launch; /* at most */
    mcv_readback readback;
} mcv_class_pass;

/* Plans the launches. mcv_class_pass_end must follow. */
mcv_result mcv_class_pass_begin(const mcv_renderer *r, mcv_pixel_class class, uint64_t first,
                                uint64_t count, mcv_class_pass *pass);

/* One launch: the pass's samples from *sample on, which moves behind them, of `sets` sets, at most
 * sets_per_launch, from this one on. The sums of sets whose samples are all rendered may still be
 * on the way: mcv_class_pass_read brings them to r->round. */
mcv_result mcv_class_pass_launch(mcv_renderer *r, mcv_class_pass *pass, uint64_t set, uint32_t sets,
                                 uint64_t *sample);
void mcv_class_pass_read(const mcv_renderer *r, mcv_class_pass *pass);
void mcv_class_pass_end(mcv_class_pass *pass);

/* Reports the progress of the render when so much of the class is done; false: stop now. */
bool mcv_class_pass_tell(const mcv_renderer *r, mcv_pixel_class class, uint64_t count, double share,
                         double error);

#endif
