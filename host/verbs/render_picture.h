/* SPDX-License-Identifier: Apache-2.0 */
/* A render: what its options ask for, and the picture that it becomes. */
#ifndef MCVISI_HOST_VERBS_RENDER_PICTURE_H
#define MCVISI_HOST_VERBS_RENDER_PICTURE_H

#include "io/exr.h"
#include "loader/load.h"
#include "options/command.h"
#include "render/render.h"

/* Name of the part with a replicate's means. */
#define MCV_PICTURE_REPLICATE "replicate %u"

/* Attribute of an image whose render was interrupted: 1. */
#define MCV_PICTURE_INTERRUPTED "mcvisi:interrupted"

/* Attribute of an image: the hash of the render that it is of. */
#define MCV_PICTURE_RENDER "mcvisi:render"
enum { MCV_RENDER_HASH = 17 }; /* bytes of its text */

/* What to render: --spp, --error, --time …; 1 % or 60 s where none of them is given. */
mcv_result mcv_render_options_read(const mcv_command *command, mcv_render_options *options,
                                   mcv_error *error);

/* A render that is done, or stopped after some samples; nothing is owned. */
typedef struct mcv_rendered {
    const mcv_scene *scene;
    uint32_t sensor;
    const mcv_render_options *options;
    const mcv_film *film;
    const mcv_render_stats *stats;
    mcv_overrides set;              /* what of the scene is not as its document says */
    uint64_t hash;                  /* FNV-1a of the document */
    uint32_t subpixels;             /* of --lasers: then a part with what surfaces they see; or 0 */
    bool replicates;                /* a part with the means of each */
    char identity[MCV_RENDER_HASH]; /* of mcv_checkpoint_hash, or "" */
} mcv_rendered;

/* The parts image and error (of two replicates or more), with `replicates` also each of them, and
 * the samples of adaptive sampling. On failure `exr` is to be freed. */
mcv_result mcv_film_parts(const mcv_film *film, bool replicates, mcv_exr *exr, mcv_error *error);

/* "irradiance" or "radiance", and their units. */
const char *mcv_rendered_quantity(const mcv_scene *scene, uint32_t sensor);
const char *mcv_rendered_unit(const mcv_scene *scene, uint32_t sensor);

/*
 * The picture: the parts image and error (of two replicates or more), the replicates, the samples
 * of adaptive sampling; with what is needed to repeat the render as attributes. On failure it is
 * empty.
 */
mcv_result mcv_rendered_develop(const mcv_rendered *rendered, mcv_exr *exr, mcv_error *error);

#endif
