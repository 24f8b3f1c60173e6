/* SPDX-License-Identifier: Apache-2.0 */
/* The part that a rig is for: its file, its box and its material. */
#include "rig/rig_part.h"

#include "check/facets.h"
#include "core/basics.h"
#include "loader/load.h"
#include "loader/load_stl.h"
#include "scene/materials.h"
#include "scene/params.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void add_points(mcv_rig_design *r, const mcv_mesh *mesh, const mcv_transform *to_world,
                       double unit) {
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        const float *from = mesh->positions + 3 * v;
        double world[3];
        mcv_transform_point(to_world, (const double[3]){from[0], from[1], from[2]}, world);
        for (int i = 0; i < 3; ++i) {
            r->lower[i] = fmin(r->lower[i], unit * world[i]);
            r->upper[i] = fmax(r->upper[i], unit * world[i]);
        }
    }
    r->triangles += mesh->triangle_count;
}

/* The scene of an .stl file, whose lengths stay in its unit. */
static mcv_result add_solid(mcv_scene *scene, double size[3], mcv_error *error) {
    const mcv_json_path place = mcv_place_file(scene->path);
    mcv_material plain = {.name = "", .type = MCV_MATERIAL_DIFFUSE, .texture = MCV_NONE};
    mcv_instance part = {.name = "part", .emitter = MCV_NONE, .to_world = mcv_transform_identity()};
    mcv_bytes bytes;
    MCV_TRY(mcv_file_read(scene->path, &bytes, &place, error));
    const mcv_result result =
        mcv_load_stl(scene, bytes, part.name, &part.mesh, size, &place, error);
    free(bytes.data);
    MCV_TRY(result);
    mcv_params_set_defaults(mcv_material_table(plain.type), &plain.as);
    MCV_TRY(mcv_scene_add_material(scene, &plain, error));
    return mcv_scene_add_instance(scene, &part, error);
}

/* The part as a scene; the caller frees it. size: of an .stl file's box. */
static mcv_result open_part(const mcv_rig_design *r, mcv_scene **scene, double size[3],
                            mcv_error *error) {
    const char *path = r->wishes.part;
    const mcv_json_path place = mcv_place_file(path);
    if (!r->stl) return mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, error);
    *scene = mcv_scene_new(path);
    if (!*scene) return mcv_fail_memory(&place, error);
    const mcv_result result = add_solid(*scene, size, error);
    if (result != MCV_OK) mcv_scene_free(*scene);
    return result;
}

static bool passes_light(const mcv_material *material) {
    return mcv_material_has_medium(material->type) || mcv_material_is_plate(material->type) ||
           (material->type == MCV_MATERIAL_METALLIC_ROUGHNESS &&
            material->as.metallic_roughness.transmission > 0);
}

static mcv_result read_part(mcv_rig_design *r, double unit, mcv_error *error) {
    const char *path = r->wishes.part;
    mcv_scene *scene;
    double size[3] = {0};
    MCV_TRY(open_part(r, &scene, size, error));
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *instance = scene->instances + i;
        const mcv_mesh *mesh = scene->meshes + instance->mesh;
        add_points(r, mesh, &instance->to_world, unit);
        r->passes_light = r->passes_light || passes_light(scene->materials + instance->material);
        r->has_normals = r->has_normals || mesh->normals;
    }
    mcv_scene_free(scene);
    if (r->stl && !r->wishes.unit)
        return mcv_fail(
            error, MCV_USAGE,
            "%s: an .stl file does not state its unit: the part is %.4g x %.4g x %.4g units "
            "large; give --unit; most files use mm",
            path, size[0], size[1], size[2]);
    return r->triangles ? MCV_OK : mcv_fail(error, MCV_BAD_INPUT, "%s: has no mesh", path);
}

mcv_result mcv_rig_read_part(mcv_rig_design *r, mcv_error *error) {
    const char *path = r->wishes.part, *unit_name = r->wishes.unit;
    double unit = 1, largest = 0;
    char one[32];
    r->stl = mcv_ends_in(path, ".stl");
    for (int i = 0; i < 3; ++i) r->lower[i] = INFINITY, r->upper[i] = -INFINITY;
    if (!r->stl && !mcv_ends_in(path, ".glb") && !mcv_ends_in(path, ".gltf"))
        return mcv_fail(error, MCV_USAGE, "%s: must be a .gltf, .glb or .stl file: %s", path,
                        mcv_conversion(path));
    if (unit_name) {
        snprintf(one, sizeof one, "1%.16s", unit_name);
        if (!isalpha((unsigned char)unit_name[0]) ||
            !mcv_parse_quantity(one, MCV_PARAM_length, &unit))
            return mcv_fail(error, MCV_USAGE, "--unit %s: must be one of nm, um, mm, cm, m, inch",
                            unit_name);
    }
    MCV_TRY(read_part(r, unit, error));
    for (int i = 0; i < 3; ++i) largest = fmax(largest, r->upper[i] - r->lower[i]);
    return largest > 0 ? MCV_OK
                       : mcv_fail(error, MCV_BAD_INPUT, "%s: its vertices are all one point", path);
}

/* --- its material --- */

int mcv_rig_word_index(const char *word, const char *const *words) {
    for (int i = 0; words[i]; ++i)
        if (strcmp(word, words[i]) == 0) return i;
    return -1;
}

/* Types without required parameters; diffuse is as grey as the default. */
static const char *const plain_types[] = {
    "diffuse", "dielectric", "mirror", "absorber", "retroreflector", "metallicRoughness", NULL};

static mcv_result fail_material(const char *name, mcv_error *error) {
    const char *const *const lists[] = {mcv_param_options("metal"), mcv_param_options("glass") + 1,
                                        plain_types};
    const char *words[64];
    char list[1024] = "";
    size_t n = 0;
    for (int k = 0; k < 3; ++k)
        for (int i = 0; lists[k][i] && n < 64; ++i) {
            words[n++] = lists[k][i];
            snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s",
                     i   ? ", "
                     : k ? "; "
                         : "",
                     lists[k][i]);
        }
    const char *nearest = mcv_nearest_word(name, words, n);
    char metals[256];
    if (mcv_is_metal(name, metals) && !(nearest && mcv_is_metal(nearest, metals)))
        return mcv_fail(error, MCV_USAGE, "--material %s: there is none: %s", name, metals);
    if (nearest)
        return mcv_fail(error, MCV_USAGE,
                        "--material %s: there is no such material: did you mean %s?", name,
                        nearest);
    return mcv_fail(error, MCV_USAGE, "--material %s: there is no such material: known are %s",
                    name, list);
}

/* Normals for glass or a mirror whose file has flat triangles only. */
static mcv_result choose_normals(mcv_rig_design *r, bool clear, mcv_error *error) {
    mcv_scene *scene;
    mcv_result result = MCV_OK;
    mcv_bend_range range = {0, INFINITY};
    double size[3] = {0};
    if (!clear || r->has_normals) return MCV_OK;
    MCV_TRY(open_part(r, &scene, size, error));
    for (uint32_t i = 0; i < scene->instance_count && result == MCV_OK; ++i) {
        mcv_facets facets;
        result = mcv_facets_of(scene, i, &facets, error);
        if (result != MCV_OK) break;
        const mcv_bend_range of_mesh = mcv_facets_range(&facets);
        mcv_facets_free(&facets);
        range.curved = fmax(range.curved, of_mesh.curved);
        range.edge = fmin(range.edge, of_mesh.edge);
    }
    mcv_scene_free(scene);
    r->crease = mcv_crease_degrees(range);
    return result;
}

mcv_result mcv_rig_choose_material(mcv_rig_design *r, mcv_error *error) {
    const char *name = r->wishes.material;
    const size_t room = sizeof r->material;
    bool clear = false;
    const bool transparent = r->wishes.kind == MCV_RIG_TRANSPARENT;
    /* CAD exports glass as opaque as steel. */
    if (!name && !r->stl && (!transparent || r->passes_light))
        return choose_normals(r, r->passes_light, error);
    if (!name) name = transparent ? "N-BK7" : "diffuse";
    if (mcv_rig_word_index(name, mcv_param_options("metal")) >= 0) {
        snprintf(r->material, room,
                 "{\"type\": \"conductor\", \"metal\": \"%s\", \"roughness\": 0.3}", name);
    } else if (mcv_rig_word_index(name, mcv_param_options("glass")) > 0) {
        snprintf(r->material, room, "{\"type\": \"dielectric\", \"glass\": \"%s\"}", name);
        clear = true;
    } else if (strcmp(name, "diffuse") == 0) {
        snprintf(r->material, room, "{\"type\": \"diffuse\", \"reflectance\": 0.5}");
    } else if (mcv_rig_word_index(name, plain_types) >= 0) {
        snprintf(r->material, room, "{\"type\": \"%s\"}", name);
        clear = strcmp(name, "dielectric") == 0 || strcmp(name, "mirror") == 0;
    } else {
        return fail_material(name, error);
    }
    return choose_normals(r, clear, error);
}
