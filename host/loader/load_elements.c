/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors and emitters: their definitions in MCVISI_sensors and MCVISI_emitters, glTF cameras, and
 * what nodes place. */
#include "loader/loader.h"

#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "scene/transform.h"

#include <stdlib.h>

static const char *const element_keys[] = {"name", "type", "extras", "extensions", NULL};

/* --- definitions --- */

static mcv_result define_sensor(const json_t *object, mcv_sensor *sensor,
                                const mcv_json_path *place, mcv_error *error) {
    uint32_t type;
    MCV_TRY(mcv_element_type(object, mcv_sensor_types, MCV_SENSOR_TYPE_COUNT, &type, place, error));
    const mcv_param_table table = mcv_sensor_table(type);
    mcv_params_set_defaults(table, &sensor->as);
    MCV_TRY(mcv_params_parse(table, object, element_keys, &sensor->as, place, error));
    sensor->name = (char *)mcv_json_name(object);
    sensor->type = type == MCV_SENSOR_LINE_SCAN ? MCV_SENSOR_THIN_LENS : type;
    return mcv_sensor_resolve(sensor, place, error);
}

/* A projector needs an image or a pattern. */
static mcv_result check_picture(mcv_emitter *emitter, const mcv_json_path *place,
                                mcv_error *error) {
    const mcv_pattern *pattern = mcv_emitter_pattern(emitter);
    const mcv_json_path image = mcv_json_path_key(place, "image"),
                        index = mcv_json_path_key(place, "index");
    if (!pattern) return MCV_OK;
    if (pattern->type == MCV_NONE && *mcv_emitter_image(emitter) == MCV_NONE)
        return mcv_fail_at(&image, error,
                           "is missing: index or name of one of the file's images, {\"uri\": "
                           "FILE.exr}, or give a pattern");
    if (pattern->type != MCV_NONE && *mcv_emitter_image(emitter) != MCV_NONE)
        return mcv_fail_at(place, error, "has both image and pattern: give one of them");
    if (pattern->type == MCV_NONE && *mcv_emitter_index(emitter) != 0)
        return mcv_fail_at(&index, error,
                           "is the index in a pattern's sequence, but there is no pattern");
    return MCV_OK;
}

static mcv_result define_emitter(const mcv_scene *scene, const json_t *object, mcv_emitter *emitter,
                                 mcv_preset *preset, const mcv_json_path *place, mcv_error *error) {
    uint32_t type;
    MCV_TRY(
        mcv_element_type(object, mcv_emitter_types, MCV_EMITTER_TYPE_COUNT, &type, place, error));
    const mcv_param_table table = mcv_emitter_table(type);
    const bool is_preset = type >= MCV_EMITTER_COUNT;
    preset->type = is_preset ? type : MCV_NONE;
    void *params = is_preset ? (void *)&preset->as : (void *)&emitter->as;
    mcv_params_set_defaults(table, params);
    MCV_TRY(mcv_params_parse(table, object, element_keys, params, place, error));
    emitter->name = (char *)mcv_json_name(object);
    emitter->type = type;
    emitter->bare_angle = json_is_number(json_object_get(object, "halfAngle")) ||
                          json_is_number(json_object_get(object, "outerConeAngle"));
    if (is_preset)
        MCV_TRY(mcv_preset_resolve(preset, emitter, place, error));
    else
        MCV_TRY(check_picture(emitter, place, error));
    emitter->texture = MCV_NONE;
    emitter->area = 1; /* placeholder: here only the presence of radiance or power is checked */
    MCV_TRY(mcv_emitter_check(emitter, place, error));
    return mcv_emitter_resolve(scene, emitter, place, error);
}

mcv_result mcv_load_definitions(mcv_loader *loader, mcv_error *error) {
    json_t *sensors, *emitters;
    MCV_TRY(mcv_load_array(loader, "MCVISI_sensors", "sensors", &sensors, error));
    MCV_TRY(mcv_load_array(loader, "MCVISI_emitters", "emitters", &emitters, error));
    loader->sensor_count = json_array_size(sensors);
    loader->emitter_count = json_array_size(emitters);
    loader->sensors = calloc(loader->sensor_count + 1, sizeof *loader->sensors);
    loader->emitters = calloc(loader->emitter_count + 1, sizeof *loader->emitters);
    loader->presets = calloc(loader->emitter_count + 1, sizeof *loader->presets);
    loader->sensor_uses = calloc(loader->sensor_count + 1, sizeof *loader->sensor_uses);
    loader->emitter_uses = calloc(loader->emitter_count + 1, sizeof *loader->emitter_uses);
    if (!loader->sensors || !loader->emitters || !loader->presets || !loader->sensor_uses ||
        !loader->emitter_uses)
        return mcv_fail_memory(&loader->file, error);
    const mcv_json_path sensors_place = mcv_json_path_key(&loader->file, "sensors"),
                        emitters_place = mcv_json_path_key(&loader->file, "emitters");
    for (size_t i = 0; i < loader->sensor_count; ++i) {
        const json_t *object = json_array_get(sensors, i);
        const mcv_json_path here = mcv_json_path_element(&sensors_place, mcv_json_name(object), i);
        MCV_TRY(define_sensor(object, loader->sensors + i, &here, error));
    }
    for (size_t i = 0; i < loader->emitter_count; ++i) {
        const json_t *object = json_array_get(emitters, i);
        const mcv_json_path here = mcv_json_path_element(&emitters_place, mcv_json_name(object), i);
        MCV_TRY(define_emitter(loader->scene, object, loader->emitters + i, loader->presets + i,
                               &here, error));
    }
    return MCV_OK;
}

/* --- emitters --- */

/* Each of a node's meshes emits the same radiance: a power is divided by area. */
static mcv_result add_emitters(mcv_loader *loader, const mcv_emitter *emitter, uint32_t first,
                               uint32_t last, mcv_error *error) {
    double total = 0;
    for (uint32_t i = first; i < last; ++i) total += mcv_scene_area(loader->scene, i);
    for (uint32_t i = first; i < last; ++i) {
        mcv_emitter part = *emitter;
        double *power = mcv_emitter_parameter(&part, "power");
        part.instance = i;
        const double share =
            last - first > 1 && total > 0 ? mcv_scene_area(loader->scene, i) / total : 1;
        if (share == 0) continue; /* this mesh has no area, but others have */
        for (int k = 0; power && k < 3; ++k) power[k] *= share;
        MCV_TRY(mcv_scene_add_emitter(loader->scene, &part, error));
    }
    return MCV_OK;
}

static bool emits(const mcv_emission *emission) {
    return emission->radiance[0] + emission->radiance[1] + emission->radiance[2] > 0;
}

/* Instances whose material emits. */
static mcv_result add_emissive(mcv_loader *loader, uint32_t first, uint32_t last,
                               mcv_error *error) {
    const size_t materials = json_array_size(json_object_get(loader->root, "materials"));
    for (uint32_t i = first; i < last; ++i) {
        const mcv_emission *emission = NULL;
        for (size_t m = 0; m < materials && !emission; ++m)
            if (loader->materials[m] == loader->scene->instances[i].material &&
                emits(loader->emission + m))
                emission = loader->emission + m;
        if (!emission) continue;
        mcv_emitter emitter = {.name = loader->scene->instances[i].name,
                               .type = MCV_EMITTER_AREA,
                               .instance = i,
                               .texture = emission->texture};
        mcv_params_set_defaults(mcv_emitter_table(emitter.type), &emitter.as);
        memcpy(emitter.as.area.radiance, emission->radiance, sizeof emission->radiance);
        MCV_TRY(mcv_scene_add_emitter(loader->scene, &emitter, error));
    }
    return MCV_OK;
}

/* Warns that the mirroring of a node has no effect on light with an image. */
static mcv_result warn_of_mirroring(mcv_loader *loader, mcv_emitter *emitter,
                                    const mcv_transform *to_world, mcv_error *error) {
    const uint32_t *image = mcv_emitter_image(emitter);
    if (!image || *image == MCV_NONE || mcv_transform_determinant(to_world) > 0) return MCV_OK;
    return mcv_scene_warn(
        loader->scene, error,
        "emitter \"%s\": its node mirrors (a negative scale), which has no effect on its "
        "light; to mirror it, flip the image%s",
        emitter->name,
        mcv_emitter_parameter(emitter, "mirror") ? ", or write \"mirror\": true into the emitter"
                                                 : "");
}

mcv_result mcv_load_emitter(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                            uint32_t first, uint32_t last, const mcv_json_path *place,
                            mcv_error *error) {
    uint32_t index;
    if (loader->is_asset) return add_emissive(loader, first, last, error);
    MCV_TRY(mcv_load_reference(node, "MCVISI_emitters", "emitter", loader->emitter_count,
                               "emitters", &index, place, error));
    if (index == MCV_NONE) return add_emissive(loader, first, last, error);
    mcv_emitter emitter = loader->emitters[index];
    ++loader->emitter_uses[index];
    if (loader->presets[index].type == MCV_NONE)
        MCV_TRY(warn_of_mirroring(loader, &emitter, to_world, error));
    if (!mcv_emitter_has_surface(emitter.type)) {
        if (!mcv_transform_rigid(to_world, &emitter.to_world))
            return mcv_fail_at(place, error, "its scale must not be 0");
        MCV_TRY(mcv_scene_add_emitter(loader->scene, &emitter, error));
        return add_emissive(loader, first, last, error);
    }
    const mcv_json_path emitters = mcv_json_path_key(&loader->file, "emitters"),
                        here = mcv_json_path_element(&emitters, emitter.name, index);
    if (loader->presets[index].type != MCV_NONE) {
        if (json_object_get(node, "mesh"))
            return mcv_fail_at(
                &here, error,
                "a %s has a shape of its own, but node \"%s\" has a mesh: put it on another node",
                mcv_emitter_types[loader->presets[index].type], mcv_json_name(node));
        MCV_TRY(mcv_load_preset(loader, loader->presets + index, mcv_json_name(node), to_world,
                                place, error));
        return add_emitters(loader, &emitter, first, first + 1, error);
    }
    double size[2];
    mcv_emitter_size(loader->scene, &emitter, size);
    const bool rectangle = !isnan(size[0]);
    if (json_object_get(node, "mesh") && rectangle)
        return mcv_fail_at(
            &here, error,
            "%s is for a node without a mesh, but node \"%s\" has one: leave one of them out",
            mcv_emitter_parameter(&emitter, "size") ? "size"
            : emitter.type == MCV_EMITTER_SCREEN    ? "a screen"
                                                    : "a lens",
            mcv_json_name(node));
    if (!json_object_get(node, "mesh")) {
        if (!rectangle)
            return mcv_fail_at(&here, error,
                               "needs size, because its node \"%s\" has no mesh to emit from",
                               mcv_json_name(node));
        MCV_TRY(emitter.type == MCV_EMITTER_SCREEN
                    ? mcv_load_screen(loader, mcv_json_name(node), &emitter.as.screen, size,
                                      to_world, place, error)
                    : mcv_load_rectangle(loader, mcv_json_name(node), size,
                                         mcv_emitter_mirrors(&emitter), to_world, place, error));
        last = first + 1;
    }
    if (first == last)
        return mcv_fail_at(&here, error,
                           "the mesh of its node \"%s\" has no triangles to emit from",
                           mcv_json_name(node));
    return add_emitters(loader, &emitter, first, last, error);
}

/* --- sensors --- */

/* A glTF camera has no pixels: it gets this many in x, square, of 10 µm. */
enum { CAMERA_WIDTH = 1024 };
static const double camera_pixel = 10e-6;

static uint32_t camera_height(double aspect) {
    return (uint32_t)fmin(fmax(round(CAMERA_WIDTH / aspect), 1), 65536);
}

static void perspective_sensor(const json_t *lens, mcv_sensor *sensor) {
    const double yfov = json_number_value(json_object_get(lens, "yfov"));
    const json_t *given = json_object_get(lens, "aspectRatio");
    const double aspect = given ? json_number_value(given) : 1;
    mcv_pinhole_params *p = &sensor->as.pinhole;
    sensor->type = MCV_SENSOR_PINHOLE;
    mcv_params_set_defaults(mcv_sensor_table(sensor->type), p);
    p->resolution[0] = CAMERA_WIDTH;
    p->resolution[1] = camera_height(aspect);
    p->pixelSize[1] = camera_pixel;
    p->pixelSize[0] = camera_pixel * p->resolution[1] * aspect /
                      CAMERA_WIDTH; /* the height is rounded, the aspect ratio is not */
    p->imageDistance = camera_pixel * p->resolution[1] / (2 * tan(yfov / 2));
}

/*
 * Magnification 1, in focus at zfar (a depth that fits the parameter), with so small a stop that a
 * point at the lens is blurred by a thousandth of a pixel.
 */
static void orthographic_sensor(const json_t *lens, mcv_sensor *sensor) {
    const double xmag = fabs(json_number_value(json_object_get(lens, "xmag")));
    const double ymag = fabs(json_number_value(json_object_get(lens, "ymag")));
    mcv_telecentric_params *p = &sensor->as.telecentric;
    sensor->type = MCV_SENSOR_TELECENTRIC;
    mcv_params_set_defaults(mcv_sensor_table(sensor->type), p);
    p->resolution[0] = CAMERA_WIDTH;
    p->resolution[1] = camera_height(xmag / ymag);
    p->pixelSize[0] = 2 * xmag / p->resolution[0];
    p->pixelSize[1] = 2 * ymag / p->resolution[1];
    p->magnification = 1;
    p->workingDistance = fmin(json_number_value(json_object_get(lens, "zfar")), 500);
    p->numericalAperture = 1e-3 * fmin(p->pixelSize[0], p->pixelSize[1]) / (2 * p->workingDistance);
}

/* Sensors are chosen by name, so names are made unique: "cam", "cam-2". */
static mcv_result add_sensor(mcv_loader *loader, mcv_sensor *sensor, const char *name,
                             const mcv_transform *to_world, const mcv_json_path *place,
                             mcv_error *error) {
    mcv_scene *scene = loader->scene;
    char *unique = NULL;
    bool taken = true;
    if (!mcv_transform_rigid(to_world, &sensor->to_world))
        return mcv_fail_at(place, error, "its scale must not be 0");
    if (mcv_transform_determinant(to_world) < 0)
        MCV_TRY(mcv_scene_warn(
            scene, error,
            "sensor \"%s\": its node mirrors (a negative scale), which has no effect on the "
            "image; to mirror it, put a mirror into the scene or flip the image",
            name));
    for (unsigned n = 1; taken; ++n) {
        free(unique);
        if ((n == 1 ? asprintf(&unique, "%s", name) : asprintf(&unique, "%s-%u", name, n)) < 0)
            return mcv_fail_memory(place, error);
        taken = false;
        for (uint32_t i = 0; i < scene->sensor_count; ++i)
            taken = taken || strcmp(scene->sensors[i].name, unique) == 0;
    }
    sensor->name = unique;
    const mcv_result result = mcv_scene_add_sensor(scene, sensor, error);
    free(unique);
    return result;
}

/* The first name that is not empty. */
static const char *first_name(const char *a, const char *b, const char *c) {
    return a && *a ? a : *b ? b : c;
}

mcv_result mcv_load_sensors(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                            const mcv_json_path *place, mcv_error *error) {
    uint32_t index, camera_index;
    const json_t *cameras = json_object_get(loader->root, "cameras");
    mcv_node_motion motion;
    if (loader->is_asset) return MCV_OK;
    MCV_TRY(mcv_load_reference(node, "MCVISI_sensors", "sensor", loader->sensor_count, "sensors",
                               &index, place, error));
    MCV_TRY(mcv_load_motion(node, &motion, place, error));
    if (index != MCV_NONE) {
        mcv_sensor sensor = loader->sensors[index];
        sensor.motion = motion;
        ++loader->sensor_uses[index];
        return add_sensor(loader, &sensor, first_name(sensor.name, mcv_json_name(node), "sensor"),
                          to_world, place, error);
    }
    MCV_TRY(mcv_json_index(node, "camera", json_array_size(cameras), "cameras", &camera_index,
                           place, error));
    if (camera_index == MCV_NONE) return MCV_OK;
    const json_t *camera = json_array_get(cameras, camera_index),
                 *lens = json_object_get(camera, "perspective");
    mcv_sensor sensor = {.motion = motion};
    if (lens)
        perspective_sensor(lens, &sensor);
    else
        orthographic_sensor(json_object_get(camera, "orthographic"), &sensor);
    return add_sensor(loader, &sensor,
                      first_name(mcv_json_name(node), mcv_json_name(camera), "camera"), to_world,
                      place, error);
}
