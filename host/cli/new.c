/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi new: a rig around a part, with standard optics and a light, as a file to read and edit. */
#include "cli/tell.h"
#include "cli/verbs.h"
#include "verbs/new.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

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
}

mcv_result mcv_verb_new(const mcv_command *command, mcv_error *error) {
    char path[PATH_MAX];
    mcv_rig_design rig;
    mcv_report report;
    MCV_TRY(mcv_new_design(command, &rig, error));
    MCV_TRY(mcv_rig_write(&rig, command->rig, command->force, path, error));
    print_choice(&rig, path);
    mcv_report_begin(&report, false, mcv_tell);
    mcv_new_warn(&rig, &report);
    return MCV_OK;
}
