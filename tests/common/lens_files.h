/* SPDX-License-Identifier: Apache-2.0 */
/* Lens files written, read and compared by tests. */
#ifndef MCVISI_TESTS_LENS_FILES_H
#define MCVISI_TESTS_LENS_FILES_H

#include "scene_builder.h"

#include "lens/lens_file.h"
#include "loader/load.h"

typedef struct lens_read {
    json_t *document;
    mcv_lens_report report;
} lens_read;

static inline void write_bytes(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline lens_read read_lens_as(const char *path, const char *text, mcv_lens_shape shape) {
    lens_read lens;
    const mcv_lens_options options = {NULL, 0, shape};
    write_bytes(path, text, strlen(text));
    BUILD(mcv_lens_file_read(path, &options, &lens.document, &lens.report, &builder_error));
    remove(path);
    return lens;
}

static inline lens_read read_lens(const char *path, const char *text) {
    return read_lens_as(path, text, MCV_LENS_SHAPE_AUTO);
}

/* The document as the renderer understands it; it is released. */
static inline mcv_scene *load_lens(lens_read *lens) {
    mcv_scene *scene;
    assert_int_equal(json_dump_file(lens->document, "lens_files.gltf", 0), 0);
    json_decref(lens->document);
    BUILD(mcv_scene_load("lens_files.gltf", (mcv_overrides){NULL, 0}, &scene, &builder_error));
    remove("lens_files.gltf");
    return scene;
}

static inline bool warns(const lens_read *lens, const char *of) {
    for (int i = 0; i < lens->report.warning_count; ++i)
        if (strstr(lens->report.warnings[i], of)) return true;
    return false;
}

static inline void refuse_lens(const char *path, const char *text, const char *word) {
    lens_read lens;
    write_bytes(path, text, strlen(text));
    const mcv_result result = mcv_lens_file_read(path, &(mcv_lens_options){0}, &lens.document,
                                                 &lens.report, &builder_error);
    if (result == MCV_OK) fail_msg("%s is read, but should be refused by \"%s\"", path, word);
    if (result != MCV_BAD_INPUT || !strstr(builder_error.text, word) ||
        !strstr(builder_error.text, path))
        fail_msg("\"%s\" should say \"%s\"", builder_error.text, word);
    remove(path);
}

/* Whether two documents hold the same, names aside and numbers within `tolerance` of each other. */
static inline bool same_document(const json_t *a, const json_t *b, double tolerance) {
    const char *key;
    json_t *value;
    if (json_is_number(a) && json_is_number(b))
        return fabs(json_number_value(a) - json_number_value(b)) <=
               tolerance * fabs(json_number_value(b));
    if (json_typeof(a) != json_typeof(b)) return false;
    if (json_is_array(a)) {
        for (size_t i = 0; i < json_array_size(a); ++i)
            if (!same_document(json_array_get(a, i), json_array_get(b, i), tolerance)) return false;
        return json_array_size(a) == json_array_size(b);
    }
    if (!json_is_object(a)) return json_equal(a, b) != 0;
    json_object_foreach((json_t *)a, key, value) {
        if (strcmp(key, "name") == 0) continue;
        if (!json_object_get(b, key) || !same_document(value, json_object_get(b, key), tolerance))
            return false;
    }
    return json_object_size(a) == json_object_size(b);
}

static inline void assert_within(double got, double expected, double tolerance, const char *what) {
    if (!(fabs(got - expected) <= tolerance * fabs(expected)))
        fail_msg("%s: %.12g, not %.12g", what, got, expected);
}

#endif
