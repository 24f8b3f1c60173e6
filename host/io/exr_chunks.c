/* SPDX-License-Identifier: Apache-2.0 */
/* The chunks of an OpenEXR file: how many a part has, and whether each lies in the file and can
 * hold its pixels. */
#include "io/exr_header.h"

/* How often a packed chunk may be larger when unpacked. A deflate stream grows at most 1032 times
 * (two bits for 258 bytes), OpenEXR's run lengths 64 times (two bytes for 128), PIZ 454 times (nine
 * bits for 255 numbers of two bytes), B44A 11 times. DWA deflates run lengths. */
enum { MAX_EXPANSION = 1032, MAX_EXPANSION_DWA = 64 * 1032 };

/* What OpenEXR takes for a chunk, in its unpacked size (measured: 0.8 to 2.9, most by PIZ and DWA).
 */
enum { CHUNK_COPIES = 3 };

/* How often an attribute is kept (measured: 3.9, of a text of part 0). */
enum { ATTRIBUTE_COPIES = 4 };

/* A level of a tiled image: its size, its tiles and where it stands. */
typedef struct tile_level {
    uint32_t x, y, width, height, tiles_x, tiles_y;
} tile_level;

static uint32_t lines_per_chunk(uint32_t compression) {
    static const uint32_t lines[MCV_EXR_COMPRESSIONS] = {
        [MCV_EXR_NONE] = 1,  [MCV_EXR_RLE] = 1,    [MCV_EXR_ZIPS] = 1, [MCV_EXR_ZIP] = 16,
        [MCV_EXR_PIZ] = 32,  [MCV_EXR_PXR24] = 16, [MCV_EXR_B44] = 32, [MCV_EXR_B44A] = 32,
        [MCV_EXR_DWAA] = 32, [MCV_EXR_DWAB] = 256};
    return lines[compression];
}

static uint32_t divided(uint32_t size, uint32_t by) { return (size - 1) / by + 1; }

/* Levels of a side: it is halved until it is 1. */
static uint32_t count_levels(uint32_t side, bool round_up) {
    uint32_t levels = 1;
    for (; side > 1; ++levels) side = (side + round_up) / 2;
    return levels;
}

static uint32_t side_of(uint32_t side, uint32_t level, bool round_up) {
    for (; level > 0; --level) side = (side + round_up) / 2;
    return side ? side : 1;
}

static tile_level level_at(const mcv_exr_part_header *part, uint32_t x, uint32_t y) {
    tile_level l = {
        x, y, side_of(part->width, x, part->round_up), side_of(part->height, y, part->round_up),
        0, 0};
    l.tiles_x = divided(l.width, part->tile_width);
    l.tiles_y = divided(l.height, part->tile_height);
    return l;
}

/* Goes to the next level in the order of the table of chunks; false behind the last. */
static bool next_level(const mcv_exr_part_header *part, tile_level *l) {
    if (part->level_mode == MCV_EXR_ONE_LEVEL) return false;
    if (part->level_mode == MCV_EXR_MIPMAP) {
        const uint32_t longer = part->width > part->height ? part->width : part->height;
        if (l->x + 1 == count_levels(longer, part->round_up)) return false;
        *l = level_at(part, l->x + 1, l->y + 1);
        return true;
    }
    const bool row_ends = l->x + 1 == count_levels(part->width, part->round_up);
    if (row_ends && l->y + 1 == count_levels(part->height, part->round_up)) return false;
    *l = level_at(part, row_ends ? 0 : l->x + 1, row_ends ? l->y + 1 : l->y);
    return true;
}

uint32_t mcv_exr_count_chunks(const mcv_exr_part_header *part) {
    if (!part->tiled) return divided(part->height, lines_per_chunk(part->compression));
    uint64_t count = 0;
    tile_level l = level_at(part, 0, 0);
    do count += (uint64_t)l.tiles_x * l.tiles_y;
    while (next_level(part, &l));
    return count < UINT32_MAX ? (uint32_t)count : UINT32_MAX;
}

/* Bytes of a pixel in the file. */
static uint64_t pixel_bytes(const mcv_exr_part_header *part) {
    uint64_t bytes = 0;
    for (uint32_t c = 0; c < part->channel_count; ++c) bytes += part->channels[c].bytes;
    return bytes;
}

uint64_t mcv_exr_reading_bytes(const mcv_exr_header *header) {
    uint64_t bytes = ATTRIBUTE_COPIES * header->attribute_bytes;
    for (uint32_t p = 0; p < header->part_count; ++p) {
        const mcv_exr_part_header *part = &header->parts[p];
        const uint32_t lines = lines_per_chunk(part->compression);
        const uint64_t chunk =
            part->tiled ? (uint64_t)part->tile_width * part->tile_height
                        : (uint64_t)part->width * (lines < part->height ? lines : part->height);
        bytes += sizeof(float) * part->channel_count * part->width * part->height +
                 CHUNK_COPIES * pixel_bytes(part) * chunk;
    }
    return bytes;
}

/* A chunk's header is the part's number where there are several, its `place` of `words` numbers,
 * and its size. */
static mcv_result check_chunk(const mcv_exr_reader *r, const mcv_exr_part_header *part,
                              uint32_t part_index, uint64_t offset, const uint32_t *place,
                              size_t words, uint64_t unpacked) {
    const size_t head = 4 * (words + 1) + (r->multi_part ? 4 : 0);
    if (offset < r->at || offset > r->size || r->size - offset < head)
        return mcv_exr_damaged(r, "a chunk is missing or lies outside the file");
    const uint8_t *b = r->bytes + offset;
    if (r->multi_part && mcv_exr_u32(b) != part_index)
        return mcv_exr_damaged(r, "a chunk belongs to another part");
    b += r->multi_part ? 4 : 0;
    for (size_t i = 0; i < words; ++i)
        if (mcv_exr_u32(b + 4 * i) != place[i])
            return mcv_exr_damaged(r, "the lines or the tile of a chunk do not match its place");
    const uint64_t packed = mcv_exr_u32(b + 4 * words);
    if (packed > r->size - offset - head)
        return mcv_exr_damaged(r, "a chunk is longer than the file");
    const uint64_t most = part->compression >= MCV_EXR_DWAA ? MAX_EXPANSION_DWA : MAX_EXPANSION;
    if (packed > unpacked || packed * most < unpacked ||
        (part->compression == MCV_EXR_NONE && packed != unpacked))
        return mcv_exr_damaged(r, "a chunk's size does not fit the pixels it holds");
    return MCV_OK;
}

static mcv_result check_lines(const mcv_exr_reader *r, const mcv_exr_part_header *part,
                              uint32_t index, const uint8_t *table) {
    const uint64_t bytes = pixel_bytes(part) * part->width;
    const uint32_t lines = lines_per_chunk(part->compression);
    for (uint32_t i = 0; i < part->chunk_count; ++i) {
        const uint32_t left = part->height - i * lines;
        const uint32_t y = (uint32_t)part->y_min + i * lines;
        MCV_TRY(check_chunk(r, part, index, mcv_exr_u64(table + (size_t)i * 8), &y, 1,
                            bytes * (left < lines ? left : lines)));
    }
    return MCV_OK;
}

static mcv_result check_tiles(const mcv_exr_reader *r, const mcv_exr_part_header *part,
                              uint32_t index, const uint8_t *table) {
    const uint64_t bytes = pixel_bytes(part);
    tile_level l = level_at(part, 0, 0);
    do {
        for (uint32_t y = 0; y < l.tiles_y; ++y) {
            const uint32_t rows = l.height - y * part->tile_height;
            for (uint32_t x = 0; x < l.tiles_x; ++x, table += 8) {
                const uint32_t columns = l.width - x * part->tile_width;
                const uint32_t place[] = {x, y, l.x, l.y};
                const uint64_t pixels =
                    (uint64_t)(rows < part->tile_height ? rows : part->tile_height) *
                    (columns < part->tile_width ? columns : part->tile_width);
                MCV_TRY(check_chunk(r, part, index, mcv_exr_u64(table), place, 4, bytes * pixels));
            }
        }
    } while (next_level(part, &l));
    return MCV_OK;
}

mcv_result mcv_exr_check_chunks(mcv_exr_reader *r, const mcv_exr_header *header) {
    const uint8_t *tables[MCV_EXR_MAX_PARTS];
    for (uint32_t p = 0; p < header->part_count; ++p) {
        tables[p] = mcv_exr_take(r, (size_t)header->parts[p].chunk_count * 8);
        if (!tables[p]) return mcv_exr_damaged(r, "the table of chunks is longer than the file");
    }
    for (uint32_t p = 0; p < header->part_count; ++p) {
        const mcv_exr_part_header *part = &header->parts[p];
        MCV_TRY(part->tiled ? check_tiles(r, part, p, tables[p])
                            : check_lines(r, part, p, tables[p]));
    }
    return MCV_OK;
}
