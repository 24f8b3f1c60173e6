/* SPDX-License-Identifier: Apache-2.0 */
/* A camera of a file as a sensor and a node of a glTF document. */
#include "calibration/calibration.h"

#include <math.h>
#include <string.h>

/* What a file of a telecentric camera need not state. */
static const double usual_distance = 0.1, usual_f_number = 8;

/* The member, which is made where it is missing; NULL where it is something else. */
static json_t *member(json_t *object, const char *key, json_t *(*make)(void)) {
    json_t *found = json_object_get(object, key);
    if (!found) {
        json_object_set_new(object, key, make());
        found = json_object_get(object, key);
    }
    json_t *like = make();
    const bool right = found && json_typeof(found) == json_typeof(like);
    json_decref(like);
    return right ? found : NULL;
}

static json_t *pair(double x, double y) { return json_pack("[f,f]", x, y); }

static json_t *make_sensor(const mcv_calibration *camera, const char *name, const double pixel[2]) {
    const mcv_camera_model *m = &camera->model;
    double centre[2];
    mcv_calibration_centre(m, centre);
    json_t *sensor =
        json_pack("{s:s, s:s}", "name", name, "type", m->telecentric ? "telecentric" : "pinhole");
    if (m->telecentric) {
        json_object_set_new(sensor, "magnification", json_real(pixel[0] / m->object_pixel[0]));
        /* The film's distance from the stop, m f, counts where the film is tilted. */
        if (m->lens.tilted || m->lens.model == MCV_BROWN_CONRADY)
            json_object_set_new(sensor, "focalLength",
                                json_real(m->film_distance * m->object_pixel[0] / pixel[0]));
        else
            json_object_set_new(sensor, "workingDistance",
                                json_real(m->focused_depth > 0 && isfinite(m->focused_depth)
                                              ? m->focused_depth
                                              : usual_distance));
        json_object_set_new(sensor, "fNumber",
                            json_real(m->f_number > 0 ? m->f_number : usual_f_number));
    } else {
        json_object_set_new(sensor, "imageDistance", json_real(m->k[0] * pixel[0]));
    }
    json_object_set_new(sensor, "resolution", json_pack("[i,i]", (int)m->size[0], (int)m->size[1]));
    json_object_set_new(sensor, "pixelSize", pair(pixel[0], pixel[1]));
    json_object_set_new(sensor, "principalPoint", pair(centre[0], centre[1]));
    if (mcv_lens_map_is_used(&m->lens)) mcv_camera_model_put_lens(m, sensor);
    return sensor;
}

/* The node looks along -z with y up: its rotation is that of R^T diag(1, -1, -1), its place -R^T t.
 */
static json_t *make_node(const mcv_camera_model *m, const char *name, size_t sensor) {
    double turned[9], place[3] = {0}, q[4];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            turned[3 * i + j] = m->rotation[3 * j + i] * (j == 0 ? 1 : -1);
            place[i] -= m->rotation[3 * j + i] * m->translation[j];
        }
    mcv_rotation_to_quaternion(turned, q);
    return json_pack("{s:s, s:[f,f,f], s:[f,f,f,f], s:{s:{s:i}}}", "name", name, "translation",
                     place[0] + 0.0, place[1] + 0.0, place[2] + 0.0, "rotation", q[1] + 0.0,
                     q[2] + 0.0, q[3] + 0.0, q[0], "extensions", "MCVISI_sensors", "sensor",
                     (int)sensor);
}

/* The nodes of the scene that is shown. */
static json_t *scene_nodes(json_t *document) {
    json_t *scenes = member(document, "scenes", json_array);
    const size_t index = (size_t)json_integer_value(json_object_get(document, "scene"));
    if (scenes && json_array_size(scenes) == 0) json_array_append_new(scenes, json_object());
    json_t *scene = json_array_get(scenes, index);
    return json_is_object(scene) ? member(scene, "nodes", json_array) : NULL;
}

static void use_extension(json_t *document) {
    json_t *used = member(document, "extensionsUsed", json_array);
    size_t i;
    const json_t *item;
    json_array_foreach(used, i, item) {
        if (json_is_string(item) && strcmp(json_string_value(item), "MCVISI_sensors") == 0) return;
    }
    json_array_append_new(used, json_string("MCVISI_sensors"));
}

/* One size where a pixel is square, else the other as the scale says. */
static void find_pixel(const mcv_camera_model *m, double width, double pixel[2]) {
    const double ratio =
        m->telecentric ? m->object_pixel[1] / m->object_pixel[0] : m->k[0] / m->k[4];
    pixel[0] = m->pixel[0] > 0 ? m->pixel[0] : width;
    pixel[1] = m->pixel[1] > 0 ? m->pixel[1] : pixel[0] * ratio;
}

mcv_result mcv_calibration_add(const mcv_calibration *camera, const char *path, const char *name,
                               double pixel, json_t *document, mcv_error *error) {
    const mcv_camera_model *m = &camera->model;
    json_t *extensions = member(document, "extensions", json_object),
           *extension = extensions ? member(extensions, "MCVISI_sensors", json_object) : NULL,
           *sensors = extension ? member(extension, "sensors", json_array) : NULL,
           *nodes = member(document, "nodes", json_array), *shown = scene_nodes(document);
    double size[2];
    size_t i;
    const json_t *other;
    if (!sensors || !nodes || !shown)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "the rig's sensors, nodes and scenes must be as glTF has them");
    json_array_foreach(sensors, i, other) {
        const char *known = json_string_value(json_object_get(other, "name"));
        if (known && strcmp(known, name) == 0)
            return mcv_fail(error, MCV_USAGE,
                            "the rig has a sensor \"%s\" already: name the new one by --sensor",
                            name);
    }
    find_pixel(m, pixel, size);
    const double ratio = m->telecentric
                             ? (m->object_pixel[0] / size[0]) / (m->object_pixel[1] / size[1])
                             : m->k[0] * size[0] / (m->k[4] * size[1]);
    if (!(fabs(ratio - 1) < 1e-9))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its pixels of %g x %g m do not have the ratio of its scales in x and "
                        "y: one lens cannot do that",
                        path, size[0], size[1]);
    json_t *sensor = make_sensor(camera, name, size);
    if (!sensor) return mcv_fail(error, MCV_USAGE, "--sensor: the sensor's name must be UTF-8");
    json_array_append_new(sensors, sensor);
    json_array_append_new(nodes, make_node(m, name, json_array_size(sensors) - 1));
    json_array_append_new(shown, json_integer((json_int_t)json_array_size(nodes) - 1));
    use_extension(document);
    return MCV_OK;
}
