/* SPDX-License-Identifier: Apache-2.0 */
/* The surface that a path has met: from the words of its slot to an interaction. */
#ifndef MCVISI_KERNELS_PATH_INTERACTION_H
#define MCVISI_KERNELS_PATH_INTERACTION_H

#include "path/camera_path.h"
#include "path/dispersion.h"
#include "path/time.h"
#include "bsdf/bsdf.h"

/* What the path has met. */
MCV_LOOP_FUNCTION mcv_hit mcv_load_hit(mcv_slot slot) {
    const mcv_hit hit = {MCV_LOAD(slot, hit, 0), MCV_LOAD(slot, hit, 1), MCV_LOAD(slot, hit, 2),
                         MCV_WORD(slot, hit, 3)};
    return hit;
}

/* mcv_disperse_at for a camera path, wherever it is; without dispersion the world as it is. */
MCV_FUNCTION mcv_world mcv_disperse(mcv_world world, mcv_slot slot) {
#if MCV_WITH_DISPERSION
    const uint primitive = MCV_WORD(slot, hit, 3);
    mcv_color throughput = mcv_path_throughput(slot);
    if (primitive == MCV_NONE) return mcv_in_channel(world, mcv_kept_channel(throughput));
    world = mcv_disperse_at(world, mcv_instance_of(world, primitive), MCV_WORD(slot, stream, 0),
                            MCV_WORD(slot, sample, 0), throughput, &throughput);
    MCV_STORE_COLOR(slot, throughput, throughput);
#else
    (void)slot;
#endif
    return world;
}

#if MCV_TILE
MCV_LOOP_FUNCTION void mcv_put_surface(mcv_slot slot, mcv_surface surface) {
    const mcv_interaction interaction =
        mcv_surface_interaction(surface, MCV_LOAD_3(slot, direction));
    MCV_STORE_3(slot, point, surface.point);
    MCV_STORE_3(slot, error, surface.error);
    MCV_STORE(slot, area, 0, surface.area);
    MCV_WORD(slot, instance, 0) = surface.instance;
    if (MCV_WITH_NORMALS) MCV_STORE_3(slot, front_ns, surface.ns);
    MCV_WORD(slot, back_face, 0) = interaction.back_face;
    MCV_STORE_3(slot, ng, interaction.ng);
    MCV_STORE_3(slot, ns, interaction.ns);
    if (MCV_WITH_GLOSSY) MCV_WORD(slot, glossy_known, 0) = 0u;
}

/* Works out the surface of a triangle; where nothing was met, of some other one. */
MCV_LOOP_FUNCTION void mcv_find_triangle(mcv_world world, mcv_slot slot) {
    const uint met = MCV_WORD(slot, hit, 3);
    mcv_put_surface(slot, mcv_surface_at(mcv_at_time(world, slot), met == MCV_NONE ? 0u : met,
                                         MCV_LOAD(slot, hit, 1), MCV_LOAD(slot, hit, 2)));
}

MCV_LOOP_FUNCTION void mcv_find_exact(mcv_world world, mcv_slot slot, uint met, int quadric) {
    mcv_put_surface(
        slot, mcv_exact_surface_on(world, met, MCV_LOAD(slot, hit, 1), MCV_LOAD_3(slot, origin),
                                   MCV_LOAD_3(slot, direction), MCV_LOAD(slot, hit, 0), quadric));
}
#endif

/* The instance that a path has met, which must have met something. */
MCV_FUNCTION uint mcv_hit_instance(mcv_world world, mcv_slot slot) {
#if MCV_TILE
    (void)world;
    return MCV_WORD(slot, instance, 0);
#else
    return mcv_instance_of(world, MCV_WORD(slot, hit, 3));
#endif
}

MCV_LOOP_FUNCTION mcv_interaction mcv_make_interaction(mcv_world world, mcv_slot slot) {
#if MCV_TILE
    const mcv_hit hit = mcv_load_hit(slot);
    mcv_interaction interaction;
    mcv_surface *surface = &interaction.surface;
    interaction.direction = MCV_LOAD_3(slot, direction);
    interaction.back_face = MCV_WORD(slot, back_face, 0);
    interaction.ng = MCV_LOAD_3(slot, ng);
    interaction.ns = MCV_LOAD_3(slot, ns);
    surface->point = MCV_LOAD_3(slot, point);
    surface->error = MCV_LOAD_3(slot, error);
    surface->ng = mcv_scale(interaction.ng, interaction.back_face ? -1.0f : 1.0f);
    surface->ns = surface->ng;
    if (MCV_WITH_NORMALS) surface->ns = MCV_LOAD_3(slot, front_ns);
    surface->area = MCV_LOAD(slot, area, 0);
    surface->primitive = hit.primitive;
    if (mcv_is_exact(hit.primitive))
        surface->corners.x = surface->corners.y = surface->corners.z = 0u;
    else
        surface->corners = mcv_triangle_corners(world, hit.primitive);
    surface->instance = surface->corners.w = MCV_WORD(slot, instance, 0);
    surface->u = hit.u;
    surface->v = hit.v;
#if MCV_WITH_GLOSSY
    interaction.glossy = slot.glossy_interactions + slot.index;
    interaction.glossy_known = &MCV_WORD(slot, glossy_known, 0);
#endif
#if MCV_WITH_DIFFUSE
    interaction.bounces = 1;
    interaction.bounce = MCV_LOAD_3(slot, bounce);
    interaction.bounce_density = MCV_LOAD(slot, bounce, 3);
#endif
#if MCV_WITH_CONTACT
    interaction.exited = MCV_WORD(slot, contact, 0);
    interaction.entered = MCV_WORD(slot, contact, 1);
    interaction.touched = MCV_WORD(slot, contact, 2);
    interaction.beyond_point = MCV_LOAD_3(slot, beyond_point);
    interaction.beyond_error = MCV_LOAD_3(slot, beyond_error);
    interaction.touched_ng = MCV_LOAD_3(slot, touched_ng);
#endif
    return interaction;
#else
    return mcv_hit_interaction(mcv_at_time(world, slot), MCV_LOAD_3(slot, origin),
                               MCV_LOAD_3(slot, direction), mcv_load_hit(slot));
#endif
}

#if MCV_TILE && MCV_WITH_CONTACT
/* Nothing is in the same place as the surface that a path has met. */
MCV_LOOP_FUNCTION void mcv_put_no_contact(mcv_slot slot) {
    MCV_WORD(slot, contact, 0) = MCV_WORD(slot, contact, 1) = 0u;
    MCV_WORD(slot, contact, 2) = MCV_NONE;
    MCV_STORE_3(slot, beyond_point, MCV_LOAD_3(slot, point));
    MCV_STORE_3(slot, beyond_error, MCV_LOAD_3(slot, error));
    MCV_STORE_3(slot, touched_ng, MCV_LOAD_3(slot, ng));
}

/* Whether the surface that a path has met may have others in the same place. */
MCV_LOOP_FUNCTION int mcv_may_touch(mcv_world world, mcv_slot slot) {
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
    const uint medium = world.instances[interaction.surface.instance].medium;
    const int near =
        MCV_WITH_SURFACES ||
        mcv_is_near_others(
            mcv_at_time(world, slot), interaction.surface, medium > 0u ? medium : 1u,
            mcv_contact_band(&interaction, interaction.surface.error, MCV_LOAD(slot, hit, 0)));
    return (medium != 0u) & near;
}

/* Looks for surfaces in the same place as the one of a body that a path has met. */
MCV_FUNCTION void mcv_find_contact(mcv_world world, mcv_slot slot) {
    mcv_interaction interaction = mcv_make_interaction(world, slot);
    mcv_find_contacts(mcv_at_time(world, slot), MCV_LOAD_3(slot, origin), mcv_load_hit(slot),
                      &interaction);
    MCV_STORE_3(slot, error, interaction.surface.error);
    MCV_WORD(slot, contact, 0) = interaction.exited;
    MCV_WORD(slot, contact, 1) = interaction.entered;
    MCV_WORD(slot, contact, 2) = interaction.touched;
    MCV_STORE_3(slot, beyond_point, interaction.beyond_point);
    MCV_STORE_3(slot, beyond_error, interaction.beyond_error);
    MCV_STORE_3(slot, touched_ng, interaction.touched_ng);
}
#endif

#endif
