/* SPDX-License-Identifier: Apache-2.0 */
/* Scene files that tests write into the build directory, and load. Include behind cmocka.h. */
#ifndef MCVISI_TESTS_SCENE_FILES_H
#define MCVISI_TESTS_SCENE_FILES_H

#include "scene/scene.h"
#include "loader/load.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* printf into a string that the caller frees. */
__attribute__((format(printf, 1, 2))) static inline char *text_of(const char *format, ...) {
    char *text = NULL;
    va_list arguments;
    va_start(arguments, format);
    const int length = vasprintf(&text, format, arguments);
    va_end(arguments);
    if (length < 0) abort();
    return text;
}

/* A file of this name in the build directory; the caller frees the path. */
static inline char *write_bytes(const char *name, const void *bytes, size_t size) {
    char *path = text_of("%s/tests/%s", MCV_BINARY_DIR, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) {
        perror(path);
        abort();
    }
    return path;
}

static inline char *base64(const void *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *p = bytes;
    char *text = malloc(4 * ((size + 2) / 3) + 1), *out = text;
    if (!text) abort();
    for (size_t i = 0; i < size; i += 3) {
        const unsigned group =
            p[i] << 16 | (i + 1 < size ? p[i + 1] << 8 : 0) | (i + 2 < size ? p[i + 2] : 0);
        for (int k = 0; k < 4; ++k)
            *out++ = i + (size_t)k > size ? '=' : digits[group >> (18 - 6 * k) & 63];
    }
    *out = '\0';
    return text;
}

/* A GLB of a JSON text and an optional binary chunk. */
static inline unsigned char *glb_of(const char *json, const void *binary, size_t binary_size,
                                    size_t *size) {
    const size_t json_size = (strlen(json) + 3) / 4 * 4, chunk_size = (binary_size + 3) / 4 * 4;
    *size = 20 + json_size + (binary ? 8 + chunk_size : 0);
    unsigned char *glb = calloc(1, *size);
    if (!glb) abort();
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)*size, (uint32_t)json_size, 0x4e4f534a};
    const uint32_t chunk[2] = {(uint32_t)chunk_size, 0x004e4942};
    memcpy(glb, head, sizeof head); /* little-endian hosts only, as the tests run on */
    memset(glb + 20, ' ', json_size);
    /* NOLINTNEXTLINE(bugprone-not-null-terminated-result): a chunk of a known length, no text */
    memcpy(glb + 20, json, strlen(json));
    if (binary) {
        memcpy(glb + 20 + json_size, chunk, sizeof chunk);
        memcpy(glb + 28 + json_size, binary, binary_size);
    }
    return glb;
}

static inline mcv_result load_file(const char *path, mcv_scene **scene, mcv_error *error) {
    error->text[0] = '\0';
    return mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, error);
}

/* Loads a text as a .gltf, with up to one --set. */
static inline mcv_result load_text(const char *name, const char *text, const char *set,
                                   mcv_scene **scene, mcv_error *error) {
    char *path = write_bytes(name, text, strlen(text));
    error->text[0] = '\0';
    const mcv_result result =
        mcv_scene_load(path, (mcv_overrides){&set, set ? 1 : 0}, scene, error);
    free(path);
    return result;
}

/* A scene file of this name and text must be refused, with one sentence that names the file and
 * says this. */
static inline void must_refuse(const char *name, const char *text, const char *says) {
    mcv_scene *scene = (mcv_scene *)1;
    mcv_error error;
    const mcv_result result = load_text(name, text, NULL, &scene, &error);
    if (result != MCV_BAD_INPUT || scene)
        fail_msg("%s\n  gave %d, must be refused with \"%s\"", text, result, says);
    const char *named = strstr(error.text, name);
    if (!named || strncmp(named + strlen(name), ": ", 2) != 0 || !strstr(error.text, says))
        fail_msg("%s\n  \"%s\"\n  must name the file and say \"%s\"", text, error.text, says);
    if (strchr(error.text, '\n')) fail_msg("\"%s\" must be one line", error.text);
}

#endif
