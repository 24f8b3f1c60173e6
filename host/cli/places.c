/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/places.h"

#include "analysis/part_place.h"

#include <stdlib.h>

static mcv_result resolve_list(const char *what, const mcv_compact_indices *from,
                               const mcv_camera_model *model, mcv_compact_indices *to,
                               mcv_error *error) {
    to->items = calloc(from->count + 1, sizeof *to->items);
    if (!to->items) return mcv_fail(error, MCV_FAILED, "no memory for %s", what);
    for (; to->count < from->count; ++to->count) {
        char *text;
        MCV_TRY(mcv_part_place_resolve(what, from->items[to->count], model, &text, error));
        to->items[to->count] = text;
    }
    return MCV_OK;
}

mcv_result mcv_places_resolve(const mcv_command *command, const mcv_camera_model *model,
                              mcv_command *resolved, mcv_error *error) {
    char *background = NULL;
    *resolved = *command;
    resolved->background = NULL;
#define MCV_X(field, name) resolved->field = (mcv_compact_indices){0};
    MCV_PLACE_OPTIONS(MCV_X)
#undef MCV_X
    if (command->background)
        MCV_TRY(
            mcv_part_place_resolve("--background", command->background, model, &background, error));
    resolved->background = background;
#define MCV_X(field, name) \
    MCV_TRY(resolve_list(name, &command->field, model, &resolved->field, error));
    MCV_PLACE_OPTIONS(MCV_X)
#undef MCV_X
    return MCV_OK;
}

static void free_list(mcv_compact_indices *list) {
    for (size_t i = 0; i < list->count; ++i) free((void *)list->items[i]);
    free((void *)list->items);
    *list = (mcv_compact_indices){0};
}

void mcv_places_free(mcv_command *resolved) {
    free((void *)resolved->background);
    resolved->background = NULL;
#define MCV_X(field, name) free_list(&resolved->field);
    MCV_PLACE_OPTIONS(MCV_X)
#undef MCV_X
}
