/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The weights of multiple importance sampling. Two pairs of techniques find the same light:
 * - next-event estimation and the surface's own choice of a direction: the power heuristic;
 * - light paths and camera paths: the balance heuristic.
 */
#ifndef MCVISI_KERNELS_MIS_H
#define MCVISI_KERNELS_MIS_H

#include "light/light_path.h"
#include "light/selection.h"
#include "light/tree.h"
#include "path/camera_path.h"

/*
 * The weight of what was found by a choice of density `own` > 0 and could have been found by
 * another: the power heuristic of exponent 2 (Veach 1997, 9.2.4). The balance heuristic leaves a
 * part of small lights to the few paths that meet them by chance, and their noise with it.
 */
MCV_LOOP_FUNCTION float mcv_power_heuristic(float own, float other) {
    const float ratio = other / own; /* whose square may be infinite: no weight */
    return 1.0f / mcv_fma(ratio, ratio, 1.0f);
}

/*
 * The pdf of the surface's own choice of a ray that has met an emitter, to be weighed against
 * p_light, the pdf of next-event estimation that takes emitters by power alone
 * (mcv_density_towards). The surface takes this emitter `ratio` times as often (mcv_tree_ratio,
 * mcv_selection_ratio); with a glossy receiver the ratio is a surrogate (mcv_light_selection). The
 * power heuristic depends on the quotient of the two pdfs alone, and p_bsdf/ratio : p_light =
 * p_bsdf : p_light * ratio. Here p_bsdf is divided; where the emitter is sampled p_light is
 * multiplied (mcv_apply_selection). Both are the same weights.
 */
MCV_LOOP_FUNCTION float mcv_bsdf_pdf_over_ratio(mcv_world world, mcv_slot slot, uint emitter,
                                                float pdf) {
#if MCV_WITH_NEXT_EVENT && MCV_WITH_LIGHT_TREE
    if (!(pdf > 0.0f)) return pdf;
    const float over_ratio =
        pdf / mcv_tree_ratio(world, emitter, MCV_LOAD_3(slot, origin), MCV_LOAD_3(slot, selection));
#else
    if (!(MCV_WITH_NEXT_EVENT && MCV_WITH_REACH)) return pdf;
    const float over_ratio =
        pdf / mcv_selection_ratio(world.emitters + emitter, MCV_LOAD_3(slot, origin),
                                  MCV_LOAD(slot, selection, 0), MCV_LOAD(slot, selection, 1));
#endif
    return pdf > 0.0f ? over_ratio : pdf;
}

/*
 * The weight of light paths in light that camera paths find by chance, too: the balance heuristic.
 * Light paths start with the density 1/etendue. Camera paths that choose directions by cosθ/π have
 * the uniform density 1/(π footprint) in étendue, of a pixel's footprint at the first broad
 * surface. Between broad surfaces both continue alike. Smooth surfaces keep étendue, and
 * near-specular ones about do: they scatter alike in both directions. Both kinds of paths compute
 * the weight from the depth of that surface. So nothing is lost or counted twice where materials or
 * the surface's slope make the weight less than the best.
 */
MCV_FUNCTION float mcv_light_path_mis_weight(mcv_world world, float etendue, float footprint) {
    return 1.0f / (1.0f + etendue / (world.frame->light_density * footprint));
}

/* Near-specular surfaces do not sample emitters whose light is brought by light paths, too: the
 * path meets these by chance. There its class is CARRIED, and mcv_light_paths_find is 1. */
MCV_LOOP_FUNCTION int mcv_leaves_to_light_paths(mcv_world world, mcv_slot slot, uint emitter,
                                                int near_specular) {
    if (!MCV_WITH_LIGHT_TRACING) return 0;
    const uint path_class = MCV_WORD(slot, path_class, 0);
    return near_specular &
           ((path_class == MCV_PATH_CLASS_BROAD) | (path_class == MCV_PATH_CLASS_CARRIED)) &
           mcv_has_light_paths(world, emitter);
}

/* Whether light paths bring, too, what this camera path has met of an emitter. The surface before
 * has not sampled it: it was smooth, or has left it to light paths. */
MCV_LOOP_FUNCTION int mcv_light_paths_find(mcv_world world, mcv_slot slot, uint emitter) {
    if (!MCV_WITH_LIGHT_TRACING) return 0;
    return (MCV_WORD(slot, path_class, 0) == MCV_PATH_CLASS_CARRIED) &
           mcv_has_light_paths(world, emitter);
}

#if MCV_WITH_LIGHT_TRACING
/* The weight of a camera path in what it has met of an emitter, along a unit direction: 1 minus
 * that of light paths, if there are any of its kind. */
MCV_FUNCTION float mcv_camera_path_mis_weight(mcv_world world, mcv_slot slot, mcv_surface surface,
                                              mcv_vec3 direction, uint emitter) {
#if MCV_HAS_EMISSION
    if (!mcv_light_paths_find(world, slot, emitter)) return 1.0f;
    const float etendue = mcv_light_etendue(world, surface, emitter, mcv_scale(direction, -1.0f));
    if (etendue > 0.0f)
        return 1.0f - mcv_light_path_mis_weight(world, etendue, MCV_LOAD(slot, footprint, 0));
#else
    (void)world, (void)slot, (void)surface, (void)direction, (void)emitter;
#endif
    return 1.0f;
}
#endif

#endif
