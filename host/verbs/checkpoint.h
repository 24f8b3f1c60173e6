/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Film files of renders (film/film_file.h) with what tells to which render they belong: beside the
 * film they have
 *
 *     version    of the program
 *     identity   all that decides the bits of the image: {"scene": hash, "sensor": name, "set":
 *                texts, "resolution": "WxH", "precision": "double" of the reference renderer, …;
 *                options by their names}
 *     device     the device and its driver
 *     state      of an unfinished render: {"thinning", "decided", "seconds"}
 *     stats      what the render has counted
 */
#ifndef MCVISI_HOST_VERBS_CHECKPOINT_H
#define MCVISI_HOST_VERBS_CHECKPOINT_H

#include "render/unfinished.h"
#include "verbs/render_picture.h"

#include <jansson.h>

/* The identity of a render, to be freed by json_decref; NULL without memory. */
json_t *mcv_checkpoint_identity(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                                mcv_overrides set);

/* A hash of the identity, the version, and whether the image has a part for each replicate: images
 * of the same hash have the same bits. Empty without memory. */
void mcv_checkpoint_hash(const json_t *identity, bool replicates, char hash[MCV_RENDER_HASH]);

/* Version, identity (a copy), device and stats; NULL without memory. */
json_t *mcv_checkpoint_facts(const json_t *identity, const mcv_render_stats *stats);

/* Refuses facts of two files that are not of one render. MCV_BAD_INPUT names what differs. */
mcv_result mcv_checkpoint_same(const char *path, const json_t *facts, const char *other_path,
                               const json_t *other_facts, mcv_error *error);

/* Writes a checkpoint. */
mcv_result mcv_checkpoint_write(const char *path, const json_t *identity,
                                const mcv_unfinished *unfinished, mcv_error *error);

/* A checkpoint that was read. */
typedef struct mcv_checkpoint {
    mcv_film_file file;
    mcv_render_stats stats;
    mcv_unfinished unfinished; /* points into both */
} mcv_checkpoint;

/*
 * Reads a checkpoint of this identity. MCV_BAD_INPUT names the first option, or the version, that
 * differs, and files that are damaged. After success it must not be moved, and is freed by
 * mcv_checkpoint_free.
 */
mcv_result mcv_checkpoint_read(const char *path, const json_t *identity, mcv_checkpoint *checkpoint,
                               mcv_error *error);
void mcv_checkpoint_free(mcv_checkpoint *checkpoint);

#endif
