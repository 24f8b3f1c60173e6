/* SPDX-License-Identifier: Apache-2.0 */
/* Rigs of the public interface: made around a part, from a lens file, and written. */
#include "api/handles.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "verbs/import.h"
#include "verbs/new.h"

#include <libgen.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* --- around a part --- */

static mcv_result tell_of_new(const mcv_command *command, const mcv_rig_design *design,
                              char **report, mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_new_report(design, command->rig, &r);
    mcv_new_warn(design, &r);
    return mcv_report_take(&r, report, error);
}

/* Without a file, as if it lay beside the part. */
static mcv_result new_in_memory(const mcv_rig_design *design, mcv_rig **rig, mcv_error *error) {
    char name[PATH_MAX], folder[PATH_MAX], *text;
    size_t size;
    if (strlen(design->wishes.part) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the part is longer than %d bytes", PATH_MAX);
    strcpy(name, design->wishes.part);
    strcpy(folder, design->wishes.part);
    MCV_TRY(mcv_rig_text(design, basename(name), &text, &size, error));
    const mcv_result result = mcv_rig_parse(text, size, dirname(folder), rig, error);
    free(text);
    return result;
}

static mcv_result new_in_file(const mcv_command *command, const mcv_rig_design *design,
                              mcv_rig **rig, mcv_error *error) {
    MCV_TRY(mcv_rig_write(design, command->rig, command->force, error));
    return mcv_rig_open(command->rig, rig, error);
}

static mcv_result new_rig(const char *kind, const char *part, const char *options, mcv_rig **rig,
                          char **report, mcv_error *error) {
    const char *const arguments[2] = {kind, part};
    mcv_options_given given;
    mcv_rig_design design;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_NEW, arguments, NULL, &given, error));
    mcv_result result = mcv_new_design(&given.command, &design, error);
    if (result == MCV_OK)
        result = given.command.rig ? new_in_file(&given.command, &design, rig, error)
                                   : new_in_memory(&design, rig, error);
    if (result == MCV_OK) result = tell_of_new(&given.command, &design, report, error);
    mcv_options_free(&given);
    if (result == MCV_OK) return MCV_OK;
    mcv_rig_free(*rig);
    *rig = NULL;
    return result;
}

mcv_result mcv_rig_new(const char *kind, const char *part, const char *options, mcv_rig **rig,
                       char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(rig);
    *rig = NULL;
    if (report) *report = NULL;
    MCV_NEED(kind);
    MCV_NEED(part);
    MCV_INSIDE(result, new_rig(kind, part, options, rig, report, error));
    return result;
}

/* --- from a lens file --- */

/* As it is in the file of "output", or as if it lay beside the lens file. */
static mcv_result make_lens(const mcv_command *command, const char *text, mcv_rig **rig,
                            mcv_error *error) {
    char folder[PATH_MAX];
    if (command->lens) {
        MCV_TRY(mcv_output_whole(command->lens, text, strlen(text), error));
        return mcv_rig_open(command->lens, rig, error);
    }
    snprintf(folder, sizeof folder, "%s", command->argument);
    return mcv_rig_parse(text, strlen(text), dirname(folder), rig, error);
}

static mcv_result import_with(const mcv_command *command, mcv_rig **rig, char **report,
                              mcv_error *error) {
    mcv_lens_report lens;
    mcv_report r;
    char *text;
    if (strlen(command->argument) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the lens is longer than %d bytes", PATH_MAX);
    if (command->lens && mcv_same_file(command->lens, command->argument))
        return mcv_fail(error, MCV_USAGE, "%s is the lens file: give the lens another name",
                        command->lens);
    MCV_TRY(mcv_import(command, &text, &lens, error));
    const mcv_result result = make_lens(command, text, rig, error);
    free(text);
    if (result != MCV_OK || !report) return result;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_import_report(&lens, command->lens, &r);
    return mcv_report_take(&r, report, error);
}

static mcv_result import_lens(const char *lens, const char *options, mcv_rig **rig, char **report,
                              mcv_error *error) {
    const char *const arguments[2] = {lens};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_IMPORT, arguments, NULL, &given, error));
    const mcv_result result = import_with(&given.command, rig, report, error);
    mcv_options_free(&given);
    if (result == MCV_OK) return MCV_OK;
    mcv_rig_free(*rig);
    *rig = NULL;
    return result;
}

mcv_result mcv_rig_import(const char *lens, const char *options, mcv_rig **rig, char **report,
                          mcv_error *error) {
    mcv_result result;
    MCV_NEED(rig);
    *rig = NULL;
    if (report) *report = NULL;
    MCV_NEED(lens);
    MCV_INSIDE(result, import_lens(lens, options, rig, report, error));
    return result;
}

/* --- into a file --- */

/* Little-endian, as glTF has it. */
static void put_word(uint8_t *to, uint32_t word) {
    for (int i = 0; i < 4; ++i) to[i] = (uint8_t)(word >> 8 * i);
}

/* The chunks of a .glb: JSON padded by blanks, then the binary chunk padded by zeros. */
static mcv_result pack_glb(const char *text, mcv_bytes binary, mcv_bytes *glb, mcv_error *error) {
    enum { HEADER = 12, CHUNK = 8 };
    const size_t length = strlen(text), json = (length + 3) & ~(size_t)3,
                 data = (binary.size + 3) & ~(size_t)3,
                 size = HEADER + CHUNK + json + (binary.data ? CHUNK + data : 0);
    if (size > UINT32_MAX)
        return mcv_fail(error, MCV_FAILED, "the rig is larger than the 4 GiB of a .glb file");
    *glb = (mcv_bytes){calloc(1, size), size};
    if (!glb->data) return mcv_fail(error, MCV_FAILED, "no memory to write the rig");
    uint8_t *to = glb->data;
    put_word(to, 0x46546c67); /* glTF */
    put_word(to + 4, 2);
    put_word(to + 8, (uint32_t)size);
    put_word(to + 12, (uint32_t)json);
    put_word(to + 16, 0x4e4f534a); /* JSON */
    memset(to + 20, ' ', json);
    /* NOLINTNEXTLINE(bugprone-not-null-terminated-result): a chunk of a known length, no text */
    memcpy(to + 20, text, length);
    if (!binary.data) return MCV_OK;
    to += 20 + json;
    put_word(to, (uint32_t)data);
    put_word(to + 4, 0x004e4942); /* BIN */
    if (binary.size) memcpy(to + 8, binary.data, binary.size);
    return MCV_OK;
}

/* File names in the document are relative: elsewhere they would lead to other files. */
static mcv_result check_folder(const mcv_rig *rig, const char *path, mcv_error *error) {
    char copy[PATH_MAX], here[PATH_MAX], there[PATH_MAX];
    if (strlen(path) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the rig is longer than %d bytes", PATH_MAX);
    strcpy(copy, path);
    if (realpath(rig->folder, here) && realpath(dirname(copy), there) && strcmp(here, there) == 0)
        return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "%s: must lie in the folder %s, which file names in the rig are relative to",
                    path, rig->folder);
}

/* The file is the document from now on. */
static mcv_result move_rig(mcv_rig *rig, const char *path, const mcv_bytes *written,
                           mcv_error *error) {
    char *own = strdup(path), *of_document = strdup(path);
    if (!own || !of_document) {
        free(own);
        free(of_document);
        return mcv_fail(error, MCV_FAILED, "no memory for the rig");
    }
    free(rig->path);
    free(rig->document.path);
    rig->path = own;
    rig->document.path = of_document;
    for (size_t i = 0; i < rig->set_count; ++i) free(rig->set[i]);
    rig->set_count = 0;
    rig->hash = mcv_hash_bytes(MCV_HASH_BEGIN, written->data, written->size);
    return MCV_OK;
}

static mcv_result save_rig(mcv_rig *rig, const char *path, mcv_error *error) {
    const bool glb = mcv_ends_in(path, ".glb");
    if (!glb && !mcv_ends_in(path, ".gltf"))
        return mcv_fail(error, MCV_USAGE, "%s: the name of a rig must end in .gltf or .glb", path);
    if (!glb && rig->document.binary.data)
        return mcv_fail(error, MCV_USAGE,
                        "%s: the rig has binary data inside: its name must end in .glb", path);
    MCV_TRY(check_folder(rig, path, error));
    char *text = json_dumps(rig->document.root, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    mcv_bytes bytes = {(uint8_t *)text, strlen(text)};
    mcv_result result = glb ? pack_glb(text, rig->document.binary, &bytes, error) : MCV_OK;
    if (result == MCV_OK) result = mcv_output_whole(path, bytes.data, bytes.size, error);
    if (result == MCV_OK) result = move_rig(rig, path, &bytes, error);
    if (bytes.data != (uint8_t *)text) free(bytes.data);
    free(text);
    return result;
}

mcv_result mcv_rig_save(mcv_rig *rig, const char *path, mcv_error *error) {
    mcv_result result;
    MCV_NEED(rig);
    MCV_NEED(path);
    MCV_INSIDE(result, save_rig(rig, path, error));
    return result;
}
