/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `measure` and `sweep` for the places of measurements. */
#ifndef MCVISI_HOST_VERBS_PLACES_H
#define MCVISI_HOST_VERBS_PLACES_H

#include "analysis/places.h"
#include "options/command.h"

/* The places as given. The texts belong to the command. */
mcv_places mcv_places_of(const mcv_command *command);

/* A list of the options as texts. */
mcv_texts mcv_texts_of(const mcv_list *list);

#endif
