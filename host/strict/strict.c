/* SPDX-License-Identifier: Apache-2.0 */
#include "strict/strict_parts.h"

#include "core/basics.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As RFC 6901 writes it: ~ is ~0, / is ~1. */
static void write_pointer(FILE *out, const mcv_json_path *place) {
    if (!place->parent) return;
    write_pointer(out, place->parent);
    fputc('/', out);
    if (!place->key) fprintf(out, "%zu", place->index);
    for (const char *c = place->key; c && *c; ++c)
        if (*c == '~' || *c == '/')
            fputs(*c == '~' ? "~0" : "~1", out);
        else
            fputc(*c, out);
}

static char *pointer_of(const mcv_json_path *place) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    write_pointer(out, place);
    (void)mcv_text_close(out, &text);
    return text;
}

void mcv_strict_find(mcv_strict *s, const char *code, const mcv_json_path *place,
                     const char *format, ...) {
    enum { MOST = 10000 }; /* nobody reads more */
    mcv_strict_findings *f = s->findings;
    if (f->count >= MOST) return;
    char *pointer = pointer_of(place), *text = NULL, *whole = NULL;
    va_list arguments;
    va_start(arguments, format);
    if (vasprintf(&text, format, arguments) < 0) text = NULL;
    va_end(arguments);
    if (pointer && text &&
        asprintf(&whole, "%s %zu %s%s", code, strlen(pointer), pointer, text) < 0)
        whole = NULL;
    if (!s->told) s->told = json_object();
    const bool seen = whole && json_object_get(s->told, whole);
    mcv_strict_finding *items =
        seen || !whole ? NULL : realloc(f->items, (f->count + 1) * sizeof *items);
    if (items) f->items = items;
    if (items && json_object_set_new_nocheck(s->told, whole, json_true()) == 0) {
        f->items[f->count++] = (mcv_strict_finding){code, pointer, text};
        pointer = text = NULL;
    } else {
        s->no_memory = s->no_memory || !seen;
    }
    free(pointer);
    free(text);
    free(whole);
}

void mcv_strict_free(mcv_strict_findings *findings) {
    for (size_t i = 0; i < findings->count; ++i) {
        free(findings->items[i].pointer);
        free(findings->items[i].text);
    }
    free(findings->items);
    *findings = (mcv_strict_findings){0};
}

static uint32_t word_at(mcv_bytes file, size_t at) {
    const uint8_t *p = file.data + at;
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

enum { GLB_MAGIC = 0x46546c67, GLB_JSON = 0x4e4f534a, GLB_BINARY = 0x004e4942 };

/* The chunks of a GLB; what is wrong of them is told. */
static mcv_bytes check_chunks(mcv_strict *s, mcv_bytes file, uint32_t length) {
    mcv_bytes json = {NULL, 0};
    bool seen[2] = {false, false};
    size_t at = 12;
    for (size_t chunk = 0; at < file.size && at < length; ++chunk) {
        if (file.size - at < 8) {
            mcv_strict_find(s, "GLB_UNEXPECTED_END_OF_CHUNK_HEADER", &s->file,
                            "ends in the header of chunk %zu", chunk);
            return json;
        }
        const uint32_t size = word_at(file, at), type = word_at(file, at + 4);
        const int known = type == GLB_JSON ? 0 : type == GLB_BINARY ? 1 : -1;
        if (chunk == 0 && type != GLB_JSON)
            mcv_strict_find(s, "GLB_UNEXPECTED_FIRST_CHUNK", &s->file,
                            "the first chunk must be JSON");
        if (known >= 0 && seen[known])
            mcv_strict_find(s, "GLB_DUPLICATE_CHUNK", &s->file, "chunk %zu stands there twice",
                            chunk);
        if (size % 4 != 0)
            mcv_strict_find(s, "GLB_CHUNK_LENGTH_UNALIGNED", &s->file,
                            "chunk %zu must have a multiple of 4 bytes", chunk);
        if ((uint64_t)at + 8 + size > length)
            mcv_strict_find(s, "GLB_CHUNK_TOO_BIG", &s->file,
                            "chunk %zu is longer than the header says", chunk);
        at += 8;
        if (size > file.size - at) {
            mcv_strict_find(s, "GLB_UNEXPECTED_END_OF_CHUNK_DATA", &s->file, "ends in chunk %zu",
                            chunk);
            return json;
        }
        if (chunk == 0 && known == 0) json = (mcv_bytes){file.data + at, size};
        if (chunk == 1 && known == 1) s->binary = (mcv_bytes){file.data + at, size};
        if (known >= 0) seen[known] = true;
        at += size;
    }
    return json;
}

/* The JSON of a GLB, or data NULL where its frame is damaged. */
static mcv_bytes check_glb(mcv_strict *s, mcv_bytes file) {
    const mcv_bytes none = {NULL, 0};
    if (file.size >= 4 && word_at(file, 0) != GLB_MAGIC) {
        mcv_strict_find(s, "GLB_INVALID_MAGIC", &s->file, "does not begin as a GLB");
        return none;
    }
    if (file.size < 12) {
        mcv_strict_find(s, "GLB_UNEXPECTED_END_OF_HEADER", &s->file, "ends in its header");
        return none;
    }
    const uint32_t length = word_at(file, 8);
    if (word_at(file, 4) != 2)
        mcv_strict_find(s, "GLB_INVALID_VERSION", &s->file, "its version must be 2");
    mcv_bytes json = check_chunks(s, file, length);
    bool cut = false;
    for (size_t i = 0; i < s->findings->count; ++i)
        cut = cut || strstr(s->findings->items[i].code, "UNEXPECTED_END");
    if (length != file.size && !cut)
        mcv_strict_find(s, "GLB_LENGTH_MISMATCH", &s->file,
                        "its header says %u bytes, but there are %zu", length, file.size);
    return s->findings->count > 0 ? none : json;
}

static void check_root(mcv_strict *s, const json_t *root) {
    if (!json_is_object(root)) {
        mcv_strict_find(s, "TYPE_MISMATCH", &s->file, "must be a JSON object");
        return;
    }
    const size_t count = json_array_size(json_object_get(root, "buffers"));
    s->root = root;
    s->buffers = calloc(count + 1, sizeof *s->buffers);
    if (!s->buffers) {
        s->no_memory = true;
        return;
    }
    mcv_strict_walk(s);
    mcv_strict_data(s);
    mcv_strict_accessors(s);
    mcv_strict_nodes(s);
    mcv_strict_meshes(s);
    mcv_strict_animations(s);
    for (size_t i = 0; i < count; ++i) free(s->buffers[i].data);
    free(s->buffers);
}

static mcv_result finish(mcv_strict *s, mcv_error *error) {
    json_decref(s->told);
    if (!s->no_memory) return MCV_OK;
    mcv_strict_free(s->findings);
    return mcv_fail_memory(&s->file, error);
}

mcv_result mcv_strict_check_document(const char *path, const json_t *root, mcv_bytes binary,
                                     uint64_t most, mcv_strict_findings *findings,
                                     mcv_error *error) {
    mcv_strict s = {.findings = findings,
                    .file = mcv_place_file(path),
                    .is_glb = binary.data,
                    .binary = binary.size ? binary : (mcv_bytes){NULL, 0},
                    .left = most};
    *findings = (mcv_strict_findings){0};
    check_root(&s, root);
    return finish(&s, error);
}

static void check_json(mcv_strict *s, mcv_bytes json) {
    json_error_t wrong;
    json_t *root = mcv_json_parse((const char *)json.data, json.size,
                                  JSON_REJECT_DUPLICATES | JSON_ALLOW_NUL, &wrong);
    if (root)
        check_root(s, root);
    else if (!wrong.text[0])
        s->no_memory = true;
    else
        mcv_strict_find(s, "INVALID_JSON", &s->file, "line %d column %d is not JSON: %s",
                        wrong.line, wrong.column, mcv_json_wrong(&wrong));
    json_decref(root);
}

mcv_result mcv_strict_check(const char *path, uint64_t most, mcv_strict_findings *findings,
                            mcv_error *error) {
    mcv_strict s = {.findings = findings, .file = mcv_place_file(path), .left = most};
    mcv_bytes file, json;
    uint64_t size;
    *findings = (mcv_strict_findings){0};
    MCV_TRY(mcv_file_size(path, &size, &s.file, error));
    if (size > most)
        return mcv_fail_at(&s.file, error, "has %llu bytes, more than --memory allows",
                           (unsigned long long)size);
    MCV_TRY(mcv_file_read(path, &file, &s.file, error));
    s.left -= size;
    s.is_glb = mcv_ends_in(path, ".glb") || (file.size >= 4 && word_at(file, 0) == GLB_MAGIC);
    json = s.is_glb ? check_glb(&s, file) : file;
    if (json.data) check_json(&s, json);
    free(file.data);
    return finish(&s, error);
}
