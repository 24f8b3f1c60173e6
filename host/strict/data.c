/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers, images and textures: their URIs, their lengths, and what kind of image they hold. */
#include "strict/strict_parts.h"

#include "loader/data_uri.h"
#include "loader/image.h"

#include <stdlib.h>
#include <string.h>

static const char *const image_types[] = {"image/png", "image/jpeg", "image/webp", "image/ktx2",
                                          NULL};

static const char *uri_of(const json_t *object) {
    return json_string_value(json_object_get(object, "uri"));
}

/* The bytes of a URI. data is NULL where it is wrong, which is told, or where they are too many. */
static mcv_bytes read_uri(mcv_strict *s, const char *uri, const char *const *types,
                          const mcv_json_path *place) {
    mcv_bytes bytes = {NULL, 0};
    mcv_error error;
    uint64_t size = 0;
    char *path = NULL;
    const bool is_data = strncmp(uri, "data:", 5) == 0;
    if (is_data ? mcv_data_uri_length(uri, types, &size, place, &error) != MCV_OK
                : mcv_file_resolve(s->file.key, uri, &path, place, &error) != MCV_OK) {
        mcv_strict_find(s, "INVALID_URI", place, "\"%.40s\" is none that can be read", uri);
        return bytes;
    }
    if (!is_data && mcv_file_size(path, &size, place, &error) != MCV_OK)
        mcv_strict_find(s, "IO_ERROR", place, "\"%.200s\" cannot be read", uri);
    if (size > 0 && size <= s->left) bytes = (mcv_bytes){malloc(size), size};
    if (bytes.data) {
        s->left -= size;
        if (is_data) {
            mcv_data_uri_decode(uri, 0, size, bytes.data);
        } else if (mcv_file_read_part(path, 0, size, bytes.data, place, &error) != MCV_OK) {
            free(bytes.data);
            bytes = (mcv_bytes){NULL, 0};
        }
    }
    free(path);
    return bytes;
}

static void read_buffer(mcv_strict *s, const json_t *buffer, size_t index,
                        const mcv_json_path *place) {
    const char *uri = uri_of(buffer);
    const uint64_t length = mcv_strict_uint(buffer, "byteLength", 0);
    const mcv_json_path here = mcv_json_path_key(place, "uri");
    mcv_bytes *bytes = &s->buffers[index];
    if (uri) {
        *bytes = read_uri(s, uri, mcv_buffer_types, &here);
    } else if (s->is_glb && index == 0) {
        if (!s->binary.data)
            mcv_strict_find(s, "BUFFER_MISSING_GLB_DATA", place, "the GLB has no binary chunk");
        else if ((bytes->data = malloc(s->binary.size ? s->binary.size : 1))) {
            memcpy(bytes->data, s->binary.data, s->binary.size);
            bytes->size = s->binary.size;
        }
    }
    if (bytes->data && bytes->size < length) {
        mcv_strict_find(s, "BUFFER_BYTE_LENGTH_MISMATCH", place,
                        "byteLength is %llu, but there are %zu bytes", (unsigned long long)length,
                        bytes->size);
        free(bytes->data);
        *bytes = (mcv_bytes){NULL, 0};
    }
}

/* The media type by the first bytes, or NULL. */
static const char *recognized(mcv_bytes bytes) {
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const unsigned char ktx[12] = {0xab, 'K',  'T',  'X',  ' ',  '2',
                                          '0',  0xbb, '\r', '\n', 0x1a, '\n'};
    if (bytes.size >= 8 && memcmp(bytes.data, png, 8) == 0) return "image/png";
    if (bytes.size >= 3 && memcmp(bytes.data, "\xff\xd8\xff", 3) == 0) return "image/jpeg";
    if (bytes.size >= 12 && memcmp(bytes.data, "RIFF", 4) == 0 &&
        memcmp(bytes.data + 8, "WEBP", 4) == 0)
        return "image/webp";
    return bytes.size >= 12 && memcmp(bytes.data, ktx, 12) == 0 ? "image/ktx2" : NULL;
}

/* The type that the image says or has; NULL if it cannot be known. */
static const char *type_of_image(mcv_strict *s, const json_t *image, bool tell,
                                 const mcv_json_path *place) {
    const char *uri = uri_of(image),
               *declared = json_string_value(json_object_get(image, "mimeType")), *found = NULL;
    const json_t *view = mcv_strict_target(s, image, "bufferView", "bufferViews");
    const mcv_json_path here = mcv_json_path_key(place, uri ? "uri" : "bufferView");
    mcv_bytes bytes = {NULL, 0};
    if (uri) {
        bytes = read_uri(s, uri, image_types, &here);
        s->left += bytes.size;
    } else if (view) {
        const uint64_t buffer = mcv_strict_uint(view, "buffer", UINT64_MAX),
                       offset = mcv_strict_uint(view, "byteOffset", 0),
                       length = mcv_strict_uint(view, "byteLength", 0);
        if (buffer < json_array_size(mcv_strict_list(s, "buffers")) && s->buffers[buffer].data &&
            offset <= s->buffers[buffer].size && length <= s->buffers[buffer].size - offset)
            bytes = (mcv_bytes){s->buffers[buffer].data + offset, length};
    }
    if (bytes.data) found = recognized(bytes);
    if (tell && found && declared && strcmp(found, declared) != 0)
        mcv_strict_find(s, "IMAGE_MIME_TYPE_INVALID", &here, "is %s, but mimeType says %.40s",
                        found, declared);
    mcv_error ignored;
    uint32_t width, height;
    const bool is_read =
        found && (strcmp(found, "image/png") == 0 || strcmp(found, "image/jpeg") == 0);
    if (tell && is_read && mcv_image_size(bytes, &width, &height, place, &ignored) != MCV_OK)
        mcv_strict_find(s, "IMAGE_DATA_INVALID", place, "its header is damaged");
    if (uri) free(bytes.data);
    return declared ? declared : found;
}

static void check_image(mcv_strict *s, const json_t *image, const mcv_json_path *place) {
    const bool uri = json_object_get(image, "uri"), view = json_object_get(image, "bufferView");
    const mcv_json_path here = mcv_json_path_key(place, "bufferView");
    if (uri == view)
        mcv_strict_find(s, "ONE_OF_MISMATCH", place, "must have one of uri and bufferView");
    if (view && !json_object_get(image, "mimeType"))
        mcv_strict_find(s, "UNSATISFIED_DEPENDENCY", &here, "needs a mimeType");
    type_of_image(s, image, true, place);
}

static void check_source(mcv_strict *s, const json_t *object, const char *types,
                         const mcv_json_path *place) {
    const json_t *image = mcv_strict_target(s, object, "source", "images");
    const mcv_json_path here = mcv_json_path_key(place, "source");
    const char *type = image ? type_of_image(s, image, false, place) : NULL;
    if (type && !strstr(types, type))
        mcv_strict_find(s, "TEXTURE_INVALID_IMAGE_MIME_TYPE", &here, "%.40s must be %s", type,
                        types);
}

static void check_texture(mcv_strict *s, const json_t *texture, const mcv_json_path *place) {
    const mcv_json_path all = mcv_json_path_key(place, "extensions"),
                        webp = mcv_json_path_key(&all, "EXT_texture_webp"),
                        basis = mcv_json_path_key(&all, "KHR_texture_basisu");
    check_source(s, texture, "image/png or image/jpeg", place);
    check_source(s, mcv_json_extension(texture, "EXT_texture_webp"), "image/webp", &webp);
    check_source(s, mcv_json_extension(texture, "KHR_texture_basisu"), "image/ktx2", &basis);
}

static void check_light(mcv_strict *s, const json_t *light, const mcv_json_path *place) {
    const char *type = json_string_value(json_object_get(light, "type"));
    if (type && strcmp(type, "spot") == 0 && !json_object_get(light, "spot"))
        mcv_strict_find(s, "UNDEFINED_PROPERTY", place, "a spot must have \"spot\"");
}

static void check_material(mcv_strict *s, const json_t *material, const mcv_json_path *place) {
    const mcv_json_path all = mcv_json_path_key(place, "extensions"),
                        here = mcv_json_path_key(&all, "KHR_materials_ior"),
                        there = mcv_json_path_key(&here, "ior");
    const json_t *ior = json_object_get(mcv_json_extension(material, "KHR_materials_ior"), "ior");
    const double n = json_number_value(ior);
    if (json_is_number(ior) && n > 0 && n < 1)
        mcv_strict_find(s, "VALUE_NOT_IN_RANGE", &there, "%g must be 0, or at least 1", n);
}

typedef void check_one(mcv_strict *s, const json_t *object, const mcv_json_path *place);

static void check_each(mcv_strict *s, const char *list, const mcv_json_path *place,
                       check_one *check) {
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, list)); ++i) {
        const json_t *item = mcv_strict_item(s, list, i);
        const mcv_json_path here = mcv_place_index(place, i);
        if (item) check(s, item, &here);
    }
}

/* "2.0": two numbers with a point; false where the text is none. */
static bool read_version(const char *text, unsigned *major, unsigned *minor) {
    int end = -1;
    // NOLINTNEXTLINE(cert-err34-c): five digits always fit
    return sscanf(text, "%5u.%5u%n", major, minor, &end) == 2 && end == (int)strlen(text) &&
           strspn(text, "0123456789.") == strlen(text);
}

static void check_asset(mcv_strict *s) {
    const json_t *asset = json_object_get(s->root, "asset");
    const mcv_json_path place = mcv_json_path_key(&s->file, "asset");
    static const char *const keys[] = {"version", "minVersion"};
    unsigned number[2][2] = {{2, 0}, {0, 0}};
    for (int i = 0; i < 2; ++i) {
        const char *text = json_string_value(json_object_get(asset, keys[i]));
        const mcv_json_path here = mcv_json_path_key(&place, keys[i]);
        if (!text) continue;
        if (!read_version(text, number[i], number[i] + 1))
            mcv_strict_find(s, "PATTERN_MISMATCH", &here, "\"%.40s\" must be like 2.0", text);
        else if (i == 0 && number[0][0] != 2)
            mcv_strict_find(s, "UNKNOWN_ASSET_MAJOR_VERSION", &here, "%.40s must be 2.x", text);
        else if (i == 1 && (number[1][0] > number[0][0] ||
                            (number[1][0] == number[0][0] && number[1][1] > number[0][1])))
            mcv_strict_find(s, "ASSET_MIN_VERSION_GREATER_THAN_VERSION", &here,
                            "%.40s must not be above the version", text);
    }
}

void mcv_strict_data(mcv_strict *s) {
    const mcv_json_path buffers = mcv_json_path_key(&s->file, "buffers"),
                        images = mcv_json_path_key(&s->file, "images"),
                        textures = mcv_json_path_key(&s->file, "textures"),
                        materials = mcv_json_path_key(&s->file, "materials"),
                        all = mcv_json_path_key(&s->file, "extensions"),
                        khr = mcv_json_path_key(&all, "KHR_lights_punctual"),
                        lights = mcv_json_path_key(&khr, "lights");
    check_asset(s);
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "buffers")); ++i) {
        const json_t *buffer = mcv_strict_item(s, "buffers", i);
        const mcv_json_path here = mcv_place_index(&buffers, i);
        if (buffer) read_buffer(s, buffer, i, &here);
    }
    check_each(s, "images", &images, check_image);
    check_each(s, "textures", &textures, check_texture);
    check_each(s, "materials", &materials, check_material);
    check_each(s, "extensions/KHR_lights_punctual/lights", &lights, check_light);
}
