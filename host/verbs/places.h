/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `measure` and `sweep` that say where. */
#ifndef MCVISI_HOST_VERBS_PLACES_H
#define MCVISI_HOST_VERBS_PLACES_H

#include "analysis/places.h"
#include "options/command.h"

/* The places of the options, as given. Texts are the command's. */
mcv_places mcv_places_of(const mcv_command *command);

/* A list of the options as texts. */
mcv_texts mcv_texts_of(const mcv_list *list);

#endif
