/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/places.h"

#include "analysis/part_place.h"

#include <stdlib.h>

size_t mcv_places_boxes(const mcv_places *places) {
    size_t count = 0;
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f) count += places->boxes[f].count;
    return count;
}

static mcv_result resolve_texts(const char *what, mcv_texts from, const mcv_camera_model *model,
                                mcv_texts *to, mcv_error *error) {
    const char **items = calloc(from.count + 1, sizeof *items);
    if (!items) return mcv_fail(error, MCV_FAILED, "no memory for %s", what);
    to->items = items;
    for (; to->count < from.count; ++to->count) {
        char *text;
        MCV_TRY(mcv_part_place_resolve(what, from.items[to->count], model, &text, error));
        items[to->count] = text;
    }
    return MCV_OK;
}

mcv_result mcv_places_resolve(const mcv_places *given, const mcv_camera_model *model,
                              mcv_places *resolved, mcv_error *error) {
    static const char *const options[] = {
#define MCV_X(form, FORM, figures, what) "--" #form,
        MCV_FORMS(MCV_X)
#undef MCV_X
    };
    char *background = NULL;
    *resolved = (mcv_places){.bound = given->bound};
    if (given->background)
        MCV_TRY(
            mcv_part_place_resolve("--background", given->background, model, &background, error));
    resolved->background = background;
    MCV_TRY(resolve_texts("--region", given->regions, model, &resolved->regions, error));
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f)
        MCV_TRY(resolve_texts(options[f], given->boxes[f], model, resolved->boxes + f, error));
    return MCV_OK;
}

static void free_texts(mcv_texts texts) {
    for (size_t i = 0; i < texts.count; ++i) free((void *)texts.items[i]);
    free((void *)texts.items);
}

void mcv_places_free(mcv_places *resolved) {
    free((void *)resolved->background);
    free_texts(resolved->regions);
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f) free_texts(resolved->boxes[f]);
    *resolved = (mcv_places){.background = NULL};
}
