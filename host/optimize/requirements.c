/* SPDX-License-Identifier: Apache-2.0 */
/* Requirements of an optimisation: comparisons of expressions over metrics and parameters. */
#include "optimize/study.h"

#include "experiment/expression.h"
#include "experiment/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- the text --- */

/* The one comparison outside of brackets; NULL without exactly one. */
static const char *find_comparison(const char *text) {
    const char *found = NULL;
    int depth = 0;
    for (const char *c = text; *c; ++c) {
        depth += (*c == '(') - (*c == ')');
        if (depth != 0 || (*c != '<' && *c != '>')) continue;
        if (found) return NULL;
        found = c;
    }
    return found;
}

static mcv_result read_requirement(const char *text, mcv_requirement *r, mcv_error *error) {
    const char *at = find_comparison(text);
    if (!at || at == text || !at[1 + (at[1] == '=')])
        return mcv_fail(error, MCV_USAGE,
                        "--require %s: must be one comparison by <, <=, > or >=, as in "
                        "'saturated<0.01'",
                        text);
    const char *right = at + 1 + (at[1] == '=');
    const int length = (int)(at - text);
    r->text = text;
    const int size =
        *at == '<' ? snprintf(r->margin, sizeof r->margin, "(%.*s)-(%s)", length, text, right)
                   : snprintf(r->margin, sizeof r->margin, "(%s)-(%.*s)", right, length, text);
    if (size < (int)sizeof r->margin) return MCV_OK;
    return mcv_fail(error, MCV_USAGE, "--require %.60s...: is too long", text);
}

/* --- its margin --- */

/* A row of the table by the names of metrics and parameters. */
typedef struct named_row {
    const mcv_optimization *o;
    const double *row;
} named_row;

static mcv_result look_up(void *user, const char *name, mcv_quantity *quantity, mcv_error *error) {
    const named_row *n = user;
    const mcv_measurement *m = &n->o->sweep.measurement;
    const mcv_plan *plan = &n->o->sweep.plan;
    for (size_t i = 0; i < m->count; ++i) {
        if (strcmp(m->metrics[i].name, name) != 0) continue;
        const double *q = n->row ? n->row + mcv_row_metric(&n->o->sweep.table, i) : NULL;
        *quantity = q ? (mcv_quantity){q[0], isnan(q[1]) ? 0 : q[1]} : (mcv_quantity){1, 0};
        return MCV_OK;
    }
    for (size_t i = 0; i < plan->count; ++i) {
        if (strcmp(plan->parameters[i].name, name) != 0) continue;
        *quantity = (mcv_quantity){n->row ? n->row[i] : 1, 0};
        return MCV_OK;
    }
    return mcv_fail(error, MCV_USAGE, "there is no metric or parameter \"%s\"", name);
}

mcv_result mcv_requirements_margins(const mcv_optimization *o, const double *row, mcv_evaluation *e,
                                    mcv_error *error) {
    named_row n = {o, row};
    for (size_t k = 0; k < o->search.requirements; ++k) {
        mcv_quantity margin;
        mcv_error reason = {""};
        if (mcv_expression_evaluate(o->requirements[k].margin, look_up, &n, &margin, &reason) !=
            MCV_OK)
            return mcv_fail(error, MCV_USAGE, "--require %s: %s", o->requirements[k].text,
                            reason.text);
        e->margins[k] = margin.value;
        e->margin_errors[k] = margin.uncertainty;
    }
    return MCV_OK;
}

/* Names that do not exist are told before the first render, with 1 for all that is measured. */
mcv_result mcv_requirements_read(const mcv_optimization_asked *asked, mcv_optimization *o,
                                 mcv_error *error) {
    mcv_evaluation tried = {.stage = 0};
    if (asked->require.count > MCV_SEARCH_REQUIREMENTS)
        return mcv_fail(error, MCV_USAGE, "--require: %zu are given: at most %d",
                        asked->require.count, MCV_SEARCH_REQUIREMENTS);
    if (asked->require.count && asked->objectives.count > 1)
        return mcv_fail(error, MCV_USAGE,
                        "--require is for one --objective: with several, make it an objective");
    for (size_t i = 0; i < asked->require.count; ++i)
        MCV_TRY(read_requirement(asked->require.items[i], o->requirements + i, error));
    o->search.requirements = asked->require.count;
    return mcv_requirements_margins(o, NULL, &tried, error);
}
