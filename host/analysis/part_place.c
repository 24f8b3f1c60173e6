/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/part_place.h"

#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LENGTHS = 5 };

/* X, Y, Z, W, H up to the end of the place. NULL where they are no such list, else where it ends.
 */
static const char *read_lengths(const char *text, double lengths[LENGTHS]) {
    for (int i = 0; i < LENGTHS; ++i) {
        char one[64];
        const size_t sign = strspn(text, " +-"), size = sign + strcspn(text + sign, ",+");
        if (size >= sizeof one) return NULL;
        memcpy(one, text, size);
        one[size] = '\0';
        if (!mcv_parse_quantity(one + strspn(one, " "), MCV_PARAM_length, lengths + i)) return NULL;
        text += size;
        if (i < LENGTHS - 1 && *text++ != ',') return NULL;
    }
    return *text == '\0' || *text == '+' ? text : NULL;
}

/* Whether one of the lengths is a number other than 0 without a unit. */
static bool has_bare_number(const char *text, const char *end) {
    while (text < end) {
        char *rest;
        const double value = strtod(text, &rest);
        if (value != 0 && (rest == end || *rest == ',')) return true;
        text = rest + strcspn(rest, ",") + 1;
    }
    return false;
}

/* Pixels of the rectangle about a point of the world. */
static mcv_result project(const char *what, const char *text, const mcv_camera_model *model,
                          const double world[3], const double size[2], bool unitless, long box[4],
                          mcv_error *error) {
    double pixel[2], per_metre[2];
    if (!mcv_camera_model_project(model, world, pixel))
        return mcv_fail(error, MCV_USAGE, "%s %s: lies behind the camera", what, text);
    mcv_camera_model_scale(model, mcv_camera_model_depth(model, world), per_metre);
    for (int i = 0; i < 2; ++i) {
        const double pixels = fmax(1, rint(size[i] * per_metre[i])),
                     first = rint(pixel[i] - pixels / 2);
        if (!(first >= 0 && first + pixels <= model->size[i]))
            return mcv_fail(error, MCV_USAGE,
                            "%s %s: its middle lies at column %.1f, row %.1f, and it reaches from "
                            "%s %.0f to %.0f: the image has %u x %u "
                            "pixels%s",
                            what, text, pixel[0], pixel[1], i == 0 ? "column" : "row", first,
                            first + pixels, model->size[0], model->size[1],
                            unitless ? "; a length without a unit is in metres" : "");
        box[i] = (long)first;
        box[i + 2] = (long)pixels;
    }
    return MCV_OK;
}

/* One place, from behind its '@'; *end is where it ends. */
static mcv_result resolve_place(const char *what, const char *text, const char *place,
                                const mcv_camera_model *model, long box[4], const char **end,
                                mcv_error *error) {
    const char *colon = strchr(place, ':');
    double lengths[LENGTHS], world[3];
    const mcv_placement *node;
    const char *ends = colon ? read_lengths(colon + 1, lengths) : NULL;
    if (!ends || !(lengths[3] > 0 && lengths[4] > 0))
        return mcv_fail(error, MCV_USAGE,
                        "%s %s: must be [NAME=]@NODE:X,Y,Z,W,H, lengths with units, as in "
                        "left=@part:-20mm,0mm,3mm,2mm,4mm",
                        what, text);
    if (!model)
        return mcv_fail(
            error, MCV_USAGE,
            "%s %s: the image's header does not state where the node lies: give --scene, or "
            "pixels X,Y,W,H",
            what, text);
    char where[256];
    snprintf(where, sizeof where, "%s %s", what, text);
    MCV_TRY(mcv_camera_model_check_places(model, where, error));
    char *name = strndup(place, (size_t)(colon - place));
    if (!name) return mcv_fail(error, MCV_FAILED, "%s %s: no memory for its node", what, text);
    const mcv_result found = mcv_camera_model_node(model, name, where, &node, error);
    free(name);
    MCV_TRY(found);
    mcv_transform_point(&node->to_world, lengths, world);
    *end = ends;
    return project(what, text, model, world, lengths + 3, has_bare_number(colon + 1, ends), box,
                   error);
}

mcv_result mcv_part_place_resolve(const char *what, const char *text, const mcv_camera_model *model,
                                  char **out, mcv_error *error) {
    size_t size = 0;
    const char *from = text;
    mcv_result result = MCV_OK;
    *out = NULL;
    FILE *stream = open_memstream(out, &size);
    if (!stream) return mcv_fail(error, MCV_FAILED, "%s %s: no memory for it", what, text);
    for (const char *at; result == MCV_OK && (at = strchr(from, '@'));) {
        long box[4] = {0};
        fprintf(stream, "%.*s", (int)(at - from), from);
        result = resolve_place(what, text, at + 1, model, box, &from, error);
        if (result == MCV_OK) fprintf(stream, "%ld,%ld,%ld,%ld", box[0], box[1], box[2], box[3]);
    }
    if (result == MCV_OK) fputs(from, stream);
    fclose(stream);
    if (result == MCV_OK && *out) return MCV_OK;
    free(*out);
    *out = NULL;
    return result == MCV_OK ? mcv_fail(error, MCV_FAILED, "%s %s: no memory for it", what, text)
                            : result;
}
