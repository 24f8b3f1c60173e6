/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/calibrate.h"

#include "core/json.h"
#include "core/output_file.h"
#include "scene/params.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- the target --- */

/* A flat target: the plane across an axis of a node, at a distance from its origin. */
typedef struct target {
    char node[256];
    int axis;
    double distance; /* [m] */
} target;

static mcv_result read_target(const char *text, target *t, mcv_error *error) {
    const char *colon = strrchr(text, ':');
    const size_t length = colon ? (size_t)(colon - text) : 0;
    const bool named = length > 0 && length < sizeof t->node;
    const bool on_axis = named && colon[1] >= 'x' && colon[1] <= 'z' && colon[2] == '=';
    if (!on_axis || !mcv_parse_quantity(colon + 3, MCV_PARAM_length, &t->distance))
        return mcv_fail(error, MCV_USAGE,
                        "--target %s: must be NODE:AXIS=D, the plane of the target, as in "
                        "plate:z=3mm",
                        text);
    memcpy(t->node, text, length);
    t->node[length] = '\0';
    t->axis = colon[1] - 'x';
    return MCV_OK;
}

mcv_result mcv_light_plane_begin(const mcv_command *c, mcv_profiles *p, mcv_error *error) {
    target ignored;
    if (!c->calibrate != !c->target)
        return mcv_fail(error, MCV_USAGE,
                        "--calibrate F.json and --target NODE:AXIS=D belong together: the images "
                        "show a flat target, and the light's plane is written");
    if (c->calibrate && (c->calibration || c->profiles.count > 0))
        return mcv_fail(error, MCV_USAGE,
                        "--calibrate makes a calibration: use it by --calibration in a call of "
                        "its own");
    if (c->calibrate) {
        MCV_TRY(read_target(c->target, &ignored, error));
        return mcv_output_check(c->calibrate, error);
    }
    if (!c->calibration) return MCV_OK;
    if (!c->laser)
        return mcv_fail(error, MCV_USAGE,
                        "--calibration is of heights: give --laser NODE, whose axes they have");
    uint8_t *bytes;
    size_t size;
    json_error_t wrong;
    json_t *object = NULL;
    double values[2][3];
    MCV_TRY(mcv_file_load(c->calibration, &bytes, &size, error));
    json_t *document = mcv_json_parse((const char *)bytes, size, 0, &wrong);
    free(bytes);
    if (!document)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", c->calibration, mcv_json_wrong(&wrong));
    const mcv_json_path file = mcv_place_file(c->calibration),
                        place = mcv_json_path_key(&file, "lightPlane");
    static const char *const keys[2] = {"point", "normal"};
    mcv_result result = mcv_json_object(document, "lightPlane", &object, &file, error);
    for (int i = 0; result == MCV_OK && i < 2; ++i) {
        values[i][0] = NAN;
        if (object)
            result = mcv_json_numbers(object, keys[i], 3, -1e6, 1e6, values[i], &place, error);
    }
    json_decref(document);
    MCV_TRY(result);
    memcpy(p->plane.point, values[0], sizeof values[0]);
    if (isnan(values[0][0]) || isnan(values[1][0]) || !mcv_normalize3(values[1], p->plane.normal))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is no calibration: it has no lightPlane with a point and a normal, "
                        "as `mcvisi triangulate --calibrate` writes it",
                        c->calibration);
    return MCV_OK;
}

/* --- points --- */

mcv_result mcv_light_plane_add(mcv_profiles *p, const mcv_subject *s, mcv_error *error) {
    const mcv_command *c = p->command;
    const bool rows = c->line_across != 0;
    const mcv_profile_point *points = p->points + (size_t)(p->added - 1) * p->length;
    mcv_transform node;
    target t;
    double point[3], normal[3];
    MCV_TRY(read_target(c->target, &t, error));
    MCV_TRY(mcv_subject_node(s, t.node, "--target", &node, error));
    for (int i = 0; i < 3; ++i) {
        normal[i] = node.m[3 * i + t.axis];
        point[i] = node.m[9 + i] + t.distance * normal[i];
    }
    double(*grown)[3] = realloc(p->lit, (p->lit_count + p->length) * sizeof *p->lit);
    if (!grown) return mcv_fail(error, MCV_FAILED, "no memory for the points of a calibration");
    p->lit = grown;
    for (uint32_t i = 0; i < p->length; ++i) {
        const double across = points[i].line.place,
                     place[2] = {rows ? across : i + 0.5, rows ? i + 0.5 : across};
        if (points[i].line.state != MCV_LINE_SEEN) continue;
        if (mcv_target_place(&s->model, point, normal, place, p->lit[p->lit_count])) ++p->lit_count;
    }
    return MCV_OK;
}

/* --- the file --- */

static json_t *numbers(const double values[3]) {
    return json_pack("[f, f, f]", values[0], values[1], values[2]);
}

mcv_result mcv_light_plane_write(mcv_profiles *p, mcv_error *error) {
    const char *path = p->command->calibrate;
    if (!path) return MCV_OK;
    if (!mcv_light_plane_fit((const double(*)[3])p->lit, p->lit_count, &p->plane))
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "--calibrate: %zu places of the target are lit, which are too few, or leave one "
            "line by less than a hundredth of its length: give images with the target "
            "at two heights or more, further apart",
            p->lit_count);
    json_t *document = json_pack("{s:s, s:{s:o?, s:o?}, s:I, s:I, s:f}", "coordinates",
                                 "the camera's: x right, y down, z forward [m]", "lightPlane",
                                 "point", numbers(p->plane.point), "normal",
                                 numbers(p->plane.normal), "images", (json_int_t)p->added, "points",
                                 (json_int_t)p->lit_count, "residual", p->plane.residual);
    char *text = document ? json_dumps(document, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for %s", path);
    const mcv_result result = mcv_output_whole(path, text, strlen(text), error);
    free(text);
    return result;
}

void mcv_light_plane_report(const mcv_profiles *p, mcv_report *report) {
    if (!p->command->calibrate) return;
    mcv_report_open(report, "calibration");
    mcv_report_number(report, "points", "", (double)p->lit_count);
    mcv_report_number(report, "residual", "m", p->plane.residual);
    mcv_report_numbers(report, "spread", "m", " x ", p->plane.spread, 2);
    mcv_report_close(report);
}
