/* SPDX-License-Identifier: Apache-2.0 */
#include "io/exr_header.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FLAG_TILED = 0x200, FLAG_LONG_NAMES = 0x400, FLAG_DEEP = 0x800, FLAG_MULTI_PART = 0x1000 };
enum { PIXEL_UINT, PIXEL_HALF, PIXEL_FLOAT };

/* Attributes that decide how pixels are read. */
enum {
    SEEN_CHANNELS = 1,
    SEEN_COMPRESSION = 2,
    SEEN_WINDOW = 4,
    SEEN_TYPE = 8,
    SEEN_NAME = 16,
    SEEN_CHUNKS = 32,
    SEEN_TILES = 64
};

enum { MAX_ATTRIBUTES = 1024 };

mcv_result mcv_exr_damaged(const mcv_exr_reader *r, const char *what) {
    return mcv_fail(r->error, MCV_BAD_INPUT, "%s: damaged OpenEXR file: %s (at byte %zu of %zu)",
                    r->path, what, r->at, r->size);
}

static mcv_result refused(const mcv_exr_reader *r, const char *what) {
    return mcv_fail(r->error, MCV_BAD_INPUT, "%s: %s; save it as a flat image with whole channels",
                    r->path, what);
}

uint32_t mcv_exr_u32(const uint8_t *b) {
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

int32_t mcv_exr_i32(const uint8_t *b) {
    const uint32_t bits = mcv_exr_u32(b);
    int32_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

uint64_t mcv_exr_u64(const uint8_t *b) {
    return mcv_exr_u32(b) | (uint64_t)mcv_exr_u32(b + 4) << 32;
}

/* The next count bytes, or NULL where the file has fewer. */
const uint8_t *mcv_exr_take(mcv_exr_reader *r, size_t count) {
    if (count > r->size - r->at) return NULL;
    const uint8_t *bytes = r->bytes + r->at;
    r->at += count;
    return bytes;
}

/* The next zero-terminated string, or NULL where it is longer than a name may be. */
static const char *take_name(mcv_exr_reader *r) {
    const size_t most = r->long_names ? MCV_EXR_NAME - 1 : MCV_EXR_ATTRIBUTE_NAME - 1;
    const size_t left = r->size - r->at;
    const char *name = (const char *)r->bytes + r->at;
    const char *end = memchr(name, 0, left < most + 1 ? left : most + 1);
    if (!end) return NULL;
    r->at += (size_t)(end - name) + 1;
    return name;
}

bool mcv_exr_take_attribute(mcv_exr_reader *r, mcv_exr_raw *a) {
    *a = (mcv_exr_raw){.name = take_name(r)};
    if (!a->name) return false;
    if (a->name[0] == '\0') return true;
    a->type = take_name(r);
    const uint8_t *size = a->type ? mcv_exr_take(r, 4) : NULL;
    if (!size) return false;
    a->size = mcv_exr_u32(size);
    a->value = mcv_exr_take(r, a->size);
    return a->value;
}

static mcv_result read_channels(const mcv_exr_reader *r, const mcv_exr_raw *attribute,
                                mcv_exr_part_header *part) {
    mcv_exr_reader list = *r;
    list.bytes = attribute->value;
    list.size = attribute->size;
    list.at = 0;
    for (;;) {
        const char *name = take_name(&list);
        if (!name) return mcv_exr_damaged(r, "a channel name has no end");
        if (name[0] == '\0') break;
        const uint8_t *b = mcv_exr_take(&list, 16);
        if (!b) return mcv_exr_damaged(r, "the channel list is truncated");
        if (part->channel_count == MCV_EXR_MAX_CHANNELS) return refused(r, "more than 64 channels");
        if (mcv_exr_i32(b) < PIXEL_UINT || mcv_exr_i32(b) > PIXEL_FLOAT)
            return mcv_exr_damaged(r, "unknown pixel type");
        if (mcv_exr_i32(b + 8) != 1 || mcv_exr_i32(b + 12) != 1)
            return refused(r, "it has subsampled channels, which are not supported");
        for (uint32_t i = 0; i < part->channel_count; ++i) {
            if (strcmp(part->channels[i].name, name) == 0)
                return mcv_exr_damaged(r, "two channels have one name");
        }
        mcv_exr_channel *channel = &part->channels[part->channel_count++];
        snprintf(channel->name, sizeof channel->name, "%s", name);
        channel->bytes = mcv_exr_i32(b) == PIXEL_HALF ? 2 : 4;
    }
    if (part->channel_count == 0) return mcv_exr_damaged(r, "no channels");
    if (list.at != list.size) return mcv_exr_damaged(r, "there are bytes after the channel list");
    return MCV_OK;
}

static mcv_result read_window(const mcv_exr_reader *r, const mcv_exr_raw *attribute,
                              mcv_exr_part_header *part) {
    int64_t box[4];
    for (int i = 0; i < 4; ++i) {
        box[i] = mcv_exr_i32(attribute->value + (size_t)4 * i);
        if (box[i] < -(1 << 30) || box[i] > 1 << 30)
            return mcv_exr_damaged(r, "the data window lies beyond ±2^30");
    }
    const int64_t width = box[2] - box[0] + 1, height = box[3] - box[1] + 1;
    if (width < 1 || height < 1) return mcv_exr_damaged(r, "the data window is empty");
    if (width > MCV_EXR_MAX_SIDE || height > MCV_EXR_MAX_SIDE)
        return mcv_exr_damaged(r, "the data window is larger than 32768 pixels");
    part->width = (uint32_t)width;
    part->height = (uint32_t)height;
    part->y_min = (int32_t)box[1];
    return MCV_OK;
}

static bool is(const mcv_exr_raw *attribute, const char *name) {
    return strcmp(attribute->name, name) == 0;
}

static bool has_type(const mcv_exr_raw *attribute, const char *type, uint32_t size) {
    return strcmp(attribute->type, type) == 0 && attribute->size == size;
}

/* Width and height of a tile; the kind of levels, and how their sizes are rounded. */
static mcv_result read_tiles(const mcv_exr_reader *r, const mcv_exr_raw *a,
                             mcv_exr_part_header *part) {
    part->tile_width = mcv_exr_u32(a->value);
    part->tile_height = mcv_exr_u32(a->value + 4);
    part->level_mode = a->value[8] & 0xf;
    part->round_up = a->value[8] >> 4 == 1;
    if (part->tile_width < 1 || part->tile_width > MCV_EXR_MAX_SIDE || part->tile_height < 1 ||
        part->tile_height > MCV_EXR_MAX_SIDE)
        return mcv_exr_damaged(r, "a tile's sides must have 1 to 32768 pixels");
    if (part->level_mode > MCV_EXR_RIPMAP || a->value[8] >> 4 > 1)
        return mcv_exr_damaged(r, "unknown levels of tiles");
    return MCV_OK;
}

/* Takes an attribute on which the pixels depend; others are passed over. Sets the bit of what was
 * seen. */
static mcv_result read_essential(const mcv_exr_reader *r, const mcv_exr_raw *a,
                                 mcv_exr_part_header *part, uint32_t *seen) {
    if (is(a, "channels")) {
        *seen |= SEEN_CHANNELS;
        return read_channels(r, a, part);
    }
    if (is(a, "dataWindow")) {
        *seen |= SEEN_WINDOW;
        return read_window(r, a, part);
    }
    if (is(a, "compression")) {
        if (a->value[0] >= MCV_EXR_COMPRESSIONS)
            return mcv_exr_damaged(r, "`compression` must be a known compression");
        part->compression = a->value[0];
        *seen |= SEEN_COMPRESSION;
    } else if (is(a, "type")) {
        const bool tiled = has_type(a, "string", 10) && memcmp(a->value, "tiledimage", 10) == 0;
        if (!tiled && (!has_type(a, "string", 13) || memcmp(a->value, "scanlineimage", 13) != 0))
            return refused(r, "a deep part");
        part->tiled = tiled;
        *seen |= SEEN_TYPE;
    } else if (is(a, "name")) {
        if (a->size >= MCV_EXR_NAME)
            return mcv_exr_damaged(r, "`name` must be a string of limited length");
        memcpy(part->name, a->value, a->size);
        *seen |= SEEN_NAME;
    } else if (is(a, "chunkCount")) {
        part->chunk_count = mcv_exr_u32(a->value);
        *seen |= SEEN_CHUNKS;
    } else if (is(a, "tiles")) {
        *seen |= SEEN_TILES;
        return read_tiles(r, a, part);
    }
    return MCV_OK;
}

static double number_at(const uint8_t *value, char scalar) {
    const uint32_t bits32 = mcv_exr_u32(value);
    const uint64_t bits64 = scalar == 'd' ? mcv_exr_u64(value) : 0;
    float number32;
    double number64;
    memcpy(&number32, &bits32, sizeof number32);
    memcpy(&number64, &bits64, sizeof number64);
    return scalar == 'd' ? number64 : scalar == 'f' ? (double)number32 : (double)mcv_exr_i32(value);
}

/* What OpenEXR itself writes into each part. It is no news to the caller, and must not be written
 * again. */
static bool is_structure(const mcv_exr_raw *a) {
    static const char *const names[] = {"name",
                                        "type",
                                        "chunkCount",
                                        "version",
                                        "pixelAspectRatio",
                                        "screenWindowWidth",
                                        "screenWindowCenter"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (is(a, names[i])) return true;
    }
    return false;
}

/* Keeps an attribute of part 0 for the caller, where its type is one that mcv_attribute can hold.
 */
static mcv_result keep_attribute(const mcv_exr_reader *r, const mcv_exr_raw *a,
                                 mcv_exr_header *header) {
    static const struct {
        const char *type;
        uint32_t count;
        char scalar;
    } kinds[] = {{"int", 1, 'i'},         {"float", 1, 'f'}, {"double", 1, 'd'},
                 {"v2i", 2, 'i'},         {"v2f", 2, 'f'},   {"v2d", 2, 'd'},
                 {"floatvector", 4, 'f'}, {"m44f", 16, 'f'}, {"m44d", 16, 'd'}};
    mcv_attribute kept = {0};
    if (strcmp(a->type, "string") == 0) {
        kept.text = strndup((const char *)a->value, a->size);
    } else {
        for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k) {
            const uint32_t scalar_size = kinds[k].scalar == 'd' ? 8 : 4;
            if (!has_type(a, kinds[k].type, kinds[k].count * scalar_size)) continue;
            kept.count = kinds[k].count;
            for (uint32_t i = 0; i < kept.count; ++i)
                kept.numbers[i] = number_at(a->value + (size_t)i * scalar_size, kinds[k].scalar);
        }
        if (kept.count == 0) return MCV_OK;
    }
    kept.name = strdup(a->name);
    header->attributes[header->attribute_count++] = kept;
    if (!kept.name || (kept.count == 0 && !kept.text))
        return mcv_fail(r->error, MCV_FAILED, "%s: no memory for its header", r->path);
    return MCV_OK;
}

/* Reads the attributes of one part up to and with the empty name that ends them. */
static mcv_result read_part(mcv_exr_reader *r, mcv_exr_header *header) {
    mcv_exr_part_header *part = &header->parts[header->part_count];
    const bool first = header->part_count == 0;
    *part = (mcv_exr_part_header){0};
    uint32_t seen = 0, count = 0;
    const char *names[MAX_ATTRIBUTES];
    for (;; ++count) {
        mcv_exr_raw a;
        const char *wrong = NULL;
        if (!mcv_exr_take_attribute(r, &a))
            return mcv_exr_damaged(r, !a.name   ? "an attribute's name has no end"
                                      : !a.size ? "an attribute is truncated"
                                                : "an attribute is longer than the file");
        if (!a.value) break;
        if (count == MAX_ATTRIBUTES) return mcv_exr_damaged(r, "more than 1024 attributes");
        if ((wrong = mcv_exr_wrong_attribute(&a))) return mcv_exr_damaged(r, wrong);
        for (uint32_t i = 0; i < count; ++i) {
            if (strcmp(names[i], a.name) == 0)
                return mcv_exr_damaged(r, "an attribute occurs twice");
        }
        names[count] = a.name;
        header->attribute_bytes += a.size;
        MCV_TRY(read_essential(r, &a, part, &seen));
        if (first && !is_structure(&a)) MCV_TRY(keep_attribute(r, &a, header));
    }
    const uint32_t needed = SEEN_CHANNELS | SEEN_COMPRESSION | SEEN_WINDOW |
                            (r->multi_part ? SEEN_TYPE | SEEN_NAME | SEEN_CHUNKS : 0);
    if ((seen & needed) != needed) {
        return mcv_exr_damaged(
            r, r->multi_part
                   ? "a part lacks channels, compression, dataWindow, name, type or chunkCount"
                   : "channels, compression or dataWindow is missing");
    }
    if (!r->multi_part) part->tiled = r->tiled; /* the flag counts */
    if (part->tiled && !(seen & SEEN_TILES)) return mcv_exr_damaged(r, "`tiles` is missing");
    /* Tiles larger than the image have its size, but OpenEXR would take memory for all of them. */
    if (part->tile_width > part->width) part->tile_width = part->width;
    if (part->tile_height > part->height) part->tile_height = part->height;
    const uint32_t chunks = mcv_exr_count_chunks(part);
    if ((seen & SEEN_CHUNKS) && part->chunk_count != chunks)
        return mcv_exr_damaged(r, "`chunkCount` does not fit the data window");
    part->chunk_count = chunks;
    ++header->part_count;
    return MCV_OK;
}

mcv_exr_reader mcv_exr_reader_begin(const char *path, const uint8_t *bytes, size_t size,
                                    mcv_error *error) {
    mcv_exr_reader r = {.path = path, .bytes = bytes, .size = size, .error = error};
    if (!mcv_exr_take(&r, 8)) return r;
    const uint32_t version = mcv_exr_u32(bytes + 4);
    r.multi_part = (version & FLAG_MULTI_PART) != 0;
    r.tiled = (version & FLAG_TILED) != 0;
    r.long_names = (version & FLAG_LONG_NAMES) != 0;
    return r;
}

static mcv_result read_parts(mcv_exr_reader *r, mcv_exr_header *header) {
    if (r->at < 8 || mcv_exr_u32(r->bytes) != 20000630u) {
        return mcv_fail(r->error, MCV_BAD_INPUT,
                        "%s: not an OpenEXR file: its first bytes are not 76 2f 31 01", r->path);
    }
    const uint32_t version = mcv_exr_u32(r->bytes + 4);
    if ((version & 0xffu) != 2) return mcv_exr_damaged(r, "its version is not 2");
    if (version & FLAG_DEEP) return refused(r, "a deep image");
    if (version & ~(0xffu | FLAG_TILED | FLAG_LONG_NAMES | FLAG_MULTI_PART))
        return mcv_exr_damaged(r, "unknown flags beside the version");
    uint64_t values = 0;
    do {
        if (header->part_count == MCV_EXR_MAX_PARTS) return refused(r, "more than 128 parts");
        MCV_TRY(read_part(r, header));
        const mcv_exr_part_header *part = &header->parts[header->part_count - 1];
        values += (uint64_t)part->width * part->height * part->channel_count;
        if (values * sizeof(float) > MCV_EXR_MAX_BYTES)
            return refused(r, "more than 4 GiB of pixels");
        if (r->at >= r->size) return mcv_exr_damaged(r, "it ends with the header");
    } while (r->multi_part && r->bytes[r->at] != 0);
    if (r->multi_part) ++r->at; /* the empty header that ends the list */
    return MCV_OK;
}

mcv_result mcv_exr_header_read(const char *path, const uint8_t *bytes, size_t size,
                               mcv_exr_header *header, mcv_error *error) {
    mcv_exr_reader r = mcv_exr_reader_begin(path, bytes, size, error);
    *header = (mcv_exr_header){.parts = calloc(MCV_EXR_MAX_PARTS, sizeof *header->parts),
                               .attributes = calloc(MAX_ATTRIBUTES, sizeof *header->attributes)};
    mcv_result result;
    if (header->parts && header->attributes) {
        result = read_parts(&r, header);
        if (result == MCV_OK) result = mcv_exr_check_chunks(&r, header);
    } else {
        result = mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    }
    if (result != MCV_OK) mcv_exr_header_free(header);
    return result;
}

void mcv_exr_header_free(mcv_exr_header *header) {
    for (uint32_t i = 0; i < header->attribute_count; ++i) {
        free((void *)header->attributes[i].name);
        free((void *)header->attributes[i].text);
    }
    free(header->attributes);
    free(header->parts);
    *header = (mcv_exr_header){0};
}
