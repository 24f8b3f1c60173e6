/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's rows for what a stage asks of the surfaces that paths have hit: place and
 * normals, reflectance, random numbers, the direction of a diffuse reflection. The paths lie in the
 * order of their classes (schedule/ranges.h). */
#ifndef MCVISI_KERNELS_SURFACE_ROWS_H
#define MCVISI_KERNELS_SURFACE_ROWS_H

#include "schedule/tile.h"

#include "geometry/path_interaction.h"
#include "path/identity.h"
#include "schedule/ranges.h"
#include "schedule/small_scene_cache.h"
#include "schedule/vectorize.h"

MCV_BATCH void mcv_find_triangles(mcv_world world, uint *paths, uint first, uint last) {
    MCV_VECTORIZE_MASKED
    MCV_EACH_PATH (slot, paths, first, last) mcv_find_triangle(world, slot);
}

MCV_LOOP_FUNCTION int mcv_hits_quadric(mcv_world world, uint hit) {
    return mcv_is_quadric(world.solids + mcv_solid_of(hit), mcv_piece_of(hit));
}

/* Quadrics run as a loop; if all paths have hit the same piece, its values are read once. */
MCV_BATCH void mcv_find_exacts(mcv_world world, uint *paths, uint first, uint last) {
    const uint *hits = paths + (MCV_PATH_hit + 3) * MCV_ROW;
    const uint piece = hits[first];
    uint others = 0, quadrics = 0;
    if (first == last) return;
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) others += hits[i] != piece;
    if (others == 0u)
        quadrics = mcv_hits_quadric(world, piece) ? last - first : 0u;
    else
        for (uint i = first; i < last; ++i) quadrics += (uint)mcv_hits_quadric(world, hits[i]);
    if (quadrics > 0 && others == 0u) {
        MCV_VECTORIZE_MASKED
        MCV_EACH_PATH (slot, paths, first, last) mcv_find_exact(world, slot, piece, 1);
    } else if (quadrics > 0) {
        MCV_VECTORIZE_MASKED
        MCV_EACH_PATH (slot, paths, first, last) mcv_find_exact(world, slot, hits[slot.index], 1);
    }
    if (quadrics == last - first) return;
    MCV_EACH_PATH (slot, paths, first, last)
        if (!mcv_hits_quadric(world, hits[slot.index]))
            mcv_find_exact(world, slot, hits[slot.index], 0);
}

MCV_BATCH void mcv_find_surfaces(mcv_world world, uint *paths, const uint *class_end) {
    const uint first_end = class_end[MCV_LAST_SMOOTH_TRIANGLE],
               second = class_end[MCV_LAST_KNOWN_EXACT], second_end = class_end[MCV_LAST_TRIANGLE];
#if MCV_FACETS_CACHED
    if (world.frame->triangle_count - 1u < MCV_CACHED &&
        class_end[MCV_LAST_CLASS] >= 2 * MCV_CACHED) {
        mcv_facet_table table;
        mcv_fill_facets(world, &table);
        mcv_find_cached_triangles(paths, &table, 0, first_end);
        mcv_find_cached_triangles(paths, &table, second, second_end);
    } else
#endif
    {
        mcv_find_triangles(world, paths, 0, first_end);
        mcv_find_triangles(world, paths, second, second_end);
    }
    if (!MCV_WITH_SURFACES) return;
    mcv_find_exacts(world, paths, first_end, class_end[MCV_LAST_SMOOTH]);
    mcv_find_exacts(world, paths, class_end[MCV_LAST_SMOOTH], second);
    mcv_find_exacts(world, paths, second_end, class_end[MCV_LAST_CLASS]);
}

#if MCV_WITH_CONTACT
/* Surfaces in the same place as those that the first `count` paths have met: only bodies have any.
 */
MCV_BATCH void mcv_find_contact_rows(mcv_world world, uint *paths, uint count) {
    uint flags[MCV_ROW], chosen[MCV_SLOTS];
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, 0, count) {
        mcv_put_no_contact(slot);
        flags[slot.index] = (uint)mcv_may_touch(world, slot);
    }
    const uint bodies = mcv_compact_indices(flags, count, chosen);
    for (uint i = 0; i < bodies; ++i) mcv_find_contact(world, mcv_slot_at(paths, chosen[i]));
}
#endif

MCV_LOOP_FUNCTION mcv_color mcv_reflectance_of(mcv_world world, uint instance) {
    mcv_color reflectance;
    MCV_EACH_CHANNEL(c)
    reflectance.c[c] = world.materials[world.instances[instance].material].color[c];
    return reflectance;
}

/* The reflectances of the surfaces of a range, without images. The words that follow it in the row
 * are overwritten. */
MCV_BATCH void mcv_find_reflectances(mcv_world world, uint *paths, uint first, uint last) {
    const uint *instances = paths + MCV_PATH_instance * MCV_ROW;
    uint *rows = paths + MCV_PATH_reflectance * MCV_ROW;
#if MCV_CACHED
    const uint count = world.frame->instance_count;
    if (count - 1u < MCV_CACHED && last - first >= 2 * MCV_CACHED) {
        uint of_each[MCV_CHANNELS][MCV_CACHED];
        MCV_VECTORIZE
        for (uint i = 0; i < MCV_CACHED; ++i) {
            const mcv_color reflectance = mcv_reflectance_of(world, i < count ? i : 0u);
            MCV_EACH_CHANNEL(c) of_each[c][i] = as_uint(reflectance.c[c]);
        }
        for (uint c = 0; c < MCV_CHANNELS; ++c)
            mcv_register_lookup(of_each[c], instances + first, last - first,
                                rows + c * MCV_ROW + first);
        return;
    }
#endif
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        const mcv_color reflectance = mcv_reflectance_of(world, instances[i]);
        MCV_EACH_CHANNEL(c) rows[c * MCV_ROW + i] = as_uint(reflectance.c[c]);
    }
}

#if MCV_WITH_TEXTURE
/* Images modulate the reflectances of a range. */
MCV_BATCH void mcv_apply_images(mcv_world world, uint *paths, uint first, uint last) {
    uint flags[MCV_ROW], chosen[MCV_ROW];
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, first, last) {
        const uint instance = MCV_WORD(slot, instance, 0);
        flags[slot.index - first] =
            world.materials[world.instances[instance].material].texture != MCV_NONE;
    }
    const uint count = mcv_compact_indices(flags, last - first, chosen);
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        const mcv_slot slot = mcv_slot_at(paths, first + chosen[i]);
        const mcv_surface surface = mcv_make_interaction(world, slot).surface;
        const mcv_color image = mcv_texture_at(
            world, surface, world.materials[world.instances[surface.instance].material].texture);
        mcv_color reflectance;
        MCV_LOAD_COLOR(slot, reflectance, reflectance);
        reflectance = mcv_tint(reflectance, image);
        MCV_STORE_COLOR(slot, reflectance, reflectance);
    }
}

#if MCV_WITH_GLOSSY
/* What the image of a glossy material makes of its roughness and of its metallic share, on a range
 * of its surfaces. */
MCV_BATCH void mcv_find_polish(mcv_world world, uint *paths, uint first, uint last,
                               uint glossy_material) {
    const uint texture = world.glossy[glossy_material].texture;
    if (texture == MCV_NONE) {
        MCV_VECTORIZE
        MCV_EACH_PATH (slot, paths, first, last) {
            MCV_STORE(slot, polish, 0, 1.0f);
            MCV_STORE(slot, polish, 1, 1.0f);
        }
        return;
    }
    MCV_VECTORIZE_MASKED
    MCV_EACH_PATH (slot, paths, first, last) {
        const mcv_polish polish =
            mcv_polish_at(world, mcv_make_interaction(world, slot).surface, texture);
        MCV_STORE(slot, polish, 0, polish.scale);
        MCV_STORE(slot, polish, 1, polish.metallic);
    }
}
#endif
#endif

/* What is known of the surfaces that the paths have hit, for all of them. glossy_material: the
 * material of the glossy classes. */
static void mcv_find_interactions(mcv_world world, uint *paths, const uint *class_end,
                                  uint glossy_material) {
    mcv_find_surfaces(world, paths, class_end);
#if MCV_WITH_CONTACT
    mcv_find_contact_rows(world, paths, class_end[MCV_LAST_CLASS]);
#endif
    (void)glossy_material;
    if (!MCV_HAS_PLAIN) return;
#if MCV_WITH_TEXTURE
    const uint first = class_end[MCV_LAST_SMOOTH], last = class_end[MCV_LAST_KNOWN];
    mcv_find_reflectances(world, paths, first, last);
    mcv_apply_images(world, paths, first, last);
#if MCV_WITH_GLOSSY
    if (glossy_material != MCV_NONE)
        mcv_find_polish(world, paths, class_end[MCV_LAST_DIFFUSE_EXACT], class_end[MCV_LAST_GLOSSY],
                        glossy_material);
#endif
#else
    /* In this order: the first call overwrites words of the second one's range. */
    mcv_find_reflectances(world, paths, class_end[MCV_LAST_SMOOTH],
                          class_end[MCV_LAST_DIFFUSE_EXACT]);
    mcv_find_reflectances(world, paths, class_end[MCV_LAST_GLOSSY], class_end[MCV_LAST_KNOWN]);
#endif
}

/* Draws one of the pairs of random numbers of the surfaces. */
MCV_BATCH void mcv_draw_pairs(uint *paths, uint first, uint last, uint depth, uint use) {
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, first, first + mcv_fill_lanes(last - first)) {
        const mcv_pair drawn = mcv_sample_pair(MCV_WORD(slot, stream, 0), MCV_WORD(slot, sample, 0),
                                               MCV_SURFACE_PAIR(depth, use));
        MCV_STORE(slot, drawn, 2u * use, drawn.x);
        MCV_STORE(slot, drawn, 2u * use + 1u, drawn.y);
    }
}

#if MCV_WITH_DIFFUSE
/* The directions in which the surfaces reflect if they are diffuse. */
MCV_BATCH void mcv_sample_diffuse_directions(uint *paths, uint first, uint last) {
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, first, first + mcv_fill_lanes(last - first)) {
        const float xi = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER);
        const float eta = MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER + 1);
        float density;
        const mcv_vec3 bounce = mcv_diffuse_sample(MCV_LOAD_3(slot, ns), xi, eta, &density);
        MCV_STORE_3(slot, bounce, bounce);
        MCV_STORE(slot, bounce, 3, density);
    }
}
#endif

/* The origins of the rays that leave the surfaces, in the directions that they have got. */
MCV_BATCH void mcv_offset_origins(mcv_world world, uint *paths, uint count) {
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, 0, count) {
        const mcv_vec3 origin =
            mcv_onward_origin(mcv_make_interaction(world, slot), MCV_LOAD_3(slot, direction));
        MCV_STORE_3(slot, origin, origin);
    }
}

#endif
