/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/transport.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "core/json.h"
#include "io/exr.h"
#include "io/values.h"
#include "scene/texture.h"

/* --- images of patterns --- */

/* Bytes of a PNG file as a scene reads them. */
static mcv_result decode_bytes(const char *path, mcv_image *image, mcv_error *error) {
    const size_t count = (size_t)image->width * image->height * image->channels;
    for (size_t i = 0; i < count; ++i) {
        if (image->pixels[i] > 255)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: has 16 bits: give a pattern with 8, or .exr or .npy with linear "
                            "values",
                            path);
        image->pixels[i] = (float)mcv_srgb_decode((uint8_t)image->pixels[i]);
    }
    return MCV_OK;
}

/* The first part of an OpenEXR file. */
static mcv_result take_first(const char *path, mcv_image *image, mcv_error *error) {
    mcv_exr exr = {0};
    const mcv_result result = mcv_exr_read(path, &exr, error);
    if (result == MCV_OK) {
        *image = exr.parts[0].image;
        exr.parts[0].image = (mcv_image){.channels = image->channels}; /* as many as names */
    }
    mcv_exr_free(&exr);
    return result;
}

mcv_result mcv_pattern_image_read(const char *path, mcv_image *image, mcv_error *error) {
    *image = (mcv_image){0};
    if (mcv_ends_in(path, ".exr")) return take_first(path, image, error);
    if (!mcv_ends_in(path, ".npy") && !mcv_ends_in(path, ".png"))
        return mcv_fail(error, MCV_USAGE, "--pattern %s: must be an image .exr, .npy or .png",
                        path);
    MCV_TRY(mcv_values_read(path, image, error));
    if (!mcv_ends_in(path, ".png")) return MCV_OK;
    const mcv_result result = decode_bytes(path, image, error);
    if (result != MCV_OK) mcv_image_free(image);
    return result;
}

/* --- which emitter --- */

/* The names of all emitters, or of those with pixels: "a", "b". */
static void list_emitters(const mcv_matrix *m, bool with_pixels, char *text, size_t size) {
    size_t length = 0;
    text[0] = '\0';
    for (uint32_t i = 0; i < m->group_count && length < size; ++i)
        if (!with_pixels || m->groups[i].width * m->groups[i].height > 1)
            length += (size_t)snprintf(text + length, size - length, "%s\"%s\"",
                                       length > 0 ? ", " : "", m->groups[i].emitter);
}

mcv_result mcv_pattern_group(const mcv_matrix *m, const char *option, const char *item,
                             const mcv_element_group **group, const char **shown,
                             mcv_error *error) {
    const char *equals = strchr(item, '=');
    char names[512], name[256];
    uint32_t with_pixels = 0;
    *group = NULL;
    *shown = equals ? equals + 1 : item;
    list_emitters(m, true, names, sizeof names);
    if (equals) {
        snprintf(name, sizeof name, "%.*s", (int)(equals - item), item);
        *group = mcv_matrix_group(m, name);
    }
    for (uint32_t i = 0; i < m->group_count && !equals; ++i)
        if (m->groups[i].width * m->groups[i].height > 1) {
            *group = m->groups + i;
            ++with_pixels;
        }
    if (with_pixels > 1)
        return mcv_fail(error, MCV_USAGE, "--%s %s: which emitter shows it? One of %s", option,
                        item, names);
    if (*group && (*group)->width * (*group)->height > 1) return MCV_OK;
    return mcv_fail(error, MCV_USAGE, "--%s %s: the matrix has pixels of %s", option, item,
                    names[0] ? names : "no emitter");
}

static mcv_result show_image(const mcv_matrix *m, const char *item, float *pattern,
                             mcv_error *error) {
    const mcv_element_group *group;
    const char *path;
    mcv_image image;
    MCV_TRY(mcv_pattern_group(m, "pattern", item, &group, &path, error));
    MCV_TRY(mcv_pattern_image_read(path, &image, error));
    const size_t plane = (size_t)image.width * image.height;
    mcv_result result = MCV_OK;
    if (image.width != group->width || image.height != group->height)
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: has %u x %u pixels, the image of emitter \"%s\" %u x %u", path,
                          image.width, image.height, group->emitter, group->width, group->height);
    for (size_t i = 0; result == MCV_OK && i < plane; ++i) {
        float *to = pattern + ((size_t)group->first + i) * m->channels;
        double sum = 0;
        for (uint32_t c = 0; c < image.channels; ++c) {
            const float value = image.pixels[c * plane + i];
            if (!isfinite(value) || value < 0)
                result = mcv_fail(error, MCV_BAD_INPUT,
                                  "%s: the value in row %zu, column %zu is %g: must be finite and "
                                  "not negative",
                                  path, i / image.width, i % image.width, (double)value);
            sum += (double)value;
        }
        for (uint32_t c = 0; c < m->channels; ++c)
            to[c] = m->channels == image.channels ? image.pixels[c * plane + i]
                                                  : (float)(sum / image.channels);
    }
    mcv_image_free(&image);
    return result;
}

/* --- other brightness --- */

/* One number or three, of emitters/NAME/radiance=VALUE. */
static bool read_brightness(const char *text, double value[3]) {
    json_error_t wrong;
    json_t *json = json_loads(text, JSON_DECODE_ANY, &wrong);
    bool right = json_is_number(json) || (json_is_array(json) && json_array_size(json) == 3);
    for (size_t k = 0; right && k < 3; ++k) {
        const json_t *number = json_is_array(json) ? json_array_get(json, k) : json;
        right = json_is_number(number) && json_number_value(number) >= 0;
        value[k] = json_number_value(number);
    }
    json_decref(json);
    return right;
}

static mcv_result set_brightness(const mcv_matrix *m, const char *item, float *pattern,
                                 mcv_error *error) {
    char name[256], key[32], names[512];
    double value[3];
    int end = 0;
    if (sscanf(item, "emitters/%255[^/]/%31[^=]=%n", name, key, &end) != 2 || end == 0 ||
        (strcmp(key, "radiance") != 0 && strcmp(key, "irradiance") != 0 &&
         strcmp(key, "intensity") != 0))
        return mcv_fail(error, MCV_USAGE,
                        "--set %s: a matrix holds for the brightness of emitters alone: "
                        "emitters/NAME/radiance=L, irradiance=E or intensity=I",
                        item);
    const mcv_element_group *group = mcv_matrix_group(m, name);
    list_emitters(m, false, names, sizeof names);
    if (!group)
        return mcv_fail(error, MCV_USAGE, "--set %s: the matrix has the emitters %s", item, names);
    if (!read_brightness(item + end, value))
        return mcv_fail(error, MCV_USAGE,
                        "--set %s: must be one number, or three as [R,G,B], of 0 or more", item);
    for (uint32_t i = 0; i < group->width * group->height; ++i)
        for (uint32_t c = 0; c < m->channels; ++c) {
            if (!(group->radiance[c] > 0))
                return mcv_fail(error, MCV_BAD_INPUT,
                                "--set %s: the emitter is dark in the matrix: render the matrix "
                                "with light from it",
                                item);
            pattern[((size_t)group->first + i) * m->channels + c] *=
                (float)(value[c] / group->radiance[c]);
        }
    return MCV_OK;
}

mcv_result mcv_pattern_read(const mcv_command *command, const mcv_matrix *matrix, float **pattern,
                            mcv_error *error) {
    const size_t bytes = (size_t)matrix->element_count * matrix->channels * sizeof **pattern;
    mcv_result result = MCV_OK;
    *pattern = malloc(bytes + 1);
    if (!*pattern) return mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    memcpy(*pattern, matrix->pattern, bytes);
    for (size_t i = 0; result == MCV_OK && i < command->patterns.count; ++i)
        result = show_image(matrix, command->patterns.items[i], *pattern, error);
    for (size_t i = 0; result == MCV_OK && i < command->set.count; ++i)
        result = set_brightness(matrix, command->set.items[i], *pattern, error);
    if (result == MCV_OK) return MCV_OK;
    free(*pattern);
    *pattern = NULL;
    return result;
}

/* --- what is told --- */

void mcv_matrix_report(const mcv_matrix *m, mcv_report *r) {
    const uint64_t entries = m->row_begins[m->row_count];
    mcv_report_numbers(r, "resolution", "", " x ", (const double[]){m->width, m->height}, 2);
    mcv_report_number(r, "channels", "", m->channels);
    mcv_report_number(r, "replicates", "", m->replicates);
    mcv_report_number(r, "samples", "", (double)m->samples * m->replicates);
    mcv_report_number(r, "columns", "", m->column_count);
    mcv_report_number(r, "entries", "", (double)entries);
    mcv_report_number(r, "entries_per_row", "", (double)entries / (double)m->row_count);
    if (m->kept < 1) mcv_report_number(r, "kept", "", m->kept);
    mcv_report_list(r, "elements");
    for (uint32_t i = 0; i < m->group_count; ++i) {
        const mcv_element_group *g = m->groups + i;
        mcv_report_element(r, g->emitter, g->type);
        mcv_report_number(r, "first", "", g->first);
        mcv_report_numbers(r, "size", "", " x ", (const double[]){g->width, g->height}, 2);
        mcv_report_close(r);
    }
    mcv_report_close(r);
}
