/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi new: a rig around a part, with standard optics and a light, written for people to read and
 * edit. */
#include "cli/command.h"
#include "rig/rig.h"
#include "scene/params.h"

#include <limits.h>
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
                        "new %s: must be `new telecentric`, `new entocentric`, `new lightfield` or "
                        "`new transparent`, and then the part",
                        command->argument);
    MCV_TRY(read_length("pixel-size", command->pixel_size, &wishes->pixel_size, error));
    MCV_TRY(read_length("focal-length", command->focal_length, &wishes->focal_length, error));
    MCV_TRY(read_length("working-distance", command->working_distance, &wishes->working_distance,
                        error));
    return read_length("field-of-view", command->field_of_view, &wishes->field_of_view, error);
}

static const char *length(double metres) { return mcv_rig_length(metres, 4); }

static void print_light(const mcv_rig_light *light) {
    printf("  light           %s, ", mcv_rig_lights[light->type]);
    if (light->type == MCV_RIG_LIGHT_BACKLIGHT || light->type == MCV_RIG_LIGHT_COAXIAL)
        printf("%s x %s, ", length(light->size[0]), length(light->size[1]));
    else
        printf("inner diameter %s, outer diameter %s, ", length(light->inner),
               length(light->outer));
    if (light->half_angle > 0) printf("half-angle %.4g°, ", light->half_angle);
    printf("%s %s the part's middle\n", length(light->distance),
           light->type == MCV_RIG_LIGHT_BACKLIGHT ? "behind" : "before");
}

static void print_choice(const mcv_rig_design *r, const char *path) {
    printf("%s\n  part            %s x %s x %s, %u triangles\n", path, length(r->across[0]),
           length(r->across[1]), length(r->depth), r->triangles);
    if (r->wishes.kind == MCV_RIG_TELECENTRIC)
        printf("  lens            telecentric, magnification %.4g, f/%g, working distance %s\n",
               r->magnification, r->f_number, length(r->working_distance));
    else
        printf("  lens            %s f/%g (working), focused at %s\n", length(r->focal_length),
               r->f_number, length(r->working_distance));
    printf("  field of view   %s x %s\n", length(r->field[0]), length(r->field[1]));
    print_light(&r->light);
    for (int i = 0; i < 2; ++i)
        if (r->across[i] > r->field[i] * (1 + 1e-9))
            fprintf(stderr,
                    "mcvisi: warning: the part, %s x %s, reaches out of the field of view, %s x "
                    "%s, %s\n",
                    length(r->across[0]), length(r->across[1]), length(r->field[0]),
                    length(r->field[1]), i ? "in height" : "in width");
    if (r->magnification < 1e-3 || r->magnification > 100)
        fprintf(stderr,
                "mcvisi: warning: %s: a magnification of %.3g is unusual: is --unit right, which "
                "is %s?\n",
                r->wishes.part, r->magnification, r->wishes.unit ? r->wishes.unit : "m by default");
}

mcv_result mcv_verb_new(const mcv_command *command, mcv_error *error) {
    char path[PATH_MAX];
    mcv_rig_wishes wishes;
    mcv_rig_design rig;
    MCV_TRY(read_wishes(command, &wishes, error));
    MCV_TRY(mcv_rig_choose(&wishes, &rig, error));
    MCV_TRY(mcv_rig_write(&rig, command->rig, command->force, path, error));
    print_choice(&rig, path);
    return MCV_OK;
}
