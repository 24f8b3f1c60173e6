/* SPDX-License-Identifier: Apache-2.0 */
#include "io/exr_header.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FLAG_TILED = 0x200, FLAG_LONG_NAMES = 0x400, FLAG_DEEP = 0x800, FLAG_MULTI_PART = 0x1000 };
enum { COMPRESSION_NONE, COMPRESSION_RLE, COMPRESSION_ZIPS, COMPRESSION_ZIP };
enum { PIXEL_UINT, PIXEL_HALF, PIXEL_FLOAT };

/* Attributes that decide how pixels are read. */
enum {
    SEEN_CHANNELS = 1,
    SEEN_COMPRESSION = 2,
    SEEN_WINDOW = 4,
    SEEN_TYPE = 8,
    SEEN_NAME = 16,
    SEEN_CHUNKS = 32
};

/* A deflate stream grows at most 1032 times (two bits for 258 bytes), OpenEXR's run lengths 64
 * times (two bytes for 128). */
enum { MAX_EXPANSION = 1032 };

enum { MAX_ATTRIBUTES = 1024 };

typedef struct reader {
    const char *path;
    const uint8_t *bytes;
    size_t size, at;
    bool multi_part, long_names;
    mcv_error *error;
} reader;

typedef struct raw_attribute {
    const char *name, *type;
    const uint8_t *value;
    uint32_t size;
} raw_attribute;

static mcv_result damaged(const reader *r, const char *what) {
    return mcv_fail(r->error, MCV_BAD_INPUT, "%s: damaged OpenEXR file: %s (at byte %zu of %zu)",
                    r->path, what, r->at, r->size);
}

static mcv_result refused(const reader *r, const char *what) {
    return mcv_fail(r->error, MCV_BAD_INPUT,
                    "%s: %s; save it as a scanline image, uncompressed, RLE, ZIPS or ZIP", r->path,
                    what);
}

static uint32_t u32(const uint8_t *b) {
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static int32_t i32(const uint8_t *b) {
    const uint32_t bits = u32(b);
    int32_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint64_t u64(const uint8_t *b) { return u32(b) | (uint64_t)u32(b + 4) << 32; }

/* The next count bytes, or NULL where the file has fewer. */
static const uint8_t *take(reader *r, size_t count) {
    if (count > r->size - r->at) return NULL;
    const uint8_t *bytes = r->bytes + r->at;
    r->at += count;
    return bytes;
}

/* The next zero-terminated string, or NULL where it is longer than a name may be. */
static const char *take_name(reader *r) {
    const size_t most = r->long_names ? MCV_EXR_NAME - 1 : MCV_EXR_ATTRIBUTE_NAME - 1;
    const size_t left = r->size - r->at;
    const char *name = (const char *)r->bytes + r->at;
    const char *end = memchr(name, 0, left < most + 1 ? left : most + 1);
    if (!end) return NULL;
    r->at += (size_t)(end - name) + 1;
    return name;
}

uint32_t mcv_exr_lines_per_chunk(uint32_t compression) {
    return compression == COMPRESSION_ZIP ? 16 : 1;
}

static mcv_result read_channels(const reader *r, const raw_attribute *attribute,
                                mcv_exr_part_header *part) {
    reader list = *r;
    list.bytes = attribute->value;
    list.size = attribute->size;
    list.at = 0;
    for (;;) {
        const char *name = take_name(&list);
        if (!name) return damaged(r, "a channel name has no end");
        if (name[0] == '\0') break;
        const uint8_t *b = take(&list, 16);
        if (!b) return damaged(r, "the channel list is truncated");
        if (part->channel_count == MCV_EXR_MAX_CHANNELS) return refused(r, "more than 64 channels");
        if (i32(b) < PIXEL_UINT || i32(b) > PIXEL_FLOAT) return damaged(r, "unknown pixel type");
        if (i32(b + 8) != 1 || i32(b + 12) != 1)
            return refused(r, "it has subsampled channels, which are not supported");
        for (uint32_t i = 0; i < part->channel_count; ++i) {
            if (strcmp(part->channels[i].name, name) == 0)
                return damaged(r, "two channels have one name");
        }
        mcv_exr_channel *channel = &part->channels[part->channel_count++];
        snprintf(channel->name, sizeof channel->name, "%s", name);
        channel->bytes = i32(b) == PIXEL_HALF ? 2 : 4;
    }
    if (part->channel_count == 0) return damaged(r, "no channels");
    if (list.at != list.size) return damaged(r, "there are bytes after the channel list");
    return MCV_OK;
}

static mcv_result read_window(const reader *r, const raw_attribute *attribute,
                              mcv_exr_part_header *part) {
    int64_t box[4];
    for (int i = 0; i < 4; ++i) {
        box[i] = i32(attribute->value + (size_t)4 * i);
        if (box[i] < -(1 << 30) || box[i] > 1 << 30)
            return damaged(r, "the data window lies beyond ±2^30");
    }
    const int64_t width = box[2] - box[0] + 1, height = box[3] - box[1] + 1;
    if (width < 1 || height < 1) return damaged(r, "the data window is empty");
    if (width > MCV_EXR_MAX_SIDE || height > MCV_EXR_MAX_SIDE)
        return damaged(r, "the data window is larger than 32768 pixels");
    part->width = (uint32_t)width;
    part->height = (uint32_t)height;
    part->y_min = (int32_t)box[1];
    return MCV_OK;
}

static bool is(const raw_attribute *attribute, const char *name) {
    return strcmp(attribute->name, name) == 0;
}

static bool has_type(const raw_attribute *attribute, const char *type, uint32_t size) {
    return strcmp(attribute->type, type) == 0 && attribute->size == size;
}

/* Takes an attribute on which the pixels depend; others are passed over. Sets the bit of what was
 * seen. */
static mcv_result read_essential(const reader *r, const raw_attribute *a, mcv_exr_part_header *part,
                                 uint32_t *seen) {
    if (is(a, "channels")) {
        if (strcmp(a->type, "chlist") != 0) return damaged(r, "`channels` must be a channel list");
        *seen |= SEEN_CHANNELS;
        return read_channels(r, a, part);
    }
    if (is(a, "dataWindow")) {
        if (!has_type(a, "box2i", 16)) return damaged(r, "`dataWindow` must be a box of integers");
        *seen |= SEEN_WINDOW;
        return read_window(r, a, part);
    }
    if (is(a, "compression")) {
        if (!has_type(a, "compression", 1))
            return damaged(r, "`compression` must be a known compression");
        if (a->value[0] > COMPRESSION_ZIP) return refused(r, "its compression is not supported");
        part->compression = a->value[0];
        *seen |= SEEN_COMPRESSION;
    } else if (is(a, "type")) {
        if (!has_type(a, "string", 13) || memcmp(a->value, "scanlineimage", 13) != 0)
            return refused(r, "a tiled or deep part");
        *seen |= SEEN_TYPE;
    } else if (is(a, "name")) {
        if (strcmp(a->type, "string") != 0 || a->size >= MCV_EXR_NAME)
            return damaged(r, "`name` must be a string of limited length");
        memcpy(part->name, a->value, a->size);
        *seen |= SEEN_NAME;
    } else if (is(a, "chunkCount")) {
        if (!has_type(a, "int", 4)) return damaged(r, "`chunkCount` must be an integer");
        part->chunk_count = u32(a->value);
        *seen |= SEEN_CHUNKS;
    } else if (is(a, "tiles")) {
        return refused(r, "a tiled image");
    }
    return MCV_OK;
}

static double number_at(const uint8_t *value, char scalar) {
    const uint32_t bits32 = u32(value);
    const uint64_t bits64 = scalar == 'd' ? u64(value) : 0;
    float number32;
    double number64;
    memcpy(&number32, &bits32, sizeof number32);
    memcpy(&number64, &bits64, sizeof number64);
    return scalar == 'd' ? number64 : scalar == 'f' ? (double)number32 : (double)i32(value);
}

/* What OpenEXR itself writes into each part. It is no news to the caller, and must not be written
 * again. */
static bool is_structure(const raw_attribute *a) {
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
static mcv_result keep_attribute(const reader *r, const raw_attribute *a, mcv_exr_header *header) {
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
static mcv_result read_part(reader *r, mcv_exr_header *header) {
    mcv_exr_part_header *part = &header->parts[header->part_count];
    const bool first = header->part_count == 0;
    *part = (mcv_exr_part_header){0};
    uint32_t seen = 0, count = 0;
    const char *names[MAX_ATTRIBUTES];
    for (;; ++count) {
        raw_attribute a;
        a.name = take_name(r);
        if (!a.name) return damaged(r, "an attribute's name has no end");
        if (a.name[0] == '\0') break;
        if (count == MAX_ATTRIBUTES) return damaged(r, "more than 1024 attributes");
        a.type = take_name(r);
        const uint8_t *size = a.type ? take(r, 4) : NULL;
        if (!size) return damaged(r, "an attribute is truncated");
        a.size = u32(size);
        a.value = take(r, a.size);
        if (!a.value) return damaged(r, "an attribute is longer than the file");
        for (uint32_t i = 0; i < count; ++i) {
            if (strcmp(names[i], a.name) == 0) return damaged(r, "an attribute occurs twice");
        }
        names[count] = a.name;
        MCV_TRY(read_essential(r, &a, part, &seen));
        if (first && !is_structure(&a)) MCV_TRY(keep_attribute(r, &a, header));
    }
    const uint32_t needed = SEEN_CHANNELS | SEEN_COMPRESSION | SEEN_WINDOW |
                            (r->multi_part ? SEEN_TYPE | SEEN_NAME | SEEN_CHUNKS : 0);
    if ((seen & needed) != needed) {
        return damaged(
            r, r->multi_part
                   ? "a part lacks channels, compression, dataWindow, name, type or chunkCount"
                   : "channels, compression or dataWindow is missing");
    }
    const uint32_t lines = mcv_exr_lines_per_chunk(part->compression);
    const uint32_t chunks = (part->height + lines - 1) / lines;
    if ((seen & SEEN_CHUNKS) && part->chunk_count != chunks)
        return damaged(r, "`chunkCount` does not fit the data window");
    part->chunk_count = chunks;
    ++header->part_count;
    return MCV_OK;
}

static mcv_result read_parts(reader *r, mcv_exr_header *header) {
    const uint8_t *start = take(r, 8);
    if (!start || u32(start) != 20000630u) {
        return mcv_fail(r->error, MCV_BAD_INPUT,
                        "%s: not an OpenEXR file: its first bytes are not 76 2f 31 01", r->path);
    }
    const uint32_t version = u32(start + 4);
    if ((version & 0xffu) != 2) return damaged(r, "its version is not 2");
    if (version & (FLAG_TILED | FLAG_DEEP)) return refused(r, "a tiled or deep image");
    if (version & ~(0xffu | FLAG_LONG_NAMES | FLAG_MULTI_PART))
        return damaged(r, "unknown flags beside the version");
    r->multi_part = (version & FLAG_MULTI_PART) != 0;
    r->long_names = (version & FLAG_LONG_NAMES) != 0;

    uint64_t bytes = 0;
    do {
        if (header->part_count == MCV_EXR_MAX_PARTS) return refused(r, "more than 128 parts");
        MCV_TRY(read_part(r, header));
        const mcv_exr_part_header *part = &header->parts[header->part_count - 1];
        bytes += (uint64_t)part->width * part->height * part->channel_count * sizeof(float);
        if (bytes > MCV_EXR_MAX_BYTES) return refused(r, "more than 4 GiB of pixels");
        if (r->at >= r->size) return damaged(r, "it ends with the header");
    } while (r->multi_part && r->bytes[r->at] != 0);
    if (r->multi_part) ++r->at; /* the empty header that ends the list */
    return MCV_OK;
}

static mcv_result check_chunk(reader *r, const mcv_exr_part_header *part, uint32_t part_index,
                              uint32_t chunk, uint64_t offset, uint64_t line_bytes) {
    const size_t head = r->multi_part ? 12 : 8;
    if (offset < r->at || offset > r->size || r->size - offset < head)
        return damaged(r, "a chunk is missing or lies outside the file");
    const uint8_t *b = r->bytes + offset;
    if (r->multi_part && u32(b) != part_index) return damaged(r, "a chunk belongs to another part");
    b += head - 8;
    const uint32_t lines = mcv_exr_lines_per_chunk(part->compression);
    const uint32_t first = chunk * lines;
    if (i32(b) != part->y_min + (int32_t)first)
        return damaged(r, "the lines of a chunk do not match its place");
    const uint64_t unpacked =
        line_bytes * (part->height - first < lines ? part->height - first : lines);
    const uint64_t packed = u32(b + 4);
    if (packed > r->size - offset - head) return damaged(r, "a chunk is longer than the file");
    if (packed > unpacked || packed * MAX_EXPANSION < unpacked ||
        (part->compression == COMPRESSION_NONE && packed != unpacked)) {
        return damaged(r, "a chunk's size does not fit the pixels it holds");
    }
    return MCV_OK;
}

/* Reads the tables of chunk offsets, which follow the headers, and checks every chunk. */
static mcv_result check_chunks(reader *r, const mcv_exr_header *header) {
    const uint8_t *tables[MCV_EXR_MAX_PARTS];
    for (uint32_t p = 0; p < header->part_count; ++p) {
        tables[p] = take(r, (size_t)header->parts[p].chunk_count * 8);
        if (!tables[p]) return damaged(r, "the table of chunks is longer than the file");
    }
    for (uint32_t p = 0; p < header->part_count; ++p) {
        const mcv_exr_part_header *part = &header->parts[p];
        uint64_t line_bytes = 0;
        for (uint32_t c = 0; c < part->channel_count; ++c)
            line_bytes += (uint64_t)part->channels[c].bytes * part->width;
        for (uint32_t i = 0; i < part->chunk_count; ++i) {
            MCV_TRY(check_chunk(r, part, p, i, u64(tables[p] + (size_t)i * 8), line_bytes));
        }
    }
    return MCV_OK;
}

mcv_result mcv_exr_header_read(const char *path, const uint8_t *bytes, size_t size,
                               mcv_exr_header *header, mcv_error *error) {
    reader r = {.path = path, .bytes = bytes, .size = size, .error = error};
    *header = (mcv_exr_header){.parts = calloc(MCV_EXR_MAX_PARTS, sizeof *header->parts),
                               .attributes = calloc(MAX_ATTRIBUTES, sizeof *header->attributes)};
    mcv_result result;
    if (header->parts && header->attributes) {
        result = read_parts(&r, header);
        if (result == MCV_OK) result = check_chunks(&r, header);
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
