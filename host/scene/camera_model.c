/* SPDX-License-Identifier: Apache-2.0 */
/* A camera model from a sensor, and projection by it. */
#include "scene/camera_model.h"

#include "core/json.h"
#include "scene/motion.h"
#include "scene/sensors.h"
#include "scene/transform.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* R and t: to the optical frame with y down. */
static void place(const mcv_transform *to_world, mcv_camera_model *model) {
    const double *m = to_world->m;
    for (int i = 0; i < 3; ++i) {
        const double sign = i == 0 ? 1 : -1;
        double sum = 0;
        for (int j = 0; j < 3; ++j) {
            model->rotation[3 * i + j] = sign * m[3 * j + i];
            sum += sign * m[3 * j + i] * m[9 + j];
        }
        model->translation[i] = -sum;
    }
}

static double image_distance(const mcv_sensor *sensor) {
    const double *b = mcv_params_find(mcv_sensor_table(sensor->type), "imageDistance", &sensor->as);
    return b ? *b : 1;
}

/* The rig's nodes first. */
static mcv_result copy_frames(const mcv_scene *scene, mcv_camera_model *model, mcv_error *error) {
    const uint32_t count = scene->frame_count;
    model->nodes = calloc((size_t)count + 1, sizeof *model->nodes);
    if (!model->nodes)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for the camera model", scene->path);
    for (int of_asset = 0; of_asset < 2; ++of_asset)
        for (uint32_t i = 0; i < count; ++i) {
            if (scene->frames[i].of_asset != (of_asset != 0)) continue;
            mcv_placement *frame = model->nodes + model->node_count;
            *frame = scene->frames[i];
            frame->name = strdup(scene->frames[i].name);
            if (!frame->name)
                return mcv_fail(error, MCV_FAILED, "%s: no memory for the camera model",
                                scene->path);
            ++model->node_count;
        }
    return MCV_OK;
}

mcv_result mcv_camera_model_of(const mcv_scene *scene, const mcv_sensor *sensor,
                               mcv_camera_model *model, mcv_error *error) {
    const mcv_readout readout = mcv_sensor_readout(sensor);
    const mcv_optics optics = mcv_sensor_optics(sensor);
    const bool line = mcv_sensor_exposure(sensor).shutter == MCV_SHUTTER_LINE;
    const bool sharp = optics.magnification > 0 && !line;
    double focal[2], centre[2];
    const bool parallel =
        sensor->type == MCV_SENSOR_TELECENTRIC || sensor->type == MCV_SENSOR_FLYING_SPOT;
    *model = (mcv_camera_model){.telecentric = parallel && !line,
                                .line = line,
                                .lens = mcv_sensor_lens_map(sensor),
                                .film_distance = mcv_sensor_film_distance(sensor),
                                .focused_depth = optics.focused_depth,
                                .f_number = optics.f_number,
                                .numerical_aperture = optics.numerical_aperture,
                                .bits = NAN,
                                .black_level = NAN,
                                .gain = NAN};
    mcv_lens_map_find_reach(&model->lens);
    mcv_sensor_film_size(sensor, &model->size[0], &model->size[1]);
    place(&sensor->to_world, model);
    for (int i = 0; i < 2; ++i) {
        model->macro[i] = readout.angular[i];
        model->pixel[i] = readout.pitch[i] * readout.binning[i];
        model->object_pixel[i] = sharp ? model->pixel[i] / optics.magnification : 0;
        centre[i] =
            readout.angular[i] * (readout.centre[i] - readout.first[i]) / readout.binning[i];
        focal[i] = readout.angular[i] * image_distance(sensor) / model->pixel[i];
    }
    if (model->telecentric) {
        for (int i = 0; i < 2; ++i) {
            for (int j = 0; j < 3; ++j)
                model->affine[4 * i + j] = model->rotation[3 * i + j] / model->object_pixel[i];
            model->affine[4 * i + 3] = model->translation[i] / model->object_pixel[i] + centre[i];
        }
    } else if (!line) {
        memcpy(model->k, (const double[9]){focal[0], 0, centre[0], 0, focal[1], centre[1], 0, 0, 1},
               sizeof model->k);
    }
    const mcv_result result = copy_frames(scene, model, error);
    if (result != MCV_OK) mcv_camera_model_free(model);
    return result;
}

void mcv_camera_model_free(mcv_camera_model *model) {
    for (uint32_t i = 0; i < model->node_count; ++i) free(model->nodes[i].name);
    free(model->nodes);
    free(model->render_error.items);
    *model = (mcv_camera_model){0};
}

bool mcv_camera_model_fit(mcv_camera_model *model, uint32_t width, uint32_t height) {
    const uint32_t size[2] = {width, height};
    if (width == model->size[0] && height == model->size[1]) return true;
    if ((uint64_t)width * model->macro[0] != model->size[0] ||
        (uint64_t)height * model->macro[1] != model->size[1])
        return false;
    for (int i = 0; i < 2; ++i) {
        model->k[4 * i] /= model->macro[i];
        model->k[3 * i + 2] /= model->macro[i];
        model->size[i] = size[i];
        model->macro[i] = 1;
    }
    return true;
}

/* --- projection --- */

mcv_result mcv_camera_model_check_places(const mcv_camera_model *model, const char *what,
                                         mcv_error *error) {
    return model->line ? mcv_fail(error, MCV_BAD_INPUT,
                                  "%s: the rows of a \"line\" shutter's image are times: no camera "
                                  "model tells where a point of the scene lies in it",
                                  what)
                       : MCV_OK;
}

static void to_camera(const mcv_camera_model *model, const double world[3], double p[3]) {
    for (int i = 0; i < 3; ++i) {
        const double *r = model->rotation + (size_t)3 * i;
        p[i] = r[0] * world[0] + r[1] * world[1] + r[2] * world[2] + model->translation[i];
    }
}

/* What one pixel is of the film's distance. */
static double slope_of_pixel(const mcv_camera_model *model, int axis) {
    return model->pixel[axis] / model->film_distance;
}

/* The principal point. */
static double centre_of(const mcv_camera_model *model, int axis) {
    /* A (X, 1) = p / object_pixel + c: the centre is what is left of the last column. */
    return model->telecentric
               ? model->affine[4 * axis + 3] - model->translation[axis] / model->object_pixel[axis]
               : model->k[3 * axis + 2];
}

bool mcv_camera_model_project(const mcv_camera_model *model, const double world[3],
                              double pixel[2]) {
    double p[3];
    to_camera(model, world, p);
    if (!model->telecentric && !(p[2] > 0)) return false;
    for (int i = 0; i < 2; ++i) {
        const double *a = model->affine + (size_t)4 * i;
        pixel[i] = model->telecentric ? a[0] * world[0] + a[1] * world[1] + a[2] * world[2] + a[3]
                                      : model->k[4 * i] * p[i] / p[2] + model->k[3 * i + 2];
    }
    if (!mcv_lens_map_is_used(&model->lens)) return true;
    double u[2], film[2];
    for (int i = 0; i < 2; ++i) u[i] = (pixel[i] - centre_of(model, i)) * slope_of_pixel(model, i);
    const bool seen = mcv_lens_map_meet(&model->lens, u, film);
    for (int i = 0; i < 2 && seen; ++i)
        pixel[i] = film[i] / slope_of_pixel(model, i) + centre_of(model, i);
    return seen;
}

double mcv_camera_model_depth(const mcv_camera_model *model, const double world[3]) {
    double p[3];
    to_camera(model, world, p);
    return p[2];
}

void mcv_camera_model_scale(const mcv_camera_model *model, double depth, double per_metre[2]) {
    for (int i = 0; i < 2; ++i)
        per_metre[i] = model->telecentric ? 1 / model->object_pixel[i] : model->k[4 * i] / depth;
}

void mcv_camera_model_unproject(const mcv_camera_model *model, const double pixel[2], double depth,
                                double world[3]) {
    double p[3] = {0, 0, depth}, offset[2];
    for (int i = 0; i < 2; ++i) offset[i] = pixel[i] - centre_of(model, i);
    if (mcv_lens_map_is_used(&model->lens)) {
        double u[2], stretch;
        for (int i = 0; i < 2; ++i) offset[i] *= slope_of_pixel(model, i);
        mcv_lens_map_look(&model->lens, offset, u, &stretch);
        for (int i = 0; i < 2; ++i) offset[i] = u[i] / slope_of_pixel(model, i);
    }
    for (int i = 0; i < 2; ++i)
        p[i] = model->telecentric ? offset[i] * model->object_pixel[i]
                                  : offset[i] / model->k[4 * i] * depth;
    for (int j = 0; j < 3; ++j) {
        world[j] = 0;
        for (int i = 0; i < 3; ++i)
            world[j] += model->rotation[3 * i + j] * (p[i] - model->translation[i]);
    }
}

/* How many nodes have the name, of the rig or of its assets; *frame is the last. */
static uint32_t count_named(const mcv_camera_model *model, const char *name, bool of_asset,
                            const mcv_placement **frame) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < model->node_count; ++i) {
        if (model->nodes[i].of_asset != of_asset || strcmp(model->nodes[i].name, name) != 0)
            continue;
        *frame = model->nodes + i;
        ++count;
    }
    return count;
}

/* The names of few nodes, as ": part, camera"; "" for more than fit. */
static void list_nodes(const mcv_camera_model *model, char text[160]) {
    size_t length = 0;
    for (uint32_t i = 0; i < model->node_count; ++i) {
        const int more =
            snprintf(text + length, 160 - length, "%s%s", i ? ", " : ": ", model->nodes[i].name);
        length += (size_t)(more > 0 ? more : 0);
        if (length < 160) continue;
        *text = '\0';
        return;
    }
}

mcv_result mcv_camera_model_node(const mcv_camera_model *model, const char *name, const char *what,
                                 const mcv_placement **frame, mcv_error *error) {
    const uint32_t rigs = count_named(model, name, false, frame),
                   found = rigs ? rigs : count_named(model, name, true, frame);
    if (found == 1) return MCV_OK;
    if (found > 1)
        return mcv_fail(error, MCV_USAGE,
                        "%s: %u nodes are called \"%s\": give them names of their own", what, found,
                        name);
    const char **names = calloc((size_t)model->node_count + 1, sizeof *names);
    for (uint32_t i = 0; names && i < model->node_count; ++i) names[i] = model->nodes[i].name;
    const char *nearest = names ? mcv_nearest_word(name, names, model->node_count) : NULL;
    free((void *)names);
    if (nearest)
        return mcv_fail(error, MCV_USAGE, "%s: there is no node \"%s\"; did you mean \"%s\"?", what,
                        name, nearest);
    char list[160] = "";
    list_nodes(model, list);
    return mcv_fail(error, MCV_USAGE, "%s: there is no node \"%s\" among the %u that it names%s",
                    what, name, model->node_count,
                    model->node_count == MCV_CAMERA_MODEL_NODES ? ": give --scene, which has all"
                                                                : list);
}
