/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors: their definitions, of one exposure or several, glTF cameras, and what nodes place. */
#include "loader/loader.h"

#include "scene/params.h"
#include "scene/sensors.h"
#include "scene/transform.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const mcv_element_keys[] = {"name", "type", "extras", "extensions", NULL};

/* --- definitions --- */

enum { MOST_EXPOSURES = 64 };

/* A sensor with a list of apertures has an exposure for each of them. */
static size_t exposures_of(const json_t *object) {
    const json_t *list = json_object_get(object, "aperture");
    return json_is_array(list) ? json_array_size(list) : 1;
}

/* Puts an aperture of the list in its place: a word, the rows of a mask, or an object of the
 * aperture's keys. */
static mcv_result put_aperture(json_t *sensor, json_t *aperture, const mcv_json_path *place,
                               mcv_error *error) {
    const char *key;
    json_t *value;
    bool whole = true;
    if (json_is_object(aperture)) {
        whole = json_object_del(sensor, "aperture") == 0;
        json_object_foreach(aperture, key, value) {
            if (strncmp(key, "aperture", strlen("aperture")) != 0)
                return mcv_fail_at(place, error, "%s: is no key of an aperture", key);
            whole = json_object_set(sensor, key, value) == 0 && whole;
        }
    } else if (json_is_array(aperture)) {
        whole = json_object_set_new(sensor, "aperture", json_string("mask")) == 0 &&
                json_object_set(sensor, "apertureMask", aperture) == 0;
    } else {
        if (!json_is_string(aperture))
            return mcv_fail_at(place, error,
                               "must be a word, the rows of a mask, or an object with aperture and "
                               "its other keys");
        whole = json_object_set(sensor, "aperture", aperture) == 0;
    }
    return whole ? MCV_OK : mcv_fail_memory(place, error);
}

static mcv_result define_exposure(const json_t *object, mcv_sensor *sensor,
                                  const mcv_json_path *place, mcv_error *error) {
    uint32_t type;
    MCV_TRY(mcv_element_type(object, mcv_sensor_types, MCV_SENSOR_TYPE_COUNT, &type, place, error));
    const mcv_param_table table = mcv_sensor_table(type);
    mcv_params_set_defaults(table, &sensor->as);
    MCV_TRY(mcv_params_parse(table, object, mcv_element_keys, &sensor->as, place, error));
    sensor->name = (char *)mcv_json_name(object);
    sensor->is_head = type == MCV_SENSOR_LASER_TRIANGULATION;
    sensor->type = type < MCV_SENSOR_COUNT ? type : MCV_SENSOR_THIN_LENS;
    if (sensor->is_head) MCV_TRY(mcv_params_check(table, &sensor->as, place, error));
    return mcv_sensor_resolve(sensor, place, error);
}

/* An error of the keys that this aperture of the list gives is told at its place there. */
static mcv_result fail_aperture(const json_t *aperture, const mcv_json_path *apertures,
                                const mcv_json_path *here, mcv_result result, mcv_error *error) {
    mcv_error own = {""};
    char key[64], path[96] = "";
    (void)mcv_fail_at(apertures, &own, "."); /* "FILE: sensors/NAME/aperture: ." */
    const size_t before = strlen(own.text) - strlen(": .");
    const char *rest = error->text + before, *sentence = strstr(rest, ": ");
    if (result != MCV_BAD_INPUT || strncmp(error->text, own.text, before) != 0 || !sentence)
        return result;
    const size_t length = strcspn(rest, "/:");
    snprintf(key, sizeof key, "aperture%.*s", (int)length, rest);
    if (json_is_object(aperture) && json_object_get(aperture, key))
        snprintf(path, sizeof path, "aperture%.*s", (int)(sentence - rest), rest);
    else if (json_is_array(aperture) && strcmp(key, "apertureMask") == 0 && rest[length] == '/')
        snprintf(path, sizeof path, "%.*s", (int)(sentence - rest - length) - 1, rest + length + 1);
    else if (json_is_object(aperture) || (length > 0 && !json_is_array(aperture)))
        return result; /* a key of the sensor */
    const mcv_json_path within = mcv_json_path_key(here, path);
    return mcv_fail_at(*path ? &within : here, error, "%s", sentence + strlen(": "));
}

/* One exposure of a sensor. */
static mcv_result define_sensor(const json_t *object, size_t exposure, mcv_sensor *sensor,
                                const mcv_json_path *place, mcv_error *error) {
    const json_t *list = json_object_get(object, "aperture");
    const mcv_json_path apertures = mcv_json_path_key(place, "aperture"),
                        here = mcv_place_index(&apertures, exposure);
    if (!json_is_array(list)) return define_exposure(object, sensor, place, error);
    if (json_array_size(list) < 1 || json_array_size(list) > MOST_EXPOSURES)
        return mcv_fail_at(&apertures, error, "must have 1 to %d apertures, one for each exposure",
                           MOST_EXPOSURES);
    json_t *one = json_copy((json_t *)object);
    mcv_result result = one ? put_aperture(one, json_array_get(list, exposure), &here, error)
                            : mcv_fail_memory(place, error);
    if (result == MCV_OK) {
        result = define_exposure(one, sensor, place, error);
        if (result != MCV_OK)
            result =
                fail_aperture(json_array_get(list, exposure), &apertures, &here, result, error);
    }
    sensor->name = (char *)mcv_json_name(object);
    json_decref(one);
    return result;
}

mcv_result mcv_define_sensor(const json_t *object, mcv_sensor *sensor, const mcv_json_path *place,
                             mcv_error *error) {
    for (size_t k = exposures_of(object); k > 1; --k) /* of these only errors are left */
        MCV_TRY(define_sensor(object, k - 1, sensor, place, error));
    return define_sensor(object, 0, sensor, place, error);
}

/* --- what nodes place --- */

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

/* The definition's sensor at a node, once for each of its exposures. */
static mcv_result add_exposures(mcv_loader *loader, uint32_t index, const mcv_node_motion *motion,
                                const char *name, const mcv_transform *to_world,
                                const mcv_json_path *place, mcv_error *error) {
    json_t *sensors;
    MCV_TRY(mcv_load_array(loader, "MCVISI_sensors", "sensors", &sensors, error));
    const json_t *object = json_array_get(sensors, index);
    const mcv_json_path all = mcv_json_path_key(&loader->file, "sensors"),
                        here = mcv_json_path_element(&all, mcv_json_name(object), index);
    for (size_t k = 0; k < exposures_of(object); ++k) {
        mcv_sensor sensor = loader->sensors[index];
        if (k > 0) MCV_TRY(define_sensor(object, k, &sensor, &here, error));
        sensor.motion = *motion;
        MCV_TRY(add_sensor(loader, &sensor, name, to_world, place, error));
    }
    return MCV_OK;
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
        ++loader->sensor_uses[index];
        return add_exposures(loader, index, &motion,
                             first_name(loader->sensors[index].name, mcv_json_name(node), "sensor"),
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
