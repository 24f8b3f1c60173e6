/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/bound.h"

#include "experiment/set_image.h"
#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* By what the text may be: a plain number has no unit. */
static const char *unit_of(const char *step) {
    double ignored;
    if (mcv_parse_quantity(step, MCV_PARAM_number, &ignored)) return "";
    if (mcv_parse_quantity(step, MCV_PARAM_length, &ignored)) return "m";
    return mcv_parse_quantity(step, MCV_PARAM_angle, &ignored) ? "rad" : "";
}

mcv_result mcv_bound_read(const char *item, const mcv_plan *plan, const mcv_document *document,
                          mcv_overrides set, mcv_bound *b, mcv_error *error) {
    const char *equals = strrchr(item, '=');
    char path[256];
    mcv_error why = {""};
    *b = (mcv_bound){.item = item, .path_length = equals ? (int)(equals - item) : 0};
    if (!equals || b->path_length == 0 || b->path_length >= (int)sizeof path ||
        !mcv_parse_quantity(equals + 1, MCV_PARAM_choice, &b->step) || !(b->step > 0))
        return mcv_fail(error, MCV_USAGE,
                        "--bound %s: must be PATH=STEP, a parameter of the scene and a small step "
                        "above 0, as in nodes/part/shiftZ=0.1mm",
                        item);
    b->unit = unit_of(equals + 1);
    for (; b->parameter < plan->count; ++b->parameter) {
        const mcv_parameter *p = plan->parameters + b->parameter;
        if (p->path_length == b->path_length && strncmp(p->item, item, (size_t)p->path_length) == 0)
            break;
    }
    b->from = NAN;
    if (b->parameter < plan->count && plan->parameters[b->parameter].levels.named)
        return mcv_fail(error, MCV_USAGE, "--bound %s: the values of --vary are words", item);
    if (b->parameter < plan->count) return MCV_OK;
    snprintf(path, sizeof path, "%.*s", b->path_length, item);
    const mcv_result result = mcv_overrides_number(path, set, document, &b->from, &why);
    return result == MCV_OK ? MCV_OK : mcv_fail(error, result, "--bound %s: %s", item, why.text);
}

void mcv_bound_override(const mcv_bound *b, const double *numbers, char text[512]) {
    const double from = isnan(b->from) ? numbers[b->parameter] : b->from;
    snprintf(text, 512, "%.*s=%.17g", b->path_length, b->item, from + b->step);
}

mcv_result mcv_bound_pairs(const mcv_camera_settings *settings, const mcv_scene *scene,
                           uint32_t sensor, const mcv_film *film, const mcv_film *stepped,
                           mcv_light_pairs *pairs, mcv_error *error) {
    mcv_set_image light;
    *pairs = (mcv_light_pairs){.lens = ""};
    if (film->width != stepped->width || film->height != stepped->height ||
        film->channels != stepped->channels || film->replicates != stepped->replicates)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "--bound: the step changes the picture's size: choose another parameter");
    mcv_result result = mcv_set_image_develop(scene, sensor, film, &light, error);
    const mcv_light_picture pictures[2] = {{scene->path, &light.exr, stepped},
                                           {scene->path, &light.exr, film}};
    if (result == MCV_OK) result = mcv_light_pairs_read(settings, pictures, pairs, error);
    mcv_set_image_free(&light);
    return result;
}
