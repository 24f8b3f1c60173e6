/* SPDX-License-Identifier: Apache-2.0 */
/* Nodes: places each with its meshes, emitters, sensors and assets, then its children. */
#include "loader/loader.h"

#include "scene/materials.h"
#include "scene/memory.h"
#include "scene/transform.h"

static mcv_result place_mesh(mcv_loader *loader, const mcv_instance *instance,
                             const mcv_json_path *place, mcv_error *error) {
    const uint64_t triangles = loader->scene->meshes[instance->mesh].triangle_count;
    if (instance->moves && loader->scene->part_motion.rate != 0 &&
        mcv_material_roughness(&loader->scene->materials[instance->material]).anisotropy > 0)
        return mcv_fail_at(place, error,
                           "turns and is brushed: give it no anisotropy, or let the sensor turn");
    MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->geometry,
                            MCV_TRIANGLE_BYTES * triangles, place, error));
    return mcv_scene_add_instance(loader->scene, instance, error);
}

/* Places the document of an asset below its node. */
static mcv_result place_asset(mcv_loader *asset, const char *name, const mcv_transform *to_world,
                              const mcv_json_path *place, mcv_error *error) {
    mcv_transform scaled = *to_world;
    for (int i = 0; i < 9; ++i) scaled.m[i] *= asset->unit;
    if (asset->solid != MCV_NONE) {
        const mcv_instance instance = {.name = (char *)name,
                                       .mesh = asset->solid,
                                       .material = asset->asset_material,
                                       .emitter = MCV_NONE,
                                       .moves = asset->moves,
                                       .to_world = scaled};
        return place_mesh(asset, &instance, place, error);
    }
    return mcv_load_nodes(asset, &scaled, error);
}

/* Whether the node has brought something that cannot move. */
static mcv_result check_moving(const mcv_loader *loader, const uint32_t before[3],
                               const mcv_json_path *place, mcv_error *error) {
    const mcv_scene *scene = loader->scene;
    if (!loader->moves) return MCV_OK;
    if (scene->emitter_count > before[0])
        return mcv_fail_at(place, error, "moves, but lights stand still: put them on another node");
    if (scene->sensor_count > before[1])
        return mcv_fail_at(place, error,
                           "is a sensor on a part that moves: give it an MCVISI_motion of its own, "
                           "on a node beside");
    if (scene->solid_count > before[2])
        return mcv_fail_at(place, error, "moves, but exact surfaces stand still: make it a mesh");
    return MCV_OK;
}

/* `document`: the frame of the document's root in the world. `material`: replaces those of the
 * node, unless it is MCV_NONE. */
static mcv_result load_node(mcv_loader *loader, uint32_t index, const mcv_transform *document,
                            const mcv_transform *parent, uint32_t material, mcv_error *error) {
    const json_t *nodes = json_object_get(loader->root, "nodes"),
                 *node = json_array_get(nodes, index);
    const mcv_json_path place = mcv_json_path_key(&loader->file, "nodes"),
                        here = mcv_json_path_element(&place, mcv_json_name(node), index);
    mcv_transform local;
    bool posed;
    MCV_TRY(mcv_load_pose(loader, node, 0, &posed, &local, &here, error));
    if (!posed) MCV_TRY(mcv_load_local(node, &local, &here, error));
    MCV_TRY(mcv_load_misalignment(node, &local, &here, error));
    const mcv_transform to_world = mcv_transform_compose(posed ? document : parent, &local);
    const uint32_t frame = loader->scene->frame_count;
    MCV_TRY(mcv_scene_check_extent(&to_world, (const double[]){1, 1, 1}, &here, error));
    MCV_TRY(mcv_scene_add_frame(loader->scene, mcv_json_name(node), loader->is_asset, &to_world,
                                error));
    const bool named = loader->scene->frame_count > frame;
    const uint32_t first = loader->scene->instance_count;
    const uint32_t before[3] = {loader->scene->emitter_count, loader->scene->sensor_count,
                                loader->scene->solid_count};
    const bool moved = loader->moves;
    uint32_t mesh;
    MCV_TRY(mcv_load_part_motion(loader, node, &here, error));
    if (loader->node_materials && loader->node_materials[index] != MCV_NONE)
        material = loader->node_materials[index];
    MCV_TRY(mcv_json_index(node, "mesh", json_array_size(json_object_get(loader->root, "meshes")),
                           "meshes", &mesh, &here, error));
    if (mesh != MCV_NONE) {
        MCV_TRY(mcv_load_mesh(loader, mesh, error));
        const mcv_loaded_mesh *loaded = loader->meshes + mesh;
        for (uint32_t i = 0; i < loaded->count; ++i) {
            const mcv_instance instance = {.name = (char *)mcv_json_name(node),
                                           .mesh = loaded->first + i,
                                           .material = material == MCV_NONE ? loaded->materials[i]
                                                                            : material,
                                           .moves = loader->moves,
                                           .to_world = to_world};
            MCV_TRY(place_mesh(loader, &instance, &here, error));
        }
    }
    MCV_TRY(mcv_load_emitter(loader, node, &to_world, first, loader->scene->instance_count, &here,
                             error));
    MCV_TRY(mcv_load_body(loader, node, &to_world, &here, error));
    MCV_TRY(mcv_load_light(loader, node, &to_world, &here, error));
    MCV_TRY(mcv_load_sensors(loader, node, &to_world, &here, error));
    mcv_loader *asset;
    MCV_TRY(mcv_load_asset_of(loader, node, &asset, &here, error));
    MCV_TRY(check_moving(loader, before, &here, error));
    if (asset) asset->moves = loader->moves;
    if (asset) MCV_TRY(place_asset(asset, mcv_json_name(node), &to_world, &here, error));
    const json_t *children = json_object_get(node, "children");
    for (size_t i = 0; i < json_array_size(children); ++i)
        MCV_TRY(load_node(loader, (uint32_t)json_number_value(json_array_get(children, i)),
                          document, &to_world, material, error));
    loader->moves = moved;
    if (!named) return MCV_OK;
    loader->scene->frames[frame].instances[0] = first;
    loader->scene->frames[frame].instances[1] = loader->scene->instance_count;
    return MCV_OK;
}

mcv_result mcv_load_nodes(mcv_loader *loader, const mcv_transform *document, mcv_error *error) {
    const json_t *scenes = json_object_get(loader->root, "scenes"),
                 *scene = json_object_get(loader->root, "scene");
    const json_t *nodes =
        json_object_get(json_array_get(scenes, (size_t)json_number_value(scene)), "nodes");
    for (size_t i = 0; i < json_array_size(nodes); ++i)
        MCV_TRY(load_node(loader, (uint32_t)json_number_value(json_array_get(nodes, i)), document,
                          document, MCV_NONE, error));
    return MCV_OK;
}
