/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/plan.h"

#include "experiment/expression.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* "emitters/back/halfAngle" becomes halfAngle, or back.halfAngle if that name exists already. */
static mcv_result name_parameter(const mcv_plan *plan, mcv_parameter *p, mcv_error *error) {
    int start = p->path_length;
    for (int parts = 0; parts < 3; ++parts) {
        size_t length = 0;
        while (start > 0 && p->item[start - 1] != '/') --start;
        for (int i = start; i < p->path_length && length + 2 < sizeof p->name; ++i) {
            const char c = p->item[i];
            if (length == 0 && isdigit((unsigned char)c)) p->name[length++] = '_';
            p->name[length++] = isalnum((unsigned char)c) ? c : c == '/' ? '.' : '_';
        }
        p->name[length] = '\0';
        bool taken = length == 0;
        for (const mcv_parameter *other = plan->parameters; other < p; ++other)
            taken = taken || strcmp(other->name, p->name) == 0;
        if (!taken) return MCV_OK;
        if (start > 0) --start;
    }
    return mcv_fail(error, MCV_USAGE, "%s: another parameter has the same path", p->item);
}

static mcv_result read_parameter(mcv_plan *plan, const char *item, const char *option,
                                 mcv_error *error) {
    const char *equals = strchr(item, '=');
    const bool tie = strcmp(option, "tie") == 0;
    if (!equals || equals == item)
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be PATH=%s", option, item,
                        tie ? "EXPR" : "VALUES");
    if (plan->count == MCV_DESIGN_PARAMETERS)
        return mcv_fail(error, MCV_USAGE,
                        "--%s %s: is one too many: at most %d parameters can vary", option, item,
                        MCV_DESIGN_PARAMETERS);
    mcv_parameter *p = plan->parameters + plan->count;
    *p = (mcv_parameter){
        .item = item, .path_length = (int)(equals - item), .expression = tie ? equals + 1 : NULL};
    MCV_TRY(name_parameter(plan, p, error));
    if (strcmp(option, "vary") == 0) {
        mcv_error detail = {""};
        const mcv_result result = mcv_levels_parse(equals + 1, &p->levels, &detail);
        if (result != MCV_OK) return mcv_fail(error, result, "--vary %s: %s", item, detail.text);
    }
    plan->varied += !tie;
    ++plan->count;
    return MCV_OK;
}

mcv_result mcv_plan_parameters(const mcv_variation *variation, mcv_plan *plan, mcv_error *error) {
    *plan = (mcv_plan){.where = variation->where};
    const char *option = variation->given ? variation->given->option : "vary";
    if (variation->vary.count == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--%s is missing: give what changes, as in --vary "
                        "emitters/back/halfAngle=0.1deg..2deg:8",
                        option);
    for (size_t i = 0; i < variation->vary.count; ++i)
        MCV_TRY(read_parameter(plan, variation->vary.items[i], option, error));
    for (size_t i = 0; i < variation->tie.count; ++i)
        MCV_TRY(read_parameter(plan, variation->tie.items[i], "tie", error));
    return MCV_OK;
}

/* --- words --- */

const char *mcv_parameter_word(const mcv_parameter *p, double number, int *length) {
    const char *at = p->item + p->path_length + 1;
    if (!p->levels.named || !(number >= 0 && number < (double)p->levels.count)) return NULL;
    for (size_t left = (size_t)number; left > 0; --left) at = strchr(at, ',') + 1;
    *length = (int)strcspn(at, ",");
    return at;
}

double mcv_parameter_number(const mcv_parameter *p, const char *text) {
    const size_t size = strcspn(text, ",");
    for (size_t i = 0; i < p->levels.count; ++i) {
        int length;
        const char *word = mcv_parameter_word(p, (double)i, &length);
        if (word && (size_t)length == size && memcmp(word, text, size) == 0) return (double)i;
    }
    return NAN;
}

const char *mcv_parameter_text(const mcv_parameter *p, double number, int digits,
                               mcv_value_text text) {
    int length;
    const char *word = mcv_parameter_word(p, number, &length);
    if (word)
        snprintf(text, sizeof(mcv_value_text), "%.*s", length, word);
    else
        snprintf(text, sizeof(mcv_value_text), "%.*g", digits, number);
    return text;
}

json_t *mcv_parameter_json(const mcv_parameter *p, double number) {
    int length;
    const char *word = mcv_parameter_word(p, number, &length);
    return word ? json_stringn(word, (size_t)length) : json_real(number);
}

/* --- sets --- */

/* The parameters of a set; those that are not computed yet are unknown. */
typedef struct known_values {
    const mcv_plan *plan;
    const double *numbers;
    size_t known;
} known_values;

static mcv_result look_up_parameter(void *user, const char *name, mcv_quantity *quantity,
                                    mcv_error *error) {
    const known_values *v = user;
    char list[512] = "";
    for (size_t i = 0; i < v->known; ++i) {
        if (strcmp(v->plan->parameters[i].name, name) == 0) {
            *quantity = (mcv_quantity){v->numbers[i], 0};
            return MCV_OK;
        }
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "",
                 v->plan->parameters[i].name);
    }
    return mcv_fail(error, MCV_USAGE, "there is no parameter \"%s\": there are %s", name, list);
}

mcv_result mcv_plan_set(const mcv_plan *plan, size_t set, double *numbers, bool *wanted,
                        mcv_error *error) {
    mcv_quantity value;
    known_values v = {plan, numbers, plan->varied};
    memcpy(numbers, plan->sets + set * plan->varied, plan->varied * sizeof *numbers);
    for (size_t i = plan->varied; i < plan->count; ++i, ++v.known) {
        const mcv_parameter *p = plan->parameters + i;
        MCV_TRY(mcv_expression_evaluate(p->expression, look_up_parameter, &v, &value, error));
        if (!isfinite(value.value))
            return mcv_fail(error, MCV_USAGE,
                            "--tie %s: must be a finite number, which it is not in set %zu",
                            p->item, set);
        numbers[i] = value.value;
    }
    *wanted = true;
    for (size_t i = 0; i < plan->where.count && *wanted; ++i) {
        MCV_TRY(
            mcv_expression_evaluate(plan->where.items[i], look_up_parameter, &v, &value, error));
        *wanted = value.value != 0 && !isnan(value.value);
    }
    return MCV_OK;
}

static mcv_result take_sets(const mcv_given_sets *given, mcv_plan *plan, mcv_error *error) {
    const size_t numbers = given->count * plan->varied;
    plan->sets = malloc((numbers + 1) * sizeof *plan->sets);
    plan->seeds = calloc(given->count + 1, sizeof *plan->seeds);
    if (!plan->sets || !plan->seeds)
        return mcv_fail(error, MCV_FAILED, "no memory for %zu sets of parameters", given->count);
    memcpy(plan->sets, given->values, numbers * sizeof *plan->sets);
    if (given->seeds) memcpy(plan->seeds, given->seeds, given->count * sizeof *plan->seeds);
    plan->set_count = given->count;
    return MCV_OK;
}

static mcv_result make_sets(const mcv_variation *variation, mcv_plan *plan, mcv_error *error) {
    mcv_levels levels[MCV_DESIGN_PARAMETERS];
    for (size_t i = 0; i < plan->varied; ++i) levels[i] = plan->parameters[i].levels;
    return mcv_design_make(variation->design, levels, plan->varied, variation->points,
                           variation->seed, &plan->sets, &plan->set_count, error);
}

mcv_result mcv_plan_sets(const mcv_variation *variation, mcv_plan *plan, mcv_error *error) {
    double numbers[MCV_DESIGN_PARAMETERS];
    bool wanted = false;
    if (variation->given)
        MCV_TRY(take_sets(variation->given, plan, error));
    else
        MCV_TRY(make_sets(variation, plan, error));
    for (size_t set = 0; set < plan->set_count; ++set) {
        MCV_TRY(mcv_plan_set(plan, set, numbers, &wanted, error));
        plan->wanted += wanted;
    }
    return plan->wanted
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE, "--where leaves out all %zu sets", plan->set_count);
}

void mcv_plan_free(mcv_plan *plan) {
    for (size_t i = 0; i < plan->count; ++i) mcv_levels_free(&plan->parameters[i].levels);
    free(plan->sets);
    free(plan->seeds);
    *plan = (mcv_plan){.sets = NULL};
}
