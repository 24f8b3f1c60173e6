/* SPDX-License-Identifier: Apache-2.0 */
#include "check/find.h"
#include "core/basics.h"
#include "scene/geometry.h"
#include "scene/lens_map.h"
#include "scene/materials.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const mcv_severities[] = {
#define MCV_X(severity, NAME) #severity,
    MCV_SEVERITIES(MCV_X)
#undef MCV_X
};

/* --- the list --- */

static char *make_path(const char *kind, const char *name, const char *key) {
    char *path = NULL;
    const bool named = name && *name;
    return asprintf(&path, "%s%s%s%s%s", kind, named ? "/" : "", named ? name : "",
                    named && key ? "/" : "", named && key ? key : "") < 0
               ? NULL
               : path;
}

mcv_result mcv_findings_add(mcv_findings *findings, mcv_severity severity, const char *kind,
                            const char *name, const char *key, mcv_error *error, const char *format,
                            ...) {
    if (severity < findings->least) return MCV_OK;
    mcv_finding *items = realloc(findings->items, (findings->count + 1) * sizeof *items);
    if (!items) return mcv_fail(error, MCV_FAILED, "no memory for the findings");
    findings->items = items;
    mcv_finding *finding = items + findings->count;
    va_list arguments;
    va_start(arguments, format);
    const bool worded = vasprintf(&finding->sentence, format, arguments) >= 0;
    va_end(arguments);
    finding->severity = severity;
    finding->path = make_path(kind, name, key);
    if (worded && finding->path) {
        ++findings->count;
        return MCV_OK;
    }
    free(finding->path);
    if (worded) free(finding->sentence);
    return mcv_fail(error, MCV_FAILED, "no memory for the findings");
}

static mcv_result find_all(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    mcv_result result = MCV_OK;
    for (uint32_t i = 0; i < scene->warning_count && result == MCV_OK; ++i)
        result = mcv_findings_add(findings, MCV_SEVERITY_WARNING, "", NULL, NULL, error, "%s",
                                  scene->warnings[i]);
#define MCV_X(name) \
    if (result == MCV_OK) result = mcv_find_##name(scene, findings, error);
    MCV_FINDINGS(MCV_X)
#undef MCV_X
    if (result != MCV_OK) mcv_findings_free(findings);
    return result;
}

mcv_result mcv_findings_of(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    *findings = (mcv_findings){.least = MCV_SEVERITY_NOTE};
    return find_all(scene, findings, error);
}

mcv_result mcv_warnings_of(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    *findings = (mcv_findings){.least = MCV_SEVERITY_WARNING};
    return find_all(scene, findings, error);
}

mcv_result mcv_find_extras(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    const size_t count = scene->ignored_extras;
    if (count == 0) return MCV_OK;
    return mcv_findings_add(findings, MCV_SEVERITY_NOTE, "", NULL, NULL, error,
                            "ignored: extras of %zu object%s", count, count == 1 ? "" : "s");
}

void mcv_findings_free(mcv_findings *findings) {
    for (size_t i = 0; i < findings->count; ++i) {
        free(findings->items[i].path);
        free(findings->items[i].sentence);
    }
    free(findings->items);
    *findings = (mcv_findings){0};
}

/* --- what the functions share --- */

const char *mcv_length_in_words(double metres, char text[32]) {
    const double size = fabs(metres);
    const char *unit = size >= 1 ? "m" : size >= 1e-3 ? "mm" : "µm";
    snprintf(text, 32, "%.3g %s", metres * (size >= 1 ? 1 : size >= 1e-3 ? 1e3 : 1e6), unit);
    return text;
}

const char *mcv_instance_label(const mcv_scene *scene, uint32_t instance, char text[MCV_LABEL]) {
    const char *name = scene->instances[instance].name,
               *mesh = scene->meshes[scene->instances[instance].mesh].name;
    const bool is_node = *name || !*mesh;
    if (!is_node) name = mesh;
    snprintf(text, MCV_LABEL, "%s \"%.*s\"", is_node ? "node" : "mesh",
             mcv_whole_characters(name, 80), name);
    return text;
}

uint32_t mcv_node_end(const mcv_scene *scene, uint32_t first) {
    uint32_t last = first + 1;
    while (last < scene->instance_count &&
           strcmp(scene->instances[first].name, scene->instances[last].name) == 0)
        ++last;
    return last;
}

uint32_t mcv_body_end(const mcv_scene *scene, uint32_t first) {
    const mcv_instance *a = scene->instances + first;
    uint32_t last = first + 1;
    for (; last < scene->instance_count; ++last) {
        const mcv_instance *b = scene->instances + last;
        if (strcmp(a->name, b->name) != 0 ||
            memcmp(&a->to_world, &b->to_world, sizeof a->to_world) != 0)
            break;
    }
    return last;
}

static bool any_emits(const mcv_scene *scene, uint32_t first, uint32_t end) {
    for (uint32_t i = first; i < end; ++i)
        if (scene->instances[i].emitter != MCV_NONE) return true;
    return false;
}

/* Of a node without a name each instance stands for itself. */
static uint32_t named_end(const mcv_scene *scene, uint32_t first) {
    return *scene->instances[first].name ? mcv_node_end(scene, first) : first + 1;
}

bool mcv_is_part(const mcv_scene *scene, uint32_t instance) {
    const char *name = scene->instances[instance].name;
    uint32_t first = instance;
    while (*name && first > 0 && strcmp(scene->instances[first - 1].name, name) == 0) --first;
    return !any_emits(scene, first, named_end(scene, first));
}

uint32_t mcv_next_part(const mcv_scene *scene, uint32_t i, uint32_t *end) {
    while (i >= *end && i < scene->instance_count) {
        *end = named_end(scene, i);
        if (any_emits(scene, i, *end)) i = *end;
    }
    return i;
}

bool mcv_is_mirror(const mcv_material *material) {
    return material->type == MCV_MATERIAL_MIRROR || material->type == MCV_MATERIAL_BEAM_SPLITTER ||
           (material->type == MCV_MATERIAL_CONDUCTOR && !mcv_material_is_rough(material));
}

double mcv_lens_radius(const mcv_sensor *sensor) {
    switch (sensor->type) {
    case MCV_SENSOR_THIN_LENS:
        return sensor->as.thin_lens.lensDiameter / 2;
    case MCV_SENSOR_TELECENTRIC:
        return sensor->as.telecentric.lensDiameter / 2;
    case MCV_SENSOR_LIGHT_FIELD:
        return sensor->as.light_field.lensDiameter * M_SQRT1_2; /* the square's corner */
    default:
        return 0;
    }
}

/* The length by which lengths on the film are divided. */
static double film_scale(const mcv_sensor *sensor) {
    switch (sensor->type) {
    case MCV_SENSOR_THIN_LENS:
        return sensor->as.thin_lens.imageDistance;
    case MCV_SENSOR_LIGHT_FIELD:
        return sensor->as.light_field.imageDistance;
    case MCV_SENSOR_PINHOLE:
        return sensor->as.pinhole.imageDistance;
    case MCV_SENSOR_TELECENTRIC:
        return sensor->as.telecentric.magnification;
    default:
        return NAN;
    }
}

/* What the border of the image sees through a lens that distorts, or from a tilted film. */
static void bend_view(const mcv_readout *readout, const mcv_sensor *sensor, mcv_view *view) {
    enum { STEPS = 16 };
    const mcv_lens_map map = mcv_sensor_lens_map(sensor);
    const double h = mcv_sensor_film_distance(sensor),
                 scale = view->is_telecentric ? sensor->as.telecentric.focalLength : 1;
    if (!mcv_lens_map_is_used(&map)) return;
    for (int i = 0; i < 2; ++i) view->film[i][0] = INFINITY, view->film[i][1] = -INFINITY;
    for (int step = 0; step < 4 * STEPS; ++step) {
        const double along = step % STEPS / (double)STEPS;
        const double share[4][2] = {{along, 0}, {1, along}, {1 - along, 1}, {0, 1 - along}};
        double film[2], u[2], stretch;
        for (int i = 0; i < 2; ++i)
            film[i] = (readout->first[i] - readout->centre[i] +
                       share[step / STEPS][i] * readout->size[i] * readout->binning[i]) *
                      readout->pitch[i] / h;
        if (!mcv_lens_map_look(&map, film, u, &stretch)) continue;
        for (int i = 0; i < 2; ++i) {
            const double at = (i == 0 ? u[0] : -u[1]) * scale;
            view->film[i][0] = fmin(view->film[i][0], at);
            view->film[i][1] = fmax(view->film[i][1], at);
        }
    }
}

mcv_view mcv_view_of(const mcv_sensor *sensor) {
    const mcv_readout readout = mcv_sensor_readout(sensor);
    const double scale = film_scale(sensor);
    mcv_view view = {.sensor = sensor,
                     .optics = mcv_sensor_optics(sensor),
                     .is_telecentric = sensor->type == MCV_SENSOR_TELECENTRIC};
    for (int i = 0; i < 2; ++i) {
        const double first = (readout.first[i] - readout.centre[i]) * readout.pitch[i] / scale;
        const double last =
            first + (double)readout.size[i] * readout.binning[i] * readout.pitch[i] / scale;
        view.film[i][0] = i == 0 ? first : -last; /* rows run down */
        view.film[i][1] = i == 0 ? last : -first;
        view.pixel[i] = readout.binning[i] * readout.pitch[i] / scale;
    }
    bend_view(&readout, sensor, &view);
    return view;
}

double mcv_view_pixel(const mcv_view *view, double depth) {
    return fmin(view->pixel[0], view->pixel[1]) * (view->is_telecentric ? 1 : depth);
}

void mcv_view_point(const mcv_view *view, const double world[3], double local[3]) {
    const double *m = view->sensor->to_world.m;
    const double from[3] = {world[0] - m[9], world[1] - m[10], world[2] - m[11]};
    for (int i = 0; i < 3; ++i) local[i] = m[i] * from[0] + m[3 + i] * from[1] + m[6 + i] * from[2];
    local[2] = -local[2];
}

bool mcv_view_project(const mcv_view *view, const double world[3], double film[2]) {
    double local[3];
    mcv_view_point(view, world, local);
    for (int i = 0; i < 2; ++i) film[i] = view->is_telecentric ? local[i] : local[i] / local[2];
    return local[2] > 0;
}

/*
 * A telecentric camera blurs a point at the depth z to 2 NA |z - W| of the object, other cameras to
 * D |1/z - κ| in tangents. The depth of field is where the blur is one pixel; it gives the slope.
 */
double mcv_view_blur(const mcv_view *view, double depth) {
    const mcv_optics *o = &view->optics;
    if (isnan(o->focused_depth)) return 0; /* a pinhole */
    if (view->is_telecentric)
        return 2 * o->numerical_aperture * fabs(depth - o->focused_depth) /
               mcv_view_pixel(view, depth);
    const double kappa = 1 / o->focused_depth, one_pixel = 1 / o->depth_of_field[0] - kappa;
    return fabs(1 / depth - kappa) / one_pixel;
}

mcv_extent mcv_view_extent(const mcv_view *view, const mcv_scene *scene, uint32_t instance) {
    const uint32_t vertices = scene->meshes[scene->instances[instance].mesh].vertex_count;
    mcv_extent e = {.depth = {INFINITY, -INFINITY},
                    .film = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}}};
    double range[2][2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
    for (uint32_t v = 0; v < vertices; ++v) {
        double world[3], local[3];
        mcv_scene_vertex(scene, instance, v, world);
        mcv_view_point(view, world, local);
        e.depth[0] = fmin(e.depth[0], local[2]);
        e.depth[1] = fmax(e.depth[1], local[2]);
        for (int i = 0; i < 2; ++i) {
            const double at = view->is_telecentric ? local[i] : local[i] / local[2];
            range[i][0] = fmin(range[i][0], local[i]);
            range[i][1] = fmax(range[i][1], local[i]);
            if (!(local[2] > 0)) continue;
            e.film[i][0] = fmin(e.film[i][0], at);
            e.film[i][1] = fmax(e.film[i][1], at);
        }
    }
    for (int i = 0; i < 2; ++i) e.middle[i] = 0.5 * (range[i][0] + range[i][1]);
    e.middle[2] = 0.5 * (e.depth[0] + e.depth[1]);
    e.crosses = e.depth[0] <= 0 && e.depth[1] > 0;
    return e;
}

bool mcv_view_shows(const mcv_view *view, const mcv_extent *e) {
    if (!(e->depth[1] > 0)) return false;
    if (e->crosses) return true;
    const double blur =
        0.5 * fmax(mcv_view_blur(view, e->depth[0]), mcv_view_blur(view, e->depth[1]));
    for (int i = 0; i < 2; ++i) {
        const double margin = blur * view->pixel[i];
        if (e->film[i][1] < view->film[i][0] - margin || e->film[i][0] > view->film[i][1] + margin)
            return false;
    }
    return true;
}
