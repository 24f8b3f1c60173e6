/* SPDX-License-Identifier: Apache-2.0 */
/* The part that a rig is for: its file, its box and its material. */
#include "rig/rig_part.h"

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

static mcv_result read_stl(mcv_rig_design *r, double unit, mcv_error *error) {
    const char *path = r->wishes.part;
    const mcv_json_path place = mcv_place_file(path);
    const mcv_transform identity = mcv_transform_identity();
    mcv_bytes bytes;
    uint32_t mesh;
    double size[3];
    mcv_scene *scene = mcv_scene_new(path);
    if (!scene) return mcv_fail_memory(&place, error);
    mcv_result result = mcv_file_read(path, &bytes, &place, error);
    if (result == MCV_OK) {
        result = mcv_load_stl(scene, bytes, "part", &mesh, size, &place, error);
        free(bytes.data);
    }
    if (result == MCV_OK) add_points(r, scene->meshes + mesh, &identity, unit);
    mcv_scene_free(scene);
    if (result == MCV_OK && !r->wishes.unit)
        return mcv_fail(
            error, MCV_USAGE,
            "%s: an .stl file does not state its unit: the part is %.4g x %.4g x %.4g units "
            "large; give --unit; most files use mm",
            path, size[0], size[1], size[2]);
    return result;
}

static bool passes_light(const mcv_material *material) {
    return mcv_material_has_medium(material->type) || mcv_material_is_plate(material->type) ||
           (material->type == MCV_MATERIAL_METALLIC_ROUGHNESS &&
            material->as.metallic_roughness.transmission > 0);
}

static mcv_result read_gltf(mcv_rig_design *r, double unit, mcv_error *error) {
    mcv_scene *scene;
    MCV_TRY(mcv_scene_load(r->wishes.part, (mcv_overrides){NULL, 0}, &scene, error));
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *instance = scene->instances + i;
        add_points(r, scene->meshes + instance->mesh, &instance->to_world, unit);
        r->passes_light = r->passes_light || passes_light(scene->materials + instance->material);
        r->has_normals = r->has_normals || scene->meshes[instance->mesh].normals;
    }
    mcv_scene_free(scene);
    return r->triangles ? MCV_OK
                        : mcv_fail(error, MCV_BAD_INPUT, "%s: has no mesh", r->wishes.part);
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
    MCV_TRY(r->stl ? read_stl(r, unit, error) : read_gltf(r, unit, error));
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

mcv_result mcv_rig_choose_material(mcv_rig_design *r, mcv_error *error) {
    const char *name = r->wishes.material;
    const size_t room = sizeof r->material;
    bool clear = false;
    const bool transparent = r->wishes.kind == MCV_RIG_TRANSPARENT;
    /* CAD exports glass as opaque as steel. */
    if (!name && !r->stl && (!transparent || r->passes_light)) {
        r->needs_normals = r->passes_light && !r->has_normals;
        return MCV_OK;
    }
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
    r->needs_normals = clear && !r->has_normals;
    return MCV_OK;
}
