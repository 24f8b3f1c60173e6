/* SPDX-License-Identifier: Apache-2.0 */
/* The lobe by which a surface that a path has met chooses among emitters (light/lobe.h). */
#ifndef MCVISI_KERNELS_RECEIVER_LOBE_H
#define MCVISI_KERNELS_RECEIVER_LOBE_H

#include "bsdf/bsdf.h"
#include "light/lobe.h"
#include "path/camera_path.h"

#if MCV_WITH_REACH && MCV_WITH_GLOSSY
/* What a glossy surface makes of light; rough glass sends on as much from everywhere. */
MCV_LOOP_FUNCTION mcv_receiver_lobe mcv_lobe_of_glossy(const mcv_glossy_interaction *m) {
    mcv_receiver_lobe lobe = mcv_even_lobe();
    if (m->microfacets.type == MCV_MATERIAL_DIELECTRIC) return lobe;
    lobe.along = m->x;
    lobe.along_squared = m->microfacets.alpha.x * m->microfacets.alpha.x;
    lobe.across_squared = m->microfacets.alpha.y * m->microfacets.alpha.y;
    lobe.microfacet = m->lobes.microfacet;
    lobe.spread = 1.0f - m->lobes.microfacet;
    lobe.even = 0.0f;
    return lobe;
}

/* The same of any surface that a path has met. Where colours disperse nothing is kept of it: it has
 * no channel yet. */
MCV_FUNCTION mcv_receiver_lobe mcv_receiver_lobe_at(mcv_world world, mcv_slot slot,
                                                    const mcv_interaction *interaction) {
    const uint material = world.instances[interaction->surface.instance].material,
               media = mcv_path_media(slot);
    mcv_glossy_interaction room;
    if (world.materials[material].type == MCV_MATERIAL_DIELECTRIC ||
        !mcv_is_microfacet(world, interaction, media))
        return mcv_even_lobe();
    if (!MCV_WITH_DISPERSION)
        return mcv_lobe_of_glossy(mcv_known_glossy(world, interaction, material, media, &room));
    room = mcv_make_glossy_interaction(world, interaction, material, media);
    return mcv_lobe_of_glossy(&room);
}
#endif

#endif
