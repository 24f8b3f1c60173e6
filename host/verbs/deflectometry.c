/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/deflectometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/emitters.h"

static mcv_screen_place place_of(const mcv_scene *scene, uint32_t emitter, bool flat) {
    const mcv_emitter *e = scene->emitters + emitter;
    const mcv_screen_params *p = &e->as.screen;
    return (mcv_screen_place){.params = p,
                              .to_world = scene->instances[e->instance].to_world,
                              .pixels = {p->pattern.resolution[0], p->pattern.resolution[1]},
                              .flat = flat};
}

mcv_result mcv_deflectometry_screen(const mcv_scene *scene, const mcv_command *command,
                                    uint32_t *emitter, mcv_error *error) {
    uint32_t screens = 0;
    *emitter = MCV_NONE;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *e = scene->emitters + i;
        if (e->type != MCV_EMITTER_SCREEN) continue;
        ++screens;
        if (!command->screen || strcmp(e->name, command->screen) == 0) *emitter = i;
    }
    if (screens == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no emitter of the type screen, which shows the fringes",
                        scene->path);
    if (*emitter == MCV_NONE)
        return mcv_fail(error, MCV_USAGE, "--screen %s: %s has no screen of this name",
                        command->screen, scene->path);
    if (screens > 1 && !command->screen)
        return mcv_fail(error, MCV_USAGE, "%s: has %u screens: choose one by --screen NAME",
                        scene->path, screens);
    const mcv_screen_params *p = &scene->emitters[*emitter].as.screen;
    if (p->pattern.type != MCV_PATTERN_PHASE_SHIFT)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: screen \"%s\" must show a pattern of the type phaseShift, whose steps "
                        "and periods count",
                        scene->path, scene->emitters[*emitter].name);
    if (p->pattern.periods >= 2) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: screen \"%s\" shows %g periods: at least 2 are needed, which are told "
                    "apart by others",
                    scene->path, scene->emitters[*emitter].name, p->pattern.periods);
}

mcv_result mcv_deflectometry_show(mcv_scene *scene, uint32_t emitter, uint32_t direction,
                                  mcv_error *error) {
    mcv_emitter *e = scene->emitters + emitter;
    const uint32_t length = e->as.screen.pattern.resolution[direction];
    mcv_texture line = scene->textures[e->texture];
    line.width = direction == 0 ? length : 1;
    line.height = direction == 0 ? 1 : length;
    line.rgba = NULL;
    line.linear = malloc(3 * sizeof *line.linear * length);
    if (!line.linear)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for a white line", scene->path);
    for (size_t i = 0; i < 3 * (size_t)length; ++i) line.linear[i] = 1;
    const mcv_result result = mcv_scene_add_texture(scene, &line, error);
    free(line.linear);
    if (result == MCV_OK) scene->emitters[emitter].texture = scene->texture_count - 1;
    return result;
}

mcv_result mcv_deflectometry_decode(const mcv_command *command, const mcv_scene *scene,
                                    uint32_t emitter, uint32_t direction, const mcv_matrix *matrix,
                                    mcv_deflectometry *d, mcv_error *error) {
    const mcv_screen_params *p = &scene->emitters[emitter].as.screen;
    const mcv_element_group *group = mcv_matrix_group(matrix, scene->emitters[emitter].name);
    const mcv_fringe_plan plan = {.steps = p->pattern.steps,
                                  .periods = p->pattern.periods,
                                  .length = p->pattern.resolution[direction],
                                  .gamma = p->gamma,
                                  .unwrap = (int)command->unwrap,
                                  .noise = command->fringe_noise,
                                  .seed = (uint32_t)command->seed,
                                  .direction = direction};
    const size_t count = (size_t)matrix->width * matrix->height;
    bool *seen = malloc(count + 1);
    d->decoded[direction] = calloc(count + 1, sizeof **d->decoded);
    mcv_result result = seen && d->decoded[direction]
                            ? MCV_OK
                            : mcv_fail(error, MCV_FAILED, "no memory for %zu pixels", count);
    if (result == MCV_OK)
        result = mcv_fringes_decode(matrix, group->first, &plan, d->decoded[direction], error);
    if (result == MCV_OK) {
        const double pitch = p->pixelPitch[direction];
        for (size_t i = 0; i < count; ++i) seen[i] = !isnan(d->decoded[direction][i].place);
        d->beats[direction] = plan.unwrap == MCV_UNWRAP_HETERODYNE ? plan.periods : 0;
        d->period[direction] = plan.length / plan.periods * pitch;
        d->best[direction] = pitch * mcv_best_period(matrix, group->first, plan.length, seen,
                                                     d->best_contrast + direction);
    }
    free(seen);
    return result;
}

static void take_form(mcv_deflectometry *d, int form) {
    d->form = form;
    d->plane = mcv_form_fit(&d->shape, MCV_FORM_PLANE);
    if (form == MCV_FORM_QUADRIC) d->quadric = mcv_form_fit(&d->shape, MCV_FORM_QUADRIC);
    if (form != MCV_FORM_NONE)
        mcv_form_take(form == MCV_FORM_PLANE ? &d->plane : &d->quadric, &d->shape);
}

mcv_result mcv_deflectometry_shape(const mcv_command *command, const mcv_scene *scene,
                                   uint32_t sensor, uint32_t emitter, mcv_deflectometry *d,
                                   mcv_error *error) {
    const mcv_screen_place screen = place_of(scene, emitter, command->flat_screen);
    const mcv_decoded *const places[2] = {d->decoded[0], d->decoded[1]};
    const mcv_placement *plane;
    mcv_camera_model model;
    MCV_TRY(mcv_camera_model_of(scene, scene->sensors + sensor, &model, error));
    mcv_result result = mcv_camera_model_node(&model, command->plane, "--plane", &plane, error);
    if (result == MCV_OK && model.macro[0] * model.macro[1] > 1)
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: a pixel of a light field camera has no ray of its own: choose "
                          "another sensor",
                          scene->path);
    if (result == MCV_OK)
        result = mcv_shape_make(&model, &screen, &plane->to_world, places, model.size[0],
                                model.size[1], (uint32_t)command->seed, &d->shape, error);
    if (result == MCV_OK && d->shape.valid_count == 0)
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: no pixel of sensor \"%s\" sees fringes of the screen in the part",
                          scene->path, scene->sensors[sensor].name);
    if (result == MCV_OK) take_form(d, (int)command->removed_form);
    mcv_camera_model_free(&model);
    return result;
}

void mcv_deflectometry_free(mcv_deflectometry *d) {
    free(d->decoded[0]);
    free(d->decoded[1]);
    mcv_shape_free(&d->shape);
}
