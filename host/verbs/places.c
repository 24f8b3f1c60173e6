/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/places.h"

mcv_texts mcv_texts_of(const mcv_list *list) { return (mcv_texts){list->items, list->count}; }

mcv_places mcv_places_of(const mcv_command *command) {
    return (mcv_places){.regions = mcv_texts_of(&command->region),
                        .background = command->background,
                        .boxes = {
#define MCV_X(form, FORM, figures, what) mcv_texts_of(&command->form),
                            MCV_FORMS(MCV_X)
#undef MCV_X
                        }};
}
