/* SPDX-License-Identifier: Apache-2.0 */
/* MCVISI_defects: reads them and puts them onto the surfaces of the finished scene. */
#include "loader/loader.h"

#include "defects/defects.h"
#include "scene/memory.h"
#include "scene/params.h"
#include "scene/solid.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of a placed defect: in an array that doubles its room, and its name. */
enum { DEFECT_BYTES = 3 * sizeof(mcv_defect) + 256 };

/* An array of three numbers, or of lengths with units. */
static mcv_result read_three(const json_t *object, const char *key, bool lengths, double three[3],
                             const mcv_json_path *place, mcv_error *error) {
    const json_t *array = json_object_get(object, key);
    const mcv_json_path here = mcv_json_path_key(place, key);
    bool whole = json_array_size(array) == 3;
    for (size_t i = 0; i < 3 && whole; ++i) {
        const json_t *one = json_array_get(array, i);
        if (json_is_number(one))
            three[i] = json_number_value(one);
        else
            whole = lengths && json_is_string(one) &&
                    mcv_parse_quantity(json_string_value(one), MCV_PARAM_length, three + i);
    }
    return whole ? MCV_OK
                 : mcv_fail_at(&here, error,
                               lengths ? "must be three lengths, as in [\"12mm\", 0, 0.003]"
                                       : "must be three numbers, as in [1, 0, 0]");
}

static mcv_result read_triangle(const json_t *object, mcv_defect_site *site,
                                const mcv_json_path *place, mcv_error *error) {
    uint64_t triangle = 0;
    const mcv_json_path here = mcv_json_path_key(place, "barycentric");
    MCV_TRY(mcv_json_uint(object, "triangle", 0, INT32_MAX, &triangle, place, error));
    site->triangle = (uint32_t)triangle;
    for (int i = 0; i < 3; ++i) site->barycentric[i] = 1.0 / 3;
    if (!json_object_get(object, "barycentric")) return MCV_OK;
    MCV_TRY(read_three(object, "barycentric", false, site->barycentric, place, error));
    const double *b = site->barycentric, sum = b[0] + b[1] + b[2];
    if (!(b[0] >= 0 && b[1] >= 0 && b[2] >= 0 && fabs(sum - 1) < 1e-6))
        return mcv_fail_at(&here, error, "must be three numbers of at least 0 whose sum is 1");
    for (int i = 0; i < 3; ++i) site->barycentric[i] /= sum;
    return MCV_OK;
}

static mcv_result read_chance(const json_t *object, size_t index, mcv_chance *chance,
                              const mcv_json_path *place, mcv_error *error) {
    uint64_t seed = 0;
    chance->count = 0;
    chance->density = 0;
    MCV_TRY(mcv_json_uint(object, "seed", 0, UINT32_MAX, &seed, place, error));
    MCV_TRY(mcv_json_uint(object, "count", 1, 1000, &chance->count, place, error));
    MCV_TRY(mcv_json_number(object, "density", DBL_MIN, DBL_MAX, &chance->density, place, error));
    if (chance->count && chance->density > 0)
        return mcv_fail_at(place, error, "must have a \"count\" or a \"density\", not both");
    /* Entries with one seed lie in other places. */
    chance->state = seed << 32 ^ index;
    return MCV_OK;
}

static mcv_result read_site(const json_t *object, bool by_chance, mcv_defect_site *site,
                            const mcv_json_path *place, mcv_error *error) {
    const bool at = json_object_get(object, "at"), triangle = json_object_get(object, "triangle");
    *site = (mcv_defect_site){.by_point = at};
    MCV_TRY(mcv_json_string(object, "node", &site->node, place, error));
    if (!site->node) return mcv_fail_at(place, error, "must have a \"node\", by name");
    if (by_chance && (at || triangle))
        return mcv_fail_at(place, error, "lies by chance: leave out \"%s\"",
                           at ? "at" : "triangle");
    if (!by_chance && at == triangle)
        return mcv_fail_at(place, error, "must have a point \"at\" or a \"triangle\"%s",
                           at ? ", not both" : "");
    if (json_object_get(object, "direction"))
        MCV_TRY(read_three(object, "direction", false, site->direction, place, error));
    if (by_chance) return MCV_OK;
    return at ? read_three(object, "at", true, site->at, place, error)
              : read_triangle(object, site, place, error);
}

/* What all entries need: how many bodies the defects inside of others will be, and what is known of
 * the meshes, which stay as they are meanwhile. */
typedef struct placing {
    mcv_loader *loader;
    uint32_t bodies;
    mcv_known_meshes known;
} placing;

/* A thousand entries of a thousand defects each are a small file. What they take is told as each is
 * placed. */
static mcv_result keep_defect(placing *to, const mcv_defect *defect, const mcv_json_path *place,
                              mcv_error *error) {
    mcv_scene *scene = to->loader->scene;
    mcv_memory *memory = to->loader->memory;
    to->bodies += mcv_defect_bodies(defect);
    if (scene->solid_count + to->bodies > MCV_MAX_SOLIDS)
        return mcv_fail_at(place, error, "more than %d bodies with exact surfaces", MCV_MAX_SOLIDS);
    MCV_TRY(mcv_memory_take(memory, &memory->geometry, DEFECT_BYTES, place, error));
    return mcv_scene_add_defect(scene, defect, error);
}

/* Places one defect by its site, or several by chance. */
static mcv_result place_defects(placing *to, const mcv_defect_site *site, mcv_chance *chance,
                                mcv_defect *defect, const mcv_json_path *place, mcv_error *error) {
    const mcv_scene *scene = to->loader->scene;
    const char *name = defect->name;
    uint64_t count = 0;
    if (!chance->count && !(chance->density > 0)) {
        MCV_TRY((mcv_defect_is_inside(defect->type) ? mcv_defect_locate_inside : mcv_defect_locate)(
            scene, site, defect, place, error));
        return keep_defect(to, defect, place, error);
    }
    chance->known = &to->known;
    MCV_TRY(mcv_chance_count(scene, site->node, chance, &count, place, error));
    for (uint64_t i = 0; i < count; ++i) {
        char numbered[256];
        snprintf(numbered, sizeof numbered, "%.200s-%u", name, (unsigned)(i + 1));
        defect->name = numbered;
        MCV_TRY(mcv_chance_locate(scene, site, chance, defect, place, error));
        MCV_TRY(keep_defect(to, defect, place, error));
    }
    return MCV_OK;
}

/* Reads an entry and finds its places. */
static mcv_result define_entry(placing *to, const json_t *object, size_t index,
                               const mcv_json_path *place, mcv_error *error) {
    static const char *const others[] = {
        "name",  "type",    "node", "at",     "triangle",   "barycentric", "direction",
        "count", "density", "seed", "extras", "extensions", NULL};
    static const char *const of_stain[] = {
        "name",      "type",  "node",    "at",   "triangle", "barycentric", "material",
        "direction", "count", "density", "seed", "extras",   "extensions",  NULL};
    static const char *const of_inclusion[] = {"name",     "type",       "node",  "at",
                                               "material", "direction",  "count", "seed",
                                               "extras",   "extensions", NULL};
    mcv_defect defect = {.name = (char *)mcv_json_name(object)};
    mcv_defect_params params;
    mcv_defect_site site;
    mcv_chance chance = {0};
    MCV_TRY(
        mcv_element_type(object, mcv_defect_types, MCV_DEFECT_COUNT, &defect.type, place, error));
    const mcv_param_table table = mcv_defect_table(defect.type);
    const bool inclusion = defect.type == MCV_DEFECT_INCLUSION,
               material = mcv_defect_takes_material(defect.type);
    mcv_params_set_defaults(table, &params);
    MCV_TRY(mcv_params_parse(table, object,
                             inclusion  ? of_inclusion
                             : material ? of_stain
                                        : others,
                             &params, place, error));
    MCV_TRY(mcv_params_check(table, &params, place, error));
    MCV_TRY(mcv_defect_resolve(&defect, &params, place, error));
    MCV_TRY(read_chance(object, index, &chance, place, error));
    MCV_TRY(read_site(object, chance.count || chance.density > 0, &site, place, error));
    if (material)
        MCV_TRY(
            mcv_load_find_material(to->loader, object, "material", &defect.material, place, error));
    if (material && defect.material == MCV_NONE)
        return mcv_fail_at(place, error, "must have a \"material\" of the file, by name or index");
    if (mcv_defect_is_inside(defect.type) && chance.density > 0)
        return mcv_fail_at(place, error, "lies inside of its body: give a \"count\"");
    return place_defects(to, &site, &chance, &defect, place, error);
}

/* A size as on drawings becomes a length; how many there are is `count` where none has a place. */
static mcv_result define(placing *to, const json_t *object, size_t index,
                         const mcv_json_path *place, mcv_error *error) {
    const char *text = json_string_value(json_object_get(object, "size"));
    const mcv_json_path here = mcv_json_path_key(place, "size");
    uint32_t type;
    uint64_t count;
    double size;
    if (!text || !mcv_defect_is_notation(text))
        return define_entry(to, object, index, place, error);
    MCV_TRY(mcv_element_type(object, mcv_defect_types, MCV_DEFECT_COUNT, &type, place, error));
    MCV_TRY(mcv_defect_read_notation(text, type, &size, &count, &here, error));
    json_t *own = json_copy((json_t *)object);
    if (!own || json_object_set_new(own, "size", json_real(size)) != 0) {
        json_decref(own);
        return mcv_fail_memory(place, error);
    }
    static const char *const places[] = {"at", "triangle", "count", "density"};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i)
        if (json_object_get(object, places[i])) count = 0;
    if (count) json_object_set_new(own, "count", json_integer((json_int_t)count));
    const mcv_result result = define_entry(to, own, index, place, error);
    json_decref(own);
    return result;
}

static mcv_result define_all(mcv_loader *loader, const json_t *array, const mcv_json_path *place,
                             mcv_error *error) {
    placing to = {.loader = loader};
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < json_array_size(array) && result == MCV_OK; ++i) {
        const json_t *object = json_array_get(array, i);
        const mcv_json_path here = mcv_json_path_element(place, mcv_json_name(object), i);
        result = define(&to, object, i, &here, error);
    }
    mcv_known_meshes_free(&to.known);
    return result;
}

/* A surface that gets a defect becomes a mesh, which can be changed. */
static mcv_result make_meshes(mcv_loader *loader, const json_t *object, const mcv_json_path *place,
                              mcv_error *error) {
    const mcv_placement *node = NULL;
    const char *name = NULL;
    uint32_t type;
    const mcv_json_path here = mcv_json_path_key(place, "node");
    MCV_TRY(mcv_element_type(object, mcv_defect_types, MCV_DEFECT_COUNT, &type, place, error));
    MCV_TRY(mcv_json_string(object, "node", &name, place, error));
    if (!name || mcv_defect_is_inside(type)) return MCV_OK; /* define() tells what is missing */
    const mcv_result found = mcv_defect_node(loader->scene, name, &node, place, error);
    if (found != MCV_OK || !node) return found;
    /* Three indices, and position and normal of half a vertex. */
    const uint64_t bytes = MCV_TRIANGLE_BYTES + 3 * sizeof(uint32_t) + 3 * sizeof(float);
    MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->geometry,
                            bytes * mcv_scene_solid_triangles(loader->scene, node->instances),
                            &here, error));
    return mcv_scene_mesh_solids(loader->scene, node->instances, &here, error);
}

static mcv_result apply_all(mcv_scene *scene, const mcv_json_path *place, mcv_error *error) {
    mcv_known_meshes known = {0};
    mcv_result result = MCV_OK;
    for (uint32_t i = 0; i < scene->defect_count && result == MCV_OK; ++i) {
        const mcv_defect defect = scene->defects[i];
        const mcv_json_path here = mcv_json_path_element(place, defect.name, i);
        result = mcv_defect_apply_known(scene, &known, &defect, &here, error);
    }
    if (result == MCV_OK && scene->defect_count > 0)
        result = mcv_defects_finish(scene, &known, place, error);
    mcv_known_meshes_free(&known);
    return result;
}

/* All are placed before the first one changes the surface. */
mcv_result mcv_load_defects(mcv_loader *loader, mcv_error *error) {
    json_t *array;
    MCV_TRY(mcv_load_array(loader, "MCVISI_defects", "defects", &array, error));
    const mcv_json_path place = mcv_json_path_key(&loader->file, "defects");
    for (size_t i = 0; i < json_array_size(array); ++i) {
        const json_t *object = json_array_get(array, i);
        const mcv_json_path here = mcv_json_path_element(&place, mcv_json_name(object), i);
        MCV_TRY(make_meshes(loader, object, &here, error));
    }
    MCV_TRY(define_all(loader, array, &place, error));
    return apply_all(loader->scene, &place, error);
}
