/* SPDX-License-Identifier: Apache-2.0 */
/* What scenes and images take in memory, told before it is taken. */
#ifndef MCVISI_HOST_SCENE_MEMORY_H
#define MCVISI_HOST_SCENE_MEMORY_H

#include "core/json_path.h"
#include "scene/scene.h"

/* Bytes that a placed triangle takes at most: its share of the acceleration structure and of the
 * tables for the device, and their copy there (measured: 190 by check, 270 by a render on a CPU).
 */
enum { MCV_TRIANGLE_BYTES = 300 };

/* Bytes of a pixel: decoded, and as the scene's own. */
enum { MCV_PIXEL_BYTES = 8 };

/* Half of the machine's memory, or of the limit of the address space (RLIMIT_AS), if that is
 * lower. */
uint64_t mcv_memory_default(void);

/* Can an image be read with so many pixels, and values of all channels and parts? It takes 4 bytes
 * a value, and 12 a pixel where it is measured (measured: 15 in all for one channel, 23 for three).
 * MCV_BAD_INPUT, with the numbers, where that is more than the default. */
mcv_result mcv_memory_check_image(const char *path, uint64_t pixels, uint64_t values,
                                  mcv_error *error);

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
