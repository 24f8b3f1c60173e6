/* SPDX-License-Identifier: Apache-2.0 */
/*
 * STL: triangles without unit, normals or material. Binary: 80 bytes of header, the number of
 * triangles, 50 bytes for each. ASCII: facet, outer loop, three vertex lines. The file's normals
 * are ignored: the winding determines the front.
 */
#include "loader/loader.h"
#include "loader/load_stl.h"

#include "scene/mesh.h"

#include <locale.h>
#include <stdlib.h>

enum { HEADER = 84, RECORD = 50, VERTEX = 12 };

static uint32_t little_endian(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static float float_at(const uint8_t *p) {
    const uint32_t bits = little_endian(p);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Makes the indices: every three positions are a triangle. */
static mcv_result number_vertices(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error) {
    mesh->triangle_count = mesh->vertex_count / 3;
    mesh->indices = malloc((mesh->vertex_count + (size_t)1) * sizeof *mesh->indices);
    if (!mesh->indices) return mcv_fail_memory(place, error);
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) mesh->indices[i] = i;
    return MCV_OK;
}

/* --- binary --- */

static mcv_result read_binary(mcv_bytes bytes, mcv_mesh *mesh, const mcv_json_path *place,
                              mcv_error *error) {
    if (bytes.size < HEADER)
        return mcv_fail_at(place, error, "%zu bytes are too few for an STL file: its header has %d",
                           bytes.size, HEADER);
    const uint32_t count = little_endian(bytes.data + HEADER - 4);
    const uint64_t needed = HEADER + (uint64_t)count * RECORD;
    if (bytes.size != needed)
        return mcv_fail_at(
            place, error, "states %u triangles, which take %llu bytes, but has %zu: it is %s",
            count, (unsigned long long)needed, bytes.size,
            bytes.size < needed ? "truncated"
                                : "not a binary STL file, and it does not begin with `solid`");
    if (count > INT32_MAX / 3)
        return mcv_fail_at(place, error, "%u triangles are more than %d", count, INT32_MAX / 3);
    mesh->vertex_count = 3 * count;
    mesh->positions = malloc((9 * (size_t)count + 1) * sizeof *mesh->positions);
    if (!mesh->positions) return mcv_fail_memory(place, error);
    for (size_t t = 0; t < count; ++t)
        for (size_t i = 0; i < 9; ++i)
            mesh->positions[9 * t + i] =
                float_at(bytes.data + HEADER + t * RECORD + VERTEX + 4 * i);
    return MCV_OK;
}

/* --- ASCII --- */

/* A reader of words that counts lines. In every locale, numbers have a decimal point. */
typedef struct reader {
    const char *at, *end;
    unsigned line;
    locale_t locale;
    char word[64];
} reader;

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

static bool next_word(reader *r) {
    size_t length = 0;
    for (; r->at < r->end && is_blank(*r->at); ++r->at) r->line += *r->at == '\n';
    for (; r->at < r->end && !is_blank(*r->at); ++r->at)
        if (length < sizeof r->word - 1) r->word[length++] = *r->at;
    r->word[length] = '\0';
    return length > 0;
}

static void skip_line(reader *r) {
    while (r->at < r->end && *r->at != '\n') ++r->at;
}

static bool word_is(const reader *r, const char *word) { return strcasecmp(r->word, word) == 0; }

static mcv_result expect_word(reader *r, const char *word, const mcv_json_path *place,
                              mcv_error *error) {
    if (!next_word(r))
        return mcv_fail_at(place, error, "is truncated: it ends in line %u, where `%s` must be",
                           r->line, word);
    return word_is(r, word)
               ? MCV_OK
               : mcv_fail_at(place, error, "line %u: \"%s\" must be `%s`", r->line, r->word, word);
}

static mcv_result read_number(reader *r, float *value, const mcv_json_path *place,
                              mcv_error *error) {
    char *end;
    if (!next_word(r))
        return mcv_fail_at(place, error, "is truncated: it ends in line %u, where a number must be",
                           r->line);
    *value = (float)strtod_l(r->word, &end, r->locale);
    if (*end == '\0') return MCV_OK;
    if (*end == ',')
        return mcv_fail_at(place, error,
                           "line %u: \"%s\" has a decimal comma, as programs write it in some "
                           "languages: export with points, "
                           "or as a binary file",
                           r->line, r->word);
    return mcv_fail_at(place, error, "line %u: \"%s\" is not a number", r->line, r->word);
}

static mcv_result read_facet(reader *r, float corners[9], const mcv_json_path *place,
                             mcv_error *error) {
    float normal;
    MCV_TRY(expect_word(r, "normal", place, error));
    for (int i = 0; i < 3; ++i) MCV_TRY(read_number(r, &normal, place, error));
    MCV_TRY(expect_word(r, "outer", place, error));
    MCV_TRY(expect_word(r, "loop", place, error));
    for (int v = 0; v < 3; ++v) {
        MCV_TRY(expect_word(r, "vertex", place, error));
        for (int i = 0; i < 3; ++i) MCV_TRY(read_number(r, corners + 3 * v + i, place, error));
    }
    MCV_TRY(expect_word(r, "endloop", place, error));
    return expect_word(r, "endfacet", place, error);
}

/* solid NAME, facets, endsolid NAME; several solids are one part. */
static mcv_result read_solids(reader *r, mcv_mesh *mesh, const mcv_json_path *place,
                              mcv_error *error) {
    size_t room = 0;
    bool open = false;
    while (next_word(r)) {
        if (!open) {
            if (!word_is(r, "solid"))
                return mcv_fail_at(place, error, "line %u: \"%s\" must be `solid`", r->line,
                                   r->word);
            skip_line(r);
            open = true;
        } else if (word_is(r, "endsolid")) {
            skip_line(r);
            open = false;
        } else if (word_is(r, "facet")) {
            if (mesh->vertex_count + (size_t)3 > room) {
                room = 2 * room + 3072;
                float *positions = room > INT32_MAX
                                       ? NULL
                                       : realloc(mesh->positions, 3 * room * sizeof *positions);
                if (!positions) return mcv_fail_memory(place, error);
                mesh->positions = positions;
            }
            MCV_TRY(read_facet(r, mesh->positions + 3 * (size_t)mesh->vertex_count, place, error));
            mesh->vertex_count += 3;
        } else {
            return mcv_fail_at(place, error, "line %u: \"%s\" must be `facet` or `endsolid`",
                               r->line, r->word);
        }
    }
    return open ? mcv_fail_at(place, error, "is truncated: it ends in line %u without `endsolid`",
                              r->line)
                : MCV_OK;
}

static mcv_result read_ascii(mcv_bytes bytes, mcv_mesh *mesh, const mcv_json_path *place,
                             mcv_error *error) {
    reader r = {
        .at = (const char *)bytes.data, .end = (const char *)bytes.data + bytes.size, .line = 1};
    r.locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!r.locale) return mcv_fail_memory(place, error);
    const mcv_result result = read_solids(&r, mesh, place, error);
    freelocale(r.locale);
    return result;
}

/* --- both --- */

/* Binary files may begin with `solid` too; where they have their count, ASCII has no byte 0. */
static bool is_ascii(mcv_bytes bytes) {
    static const char solid[] = "solid";
    if (bytes.size < sizeof solid - 1 ||
        strncasecmp((const char *)bytes.data, solid, sizeof solid - 1) != 0)
        return false;
    if (bytes.size >= HEADER &&
        bytes.size == HEADER + (uint64_t)little_endian(bytes.data + HEADER - 4) * RECORD)
        return false;
    return !memchr(bytes.data, 0, bytes.size < 512 ? bytes.size : 512);
}

static mcv_result read_mesh(mcv_bytes bytes, mcv_mesh *mesh, const mcv_json_path *place,
                            mcv_error *error) {
    uint32_t repaired;
    if (bytes.size == 0) return mcv_fail_at(place, error, "is empty");
    MCV_TRY(is_ascii(bytes) ? read_ascii(bytes, mesh, place, error)
                            : read_binary(bytes, mesh, place, error));
    if (mesh->vertex_count == 0) return mcv_fail_at(place, error, "holds no triangle");
    MCV_TRY(number_vertices(mesh, place, error));
    return mcv_mesh_check(mesh, &repaired, place, error);
}

mcv_result mcv_load_stl(mcv_scene *scene, mcv_bytes bytes, const char *name, uint32_t *mesh,
                        double size[3], const mcv_json_path *place, mcv_error *error) {
    mcv_mesh loaded = {.name = strdup(name)};
    const mcv_result result =
        loaded.name ? read_mesh(bytes, &loaded, place, error) : mcv_fail_memory(place, error);
    if (result != MCV_OK) {
        mcv_mesh_free(&loaded);
        return result;
    }
    for (size_t i = 0; i < 3; ++i) {
        float low = INFINITY, high = -INFINITY; /* comparisons: a call of fmin for each would take
                                                   longer than all else here */
        for (size_t v = 0; v < loaded.vertex_count; ++v) {
            const float here = loaded.positions[3 * v + i];
            low = here < low ? here : low;
            high = here > high ? here : high;
        }
        size[i] = (double)high - low;
    }
    *mesh = scene->mesh_count;
    return mcv_scene_take_mesh(scene, &loaded, error);
}
