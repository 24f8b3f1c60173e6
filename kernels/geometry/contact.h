/* SPDX-License-Identifier: Apache-2.0 */
/* Bodies in contact: what else lies where a ray hits a surface. The media of all of them change
 * there. mcv_hit_interaction, of a hit, therefore stands here. */
#ifndef MCVISI_KERNELS_CONTACT_H
#define MCVISI_KERNELS_CONTACT_H

#include "geometry/interaction.h"
#include "traverse/bvh8.h"

#if MCV_WITH_CONTACT
MCV_FUNCTION mcv_vec3 mcv_larger(mcv_vec3 a, mcv_vec3 b) {
    return mcv_vec(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z));
}

/* Where a ray meets an exact surface, and where it would meet a mesh's in the same place: both
 * round, and the corners have been rounded. */
MCV_FUNCTION float mcv_exact_rounding(mcv_vec3 at, float size) {
    return MCV_GAMMA(16) * (mcv_abs(at.x) + mcv_abs(at.y) + mcv_abs(at.z) + size);
}

/*
 * Exact surfaces of dielectrics in the same place as the one met, but those of its own lens: what
 * is no farther away than places are rounded. The next ray starts twice as far off, or knows that
 * it starts on that surface.
 */
MCV_FUNCTION void mcv_find_exact_contacts(mcv_world world, uint own, mcv_interaction *interaction) {
    const uint met = interaction->surface.primitive;
    const uint group = met >= MCV_EXACT ? world.solids[mcv_solid_of(met)].group : MCV_NONE;
    const mcv_vec3 at = interaction->surface.point;
    const mcv_vec3 e = interaction->surface.error;
    for (uint i = 0; i < world.frame->solid_count; ++i) {
        __global const mcv_device_solid *solid = world.solids + i;
        const float reach = mcv_exact_rounding(at, solid->bound) + e.x + e.y + e.z;
        const mcv_vec3 p = mcv_into_frame(solid, mcv_from_middle(solid, at));
        uint piece = MCV_PIECE_COUNT;
        mcv_vec3 ng = p;
        if (solid->group == group || solid->side == MCV_SIDE_OPEN) continue;
        for (uint k = solid->side == MCV_SIDE_SPHERE ? MCV_PIECE_SIDE : 0u; k < MCV_PIECE_COUNT;
             ++k) {
            float outside;
            const mcv_vec3 normal = mcv_piece_gradient(solid, k, p, &outside);
            if (!(outside <= reach)) {
                piece = MCV_PIECE_COUNT;
                break;
            }
            if (outside < -reach) continue;
            piece = k;
            ng = mcv_out_of_frame(solid, normal);
        }
        if (piece == MCV_PIECE_COUNT) continue;
        const uint medium = world.instances[solid->instance[piece]].medium;
        if (medium == 0u || medium == own) continue;
        if (mcv_dot(interaction->direction, ng) > 0.0f)
            interaction->exited |= 1u << (medium - 1u);
        else
            interaction->entered |= 1u << (medium - 1u);
        const float off = 2.0f * reach;
        interaction->surface.error = mcv_larger(interaction->surface.error, mcv_vec(off, off, off));
        if (met < MCV_EXACT) {
            interaction->touched = mcv_exact_hit(i, piece);
            interaction->touched_ng = ng;
        }
    }
}

/* How far behind a hit at t another surface may be met that is in the same place, as far as points
 * are in doubt by e. */
MCV_LOOP_FUNCTION float mcv_contact_band(const mcv_interaction *interaction, mcv_vec3 e, float t) {
    const mcv_vec3 f = interaction->ng;
    const float reach = mcv_abs(f.x) * e.x + mcv_abs(f.y) * e.y + mcv_abs(f.z) * e.z;
    return 2.0f * reach / -mcv_dot(interaction->direction, f) + 2.0f * MCV_GAMMA(16) * t;
}

/* Whether surfaces of other bodies than that of the medium `own` may lie so close to a place;
 * triangles, not exact ones. */
MCV_LOOP_FUNCTION int mcv_is_near_others(mcv_world world, mcv_surface surface, uint own,
                                         float band) {
    __global const mcv_contact_grid *grid = world.contact_grid;
    mcv_vec3 point = surface.point;
#if MCV_WITH_MOVING
    point = mcv_either(world.instances[surface.instance].moves != 0u,
                       mcv_point_at_rest(&world.frame->part_motion, world.pose, point), point);
#endif
    const uint x = mcv_contact_cell(point.x, grid->low[0], grid->scale[0]),
               y = mcv_contact_cell(point.y, grid->low[1], grid->scale[1]),
               z = mcv_contact_cell(point.z, grid->low[2], grid->scale[2]);
    const uint media = grid->media[(z * MCV_CONTACT_CELLS + y) * MCV_CONTACT_CELLS + x];
    const int far = 2.0f * band < grid->reach; /* half of it is for what rounds */
    return !far | ((media & ~(1u << (own - 1u))) != 0u);
}

/*
 * Surfaces of dielectric bodies in the same place as the one that the ray has met: so close behind
 * that the next ray's origin, which is moved off the surface by its error, might lie beyond them,
 * too. From each found the next is looked for.
 */
static void mcv_find_contacts(mcv_world world, mcv_vec3 origin, mcv_hit hit,
                              mcv_interaction *interaction) {
    interaction->exited = interaction->entered = 0u;
    interaction->touched = MCV_NONE;
    interaction->touched_ng = interaction->ng;
    const uint own = world.instances[interaction->surface.instance].medium;
    if (MCV_WITH_SURFACES && own != 0u) mcv_find_exact_contacts(world, own, interaction);
    interaction->beyond_point = interaction->surface.point;
    interaction->beyond_error = interaction->surface.error;
    if (own == 0u) return;
    uint crossed = 1u << (own - 1u) | interaction->exited | interaction->entered;
    mcv_vec3 e = interaction->surface.error;
    const float rounding =
        mcv_is_exact(hit.primitive) ? mcv_exact_rounding(interaction->surface.point, 0.0f) : 0.0f;
    if (MCV_WITH_SURFACES) e = mcv_larger(e, mcv_vec(rounding, rounding, rounding));
    if (!mcv_is_near_others(world, interaction->surface, own,
                            mcv_contact_band(interaction, e, hit.t)))
        return;
    __global const mcv_node *nodes = world.nodes;
    __global const mcv_leaf *leaves = world.leaves;
    mcv_vec3 direction = interaction->direction;
#if MCV_WITH_MOVING
    /* What touches a moving part moves with it. */
    if (world.instances[interaction->surface.instance].moves != 0u) {
        MCV_CONSTANT const mcv_rigid_motion *motion = &world.frame->part_motion;
        nodes += world.frame->moving_nodes;
        leaves += world.frame->moving_leaves;
        origin = mcv_point_at_rest(motion, world.pose, origin);
        direction = mcv_direction_at_rest(motion, world.pose, direction);
    }
#endif
    for (int i = 0; i < (int)MCV_MAX_MEDIA; ++i) {
        const float band = mcv_contact_band(interaction, e, hit.t);
        hit = mcv_next_hit_ray(nodes, leaves, origin, direction, hit, hit.t + band);
        if (hit.primitive == MCV_NONE) return;
        const mcv_surface next = mcv_surface_at(world, hit.primitive, hit.u, hit.v);
        const uint medium = world.instances[next.instance].medium;
        if (medium == 0u) return;
        const uint bit = 1u << (medium - 1u);
        /* A body that is crossed once more is on the ray's side again. */
        if (crossed & bit) {
            if (medium == own) return;
            interaction->exited &= ~bit;
            interaction->entered &= ~bit;
        } else if (mcv_dot(interaction->direction, next.ng) > 0.0f) {
            interaction->exited |= bit;
        } else {
            interaction->entered |= bit;
        }
        crossed ^= bit;
        e = mcv_larger(e, next.error);
        if (MCV_WITH_SURFACES)
            interaction->surface.error =
                mcv_larger(interaction->surface.error, mcv_scale(e, rounding > 0.0f ? 2.0f : 0.0f));
        else
            e = next.error;
        interaction->beyond_point = next.point;
        interaction->beyond_error = e;
    }
}
#endif

MCV_FUNCTION mcv_interaction mcv_hit_interaction(mcv_world world, mcv_vec3 origin,
                                                 mcv_vec3 direction, mcv_hit hit) {
    mcv_interaction interaction =
        mcv_surface_interaction(mcv_hit_surface(world, origin, direction, hit), direction);
#if MCV_WITH_CONTACT
    mcv_find_contacts(world, origin, hit, &interaction);
#endif
    return interaction;
}

#endif
