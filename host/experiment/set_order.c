/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/set_order.h"

#include <stdlib.h>

static int by_scene(const void *a, const void *b) {
    const mcv_set_place *x = a, *y = b;
    if (x->scene != y->scene) return x->scene < y->scene ? -1 : 1;
    return (x->set > y->set) - (x->set < y->set);
}

static int by_first(const void *a, const void *b) {
    const mcv_set_place *x = a, *y = b;
    if (x->first != y->first) return x->first < y->first ? -1 : 1;
    return (x->set > y->set) - (x->set < y->set);
}

mcv_result mcv_set_order(const mcv_sweep *s, mcv_set_place **order, mcv_error *error) {
    const size_t count = s->plan.set_count;
    double numbers[MCV_DESIGN_PARAMETERS];
    mcv_set_place *places = malloc(count * sizeof *places);
    if (!places) return mcv_fail(error, MCV_FAILED, "no memory for the order of %zu sets", count);
    mcv_result result = MCV_OK;
    for (size_t set = 0; set < count && result == MCV_OK; ++set) {
        bool wanted;
        result = mcv_plan_set(&s->plan, set, numbers, &wanted, error);
        if (result == MCV_OK) places[set] = (mcv_set_place){mcv_judge_scene(s, numbers), set, set};
    }
    if (result != MCV_OK) {
        free(places);
        return result;
    }
    qsort(places, count, sizeof *places, by_scene);
    for (size_t i = 1; i < count; ++i)
        if (places[i].scene == places[i - 1].scene) places[i].first = places[i - 1].first;
    qsort(places, count, sizeof *places, by_first);
    *order = places;
    return MCV_OK;
}

mcv_result mcv_set_seeds(mcv_sweep *s, mcv_error *error) {
    double numbers[MCV_DESIGN_PARAMETERS];
    uint32_t *seeds = malloc((s->plan.set_count + 1) * sizeof *seeds);
    if (!seeds) return mcv_fail(error, MCV_FAILED, "no memory for %zu seeds", s->plan.set_count);
    free(s->plan.seeds);
    s->plan.seeds = seeds;
    for (size_t set = 0; set < s->plan.set_count; ++set) {
        bool wanted;
        MCV_TRY(mcv_plan_set(&s->plan, set, numbers, &wanted, error));
        const uint64_t scene = mcv_judge_scene(s, numbers);
        seeds[set] = (uint32_t)(scene ^ scene >> 32);
    }
    return MCV_OK;
}
