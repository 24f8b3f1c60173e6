/* SPDX-License-Identifier: Apache-2.0 */
/* The part of a rig and its material (rig/rig.c); nothing else calls this. */
#ifndef MCVISI_HOST_RIG_RIG_PART_H
#define MCVISI_HOST_RIG_RIG_PART_H

#include "rig/rig.h"

mcv_result mcv_rig_read_part(mcv_rig_design *r, mcv_error *error);
mcv_result mcv_rig_choose_material(mcv_rig_design *r, mcv_error *error);
int mcv_rig_word_index(const char *word, const char *const *words);

#endif
