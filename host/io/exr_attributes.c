/* SPDX-License-Identifier: Apache-2.0 */
/* The attributes that OpenEXR takes by itself to decode an image. */
#include "io/exr_header.h"

#include <string.h>

typedef struct essential {
    const char *name, *type;
    uint32_t size; /* 0: any */
    const char *wrong;
} essential;

static const essential *find(const char *name) {
    static const essential essentials[] = {
        {"channels", "chlist", 0, "`channels` must be a channel list"},
        {"compression", "compression", 1, "`compression` must be a known compression"},
        {"dataWindow", "box2i", 16, "`dataWindow` must be a box of integers"},
        {"displayWindow", "box2i", 16, "`displayWindow` must be a box of integers"},
        {"lineOrder", "lineOrder", 1, "`lineOrder` must be an order of lines"},
        {"pixelAspectRatio", "float", 4, "`pixelAspectRatio` must be a number"},
        {"screenWindowCenter", "v2f", 8, "`screenWindowCenter` must be two numbers"},
        {"screenWindowWidth", "float", 4, "`screenWindowWidth` must be a number"},
        {"name", "string", 0, "`name` must be a string"},
        {"type", "string", 0, "`type` must be a string"},
        {"chunkCount", "int", 4, "`chunkCount` must be an integer"},
        {"tiles", "tiledesc", 9, "`tiles` must describe tiles"}};
    for (size_t i = 0; i < sizeof essentials / sizeof essentials[0]; ++i)
        if (strcmp(name, essentials[i].name) == 0) return essentials + i;
    return NULL;
}

const char *mcv_exr_wrong_attribute(const mcv_exr_raw *a) {
    const essential *e = find(a->name);
    if (!e || (strcmp(a->type, e->type) == 0 && (e->size == 0 || a->size == e->size))) return NULL;
    return e->wrong;
}

static void put_u32(uint8_t *to, uint32_t number) {
    for (int i = 0; i < 4; ++i) to[i] = (uint8_t)(number >> 8 * i);
}

void mcv_exr_simplify(uint8_t *bytes, size_t size, const mcv_exr_header *header) {
    mcv_exr_reader r = mcv_exr_reader_begin(NULL, bytes, size, NULL);
    const mcv_exr_part_header *part = header->parts;
    do {
        mcv_exr_raw a;
        while (mcv_exr_take_attribute(&r, &a) && a.value) {
            if (!find(a.name) && a.type[0]) bytes[a.type - (const char *)bytes] = '?';
            if (strcmp(a.name, "tiles") == 0) {
                put_u32(bytes + (a.value - bytes), part->tile_width);
                put_u32(bytes + (a.value - bytes) + 4, part->tile_height);
            }
        }
        ++part;
    } while (r.multi_part && r.bytes[r.at] != 0);
}
