/* SPDX-License-Identifier: Apache-2.0 */
/* What a scene takes in memory, told before it is taken. */
#ifndef MCVISI_HOST_SCENE_MEMORY_H
#define MCVISI_HOST_SCENE_MEMORY_H

#include "core/json_path.h"
#include "core/memory_limit.h"
#include "scene/scene.h"

/* Bytes that a placed triangle takes at most: its share of the acceleration structure and of the
 * tables for the device, and their copy there (measured: 190 by check, 270 by a render on a CPU).
 */
enum { MCV_TRIANGLE_BYTES = 300 };

/* Bytes of a pixel: decoded, and as the scene's own. */
enum { MCV_PIXEL_BYTES = 8 };

/* Adds `bytes` to *part, which is one of `memory`. MCV_BAD_INPUT, with the numbers, where the total
 * then exceeds the limit. A limit of 0 is none. */
mcv_result mcv_memory_take(mcv_memory *memory, uint64_t *part, uint64_t bytes,
                           const mcv_json_path *place, mcv_error *error);

uint64_t mcv_memory_total(const mcv_memory *memory);

/* What the limit leaves; UINT64_MAX where there is none. */
uint64_t mcv_memory_left(const mcv_memory *memory);

/* At least the bytes that a JSON text takes as a tree. */
uint64_t mcv_memory_of_json(const char *text, size_t size);

#endif
