/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/new.h"

#include "core/basics.h"
#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* "--NAME 12mm"; an option that is not given stays 0. */
static mcv_result read_length(const char *name, const char *text, double *value, mcv_error *error) {
    if (!text || (mcv_parse_quantity(text, MCV_PARAM_length, value) && *value > 0)) return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "--%s %s: must be a length above 0, as in 25mm (nm, um, mm, cm, m, inch)", name,
                    text);
}

static mcv_result read_wishes(const mcv_command *command, mcv_rig_wishes *wishes,
                              mcv_error *error) {
    *wishes =
        (mcv_rig_wishes){.kind = -1,
                         .light = (int)command->light,
                         .part = command->second,
                         .unit = command->unit,
                         .material = command->material,
                         .view = command->view,
                         .resolution = {(uint32_t)command->film[0], (uint32_t)command->film[1]},
                         .magnification = command->magnification,
                         .f_number = command->f_number};
    for (int i = 0; i < MCV_RIG_KIND_COUNT; ++i)
        if (strcmp(command->argument, mcv_rig_kinds[i]) == 0) wishes->kind = i;
    if (wishes->kind < 0)
        return mcv_fail(error, MCV_USAGE,
                        "new %s: must be `new telecentric`, `new entocentric`, `new lightfield`, "
                        "`new transparent` or `new laser`, and then the part",
                        command->argument);
    MCV_TRY(read_length("pixel-size", command->pixel_size, &wishes->pixel_size, error));
    MCV_TRY(read_length("focal-length", command->focal_length, &wishes->focal_length, error));
    MCV_TRY(read_length("working-distance", command->working_distance, &wishes->working_distance,
                        error));
    return read_length("field-of-view", command->field_of_view, &wishes->field_of_view, error);
}

mcv_result mcv_new_design(const mcv_command *command, mcv_rig_design *rig, mcv_error *error) {
    mcv_rig_wishes wishes;
    MCV_TRY(read_wishes(command, &wishes, error));
    return mcv_rig_choose(&wishes, rig, error);
}

static const char *length(double metres) { return mcv_rig_length(metres, 4); }

void mcv_new_warn(const mcv_rig_design *r, mcv_report *report) {
    char text[512];
    for (int i = 0; i < 2; ++i) {
        if (r->across[i] <= r->field[i] * (1 + 1e-9)) continue;
        if (i == 1 && r->wishes.kind == MCV_RIG_LASER) continue; /* it is scanned that way */
        snprintf(text, sizeof text,
                 "the part, %s x %s, is larger than the field of view, %s x %s, %s",
                 length(r->across[0]), length(r->across[1]), length(r->field[0]),
                 length(r->field[1]), i ? "in height" : "in width");
        mcv_report_tell(report, "warning", text);
    }
    if (r->magnification >= 1e-3 && r->magnification <= 100) return;
    snprintf(text, sizeof text, "%.256s: a magnification of %.3g is unusual: is the unit %s right?",
             r->wishes.part, r->magnification, r->wishes.unit ? r->wishes.unit : "m");
    mcv_report_tell(report, "warning", text);
}

static void print_light(FILE *out, const mcv_rig_light *light) {
    fprintf(out, "  light           %s, ", mcv_rig_lights[light->type]);
    if (light->type == MCV_RIG_LIGHT_LASER)
        fprintf(out, "line %s thick, ", length(light->size[0]));
    else if (light->type == MCV_RIG_LIGHT_BACKLIGHT || light->type == MCV_RIG_LIGHT_COAXIAL)
        fprintf(out, "%s x %s, ", length(light->size[0]), length(light->size[1]));
    else
        fprintf(out, "inner diameter %s, outer diameter %s, ", length(light->inner),
                length(light->outer));
    if (light->half_angle > 0) fprintf(out, "half-angle %.4g°, ", light->half_angle);
    fprintf(out, "%s %s the part's middle\n", length(light->distance),
            light->type == MCV_RIG_LIGHT_BACKLIGHT ? "behind" : "before");
}

static void print_choice(FILE *out, const mcv_rig_design *r, const char *path) {
    mcv_print_line(out, path ? path : mcv_rig_kinds[r->wishes.kind]);
    fprintf(out, "\n  part            %s x %s x %s, %u triangles\n", length(r->across[0]),
            length(r->across[1]), length(r->depth), r->triangles);
    if (r->wishes.kind == MCV_RIG_TELECENTRIC)
        fprintf(out,
                "  lens            telecentric, magnification %.4g, f/%g, working distance %s\n",
                r->magnification, r->f_number, length(r->working_distance));
    else
        fprintf(out, "  lens            %s f/%g (working), focused at %s\n",
                length(r->focal_length), r->f_number, length(r->working_distance));
    fprintf(out, "  field of view   %s x %s\n", length(r->field[0]), length(r->field[1]));
    print_light(out, &r->light);
}

void mcv_new_report(const mcv_rig_design *r, const char *path, mcv_report *report) {
    const mcv_rig_light *light = &r->light;
    if (!report->json) {
        print_choice(report->out, r, path);
        return;
    }
    mcv_report_text(report, "kind", mcv_rig_kinds[r->wishes.kind]);
    mcv_report_numbers(report, "size", "m", " x ",
                       (const double[]){r->across[0], r->across[1], r->depth}, 3);
    mcv_report_number(report, "triangles", "", r->triangles);
    mcv_report_number(report, "magnification", "", r->magnification);
    if (r->wishes.kind != MCV_RIG_TELECENTRIC)
        mcv_report_number(report, "focal_length", "m", r->focal_length);
    mcv_report_number(report, "f_number", "", r->f_number);
    mcv_report_number(report, "working_distance", "m", r->working_distance);
    mcv_report_numbers(report, "field_of_view", "m", " x ", r->field, 2);
    mcv_report_open(report, "light");
    mcv_report_text(report, "type", mcv_rig_lights[light->type]);
    mcv_report_number(report, "distance", "m", light->distance);
    if (light->type == MCV_RIG_LIGHT_LASER) {
        mcv_report_number(report, "line_thickness", "m", light->size[0]);
    } else if (light->inner > 0 || light->outer > 0) {
        mcv_report_number(report, "inner_diameter", "m", light->inner);
        mcv_report_number(report, "outer_diameter", "m", light->outer);
    } else {
        mcv_report_numbers(report, "size", "m", " x ", light->size, 2);
    }
    if (light->half_angle > 0)
        mcv_report_number(report, "half_angle", "rad", light->half_angle * (M_PI / 180));
    mcv_report_close(report);
}
