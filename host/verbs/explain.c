/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/explain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check/find.h"
#include "check/setup_page.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "explain/routes.h"
#include "scene/emitters.h"
#include "scene/materials.h"
#include "scene/params.h"
#include "verbs/render_picture.h"

static mcv_result read_pixel(const mcv_command *command, uint32_t pixel[2], mcv_error *error) {
    char *comma, *end = NULL;
    if (!command->pixel)
        return mcv_fail(error, MCV_USAGE, "--pixel is missing: give one, as in --pixel 120,80");
    const unsigned long column = strtoul(command->pixel, &comma, 10),
                        row = *comma == ',' ? strtoul(comma + 1, &end, 10) : 0;
    pixel[0] = (uint32_t)column;
    pixel[1] = (uint32_t)row;
    if (command->pixel[strspn(command->pixel, "0123456789,")] == '\0' && comma > command->pixel &&
        *comma == ',' && end > comma + 1 && *end == '\0' && column <= 99999 && row <= 99999)
        return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "--pixel %s: must be column and row from 0, as in --pixel 120,80",
                    command->pixel);
}

static json_t *place(const double p[3]) { return json_pack("[f, f, f]", p[0], p[1], p[2]); }

/* The surfaces and the places of a route's strongest path, for JSON. */
static void report_path(const mcv_scene *scene, const mcv_contribution *c, mcv_report *r) {
    static const char *const ways[] = {
#define MCV_X(WAY, word) word,
        MCV_WAYS(MCV_X)
#undef MCV_X
    };
    json_t *surfaces = json_array(), *path = json_array();
    json_array_append_new(path, place(c->sensor));
    for (uint32_t i = 0; i < c->surface_count && i < MCV_PATH_SURFACES; ++i) {
        const mcv_instance *instance = scene->instances + c->surfaces[i].instance;
        const char *material = scene->materials[instance->material].name;
        json_array_append_new(surfaces,
                              json_pack("{s:s, s:s, s:s}", "node", instance->name, "material",
                                        material ? material : "", "way", ways[c->surfaces[i].way]));
        json_array_append_new(path, place(c->surfaces[i].position));
    }
    if (!c->is_far) json_array_append_new(path, place(c->from));
    mcv_report_value(r, "surfaces", surfaces);
    mcv_report_value(r, "path", path);
}

/* The materials of a route's surfaces, each once. */
static void report_materials(const mcv_scene *scene, const mcv_contribution *c, mcv_report *r) {
    char text[256] = "";
    size_t length = 0;
    const uint32_t count =
        c->surface_count < MCV_PATH_SURFACES ? c->surface_count : MCV_PATH_SURFACES;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t material = scene->instances[c->surfaces[i].instance].material;
        const char *name = scene->materials[material].name;
        bool told = !name || !name[0];
        for (uint32_t k = 0; k < i && !told; ++k)
            told = scene->instances[c->surfaces[k].instance].material == material;
        if (told || length + strlen(name) + 3 > sizeof text) continue;
        length += (size_t)snprintf(text + length, sizeof text - length, "%s%s",
                                   length > 0 ? ", " : "", name);
    }
    if (length > 0) mcv_report_text(r, "materials", text);
}

/* The pixel of the emitter's image that brings the most. */
static void report_pixel(const mcv_route *route, mcv_report *r) {
    double share;
    const mcv_route_pixel *found = mcv_route_brightest(route, &share);
    if (!found) return;
    mcv_report_numbers(r, "emitter_pixel", "", ", ",
                       (const double[]){found->pixel[0], found->pixel[1]}, 2);
    mcv_report_number(r, "share_of_pixel", "", share);
}

static mcv_result report_route(const mcv_scene *scene, uint32_t sensor, const mcv_route *route,
                               mcv_report *r, mcv_error *error) {
    char *words = mcv_route_words(scene, sensor, route);
    const char *emitter = scene->emitters[route->strongest.emitter].name;
    if (!words) return mcv_fail(error, MCV_FAILED, "no memory for a route");
    mcv_report_element(r, words, mcv_emitter_types[scene->emitters[route->strongest.emitter].type]);
    mcv_report_quantity(r, "share", "", route->share, route->share_error);
    mcv_report_value(r, "emitter", json_string(emitter ? emitter : ""));
    report_materials(scene, &route->strongest, r);
    report_pixel(route, r);
    report_path(scene, &route->strongest, r);
    mcv_report_close(r);
    free(words);
    return MCV_OK;
}

/* Whether surfaces pass light on without spreading it. */
static bool has_smooth_surfaces(const mcv_scene *scene) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_material *m = scene->materials + scene->instances[i].material;
        if (mcv_is_mirror(m)) return true;
        if (mcv_material_has_medium(m->type) && !mcv_material_is_rough(m)) return true;
    }
    return false;
}

/* Without light paths nothing meets a light without extent behind smooth surfaces. */
static void tell_missing(const mcv_scene *scene, mcv_report *r) {
    char text[400];
    if (!has_smooth_surfaces(scene)) return;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *e = scene->emitters + i;
        if (e->type == MCV_EMITTER_ENVIRONMENT ||
            (mcv_emitter_has_surface(e->type) && e->type != MCV_EMITTER_COLLIMATED_BEAM))
            continue;
        snprintf(
            text, sizeof text,
            "light of emitter \"%.200s\" that smooth glass or mirrors bring to a surface is "
            "missing: it has no extent, and there are no light paths; `mcvisi render` has them",
            e->name ? e->name : "");
        mcv_report_tell(r, "note", text);
        return;
    }
}

static mcv_result report_routes(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                                const uint32_t pixel[2], uint64_t samples, const mcv_routes *routes,
                                mcv_report *r, mcv_error *error) {
    mcv_report_text(r, "scene", scene->path);
    mcv_report_numbers(r, "pixel", "", ", ", (const double[]){pixel[0], pixel[1]}, 2);
    mcv_report_number(r, "samples", "", (double)samples * MCV_ROUTE_REPLICATES);
    mcv_report_quantity(r, "value", mcv_rendered_unit(scene, sensor), routes->value,
                        routes->value_error);
    mcv_report_number(r, "route_count", "", (double)routes->count);
    if (routes->others_value > 0)
        mcv_report_number(r, "other_routes", "", routes->others_value / routes->value);
    mcv_report_list(r, "routes");
    for (size_t i = 0; i < routes->count && i < command->routes; ++i)
        MCV_TRY(report_route(scene, sensor, routes->items + i, r, error));
    mcv_report_close(r);
    if (command->explained) mcv_report_text(r, "page", command->explained);
    if (command->explained_svg) mcv_report_text(r, "drawing", command->explained_svg);
    return MCV_OK;
}

static mcv_result check_files(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                              mcv_error *error) {
    const char *svg = command->explained_svg;
    if (command->explained) MCV_TRY(mcv_output_check(command->explained, error));
    if (!svg) return MCV_OK;
    if (!mcv_ends_in(svg, ".svg"))
        return mcv_fail(error, MCV_USAGE, "--svg %s: must end in .svg", svg);
    if (!mcv_setup_is_known(scene, sensor))
        return mcv_fail(error, MCV_USAGE, "--svg: a sensor of type %s is not drawn",
                        mcv_sensor_types[scene->sensors[sensor].type]);
    return mcv_output_check(svg, error);
}

static mcv_result write_files(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                              const uint32_t pixel[2], const mcv_routes *routes, mcv_error *error) {
    if (command->explained)
        MCV_TRY(mcv_explain_page_write(command->explained, scene, sensor, pixel, routes,
                                       command->routes, error));
    return command->explained_svg ? mcv_explain_drawing_write(command->explained_svg, scene, sensor,
                                                              routes, command->routes, error)
                                  : MCV_OK;
}

mcv_result mcv_explain(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                       mcv_report *report, mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    mcv_routes routes = {0};
    uint32_t pixel[2];
    const uint64_t samples =
        (command->pixel_samples + MCV_ROUTE_REPLICATES - 1) / MCV_ROUTE_REPLICATES;
    MCV_TRY(read_pixel(command, pixel, error));
    MCV_TRY(check_files(command, scene, sensor, error));
    options.replicates = MCV_ROUTE_REPLICATES;
    options.last = 1; /* the number of samples is given apart */
    options.seed = (uint32_t)command->seed;
    options.depth = (uint32_t)command->depth;
    mcv_result result = mcv_reference_explain(scene, sensor, &options, pixel, samples,
                                              mcv_routes_add, &routes, error);
    if (result == MCV_OK) result = mcv_routes_finish(&routes, samples, error);
    if (result == MCV_OK) result = write_files(command, scene, sensor, pixel, &routes, error);
    if (result == MCV_OK) tell_missing(scene, report);
    if (result == MCV_OK)
        result = report_routes(command, scene, sensor, pixel, samples, &routes, report, error);
    mcv_routes_free(&routes);
    return result;
}
