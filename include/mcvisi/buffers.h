/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The list of a scene's buffers on the device. It makes the kernel arguments (kernels/world.h), the
 * members of the host's mcv_device_scene, and the code that fills them. A new buffer is one line
 * here.
 *
 * X(space, type, name, "words", bytes, data): a buffer in `space` with elements of `type`, const
 * unless kernels write it. Only the host reads the last three: the name in messages, the size and
 * the contents, written in the variables of fill_buffers (host/device/device_scene.c). Size 0: the
 * scene does not need the buffer, and kernels get NULL. Data NULL: the contents are written for
 * each sensor or launch.
 */
#ifndef MCVISI_BUFFERS_H
#define MCVISI_BUFFERS_H

#define MCV_BUFFERS(X) \
    X(__constant, const mcv_frame, frame, "the frame", sizeof(mcv_frame), NULL) \
    X(__constant, const mcv_sensor, sensor, "the sensor", sizeof(any_sensor), NULL) \
    X(__global, const mcv_node, nodes, "the nodes of the acceleration structure", \
      bvh->node_count * sizeof *bvh->nodes, bvh->nodes) \
    X(__global, const mcv_leaf, leaves, "the leaves of the acceleration structure", \
      bvh->leaf_count * sizeof *bvh->leaves, bvh->leaves) \
    /* Three vertices and the instance. */ \
    X(__global, const uint4, triangles, "the triangles", 16 * triangles, p->triangles) \
    X(__global, const float, positions, "the vertices", 12 * vertices, p->positions) \
    X(__global, const float, normals, "the normals", present(p->normals, 12 * vertices), \
      p->normals) \
    X(__global, const float, texcoords, "the texture coordinates", \
      present(p->texcoords, 8 * p->texcoord_sets * vertices), p->texcoords) \
    /* Direction, and the handedness of its bitangent. */ \
    X(__global, const float, tangents, "the tangents", present(p->tangents, 16 * vertices), \
      p->tangents) \
    X(__global, const mcv_device_instance, instances, "the instances", \
      p->instance_count * sizeof *p->instances, p->instances) \
    X(__global, const mcv_device_material, materials, "the materials", \
      p->material_count * sizeof *p->materials, p->materials) \
    X(__global, const mcv_device_glossy, glossy, "the glossy materials", \
      present(p->glossy, p->material_count * sizeof *p->glossy), p->glossy) \
    X(__global, const float, albedos, "the albedos of microfacets", 4 * p->albedo_count, \
      p->albedos) \
    X(__global, const mcv_device_medium, medium_table, "the media", \
      tables * sizeof p->medium_table[0], p->medium_table) \
    X(__global, const mcv_device_interface, interfaces, "the interfaces", \
      tables * sizeof p->interfaces[0], p->interfaces) \
    /* Where the albedos of a rough interface begin; MCV_NONE: it is smooth. */ \
    X(__global, const uint, interface_albedos, "the rough interfaces", \
      dielectric && p->glossy ? sizeof p->interface_albedos : 0, p->interface_albedos) \
    X(__global, const mcv_contact_grid, contact_grid, "where bodies may touch", \
      present(p->contact_grid, sizeof *p->contact_grid), p->contact_grid) \
    X(__global, const mcv_device_emitter, emitters, "the emitters", \
      p->emitter_count * sizeof *p->emitters, p->emitters) \
    /* Cumulative shares, 2^31 = 1: of the emitters; of each one's triangles, of the rows and \
     * pixels of a sky or of the columns of a laser's fan; of the emitters for light paths. */ \
    X(__global, const uint, emitter_cdf, "the emitters' shares", \
      p->emitter_count > 0 ? 4 * p->cdf_count : 0, p->emitter_cdf) \
    X(__global, const mcv_light_node, light_tree, "the light tree", \
      present(p->light_tree, p->light_node_count * sizeof *p->light_tree), p->light_tree) \
    X(__global, const mcv_device_texture, textures, "the list of textures", \
      textures ? p->texture_count * sizeof *p->textures : 0, p->textures) \
    /* RGBA, 8 bits each, or three floats. */ \
    X(__global, const uint, texels, "the textures", textures ? 4 * p->texel_count : 0, p->texels) \
    /* Of the pixels, row by row; made by mcv_device_scene_place. */ \
    X(__global, const mcv_device_pupil_guide, pupil_guides, "the pupil guides", 0, NULL) \
    /* The pixels of a launch where the frame has them listed; made by the renderer. */ \
    X(__global, const uint, listed, "the listed pixels", 0, NULL) \
    X(__global, const mcv_device_solid, solids, "the exact surfaces", \
      present(p->solids, p->solid_count * sizeof *p->solids), p->solids) \
    X(__global, const MCV_PRECISE_SOLID, precise_solids, "the exact surfaces in double", \
      present(p->precise_solids, p->solid_count * sizeof *p->precise_solids), p->precise_solids) \
    /* What rounding leaves of positions and normals. */ \
    X(__global, const float, position_lows, "the low words of the vertices", \
      present(p->position_lows, 12 * vertices), p->position_lows) \
    X(__global, const float, normal_lows, "the low words of the normals", \
      present(p->normal_lows, 12 * vertices), p->normal_lows) \
    /* Of the media. */ \
    X(__global, const MCV_DOUBLE, refractive_indices, "the refractive indices", \
      mixed ? sizeof p->refractive_indices : 0, p->refractive_indices) \
    /* Their count, then the records of a launch (kernels/stage/record_light.h); made by the \
     * renderer. */ \
    X(__global, uint, records, "the records of a launch", 0, NULL)

#endif
