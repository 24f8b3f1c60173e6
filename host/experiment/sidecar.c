/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/sidecar.h"

#include "core/json.h"
#include "core/output_file.h"

#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static json_t *describe(const mcv_sidecar *s) {
    char file[PATH_MAX], folder[PATH_MAX], copy[PATH_MAX];
    json_t *document = json_object();
    const char *rig = realpath(s->rig, file) ? file : s->rig;
    snprintf(copy, sizeof copy, "%s", s->table);
    /* In or below the table's folder the relative path is enough. */
    if (rig == file && realpath(dirname(copy), folder)) {
        const size_t length = strlen(folder);
        if (strncmp(file, folder, length) == 0 && file[length] == '/') rig = file + length + 1;
    }
    mcv_json_put(&document, "rig", json_string(rig));
    mcv_json_put(&document, "fingerprint", json_string(s->fingerprint));
    if (!document || !s->settings || json_object_update(document, s->settings) == 0)
        return document;
    json_decref(document);
    return NULL;
}

mcv_result mcv_sidecar_is_free(const char *path, mcv_error *error) {
    json_t *document;
    mcv_error ignored;
    if (access(path, F_OK) != 0) return MCV_OK;
    const bool own = mcv_json_file_read(path, &document, &ignored) == MCV_OK &&
                     json_is_string(json_object_get(document, "fingerprint"));
    json_decref(document);
    return own ? MCV_OK
               : mcv_fail(error, MCV_BAD_INPUT,
                          "%s exists already, and was not written beside a table: replace it by "
                          "--force, or give another name by -o",
                          path);
}

mcv_result mcv_sidecar_write(const mcv_sidecar *s, mcv_error *error) {
    json_t *document = describe(s);
    char *text = json_dumps(document, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: the experiment must be UTF-8 text", s->path);
    const size_t size = strlen(text);
    const mcv_result result =
        size > MCV_JSON_FILE_MOST
            ? mcv_fail(error, MCV_BAD_INPUT,
                       "%s: the experiment would take %zu bytes, more than the limit of 4 MB for "
                       "such a file: give fewer values, or a shorter note",
                       s->path, size)
            : mcv_output_whole(s->path, text, size, error);
    free(text);
    return result;
}

/* `before` holds the contents of the file, NULL if it cannot be read. */
/* What only the page tells may change; the scene is compared by its fingerprint. */
static bool is_free(const char *key) {
    static const char *const keys[] = {"rig", "title", "note", "best"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i)
        if (strcmp(key, keys[i]) == 0) return true;
    return false;
}

static mcv_result compare(const mcv_sidecar *s, const json_t *before, const json_t *now,
                          mcv_error *error) {
    const char *key, *hash = json_string_value(json_object_get(before, "fingerprint"));
    const json_t *value;
    if (!hash || strcmp(hash, s->fingerprint) != 0)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s or a file that it names has changed since %s was begun: start another table by -o",
            s->rig, s->table);
    json_object_foreach((json_t *)now, key, value) {
        if (!is_free(key) && !json_equal(value, json_object_get(before, key)))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "--%s differs from that of %s (%s): start another table by -o", key,
                            s->table, s->path);
    }
    json_object_foreach((json_t *)before, key, value) {
        if (!is_free(key) && !json_object_get(now, key))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "--%s is missing, but %s has it (%s): start another table by -o", key,
                            s->table, s->path);
    }
    return MCV_OK;
}

mcv_result mcv_sidecar_check(const mcv_sidecar *s, mcv_error *error) {
    json_t *before, *now;
    mcv_error why;
    if (mcv_json_file_read(s->path, &before, &why) != MCV_OK)
        return mcv_fail(error, MCV_BAD_INPUT, "%s; without it %s cannot be resumed", why.text,
                        s->table);
    now = describe(s);
    const mcv_result result = compare(s, before, now, error);
    json_decref(before);
    json_decref(now);
    return result;
}
