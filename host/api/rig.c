/* SPDX-License-Identifier: Apache-2.0 */
/* Rigs of the public interface: documents that are read, changed and written. */
#include "api/handles.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "loader/overrides.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mcv_result fail_no_memory(mcv_error *error) {
    return mcv_fail(error, MCV_FAILED, "no memory for the rig");
}

static void free_rig(mcv_rig *rig) {
    mcv_document_free(&rig->document);
    for (size_t i = 0; i < rig->set_count; ++i) free(rig->set[i]);
    free(rig->set);
    free(rig->path);
    free(rig->folder);
    free(rig);
}

mcv_result mcv_rig_of(mcv_document *document, const char *path, const char *folder, mcv_rig **rig,
                      mcv_error *error) {
    mcv_rig *r = calloc(1, sizeof *r);
    if (!r) {
        mcv_document_free(document);
        fail_no_memory(error);
        return MCV_FAILED;
    }
    r->document = *document;
    r->path = strdup(path);
    r->folder = strdup(folder);
    if (!r->path || !r->folder) {
        free_rig(r);
        fail_no_memory(error);
        return MCV_FAILED;
    }
    *rig = r;
    return MCV_OK;
}

mcv_overrides mcv_rig_changes(const mcv_rig *rig) {
    return (mcv_overrides){(const char *const *)rig->set, rig->set_count};
}

/* --- where from --- */

static mcv_result open_rig(const char *path, mcv_rig **rig, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    mcv_document document;
    const double begun = mcv_seconds();
    char *copy = strdup(path);
    if (!copy) return fail_no_memory(error);
    mcv_result result = mcv_document_read(path, &document, error);
    if (result == MCV_OK) result = mcv_rig_of(&document, path, dirname(copy), rig, error);
    free(copy);
    MCV_TRY(result);
    result = mcv_file_load(path, &bytes, &size, error);
    if (result == MCV_OK) {
        (*rig)->hash = mcv_hash_bytes(MCV_HASH_BEGIN, bytes, size);
        (*rig)->seconds = mcv_seconds() - begun;
        free(bytes);
        return MCV_OK;
    }
    free_rig(*rig);
    *rig = NULL;
    return result;
}

mcv_result mcv_rig_open(const char *path, mcv_rig **rig, mcv_error *error) {
    mcv_result result;
    MCV_NEED(rig);
    *rig = NULL;
    MCV_NEED(path);
    MCV_INSIDE(result, open_rig(path, rig, error));
    return result;
}

static mcv_result parse_rig(const char *json, size_t size, const char *folder, mcv_rig **rig,
                            mcv_error *error) {
    mcv_document document;
    char path[PATH_MAX];
    /* No such file needs to be there: it stands for the document in messages and paths. */
    if (snprintf(path, sizeof path, "%s/(rig)", folder) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the folder is longer than %d bytes",
                        PATH_MAX);
    MCV_TRY(mcv_document_parse(path, json, size, &document, error));
    MCV_TRY(mcv_rig_of(&document, "", folder, rig, error));
    (*rig)->hash = mcv_hash_bytes(MCV_HASH_BEGIN, json, size);
    return MCV_OK;
}

mcv_result mcv_rig_parse(const char *json, size_t size, const char *folder, mcv_rig **rig,
                         mcv_error *error) {
    mcv_result result;
    MCV_NEED(rig);
    *rig = NULL;
    MCV_NEED(json);
    MCV_INSIDE(result, parse_rig(json, size, folder && folder[0] ? folder : ".", rig, error));
    return result;
}

static mcv_result copy_rig(const mcv_rig *rig, mcv_rig **copy, mcv_error *error) {
    mcv_document document;
    MCV_TRY(mcv_document_copy(&rig->document, &document, error));
    MCV_TRY(mcv_rig_of(&document, rig->path, rig->folder, copy, error));
    mcv_rig *r = *copy;
    r->hash = rig->hash;
    r->set = calloc(rig->set_count + 1, sizeof *r->set);
    bool whole = r->set;
    for (; whole && r->set_count < rig->set_count; ++r->set_count) {
        r->set[r->set_count] = strdup(rig->set[r->set_count]);
        whole = r->set[r->set_count];
    }
    if (whole) return MCV_OK;
    free_rig(r);
    *copy = NULL;
    return fail_no_memory(error);
}

mcv_result mcv_rig_copy(const mcv_rig *rig, mcv_rig **copy, mcv_error *error) {
    mcv_result result;
    MCV_NEED(copy);
    *copy = NULL;
    MCV_NEED(rig);
    MCV_INSIDE(result, copy_rig(rig, copy, error));
    return result;
}

void mcv_rig_free(mcv_rig *rig) {
    if (rig) free_rig(rig);
}

const char *mcv_rig_path(const mcv_rig *rig) { return rig->path; }
const char *mcv_rig_folder(const mcv_rig *rig) { return rig->folder; }

/* --- what is in it --- */

/* Remembers what was set, of each path the last. */
static mcv_result note_setting(mcv_rig *rig, char *item, size_t path_length, mcv_error *error) {
    for (size_t i = 0; i < rig->set_count; ++i) {
        if (strncmp(rig->set[i], item, path_length + 1) != 0) continue;
        free(rig->set[i]);
        rig->set[i] = item;
        return MCV_OK;
    }
    char **set = realloc(rig->set, (rig->set_count + 1) * sizeof *set);
    if (!set) {
        free(item);
        return fail_no_memory(error);
    }
    rig->set = set;
    set[rig->set_count++] = item;
    return MCV_OK;
}

/* On a copy of the tree: a path that leads nowhere leaves the rig as it was. */
static mcv_result set_in_rig(mcv_rig *rig, const char *path, const char *value, mcv_error *error) {
    const mcv_json_path place = mcv_place_file(rig->document.path);
    char *item;
    if (!path[0] || strchr(path, '='))
        return mcv_fail(error, MCV_USAGE, "\"%s\": must be a path, as in sensors/cam/fNumber",
                        path);
    json_t *root = json_deep_copy(rig->document.root);
    if (!root || asprintf(&item, "%s=%s", path, value) < 0) {
        json_decref(root);
        return fail_no_memory(error);
    }
    const char *const items[] = {item};
    mcv_result result = mcv_overrides_apply((mcv_overrides){items, 1}, root, &place, error);
    if (result == MCV_OK) {
        result = note_setting(rig, item, strlen(path), error);
    } else {
        free(item);
    }
    if (result != MCV_OK) {
        json_decref(root);
        return result;
    }
    json_decref(rig->document.root);
    rig->document.root = root;
    rig->document.fingerprint = mcv_hash_bytes(rig->document.fingerprint, path, strlen(path) + 1);
    rig->document.fingerprint = mcv_hash_bytes(rig->document.fingerprint, value, strlen(value) + 1);
    return MCV_OK;
}

mcv_result mcv_rig_set(mcv_rig *rig, const char *path, const char *value, mcv_error *error) {
    mcv_result result;
    MCV_NEED(rig);
    MCV_NEED(path);
    MCV_NEED(value);
    MCV_INSIDE(result, set_in_rig(rig, path, value, error));
    return result;
}

/* Headers, pages and experiments name the scene by this until it is saved: its file is another. */
static const char changed[] = " (changed)";

/* The rig is another scene from now on: of this tree, which changes owners. */
static void take_root(mcv_rig *rig, json_t *root) {
    char *path = NULL;
    if (rig->path[0] && !mcv_ends_in(rig->document.path, changed) &&
        asprintf(&path, "%s%s", rig->document.path, changed) > 0) {
        free(rig->document.path);
        rig->document.path = path;
    }
    char *text = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(rig->document.root);
    rig->document.root = root;
    if (!text) return;
    rig->hash = mcv_hash_bytes(rig->hash, text, strlen(text));
    rig->document.fingerprint = mcv_hash_bytes(rig->document.fingerprint, text, strlen(text));
    free(text);
}

mcv_result mcv_rig_change(mcv_rig *rig, const mcv_command *command, mcv_rig_edit *edit,
                          char **report, mcv_error *error) {
    mcv_report r;
    json_t *root = json_deep_copy(rig->document.root);
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK && !root) result = mcv_fail(error, MCV_FAILED, "no memory for the rig");
    if (result == MCV_OK) result = edit(rig, command, root, &r, error);
    if (result == MCV_OK && report)
        result = mcv_report_take(&r, report, error);
    else
        mcv_report_free(&r);
    if (result == MCV_OK)
        take_root(rig, root);
    else
        json_decref(root);
    return result;
}

static mcv_result get_from_rig(const mcv_rig *rig, const char *path, char **json,
                               mcv_error *error) {
    const mcv_json_path place = mcv_place_file(rig->document.path);
    json_t *root = json_deep_copy(rig->document.root);
    const json_t *found = root;
    if (!root) return fail_no_memory(error);
    const mcv_result result =
        path[0] ? mcv_overrides_find(path, root, &place, &found, error) : MCV_OK;
    if (result == MCV_OK)
        *json = json_dumps(found, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(root);
    MCV_TRY(result);
    return *json ? MCV_OK : fail_no_memory(error);
}

mcv_result mcv_rig_get(const mcv_rig *rig, const char *path, char **json, mcv_error *error) {
    mcv_result result;
    MCV_NEED(json);
    *json = NULL;
    MCV_NEED(rig);
    MCV_NEED(path);
    MCV_INSIDE(result, get_from_rig(rig, path, json, error));
    return result;
}

static mcv_result list_paths(const mcv_rig *rig, char **json, mcv_error *error) {
    json_t *list = mcv_overrides_paths(rig->document.root);
    *json = list ? json_dumps(list, JSON_COMPACT) : NULL;
    json_decref(list);
    return *json ? MCV_OK : fail_no_memory(error);
}

mcv_result mcv_rig_paths(const mcv_rig *rig, char **json, mcv_error *error) {
    mcv_result result;
    MCV_NEED(json);
    *json = NULL;
    MCV_NEED(rig);
    MCV_INSIDE(result, list_paths(rig, json, error));
    return result;
}
