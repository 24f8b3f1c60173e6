/* SPDX-License-Identifier: Apache-2.0 */
/* The layout of ZIP archives is that of PKWARE's APPNOTE 6.3, sections 4.3.7, 4.3.12 and 4.3.16. */
#include "io/npz.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "core/output_file.h"

enum {
    LOCAL = 30,   /* bytes of a member's local header before its name, */
    CENTRAL = 46, /* of its entry in the directory, */
    END = 22,     /* and of the directory's end */
    VERSION = 20,
    JANUARY_1980 = 0x21, /* a date, so that the same arrays make the same bytes */
    ALIGNMENT = 64,
    PREAMBLE = 10 /* of an NPY array, before its header */
};

#define LOCAL_MAGIC 0x04034b50u
#define CENTRAL_MAGIC 0x02014b50u
#define END_MAGIC 0x06054b50u

static void put(uint8_t *to, uint32_t value, size_t bytes) {
    for (size_t i = 0; i < bytes; ++i) to[i] = (uint8_t)(value >> 8 * i);
}

static uint32_t get(const uint8_t *from, size_t bytes) {
    uint32_t value = 0;
    for (size_t i = 0; i < bytes; ++i) value |= (uint32_t)from[i] << 8 * i;
    return value;
}

static uint32_t checksum(uint32_t so_far, const void *data, size_t bytes) {
    const uint8_t *from = data;
    uLong crc = so_far;
    for (size_t done = 0; done < bytes;) {
        const size_t part = bytes - done < UINT_MAX ? bytes - done : UINT_MAX;
        crc = crc32(crc, from + done, (uInt)part);
        done += part;
    }
    return (uint32_t)crc;
}

/* --- writing --- */

/* The header of an NPY array; returns its length. */
static size_t array_header(const mcv_npz_member *m, char header[4 * ALIGNMENT]) {
    char shape[96] = "";
    size_t length = 0;
    for (int i = 0; i < MCV_NPZ_DIMENSIONS && !m->scalar && (i == 0 || m->shape[i] > 0); ++i)
        length += (size_t)snprintf(shape + length, sizeof shape - length, "%zu,", m->shape[i]);
    snprintf(header, 4 * ALIGNMENT,
             "\x93NUMPY\x01%c%c%c{'descr': '%s', 'fortran_order': False, "
             "'shape': (%s), }",
             0, 0, 0, m->dtype, shape);
    const size_t text = strlen(header + PREAMBLE);
    const size_t total = (PREAMBLE + text + 1 + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    memset(header + PREAMBLE + text, ' ', total - PREAMBLE - text);
    header[total - 1] = '\n';
    header[8] = (char)(total - PREAMBLE);
    return total;
}

/* The fields that a local header and the directory share, from the version needed on. */
static void put_fields(uint8_t *to, const char *name, uint32_t crc, size_t bytes) {
    put(to, VERSION, 2);
    put(to + 2, 0, 2); /* flags */
    put(to + 4, 0, 2); /* stored */
    put(to + 6, 0, 2);
    put(to + 8, JANUARY_1980, 2);
    put(to + 10, crc, 4);
    put(to + 14, (uint32_t)bytes, 4);
    put(to + 18, (uint32_t)bytes, 4);
    put(to + 22, (uint32_t)strlen(name), 2);
    put(to + 24, 0, 2);
}

/* What the directory says of a member. */
typedef struct stored {
    uint32_t offset, crc;
    size_t bytes;
} stored;

static mcv_result write_member(mcv_output *out, const mcv_npz_member *m, stored *s,
                               mcv_error *error) {
    char header[4 * ALIGNMENT];
    uint8_t local[LOCAL];
    const size_t before = m->dtype ? array_header(m, header) : 0;
    *s = (stored){.offset = (uint32_t)out->size,
                  .crc = checksum(checksum(0, header, before), m->data, m->bytes),
                  .bytes = before + m->bytes};
    put(local, LOCAL_MAGIC, 4);
    put_fields(local + 4, m->name, s->crc, s->bytes);
    MCV_TRY(mcv_output_write(out, local, LOCAL, error));
    MCV_TRY(mcv_output_write(out, m->name, strlen(m->name), error));
    MCV_TRY(mcv_output_write(out, header, before, error));
    return mcv_output_write(out, m->data, m->bytes, error);
}

static mcv_result write_directory(mcv_output *out, const mcv_npz_member *members,
                                  const stored *places, size_t count, mcv_error *error) {
    const uint64_t begin = out->size;
    uint8_t end[END] = {0};
    for (size_t i = 0; i < count; ++i) {
        uint8_t entry[CENTRAL] = {0};
        put(entry, CENTRAL_MAGIC, 4);
        put(entry + 4, VERSION, 2);
        put_fields(entry + 6, members[i].name, places[i].crc, places[i].bytes);
        put(entry + 42, places[i].offset, 4);
        MCV_TRY(mcv_output_write(out, entry, CENTRAL, error));
        MCV_TRY(mcv_output_write(out, members[i].name, strlen(members[i].name), error));
    }
    put(end, END_MAGIC, 4);
    put(end + 8, (uint32_t)count, 2);
    put(end + 10, (uint32_t)count, 2);
    put(end + 12, (uint32_t)(out->size - begin), 4);
    put(end + 16, (uint32_t)begin, 4);
    return mcv_output_write(out, end, END, error);
}

mcv_result mcv_npz_write(const char *path, const mcv_npz_member *members, size_t count,
                         mcv_error *error) {
    stored places[MCV_NPZ_MEMBERS];
    mcv_output out;
    double bytes = 0;
    for (size_t i = 0; i < count; ++i) bytes += (double)members[i].bytes + 1024;
    if (count > MCV_NPZ_MEMBERS || bytes >= 0x1p32)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its arrays have %.3g GiB, a file has less than 4 GiB: keep fewer "
                        "entries",
                        path, bytes / 0x1p30);
    MCV_TRY(mcv_output_open(&out, path, error));
    mcv_result result = MCV_OK;
    for (size_t i = 0; result == MCV_OK && i < count; ++i)
        result = write_member(&out, members + i, places + i, error);
    if (result == MCV_OK) result = write_directory(&out, members, places, count, error);
    if (result == MCV_OK) return mcv_output_commit(&out, error);
    mcv_output_discard(&out);
    return result;
}

mcv_result mcv_npy_write(const char *path, const mcv_npz_member *array, mcv_error *error) {
    char header[4 * ALIGNMENT];
    mcv_output out;
    MCV_TRY(mcv_output_open(&out, path, error));
    mcv_result result = mcv_output_write(&out, header, array_header(array, header), error);
    if (result == MCV_OK) result = mcv_output_write(&out, array->data, array->bytes, error);
    if (result == MCV_OK) return mcv_output_commit(&out, error);
    mcv_output_discard(&out);
    return result;
}

/* --- reading --- */

static mcv_result damaged(const mcv_npz *z, const char *what, mcv_error *error) {
    return mcv_fail(error, MCV_BAD_INPUT, "%s: is no NPZ file, or a damaged one: %s", z->path,
                    what);
}

/* Reads the directory's entry at *at and finds its member. */
static mcv_result read_entry(mcv_npz *z, size_t *at, mcv_error *error) {
    const uint8_t *e = z->file + *at;
    if (*at > z->size || z->size - *at < CENTRAL || get(e, 4) != CENTRAL_MAGIC)
        return damaged(z, "its directory is cut off", error);
    const size_t name = get(e + 28, 2), rest = get(e + 30, 2) + get(e + 32, 2),
                 bytes = get(e + 24, 4), offset = get(e + 42, 4);
    if (z->size - *at < CENTRAL + name + rest) return damaged(z, "its directory is cut off", error);
    if (get(e + 10, 2) != 0 || get(e + 20, 4) != bytes)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is compressed: write it without compression, as numpy.savez does",
                        z->path);
    if (name == 0 || name >= sizeof z->members[0].name || memchr(e + CENTRAL, 0, name))
        return damaged(z, "a member has no name, or a long one", error);
    if (offset > z->size || z->size - offset < LOCAL || get(z->file + offset, 4) != LOCAL_MAGIC)
        return damaged(z, "a member is not where the directory says", error);
    const size_t data =
        offset + LOCAL + get(z->file + offset + 26, 2) + get(z->file + offset + 28, 2);
    if (data > z->size || z->size - data < bytes) return damaged(z, "a member is cut off", error);
    if (checksum(0, z->file + data, bytes) != get(e + 16, 4))
        return damaged(z, "a member does not have its checksum", error);
    memcpy(z->members[z->count].name, e + CENTRAL, name);
    z->members[z->count].name[name] = '\0';
    z->members[z->count].data = z->file + data;
    z->members[z->count++].bytes = bytes;
    *at += CENTRAL + name + rest;
    return MCV_OK;
}

static mcv_result read_directory(mcv_npz *z, mcv_error *error) {
    size_t end = z->size < END ? 0 : z->size - END;
    if (z->size < END) return damaged(z, "it is too short", error);
    /* A comment of up to 2^16 bytes may follow. */
    const size_t first = end > 0xffff ? end - 0xffff : 0;
    while (end > first && get(z->file + end, 4) != END_MAGIC) --end;
    if (get(z->file + end, 4) != END_MAGIC) return damaged(z, "it has no directory", error);
    const size_t count = get(z->file + end + 10, 2);
    size_t at = get(z->file + end + 16, 4);
    if (count > MCV_NPZ_MEMBERS) return damaged(z, "it has too many members", error);
    for (size_t i = 0; i < count; ++i) MCV_TRY(read_entry(z, &at, error));
    return MCV_OK;
}

mcv_result mcv_npz_read(const char *path, mcv_npz *npz, mcv_error *error) {
    *npz = (mcv_npz){.path = path};
    MCV_TRY(mcv_file_load(path, &npz->file, &npz->size, error));
    const mcv_result result = read_directory(npz, error);
    if (result != MCV_OK) mcv_npz_free(npz);
    return result;
}

const uint8_t *mcv_npz_bytes(const mcv_npz *npz, const char *name, size_t *bytes) {
    for (size_t i = 0; i < npz->count; ++i)
        if (strcmp(npz->members[i].name, name) == 0) {
            *bytes = npz->members[i].bytes;
            return npz->members[i].data;
        }
    return NULL;
}

/* Whether the header's shape is the one asked for; *length: of the dimension that may have any. */
static bool has_shape(const char *text, const size_t shape[MCV_NPZ_DIMENSIONS], size_t *length) {
    if (*text++ != '(') return false;
    for (int i = 0; i < MCV_NPZ_DIMENSIONS && (i == 0 || shape[i] > 0); ++i) {
        char *end;
        if (*text < '0' || *text > '9') return false;
        const unsigned long long side = strtoull(text, &end, 10);
        if (shape[i] == SIZE_MAX)
            *length = (size_t)side;
        else if (side != shape[i])
            return false;
        text = end + (*end == ',');
        text += *text == ' ';
    }
    return *text == ')';
}

mcv_result mcv_npz_array(const mcv_npz *npz, const char *name, const char *dtype,
                         const size_t shape[MCV_NPZ_DIMENSIONS], size_t *length,
                         const uint8_t **data, mcv_error *error) {
    char header[512], type[32];
    size_t bytes = 0, count = 1;
    const uint8_t *member = mcv_npz_bytes(npz, name, &bytes);
    if (!member) return mcv_fail(error, MCV_BAD_INPUT, "%s: has no array %s", npz->path, name);
    const size_t text = bytes < PREAMBLE ? 0 : get(member + 8, 2);
    if (bytes < PREAMBLE || memcmp(member, "\x93NUMPY\x01", 7) != 0 || text >= sizeof header ||
        bytes - PREAMBLE < text)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s is no NPY array of version 1", npz->path,
                        name);
    memcpy(header, member + PREAMBLE, text);
    header[text] = '\0';
    snprintf(type, sizeof type, "'descr': '%s'", dtype);
    const char *where = strstr(header, "'shape': ");
    if (!strstr(header, type) || !strstr(header, "'fortran_order': False") || !where ||
        !has_shape(where + strlen("'shape': "), shape, length))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: the array %s has another type or shape than this file's others ask "
                        "for",
                        npz->path, name);
    for (int i = 0; i < MCV_NPZ_DIMENSIONS && (i == 0 || shape[i] > 0); ++i) {
        const size_t side = shape[i] == SIZE_MAX ? *length : shape[i];
        if (side > 0 && count > SIZE_MAX / 16 / side)
            return damaged(npz, "an array is larger than the file", error);
        count *= side;
    }
    if (bytes - PREAMBLE - text != count * (size_t)(dtype[strlen(dtype) - 1] - '0'))
        return damaged(npz, "an array is longer or shorter than its shape", error);
    *data = member + PREAMBLE + text;
    return MCV_OK;
}

void mcv_npz_free(mcv_npz *npz) {
    free(npz->file);
    *npz = (mcv_npz){0};
}
